use num_complex::Complex64;

use super::pencil::{Pencil, Rotation};
use crate::Stopped;

/// A generalized eigenvalue `b/a`; a is 0 for an infinite one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ratio {
    pub(super) b: Complex64,
    pub(super) a: Complex64,
}

/// Entries that are rotated between two ticks: about a millisecond.
const ENTRIES_PER_TICK: usize = 1 << 18;

/// Columns whose rows are rotated in one pass. A rotation needs the result of the previous one in the
/// same column, so the processor works on several columns at once.
const TOGETHER: usize = 4;

/// Sweeps after which a shift is replaced by an arbitrary one, and per eigenvalue at most.
const SWEEPS_BEFORE_EXCEPTION: usize = 10;
const MAX_SWEEPS: usize = 30;

/// The reason why eigenvalues are missing.
#[derive(Clone, Copy, Debug)]
pub(super) enum Failure {
    Stopped(Stopped),
    NoConvergence,
}

impl From<Stopped> for Failure {
    fn from(stopped: Stopped) -> Self {
        Self::Stopped(stopped)
    }
}

/// Calls `each` with the generalized eigenvalues of a pencil, whose content is lost; `tick` is called
/// with the number of rotated entries, in total about [`expected_entries`].
///
/// The QZ algorithm of Moler and Stewart 1973 with single complex shifts, which is backward stable:
/// the ratios are those of a pencil whose entries differ by rounding, also where A is nearly
/// singular. Only the block that is not yet triangular is transformed, since no vectors are needed.
/// A sweep visits the columns once, from left to right: each receives all rotations of rows, and is
/// then rotated with the previous column.
pub(super) fn eigenvalues(
    pencil: &mut Pencil,
    tick: &dyn Fn(usize) -> Result<(), Stopped>,
    mut each: impl FnMut(Ratio),
) -> Result<(), Failure> {
    let mut rotations = Vec::with_capacity(pencil.size());
    let mut sweeps = 0;
    let mut left = pencil.size();
    while left > 0 {
        let last = left - 1;
        let first = first_of_block(pencil, last);
        if first == last {
            let diagonal = pencil.at(last, last);
            each(Ratio { b: diagonal.b(), a: diagonal.a() });
            left = last;
            sweeps = 0;
            continue;
        }
        if sweeps == MAX_SWEEPS {
            return Err(Failure::NoConvergence);
        }
        sweeps += 1;
        let mut shift = nearer_eigenvalue(pencil, last);
        if sweeps % SWEEPS_BEFORE_EXCEPTION == 0 || !shift.is_finite() {
            shift = exceptional_shift(pencil, last, shift);
        }
        sweep(pencil, first, last, shift, &mut rotations, tick)?;
    }
    Ok(())
}

/// Returns the number of entries that rotations visit for all eigenvalues of a pencil, about.
pub(super) fn expected_entries(size: usize) -> f64 {
    // A sweep of a block of m rows visits m^2/2 entries twice.
    SWEEPS * (size as f64).powi(3) / 3.0
}

/// Sweeps per eigenvalue, measured at N = 1000; 3.2 at 100.
const SWEEPS: f64 = 2.7;

/// Returns the first row of the block that ends in `last` and has no zero below its diagonal;
/// subdiagonal entries at the level of rounding are set to 0.
fn first_of_block(pencil: &mut Pencil, last: usize) -> usize {
    for k in (1..=last).rev() {
        let below = pencil.at(k, k - 1).b().norm();
        let beside = pencil.at(k, k).b().norm() + pencil.at(k - 1, k - 1).b().norm();
        if below <= f64::EPSILON * beside {
            pencil.at_mut(k, k - 1).set_b(Complex64::ZERO);
            return k;
        }
    }
    0
}

/// Returns the eigenvalue of the last 2 x 2 block of `B A^-1` that is nearer to the last entry; not
/// finite if A is singular there.
fn nearer_eigenvalue(pencil: &Pencil, last: usize) -> Complex64 {
    let [p, q] = [last - 1, last].map(|k| pencil.at(k, k).a());
    let corner = pencil.at(last - 1, last);
    let (b21, b22) = (pencil.at(last, last - 1).b() / p, pencil.at(last, last).b() / q);
    let b11 = pencil.at(last - 1, last - 1).b() / p;
    let u = corner.a() / q;
    // The entries of B A^-1, whose lower left one is b21.
    let m22 = b22 - u * b21;
    let m12 = corner.b() / q - u * b11;
    let half = 0.5 * (b11 - m22);
    let product = m12 * b21;
    let root = (half * half + product).sqrt();
    let root = if (half * root.conj()).re < 0.0 { -root } else { root };
    let sum = half + root;
    if sum == Complex64::ZERO { m22 } else { m22 - product / sum }
}

/// Returns a shift for a block that does not converge: off by the last subdiagonal entry of
/// `B A^-1`.
fn exceptional_shift(pencil: &Pencil, last: usize, shift: Complex64) -> Complex64 {
    let below = pencil.at(last, last - 1).b() / pencil.at(last - 1, last - 1).a();
    let shift = if shift.is_finite() { shift } else { Complex64::ZERO };
    if below.is_finite() { shift + below } else { Complex64::ONE }
}

