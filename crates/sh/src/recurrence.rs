use core::ops::{Range, RangeInclusive};

use pulp::Arch;

use crate::{Colatitude, Scaled, lanes::Blocks, sectoral::sectoral_function};

/// Coefficients of the step from `l` to `l + 1` at fixed order; see [`Recurrence`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// `g`, the factor of `L`.
    pub growth: f64,
    /// `g r`, the factor of `D`.
    pub damping: f64,
    /// `g (1 + r)`, the factor of `(1 - x) L`.
    pub forcing: f64,
}

impl Step {
    /// Returns the step from `l` to `l + 1` at order `m`.
    ///
    /// Precondition: `m <= l`, both at most [`MAX_DEGREE`](crate::MAX_DEGREE) for full accuracy.
    /// The cost is two divisions and a square root.
    #[must_use]
    #[inline]
    pub fn new(l: usize, m: usize) -> Self {
        let (l, m) = (l as f64, m as f64);
        let n = l - m;
        // Both products are exact integers, so g has one rounding of the quotient, halved by the
        // root, and one of the root.
        let growth = (((2.0 * l + 3.0) * (l + m + 1.0)) / ((2.0 * l + 1.0) * (n + 1.0))).sqrt();
        let r = n / (l + m + 1.0);
        Self { growth, damping: growth * r, forcing: growth * (1.0 + r) }
    }
}

/// Recurrence coefficients of one order `m` for evaluation at many colatitudes.
///
/// With `x = cos theta`, `n = l - m`:
///
/// ```text
/// r = n / (n + 2m + 1),   g = sqrt((2l + 3)/(2l + 1) (l + 1 + m)/(l + 1 - m))
/// D_{l+1} = g r D_l - g (1 + r) (1 - x) L_l,     D_m = 0
/// L_{l+1} = g L_l + D_{l+1},                     L_m = lambda_mm
/// ```
///
/// and `L_l = lambda_lm`. This is the three-term recurrence of the Gegenbauer polynomials
/// normalized to 1 at `x = 1`, `(n + 2m + 1) q_{n+1} = (2n + 2m + 1) x q_n - n q_{n-1}`, written
/// for the differences `q_{n+1} - q_n`. The recurrence depends on `1 - x`, which a [`Colatitude`]
/// represents with full relative accuracy; the form with `x` loses a factor `1/sin theta` at the
/// poles. Errors grow in proportion to the number of steps, at every colatitude.
///
/// [`degree_into`](Self::degree_into), [`table_into`](Self::table_into) and
/// [`for_each_block`](Self::for_each_block) evaluate lists of colatitudes in the registers of the
/// processor: the largest degree only, all degrees, or a range of degrees. A loop of one's own over
/// many points with one `(L, D)` pair per point must store a scale for points whose
/// [`sectoral_function`] is below the range of `f64`: `L` and `D` scale together, and `|L|` grows
/// with `l` until it is of order one.
///
/// A recurrence uses 24 bytes per degree. An empty one (`default()`) can be filled with
/// [`fill`](Self::fill).
///
/// # Examples
///
/// ```
/// use sphvar_sh::{Colatitude, Recurrence, lambda, sectoral_function};
///
/// let c = Colatitude::from_theta(0.3)?;
/// let recurrence = Recurrence::new(2, 10);
/// let (mut value, mut difference) = (sectoral_function(2, c).value(), 0.0);
/// for (l, step) in (2..).zip(recurrence.steps()) {
///     assert_eq!(value, lambda(l, 2, c));
///     difference = step.damping * difference - step.forcing * (c.versine() * value);
///     value = step.growth * value + difference;
/// }
/// # Ok::<(), sphvar_sh::Error>(())
/// ```
///
/// # References
///
/// Gentleman 1969, doi:10.1093/comjnl/12.2.160: Reinsch's modification of Clenshaw's algorithm,
/// which uses differences, here in the forward direction. DLMF 18.9.1: Gegenbauer polynomials.
#[derive(Debug, Clone, Default)]
pub struct Recurrence {
    m: usize,
    steps: Vec<Step>,
}

impl Recurrence {
    /// Returns the coefficients of order `m` for the degrees `m..=lmax`.
    ///
    /// Empty if `m > lmax`.
    ///
    /// # Panics
    ///
    /// Panics if allocation fails.
    #[must_use]
    pub fn new(m: usize, lmax: usize) -> Self {
        let mut recurrence = Self::default();
        recurrence.fill(m, lmax);
        recurrence
    }

    /// Replaces the coefficients by those of another order, reusing the memory.
    ///
    /// # Panics
    ///
    /// Panics if allocation fails.
    pub fn fill(&mut self, m: usize, lmax: usize) {
        self.m = m;
        self.steps.clear();
        self.steps.extend((m..=lmax).map(|l| Step::new(l, m)));
    }

    /// Returns the order `m`.
    #[must_use]
    pub const fn order(&self) -> usize {
        self.m
    }

