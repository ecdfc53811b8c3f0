use num_complex::Complex;
use pulp::{Arch, NullaryFnOnce};

use super::PARTS;

/// Longest stretch of the recurrence between two looks at the range of its values.
pub(super) const SPAN: usize = 16;

/// Growth of the functions over a stretch at which it ends early.
const MOST_GROWTH: f64 = (1u64 << 60) as f64;

/// Numbers computed side by side.
const WIDTH: usize = 8;

/// The coefficients of the recurrence over the degree at one order m, two degrees at a step.
///
/// All functions of one order are made of one sequence `mu_n`, polynomials in `sin^2 theta` times
/// `sin^m theta`:
///
/// ```text
/// lambda_{m+2n+1} = cos theta mu_n,    lambda_{m+2n} = A_n mu_n + B_n mu_{n-1}
/// ```
///
/// because `mu_n` is proportional to the Jacobi polynomial `P_n^(m,1/2)(cos 2 theta)` and the even
/// functions to `P_n^(m,-1/2)` (DLMF 18.7.15, 18.7.16, 18.9.5). That two parities can share a
/// recurrence is Ishioka 2018, doi:10.2151/jmsj.2018-019. The recurrence itself is in
/// [`Sequence`].
#[derive(Clone, Debug, Default)]
pub(crate) struct Order {
    len: usize,
    rows: Vec<Row>,
    segments: Vec<Segment>,
    sequences: [Sequence; 2],
}

/// A stretch of the recurrence between two looks at the range of its values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    /// One past its last step.
    pub(super) end: usize,
    /// The most by which a value grows in it.
    pub(super) growth: f64,
}

/// The end of the interval in which a recurrence is at its best.
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
/// With j the polynomial normalised to 1 at the anchor and y the squared distance from it,
/// `y = sin^2 theta` from the pole or `y = cos^2 theta` from the equator,
///
/// ```text
/// d' = r d - c y j,    j' = j + d'
/// c = (2n+m+3/2)(2n+m+5/2) / ((n+1+a)(n+m+3/2)),
/// r = n(n+b)(2n+m+5/2) / ((n+1+a)(n+m+3/2)(2n+m+1/2))
/// ```
///
/// with (a, b) = (m, 1/2) at the pole and (1/2, m) at the equator. It is the three-term recurrence
/// written for differences, so that nothing is lost where y is small; at the other end a factor of
/// about the degree would be. Factors are moved between d and j to make it three operations,
/// `d -= (forcing y) j; j += follow d`, and moved back at the end of a segment before they leave
/// the range of f64.
#[derive(Clone, Debug, Default)]
pub(super) struct Sequence {
    pub(super) steps: Vec<Step>,
    /// By segment.
    pub(super) factors: Vec<Factors>,
    /// What the value is to be multiplied with to be `mu_n`.
    norm: Vec<f64>,
}

/// The step from n to n + 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) forcing: f64,
    pub(super) follow: f64,
}

/// The factors that value and difference take at the end of a segment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Factors {
    pub(super) value: f64,
    pub(super) difference: f64,
}

impl Order {
    /// Replaces the coefficients by those of order `m` for degrees `m..=lmax`; m <= lmax.
    ///
    /// Cost: some 40 operations a step, a quarter of them divisions or roots of vectors.
    pub(crate) fn fill(&mut self, arch: Arch, m: usize, lmax: usize) {
        self.len = (lmax - m) / 2 + 1;
        self.rows.resize(self.len.div_ceil(WIDTH), Row::default());
        arch.dispatch(Fill { m: m as f64, rows: &mut self.rows });
        self.cut();
        for anchor in Anchor::BOTH {
            self.scale(anchor);
        }
    }

    /// The number of functions `mu_n`: as many as even l - m up to lmax.
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

    /// Cuts the steps into segments.
    fn cut(&mut self) {
        self.segments.clear();
        let (mut begun, mut growth) = (0, 1.0);
        for n in 0..self.len {
            let (row, i) = self.at(n);
            growth *= row.growth[i];
            if n + 1 - begun == SPAN || growth > MOST_GROWTH || n + 1 == self.len {
                self.segments.push(Segment { end: n + 1, growth });
                (begun, growth) = (n + 1, 1.0);
            }
        }
    }

    /// Moves the factors of one recurrence.
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
                // The first difference is zero, whatever it is multiplied with.
                shrink *= if n == 0 { 1.0 } else { damping };
                size *= growth;
                steps.push(Step { forcing: forcing / shrink, follow: shrink });
                n += 1;
            }
            factors.push(Factors { value: size, difference: shrink * size });
        }
        self.sequences[anchor as usize] = sequence;
    }

    /// Writes the coefficients of one function to `column`, degrees from m on, from the sums of
    /// values of either recurrence, by anchor: `PARTS` of `n_columns` numbers for each n.
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

    /// The transpose of [`Self::collect`]: what multiplies the values of either recurrence.
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

/// Coefficients for `WIDTH` successive n.
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

/// The coefficients for every n, vectorised by the compiler.
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
                // Norms relative to the value at the pole, sqrt((2l+1) (l+m)!/(l-m)!): from l to l+2
                // for l = k + 1, and from the odd degrees k + 1 and k - 1 to l = k.
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
                // n sqrt(1/(k - m)) with k - m = 2n; 2k - 1 is negative only where n = 0 makes it 0.
                row.far[i] =
                    half * ((2.0 * k + 1.0) * above * (0.5 * n) / (2.0 * k - 1.0).abs()).sqrt();
            }
            first += WIDTH as f64;
        }
    }
}
