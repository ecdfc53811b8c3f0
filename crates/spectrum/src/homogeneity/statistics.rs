use sphvar_samplers::Domain;

use super::AuditFamily;

/// Maximum degree of the coefficients whose products are tested.
pub(super) const PAIR_DEGREE: usize = 4;

/// Power below this fraction of that of degree 0 is rounding error: the transform has a relative
/// accuracy of 1e-12, and power is quadratic in coefficients.
const ROUNDING: f64 = 1e-22;

/// Layout of the sums over the realizations of an ensemble: the components and their names.
///
/// The components are those of [`Rotator`](super::rotator::Rotator).
#[derive(Debug)]
pub(super) struct Layout {
    /// The tested degrees.
    pub(super) degrees: Vec<usize>,
    /// Degrees of the domain without power in any realization.
    pub(super) vanishing: Vec<usize>,
    /// The mean power per degree, starting at 0.
    pub(super) power: Vec<f64>,
    paired: Vec<usize>,
}

/// The sums over one ensemble, in the order of [`Layout`]: components, phases and doubled phases,
/// powers of orders minus those of their degree, products.
#[derive(Clone, Debug)]
pub(super) struct Sums {
    pub(super) means: Vec<f64>,
    pub(super) phases: Vec<f64>,
    pub(super) orders: Vec<f64>,
    pub(super) pairs: Vec<f64>,
}

impl Layout {
    /// Returns the layout for these realizations and degrees up to `lmax`.
    pub(super) fn new(domain: Domain, lmax: usize, rows: &[Vec<f64>]) -> Self {
        let mean =
            |l: usize| rows.iter().map(|row| degree_power(row, l)).sum::<f64>() / rows.len() as f64;
        let power: Vec<f64> = (0..=lmax).map(mean).collect();
        let has_power = |&l: &usize| power[l] > ROUNDING * power[0];
        let (degrees, vanishing): (Vec<usize>, Vec<usize>) =
            (1..=lmax).filter(|&l| domain.has_degree(l)).partition(has_power);
        let low = degrees.iter().filter(|&&l| l <= PAIR_DEGREE);
        let paired = low.flat_map(|&l| l * l..(l + 1) * (l + 1)).collect();
        Self { degrees, vanishing, power, paired }
    }

    /// Returns the (l, m) with a tested l and `m >= first`.
    pub(super) fn orders(&self, first: usize) -> impl Iterator<Item = (usize, usize)> {
        self.degrees.iter().flat_map(move |&l| (first..=l).map(move |m| (l, m)))
    }

    fn components(&self) -> impl Iterator<Item = usize> {
        self.degrees.iter().flat_map(|&l| l * l..(l + 1) * (l + 1))
    }

    /// Returns the number of comparisons of a family.
    pub(super) fn comparisons(&self, family: AuditFamily) -> usize {
        let paired = self.paired.len();
        match family {
            AuditFamily::Means => self.components().count(),
            AuditFamily::Phases => 2 * self.orders(1).count(),
            AuditFamily::Orders => self.orders(0).count(),
            AuditFamily::Covariances => {
                paired * paired.saturating_sub(1) / 2 + self.squares().count()
            }
            AuditFamily::Rotations => 9,
        }
    }

    /// Returns the (l, m), m >= 1, of which `Re S_lm^2` is tested.
    fn squares(&self) -> impl Iterator<Item = (usize, usize)> {
        self.orders(1).filter(|lm| lm.0 <= PAIR_DEGREE)
    }

    /// Returns sums of zero.
    pub(super) fn zero(&self) -> Sums {
        let zeros = |family| vec![0.0; self.comparisons(family)];
        Sums {
            means: zeros(AuditFamily::Means),
            phases: vec![0.0; 2 * self.comparisons(AuditFamily::Phases)],
            orders: zeros(AuditFamily::Orders),
            pairs: zeros(AuditFamily::Covariances),
        }
    }

