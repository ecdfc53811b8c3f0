//! The coefficients of one large set from blocks of its points.

use std::collections::BTreeMap;

use glam::DVec3;
use num_complex::Complex;
use sphvar_samplers::PointSet;
use sphvar_sh::{Alm, ByParity, Domain};
use sphvar_sht::{Transform, TransformWorkspace};

use crate::accumulate::given_weights;
use crate::coincidence::TailSample;
use crate::{Error, ExactSum, Resolution, SpectralBands};

/// The exponent of the weights of a block whose weights are all 0, below that of any other.
const ZERO: i32 = -10_000;

/// Transforms blocks of the points of one set.
///
/// The result for a block depends on its own points and weights only, and [`BlockSums`] adds blocks
/// in an order that depends on their numbers only, so the coefficients of the set are bit-identical
/// for any division of the blocks among threads or machines of one instruction-set class.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_samplers::PointSet;
/// use sphvar_sh::Domain;
/// use sphvar_spectrum::{BlockSums, BlockTransform, Resolution};
///
/// let resolution = Resolution::new(4, BlockTransform::size(4));
/// let transform = BlockTransform::new(resolution, Domain::Sphere)?;
/// let mut sums = BlockSums::new(4);
/// // Blocks of any sizes, added in any order.
/// for (number, point) in [(1, DVec3::NEG_Z), (0, DVec3::Z)] {
///     let block = PointSet::new(vec![point]);
///     sums.merge(transform.sums(number, block, &mut Default::default())?)?;
/// }
/// let total = sums.total(Domain::Sphere)?;
/// assert_eq!((total.n_points, total.n_effective), (2, 2.0));
/// assert!((total.powers()[2] - 2.0).abs() < 1e-12 && total.powers()[1].abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct BlockTransform {
    resolution: Resolution,
    domain: Domain,
    /// The transform of blocks of `resolution.n_points` points.
    transform: Transform,
}

impl BlockTransform {
    /// The least number of points of blocks of catalogues.
    pub const MIN_SIZE: usize = 1 << 20;

    /// Returns the number of points of the blocks of catalogues for spectra to degree `lmax`,
    /// `max(2^20, 4 lmax^2)`: the cost that a block has whatever its number of points, that of
    /// about `0.6 lmax^2` points, is then small.
    #[must_use]
    pub fn size(lmax: usize) -> usize {
        Self::MIN_SIZE.max(lmax.saturating_mul(lmax).saturating_mul(4))
    }

    /// Returns the transform of blocks of `resolution.n_points` points and shorter ones.
    ///
    /// # Errors
    ///
    /// [`Error::Transform`] if the degree exceeds the limit of the transform or the accuracy is out
    /// of range.
    pub fn new(resolution: Resolution, domain: Domain) -> Result<Self, Error> {
        let transform = transform(resolution)?;
        Ok(Self { resolution, domain, transform })
    }

    /// Returns the memory in bytes of one transform with the points of its block, and of its result.
    #[must_use]
    pub fn bytes(&self) -> f64 {
        // What a point takes beside what `Method::bytes` counts: its weight and, for the exact
        // method, buffers that have grown to twice their content. Measured: 290 bytes in all.
        let of_point = if self.transform.is_fast() { 8.0 } else { 120.0 };
        let Resolution { lmax, n_points, method, .. } = self.resolution;
        method.bytes(n_points, lmax, 1) + of_point * n_points as f64 + BlockSums::bytes(lmax)
    }

    /// Returns the sums of a block. Directions are normalized to length 1; on the hemisphere, those
    /// with z < 0 are replaced by their antipodes.
    ///
    /// # Errors
    ///
    /// [`Error::Sampler`] if a point has no direction, or a weight is not finite;
    /// [`Error::Transform`] if allocation of the coefficients fails.
    pub fn sums(
        &self,
        number: u64,
        mut block: PointSet,
        workspace: &mut TransformWorkspace,
    ) -> Result<BlockSums, Error> {
        locate(&mut block, self.domain)?;
        let largest = block.weights.iter().fold(0.0, |max: f64, w| max.max(w.abs()));
        let exponent = match (block.weights.is_empty(), largest) {
            (true, _) => 0,
            (false, 0.0) => ZERO,
            (false, largest) => libm::frexp(largest).1,
        };
        block.normalize_weights();
        let mut alm = Alm::zeros(self.resolution.lmax)?;
        let input = [(&*block.points, given_weights(&block))];
        let of_length;
        // A shorter block may be less expensive by the other method.
        let transform = if block.len() == self.resolution.n_points {
            &self.transform
        } else {
            of_length = transform(Resolution { n_points: block.len(), ..self.resolution })?;
            &of_length
        };
        transform.adjoint_batch_into(&input, workspace, std::slice::from_mut(&mut alm));
        let sums = Sums {
            n_points: block.len() as u64,
            exponent,
            values: alm.into_values(),
            weights: given_weights(&block).map(WeightSums::of),
            tail: TailSample::of(&block.points, &block.weights),
        };
        let mut all = BlockSums::new(self.resolution.lmax);
        all.insert(number, 0, sums)?;
        Ok(all)
    }
}