/// Performs one sweep on the block from `first` to `last`.
fn sweep(
    pencil: &mut Pencil,
    first: usize,
    last: usize,
    shift: Complex64,
    rotations: &mut Vec<Rotation>,
    tick: &dyn Fn(usize) -> Result<(), Stopped>,
) -> Result<(), Stopped> {
    rotations.clear();
    let start = pencil.at(first, first);
    let below = pencil.at(first + 1, first).b();
    rotations.push(Rotation::annihilating(start.b() - shift * start.a(), below));
    rotate_rows::<1>(pencil, first, first, rotations);
    let mut visited = 0;
    for k in first..last {
        // Column k has all rotations of rows; those of k + 1 fill one entry below the diagonal of
        // A, which a rotation of both columns removes at the cost of one below the subdiagonal of B,
        // which the next rotation of rows removes.
        let behind = (k - first) % TOGETHER;
        if behind > 0 {
            rotate_rows::<1>(pencil, k + 1, k + 1 - behind, &rotations[k + 1 - behind - first..]);
        } else if k + TOGETHER <= last {
            rotate_rows::<TOGETHER>(pencil, k + 1, first, rotations);
        } else {
            (k + 1..=last).for_each(|column| rotate_rows::<1>(pencil, column, first, rotations));
        }
        let columns = Rotation::annihilating(pencil.at(k + 1, k + 1).a(), pencil.at(k + 1, k).a());
        let (left, right) = pencil.columns_mut(k, first, k + 1);
        for (x, y) in right.iter_mut().zip(left) {
            (*x, *y) = columns.apply(*x, *y);
        }
        pencil.at_mut(k + 1, k).set_a(Complex64::ZERO);
        if k + 1 < last {
            let (kept, bulge) = columns.apply_to_pair(pencil.at(k + 2, k + 1).b(), Complex64::ZERO);
            pencil.at_mut(k + 2, k + 1).set_b(kept);
            let under = pencil.at(k + 1, k).b();
            let rows = Rotation::annihilating(under, bulge);
            pencil.at_mut(k + 1, k).set_b(rows.apply_to_pair(under, bulge).0);
            rotations.push(rows);
            let column = pencil.column_mut(k + 1);
            (column[k + 1], column[k + 2]) = rows.apply(column[k + 1], column[k + 2]);
        }
        visited += 2 * (k + 1 - first);
        if visited >= ENTRIES_PER_TICK {
            tick(visited)?;
            visited = 0;
        }
    }
    tick(visited)
}

