use std::f64::consts::{FRAC_1_SQRT_2, PI, SQRT_2};

use num_complex::Complex;
use pulp::{Arch, NullaryFnOnce};
use sphvar_sh::Colatitude;

use super::number::Number;
use super::{Form, PARTS, RINGS};

/// The least `|sin 2 theta|` for the recurrence without differences if it is not accurate enough
/// at a pole.
const MIDDLE: f64 = 0.25;

/// The error of the recurrence without differences at a pole, divided by lmax^(3/2): that of the
/// sum of lmax/2 independent rounding errors that grow linearly.
const DOUBLE_ERROR: f64 = 4e-17;

/// The rounding error of f32 in coefficients relative to their norm, without cancellation, measured.
const SINGLE_ERROR: f64 = 2.7e-8;

/// The least accuracy with values and sums over some hundred lanes in f32. It is below that of grids
/// in f32; half of the lanes are still in f32 there.
const MIN_SINGLE: f64 = 2e-7;

/// Accuracy of the values, and the arithmetic that it permits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Arithmetic {
    /// Values below are negligible.
    smallest: f64,
    /// The recurrence is without differences where `|sin 2 theta|` is at least this.
    middle: f64,
    /// Values are rounded to f32 where the recurrence is without differences and `|cos theta|` is
    /// at least this.
    single: f64,
}

impl Arithmetic {
    /// Returns the arithmetic for transforms of accuracy `epsilon` to degree `lmax`.
    ///
    /// The recurrence without differences is used at all rings if its errors at a pole are below
    /// 0.2 epsilon, or else where it is about as accurate as the other forms.
    ///
    /// The functions of even l - m are differences of neighbours in the sequence of the
    /// recurrence, which are larger by up to `1/|cos theta|` and at most the degree. Rounding errors
    /// of f32 relative to them stay below 0.3 epsilon, or 0.35 epsilon if all lanes can then be in
    /// f32.
    pub(crate) fn new(epsilon: f64, lmax: usize) -> Self {
        // A thousandth of the accuracy is negligible.
        let smallest = 0.001 * epsilon;
        let middle =
            if DOUBLE_ERROR * (lmax as f64).powf(1.5) < 0.2 * epsilon { 0.0 } else { MIDDLE };
        let single = match SINGLE_ERROR / epsilon {
            _ if epsilon < MIN_SINGLE => f64::INFINITY,
            error if error * (lmax as f64) < 0.35 => 0.0,
            error => error / 0.3,
        };
        Self { smallest, middle, single }
    }

    pub(super) fn smallest(self) -> f64 {
        self.smallest
    }

    /// Returns whether there may be lanes with a form of the recurrence.
    #[inline(always)]
    pub(super) fn uses(self, form: Form) -> bool {
        match form {
            Form::Equator | Form::Pole => self.middle > 0.0,
            Form::Middle => self.middle <= 1.0 && self.single > 0.0,
            Form::Single => self.single <= 1.0,
        }
    }

    fn form(self, sin: f64, cos: f64) -> Form {
        if 2.0 * sin * cos.abs() >= self.middle {
            if cos.abs() >= self.single { Form::Single } else { Form::Middle }
        } else if sin > FRAC_1_SQRT_2 || sin.is_nan() {
            Form::Equator
        } else {
            Form::Pole
        }
    }
}

impl Default for Arithmetic {
    /// Returns the full arithmetic of f64.
    fn default() -> Self {
        // Far below the rounding errors of significant values.
        Self { smallest: 1e-20, middle: f64::INFINITY, single: f64::INFINITY }
    }
}

/// The representation of small values of the recurrence, as `x 10^(100 k)`, k <= 0: k is below 0
/// while `|x|` is at most `LIMIT` and the value below `1/LIMIT`.
///
/// Then a lane with k < 0 has no value above 1e-25 in the next `SPAN` steps: the largest growth in
/// them that leads to a value near 1 is about e^60, by the asymptotics of Hermite functions beyond
/// their turning point.
pub(super) struct Scale;

impl Scale {
    pub(super) const LIMIT: f64 = 1e50;
    const UP: f64 = 1e100;
    pub(super) const DOWN: f64 = 1e-100;
}

/// Rings at one order m at a time, stored as lanes of the northern hemisphere.
///
/// A southern ring is stored as its reflection at the equator, where `lambda_lm` only changes sign
/// with the parity of l + m. Two rings that are reflections of each other share a lane.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lanes {
    n_rings: usize,
    arithmetic: Arithmetic,
    unsorted: Vec<Members>,
    groups: [Group; 4],
}

