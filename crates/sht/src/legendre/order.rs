use num_complex::Complex;
use pulp::{Arch, NullaryFnOnce};

use super::number::Number;
use super::{Arithmetic, PARTS};

/// Number of steps between two checks of the range of the values.
pub(super) const SPAN: usize = 16;

/// Number of coefficients computed side by side.
const WIDTH: usize = 8;

/// Coefficients of the recurrence over the degree at one order m, two degrees per step.
///
/// All functions of one order are derived from one sequence `mu_n`, polynomials in `sin^2 theta`
/// times `sin^m theta`:
///
/// ```text
/// lambda_{m+2n+1} = cos theta mu_n,    lambda_{m+2n} = A_n mu_n + B_n mu_{n-1}
/// ```
///
/// `mu_n` is proportional to the Jacobi polynomial `P_n^(m,1/2)(cos 2 theta)` and the even
/// functions to `P_n^(m,-1/2)` (DLMF 18.7.15, 18.7.16, 18.9.5). The recurrences are described at
/// [`Sequence`].
///
/// # References
///
/// Ishioka 2018, doi:10.2151/jmsj.2018-019: one recurrence for both parities.
#[derive(Clone, Debug, Default)]
pub(crate) struct Order {
    len: usize,
    connections: Vec<Connection>,
    /// The coefficients of forms with differences.
    rows: Vec<Row>,
    /// The coefficients of the form without differences.
    ratios: Vec<Ratio>,
    /// Indexed by `Form::steps`; those of unused forms are out of date.
    sequences: [Sequence; 3],
}

/// The form of the recurrence for a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// Differences from the equator, for lanes near it.
    Equator = 0,
    /// Differences from the pole, for lanes near one.
    Pole = 1,
    /// Values only. This takes two operations for a step instead of three. Its rounding errors are
    /// those of the other forms times about `1/sin 2 theta`.
    Middle = 2,
    /// The same with values rounded to f32 for the sums.
    Single = 3,
}

impl Form {
    pub(super) const ALL: [Self; 4] = [Self::Equator, Self::Pole, Self::Middle, Self::Single];

    /// Returns the index of the steps of the recurrence.
    fn steps(self) -> usize {
        (self as usize).min(Self::Middle as usize)
    }
}

/// The steps of a recurrence in one form.
///
/// # With differences
///
/// Let j be the polynomial normalized to 1 at an anchor, the pole or the equator, and y the squared
/// distance from it, `y = sin^2 theta` or `y = cos^2 theta`. Then
///
/// ```text
/// d' = r d - c y j,    j' = j + d'
/// c = (2n+m+3/2)(2n+m+5/2) / ((n+1+a)(n+m+3/2)),
/// r = n(n+b)(2n+m+5/2) / ((n+1+a)(n+m+3/2)(2n+m+1/2))
/// ```
///
/// with (a, b) = (m, 1/2) at the pole and (1/2, m) at the equator. This is the three-term
/// recurrence written for differences. It loses no accuracy where y is small; at the other end it
/// would lose a factor of about the degree. Moving factors between d and j reduces a step to three
/// operations, `d -= (forcing y) j; j += follow d`. At the end of a segment, before they exceed the
/// range of f64, the factors are moved back.
///
/// # Without differences
///
/// With `e_l^2 = (l^2 - m^2)/(4 l^2 - 1)` and l = m + 2n + 1 the orthonormal functions obey
///
/// ```text
/// cos^2 theta mu_n = g_{n+1} mu_{n+1} + (e_{l+1}^2 + e_l^2) mu_n + g_n mu_{n-1},
/// g_n = e_{l-1} e_l
/// ```
///
/// For `mu_n = (1, 1, -1, -1)_n s_n p_n` with `s_0 = s_1 = 1`, `s_n s_{n+1} = g_1/g_{n+1}` a step
/// has two operations, `p_{n+1} = (slope y + offset) p_n + p_{n-1}` with `y = cos^2 theta - 1/2`
/// and `slope = (-1)^n s_n^2/g_1`.
#[derive(Clone, Debug, Default)]
pub(super) struct Sequence {
    pub(super) steps: Vec<Step>,
    /// Indexed by segment of `SPAN` steps. Empty in the form without differences.
    pub(super) factors: Vec<Factors>,
    /// The factors that convert values to `mu_n`.
    norm: Vec<f64>,
}

