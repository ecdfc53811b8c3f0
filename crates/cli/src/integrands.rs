//! Integrands as they are named on the command line.

pub(crate) mod environment;
mod expression;
mod healpix_map;
mod term;

use sphvar_integrands::Integrand;
use sphvar_samplers::Domain;

use crate::error::CliError;
use crate::report::say;

/// The names and their parameters, for help texts.
pub(crate) const FORMS: &str = "ylm:l=4,m=0 | cap:degrees=60 | double-cap:degrees=60 | \
     half-space[:height=0] | vmf:kappa=10 | phong:n=20 | cosine | abs-cosine | \
     env:FILE[,channel=luminance|r|g|b|NAME][,layer=NAME][,projection=latlong|octahedral]\
     [,up=z|y|x|-z|-y|-x][,mirror=no|yes][,turn=DEGREES] (EXR or HDR) | \
     map:FILE[,field=0|NAME][,hdu=1|NAME][,missing=0|mean] (HEALPix map in FITS); names of files with commas or \
     operators in quotes, file=\"a,b.exr\"; \
     combined with blanks around by \" + \", \" - \", \" * \" and numbers, and turned by \" @ THETA/PHI\" or \
     \" @ THETA/PHI/PSI\" in degrees, which carries +z there after a turn by PSI: \
     \"cap:degrees=30 @ 40/10 + 0.5 * vmf:kappa=10\"";

/// The integrand of the examples: where there is no such file, the copy that is built in.
pub(crate) const CITY: &str = "env:data/city.exr";

/// An integrand with the name by which tables know it.
pub(crate) struct NamedIntegrand {
    /// As it was written.
    pub(crate) name: String,
    /// The function.
    pub(crate) function: Box<dyn Integrand>,
}

/// Energies that take less are computed without a word, in seconds.
const WORTH_SAYING: f64 = 2.0;

impl NamedIntegrand {
    /// Says how long energies to a degree will take, if that is long.
    pub(crate) fn announce_energies(&self, domain: Domain, lmax: usize, quiet: bool) {
        let seconds = self.function.energy_seconds(domain, lmax);
        if seconds > WORTH_SAYING {
            say(
                quiet,
                &format!("energies of {} to degree {lmax}: about {seconds:.0} s", self.name),
            );
        }
    }
}

/// The integrand of one expression; reads the files that it names and says what is remarkable of them, unless
/// `quiet`.
pub(crate) fn parse_integrand(text: &str, quiet: bool) -> Result<NamedIntegrand, CliError> {
    let mut remarks = Vec::new();
    let function = expression::parse(text, &mut remarks)?;
    remarks.iter().for_each(|remark| say(quiet, remark));
    Ok(NamedIntegrand { name: text.to_owned(), function })
}

/// Refuses an integrand whose energy is not known on the domain.
pub(crate) fn check_domain(integrand: &NamedIntegrand, domain: Domain) -> Result<(), CliError> {
    let wrong = |what: String| CliError::Usage(format!("{}: {what}", integrand.name));
    let energy = integrand.function.energy(domain, 0).map_err(|e| wrong(e.to_string()))?;
    energy.check_magnitude().map_err(|e| wrong(e.to_string()))
}
