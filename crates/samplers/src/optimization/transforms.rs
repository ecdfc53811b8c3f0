use sphvar_sht::TransformWorkspace;

/// The number of points from which the transforms of an optimization use all threads.
///
/// Sets of fewer points are optimized in a fraction of a second, and mostly many side by side,
/// which occupies all threads anyway.
const MIN_DIVIDED: usize = 16384;

/// Returns a workspace for the transforms of an optimization of `n_points` points.
///
/// Many points use all threads of the current rayon pool: where sets are generated side by side,
/// the other threads are busy, and each set remains on its own. Results are bit-identical for any
/// number of threads.
pub(super) fn workspace(n_points: usize) -> TransformWorkspace {
    if n_points < MIN_DIVIDED {
        TransformWorkspace::default()
    } else {
        TransformWorkspace::parallel()
    }
}

#[cfg(test)]
mod tests {
    use sphvar_sh::Alm;
    use sphvar_sht::{Method, Transform};

    use super::*;
    use crate::{Domain, Pattern, Purpose, Streams};

    #[test]
    fn divided_transforms_are_bit_identical_to_those_of_one_thread() {
        let mut rng = Streams::new(2, Purpose::Pattern, 0).realization(0);
        let pattern = Pattern::WhiteNoise.build(MIN_DIVIDED, Domain::Sphere).unwrap();
        let points = pattern.sample(&mut rng).unwrap().points;
        let transform = Transform::new(Method::Fast, 100, points.len(), 1e-5).unwrap();
        let run = |mut workspace: TransformWorkspace| {
            let mut alms = [Alm::zeros(100).unwrap()];
            transform.adjoint_batch_into(&[(&points, None)], &mut workspace, &mut alms);
            alms[0].energy_per_degree().into_iter().map(f64::to_bits).collect::<Vec<_>>()
        };
        let expected = run(TransformWorkspace::default());
        for threads in [1, 2, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert_eq!(pool.install(|| run(workspace(MIN_DIVIDED))), expected, "{threads}");
        }
    }
}