/// The step from n to n + 1: forcing and follow, or slope and offset.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step(pub(super) f64, pub(super) f64);

/// Factors applied to value and difference at the end of a segment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Factors {
    pub(super) value: f64,
    pub(super) difference: f64,
}

impl Order {
    /// Replaces the coefficients by those of order `m` for degrees `m..=lmax` and the forms of
    /// `arithmetic`; requires m <= lmax.
    ///
    /// # Performance
    ///
    /// About 30 operations per step and form, a fifth of them vector divisions or square roots.
    pub(crate) fn fill(&mut self, arch: Arch, m: usize, lmax: usize, arithmetic: Arithmetic) {
        self.len = (lmax - m) / 2 + 1;
        let n_rows = self.len.div_ceil(WIDTH);
        let m = m as f64;
        self.connections.resize(n_rows, Connection::default());
        arch.dispatch(Fill { m, rows: &mut self.connections });
        if arithmetic.uses(Form::Equator) {
            self.rows.resize(n_rows, Row::default());
            arch.dispatch(Fill { m, rows: &mut self.rows });
            self.scale(Form::Equator);
            self.scale(Form::Pole);
        }
        if arithmetic.uses(Form::Middle) || arithmetic.uses(Form::Single) {
            self.ratios.resize(n_rows, Ratio::default());
            arch.dispatch(Fill { m, rows: &mut self.ratios });
            self.chain();
            arch.dispatch(SignedRoots(&mut self.sequences[Form::Middle as usize].norm));
        }
    }

