use glam::DVec3;
use sphvar_sh::Domain;
use sphvar_sh::{ByParity, MAX_DEGREE};

use super::inner_product::centred_inner_product;
use crate::{Coefficients, Error, Integrand, Shape, quadrature};

type Term<'a> = (f64, &'a dyn Integrand);

/// [`Integrand::centred_square`] of a weighted sum.
///
/// Terms without edges contribute through the coefficients of their sum. Terms with edges that are
/// functions of the angle from one axis form one function, with one quadrature; only groups of
/// different axes need pairwise inner products. The time for n terms is therefore proportional to n
/// unless they have edges about n axes.
pub(super) fn centred_square<'a>(
    terms: impl IntoIterator<Item = Term<'a>>,
    domain: Domain,
) -> Result<ByParity, Error> {
    let mut limited = Vec::new();
    let mut groups: Vec<Group<'a>> = Vec::new();
    for (weight, function) in terms {
        match function.shape() {
            _ if weight == 0.0 => {}
            Ok(shape) if shape.is_band_limited(domain) => {
                limited.push((shape.degree(), (weight, function)));
            }
            shape => {
                let shape = shape.ok();
                let near = groups.iter_mut().find(|group| group.takes(shape.as_ref()));
                match near {
                    Some(group) => group.join((weight, function), shape.as_ref()),
                    None => groups.push(Group { terms: vec![(weight, function)], shape }),
                }
            }
        }
    }
    let mut sum = limited_square(limited, &groups, domain)?;
    for (i, group) in groups.iter().enumerate() {
        add(&mut sum, 1.0, group.centred_square(domain)?);
        for other in &groups[..i] {
            add(&mut sum, 2.0, centred_inner_product(group, other, domain)?);
        }
    }
    // Cancellation leaves rounding errors of either sign.
    Ok(sum.map(|x| x.max(0.0)))
}

/// Terms with edges about one axis, or a single term.
struct Group<'a> {
    terms: Vec<Term<'a>>,
    /// `None` if it is unknown.
    shape: Option<Shape>,
}

impl<'a> Group<'a> {
    fn takes(&self, shape: Option<&Shape>) -> bool {
        let (Some(own), Some(other)) = (&self.shape, shape) else {
            return false;
        };
        own.axis().is_some() && own.sum(other).axis().is_some()
    }

    fn join(&mut self, term: Term<'a>, shape: Option<&Shape>) {
        self.terms.push(term);
        self.shape = self.shape.as_ref().zip(shape).map(|(own, other)| own.sum(other));
    }
}

impl Integrand for Group<'_> {
    fn eval(&self, dir: DVec3) -> f64 {
        self.terms.iter().map(|(w, f)| w * f.eval(dir)).sum()
    }

    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        weighted_sum_into(self.terms.iter().copied(), dirs, values)
    }

    fn shape(&self) -> Result<Shape, Error> {
        match (&self.shape, self.terms.as_slice()) {
            (Some(shape), _) => Ok(shape.clone()),
            // This call returns the reason.
            (None, [(_, single)]) => single.shape(),
            (None, _) => Err(Error::NoEnergy { reason: "the shape of a term is not known" }),
        }
    }

    fn exact(&self, domain: Domain) -> Option<f64> {
        self.terms.iter().map(|(w, f)| Some(w * f.exact(domain)?)).sum()
    }

    fn coefficients(&self, domain: Domain, lmax: usize) -> Result<Coefficients, Error> {
        sum_of_coefficients(self.terms.iter().copied(), domain, lmax)
    }

    fn centred_square(&self, domain: Domain) -> Result<ByParity, Error> {
        match self.terms.as_slice() {
            [(weight, single)] => {
                Ok(single.centred_square(domain)?.map(|square| weight * weight * square))
            }
            _ => quadrature::centred_square(&self.shape()?, domain, &|dirs, values| {
                self.eval_into(dirs, values)
            }),
        }
    }
}

/// Writes the values of a weighted sum.
pub(super) fn weighted_sum_into<'a>(
    terms: impl IntoIterator<Item = Term<'a>>,
    dirs: &[DVec3],
    values: &mut [f64],
) -> Result<(), Error> {
    // The initial value of a floating-point sum.
    values.fill(-0.0);
    let mut of_term = vec![0.0; values.len()];
    for (weight, term) in terms {
        term.eval_into(dirs, &mut of_term)?;
        values.iter_mut().zip(&of_term).for_each(|(sum, value)| *sum += weight * value);
    }
    Ok(())
}

/// Returns the coefficients of a weighted sum.
pub(super) fn sum_of_coefficients<'a>(
    terms: impl IntoIterator<Item = Term<'a>>,
    domain: Domain,
    lmax: usize,
) -> Result<Coefficients, Error> {
    let mut sum = Coefficients::zonal(DVec3::Z, vec![0.0; lmax + 1])?;
    for (weight, function) in terms {
        sum = sum.plus(weight, &function.coefficients(domain, lmax)?)?;
    }
    Ok(sum)
}

/// Returns the centred square of the sum of functions without edges, each with its degree, plus
/// twice their inner products with functions that have edges.
///
/// Functions of higher degree come first. The sum of all functions that reach a degree has the
/// energy of that degree, so a general function of low degree does not force one of high degree to
/// use all orders.
fn limited_square<'a>(
    mut limited: Vec<(usize, Term<'a>)>,
    groups: &[Group<'_>],
    domain: Domain,
) -> Result<ByParity, Error> {
    if let ([(_, (weight, single))], []) = (limited.as_slice(), groups) {
        return Ok(single.centred_square(domain)?.map(|square| weight * weight * square));
    }
    // Rounded to eight degrees per octave, so that there are few different ones.
    for (degree, _) in &mut limited {
        let step = (degree.next_power_of_two() / 16).max(1);
        *degree = degree.next_multiple_of(step).min(MAX_DEGREE);
    }
    limited.sort_by_key(|&(degree, _)| std::cmp::Reverse(degree));
    let mut square = ByParity::both(0.0);
    let Some(&(highest, _)) = limited.first() else {
        return Ok(square);
    };
    let edged = groups.iter().map(|group| (1.0, group as &dyn Integrand));
    let mut edged = match groups {
        [] => None,
        _ => Some(sum_of_coefficients(edged, domain, highest)?),
    };
    let mut sum = Coefficients::zonal(DVec3::Z, vec![0.0; highest + 1])?;
    let tiers: Vec<_> = limited.chunk_by(|a, b| a.0 == b.0).collect();
    for (i, tier) in tiers.iter().enumerate() {
        let degree = tier[0].0;
        for (_, (weight, function)) in *tier {
            sum = sum.plus(*weight, &function.coefficients(domain, degree)?)?;
        }
        let lower = tiers.get(i + 1).map_or(0, |next| next[0].0);
        let mut energies = sum.energy_per_degree()?;
        if let Some(edged) = &mut edged {
            edged.truncate(degree)?;
            for (e, cross) in energies.iter_mut().zip(sum.inner_per_degree(edged)?) {
                *e += 2.0 * cross;
            }
        }
        for (l, e) in energies.iter().enumerate().skip(lower + 1) {
            *square.of_mut(l) += e;
        }
    }
    Ok(square)
}

fn add(sum: &mut ByParity, weight: f64, terms: ByParity) {
    sum.even += weight * terms.even;
    sum.odd += weight * terms.odd;
}
