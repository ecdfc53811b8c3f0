//! Curves of many degrees, summarized by means and ranges of bins.

/// Curves of more points than this are summarized in bins.
const MAX_POINTS: usize = 150;
/// The number of bins in a decade of x.
const BINS: f64 = 30.0;

/// A curve with at most a few hundred points.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Binned {
    /// The points, or the means of bins.
    pub(crate) points: Vec<(f64, f64)>,
    /// The smallest and the largest value of each bin; `None` if every point is shown.
    pub(crate) ranges: Option<Vec<(f64, f64)>>,
}

impl Binned {
    /// The note of a chart with bins.
    pub(crate) const NOTE: &str = "Where degrees are many, lines are means over bins of log l and bands their ranges; \
        degrees with 0 (to rounding) are left out.";
    /// The note of a chart with bins but without ranges.
    pub(crate) const NOTE_OF_MEANS: &str = "Where degrees are many, lines are means over bins of log l; degrees with \
        0 (to rounding) are left out.";
    /// The note of a chart over rings of frequencies with bins.
    pub(crate) const NOTE_OF_RINGS: &str = "Where rings are many, lines are means over bins of log |k| and bands their \
        ranges; rings with 0 (to rounding) are left out.";
    /// The note of a chart over rings of frequencies with bins but without ranges.
    pub(crate) const NOTE_OF_MEANS_OF_RINGS: &str = "Where rings are many, lines are means over bins of log |k|; rings \
        with 0 (to rounding) are left out.";

    /// Returns the points in order of x > 0 with y above `floor`, the rounding level: all points if
    /// they are few, otherwise the mean of each bin of log x, at the geometric mean of its first
    /// and last x.
    pub(crate) fn new(points: &[(f64, f64)], floor: f64) -> Self {
        let points: Vec<_> = points.iter().copied().filter(|point| point.1 > floor).collect();
        if points.len() <= MAX_POINTS {
            return Self { points, ranges: None };
        }
        let bin = |point: &(f64, f64)| (BINS * point.0.log10()).floor();
        let (mut means, mut ranges) = (Vec::new(), Vec::new());
        for members in points.chunk_by(|a, b| bin(a) >= bin(b)) {
            let (first, last) = (members[0].0, members[members.len() - 1].0);
            let values = || members.iter().map(|point| point.1);
            means.push(((first * last).sqrt(), values().sum::<f64>() / members.len() as f64));
            ranges.push((
                values().fold(f64::INFINITY, f64::min),
                values().fold(f64::NEG_INFINITY, f64::max),
            ));
        }
        Self { points: means, ranges: Some(ranges) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_points_stay() {
        let points: Vec<_> = (1..=20).map(|l| (f64::from(l), f64::from(l % 2))).collect();
        let binned = Binned::new(&points, 1e-20);
        assert_eq!(binned.points.len(), 10);
        assert_eq!(binned.ranges, None);
    }

    #[test]
    fn bins_keep_mean_and_range() {
        // Power in odd degrees only, alternating between 1 and 3.
        let power = |l: i32| if l % 2 == 0 { 0.0 } else { f64::from(l % 4) };
        let points: Vec<_> = (1..=4000).map(|l| (f64::from(l), power(l))).collect();
        let Binned { points, ranges } = Binned::new(&points, 1e-20);
        let ranges = ranges.unwrap();
        assert!((50..150).contains(&points.len()), "{} bins", points.len());
        assert_eq!(points.len(), ranges.len());
        assert_eq!(points[..2], [(1.0, 1.0), (3.0, 3.0)], "single degrees where bins are narrow");
        for (&(l, mean), &range) in points.iter().zip(&ranges).filter(|bin| bin.0.0 > 200.0) {
            assert!((mean - 2.0).abs() < 0.15, "mean {mean} at {l}");
            assert_eq!(range, (1.0, 3.0), "{l}");
        }
        assert!(points.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }
}