    /// Adds one realization.
    pub(super) fn add(&self, row: &[f64], sums: &mut Sums) {
        for (sum, c) in sums.means.iter_mut().zip(self.components()) {
            *sum += row[c];
        }
        for (sum, (l, m)) in sums.phases.chunks_exact_mut(4).zip(self.orders(1)) {
            let (x, y) = (row[l * l + m], row[l * l + l + m]);
            let square = x * x + y * y;
            // Coefficients that vanish by symmetry, such as S_41 of a lattice with a fourfold axis,
            // have no phase.
            if square > ROUNDING * row[0] * row[0] {
                let size = square.sqrt();
                let (c, s) = (x / size, y / size);
                for (sum, part) in sum.iter_mut().zip([c, s, c * c - s * s, 2.0 * c * s]) {
                    *sum += part;
                }
            }
        }
        let mut orders = sums.orders.iter_mut();
        for &l in &self.degrees {
            let degree = degree_power(row, l);
            for (m, sum) in (0..=l).zip(&mut orders) {
                *sum += order_power(row, l, m) - degree;
            }
        }
        let mut pairs = sums.pairs.iter_mut();
        for (i, &a) in self.paired.iter().enumerate() {
            let a = row[a];
            for (&b, sum) in self.paired[i + 1..].iter().zip(&mut pairs) {
                *sum += a * row[b];
            }
        }
        for ((l, m), sum) in self.squares().zip(pairs) {
            let (x, y) = (row[l * l + m], row[l * l + l + m]);
            *sum += 0.5 * (x * x - y * y);
        }
    }

    /// Returns the name of comparison `i` of a family and its value for sums over `count`
    /// realizations.
    pub(super) fn describe(
        &self,
        family: AuditFamily,
        i: usize,
        sums: &Sums,
        count: f64,
    ) -> (String, f64) {
        match family {
            AuditFamily::Means => {
                let c = self.components().nth(i).unwrap_or_default();
                (name(c), sums.means[i] / count / self.power[c.isqrt()].sqrt())
            }
            AuditFamily::Phases => {
                let (l, m) = self.orders(1).nth(i / 2).unwrap_or_default();
                let doubled = if i % 2 == 1 { "2 " } else { "" };
                let (c, s) = (sums.phases[2 * i], sums.phases[2 * i + 1]);
                (format!("{doubled}arg S({l},{m})"), c.hypot(s) / count)
            }
            AuditFamily::Orders => {
                let (l, m) = self.orders(0).nth(i).unwrap_or_default();
                (format!("({l},{m})"), 1.0 + sums.orders[i] / count / self.power[l])
            }
            AuditFamily::Covariances => {
                let (a, b) = self.pair(i);
                let scale = (self.power[a.isqrt()] * self.power[b.isqrt()]).sqrt();
                let name = if a == b {
                    format!("Re {}^2", name(a).trim_start_matches("Re "))
                } else {
                    format!("{} {}", name(a), name(b))
                };
                (name, sums.pairs[i] / count / scale)
            }
            AuditFamily::Rotations => (String::new(), 0.0),
        }
    }

    /// Returns the components of product `i`; for the real part of a square, the same one twice.
    fn pair(&self, i: usize) -> (usize, usize) {
        let mut first = 0;
        for (at, &a) in self.paired.iter().enumerate() {
            let rest = self.paired.len() - at - 1;
            if i < first + rest {
                return (a, self.paired[at + 1 + i - first]);
            }
            first += rest;
        }
        let (l, m) = self.squares().nth(i - first).unwrap_or_default();
        (l * l + m, l * l + m)
    }
}

/// Returns the power of a degree in one realization.
pub(super) fn degree_power(row: &[f64], l: usize) -> f64 {
    row[l * l..(l + 1) * (l + 1)].iter().map(|x| x * x).sum::<f64>() / (2 * l + 1) as f64
}

/// Returns the power of one order, `m >= 0`.
pub(super) fn order_power(row: &[f64], l: usize, m: usize) -> f64 {
    let x = row[l * l + m];
    if m == 0 { x * x } else { 0.5 * (x * x + row[l * l + l + m].powi(2)) }
}

/// Returns the human-readable name of a component.
fn name(component: usize) -> String {
    let l = component.isqrt();
    match component - l * l {
        0 => format!("S({l},0)"),
        m if m <= l => format!("Re S({l},{m})"),
        m => format!("Im S({l},{})", m - l),
    }
}
