use std::f64::consts::{PI, TAU};
use std::fmt;

use num_complex::Complex;
use pulp::{Arch, Simd, WithSimd};
use sphvar_nufft::parts::{Design, SHORT, Threads, add_with_rests, share};
use sphvar_sh::{Alm, Colatitude, Error};

use crate::RingTransform;
use crate::legendre::last_order;
use crate::rings::RingWorker;
use crate::torus::{Layout, ORDERS, ROWS, Stage, Torus, TorusScratch};

/// Adjoint of the Legendre stage for many rings, `a_lm = sum_r lambda_lm(theta_r) f_m(r)`, at a
/// cost that hardly depends on their number.
///
/// It computes what [`RingTransform`] does, to rounding, for rings that come in pairs: each stands
/// for itself and for its reflection at the equator. Up to degree L, `lambda_lm` is a trigonometric
/// polynomial in theta, so that its value on a ring follows from those on L + 2 Clenshaw-Curtis
/// rings. The adjoint of this interpolation replaces the ring by terms on these: a window spreads
/// it onto a regular grid in theta, and a Fourier transform, divided by that of the window, leads
/// to the rings.
///
/// # Performance
///
/// 32 multiply-adds per ring and order, and a [`RingTransform`] of L + 2 rings. It is faster than
/// the latter for all rings from about twice as many rings on.
///
/// # Examples
///
/// ```
/// use num_complex::Complex;
/// use sphvar_sh::Colatitude;
/// use sphvar_sht::{DenseRingTransform, MirroredRings, RingSums};
///
/// /// A ring of mass 1 at every colatitude.
/// struct Masses(usize);
///
/// impl MirroredRings for Masses {
///     fn add<const FUSED: bool>(&self, first: usize, sums: &mut RingSums<'_>) {
///         for ring in (0..self.0).filter(|_| first == 0) {
///             let mut values = [[Complex::ZERO; RingSums::ORDERS]; 2];
///             (values[0][0].re, values[1][0].re) = (1.0, 1.0);
///             sums.add::<FUSED>(ring, &values);
///         }
///     }
/// }
///
/// let colatitude = |i: i32| Colatitude::from_theta(0.001 * f64::from(i));
/// let rings: Vec<_> = (0..1570).map(colatitude).collect::<Result<_, _>>()?;
/// let alm = DenseRingTransform::new(20, rings.iter().copied())?.adjoint(&Masses(rings.len()))?;
/// // 3140 masses times Y_00, and no odd degrees.
/// assert!((alm.column(0)[0].re - 3140.0 * 0.28209479177387814).abs() < 1e-10);
/// assert!(alm.column(0)[1].norm() < 1e-10);
/// # Ok::<(), sphvar_sht::Error>(())
/// ```
pub struct DenseRingTransform {
    arch: Arch,
    rings: RingTransform,
    torus: Torus<f64>,
    places: Vec<Place>,
}

/// The values of functions on the rings of a [`DenseRingTransform`].
pub trait MirroredRings: Sync {
    /// Adds the values of the orders `first..first + RingSums::ORDERS` on every pair of rings to
    /// `sums`; `first` is a multiple of [`RingSums::ORDERS`]. Values of orders beyond lmax are
    /// ignored. `FUSED` is true where the processor has fused multiply-adds.
    ///
    /// Rings that are close to each other should follow each other.
    fn add<const FUSED: bool>(&self, first: usize, sums: &mut RingSums<'_>);
}

/// Sums of the values on rings.
#[derive(Debug)]
pub struct RingSums<'a> {
    places: &'a [Place],
    first: usize,
    grid: &'a mut Grid,
}

/// The number of cells of the window.
const WIDTH: usize = 16;

/// Number of rows of the grid beyond a pole or the equator.
const MARGIN: usize = WIDTH / 2;

/// A row of the grid: the orders of the northern rings and those of the southern ones.
type Row = [f64; 4 * ORDERS];

/// A ring and its reflection.
#[derive(Clone, Debug)]
struct Place {
    /// The first row that its window reaches, counted from `MARGIN` rows beyond the pole.
    first: usize,
    /// The highest order that is not negligible.
    last_order: f64,
    window: [f64; WIDTH],
}

