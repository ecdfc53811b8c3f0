use std::f64::consts::{FRAC_1_SQRT_2, PI, SQRT_2};

use num_complex::Complex;
use pulp::{Arch, NullaryFnOnce};
use sphvar_sh::Colatitude;

use super::{Anchor, PARTS, RINGS};

/// Range of significant values. Smaller values are stored as `x up^k`, k <= 0, while they are below
/// `1/limit`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ValueRange {
    pub(super) limit: f64,
    /// The square of the limit and its reciprocal.
    pub(super) up: f64,
    pub(super) down: f64,
}

impl ValueRange {
    /// Returns the range of values from the power of two at or above `smallest`, which must be at
    /// least 1e-60.
    pub(crate) fn starting_at(smallest: f64) -> Self {
        let limit = f64::from_bits((1.0 / smallest).to_bits() & f64::INFINITY.to_bits());
        Self { limit, up: limit * limit, down: 1.0 / (limit * limit) }
    }
}

impl Default for ValueRange {
    fn default() -> Self {
        // Far below the rounding errors of significant values.
        Self::starting_at(1e-20)
    }
}

/// Rings at one order m at a time, stored as lanes of the northern hemisphere.
///
/// A southern ring is stored as its reflection at the equator, where `lambda_lm` only changes sign
/// with the parity of l + m. Two rings that are reflections of each other share a lane.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lanes {
    n_rings: usize,
    unsorted: Vec<Members>,
    groups: [Group; 2],
}

/// Lanes whose recurrence starts at one anchor, sorted from the equator to the pole.
///
/// Stored as a structure of arrays. All fields except `rings` are padded to a multiple of `RINGS`
/// with empty lanes.
#[derive(Clone, Debug, Default)]
pub(super) struct Group {
    pub(super) range: ValueRange,
    rings: Vec<Members>,
    sin_theta: Vec<f64>,
    /// The maximum order at which a lane is significant.
    last_order: Vec<f64>,
    /// The argument of the recurrence.
    pub(super) argument: Vec<f64>,
    /// `lambda_mm = sectoral up^scale`, where `|sectoral|` is zero or at least `1/limit`.
    sectoral: Vec<f64>,
    pub(super) scale: Vec<f64>,
    /// `mu_0` in the same scale.
    pub(super) start: Vec<f64>,
}

/// The caller's rings that share a lane, at least one.
#[derive(Clone, Copy, Debug)]
struct Members {
    north: Option<usize>,
    south: Option<usize>,
    colatitude: Colatitude,
}

impl Lanes {
    /// Loads the caller's rings, for degrees up to `lmax`.
    pub(crate) fn load(
        &mut self,
        colatitudes: impl Iterator<Item = Colatitude>,
        lmax: usize,
        range: ValueRange,
    ) {
        self.unsorted.clear();
        self.unsorted.extend(colatitudes.enumerate().map(|(ring, colatitude)| {
            let south = colatitude.is_south();
            Members { north: (!south).then_some(ring), south: south.then_some(ring), colatitude }
        }));
        self.n_rings = self.unsorted.len();
        share_lanes(&mut self.unsorted);
        // Rings of similar colatitude enter the range of f64 at about the same degree, so whole
        // blocks can skip smaller values; the active lanes of a high order are the first ones.
        // Rings with a NaN colatitude come first and stay active; they affect only their own
        // values.
        let sine = |ring: &Members| ring.colatitude.sin().abs();
        self.unsorted.sort_unstable_by(|a, b| sine(b).total_cmp(&sine(a)));
        for group in &mut self.groups {
            group.range = range;
        }
        let near_equator =
            self.unsorted.partition_point(|ring| sine(ring) > FRAC_1_SQRT_2 || sine(ring).is_nan());
        let (equator, pole) = self.unsorted.split_at(near_equator);
        self.groups[Anchor::Equator as usize].load(equator, Anchor::Equator, lmax);
        self.groups[Anchor::Pole as usize].load(pole, Anchor::Pole, lmax);
    }

    /// Returns the number of the caller's rings.
    pub(crate) fn n_rings(&self) -> usize {
        self.n_rings
    }

    /// Advances to order `m`, which must be 0 or follow m - 1.
    pub(crate) fn start_order(&mut self, arch: Arch, m: usize) {
        for group in &mut self.groups {
            group.start_order(arch, m);
        }
    }

