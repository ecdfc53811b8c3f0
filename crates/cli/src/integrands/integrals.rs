//! The integrals that a command estimates from the same directions.

use std::ops::Range;

use sphvar_integrands::{
    Expression, Factor, HarmonicParameters, HarmonicProjection, Integrand, Term, VectorIntegrand,
};
use sphvar_variance::{JointTrials, Predictor};

use super::{NamedIntegrand, parse_expression};
use crate::error::CliError;

/// Integrals that are estimated from the same directions: one, those of the channels of a picture,
/// or with `--project` the coefficients of harmonics and the irradiance that follows from them.
pub(crate) struct Integrals<'a> {
    all: Vec<Integral<'a>>,
    vector: Box<dyn VectorIntegrand + 'a>,
}

/// One of the integrals.
pub(crate) struct Integral<'a> {
    pub(crate) integrand: &'a NamedIntegrand<'a>,
    /// The name in tables that have several.
    pub(crate) label: String,
    /// Degree and order of a coefficient of a projection.
    pub(crate) order: Option<(usize, i64)>,
    source: Source,
    /// Whether the computation of its energies is announced; it serves all coefficients.
    is_announced: bool,
}

/// How rows name an integral.
#[derive(Clone)]
pub(crate) struct IntegralName {
    /// The integrand as it was written.
    pub(crate) name: String,
    /// The name in tables, if there are several integrals.
    pub(crate) label: Option<String>,
    /// Whether rates, charts and ranks are those of this integral.
    pub(crate) is_main: bool,
}

/// The components of the vector integrand that an integral consists of.
enum Source {
    Component(usize),
    Vector { components: Range<usize>, weights: Vec<f64> },
}