/// The grid from the north pole to the equator, of the northern rings and of the reflections of the
/// southern ones.
#[derive(Debug, Default)]
struct Grid {
    /// The sums of the last `short` rings, in the rows `from..to`.
    recent: Vec<Row>,
    short: usize,
    from: usize,
    to: usize,
    sums: Vec<Row>,
    rests: Vec<Row>,
}

impl fmt::Debug for DenseRingTransform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DenseRingTransform")
            .field("lmax", &self.rings.lmax())
            .field("pairs", &self.places.len())
            .finish_non_exhaustive()
    }
}

impl DenseRingTransform {
    /// Returns the plan for degree `lmax`, inclusive, and the rings at `colatitudes`, each together
    /// with its reflection at the equator.
    ///
    /// # Errors
    ///
    /// [`Error::DegreeTooLarge`] if `lmax` exceeds the limit of the coefficient index.
    ///
    /// # Panics
    ///
    /// Panics if a colatitude is NaN or south of the equator.
    pub fn new(
        lmax: usize,
        colatitudes: impl IntoIterator<Item = Colatitude>,
    ) -> Result<Self, Error> {
        Self::with_arch(lmax, colatitudes, Arch::new())
    }

    fn with_arch(
        lmax: usize,
        colatitudes: impl IntoIterator<Item = Colatitude>,
        arch: Arch,
    ) -> Result<Self, Error> {
        let rings = RingTransform::new(lmax)?;
        let design = Design::finest();
        debug_assert_eq!(design.window.width(), WIDTH, "the width of the places");
        let torus = Torus::new(lmax, design);
        let cells = torus.n_theta() as f64 / TAU;
        let places = colatitudes.into_iter().map(|colatitude| {
            let theta = colatitude.sin().atan2(colatitude.cos());
            assert!(theta < 0.5 * PI + 1e-15, "a northern ring, not one at {theta}");
            let x = theta * cells + MARGIN as f64;
            let start = (x - MARGIN as f64).ceil();
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a row")]
            let first = start as usize;
            let window = std::array::from_fn(|i| design.window.value(x - start - i as f64));
            Place { first, last_order: last_order(colatitude, lmax), window }
        });
        let places = places.collect();
        Ok(Self { arch, rings, torus, places })
    }

    /// Returns the maximum degree, inclusive.
    #[must_use]
    pub fn lmax(&self) -> usize {
        self.rings.lmax()
    }

    /// Returns the highest order whose functions up to lmax are not negligible on a pair of rings.
    #[must_use]
    pub fn last_order(&self, ring: usize) -> f64 {
        self.places[ring].last_order
    }

    /// Returns the coefficients of the values of `source`. Uses the threads of the current pool of
    /// rayon; the result does not depend on their number.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfMemory`] if allocation of the coefficients fails.
    pub fn adjoint<R: MirroredRings>(&self, source: &R) -> Result<Alm, Error> {
        let lmax = self.lmax();
        let mut alm = Alm::zeros(lmax)?;
        let mut workers: Vec<Worker> = Vec::new();
        Threads::Pool.resize(&mut workers);
        for worker in &mut workers {
            worker.rings.load_torus(&self.rings, &self.torus);
        }
        // Coefficients of an order are contiguous and follow those of the order before.
        let mut rest = alm.values_mut();
        let blocks = (0..=lmax).step_by(ORDERS).map(|first| {
            let orders = first..(first + ORDERS).min(lmax + 1);
            let columns = orders.clone().map(|m| rest.split_off_mut(..lmax + 1 - m));
            (orders, columns.map(Option::unwrap_or_default).collect::<Vec<_>>())
        });
        let n_rings = self.torus.n_ring_rows();
        Threads::Pool.enter(|| {
            share(&mut workers, blocks, |worker, (orders, columns)| {
                self.sum_orders(source, orders.start, worker);
                let Worker { rings, terms, .. } = worker;
                let terms = terms.chunks_exact(n_rings);
                for ((m, column), terms) in orders.zip(columns).zip(terms) {
                    rings.adjoint(&self.rings, m, terms, &mut [column]);
                }
            });
        });
        Ok(alm)
    }

