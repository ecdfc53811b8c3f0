//! The integrands of the command line.

pub(crate) mod environment;
mod expansion;
mod healpix_map;
mod integrals;
mod rgb;
mod square;
mod values;
mod warps;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use sphvar_grammar::{ResolveError, Spec};
use sphvar_integrands::{
    AlmParameters, EnergiesParameters, EnergyEstimates, EnvironmentMap, EnvironmentParameters,
    Error, Expansion, Expression, FittedFunction, FunctionParameters, HealpixMap,
    HealpixMapParameters, ImageParameters, Integrand, IntegrandResolver, Interpolation, NoFiles,
    SharedFunction, SquareExpression, SquareImage, Term, ValuesParameters,
};
use sphvar_samplers::Domain;
use sphvar_warps::DensityMap;

use self::environment::{Environment, PictureSource};
pub(crate) use self::integrals::{Integral, IntegralName, Integrals, with_integrals};
pub(crate) use self::rgb::parse_integrands;
pub(crate) use self::square::{NamedSquareIntegrand, SquareForms, parse_square_integrand};
pub(crate) use self::warps::strategies_of;
use crate::error::CliError;
use crate::memory::check_degree;
use crate::report::number::value;
use crate::session::Session;

/// The names and their parameters, for help texts.
pub(crate) const FORMS: Forms = Forms;

/// The `Display` text of [`FORMS`].
pub(crate) struct Forms;

impl fmt::Display for Forms {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let forms: Vec<String> = Term::all().iter().map(Term::form).collect();
        write!(
            f,
            "{}; quote names of files with commas or operators, file=\"a,b.exr\"; combine by \" + \", \" - \", \
             \" * \" and numbers, with blanks around, and rotate by \" @ THETA/PHI\" or \" @ THETA/PHI/PSI\" in \
             degrees, which moves +z there after a rotation by PSI about z: \
             \"cap:degrees=30 @ 40/10 + 0.5 * vmf:kappa=10\"; sphvar list integrands explains the parameters",
            forms.join(" | ")
        )
    }
}

/// The integrand of the examples; if the file does not exist, the embedded copy is used.
pub(crate) const CITY: &str = "env:data/city.exr";

/// An integrand with its name in tables.
pub(crate) struct NamedIntegrand<'a> {
    /// The name as the user wrote it.
    pub(crate) name: String,
    /// The function.
    pub(crate) function: Box<dyn Integrand + 'a>,
    /// The function without its filters, if it has any.
    unfiltered: Option<Box<dyn Integrand>>,
}

/// The time above which the computation of energies is announced, in seconds.
const MIN_ANNOUNCED_SECONDS: f64 = 2.0;

impl NamedIntegrand<'_> {
    /// Prints the expected time of energies to a degree, if it is long.
    pub(crate) fn announce_energies(&self, domain: Domain, lmax: usize, session: &Session) {
        let seconds = self.function.energy_seconds(domain, lmax);
        if seconds > MIN_ANNOUNCED_SECONDS {
            session
                .say(&format!("energies of {} to degree {lmax}: about {seconds:.0} s", self.name));
        }
    }

    /// Prints by how much filters change the integral over the domain.
    pub(crate) fn announce_bias(&self, domain: Domain, session: &Session) {
        /// Smaller changes, relative to the integral, are rounding.
        const ROUNDING: f64 = 1e-10;
        let before = self.unfiltered.as_ref().and_then(|function| function.exact(domain));
        let Some((before, after)) = before.zip(self.function.exact(domain)) else { return };
        let change = after - before;
        let text = if change.abs() <= ROUNDING * before.abs().max(after.abs()) {
            format!("filters do not change the integral, {}", value(before))
        } else {
            format!("filters change the integral from {} by {}", value(before), value(change))
        };
        session.say(&text);
    }
}

/// Returns the integrand of one expression. Reads the files that it names and reports remarks on
/// them.
pub(crate) fn parse_integrand(
    text: &str,
    session: &Session,
) -> Result<NamedIntegrand<'static>, CliError> {
    let expression = parse_expression(text)?;
    rgb::reject(&expression)?;
    let files = IntegrandFiles::new(session);
    let integrand = files.build(&expression, text.to_owned())?;
    files.report();
    Ok(integrand)
}