    /// Returns one step for each degree `l = m..=lmax`; entry `l - m` advances from `l` to `l + 1`.
    ///
    /// The last step goes beyond `lmax`, so that a loop that reads the value of a degree and then
    /// steps needs no special case for it.
    #[must_use]
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Writes `lambda_lm` for `l = m..=lmax` to `out`, bit-identical to [`lambda`](crate::lambda).
    ///
    /// The cost is `O(lmax - m)`, without the divisions and roots of
    /// [`LegendrePlan::column_into`](crate::LegendrePlan::column_into).
    ///
    /// # Panics
    ///
    /// Panics if `out` does not have one entry per degree.
    pub fn column_into(&self, colatitude: Colatitude, out: &mut [f64]) {
        assert_eq!(out.len(), self.steps.len(), "a column has one entry per degree");
        let start = sectoral_function(self.m, colatitude);
        fill_column(start, self.steps.iter().copied(), colatitude, out);
    }

    /// Writes `lambda_lm` at a list of colatitudes to `out`, one value per colatitude.
    ///
    /// The values equal those of [`lambda`](crate::lambda).
    ///
    /// # Panics
    ///
    /// Panics if `l` is not in `m..=lmax` or `out` does not have one entry per colatitude.
    ///
    /// # Performance
    ///
    /// See [`for_each_block`](Self::for_each_block); lower degrees are not stored.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_sh::{Colatitude, Recurrence, lambda};
    ///
    /// let rings = [0.1, 0.8, 3.0].map(|theta| Colatitude::from_theta(theta).unwrap());
    /// let mut values = [0.0; 3];
    /// Recurrence::new(500, 1000).degree_into(1000, &rings, &mut values);
    /// assert_eq!(values, rings.map(|ring| lambda(1000, 500, ring)));
    /// ```
    pub fn degree_into(&self, l: usize, colatitudes: &[Colatitude], out: &mut [f64]) {
        assert_eq!(out.len(), colatitudes.len(), "a degree has one entry per colatitude");
        self.for_each_block(l..=l, colatitudes, |_, range, values| {
            out[range].copy_from_slice(values);
        });
    }

    /// Writes `lambda_lm` for `l = m..=lmax` at a list of colatitudes to `out`, one row per degree:
    /// colatitude `i` has entry `(l - m) colatitudes.len() + i`.
    ///
    /// The values equal those of [`lambda`](crate::lambda). An empty recurrence has no rows.
    ///
    /// # Panics
    ///
    /// Panics if `out` does not have one entry per degree and colatitude.
    ///
    /// # Performance
    ///
    /// See [`for_each_block`](Self::for_each_block), which needs no table. Writing a table that
    /// exceeds the caches takes longer than the computation.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_sh::{Colatitude, Recurrence, lambda};
    ///
    /// let rings = [0.1, 0.8, 3.0].map(|theta| Colatitude::from_theta(theta).unwrap());
    /// let mut recurrence = Recurrence::default();
    /// let mut table = Vec::new();
    /// for m in 0..=20 {
    ///     recurrence.fill(m, 20);
    ///     table.resize((20 - m + 1) * rings.len(), 0.0);
    ///     recurrence.table_into(&rings, &mut table);
    ///     for (l, row) in (m..).zip(table.chunks_exact(rings.len())) {
    ///         assert_eq!(row, rings.map(|ring| lambda(l, m, ring)));
    ///     }
    /// }
    /// ```
    pub fn table_into(&self, colatitudes: &[Colatitude], out: &mut [f64]) {
        let (n, rows) = (colatitudes.len(), self.steps.len());
        assert_eq!(out.len(), rows * n, "a table has one entry per degree and colatitude");
        let Some(last) = rows.checked_sub(1) else {
            return;
        };
        self.for_each_block(self.m..=self.m + last, colatitudes, |l, range, values| {
            copy_short(values, &mut out[(l - self.m) * n..][range]);
        });
    }