/// Replaces directions by unit vectors, those that are so to rounding excepted, and on the hemisphere by
/// the representatives of antipodal pairs, as [`PointSets`](sphvar_samplers::PointSets) does.
fn locate(block: &mut PointSet, domain: Domain) -> Result<(), Error> {
    let wrong = |reason: String| sphvar_samplers::Error::Given { reason };
    let (n, n_weights) = (block.points.len(), block.weights.len());
    if n_weights > 0 && n_weights != n {
        return Err(wrong(format!("a block has {n} points and {n_weights} weights")).into());
    }
    for point in &mut block.points {
        let is_unit = (point.length_squared() - 1.0).abs() <= 4.0 * f64::EPSILON;
        let along = |p: DVec3| (p / p.abs().max_element()).try_normalize();
        let unit = if is_unit { Some(*point) } else { along(*point) };
        let unit = unit.ok_or_else(|| wrong(format!("a block has no direction {point:?}")))?;
        *point = domain.representative(unit);
    }
    match block.weights.iter().find(|w| !w.is_finite()) {
        Some(w) => Err(wrong(format!("a block has a weight that is not finite: {w}")).into()),
        None => Ok(()),
    }
}

fn transform(resolution: Resolution) -> Result<Transform, Error> {
    let Resolution { lmax, n_points, method, epsilon } = resolution;
    Ok(Transform::new(method, lmax, n_points, epsilon)?)
}

/// The coefficients of blocks of a point set, for any of its blocks.
///
/// Blocks are added along a binary tree over their numbers: a node is the sum of its left and its
/// right child, in this order, and exists as soon as both do. What is stored of n consecutive blocks
/// are thus at most 2 log2(n) nodes.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BlockSums {
    lmax: usize,
    /// By their first block.
    nodes: BTreeMap<u64, Node>,
}

/// The sum of `2^level` blocks.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Node {
    level: u32,
    sums: Sums,
}

/// The sums over points, whose weights are multiplied by `2^-exponent`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Sums {
    n_points: u64,
    exponent: i32,
    values: Vec<Complex<f64>>,
    /// `None` for equal weights.
    weights: Option<WeightSums>,
    tail: TailSample,
}

/// The sums of weights.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct WeightSums {
    sum: ExactSum,
    magnitude: ExactSum,
    squares: ExactSum,
}

/// The coefficients of all blocks of a set.
#[derive(Clone, Debug)]
pub struct BlockTotal {
    /// The number of points.
    pub n_points: u64,
    /// [`PointSet::n_effective`] of the points: their number for equal weights.
    pub n_effective: f64,
    /// Whether the points have weights.
    pub has_weights: bool,
    /// The sum of the weights; infinite if it overflows.
    pub sum_w: f64,
    /// The sum of the squares of the weights; it may overflow or underflow.
    pub sum_w2: f64,
    /// `S_lm = sum_k w_k conj Y_lm(s_k)`, with weights scaled by a power of two such that the
    /// largest is in [1/2, 1); equal weights are 1.
    pub alm: Alm,
    /// The factor that normalizes the power of white noise to 1, as
    /// [`Realization::normalization`](crate::Realization::normalization).
    pub normalization: f64,
    /// The mean power beyond any degree, [`tail_power`](crate::tail_power), of a sample of the
    /// directions: exact if a few thousand points have the same share of coincident and antipodal
    /// ones as all. NaN if all points are in so small a part of the sphere that there is no sample.
    pub tail: ByParity,
}