fn parse_expression(text: &str) -> Result<Expression, CliError> {
    let expression = if names_a_file(text) {
        text.parse::<Term>().map(Expression::from)
    } else {
        text.parse::<Expression>()
    };
    let expression = expression.map_err(|error| match text.parse::<SquareExpression>() {
        Ok(_) => {
            CliError::Usage(format!("{text} is an integrand on the unit square: use --square"))
        }
        Err(_) => CliError::usage(error),
    })?;
    for term in expression.terms() {
        match term {
            Term::Harmonic(harmonic) => check_degree(&term.to_string(), harmonic.l)?,
            Term::Band(band) => check_degree(&term.to_string(), band.lmax)?,
            _ => {}
        }
    }
    Ok(expression)
}

/// Returns whether the text is a single term with a file whose name looks like an expression.
///
/// Operators in the other parameters are part of an expression, as in `env:a.exr,up=y * cosine`.
fn names_a_file(text: &str) -> bool {
    let Ok(mut spec) = Spec::parse(text) else { return false };
    if !matches!(spec.name.as_str(), "env" | "map" | "energy" | "alm" | "values") {
        return false;
    }
    let file = spec.take_path("").or_else(|| spec.take_path("file"));
    file.is_some_and(|file| file.is_file()) && !spec.has_operator_left()
}

/// Reads the files of integrands, or arrays that are given in their place, and collects remarks for
/// the user.
struct IntegrandFiles<'a> {
    session: &'a Session,
    remarks: RefCell<Vec<String>>,
    /// The contents of pictures, which are read once for all channels.
    pictures: RefCell<BTreeMap<PathBuf, PictureSource>>,
    /// The densities of pictures, whose clones share texels.
    densities: RefCell<Vec<(EnvironmentParameters, Interpolation, DensityMap)>>,
}

impl<'a> IntegrandFiles<'a> {
    fn new(session: &'a Session) -> Self {
        let (remarks, pictures, densities) = Default::default();
        Self { session, remarks, pictures, densities }
    }

    /// Reports the remarks.
    fn report(&self) {
        self.remarks.take().iter().for_each(|text| self.session.remark(text));
    }

    fn build(
        &self,
        expression: &Expression,
        name: String,
    ) -> Result<NamedIntegrand<'static>, CliError> {
        let of_expression = |error| match error {
            Error::File(source) => CliError::of_resolver(&source),
            other => CliError::usage(other),
        };
        let function = expression.build(self).map_err(of_expression)?;
        let n_remarks = self.remarks.borrow().len();
        let unfiltered = expression.build_unfiltered(self).map_err(of_expression)?;
        // The same files give the same remarks again.
        self.remarks.borrow_mut().truncate(n_remarks);
        Ok(NamedIntegrand { name, function, unfiltered })
    }

    fn picture(&self, file: &Path) -> Result<PictureSource, CliError> {
        if let Some(known) = self.pictures.borrow().get(file) {
            return Ok(known.clone());
        }
        let source = PictureSource::open(file, self.session)?;
        self.pictures.borrow_mut().insert(file.to_owned(), source.clone());
        Ok(source)
    }
}