    pub(super) fn group(&self, anchor: Anchor) -> &Group {
        &self.groups[anchor as usize]
    }

    /// Writes the factors of `mu_n` in sums over rings to `terms`, indexed by anchor: `n_columns`
    /// numbers per lane, of which a function has `PARTS`. The caller's ring r of function b has the
    /// value `values[b * n_rings + r]`.
    #[inline(always)]
    pub(super) fn gather(
        &self,
        values: &[Complex<f64>],
        n_columns: usize,
        terms: &mut [Vec<f64>; 2],
    ) {
        for (group, terms) in self.groups.iter().zip(terms) {
            terms.resize(group.argument.len() * n_columns, 0.0);
            terms[group.rings.len() * n_columns..].fill(0.0);
            for (ring, terms) in group.rings.iter().zip(terms.chunks_exact_mut(n_columns)) {
                let cos = ring.colatitude.cos().abs();
                let functions = values.chunks_exact(self.n_rings);
                for (values, part) in functions.zip(terms.as_chunks_mut::<PARTS>().0) {
                    let north = ring.north.map_or(Complex::ZERO, |r| values[r]);
                    let south = ring.south.map_or(Complex::ZERO, |r| values[r]);
                    let (even, odd) = (north + south, (north - south) * cos);
                    *part = [even.re, even.im, odd.re, odd.im];
                }
            }
        }
    }

    /// Computes ring values from sums over degrees: the transpose of [`Self::gather`].
    #[inline(always)]
    pub(super) fn scatter(
        &self,
        sums: &[Vec<f64>; 2],
        n_columns: usize,
        values: &mut [Complex<f64>],
    ) {
        for (group, sums) in self.groups.iter().zip(sums) {
            for (ring, sums) in group.rings.iter().zip(sums.chunks_exact(n_columns)) {
                let cos = ring.colatitude.cos().abs();
                let functions = values.chunks_exact_mut(self.n_rings);
                for (values, part) in functions.zip(sums.as_chunks::<PARTS>().0) {
                    let even = Complex::new(part[0], part[1]);
                    let odd = Complex::new(part[2], part[3]) * cos;
                    if let Some(r) = ring.north {
                        values[r] = even + odd;
                    }
                    if let Some(r) = ring.south {
                        values[r] = even - odd;
                    }
                }
            }
        }
    }
}

/// Joins ring i and ring n - 1 - i if all such pairs are bit-identical reflections.
fn share_lanes(rings: &mut Vec<Members>) {
    let n = rings.len();
    let mirrored = |a: &Members, b: &Members| {
        a.colatitude.versine().to_bits() == b.colatitude.versine().to_bits()
            && a.colatitude.is_south() != b.colatitude.is_south()
    };
    if n < 2 || !(0..n / 2).all(|i| mirrored(&rings[i], &rings[n - 1 - i])) {
        return;
    }
    for i in 0..n / 2 {
        let other = rings[n - 1 - i];
        let ring = &mut rings[i];
        ring.north = ring.north.or(other.north);
        ring.south = ring.south.or(other.south);
    }
    rings.truncate(n.div_ceil(2));
}

impl Group {
    fn load(&mut self, rings: &[Members], anchor: Anchor, lmax: usize) {
        self.rings.clear();
        self.rings.extend_from_slice(rings);
        let n = rings.len().next_multiple_of(RINGS);
        let Self { range, rings, sin_theta, last_order, argument, sectoral, scale, start } = self;
        for column in [&mut *sin_theta, last_order, argument, sectoral, scale, start] {
            column.clear();
            column.resize(n, 0.0);
        }
        for (lane, ring) in rings.iter().enumerate() {
            let (sin, cos) = (ring.colatitude.sin(), ring.colatitude.cos());
            sin_theta[lane] = sin;
            argument[lane] = match anchor {
                Anchor::Equator => cos * cos,
                Anchor::Pole => sin * sin,
            };
            last_order[lane] = last_order_at(sin, cos, lmax as f64, *range);
        }
    }

    /// Returns the number of lanes, including empty ones.
    pub(super) fn capacity(&self) -> usize {
        self.argument.len()
    }