    /// Calls `visit(l, range, values)` for every degree `l` in `degrees` and every block of
    /// consecutive colatitudes, where `values[i]` is `lambda_lm` at `colatitudes[range.start + i]`.
    ///
    /// All degrees of a block, in ascending order, precede those of the next. A block has 48
    /// colatitudes, the last one of a list up to 48. The values equal those of
    /// [`lambda`](crate::lambda), which is the same on every processor.
    ///
    /// # Panics
    ///
    /// Panics if a degree is not in `m..=lmax`.
    ///
    /// # Performance
    ///
    /// `O((l - m + log m) n)` for `n` colatitudes and the largest degree `l`; no allocation. The
    /// recurrence runs in the registers of the processor, one colatitude per lane, more than 10
    /// times as fast as [`column_into`](Self::column_into): with AVX2 a degree takes 0.25 ns per
    /// colatitude, and 0.2 ns more if it is visited. A list of a few colatitudes takes as long as
    /// one of 24.
    ///
    /// # Examples
    ///
    /// The integral of `lambda_lm^2` over the sphere is 1, by Gauss-Legendre quadrature:
    ///
    /// ```
    /// use std::f64::consts::TAU;
    ///
    /// use sphvar_sh::{Colatitude, GaussLegendre, Recurrence};
    ///
    /// let (m, lmax) = (40, 100);
    /// let rule = GaussLegendre::new(lmax + 1)?;
    /// let rings: Vec<_> = (rule.nodes().iter())
    ///     .map(|x| Colatitude::from_theta(x.acos()))
    ///     .collect::<Result<_, _>>()?;
    /// let mut norms = vec![0.0; lmax + 1 - m];
    /// Recurrence::new(m, lmax).for_each_block(m..=lmax, &rings, |l, range, values| {
    ///     for (value, weight) in values.iter().zip(&rule.weights()[range]) {
    ///         norms[l - m] += TAU * weight * value * value;
    ///     }
    /// });
    /// assert!(norms.iter().all(|norm| (norm - 1.0).abs() < 1e-12));
    /// # Ok::<(), sphvar_sh::Error>(())
    /// ```
    pub fn for_each_block(
        &self,
        degrees: RangeInclusive<usize>,
        colatitudes: &[Colatitude],
        visit: impl FnMut(usize, Range<usize>, &[f64]),
    ) {
        if degrees.is_empty() {
            return;
        }
        let first = degrees.start().checked_sub(self.m);
        let last = degrees.end().checked_sub(self.m).filter(|&last| last < self.steps.len());
        let (Some(first), Some(last)) = (first, last) else {
            panic!(
                "degrees {degrees:?} are not among the {} of order {} from {} on",
                self.steps.len(),
                self.m,
                self.m
            );
        };
        let visited = first..last + 1;
        Arch::new().dispatch(Blocks { recurrence: self, visited, colatitudes, visit });
    }
}

/// Copies slices of equal length without a call.
#[inline(always)]
fn copy_short(from: &[f64], to: &mut [f64]) {
    let ((from, from_rest), (to, to_rest)) = (from.as_chunks::<16>(), to.as_chunks_mut::<16>());
    for (from, to) in from.iter().zip(to) {
        *to = *from;
    }
    for (from, to) in from_rest.iter().zip(to_rest) {
        *to = *from;
    }
}

/// Binary digits of one scaling of a [`State`].
const BLOCK: i64 = 512;
/// `2^-BLOCK`.
pub(crate) const BLOCK_FACTOR: f64 = f64::from_bits((1023 - BLOCK.cast_unsigned()) << 52);

/// The state of the recurrence: `lambda_lm = value * 2^(-BLOCK blocks)`, and the difference in the
/// same scale.
///
/// `blocks` only decreases. While it is positive the value is kept below 1 by extracting factors of
/// `2^BLOCK`, which is exact. A value of at least about `2^-BLOCK` leaves enough range for the
/// difference, which is negligible where it underflows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct State {
    pub(crate) value: f64,
    difference: f64,
    pub(crate) blocks: i64,
}

impl State {
    /// Returns the state at `l = m` for `lambda_mm = start`.
    #[inline]
    pub(crate) fn start(start: Scaled) -> Self {
        let blocks = (start.exponent.min(0).unsigned_abs() / BLOCK.unsigned_abs()).cast_signed();
        let value = Scaled { exponent: start.exponent + BLOCK * blocks, ..start }.value();
        Self { value, difference: 0.0, blocks }
    }

    /// Advances from `l` to `l + 1`.
    #[inline]
    pub(crate) fn advance(&mut self, step: Step, versine: f64) {
        self.difference = step.damping * self.difference - step.forcing * (versine * self.value);
        self.value = step.growth * self.value + self.difference;
        if self.blocks > 0 && self.value.abs() > 1.0 {
            self.value *= BLOCK_FACTOR;
            self.difference *= BLOCK_FACTOR;
            self.blocks -= 1;
        }
    }

    /// Returns the current `lambda_lm` with its full exponent.
    #[inline]
    pub(crate) fn scaled(self) -> Scaled {
        Scaled::new(self.value, -BLOCK * self.blocks)
    }

    /// Returns the current `lambda_lm`, equal to `scaled().value()`.
    #[inline]
    pub(crate) fn value(self) -> f64 {
        match self.blocks {
            0 => self.value,
            1 => self.value * BLOCK_FACTOR,
            // The first product is exact unless the second one underflows to zero.
            2 => self.value * BLOCK_FACTOR * BLOCK_FACTOR,
            _ => 0.0,
        }
    }
}

/// Writes one column: `out[0]` is `start = lambda_mm`, and each entry is one step further.
#[inline]
pub(crate) fn fill_column(
    start: Scaled,
    steps: impl Iterator<Item = Step>,
    colatitude: Colatitude,
    out: &mut [f64],
) {
    let Some((first, rest)) = out.split_first_mut() else {
        return;
    };
    let mut state = State::start(start);
    *first = state.value();
    for (slot, step) in rest.iter_mut().zip(steps) {
        state.advance(step, colatitude.versine());
        *slot = state.value();
    }
    if colatitude.is_south() {
        // Entry n has l + m = n + 2m.
        for odd in out.iter_mut().skip(1).step_by(2) {
            *odd = -*odd;
        }
    }
}