/// Calls `run` with the integrals of functions, or of their projections onto harmonics to a degree.
pub(crate) fn with_integrals<T>(
    functions: &[NamedIntegrand<'_>],
    degree: Option<usize>,
    run: impl FnOnce(&Integrals<'_>) -> Result<T, CliError>,
) -> Result<T, CliError> {
    let Some(degree) = degree else {
        return run(&Integrals::of_functions(functions));
    };
    let projections = functions
        .iter()
        .map(|f| HarmonicProjection::new(&*f.function, degree).map_err(CliError::usage))
        .collect::<Result<Vec<_>, _>>()?;
    let mut products = Vec::new();
    for (function, projection) in functions.iter().zip(&projections) {
        for (l, m) in projection.orders() {
            let product = projection.coefficient(l, m).map_err(CliError::usage)?;
            let name = times_harmonic(&function.name, l, m)?;
            products.push(NamedIntegrand { name, function: Box::new(product), unfiltered: None });
        }
        let name = format!("irradiance of {}", function.name);
        let irradiance = Box::new(projection.irradiance());
        products.push(NamedIntegrand { name, function: irradiance, unfiltered: None });
    }
    run(&Integrals::of_projections(functions, &projections, &products))
}

impl<'a> Integrals<'a> {
    fn of_functions(functions: &'a [NamedIntegrand<'a>]) -> Self {
        let all = functions.iter().enumerate().map(|(i, integrand)| Integral {
            integrand,
            label: channel(&integrand.name),
            order: None,
            source: Source::Component(i),
            is_announced: true,
        });
        let vector: Vec<&dyn Integrand> = functions.iter().map(|f| &*f.function).collect();
        Self { all: all.collect(), vector: Box::new(vector) }
    }

    /// `products` has the coefficients of each projection, followed by its irradiance.
    fn of_projections(
        functions: &'a [NamedIntegrand<'_>],
        projections: &'a [HarmonicProjection<'a>],
        products: &'a [NamedIntegrand<'a>],
    ) -> Self {
        let (mut all, mut first) = (Vec::new(), 0);
        let mut products = products.iter();
        for (function, projection) in functions.iter().zip(projections) {
            let of_channel = match functions.len() {
                1 => String::new(),
                _ => format!(" {}", channel(&function.name)),
            };
            let components = first..first + projection.components();
            for (component, (l, m)) in components.clone().zip(projection.orders()) {
                all.extend(products.next().map(|integrand| Integral {
                    integrand,
                    label: format!("Y {l} {m}{of_channel}"),
                    order: Some((l, m)),
                    source: Source::Component(component),
                    is_announced: component == first,
                }));
            }
            first = components.end;
            let weights = projection.irradiance().weights().to_vec();
            all.extend(products.next().map(|integrand| Integral {
                integrand,
                label: format!("irradiance{of_channel}"),
                order: None,
                source: Source::Vector { components, weights },
                is_announced: false,
            }));
        }
        let vector: Vec<&dyn VectorIntegrand> =
            projections.iter().map(|p| p as &dyn VectorIntegrand).collect();
        Self { all, vector: Box::new(vector) }
    }

    /// Returns all integrals; rates, charts and ranks are those of the last one.
    pub(crate) fn all(&self) -> &[Integral<'a>] {
        &self.all
    }

    /// Returns the names of all integrals in rows.
    pub(crate) fn in_rows(&self) -> impl Iterator<Item = IntegralName> {
        let count = self.all.len();
        self.all.iter().enumerate().map(move |(i, integral)| IntegralName {
            name: integral.integrand.name.clone(),
            label: (count > 1).then(|| integral.label.clone()),
            is_main: i + 1 == count,
        })
    }

    /// Returns the integrals by which patterns are ranked, the main one first, each with the
    /// coefficients that it follows from.
    pub(crate) fn ranked(&self) -> impl Iterator<Item = (&Integral<'a>, &[Integral<'a>])> {
        let ranked = self.all.iter().enumerate().rev().filter(|(_, i)| i.order.is_none());
        ranked.map(|(at, integral)| {
            let coefficients = match &integral.source {
                Source::Component(_) => at..at,
                Source::Vector { weights, .. } => at - weights.len()..at,
            };
            (integral, &self.all[coefficients])
        })
    }

    /// Returns the integral of charts and rates: the only one, luminance or irradiance.
    pub(crate) fn main(&self) -> &NamedIntegrand<'a> {
        // Every expression has an integrand.
        self.all[self.all.len() - 1].integrand
    }

    /// Returns the only integral; an error names the option that does not take several.
    pub(crate) fn only(&self, option: &str) -> Result<&NamedIntegrand<'a>, CliError> {
        match &*self.all {
            [only] => Ok(only.integrand),
            _ => Err(CliError::Usage(format!(
                "{option} takes one integral, not channel=rgb or --project; name a channel, or the coefficient as \
                 \"f * ylm:l=2,m=1\""
            ))),
        }
    }

    /// Returns the joint trials of all integrals; `predictor` is called for each in their order.
    pub(crate) fn trials<'t>(
        &'t self,
        mut predictor: impl FnMut(&'t Integral<'a>) -> Result<Predictor<'t>, sphvar_variance::Error>,
    ) -> Result<JointTrials<'t>, CliError> {
        let mut joint = JointTrials::new(&*self.vector);
        for integral in &self.all {
            let of_integral = predictor(integral)?;
            joint = match &integral.source {
                Source::Component(component) => joint.with_component(*component, of_integral),
                Source::Vector { components, weights } => {
                    joint.with_vector(components.clone(), weights, of_integral)
                }
            };
        }
        Ok(joint)
    }
}

impl Integral<'_> {
    /// Returns whether the computation of energies is announced.
    pub(crate) fn is_announced(&self) -> bool {
        self.is_announced
    }

    /// Returns whether it is the irradiance of all coefficients.
    pub(crate) fn is_irradiance(&self) -> bool {
        matches!(self.source, Source::Vector { .. })
    }
}

/// Returns the channel in the name of an integrand, for tables.
fn channel(name: &str) -> String {
    let of_term = |term: &Term| match term {
        Term::Environment(parameters) => parameters.picture.channel.clone(),
        _ => None,
    };
    let channel = parse_expression(name).ok().and_then(|e| e.terms().find_map(of_term));
    channel.unwrap_or_else(|| "luminance".to_owned())
}

/// Returns the expression of the product of an integrand and a harmonic.
fn times_harmonic(name: &str, l: usize, m: i64) -> Result<String, CliError> {
    let mut expression: Expression = parse_expression(name)?;
    for summand in &mut expression.summands {
        let term = Term::Harmonic(HarmonicParameters { l, m });
        summand.factors.push(Factor { term, rotations: Vec::new() });
    }
    Ok(expression.to_string())
}