impl BlockTotal {
    /// Returns the power of every degree from 0, as [`Realization::power`](crate::Realization::power).
    #[must_use]
    pub fn powers(&self) -> Vec<f64> {
        Domain::powers(&self.alm, self.normalization)
    }
}

impl BlockSums {
    /// Returns the sums of no blocks, of coefficients to degree `lmax`.
    #[must_use]
    pub fn new(lmax: usize) -> Self {
        Self { lmax, nodes: BTreeMap::new() }
    }

    /// Returns the memory in bytes of one node of the tree, an upper bound.
    #[must_use]
    pub fn bytes(lmax: usize) -> f64 {
        8.0 * (lmax as f64 + 1.0) * (lmax as f64 + 2.0) + TailSample::MAX_BYTES as f64
    }

    /// Returns the ranges of block numbers that are in the sums, in order.
    #[must_use]
    pub fn ranges(&self) -> Vec<std::ops::Range<u64>> {
        let mut ranges: Vec<std::ops::Range<u64>> = Vec::new();
        for (&first, node) in &self.nodes {
            let end = first.saturating_add(node.len());
            match ranges.last_mut() {
                Some(last) if last.end == first => last.end = end,
                _ => ranges.push(first..end),
            }
        }
        ranges
    }

    /// Adds other blocks.
    ///
    /// # Errors
    ///
    /// [`Error::Mismatch`] if the degrees differ, if a block is in both, or if only some blocks have
    /// weights.
    pub fn merge(&mut self, other: Self) -> Result<(), Error> {
        crate::error::check_equal("degrees", &self.lmax, &other.lmax)?;
        other
            .nodes
            .into_iter()
            .try_for_each(|(first, node)| self.insert(first, node.level, node.sums))
    }

    /// Adds the sum of the blocks from `first` of a node of this level, and those above it that it
    /// completes.
    fn insert(&mut self, mut first: u64, mut level: u32, mut sums: Sums) -> Result<(), Error> {
        let mismatch = |what, left: u64, right: u64| Error::Mismatch {
            what,
            left: left.to_string(),
            right: right.to_string(),
        };
        let count = (self.lmax as u64 + 1).saturating_mul(self.lmax as u64 + 2) / 2;
        if sums.values.len() as u64 != count {
            return Err(mismatch("numbers of coefficients", count, sums.values.len() as u64));
        }
        let len = 1_u64.checked_shl(level).filter(|len| first.is_multiple_of(*len));
        let end = len.and_then(|len| first.checked_add(len));
        let Some(end) = end else {
            return Err(mismatch("nodes", first, level.into()));
        };
        if let Some((&other, node)) = self.nodes.range(..end).next_back()
            && other.saturating_add(node.len()) > first
        {
            return Err(mismatch("blocks (one is in both)", other, first));
        }
        if let Some(other) = self.nodes.values().next()
            && other.sums.weights.is_some() != sums.weights.is_some()
        {
            let count = |sums: &Sums| if sums.weights.is_some() { sums.n_points } else { 0 };
            return Err(mismatch("numbers of weights", count(&other.sums), count(&sums)));
        }
        loop {
            let len = 1 << level;
            let sibling = first ^ len;
            match self.nodes.remove(&sibling) {
                Some(node) if node.level == level => {
                    let (left, right) =
                        if sibling < first { (node.sums, sums) } else { (sums, node.sums) };
                    sums = left.plus(right);
                    first = first.min(sibling);
                    level += 1;
                }
                other => {
                    self.nodes.extend(other.map(|node| (sibling, node)));
                    self.nodes.insert(first, Node { level, sums });
                    return Ok(());
                }
            }
        }
    }

