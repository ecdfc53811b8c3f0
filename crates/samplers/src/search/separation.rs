use glam::DVec3;

use crate::{Domain, Progress, Stopped};

/// Sets of at most this size are searched pair by pair.
const MAX_PAIRWISE: usize = 16;

/// Parts of fewer points do not report progress.
const MIN_REPORTED: usize = 4096;

/// Returns the separation of unit vectors, the least chord between two of them: 0 if points
/// coincide, `None` for fewer than two points. Weights have no part in it.
///
/// On the hemisphere, whose directions are lines through the origin, the distance of two lines is
/// the smaller chord between their ends, at most sqrt(2).
///
/// # Errors
///
/// [`Stopped`] if `progress` stops the work.
///
/// # Performance
///
/// Divide and conquer (Bentley and Shamos 1976): O(N log N) on any set that is not on few lines,
/// also with clusters and repeated points; 0.6 s for a million points.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_samplers::{Domain, separation};
///
/// let points = [DVec3::Z, DVec3::X, DVec3::new(-0.8, 0.0, -0.6)];
/// let between = |domain| separation(&points, domain, &());
/// assert!((between(Domain::Sphere)?.unwrap() - 2f64.sqrt()).abs() < 1e-15);
/// assert!((between(Domain::Hemisphere)?.unwrap() - 0.4f64.sqrt()).abs() < 1e-15);
/// # Ok::<(), sphvar_samplers::Stopped>(())
/// ```
///
/// # References
///
/// J. L. Bentley and M. I. Shamos, "Divide-and-conquer in multidimensional space", STOC 1976.
pub fn separation(
    points: &[DVec3],
    domain: Domain,
    progress: &dyn Progress,
) -> Result<Option<f64>, Stopped> {
    if points.len() < 2 {
        return Ok(None);
    }
    let antipodes = (domain == Domain::Hemisphere).then(|| points.iter().map(|p| -*p));
    let mut all: Vec<DVec3> =
        points.iter().copied().chain(antipodes.into_iter().flatten()).collect();
    // No two points are farther apart than antipodes.
    Ok(Some(closest(&mut all, 4.0, progress)?.sqrt()))
}

/// Returns the smaller one of `bound` and the least squared distance of two points, which it
/// reorders.
pub(super) fn closest(
    points: &mut [DVec3],
    bound: f64,
    progress: &dyn Progress,
) -> Result<f64, Stopped> {
    if bound <= 0.0 {
        return Ok(bound);
    }
    if points.len() <= MAX_PAIRWISE {
        let pairs = points
            .iter()
            .enumerate()
            .flat_map(|(k, p)| points[k + 1..].iter().map(|q| p.distance_squared(*q)));
        return Ok(pairs.fold(bound, f64::min));
    }
    let axis = widest_axis(points);
    let half = points.len() / 2;
    points.select_nth_unstable_by(half, |p, q| p[axis].total_cmp(&q[axis]));
    let middle = points[half][axis];
    let (left, right) = points.split_at_mut(half);
    let bound = closest(left, bound, progress)?;
    let bound = closest(right, bound, progress)?;
    let is_near = |p: &&DVec3| (p[axis] - middle).powi(2) < bound;
    let mut strip: Vec<DVec3> = points.iter().filter(is_near).copied().collect();
    let along = widest_axis(&strip);
    strip.sort_unstable_by(|p, q| p[along].total_cmp(&q[along]));
    let mut smallest = bound;
    for (k, p) in strip.iter().enumerate() {
        let ahead = strip[k + 1..].iter().take_while(|q| (q[along] - p[along]).powi(2) < smallest);
        let nearest = ahead.map(|q| p.distance_squared(*q)).fold(smallest, f64::min);
        smallest = nearest;
        if smallest <= 0.0 {
            break;
        }
    }
    if points.len() >= MIN_REPORTED {
        progress.tick(0.0)?;
    }
    Ok(smallest)
}

/// Returns the axis along which the points extend farthest.
fn widest_axis(points: &[DVec3]) -> usize {
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = points.iter().fold(start, |(low, high), p| (low.min(*p), high.max(*p)));
    (high - low).max_position()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::separation;
    use crate::{Domain, Pattern, Purpose, Streams};

    fn definition(points: &[DVec3], domain: Domain) -> f64 {
        let mut smallest = f64::INFINITY;
        for (k, p) in points.iter().enumerate() {
            for q in &points[..k] {
                smallest = smallest.min(p.distance(*q));
                if domain == Domain::Hemisphere {
                    smallest = smallest.min(p.distance(-*q));
                }
            }
        }
        smallest
    }

    #[test]
    fn it_matches_all_pairs_on_hostile_sets() {
        let sample = |pattern: Pattern, n: usize| {
            let mut rng = Streams::new(3, Purpose::Pattern, n).realization(0);
            pattern.build(n, Domain::Sphere).unwrap().sample(&mut rng).unwrap().points
        };
        let meridian = |k: u32| DVec3::new((0.003 * f64::from(k)).sin(), 0.0, 1.0).normalize();
        let white = sample(Pattern::WhiteNoise, 400);
        let at_pole = white.iter().map(|p| (DVec3::Z + 1e-9 * p).normalize());
        let cluster = white.iter().copied().chain(at_pole).collect();
        let mut repeated = sample(Pattern::FIBONACCI, 300);
        repeated.push(repeated[17]);
        let mut antipodal = sample(Pattern::FIBONACCI, 300);
        antipodal.push(-antipodal[200]);
        let sets = [
            ("two", vec![DVec3::X, DVec3::Y]),
            ("poles", vec![DVec3::Z, -DVec3::Z]),
            ("meridian", (0..500).map(meridian).collect()),
            ("white noise", sample(Pattern::WhiteNoise, 1500)),
            ("rings", sample(Pattern::Healpix, 768)),
            ("fibonacci", sample(Pattern::FIBONACCI, 1000)),
            ("cluster", cluster),
            ("repeated", repeated),
            ("antipodal", antipodal),
            ("coincident", vec![DVec3::Y; 100]),
        ];
        for (name, points) in sets {
            for domain in [Domain::Sphere, Domain::Hemisphere] {
                let got = separation(&points, domain, &()).unwrap().unwrap();
                let expected = definition(&points, domain);
                assert!((got - expected).abs() <= 0.0, "{name}, {domain}: {got}, {expected}");
            }
        }
        assert_eq!(separation(&[DVec3::X], Domain::Hemisphere, &()), Ok(None));
    }

    /// A million coincident or clustered points take as long as others.
    #[test]
    fn repeated_points_do_not_take_quadratic_time() {
        let points: Vec<DVec3> = (0..200_000)
            .map(|k| DVec3::new(f64::from(k % 500) * 1e-9, f64::from(k / 500) * 1e-9, 1.0))
            .collect();
        let chord = separation(&points, Domain::Sphere, &()).unwrap().unwrap();
        assert!((chord - 1e-9).abs() < 1e-15, "{chord}");
        let same = vec![DVec3::Z; 200_000];
        assert_eq!(separation(&same, Domain::Sphere, &()), Ok(Some(0.0)));
    }
}
