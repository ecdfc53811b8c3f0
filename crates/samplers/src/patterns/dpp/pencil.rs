use glam::DVec2;
use num_complex::Complex64;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Gamma, StandardNormal};

/// The entries of `B` and of `A` at one position: `x` is of `B`, `y` of `A`. Rotations apply to both
/// matrices, so a processor with vectors of two numbers rotates both at once.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Entry {
    re: DVec2,
    im: DVec2,
}

/// A pencil `B - lambda A` of an upper Hessenberg matrix `B` and an upper triangular matrix `A`.
///
/// The columns are packed: column j has the rows 0 to j + 1, the last one without a counterpart in
/// the matrices.
#[derive(Debug)]
pub(super) struct Pencil {
    size: usize,
    entries: Vec<Entry>,
}

/// A unitary 2 x 2 matrix `[c, s; -conj(s), c]` with real c.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rotation {
    c: f64,
    s: Complex64,
}

impl Entry {
    pub(super) fn b(self) -> Complex64 {
        Complex64::new(self.re.x, self.im.x)
    }

    pub(super) fn a(self) -> Complex64 {
        Complex64::new(self.re.y, self.im.y)
    }

    fn of(b: Complex64, a: Complex64) -> Self {
        Self { re: DVec2::new(b.re, a.re), im: DVec2::new(b.im, a.im) }
    }

    pub(super) fn set_b(&mut self, b: Complex64) {
        (self.re.x, self.im.x) = (b.re, b.im);
    }

    pub(super) fn set_a(&mut self, a: Complex64) {
        (self.re.y, self.im.y) = (a.re, a.im);
    }
}

impl Pencil {
    /// Returns the number of entries of a pencil of `size` rows.
    pub(super) fn n_entries(size: usize) -> usize {
        // N(N + 3)/2, where one of the factors is even.
        let next = size.saturating_add(3);
        let (even, odd) = if size.is_multiple_of(2) { (size, next) } else { (next, size) };
        (even / 2).saturating_mul(odd)
    }

    /// Returns the form to which unitary transformations reduce a pencil of two independent
    /// matrices of independent complex normal entries of variance 1, drawn directly. The
    /// generalized eigenvalues have the same distribution.
    ///
    /// With `gamma_k` for the root of a number of the gamma distribution of shape k and scale 1,
    /// all entries are independent:
    ///
    /// ```text
    /// A_11 = gamma_N,   A_kk = gamma_{k-1} for k >= 2,   A_jk normal for j < k
    /// B_{k+1,k} = gamma_{N-k},                           B_jk normal for j <= k
    /// ```
    ///
    /// Proof: bases `u_1, u_2, ...` of the left and `v_1, v_2, ...` of the right space are chosen in
    /// turn, the left one along the part of `B v_k` that is orthogonal to `u_1 .. u_k`, the right one
    /// as the vector orthogonal to `v_1 .. v_k` that the rows of A beyond k + 1 map to 0. `B v_k` is
    /// independent of all earlier choices, so its component along `u_{k+1}` is the length of a
    /// normal vector of N - k components. The null vector of the remaining (N - k - 1) x (N - k)
    /// block of A is independent of the other rows; what the block is on the complement of that
    /// vector has the density of normal entries times `|det|^2`, since that is the volume of the
    /// blocks with one null vector. Each step adds such a factor to the next block, so that
    /// `|A_kk|^2` has the density `x^{k-2} e^{-x}`.
    ///
    /// `entries` is the memory of the pencil, at least [`Self::n_entries`] long.
    pub(super) fn spherical(size: usize, mut entries: Vec<Entry>, rng: &mut ChaCha8Rng) -> Self {
        entries.clear();
        for k in 0..size {
            entries.extend((0..k).map(|_| Entry::of(normal(rng), normal(rng))));
            let a = if k == 0 { size } else { k };
            entries.push(Entry::of(normal(rng), root_of_gamma(a, rng).into()));
            // The row below the last is not part of the matrix.
            let below = if k + 1 < size { root_of_gamma(size - k - 1, rng) } else { 0.0 };
            entries.push(Entry::of(below.into(), Complex64::ZERO));
        }
        Self { size, entries }
    }

