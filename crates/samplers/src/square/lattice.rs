use crate::Error;
use crate::count::checked;

/// A lattice of the square: N points that are closed under addition modulo 1.
///
/// ```text
/// ( i/rows, j/columns + i skew/N  mod 1 ),   0 <= i < rows, 0 <= j < columns,   N = rows columns
/// ```
///
/// Every lattice that contains the integer vectors has exactly one such form with `skew < rows`,
/// the Hermite normal form of its generators. A regular grid has skew 0; the rank-1 lattice
/// `(j/N, j g/N)` has N rows, one column and skew g.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Lattice {
    rows: u32,
    columns: u32,
    skew: u32,
}

impl Lattice {
    /// Returns the regular grid of `rows` values of u and `columns` values of v.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless the product is from 1 to `u32::MAX`.
    pub fn grid(rows: usize, columns: usize) -> Result<Self, Error> {
        checked(rows.saturating_mul(columns))?;
        Ok(Self { rows: checked(rows)?, columns: checked(columns)?, skew: 0 })
    }

    /// Returns the rank-1 lattice `(j/N, j g/N mod 1)` of `n_points` points with the generator g,
    /// which is taken modulo N.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn rank_1(n_points: usize, generator: usize) -> Result<Self, Error> {
        let rows = checked(n_points)?;
        Ok(Self { rows, columns: 1, skew: checked(generator % n_points + 1)? - 1 })
    }

    /// Returns the lattice of this normal form; `skew` is below `rows`.
    pub(super) fn from_normal_form(rows: u32, columns: u32, skew: u32) -> Self {
        Self { rows, columns, skew }
    }

    /// Returns the index of the point with the coordinates `multiples/N`, below 1, if the lattice
    /// has it.
    pub(super) fn index_of(&self, multiples: [u32; 2]) -> Option<usize> {
        let [rows, columns, skew] = self.normal_form();
        let [u, v] = multiples.map(|k| k as usize);
        let n = self.n_points();
        let i = u / columns;
        let rest = (v + n - i * skew % n) % n;
        (u.is_multiple_of(columns) && rest.is_multiple_of(rows))
            .then_some(i * columns + rest / rows)
    }

    /// Returns the number of points.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.rows as usize * self.columns as usize
    }

    /// Returns the number of distinct values of u, the number of values of v that occur with each,
    /// and the skew.
    #[must_use]
    pub fn normal_form(&self) -> [usize; 3] {
        [self.rows, self.columns, self.skew].map(|n| n as usize)
    }

    /// Returns point `index`, `i columns + j` in the order of the definition; its coordinates are
    /// correctly rounded.
    #[must_use]
    pub fn point(&self, index: usize) -> [f64; 2] {
        let [rows, columns, skew] = self.normal_form();
        let (i, j) = (index / columns % rows, index % columns);
        let n = self.n_points();
        // Below N^2 < 2^64.
        let v = (i * skew + j * rows) % n;
        [i as f64 / rows as f64, v as f64 / n as f64]
    }

    /// Returns whether a frequency belongs to the dual lattice: whether `k . p` is an integer for
    /// every point p.
    #[must_use]
    pub fn is_dual(&self, frequency: [i32; 2]) -> bool {
        let [rows, columns, skew] = [self.rows, self.columns, self.skew].map(i128::from);
        let [k1, k2] = frequency.map(i128::from);
        k2 % columns == 0 && (k1 + k2 / columns * skew) % rows == 0
    }

    /// Returns how many points share a value of u, and how many share a value of v: the powers on
    /// the axes `(k, 0)` and `(0, k)` averaged over k.
    #[must_use]
    pub fn coordinate_multiplicities(&self) -> [usize; 2] {
        [self.columns as usize, gcd(self.rows, self.skew) as usize]
    }
}

/// Returns the greatest common divisor; that of n and 0 is n.
pub(super) fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::Lattice;

    fn lattices() -> impl Iterator<Item = Lattice> {
        let grids = (1..7).flat_map(|r| (1..7).map(move |c| Lattice::grid(r, c).unwrap()));
        let skewed = (1..7).flat_map(|rows| {
            (0..rows)
                .flat_map(move |skew| (1..5).map(move |columns| Lattice { rows, columns, skew }))
        });
        let ranks = (1..30).flat_map(|n| (0..n).map(move |g| Lattice::rank_1(n, g).unwrap()));
        grids.chain(skewed).chain(ranks)
    }

    /// The points are distinct and every sum of two is one of them, in exact integers `N p`.
    #[test]
    fn lattices_are_closed_under_addition() {
        for lattice in lattices() {
            let n = lattice.n_points();
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below N")]
            let scaled = |x: f64| (x * n as f64).round() as usize;
            let points: Vec<[usize; 2]> = (0..n).map(|j| lattice.point(j).map(scaled)).collect();
            for p in &points {
                assert_eq!(points.iter().filter(|q| *q == p).count(), 1, "{lattice:?}: {p:?}");
                for q in &points {
                    let sum = [0, 1].map(|d: usize| (p[d] + q[d]) % n);
                    assert!(points.contains(&sum), "{lattice:?}: {p:?} + {q:?}");
                }
            }
        }
    }

    /// The power is that of the definition, and its mean on the axes over a period is the number of
    /// points with equal coordinates.
    #[test]
    fn power_is_n_on_the_dual_lattice_and_0_elsewhere() {
        for lattice in lattices().filter(|lattice| lattice.n_points() < 20) {
            let n = lattice.n_points();
            let points: Vec<[f64; 2]> = (0..n).map(|j| lattice.point(j)).collect();
            let power = |k: [i32; 2]| {
                let angle = |p: &[f64; 2]| TAU * (f64::from(k[0]) * p[0] + f64::from(k[1]) * p[1]);
                let sums = points.iter().map(|p| angle(p).sin_cos());
                let (sin, cos) = sums.fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
                (sin * sin + cos * cos) / n as f64
            };
            for k1 in -9..=9 {
                for k2 in -9..=9 {
                    let expected = if lattice.is_dual([k1, k2]) { n as f64 } else { 0.0 };
                    let got = power([k1, k2]);
                    assert!((got - expected).abs() < 1e-10, "{lattice:?} at {k1}, {k2}: {got}");
                }
            }
            let period = i32::try_from(n).unwrap();
            for (axis, count) in lattice.coordinate_multiplicities().into_iter().enumerate() {
                let on_axis = |k: i32| if axis == 0 { [k, 0] } else { [0, k] };
                let sum: f64 = (0..period).map(|k| power(on_axis(k))).sum();
                assert!((sum / n as f64 - count as f64).abs() < 1e-10, "{lattice:?}, axis {axis}");
            }
        }
    }

    #[test]
    fn sizes_are_checked() {
        assert!(Lattice::grid(0, 3).is_err() && Lattice::grid(1 << 20, 1 << 20).is_err());
        assert!(Lattice::rank_1(1 << 33, 1).is_err());
        assert_eq!(Lattice::rank_1(7, 10), Lattice::rank_1(7, 3));
        // No overflow at the largest size.
        let n = u32::MAX as usize;
        let largest = Lattice::rank_1(n, n - 1).unwrap();
        let [u, v] = largest.point(n - 1).map(|x| x * n as f64);
        assert!((u - (n - 1) as f64).abs() + (v - 1.0).abs() < 1e-6, "{u}, {v}");
    }
}
