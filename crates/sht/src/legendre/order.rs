use num_complex::Complex;
use pulp::{Arch, NullaryFnOnce};

use super::PARTS;

/// Maximum number of steps between two checks of the range of the values.
pub(super) const SPAN: usize = 16;

/// Growth of the functions that ends a segment early.
const MAX_GROWTH: f64 = (1u64 << 60) as f64;

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
/// functions to `P_n^(m,-1/2)` (DLMF 18.7.15, 18.7.16, 18.9.5). The recurrence is described at
/// [`Sequence`].
///
/// # References
///
/// Ishioka 2018, doi:10.2151/jmsj.2018-019: one recurrence for both parities.
#[derive(Clone, Debug, Default)]
pub(crate) struct Order {
    len: usize,
    rows: Vec<Row>,
    segments: Vec<Segment>,
    sequences: [Sequence; 2],
}

/// A section of the recurrence between two checks of the range of its values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    /// The index after its last step.
    pub(super) end: usize,
    /// The maximum growth of a value within the segment.
    pub(super) growth: f64,
}

/// The end of the interval at which a recurrence is most accurate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Equator = 0,
    Pole = 1,
}

impl Anchor {
    pub(super) const BOTH: [Self; 2] = [Self::Equator, Self::Pole];
}

/// The recurrence of the Jacobi polynomials in difference form.
///
/// Let j be the polynomial normalized to 1 at the anchor and y the squared distance from it,
/// `y = sin^2 theta` from the pole or `y = cos^2 theta` from the equator. Then
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
#[derive(Clone, Debug, Default)]
pub(super) struct Sequence {
    pub(super) steps: Vec<Step>,
    /// Indexed by segment.
    pub(super) factors: Vec<Factors>,
    /// The factors that convert values to `mu_n`.
    norm: Vec<f64>,
}

/// The step from n to n + 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) forcing: f64,
    pub(super) follow: f64,
}

/// Factors applied to value and difference at the end of a segment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Factors {
    pub(super) value: f64,
    pub(super) difference: f64,
}

impl Order {
    /// Replaces the coefficients by those of order `m` for degrees `m..=lmax`; requires m <= lmax.
    ///
    /// # Performance
    ///
    /// About 40 operations per step, a quarter of them vector divisions or square roots.
    pub(crate) fn fill(&mut self, arch: Arch, m: usize, lmax: usize) {
        self.len = (lmax - m) / 2 + 1;
        self.rows.resize(self.len.div_ceil(WIDTH), Row::default());
        arch.dispatch(Fill { m: m as f64, rows: &mut self.rows });
        self.split_segments();
        for anchor in Anchor::BOTH {
            self.scale(anchor);
        }
    }