/// Lanes with one form of the recurrence, sorted from the equator to the pole.
///
/// Stored as a structure of arrays. All fields except `rings` are padded to a multiple of `RINGS`
/// with empty lanes.
#[derive(Clone, Debug, Default)]
pub(super) struct Group {
    rings: Vec<Members>,
    sin_theta: Vec<f64>,
    /// The maximum order at which a lane is significant.
    last_order: Vec<f64>,
    /// The argument of the recurrence.
    pub(super) argument: Vec<f64>,
    /// `lambda_mm` and its scale; see [`Scale`].
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
        arithmetic: Arithmetic,
    ) {
        self.arithmetic = arithmetic;
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
        for form in Form::ALL {
            let rings = self.unsorted.iter().filter(|ring| {
                arithmetic.form(ring.colatitude.sin(), ring.colatitude.cos()) == form
            });
            self.groups[form as usize].load(rings, form, lmax, arithmetic.smallest);
        }
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

    pub(crate) fn arithmetic(&self) -> Arithmetic {
        self.arithmetic
    }

    pub(super) fn group(&self, form: Form) -> &Group {
        &self.groups[form as usize]
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
    fn load<'r>(
        &mut self,
        of_form: impl Iterator<Item = &'r Members>,
        form: Form,
        lmax: usize,
        smallest: f64,
    ) {
        let Self { rings, sin_theta, last_order, argument, sectoral, scale, start } = self;
        rings.clear();
        rings.extend(of_form.copied());
        let n = rings.len().next_multiple_of(RINGS);
        for column in [&mut *sin_theta, last_order, argument, sectoral, scale, start] {
            column.clear();
            column.resize(n, 0.0);
        }
        for (lane, ring) in rings.iter().enumerate() {
            let (sin, cos) = (ring.colatitude.sin(), ring.colatitude.cos());
            sin_theta[lane] = sin;
            argument[lane] = match form {
                Form::Equator => cos * cos,
                Form::Pole => sin * sin,
                Form::Middle | Form::Single => 0.5 * (cos.abs() + sin) * (cos.abs() - sin),
            };
            last_order[lane] = last_order_at(sin, cos, lmax as f64, smallest);
        }
    }

    /// Returns the length of a column of numbers for every lane. Columns of 2^k numbers would
    /// compete for the same places of the cache.
    pub(super) fn column_len(&self) -> usize {
        self.argument.len() + RINGS / 2
    }

    /// Writes the factors of `mu_n` in sums over rings to `terms`: for each function `PARTS`
    /// columns of a number per lane, for the first `active` lanes and their padding. The caller's
    /// ring r of function b has the value `values[b * n_rings + r]`.
    #[inline(always)]
    pub(super) fn gather<T: Number>(
        &self,
        values: &[Complex<f64>],
        n_rings: usize,
        active: usize,
        terms: &mut [T],
    ) {
        let len = self.column_len();
        let functions = values.chunks_exact(n_rings.max(1));
        for (values, columns) in functions.zip(terms.chunks_exact_mut(len * PARTS)) {
            let mut columns = columns.chunks_exact_mut(len);
            let [a, b, c, d] = std::array::from_fn(|_| columns.next().unwrap_or_default());
            for column in [&mut *a, b, c, d] {
                column[active..active.next_multiple_of(T::PADDING)].fill(T::of(0.0));
            }
            let columns = a.iter_mut().zip(b).zip(c.iter_mut().zip(d));
            for (ring, ((a, b), (c, d))) in self.rings[..active].iter().zip(columns) {
                let cos = ring.colatitude.cos().abs();
                let north = ring.north.map_or(Complex::ZERO, |r| values[r]);
                let south = ring.south.map_or(Complex::ZERO, |r| values[r]);
                let (even, odd) = (north + south, (north - south) * cos);
                (*a, *b) = (T::of(even.re), T::of(even.im));
                (*c, *d) = (T::of(odd.re), T::of(odd.im));
            }
        }
    }

    /// Computes ring values from sums over degrees, multiplied by the size of each function: the
    /// transpose of [`Self::gather`].
    #[inline(always)]
    pub(super) fn scatter(
        &self,
        sums: &[f64],
        sizes: &[f64],
        n_rings: usize,
        values: &mut [Complex<f64>],
    ) {
        let len = self.column_len();
        let functions = values.chunks_exact_mut(n_rings.max(1));
        for ((values, columns), &size) in functions.zip(sums.chunks_exact(len * PARTS)).zip(sizes) {
            let mut columns = columns.chunks_exact(len);
            let [a, b, c, d] = std::array::from_fn(|_| columns.next().unwrap_or_default());
            let columns = a.iter().zip(b).zip(c.iter().zip(d));
            for (ring, ((&a, &b), (&c, &d))) in self.rings.iter().zip(columns) {
                let cos = ring.colatitude.cos().abs();
                let (even, odd) = (Complex::new(a, b) * size, Complex::new(c, d) * (size * cos));
                if let Some(r) = ring.north {
                    values[r] = even + odd;
                }
                if let Some(r) = ring.south {
                    values[r] = even - odd;
                }
            }
        }
    }

    fn start_order(&mut self, arch: Arch, m: usize) {
        let Self { rings, sin_theta, sectoral, scale, start, .. } = self;
        if m == 0 {
            sectoral[..rings.len()].fill(0.5 / PI.sqrt());
            scale.fill(0.0);
        } else {
            let ratio = -((2.0 * m as f64 + 1.0) / (2.0 * m as f64)).sqrt();
            arch.dispatch(Advance { ratio, sin_theta, sectoral, scale });
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

/// Returns the highest order that is significant at a colatitude up to degree `lmax`, in the default
/// arithmetic.
pub(crate) fn last_order(colatitude: Colatitude, lmax: usize) -> f64 {
    let smallest = Arithmetic::default().smallest();
    last_order_at(colatitude.sin(), colatitude.cos(), lmax as f64, smallest)
}

/// Returns the order beyond which every `|lambda_lm|`, l <= lmax, is below `smallest` at a
/// colatitude.
///
/// Beyond its turning point `m_0 = l sin theta` a harmonic decays as
/// `exp(-(2 sqrt 2/3) (m - m_0)^(3/2) / (sqrt(m_0) cos theta))`, the WKB exponent to leading order
/// in `m - m_0`, and faster for larger m. The added constant covers the neighbourhood of the poles,
/// where it is about `(m_0/2)^m/m!`.
fn last_order_at(sin_theta: f64, cos_theta: f64, lmax: f64, smallest: f64) -> f64 {
    let turning = (lmax + 0.5) * sin_theta;
    let exponent = 2.0 - smallest.ln();
    let scale = 1.5 / SQRT_2 * exponent * turning.sqrt() * cos_theta.abs();
    let last = turning + (scale * scale).cbrt() + 8.0 + 0.2 * exponent;
    if last.is_nan() { f64::INFINITY } else { last }
}

/// Computes `lambda_mm` from `lambda_{m-1,m-1}`, vectorized by the compiler.
struct Advance<'a> {
    ratio: f64,
    sin_theta: &'a [f64],
    sectoral: &'a mut [f64],
    scale: &'a mut [f64],
}

impl NullaryFnOnce for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { ratio, sin_theta, sectoral, scale } = self;
        let min = 1.0 / Scale::LIMIT;
        for ((sectoral, scale), sin) in sectoral.iter_mut().zip(scale).zip(sin_theta) {
            // So close to a pole only m = 0 is significant, and one change of scale would not
            // suffice.
            let sin = if *sin < min { 0.0 } else { *sin };
            let next = *sectoral * (ratio * sin);
            let low = next.abs() < min;
            *sectoral = if low { next * Scale::UP } else { next };
            let lower = if low { *scale - 1.0 } else { *scale };
            *scale = if next == 0.0 { 0.0 } else { lower };
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sphvar_sh::{Colatitude, Recurrence};

    use super::last_order_at;

    #[test]
    fn skipped_orders_are_negligible() {
        for smallest in [1e-4, 1e-8, 1e-16, 1e-20] {
            for lmax in [1, 2, 7, 40, 300, 1500_u32] {
                for k in 0..60 {
                    // From the equator to within 1e-9 of the pole.
                    let theta = std::f64::consts::FRAC_PI_2 * 0.7_f64.powi(k);
                    let colatitude =
                        Colatitude::from_direction(DVec3::new(theta.sin(), 0.0, theta.cos()));
                    let (sin, cos) = (colatitude.sin(), colatitude.cos());
                    let last = last_order_at(sin, cos, f64::from(lmax), smallest);
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
                        largest < smallest,
                        "lmax {lmax}, theta {theta:e}, m {m}: {largest:e}, significant from {smallest:e}"
                    );
                }
            }
        }
    }
}