    pub(super) fn size(&self) -> usize {
        self.size
    }

    fn start(column: usize) -> usize {
        column * (column + 3) / 2
    }

    pub(super) fn at(&self, row: usize, column: usize) -> Entry {
        self.entries[Self::start(column) + row]
    }

    pub(super) fn at_mut(&mut self, row: usize, column: usize) -> &mut Entry {
        &mut self.entries[Self::start(column) + row]
    }

    /// Returns the rows 0 to column + 1 of a column.
    pub(super) fn column_mut(&mut self, column: usize) -> &mut [Entry] {
        &mut self.entries[Self::start(column)..Self::start(column + 1)]
    }

    /// Returns the rows 0 to column + 1 of `W` columns from `column`.
    pub(super) fn some_columns_mut<const W: usize>(&mut self, column: usize) -> [&mut [Entry]; W] {
        let mut rest = &mut self.entries[Self::start(column)..];
        std::array::from_fn(|k| {
            let (rows, others) = std::mem::take(&mut rest).split_at_mut(column + k + 2);
            rest = others;
            rows
        })
    }

    /// Returns the rows `from` to `to` of a column and of the next one.
    pub(super) fn columns_mut(
        &mut self,
        column: usize,
        from: usize,
        to: usize,
    ) -> (&mut [Entry], &mut [Entry]) {
        let next = Self::start(column + 1);
        let (left, right) = self.entries.split_at_mut(next);
        (&mut left[Self::start(column)..][from..=to], &mut right[from..=to])
    }
}

impl Rotation {
    /// Returns the rotation that maps `(a, b)` to `(r, 0)`.
    pub(super) fn annihilating(a: Complex64, b: Complex64) -> Self {
        let (a_norm, b_norm) = (a.norm(), b.norm());
        let norm = a_norm.hypot(b_norm);
        if norm == 0.0 || b_norm == 0.0 {
            return Self { c: 1.0, s: Complex64::ZERO };
        }
        if a_norm == 0.0 {
            return Self { c: 0.0, s: b.conj() / b_norm };
        }
        Self { c: a_norm / norm, s: (a / a_norm) * (b.conj() / norm) }
    }

    /// Returns the rotation of `(x, y)`.
    #[inline]
    pub(super) fn apply(self, x: Entry, y: Entry) -> (Entry, Entry) {
        let Self { c, s } = self;
        let first = Entry {
            re: c * x.re + s.re * y.re - s.im * y.im,
            im: c * x.im + s.re * y.im + s.im * y.re,
        };
        let second = Entry {
            re: c * y.re - s.re * x.re - s.im * x.im,
            im: c * y.im - s.re * x.im + s.im * x.re,
        };
        (first, second)
    }

    pub(super) fn apply_to_pair(self, x: Complex64, y: Complex64) -> (Complex64, Complex64) {
        (self.c * x + self.s * y, self.c * y - self.s.conj() * x)
    }
}

/// Returns a complex normal number of variance 1.
fn normal(rng: &mut ChaCha8Rng) -> Complex64 {
    let part = |rng: &mut ChaCha8Rng| -> f64 { StandardNormal.sample(rng) };
    std::f64::consts::FRAC_1_SQRT_2 * Complex64::new(part(rng), part(rng))
}

/// Returns the root of a number of the gamma distribution, the length of a vector of `shape`
/// complex normal components.
fn root_of_gamma(shape: usize, rng: &mut ChaCha8Rng) -> f64 {
    // A positive shape is valid.
    Gamma::new(shape as f64, 1.0).map_or(0.0, |gamma| gamma.sample(rng)).sqrt()
}
