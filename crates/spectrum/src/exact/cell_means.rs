use std::f64::consts::PI;

use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::Progress;
use sphvar_sh::Alm;
use sphvar_sht::{Method, Transform, TransformWorkspace};

use super::EPSILON;
use super::partition::{CongruentStrata, Partition};
use crate::{Error, ExactSum};

/// Returns `1 - (1/N) sum_k E P_l(x.y)` for l from 0 to `lmax`. The addition theorem expresses it
/// by the means of the harmonics over the strata:
///
/// ```text
/// (1/N) sum_k E P_l(x.y) = (4 pi/N) sum_k 1/(2l+1) sum_m |E_k Y_lm|^2
/// ```
///
/// The quadrature is accurate up to degree `degree`.
pub(super) fn power(
    partition: &Partition,
    degree: usize,
    lmax: usize,
    progress: &dyn Progress,
) -> Result<Vec<f64>, Error> {
    let transform = Transform::new(Method::Auto, lmax, partition.max_nodes(degree), EPSILON)?;
    let zeros = || vec![ExactSum::default(); lmax + 1];
    let begin = || {
        Ok(Worker {
            alm: [Alm::zeros(lmax)?],
            workspace: TransformWorkspace::default(),
            sums: zeros(),
        })
    };
    let sums = (0..partition.n_rows())
        .into_par_iter()
        .flat_map_iter(|row| partition.row(row))
        .fold(begin, |worker: Result<Worker, Error>, class| {
            let mut worker = worker?;
            let nodes = worker.add(&transform, &class, degree)?;
            progress.tick(class_work(nodes, lmax))?;
            Ok(worker)
        })
        .map(|worker| Ok(worker?.sums))
        .reduce(
            || Ok(zeros()),
            |a: Result<Vec<ExactSum>, Error>, b| {
                let mut a = a?;
                for (mine, theirs) in a.iter_mut().zip(&b?) {
                    mine.merge(theirs);
                }
                Ok(a)
            },
        )?;
    Ok(sums.iter().map(|sum| 1.0 - 4.0 * PI * sum.value()).collect())
}

/// The buffers of one thread.
struct Worker {
    alm: [Alm; 1],
    workspace: TransformWorkspace,
    sums: Vec<ExactSum>,
}

impl Worker {
    /// Adds a class and returns the number of its nodes.
    fn add(
        &mut self,
        transform: &Transform,
        class: &CongruentStrata,
        degree: usize,
    ) -> Result<usize, Error> {
        let nodes = class.quadrature(degree)?;
        let set = [(&*nodes.points, Some(&*nodes.weights))];
        transform.adjoint_batch_into(&set, &mut self.workspace, &mut self.alm);
        for (sum, p) in self.sums.iter_mut().zip(self.alm[0].power_per_degree()) {
            sum.add(class.share * p);
        }
        Ok(nodes.points.len())
    }
}

/// Returns the nominal work of all classes, as ticked by [`power`].
pub(super) fn work(partition: &Partition, lmax: usize) -> f64 {
    partition.nodes(lmax).into_iter().map(|(classes, n)| classes * class_work(n, lmax)).sum()
}

/// Returns the memory in bytes per thread.
pub(super) fn bytes(partition: &Partition, lmax: usize) -> f64 {
    let nodes = partition.max_nodes(lmax);
    Method::Auto.bytes(nodes, lmax, 1) + 32.0 * nodes as f64 + 150.0 * lmax as f64
}

fn class_work(n_nodes: usize, lmax: usize) -> f64 {
    Method::Auto.nominal_work(n_nodes, lmax)
}
