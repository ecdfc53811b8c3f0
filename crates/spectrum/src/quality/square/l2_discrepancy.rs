use sphvar_samplers::{Progress, Stopped};
use sphvar_sh::CompensatedSum;

use super::dominance::sweep;
use crate::quality::Unavailable;

/// The largest number of points for which L2 discrepancies are computed; the sums take 100 bytes a
/// point.
pub const MAX_POINTS_OF_L2_DISCREPANCY: usize = 4_000_000;

/// Points between reports of progress.
const ROWS: usize = 1 << 14;

/// Nominal work of a point, from its 1 to 3 us.
const POINT: f64 = 30.0;

/// Returns the L2 star discrepancy of a point set of the square: the root mean square, over boxes
/// [0, u) x [0, v), of the fraction of points in the box minus its area.
///
/// ```text
/// D^2 = 1/9 - (1/(2N)) sum_j (1 - u_j^2)(1 - v_j^2)
///       + (1/N^2) sum_jk (1 - max(u_j, u_k))(1 - max(v_j, v_k))
/// ```
///
/// `Err(Unavailable)` without points and for more than [`MAX_POINTS_OF_L2_DISCREPANCY`].
///
/// # Errors
///
/// [`Stopped`] if `progress` stops the work.
///
/// # Performance
///
/// O(N log N). The terms cancel to about `log N/N^2`; the measured relative error of D is 1e-14 at
/// 1000 points and grows as `N^1.5` for good sets.
///
/// # Examples
///
/// ```
/// use sphvar_spectrum::quality::l2_star_discrepancy;
///
/// // The mean over boxes of (1 - u v)^2 where the box has the point 0, everywhere.
/// let squared = l2_star_discrepancy(&[[0.0, 0.0]], &())?.expect("is small").powi(2);
/// assert!((squared - (1.0 - 0.5 + 1.0 / 9.0)).abs() < 1e-15);
/// # Ok::<(), sphvar_samplers::Stopped>(())
/// ```
///
/// # References
///
/// Warnock 1972, Computational investigations of low-discrepancy point sets.
pub fn l2_star_discrepancy(
    points: &[[f64; 2]],
    progress: &dyn Progress,
) -> Result<Result<f64, Unavailable>, Stopped> {
    let n = match count(points) {
        Ok(n) => n,
        Err(unavailable) => return Ok(Err(unavailable)),
    };
    let mut sum = CompensatedSum::default();
    let mut report = Report::new(points, progress);
    sweep(
        points,
        |[_, v]| [1.0, 1.0 - v],
        |[u, v], [count_below, _], [_, missing_above]| {
            let (a, b) = (1.0 - u, 1.0 - v);
            sum.add(-0.5 * n * (a * (1.0 + u)) * (b * (1.0 + v)));
            sum.add(a * b);
            // The later of two points in the order of u has the larger u.
            sum.add(2.0 * a * (count_below * b + missing_above));
            report.tick()
        },
    )?;
    add_squared_count(&mut sum, points.len(), 1, 9);
    Ok(Ok(sum.value().max(0.0).sqrt() / n))
}

/// Returns the wrap-around L2 discrepancy of a point set of the square, which shifts modulo 1 do
/// not change: the root mean square of the difference of counts and areas over the boxes of the
/// torus, of all dimensions.
///
/// ```text
/// W^2 = (1/N^2) sum_jk K(u_j - u_k) K(v_j - v_k) - 16/9,   K(x) = 3/2 - |x| + x^2
///     = (1/N) sum over k != 0 of r(k1) r(k2) P(k),   r(0) = 4/3, r(k) = 1/(2 pi^2 k^2)
/// ```
///
/// The second line has the power of the set at all frequencies: W^2 is the variance of integrals of
/// functions with these energies.
///
/// `Err(Unavailable)` without points and for more than [`MAX_POINTS_OF_L2_DISCREPANCY`].
///
/// # Errors
///
/// [`Stopped`] if `progress` stops the work.
///
/// # Performance
///
/// O(N log N), with the accuracy of [`l2_star_discrepancy`].
///
/// # Examples
///
/// ```
/// use sphvar_spectrum::quality::wraparound_l2_discrepancy;
///
/// let squared = wraparound_l2_discrepancy(&[[0.3, 0.8]], &())?.expect("is small").powi(2);
/// assert!((squared - (2.25 - 16.0 / 9.0)).abs() < 1e-15);
/// # Ok::<(), sphvar_samplers::Stopped>(())
/// ```
///
/// # References
///
/// Hickernell 1998, Lattice rules: how well do they measure up?, eq. 5.
pub fn wraparound_l2_discrepancy(
    points: &[[f64; 2]],
    progress: &dyn Progress,
) -> Result<Result<f64, Unavailable>, Stopped> {
    let n = match count(points) {
        Ok(n) => n,
        Err(unavailable) => return Ok(Err(unavailable)),
    };
    let mut sum = CompensatedSum::default();
    let mut report = Report::new(points, progress);
    sweep(
        points,
        |[u, v]| [1.0, u, u * u, v, u * v, u * u * v, v * v, u * v * v, u * u * v * v],
        |[u, v], below, above| {
            // K(u - x) for x below u, and K(v - y) for y below and above v, by powers of x and y.
            let of_u = [1.5 - u + u * u, 1.0 - 2.0 * u, 1.0];
            let of_below = [1.5 - v + v * v, 1.0 - 2.0 * v, 1.0];
            let of_above = [1.5 + v + v * v, -1.0 - 2.0 * v, 1.0];
            for (moments, of_v) in [(below, of_below), (above, of_above)] {
                for (moment, i) in moments.iter().zip(0..) {
                    sum.add(2.0 * of_u[i % 3] * of_v[i / 3] * moment);
                }
            }
            report.tick()
        },
    )?;
    // The pairs of a point with itself.
    sum.add(2.25 * n);
    add_squared_count(&mut sum, points.len(), -16, 9);
    Ok(Ok(sum.value().max(0.0).sqrt() / n))
}

/// Returns the number of points.
fn count(points: &[[f64; 2]]) -> Result<f64, Unavailable> {
    match points.len() {
        0 => Err(Unavailable::new("the set has no points")),
        n if n > MAX_POINTS_OF_L2_DISCREPANCY => {
            let reason = format!("computed for at most {MAX_POINTS_OF_L2_DISCREPANCY} points");
            Err(Unavailable::new(reason))
        }
        n => Ok(n as f64),
    }
}

/// Adds `n^2 numerator/denominator`, of which the integer part has no rounding.
fn add_squared_count(sum: &mut CompensatedSum, n: usize, numerator: i64, denominator: u64) {
    let product = (n as u64).pow(2) * numerator.unsigned_abs();
    let sign = numerator.signum() as f64;
    sum.add(sign * (product / denominator) as f64);
    sum.add(sign * (product % denominator) as f64 / denominator as f64);
}

/// Reports the progress of a sweep in blocks of points.
struct Report<'a> {
    progress: &'a dyn Progress,
    n_points: usize,
}

impl<'a> Report<'a> {
    fn new(points: &[[f64; 2]], progress: &'a dyn Progress) -> Self {
        progress.expect(POINT * points.len() as f64);
        Self { progress, n_points: 0 }
    }

    fn tick(&mut self) -> Result<(), Stopped> {
        self.n_points += 1;
        if self.n_points.is_multiple_of(ROWS) {
            self.progress.tick(POINT * ROWS as f64)?;
        }
        Ok(())
    }
}