    /// Returns the number of functions `mu_n`, that of even l - m up to lmax.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    pub(super) fn sequence(&self, form: Form) -> &Sequence {
        &self.sequences[form.steps()]
    }

    /// Moves the factors of a recurrence with differences from values to coefficients.
    fn scale(&mut self, anchor: Form) {
        let Sequence { steps, factors, norm } = &mut self.sequences[anchor as usize];
        steps.clear();
        factors.clear();
        norm.clear();
        // mu = size j, and the true difference is shrink d.
        let (mut size, mut shrink) = (1.0, 1.0);
        for n in 0..self.len {
            let (row, i) = (&self.rows[n / WIDTH], n % WIDTH);
            let (damping, forcing, growth) = match anchor {
                Form::Equator => {
                    (row.equator_damping[i], row.equator_forcing[i], row.equator_growth[i])
                }
                _ => (row.damping[i], row.forcing[i], row.growth[i]),
            };
            norm.push(size);
            // The first difference is zero, so its factor is arbitrary.
            shrink *= if n == 0 { 1.0 } else { damping };
            size *= growth;
            steps.push(Step(forcing / shrink, shrink));
            if (n + 1).is_multiple_of(SPAN) || n + 1 == self.len {
                factors.push(Factors { value: size, difference: shrink * size });
                (size, shrink) = (1.0, 1.0);
            }
        }
    }

    /// Computes the steps without differences, and the squares of their norms.
    fn chain(&mut self) {
        let Sequence { steps, norm, .. } = &mut self.sequences[Form::Middle as usize];
        steps.clear();
        norm.clear();
        let Some(first) = self.ratios.first() else { return };
        let root = first.product[0].sqrt();
        // Squares of s_n. Each odd one follows from the even one before, so that rounding errors
        // of `s_n s_{n+1}` do not accumulate.
        let mut square = 1.0;
        for row in &self.ratios {
            for (i, pair) in (0..WIDTH).step_by(2).zip(row.product.as_chunks::<2>().0) {
                let next = first.product[0] / (pair[0] * square);
                for (i, square, sign) in [(i, square, 1.0), (i + 1, next, -1.0)] {
                    let slope = sign * square / root;
                    steps.push(Step(slope, -slope * row.center[i]));
                    norm.push(square);
                }
                square *= pair[0] / pair[1];
            }
        }
        steps.truncate(self.len);
        norm.truncate(self.len);
    }

    /// Writes the coefficients of functions to `columns`, for degrees from m on. `sums` are the
    /// sums of values in each form, indexed by form: for each n, `PARTS` for each function. `total`
    /// is workspace.
    #[inline(always)]
    pub(super) fn collect(
        &self,
        arithmetic: Arithmetic,
        sums: &[Vec<f64>; 4],
        total: &mut Vec<f64>,
        columns: &mut [&mut [Complex<f64>]],
    ) {
        let n_functions = columns.len();
        total.resize(self.len * PARTS * n_functions, 0.0);
        let mut is_first = true;
        for form in Form::ALL.into_iter().filter(|&form| arithmetic.uses(form)) {
            let norms = &self.sequence(form).norm;
            let terms = sums[form as usize].chunks_exact(PARTS * n_functions);
            let totals = total.chunks_exact_mut(PARTS * n_functions);
            for ((total, terms), norm) in totals.zip(terms).zip(norms) {
                for (total, term) in total.iter_mut().zip(terms) {
                    *total = if is_first { 0.0 } else { *total } + term * norm;
                }
            }
            is_first = false;
        }
        let total = total.as_chunks::<PARTS>().0;
        for (function, column) in columns.iter_mut().enumerate() {
            let connections = self.connections.iter().flat_map(|row| row.near.iter().zip(&row.far));
            let sums = total[function..].iter().step_by(n_functions);
            let mut previous = Complex::ZERO;
            for ((pair, sum), (&near, &far)) in column.chunks_mut(2).zip(sums).zip(connections) {
                let even = Complex::new(sum[0], sum[1]);
                pair[0] = even * near + previous * far;
                if let Some(odd) = pair.get_mut(1) {
                    *odd = Complex::new(sum[2], sum[3]);
                }
                previous = even;
            }
        }
    }

    /// Computes the factors of the values in one form, divided by `size`: the transpose of
    /// [`Self::collect`].
    #[inline(always)]
    pub(super) fn distribute<T: Number>(
        &self,
        form: Form,
        column: &[Complex<f64>],
        size: f64,
        n_functions: usize,
        function: usize,
        terms: &mut [T],
    ) {
        let entry = |l: usize| column.get(l).map_or(Complex::ZERO, |a| a / size);
        let at = |n: usize| (&self.connections[n / WIDTH], n % WIDTH);
        let norms = &self.sequence(form).norm[..self.len];
        let terms = terms.as_chunks_mut::<PARTS>().0[function..].iter_mut().step_by(n_functions);
        for (n, (terms, norm)) in terms.zip(norms).enumerate() {
            let (row, i) = at(n);
            let mut even = entry(2 * n) * row.near[i];
            if n + 1 < self.len {
                let (next, i) = at(n + 1);
                even += entry(2 * n + 2) * next.far[i];
            }
            let odd = entry(2 * n + 1);
            *terms = [even.re, even.im, odd.re, odd.im].map(|x| T::of(x * norm));
        }
    }
}

/// Coefficients for `WIDTH` consecutive n.
trait FillRow {
    /// Computes the coefficients at index `i`, for `n`.
    fn set(&mut self, i: usize, at: Place);
}

/// What the coefficients for one n depend on.
#[derive(Clone, Copy)]
struct Place {
    n: f64,
    m: f64,
    /// The degree of the even function, `2 n + m`.
    k: f64,
    /// `k + m` and `k - m`.
    above: f64,
    below: f64,
}

impl Place {
    #[inline(always)]
    fn new(n: f64, m: f64) -> Self {
        let k = 2.0 * n + m;
        Self { n, m, k, above: k + m, below: 2.0 * n }
    }
}

/// `A_n` and `B_n`.
#[derive(Clone, Copy, Debug, Default)]
struct Connection {
    near: [f64; WIDTH],
    far: [f64; WIDTH],
}

