//! Point sets as they are kept by `--save`.

use serde::{Deserialize, Serialize};
use sphvar_samplers::PointSet;

use crate::error::CliError;
use crate::files::FilePoint;

/// A point set with its number.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct KeptSet<N> {
    number: u64,
    points: Vec<N>,
    weights: Vec<f64>,
}

impl<N> KeptSet<N> {
    pub(super) fn new<P: FilePoint<Numbers = N>>(number: u64, set: PointSet<P>) -> Self {
        let points = set.points.iter().map(P::numbers).collect();
        Self { number, points, weights: set.weights }
    }
}

/// Sets with their numbers, one for each set.
pub(super) type RestoredSets<P> = (Vec<usize>, Vec<PointSet<P>>);

/// Returns kept sets with their numbers, which increase and are below `count`.
///
/// # Errors
///
/// If they are no such sets, which only a changed file has.
pub(super) fn restored<P: FilePoint<Numbers: Into<P>>>(
    kept: Vec<KeptSet<P::Numbers>>,
    count: u64,
) -> Result<RestoredSets<P>, CliError> {
    let wrong = || CliError::File("the saved sets of points have another form".to_owned());
    let is_set =
        |set: &KeptSet<P::Numbers>| set.weights.is_empty() || set.weights.len() == set.points.len();
    let is_ordered = kept.is_sorted_by(|a, b| a.number < b.number);
    if !is_ordered
        || kept.last().is_none_or(|last| last.number >= count)
        || !kept.iter().all(is_set)
    {
        return Err(wrong());
    }
    let restore = |set: KeptSet<P::Numbers>| {
        let points = set.points.into_iter().map(Into::into).collect();
        let number = usize::try_from(set.number).map_err(|_| wrong())?;
        Ok((number, PointSet { points, weights: set.weights }))
    };
    kept.into_iter().map(restore).collect()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sphvar_samplers::PointSet;

    use super::{KeptSet, restored};

    #[test]
    fn sets_come_back_bit_by_bit_and_changed_ones_are_errors() {
        let points = vec![DVec3::new(-0.0, 1e-310, 1.0), DVec3::Z];
        let set = PointSet { points, weights: vec![0.1, -3.0] };
        let kept = |numbers: &[u64]| -> Vec<KeptSet<[f64; 3]>> {
            let kept: Vec<_> = numbers.iter().map(|&n| KeptSet::new(n, set.clone())).collect();
            postcard::from_bytes(&postcard::to_stdvec(&kept).unwrap()).unwrap()
        };
        let (numbers, sets) = restored::<DVec3>(kept(&[1, 4]), 5).unwrap();
        assert_eq!(numbers, [1, 4]);
        let bits = |set: &PointSet| -> Vec<u64> {
            let numbers = set.points.iter().flat_map(|p| p.to_array());
            numbers.chain(set.weights.iter().copied()).map(f64::to_bits).collect()
        };
        assert!(sets.iter().all(|restored| bits(restored) == bits(&set)));
        for numbers in [&[][..], &[4, 1], &[1, 1], &[5]] {
            assert!(restored::<DVec3>(kept(numbers), 5).is_err(), "{numbers:?}");
        }
        let mut short = kept(&[0]);
        short[0].weights.pop();
        assert!(restored::<DVec3>(short, 5).is_err());
    }
}
