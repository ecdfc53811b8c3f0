use glam::DVec3;
use sphvar_samplers::{Domain, Pattern, PointSet, Purpose, Streams};
use sphvar_sht::TransformWorkspace;
use sphvar_spectrum::{BlockSums, BlockTransform, Resolution};

use crate::Errors;
use crate::reference::DoubleDouble;
use crate::transforms::Definition;

const LMAX: usize = 24;
/// The number of points of a block.
const SIZE: usize = 64;

/// Compares the coefficients of sets in blocks, added in two orders, with the definition in twice the
/// working precision.
pub(super) fn errors() -> Errors {
    let mut errors = Errors::default();
    for (name, set) in sets() {
        let resolution = Resolution::new(LMAX, SIZE);
        let transform = BlockTransform::new(resolution, Domain::Sphere).expect("a low degree");
        let mut workspace = TransformWorkspace::default();
        let starts: Vec<usize> = (0..set.len()).step_by(SIZE).collect();
        let mut blocks = Vec::new();
        for (number, &start) in starts.iter().enumerate() {
            let range = start..set.len().min(start + SIZE);
            let weights = set.weights.get(range.clone()).unwrap_or_default().to_vec();
            let block = PointSet { points: set.points[range].to_vec(), weights };
            let sums = transform.sums(number as u64, block, &mut workspace);
            blocks.push(sums.expect("points on the sphere"));
        }
        let total = |blocks: &mut dyn Iterator<Item = &BlockSums>| {
            let mut sums = BlockSums::new(LMAX);
            blocks.for_each(|block| sums.merge(block.clone()).expect("each block once"));
            sums.total(Domain::Sphere).expect("a set with points").alm
        };
        let (alm, reversed) = (total(&mut blocks.iter()), total(&mut blocks.iter().rev()));
        let bits = |a: f64, b: f64| a.to_bits() == b.to_bits();
        let are_same = alm
            .values()
            .iter()
            .zip(reversed.values())
            .all(|(a, b)| bits(a.re, b.re) && bits(a.im, b.im));
        errors.push(if are_same { 0.0 } else { f64::INFINITY }, || format!("the bits of {name}"));
        let mut scaled = set.clone();
        scaled.normalize_weights();
        let weights = (!scaled.weights.is_empty()).then_some(&*scaled.weights);
        let definition = Definition::new(&scaled.points, weights);
        let (mut error, mut norm) = (0.0, 0.0);
        for m in 0..=LMAX {
            for (a, exact) in alm.column(m).iter().zip(definition.column(m, LMAX)) {
                let re = DoubleDouble::from(a.re) - exact.re;
                let im = DoubleDouble::from(a.im) - exact.im;
                error += re.value().powi(2) + im.value().powi(2);
                norm += exact.re.value().powi(2) + exact.im.value().powi(2);
            }
        }
        errors.push((error / norm).sqrt(), || name.to_owned());
    }
    errors
}

/// Returns sets that are hard to add, with their names.
fn sets() -> [(&'static str, PointSet); 3] {
    let white = |n: usize| {
        let sampler = Pattern::WhiteNoise.build(n, Domain::Sphere).expect("any number of points");
        let mut rng = Streams::new(0, Purpose::Pattern, n).realization(0);
        sampler.sample(&mut rng).expect("white noise is feasible").points
    };
    let magnitude = |k: i32| 10_f64.powi(k * 37 % 61 - 30);
    [
        ("coincident points", PointSet::new(vec![DVec3::new(0.48, 0.6, 0.64); 5 * SIZE])),
        ("one block and one point", PointSet::new(white(SIZE + 1))),
        (
            "weights of 1e-30 to 1e30",
            PointSet { points: white(257), weights: (0..257).map(magnitude).collect() },
        ),
    ]
}