    /// Computes the terms of a block of orders on the Clenshaw-Curtis rings.
    fn sum_orders<R: MirroredRings>(&self, source: &R, first: usize, worker: &mut Worker) {
        let Worker { grid, rows, terms, scratch, .. } = worker;
        rows.clear();
        rows.resize(self.torus.n_rows().next_multiple_of(ROWS), [Complex::ZERO; ORDERS]);
        terms.resize(self.torus.n_ring_rows() * ORDERS, Complex::ZERO);
        self.arch.dispatch(AddRings { transform: self, first, source, grid });
        grid.write(&mut rows[..self.torus.n_rows()]);
        self.analyse(rows, terms, scratch);
    }

    /// Computes terms from the rows of a grid. Not generic, so that it is compiled once and not in
    /// every crate that has rings.
    fn analyse(
        &self,
        rows: &[[Complex<f64>; ORDERS]],
        terms: &mut [Complex<f64>],
        scratch: &mut TorusScratch<f64>,
    ) {
        let layout = Layout { stride: 0, margin: 0 };
        self.torus.run(self.arch, layout, Stage::AnalyseBlock { spectra: rows, terms }, scratch);
    }

    /// Returns the number of rows of a grid, which reaches from `MARGIN` beyond the pole to
    /// `MARGIN` beyond the equator.
    fn n_rows(&self) -> usize {
        self.torus.n_theta() / 4 + 1 + 2 * MARGIN
    }
}

/// The workspace of a thread.
#[derive(Default)]
struct Worker {
    rings: RingWorker,
    grid: Grid,
    /// The grid in the order of the torus.
    rows: Vec<[Complex<f64>; ORDERS]>,
    /// Indexed by order and ring.
    terms: Vec<Complex<f64>>,
    scratch: TorusScratch<f64>,
}

struct AddRings<'a, R> {
    transform: &'a DenseRingTransform,
    first: usize,
    source: &'a R,
    grid: &'a mut Grid,
}

impl<R: MirroredRings> WithSimd for AddRings<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { transform, first, source, grid } = self;
        grid.clear(transform.n_rows());
        let mut sums = RingSums { places: &transform.places, first, grid };
        if S::F64_LANES > 1 {
            source.add::<true>(first, &mut sums);
        } else {
            source.add::<false>(first, &mut sums);
        }
        sums.grid.flush();
    }
}

impl RingSums<'_> {
    /// Number of orders that are processed together.
    pub const ORDERS: usize = ORDERS;

    /// Returns whether all of the present orders are negligible on a pair of rings.
    #[inline(always)]
    pub fn is_negligible(&self, ring: usize) -> bool {
        (self.first as f64) > self.places[ring].last_order
    }

    /// Adds the values of the northern and of the southern ring of a pair.
    #[inline(always)]
    pub fn add<const FUSED: bool>(&mut self, ring: usize, values: &[[Complex<f64>; ORDERS]; 2]) {
        let Place { first, window, .. } = &self.places[ring];
        let mut terms: Row = [0.0; 4 * ORDERS];
        for (terms, value) in terms.as_chunks_mut::<2>().0.iter_mut().zip(values.as_flattened()) {
            *terms = [value.re, value.im];
        }
        let rows = self.grid.recent(*first);
        for (row, &factor) in rows.iter_mut().zip(window) {
            for (sum, &term) in row.iter_mut().zip(&terms) {
                *sum = if FUSED { f64::mul_add(term, factor, *sum) } else { *sum + term * factor };
            }
        }
    }
}

impl Grid {
    fn clear(&mut self, n_rows: usize) {
        for rows in [&mut self.recent, &mut self.sums, &mut self.rests] {
            rows.clear();
            rows.resize(n_rows, [0.0; 4 * ORDERS]);
        }
        (self.short, self.from, self.to) = (0, n_rows, 0);
    }

    /// Returns the rows from `first` on for one more term. In one long sum all rounding errors can
    /// have the same sign.
    #[inline(always)]
    fn recent(&mut self, first: usize) -> &mut [Row] {
        if self.short == SHORT {
            self.flush();
        }
        self.short += 1;
        self.from = self.from.min(first);
        self.to = self.to.max(first + WIDTH);
        &mut self.recent[first..first + WIDTH]
    }

    #[inline(always)]
    fn flush(&mut self) {
        if self.from < self.to {
            let rows = self.from..self.to;
            let recent = &mut self.recent[rows.clone()];
            let (sums, rests) = (&mut self.sums[rows.clone()], &mut self.rests[rows]);
            add_with_rests(
                sums.as_flattened_mut(),
                rests.as_flattened_mut(),
                recent.as_flattened(),
            );
            recent.fill([0.0; 4 * ORDERS]);
        }
        (self.short, self.from, self.to) = (0, self.sums.len(), 0);
    }