/// Applies rotations to the rows of `W` columns from `column`: the first one to rows `first` and
/// `first + 1`, and so on.
fn rotate_rows<const W: usize>(
    pencil: &mut Pencil,
    column: usize,
    first: usize,
    rotations: &[Rotation],
) {
    let mut columns = pencil.some_columns_mut::<W>(column);
    let mut upper = columns.each_ref().map(|rows| rows[first]);
    for (row, rotation) in (first..).zip(rotations) {
        for (rows, upper) in columns.iter_mut().zip(&mut upper) {
            (rows[row], *upper) = rotation.apply(*upper, rows[row + 1]);
        }
    }
    for (rows, upper) in columns.iter_mut().zip(upper) {
        rows[first + rotations.len()] = upper;
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use nalgebra::DMatrix;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::super::direction;
    use super::{Complex64, Failure, Pencil, Ratio, Stopped, eigenvalues};

    fn random(size: usize, seed: u64) -> Pencil {
        Pencil::spherical(size, Vec::new(), &mut ChaCha8Rng::seed_from_u64(seed))
    }

    /// Returns the matrices of a pencil.
    fn dense(pencil: &Pencil) -> [DMatrix<Complex64>; 2] {
        let n = pencil.size();
        let entry = |row: usize, column: usize| pencil.at(row, column);
        let b =
            DMatrix::from_fn(n, n, |i, j| if i <= j + 1 { entry(i, j).b() } else { 0.0.into() });
        let a = DMatrix::from_fn(n, n, |i, j| if i <= j { entry(i, j).a() } else { 0.0.into() });
        [b, a]
    }

    fn points(mut pencil: Pencil) -> Vec<DVec3> {
        let mut points = Vec::new();
        eigenvalues(&mut pencil, &|_| Ok(()), |ratio| points.push(direction(ratio))).unwrap();
        points
    }

    /// Returns the largest distance of matched points of two sets; every point is matched once.
    fn distance(got: &[DVec3], expected: &[DVec3]) -> f64 {
        assert_eq!(got.len(), expected.len());
        let mut left = expected.to_vec();
        let mut largest: f64 = 0.0;
        for p in got {
            let nearest = |k: &usize, l: &usize| {
                p.distance_squared(left[*k]).total_cmp(&p.distance_squared(left[*l]))
            };
            let k = (0..left.len()).min_by(nearest).unwrap();
            largest = largest.max(p.distance(left.swap_remove(k)));
        }
        largest
    }

    /// The oracle is the dense Schur form of `B A^-1`. Its error grows with the condition of A, about
    /// N^2 for these matrices.
    #[test]
    fn eigenvalues_are_those_of_a_dense_schur_form() {
        for (size, seed) in (1..=12).flat_map(|n| [(n, 1), (n, 2)]).chain([(25, 3), (60, 4)]) {
            let pencil = random(size, seed);
            let [b, a] = dense(&pencil);
            let inverse = a.try_inverse().unwrap();
            let schur = nalgebra::linalg::Schur::new(b * inverse);
            let one = Complex64::ONE;
            let expected: Vec<DVec3> = schur
                .unpack()
                .1
                .diagonal()
                .iter()
                .map(|&b| direction(Ratio { b, a: one }))
                .collect();
            let off = distance(&points(pencil), &expected);
            assert!(off < 1e-9, "size {size}: {off:e}");
        }
    }

    /// Unitary transformations leave `prod b_k = det B` and `prod a_k = det A` in magnitude.
    #[test]
    fn determinants_are_kept() {
        for size in [1, 2, 3, 17, 80] {
            let mut pencil = random(size, 9);
            let expected = dense(&pencil).map(|m| m.determinant().norm().ln());
            let mut got = [0.0; 2];
            let each = |Ratio { b, a }: Ratio| {
                got[0] += b.norm().ln();
                got[1] += a.norm().ln();
            };
            eigenvalues(&mut pencil, &|_| Ok(()), each).unwrap();
            for (got, expected) in got.iter().zip(expected) {
                // Relative rounding of N factors.
                assert!((got - expected).abs() < 1e-10, "{size}: {got} against {expected}");
            }
        }
    }

    /// Singular, zero, triangular, repeated and badly scaled: no panic, no endless loop, unit
    /// vectors.
    #[test]
    fn hostile_pencils_end() {
        const SIZE: usize = 20;
        let entries = || (0..SIZE).flat_map(|j| (0..=j + 1).map(move |i| (i, j)));
        let changed = |change: &dyn Fn(usize, usize, Complex64, Complex64) -> [Complex64; 2]| {
            let mut pencil = random(SIZE, 5);
            for (i, j) in entries() {
                let entry = pencil.at(i, j);
                let [b, a] = change(i, j, entry.b(), entry.a());
                pencil.at_mut(i, j).set_b(b);
                pencil.at_mut(i, j).set_a(a);
            }
            pencil
        };
        let (zero, one) = (Complex64::ZERO, Complex64::ONE);
        let pencils = [
            changed(&|i, j, b, a| [b, if i == 7 && j == 7 { zero } else { a }]),
            changed(&|i, j, b, a| [b, if i == 19 && j == 19 { zero } else { a }]),
            changed(&|i, j, b, a| [b, if i == 0 && j == 0 { zero } else { a }]),
            changed(&|_, _, _, a| [zero, a]),
            changed(&|_, _, b, _| [b, zero]),
            changed(&|_, _, _, _| [zero, zero]),
            changed(&|i, j, b, a| [if i > j { zero } else { b }, a]),
            // A permutation: the roots of unity.
            changed(&|i, j, _, _| {
                let cyclic = i == j + 1 && i < SIZE || i == 0 && j == SIZE - 1;
                [if cyclic { one } else { zero }, if i == j { one } else { zero }]
            }),
            changed(&|i, j, _, _| {
                [if i <= j { one } else { zero }, if i == j { one } else { zero }]
            }),
            changed(&|_, _, b, a| [1e40 * b, 1e-40 * a]),
            changed(&|_, _, b, a| [1e-40 * b, 1e40 * a]),
        ];
        for (k, mut pencil) in pencils.into_iter().enumerate() {
            let mut found = 0;
            let each = |ratio| {
                found += 1;
                assert!(direction(ratio).is_normalized(), "case {k}: {ratio:?}");
            };
            match eigenvalues(&mut pencil, &|_| Ok(()), each) {
                Ok(()) => assert_eq!(found, SIZE, "case {k}"),
                Err(failure) => {
                    // Only where A has an exact zero, which random pencils do not have.
                    assert!(matches!(failure, Failure::NoConvergence) && k < 6, "case {k}");
                }
            }
        }
        let roots = points(changed(&|i, j, _, _| {
            let cyclic = i == j + 1 && i < SIZE || i == 0 && j == SIZE - 1;
            [if cyclic { one } else { zero }, if i == j { one } else { zero }]
        }));
        let expected: Vec<DVec3> = (0..SIZE)
            .map(|k| Complex64::cis(std::f64::consts::TAU * k as f64 / SIZE as f64))
            .map(|root| direction(Ratio { b: root, a: one }))
            .collect();
        assert!(distance(&roots, &expected) < 1e-13);
    }

    #[test]
    fn ticks_stop_the_work() {
        let ticked = std::cell::Cell::new(0);
        let tick = |_| {
            ticked.set(ticked.get() + 1);
            if ticked.get() == 3 { Err(Stopped) } else { Ok(()) }
        };
        let stopped = eigenvalues(&mut random(30, 6), &tick, |_| ());
        assert!(matches!(stopped, Err(Failure::Stopped(_))) && ticked.get() == 3);
    }
}