    /// Returns the coefficients of the set. Blocks that are missing are not counted. The nodes of an
    /// incomplete tree are added from the last to the first, which the number of blocks determines.
    ///
    /// # Errors
    ///
    /// [`Error::NoRealizations`] without any points.
    pub fn total(self, domain: Domain) -> Result<BlockTotal, Error> {
        let nodes = self.nodes.into_values().rev().map(|node| node.sums);
        let sums = nodes.reduce(|right, left| left.plus(right));
        let Some(sums) = sums.filter(|sums| sums.n_points > 0) else {
            return Err(Error::NoRealizations);
        };
        let n = sums.n_points as f64;
        let (mut n_effective, mut sum_w, mut sum_w2, mut squares) = (n, n, n, n);
        if let Some(weights) = &sums.weights {
            let sum = weights.sum.value();
            squares = weights.squares.value();
            let magnitude = weights.magnitude.value();
            let is_zero = sum.abs() <= f64::EPSILON * magnitude;
            n_effective = if is_zero { 0.0 } else { sum.powi(2) / squares };
            sum_w = libm::scalbn(sum, sums.exponent);
            sum_w2 = libm::scalbn(libm::scalbn(squares, sums.exponent), sums.exponent);
        }
        let tail = sums.tail.power();
        Ok(BlockTotal {
            n_points: sums.n_points,
            n_effective,
            has_weights: sums.weights.is_some(),
            sum_w,
            sum_w2,
            alm: Alm::from_values(self.lmax, sums.values)?,
            normalization: if squares > 0.0 { Domain::UNIT_POWER / squares } else { 0.0 },
            // Odd degrees do not exist on the hemisphere.
            tail: if domain == Domain::Sphere { tail } else { ByParity { odd: 0.0, ..tail } },
        })
    }
}

impl Node {
    fn len(&self) -> u64 {
        1_u64.checked_shl(self.level).unwrap_or(u64::MAX)
    }
}

impl Sums {
    /// Returns the sums of these points and those that follow.
    fn plus(mut self, mut right: Self) -> Self {
        let exponent = self.exponent.max(right.exponent);
        self.scale_to(exponent);
        right.scale_to(exponent);
        self.n_points = self.n_points.saturating_add(right.n_points);
        for (a, b) in self.values.iter_mut().zip(&right.values) {
            *a += b;
        }
        if let (Some(weights), Some(others)) = (&mut self.weights, &right.weights) {
            weights.sum.merge(&others.sum);
            weights.magnitude.merge(&others.magnitude);
            weights.squares.merge(&others.squares);
        }
        self.tail.merge(right.tail);
        self
    }

    /// Changes the scale of the weights, exactly unless they are negligible in the new one.
    fn scale_to(&mut self, exponent: i32) {
        let shift = self.exponent.saturating_sub(exponent);
        if shift == 0 {
            return;
        }
        self.exponent = exponent;
        let factor = libm::scalbn(1.0, shift);
        self.values.iter_mut().for_each(|a| *a *= factor);
        if let Some(WeightSums { sum, magnitude, squares }) = &mut self.weights {
            scale(sum, factor);
            scale(magnitude, factor);
            scale(squares, factor * factor);
        }
        self.tail.scale(factor);
    }
}

/// Multiplies a sum by a power of two. Of its bits, the first 106 remain.
fn scale(sum: &mut ExactSum, factor: f64) {
    let (value, rest) = sum.value_and_rest();
    let mut scaled = ExactSum::default();
    scaled.add(value * factor);
    scaled.add(rest * factor);
    *sum = scaled;
}

impl WeightSums {
    fn of(weights: &[f64]) -> Self {
        let mut sums = Self::default();
        for w in weights {
            sums.sum.add(*w);
            sums.magnitude.add(w.abs());
            sums.squares.add(w * w);
        }
        sums
    }
}