/// Coefficients of both forms with differences.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    /// r, c, and the growth of `mu_n` at the pole from n to n + 1.
    damping: [f64; WIDTH],
    forcing: [f64; WIDTH],
    growth: [f64; WIDTH],
    /// The same at the equator.
    equator_damping: [f64; WIDTH],
    equator_forcing: [f64; WIDTH],
    equator_growth: [f64; WIDTH],
}

/// Coefficients of the form without differences.
#[derive(Clone, Copy, Debug, Default)]
struct Ratio {
    /// The square of `g_{n+1}`.
    product: [f64; WIDTH],
    /// `e_{l+1}^2 + e_l^2 - 1/2`.
    center: [f64; WIDTH],
}

impl FillRow for Connection {
    #[inline(always)]
    fn set(&mut self, i: usize, at: Place) {
        let Place { n, m, k, above, below } = at;
        let half = 1.0 / (k + 0.5);
        self.near[i] = (n + m + 0.5)
            * half
            * ((2.0 * k + 1.0) * (below + 1.0) / ((2.0 * k + 3.0) * (above + 1.0))).sqrt();
        // n sqrt(1/(k - m)) with k - m = 2n; 2k - 1 is negative only for n = 0, where the
        // result is 0.
        self.far[i] = half * ((2.0 * k + 1.0) * above * (0.5 * n) / (2.0 * k - 1.0).abs()).sqrt();
    }
}

impl FillRow for Row {
    #[inline(always)]
    fn set(&mut self, i: usize, at: Place) {
        let Place { n, m, k, above, below } = at;
        let at_pole = 1.0 / (n + m + 1.0);
        let at_equator = 1.0 / (n + 1.5);
        let half = 1.0 / (k + 0.5);
        let common = (k + 2.5) / (n + m + 1.5);
        self.damping[i] = n * (n + 0.5) * common * half * at_pole;
        self.equator_damping[i] = n * (n + m) * common * half * at_equator;
        self.forcing[i] = (k + 1.5) * common * at_pole;
        self.equator_forcing[i] = (k + 1.5) * common * at_equator;
        // Norms relative to the value at the pole, sqrt((2l+1) (l+m)!/(l-m)!): from l to
        // l+2 for l = k + 1, and from the odd degrees k + 1 and k - 1 to l = k.
        let growth = ((2.0 * k + 7.0) * (above + 2.0) * (above + 3.0)
            / ((2.0 * k + 3.0) * (below + 2.0) * (below + 3.0)))
            .sqrt();
        self.growth[i] = growth;
        // P_n(-1)/P_n(1) of the Jacobi polynomials, from n to n + 1.
        self.equator_growth[i] = -growth * (n + 1.5) * at_pole;
    }
}

impl FillRow for Ratio {
    #[inline(always)]
    fn set(&mut self, i: usize, at: Place) {
        let Place { k, above, below, .. } = at;
        // The numerators of e_l^2, e_{l+1}^2 and e_{l+2}^2 for l = k + 1, and the denominators
        // (2l-1)(2l+1), with one division.
        let [low, mid, high] = [1.0, 2.0, 3.0].map(|step| (below + step) * (above + step));
        let [a, b, c, d] = [1.0, 3.0, 5.0, 7.0].map(|step| 2.0 * k + step);
        let inverse = 1.0 / ((a * b) * (c * c * d));
        self.product[i] = mid * high * (inverse * a);
        self.center[i] = (low * c + mid * a) * (inverse * (c * d)) - 0.5;
    }
}

/// Computes the coefficients for every n, vectorized by the compiler.
struct Fill<'a, R> {
    m: f64,
    rows: &'a mut [R],
}

impl<R: FillRow> NullaryFnOnce for Fill<'_, R> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { m, rows } = self;
        let mut first = 0.0;
        for row in rows {
            for i in 0..WIDTH {
                row.set(i, Place::new(first + i as f64, m));
            }
            first += WIDTH as f64;
        }
    }
}

/// Replaces squares of norms by norms.
struct SignedRoots<'a>(&'a mut [f64]);

impl NullaryFnOnce for SignedRoots<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (n, norm) in self.0.iter_mut().enumerate() {
            let root = norm.sqrt();
            *norm = if n & 2 == 0 { root } else { -root };
        }
    }
}