    /// Adds the values to every row of a torus from pole to pole.
    fn write(&mut self, out: &mut [[Complex<f64>; ORDERS]]) {
        for (sums, rests) in self.sums.iter_mut().zip(&self.rests) {
            for (sum, rest) in sums.iter_mut().zip(rests) {
                *sum += rest;
            }
        }
        let last = out.len() - 1;
        for (i, row) in self.sums.iter().enumerate() {
            // A row beyond the pole is its reflection at it, half a turn further.
            let (at, sign) = match i.checked_sub(MARGIN) {
                Some(at) => (at, 1.0),
                None => (MARGIN - i, -1.0),
            };
            let (north, south) = row.split_at(2 * ORDERS);
            for (at, values) in [(at, north), (last - at, south)] {
                for (j, value) in values.as_chunks::<2>().0.iter().enumerate() {
                    let sign = if j % 2 == 1 { sign } else { 1.0 };
                    out[at][j] += Complex::new(value[0], value[1]) * sign;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RingWorkspace;

    /// Values on the rings of a transform, northern and southern ones by order and ring.
    struct Values<'a> {
        n_rings: usize,
        values: &'a [[Vec<Complex<f64>>; 2]],
    }

    impl MirroredRings for Values<'_> {
        fn add<const FUSED: bool>(&self, first: usize, sums: &mut RingSums<'_>) {
            for ring in 0..self.n_rings {
                let value = |side: usize, i: usize| {
                    self.values.get(first + i).map_or(Complex::ZERO, |order| order[side][ring])
                };
                let values = [0, 1].map(|side| std::array::from_fn(|i| value(side, i)));
                if !sums.is_negligible(ring) {
                    sums.add::<FUSED>(ring, &values);
                }
            }
        }
    }

    fn noise() -> impl FnMut() -> f64 {
        let mut state = 1_u64;
        move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 * 2f64.powi(-52) - 1.0
        }
    }

    #[test]
    fn coefficients_are_those_of_all_rings() {
        let mut next = noise();
        let mut sets: Vec<(&str, Vec<f64>)> = vec![
            ("none", vec![]),
            ("poles and equator", vec![0.0, 1e-300, 1e-12, 0.5 * PI]),
            ("one place", vec![1.1; 3000]),
            ("dense", (0..400).map(|i| 0.5 * PI * f64::from(i) / 399.0).collect()),
        ];
        sets.push(("random", (0..100).map(|_| 0.25 * PI * (1.0 + next())).collect()));
        for (name, thetas) in &sets {
            for lmax in [0, 1, 7, 8, 40, 131] {
                for arch in [Arch::new(), Arch::Scalar] {
                    let theta = |&theta: &f64| Colatitude::from_theta(theta).unwrap();
                    let north: Vec<_> = thetas.iter().map(theta).collect();
                    let south = north.iter().map(|c| {
                        Colatitude::from_direction(glam::DVec3::new(c.sin(), 0.0, -c.cos()))
                    });
                    let mut column = || -> Vec<Complex<f64>> {
                        north.iter().map(|_| Complex::new(1.0 + next(), next())).collect()
                    };
                    let values: Vec<_> = (0..=lmax).map(|_| [column(), column()]).collect();
                    let mut expected = Alm::zeros(lmax).unwrap();
                    RingTransform::new(lmax).unwrap().adjoint_into(
                        north.iter().copied().chain(south),
                        |m, out| out.copy_from_slice(&values[m].concat()),
                        &mut RingWorkspace::default(),
                        &mut expected,
                    );
                    let plan =
                        DenseRingTransform::with_arch(lmax, north.iter().copied(), arch).unwrap();
                    let got =
                        plan.adjoint(&Values { n_rings: north.len(), values: &values }).unwrap();
                    // A ring of value 1 has coefficients of size sqrt(lmax).
                    let size = (2 * north.len()) as f64 * (1.0 + lmax as f64).sqrt();
                    for (a, b) in expected.values().iter().zip(got.values()) {
                        let error = (a - b).norm();
                        assert!(error <= 1e-14 * size, "{name}, lmax {lmax}: {a} and {b}");
                    }
                }
            }
        }
    }
}