impl PartialEq for WeightSums {
    fn eq(&self, other: &Self) -> bool {
        let values =
            |sums: &Self| [&sums.sum, &sums.magnitude, &sums.squares].map(ExactSum::value_and_rest);
        values(self) == values(other)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use proptest::prelude::{ProptestConfig, any, prop, prop_assert_eq, proptest};
    use sphvar_samplers::{Pattern, PointSet, Purpose, Streams};
    use sphvar_sh::Domain;
    use sphvar_sht::{ExactTransform, Method, TransformWorkspace};

    use super::{BlockSums, BlockTotal, BlockTransform};
    use crate::{Error, Resolution, tail_power};

    const LMAX: usize = 12;

    fn white(n: usize) -> Vec<DVec3> {
        let sampler = Pattern::WhiteNoise.build(n, Domain::Sphere).unwrap();
        let mut rng = Streams::new(3, Purpose::Pattern, n).realization(0);
        sampler.sample(&mut rng).unwrap().points
    }

    /// Returns the sums of every block of `size` points.
    fn blocks(set: &PointSet, size: usize, domain: Domain, method: Method) -> Vec<BlockSums> {
        let resolution = Resolution { method, ..Resolution::new(LMAX, size) };
        let transform = BlockTransform::new(resolution, domain).unwrap();
        let mut workspace = TransformWorkspace::default();
        let starts = (0..set.len()).step_by(size);
        let block = |(number, start): (usize, usize)| {
            let end = set.len().min(start + size);
            let weights = set.weights.get(start..end).unwrap_or_default().to_vec();
            let block = PointSet { points: set.points[start..end].to_vec(), weights };
            transform.sums(number as u64, block, &mut workspace).unwrap()
        };
        starts.enumerate().map(block).collect()
    }

    fn total_of(blocks: impl IntoIterator<Item = BlockSums>, domain: Domain) -> BlockTotal {
        let mut sums = BlockSums::new(LMAX);
        blocks.into_iter().for_each(|block| sums.merge(block).unwrap());
        sums.total(domain).unwrap()
    }

    /// Sets that are hard to add: coincident points, one point more than a block, and weights of many
    /// magnitudes and both signs.
    fn hostile() -> Vec<(&'static str, PointSet)> {
        let points = white(129);
        let magnitudes = |k: usize| 10f64.powf((k * 37 % 61) as f64 - 30.0);
        let signed = (0..129).map(|k| magnitudes(k) * if k % 3 == 0 { -1.0 } else { 1.0 });
        let growing = (0..129).map(|k| 2f64.powi(4 * k - 300));
        let extreme = (0..129).map(|k| if k < 64 { 1e-300 * k as f64 } else { 1e300 });
        let zeros = (0..129).map(|k| if k < 40 { 0.0 } else { 1.0 });
        let weighted = |weights: Vec<f64>| PointSet { points: points.clone(), weights };
        vec![
            ("equal weights", PointSet::new(points.clone())),
            ("coincident", PointSet::new(vec![DVec3::new(0.6, 0.0, 0.8); 129])),
            ("signed", weighted(signed.collect())),
            ("growing", weighted(growing.collect())),
            ("extreme", weighted(extreme.collect())),
            ("blocks of zeros", weighted(zeros.collect())),
            ("all zero", weighted(vec![0.0; 129])),
        ]
    }

    /// Oracle: the definition, for the whole set.
    #[test]
    fn the_sum_of_blocks_is_the_transform_of_the_set() {
        for (name, set) in hostile() {
            let mut scaled = set.clone();
            scaled.normalize_weights();
            let weights = (!scaled.weights.is_empty()).then_some(&*scaled.weights);
            let exact = ExactTransform::new(LMAX).unwrap().adjoint(&scaled.points, weights);
            let exact = exact.unwrap();
            let magnitude: f64 = weights.map_or(129.0, |w| w.iter().map(|w| w.abs()).sum());
            let tail = tail_power(&scaled.points, &scaled.weights);
            for size in [1, 16, 128, 129, 1000] {
                for method in [Method::Exact, Method::Fast] {
                    let total =
                        total_of(blocks(&set, size, Domain::Sphere, method), Domain::Sphere);
                    assert_eq!(total.n_points, 129);
                    let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs();
                    assert!(near(total.n_effective, set.n_effective()), "{name} in {size}");
                    for (a, b) in total.alm.values().iter().zip(exact.values()) {
                        let error = (a - b).norm();
                        assert!(error <= 1e-11 * magnitude, "{name} in {size}: {a} and {b}");
                    }
                    let same = near(total.tail.even, tail.even) && near(total.tail.odd, tail.odd);
                    assert!(same, "{name} in {size}: {:?} and {tail:?}", total.tail);
                    let (sum, squares) = set.weight_sums();
                    let is_sum = near(total.sum_w, sum) || sum.abs() < 1e-14 * magnitude;
                    assert!(is_sum, "{name} in {size}: {} and {sum}", total.sum_w);
                    assert!(
                        total.sum_w2.to_bits() == squares.to_bits() || near(total.sum_w2, squares)
                    );
                }
            }
        }
    }

    #[test]
    fn points_of_the_hemisphere_are_folded() {
        let below: Vec<DVec3> = white(50).iter().map(|p| -p.abs()).collect();
        let above: Vec<DVec3> = below.iter().map(|p| -*p).collect();
        let total = |points: Vec<DVec3>| {
            let domain = Domain::Hemisphere;
            total_of(blocks(&PointSet::new(points), 7, domain, Method::Exact), domain)
        };
        let (below, above) = (total(below), total(above));
        assert_eq!(below.alm, above.alm);
        assert!((below.tail.even - 1.0).abs() < 1e-12 && below.tail.odd == 0.0);
    }

    #[test]
    fn blocks_that_do_not_fit_are_errors() {
        let set = PointSet::new(white(4));
        let all = blocks(&set, 1, Domain::Sphere, Method::Exact);
        let mut sums = BlockSums::new(LMAX);
        sums.merge(all[0].clone()).unwrap();
        sums.merge(all[1].clone()).unwrap();
        assert_eq!(sums.ranges(), vec![0..2]);
        for again in [&all[0], &all[1]] {
            assert!(matches!(sums.clone().merge(again.clone()), Err(Error::Mismatch { .. })));
        }
        assert!(sums.merge(BlockSums::new(LMAX + 1)).is_err());
        let weighted = PointSet { weights: vec![1.0; 4], ..set };
        let weighted = blocks(&weighted, 1, Domain::Sphere, Method::Exact);
        assert!(sums.merge(weighted[2].clone()).is_err());
        sums.merge(all[3].clone()).unwrap();
        assert_eq!(sums.ranges(), [0..2, 3..4]);
        assert_eq!(sums.total(Domain::Sphere).unwrap().n_points, 3);
        assert!(BlockSums::new(LMAX).total(Domain::Sphere).is_err());
    }

    /// Samples of large sets keep the share of coincident and antipodal points.
    #[test]
    fn tails_of_large_sets_are_those_of_a_sample() {
        let base = white(30_000);
        let antipodal: Vec<DVec3> = base
            .iter()
            .chain(&base)
            .enumerate()
            .map(|(k, p)| if k < base.len() { *p } else { -*p })
            .collect();
        let single = |points: &[DVec3]| -> Vec<DVec3> {
            points.iter().map(|p| p.as_vec3().as_dvec3().normalize()).collect()
        };
        let twice: Vec<DVec3> = base.iter().copied().chain(single(&base)).collect();
        let tail = |points: Vec<DVec3>| {
            let blocks = blocks(&PointSet::new(points), 7000, Domain::Sphere, Method::Fast);
            total_of(blocks, Domain::Sphere).tail
        };
        for (points, even, odd) in
            [(base.clone(), 1.0, 1.0), (antipodal, 2.0, 0.0), (twice, 2.0, 2.0)]
        {
            let tail = tail(points);
            assert!((tail.even - even).abs() < 1e-12 && (tail.odd - odd).abs() < 1e-12, "{tail:?}");
        }
        assert_eq!(tail(vec![DVec3::X; 40_000]).even.to_bits(), 40_000_f64.to_bits());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]

        /// Whichever parts the blocks are divided into, and in which order these are added.
        #[test]
        fn any_division_gives_the_same_bits(
            cuts in prop::collection::vec(0_usize..22, 0..6),
            keys in prop::collection::vec(any::<u32>(), 7),
            which in 0_usize..7,
        ) {
            let (_, set) = &hostile()[which];
            let all = blocks(set, 6, Domain::Sphere, Method::Exact);
            let mut cuts = cuts;
            cuts.extend([0, all.len()]);
            cuts.sort_unstable();
            let parts = cuts.windows(2).map(|cut| {
                let mut part = BlockSums::new(LMAX);
                all[cut[0]..cut[1]].iter().rev().for_each(|b| part.merge(b.clone()).unwrap());
                part
            });
            let mut parts: Vec<(u32, BlockSums)> = keys.iter().copied().cycle().zip(parts).collect();
            parts.sort_by_key(|(key, _)| *key);
            let whole = total_of(all.iter().cloned(), Domain::Sphere);
            let divided = total_of(parts.into_iter().map(|(_, part)| part), Domain::Sphere);
            let bits = |total: &BlockTotal| {
                let alm: Vec<u64> =
                    total.alm.values().iter().flat_map(|a| [a.re.to_bits(), a.im.to_bits()]).collect();
                let sums = [total.n_effective, total.sum_w, total.sum_w2, total.normalization];
                let tail = [total.tail.even, total.tail.odd];
                (alm, sums.map(f64::to_bits), tail.map(f64::to_bits))
            };
            prop_assert_eq!(bits(&whole), bits(&divided));
        }
    }
}
