use sphvar_samplers::{Progress, Stopped};

use crate::quality::Unavailable;

/// The largest number of points for which the star discrepancy is computed, in 2 to 3 s.
pub const MAX_POINTS_OF_STAR_DISCREPANCY: usize = 50_000;

/// Nominal work of a pair of points, from its 1 ns.
const PAIR: f64 = 1.0 / 60.0;

/// Returns the star discrepancy of a point set of the square, the supremum over boxes [0, u) x
/// [0, v) of the difference between the fraction of points in the box and its area. It is exact to
/// rounding.
///
/// The integration error of a function of variation V in the sense of Hardy and Krause is at most
/// D V (Koksma and Hlawka).
///
/// `Err(Unavailable)` without points and for more than [`MAX_POINTS_OF_STAR_DISCREPANCY`].
///
/// # Errors
///
/// [`Stopped`] if `progress` stops the work.
///
/// # Performance
///
/// O(N^2): for each u of a point, the boxes that end at the v of points to its left.
///
/// # Examples
///
/// ```
/// use sphvar_spectrum::quality::star_discrepancy;
///
/// // The closed box to the point has the area 1/4 and all of the points.
/// let discrepancy = star_discrepancy(&[[0.5, 0.5]], &())?.expect("is small");
/// assert_eq!(discrepancy, 0.75);
/// # Ok::<(), sphvar_samplers::Stopped>(())
/// ```
///
/// # References
///
/// Niederreiter 1972, Discrepancy and convex programming: the candidate boxes in two dimensions.
pub fn star_discrepancy(
    points: &[[f64; 2]],
    progress: &dyn Progress,
) -> Result<Result<f64, Unavailable>, Stopped> {
    let count = points.len();
    if count == 0 {
        return Ok(Err(Unavailable::new("the set has no points")));
    }
    if count > MAX_POINTS_OF_STAR_DISCREPANCY {
        let reason = format!("computed for at most {MAX_POINTS_OF_STAR_DISCREPANCY} points");
        return Ok(Err(Unavailable::new(reason)));
    }
    progress.expect(0.5 * PAIR * (count as f64).powi(2));
    let n = count as f64;
    let mut sorted = points.to_vec();
    sorted.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    // The v of the points so far, in order.
    let mut column: Vec<f64> = Vec::with_capacity(count);
    // Before the first point, boxes are empty.
    let mut largest = n * sorted[0][0];
    let mut rest = &sorted[..];
    while let Some(&[u, _]) = rest.first() {
        let n_equal = rest.iter().take_while(|p| p[0] <= u).count();
        for &[_, v] in &rest[..n_equal] {
            column.insert(column.partition_point(|x| *x < v), v);
        }
        rest = &rest[n_equal..];
        // Open boxes extend to the next point, or the edge.
        let next = rest.first().map_or(1.0, |p| p[0]);
        largest = largest.max(n * next - column.len() as f64).max(of_column(&column, n, u, next));
        progress.tick(PAIR * (column.len() * n_equal) as f64)?;
    }
    Ok(Ok(largest / n))
}

/// Returns the largest deviation, times N, of the boxes that end at one of the sorted v: closed
/// boxes to u have too many points, open boxes to `next` too few.
fn of_column(column: &[f64], n: f64, u: f64, next: f64) -> f64 {
    // Independent maxima, so that the loop is vectorized.
    const LANES: usize = 8;
    let mut largest = [0.0f64; LANES];
    let (blocks, rest) = column.as_chunks::<LANES>();
    for (block, values) in blocks.iter().enumerate() {
        let first = (block * LANES) as f64;
        for (i, (largest, v)) in largest.iter_mut().zip(values).enumerate() {
            let below = first + i as f64;
            let many = below + 1.0 - n * u * v;
            let few = n * next * v - below;
            let larger = if many > few { many } else { few };
            *largest = if larger > *largest { larger } else { *largest };
        }
    }
    let tail = rest.iter().enumerate().map(|(i, v)| {
        let below = (blocks.len() * LANES + i) as f64;
        (below + 1.0 - n * u * v).max(n * next * v - below)
    });
    tail.chain(largest).fold(0.0, f64::max)
}