    /// Returns the number of functions `mu_n`, that of even l - m up to lmax.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    pub(super) fn segments(&self) -> &[Segment] {
        &self.segments
    }

    pub(super) fn sequence(&self, anchor: Anchor) -> &Sequence {
        &self.sequences[anchor as usize]
    }

    fn at(&self, n: usize) -> (&Row, usize) {
        (&self.rows[n / WIDTH], n % WIDTH)
    }

    /// Splits the steps into segments.
    fn split_segments(&mut self) {
        self.segments.clear();
        let (mut start, mut growth) = (0, 1.0);
        for n in 0..self.len {
            let (row, i) = self.at(n);
            growth *= row.growth[i];
            if n + 1 - start == SPAN || growth > MAX_GROWTH || n + 1 == self.len {
                self.segments.push(Segment { end: n + 1, growth });
                (start, growth) = (n + 1, 1.0);
            }
        }
    }

    /// Moves the factors of one recurrence from values to coefficients.
    fn scale(&mut self, anchor: Anchor) {
        let mut sequence = std::mem::take(&mut self.sequences[anchor as usize]);
        let Sequence { steps, factors, norm } = &mut sequence;
        steps.clear();
        factors.clear();
        norm.clear();
        let mut n = 0;
        for &Segment { end, .. } in &self.segments {
            // mu = size j, and the true difference is shrink d.
            let (mut size, mut shrink) = (1.0, 1.0);
            while n < end {
                let (row, i) = self.at(n);
                let (damping, forcing, growth) = match anchor {
                    Anchor::Equator => {
                        (row.equator_damping[i], row.equator_forcing[i], row.equator_growth[i])
                    }
                    Anchor::Pole => (row.damping[i], row.forcing[i], row.growth[i]),
                };
                norm.push(size);
                // The first difference is zero, so its factor is arbitrary.
                shrink *= if n == 0 { 1.0 } else { damping };
                size *= growth;
                steps.push(Step { forcing: forcing / shrink, follow: shrink });
                n += 1;
            }
            factors.push(Factors { value: size, difference: shrink * size });
        }
        self.sequences[anchor as usize] = sequence;
    }

    /// Writes the coefficients of one function to `column`, for degrees from m on. `sums` are the
    /// sums of values of each recurrence, indexed by anchor: for each n, `n_columns` numbers of
    /// which a function has `PARTS`.
    #[inline(always)]
    pub(super) fn collect(
        &self,
        sums: &[Vec<f64>; 2],
        n_columns: usize,
        function: usize,
        column: &mut [Complex<f64>],
    ) {
        let [equator, pole] = &self.sequences;
        let sums = sums[0].chunks_exact(n_columns).zip(sums[1].chunks_exact(n_columns));
        let norms = equator.norm.iter().zip(&pole.norm);
        let connections = self.rows.iter().flat_map(|row| row.near.iter().zip(&row.far));
        let mut previous = Complex::ZERO;
        for (((pair, sums), norms), (&near, &far)) in
            column.chunks_mut(2).zip(sums).zip(norms).zip(connections)
        {
            let part = |row: &'_ [f64]| row.as_chunks::<PARTS>().0[function];
            let (equator, pole) = (part(sums.0), part(sums.1));
            let mut sum = [0.0; PARTS];
            for i in 0..PARTS {
                sum[i] = equator[i] * norms.0 + pole[i] * norms.1;
            }
            let even = Complex::new(sum[0], sum[1]);
            pair[0] = even * near + previous * far;
            if let Some(odd) = pair.get_mut(1) {
                *odd = Complex::new(sum[2], sum[3]);
            }
            previous = even;
        }
    }

    /// Computes the factors of the values of each recurrence: the transpose of [`Self::collect`].
    #[inline(always)]
    pub(super) fn distribute(
        &self,
        column: &[Complex<f64>],
        n_columns: usize,
        function: usize,
        terms: &mut [Vec<f64>; 2],
    ) {
        let entry = |l: usize| column.get(l).copied().unwrap_or_default();
        for n in 0..self.len {
            let (row, i) = self.at(n);
            let mut even = entry(2 * n) * row.near[i];
            if n + 1 < self.len {
                let (next, i) = self.at(n + 1);
                even += entry(2 * n + 2) * next.far[i];
            }
            let odd = entry(2 * n + 1);
            for (terms, sequence) in terms.iter_mut().zip(&self.sequences) {
                let at = n * n_columns + function * PARTS;
                let norm = sequence.norm[n];
                let parts = [even.re, even.im, odd.re, odd.im].map(|x| x * norm);
                terms[at..at + PARTS].copy_from_slice(&parts);
            }
        }
    }
}

/// Coefficients for `WIDTH` consecutive n.
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
    /// `A_n` and `B_n`.
    near: [f64; WIDTH],
    far: [f64; WIDTH],
}

/// Computes the coefficients for every n, vectorized by the compiler.
struct Fill<'a> {
    m: f64,
    rows: &'a mut [Row],
}

impl NullaryFnOnce for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { m, rows } = self;
        let mut first = 0.0;
        for row in rows {
            for i in 0..WIDTH {
                let n = first + i as f64;
                let k = 2.0 * n + m;
                let at_pole = 1.0 / (n + m + 1.0);
                let at_equator = 1.0 / (n + 1.5);
                let half = 1.0 / (k + 0.5);
                let common = (k + 2.5) / (n + m + 1.5);
                row.damping[i] = n * (n + 0.5) * common * half * at_pole;
                row.equator_damping[i] = n * (n + m) * common * half * at_equator;
                row.forcing[i] = (k + 1.5) * common * at_pole;
                row.equator_forcing[i] = (k + 1.5) * common * at_equator;
                // Norms relative to the value at the pole, sqrt((2l+1) (l+m)!/(l-m)!): from l to
                // l+2 for l = k + 1, and from the odd degrees k + 1 and k - 1 to l = k.
                let (above, below) = (k + m, k - m);
                let growth = ((2.0 * k + 7.0) * (above + 2.0) * (above + 3.0)
                    / ((2.0 * k + 3.0) * (below + 2.0) * (below + 3.0)))
                    .sqrt();
                row.growth[i] = growth;
                // P_n(-1)/P_n(1) of the Jacobi polynomials, from n to n + 1.
                row.equator_growth[i] = -growth * (n + 1.5) * at_pole;
                row.near[i] = (n + m + 0.5)
                    * half
                    * ((2.0 * k + 1.0) * (below + 1.0) / ((2.0 * k + 3.0) * (above + 1.0))).sqrt();
                // n sqrt(1/(k - m)) with k - m = 2n; 2k - 1 is negative only for n = 0, where the
                // result is 0.
                row.far[i] =
                    half * ((2.0 * k + 1.0) * above * (0.5 * n) / (2.0 * k - 1.0).abs()).sqrt();
            }
            first += WIDTH as f64;
        }
    }
}