impl IntegrandResolver for IntegrandFiles<'_> {
    fn environment(&self, wanted: &EnvironmentParameters) -> Result<EnvironmentMap, ResolveError> {
        let decode = |source| Environment::decode(&wanted.file, &source, &wanted.picture);
        let read = self.picture(&wanted.file).and_then(decode).map_err(ResolveError::new)?;
        read.remarks.into_iter().for_each(|remark| self.remark(remark));
        Ok(read.map)
    }

    fn environment_density(
        &self,
        wanted: &EnvironmentParameters,
        interpolation: Interpolation,
    ) -> Result<DensityMap, Error> {
        let known = |(of, between, _): &&(EnvironmentParameters, Interpolation, DensityMap)| {
            of == wanted && *between == interpolation
        };
        if let Some((.., density)) = self.densities.borrow().iter().find(known) {
            return Ok(density.clone());
        }
        let map = self.environment(wanted)?;
        // The remark on the file includes densities.
        let density = wanted.density(map, interpolation, drop)?;
        self.densities.borrow_mut().push((wanted.clone(), interpolation, density.clone()));
        Ok(density)
    }

    fn healpix_map(&self, wanted: &HealpixMapParameters) -> Result<HealpixMap, ResolveError> {
        healpix_map::read(wanted, self.session, &mut self.remarks.borrow_mut())
            .map_err(ResolveError::new)
    }

    fn energies(&self, wanted: &EnergiesParameters) -> Result<EnergyEstimates, ResolveError> {
        expansion::read_energies(wanted, self.session, &mut self.remarks.borrow_mut())
            .map_err(ResolveError::new)
    }

    fn expansion(&self, wanted: &AlmParameters) -> Result<Expansion, ResolveError> {
        expansion::read_coefficients(wanted, self.session, &mut self.remarks.borrow_mut())
            .map_err(ResolveError::new)
    }

    fn fitted_values(&self, wanted: &ValuesParameters) -> Result<FittedFunction, ResolveError> {
        values::fit(wanted, self.session, &mut self.remarks.borrow_mut()).map_err(ResolveError::new)
    }

    fn function(&self, wanted: &FunctionParameters) -> Result<Box<dyn Integrand>, ResolveError> {
        match self.session.given.function(Path::new(&wanted.name)) {
            Some(function) => Ok(Box::new(SharedFunction::from(function))),
            None => NoFiles.function(wanted),
        }
    }

    fn square_image(&self, wanted: &ImageParameters) -> Result<SquareImage, ResolveError> {
        square::read_image(self, wanted).map_err(ResolveError::new)
    }

    fn memory_check(&self) -> fn(usize) -> Result<(), String> {
        expansion::check_values
    }

    /// A map that is read twice, for two interpolations, has the same remarks.
    fn remark(&self, text: String) {
        let mut remarks = self.remarks.borrow_mut();
        if !remarks.contains(&text) {
            remarks.push(text);
        }
    }
}

/// Rejects an integrand whose energy is unknown on the domain.
pub(crate) fn check_domain(integrand: &NamedIntegrand<'_>, domain: Domain) -> Result<(), CliError> {
    let wrong = |what: String| CliError::Usage(format!("{}: {what}", integrand.name));
    let energy = integrand.function.energy(domain, 0).map_err(|e| wrong(e.to_string()))?;
    energy.check_magnitude().map_err(|e| wrong(e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::{CliError, Domain, Integrand, Session, parse_integrand};

    fn parsed(text: &str) -> Result<Box<dyn Integrand>, CliError> {
        parse_integrand(text, &Session::default().muted()).map(|integrand| integrand.function)
    }

    #[test]
    fn long_expressions_take_neither_stack_nor_much_time() {
        let chain = format!("cap:degrees=30{}", " @ 40/10/5".repeat(12_000));
        let rotated = parsed(&chain).unwrap();
        let exact = parsed("cap:degrees=30").unwrap().exact(Domain::Sphere).unwrap();
        assert!((rotated.exact(Domain::Sphere).unwrap() / exact - 1.0).abs() < 1e-15);
        let square = |f: &dyn Integrand| f.square(Domain::Sphere).unwrap();
        for term in ["cosine", "vmf:kappa=5 @ 30/20", "ylm:l=4,m=2", "cap:degrees=60"] {
            let sum = parsed(&vec![term; 1000].join(" + ")).unwrap();
            let ratio = square(&*sum) / square(&*parsed(term).unwrap());
            assert!((ratio / 1e6 - 1.0).abs() < 1e-11, "{term}: {ratio}");
        }
        let product = vec!["cosine"; 100_000].join(" * ");
        assert!(parsed(&product).is_err_and(|e| e.to_string().contains("at most 64")));
        assert!(parsed("1e-200 * cosine").is_err_and(|e| e.to_string().contains("1e-150")));
    }
}