    fn start_order(&mut self, arch: Arch, m: usize) {
        let Self { range, rings, sin_theta, sectoral, scale, start, .. } = self;
        if m == 0 {
            sectoral[..rings.len()].fill(0.5 / PI.sqrt());
            scale.fill(0.0);
        } else {
            let ratio = -((2.0 * m as f64 + 1.0) / (2.0 * m as f64)).sqrt();
            let range = *range;
            arch.dispatch(Advance { ratio, range, sin_theta, sectoral, scale });
        }
        let first = (2.0 * m as f64 + 3.0).sqrt();
        for (start, sectoral) in start.iter_mut().zip(sectoral) {
            *start = *sectoral * first;
        }
    }

    /// Returns the number of leading lanes that are significant at order `m`.
    pub(super) fn active(&self, m: usize) -> usize {
        self.last_order[..self.rings.len()].partition_point(|&last| last >= m as f64)
    }
}

/// Returns the order beyond which every `|lambda_lm|`, l <= lmax, is below the range at a
/// colatitude.
///
/// Beyond its turning point `m_0 = l sin theta` a harmonic decays as
/// `exp(-(2 sqrt 2/3) (m - m_0)^(3/2) / (sqrt(m_0) cos theta))`, the WKB exponent to leading order
/// in `m - m_0`, and faster for larger m. The added constant covers the neighbourhood of the poles,
/// where it is about `(m_0/2)^m/m!`.
fn last_order_at(sin_theta: f64, cos_theta: f64, lmax: f64, range: ValueRange) -> f64 {
    let turning = (lmax + 0.5) * sin_theta;
    let exponent = range.limit.ln() + 2.0;
    let scale = 1.5 / SQRT_2 * exponent * turning.sqrt() * cos_theta.abs();
    let last = turning + (scale * scale).cbrt() + 8.0 + 0.2 * exponent;
    if last.is_nan() { f64::INFINITY } else { last }
}

/// Computes `lambda_mm` from `lambda_{m-1,m-1}`, vectorized by the compiler.
struct Advance<'a> {
    ratio: f64,
    range: ValueRange,
    sin_theta: &'a [f64],
    sectoral: &'a mut [f64],
    scale: &'a mut [f64],
}

impl NullaryFnOnce for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { ratio, range, sin_theta, sectoral, scale } = self;
        let min = 1.0 / range.limit;
        for ((sectoral, scale), sin) in sectoral.iter_mut().zip(scale).zip(sin_theta) {
            // So close to a pole only m = 0 is significant, and one change of scale would not
            // suffice.
            let sin = if *sin < min { 0.0 } else { *sin };
            let next = *sectoral * (ratio * sin);
            let low = next.abs() < min;
            *sectoral = if low { next * range.up } else { next };
            let lower = if low { *scale - 1.0 } else { *scale };
            *scale = if next == 0.0 { 0.0 } else { lower };
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sphvar_sh::{Colatitude, Recurrence};

    use super::{ValueRange, last_order_at};

    #[test]
    fn skipped_orders_are_negligible() {
        for range in [1e-4, 1e-8, 1e-16, 1e-20].map(ValueRange::starting_at) {
            for lmax in [1, 2, 7, 40, 300, 1500_u32] {
                for k in 0..60 {
                    // From the equator to within 1e-9 of the pole.
                    let theta = std::f64::consts::FRAC_PI_2 * 0.7_f64.powi(k);
                    let colatitude =
                        Colatitude::from_direction(DVec3::new(theta.sin(), 0.0, theta.cos()));
                    let (sin, cos) = (colatitude.sin(), colatitude.cos());
                    let last = last_order_at(sin, cos, f64::from(lmax), range);
                    assert!(
                        last <= f64::from(lmax) * sin * 1.5 + 200.0,
                        "skips too little: {last}"
                    );
                    // Functions decrease with the order: the first skipped one is the largest.
                    let Some(m) = (0..=lmax as usize).find(|&m| m as f64 > last) else { continue };
                    let mut column = vec![0.0; lmax as usize + 1 - m];
                    Recurrence::new(m, lmax as usize).column_into(colatitude, &mut column);
                    let largest = column.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
                    assert!(
                        largest < 1.0 / range.limit,
                        "lmax {lmax}, theta {theta:e}, m {m}: {largest:e}, significant from {:e}",
                        1.0 / range.limit
                    );
                }
            }
        }
    }
}
