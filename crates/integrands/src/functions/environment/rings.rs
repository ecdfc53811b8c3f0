//! Coefficients of a map from the Fourier transforms of its rows.

use std::f64::consts::{PI, TAU};

use num_complex::Complex;
use sphvar_nufft::parts::{FftDirection, Real};
use sphvar_sh::{Alm, Colatitude};
use sphvar_sht::{DenseRingTransform, MirroredRings, RingSums, RingTransform, RingWorkspace};

use super::EnvironmentMap;
use super::nodes::Node;
use crate::Error;

/// From this ratio of rings to degrees on, [`DenseRingTransform`] is faster.
const DENSE: usize = 2;
/// The distance of a northern node from the reflection of a southern one, in radians, that is due to
/// rounding: both are the same node of a symmetric rule.
const ROUNDING: f64 = 4e-15;

/// The Fourier coefficients over longitude of a map at the nodes of a quadrature over theta.
struct Rows<'a> {
    /// The discrete Fourier transform of each row, without the phase of the half texel.
    spectra: Vec<Complex<f64>>,
    width: usize,
    /// The factor of each order.
    hats: Vec<Complex<f64>>,
    nodes: &'a [Node],
}

/// The rows at a node, with their weights.
#[derive(Clone, Copy)]
struct Weighted {
    rows: (usize, usize),
    weights: [f64; 2],
}

/// A colatitude of the northern hemisphere with the nodes there and at its reflection.
struct Pair {
    theta: f64,
    nodes: [Option<Weighted>; 2],
}

/// [`Rows`] by colatitude.
struct Pairs<'a> {
    rows: &'a Rows<'a>,
    pairs: Vec<Pair>,
}

/// Returns the coefficients to degree `lmax` of a map with the weights of nodes over theta.
pub(super) fn coefficients(
    map: &EnvironmentMap,
    nodes: &[Node],
    lmax: usize,
) -> Result<Alm, Error> {
    let rows = Rows::new(map, nodes, lmax);
    if nodes.len() < DENSE * (lmax + 2) { rows.by_rings(lmax) } else { rows.by_dense_rings(lmax) }
}

impl<'a> Rows<'a> {
    fn new(map: &EnvironmentMap, nodes: &'a [Node], lmax: usize) -> Self {
        let mut spectra: Vec<_> = map.texels.iter().map(|&x| Complex::new(x, 0.0)).collect();
        f64::fourier_plan(map.width, FftDirection::Forward).process(&mut spectra);
        let texel = TAU / map.width as f64;
        let hat = |m: usize| {
            // A hat of half-width `texel` around each centre has the transform texel sinc^2.
            let half = 0.5 * texel * m as f64;
            let sinc = if m == 0 { 1.0 } else { half.sin() / half };
            Complex::cis(-half - map.first_longitude * m as f64) * (texel * sinc * sinc)
        };
        Self { spectra, width: map.width, hats: (0..=lmax).map(hat).collect(), nodes }
    }

    /// Returns the coefficients of every row at some orders; 0 beyond the last order.
    fn at_orders<const N: usize>(&self, first: usize) -> Vec<[Complex<f64>; N]> {
        let orders: [(usize, Complex<f64>); N] = std::array::from_fn(|i| {
            let hat = self.hats.get(first + i).copied().unwrap_or_default();
            ((first + i) % self.width, hat)
        });
        let rows = self.spectra.chunks_exact(self.width);
        rows.map(|row| orders.map(|(column, hat)| row[column] * hat)).collect()
    }

    fn weighted(node: &Node) -> Weighted {
        let Node { rows, share, weight, .. } = *node;
        Weighted { rows, weights: [weight * (1.0 - share), weight * share] }
    }

    /// Returns the coefficients by the sum over all rings.
    fn by_rings(&self, lmax: usize) -> Result<Alm, Error> {
        let mut alm = Alm::zeros(lmax)?;
        RingTransform::new(lmax)?.adjoint_into(
            self.nodes.iter().map(|n| n.colatitude),
            |m, fourier| {
                let rows = self.at_orders::<1>(m);
                for (f, node) in fourier.iter_mut().zip(self.nodes) {
                    let Weighted { rows: (i, j), weights } = Self::weighted(node);
                    *f = rows[i][0] * weights[0] + rows[j][0] * weights[1];
                }
            },
            &mut RingWorkspace::default(),
            &mut alm,
        );
        Ok(alm)
    }

    /// Returns the same coefficients, to rounding, at a cost that hardly depends on the number of
    /// rings.
    fn by_dense_rings(&self, lmax: usize) -> Result<Alm, Error> {
        let pairs = Pairs { rows: self, pairs: pairs(self.nodes) };
        let colatitudes = pairs.pairs.iter().map(|pair| Colatitude::from_theta(pair.theta));
        let colatitudes: Vec<_> = colatitudes.collect::<Result<_, _>>()?;
        Ok(DenseRingTransform::new(lmax, colatitudes)?.adjoint(&pairs)?)
    }
}

/// Returns nodes by their colatitude or that of their reflection, ascending.
fn pairs(nodes: &[Node]) -> Vec<Pair> {
    let place = |node: &Node| {
        let theta = node.colatitude.sin().atan2(node.colatitude.cos().abs()).min(0.5 * PI);
        (theta, usize::from(node.colatitude.is_south()), Rows::weighted(node))
    };
    let mut places: Vec<_> = nodes.iter().map(place).collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut pairs: Vec<Pair> = Vec::with_capacity(places.len());
    for (theta, half, weighted) in places {
        let own = pairs.last_mut().filter(|pair| theta - pair.theta <= ROUNDING);
        match own.map(|pair| &mut pair.nodes[half]) {
            Some(free @ None) => *free = Some(weighted),
            _ => {
                let mut nodes = [None; 2];
                nodes[half] = Some(weighted);
                pairs.push(Pair { theta, nodes });
            }
        }
    }
    pairs
}

impl MirroredRings for Pairs<'_> {
    #[inline(always)]
    fn add<const FUSED: bool>(&self, first: usize, sums: &mut RingSums<'_>) {
        const ORDERS: usize = RingSums::ORDERS;
        let rows = self.rows.at_orders::<ORDERS>(first);
        for (ring, pair) in self.pairs.iter().enumerate() {
            if sums.is_negligible(ring) {
                continue;
            }
            let mut values = [[Complex::ZERO; ORDERS]; 2];
            for (values, node) in values.iter_mut().zip(&pair.nodes) {
                let Some(Weighted { rows: (i, j), weights: [before, after] }) = *node else {
                    continue;
                };
                for ((value, from), to) in values.iter_mut().zip(&rows[i]).zip(&rows[j]) {
                    *value = Complex::new(
                        from.re.times_plus::<FUSED>(before, to.re * after),
                        from.im.times_plus::<FUSED>(before, to.im * after),
                    );
                }
            }
            sums.add::<FUSED>(ring, &values);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{EnvironmentMap, Node, Rows, pairs};
    use crate::Domain;

    /// Both methods on maps of few and of many rows, at degrees below and beyond the texels, on both
    /// domains, and with nodes that have no reflection.
    #[test]
    fn dense_rings_give_the_sum_over_all_rings() {
        for height in [1, 2, 7, 32] {
            let texel = |k: usize| ((k * 2_654_435_761) % 1009) as f64 / 1009.0 - 0.3;
            let texels = (0..2 * height * height).map(texel).collect();
            let map = EnvironmentMap::new(2 * height, height, texels).unwrap();
            let map = map.with_first_longitude(0.7);
            for (domain, edges) in [
                (Domain::Sphere, &[][..]),
                (Domain::Hemisphere, &[]),
                (Domain::Sphere, &[0.4, 2.0]),
            ] {
                for lmax in [1, 7, 65] {
                    let nodes = map.nodes_between(edges, domain, lmax).unwrap();
                    let rows = Rows::new(&map, &nodes, lmax);
                    let by_rings = rows.by_rings(lmax).unwrap();
                    let dense = rows.by_dense_rings(lmax).unwrap();
                    let size = by_rings.values().iter().map(|a| a.norm()).fold(0.0, f64::max);
                    for (a, b) in by_rings.values().iter().zip(dense.values()) {
                        let case = format!("{height} rows, {domain}, {edges:?}, {lmax}");
                        assert!((a - b).norm() < 1e-14 * size, "{case}: {a}, {b}");
                    }
                }
            }
        }
    }

    #[test]
    fn nodes_of_both_hemispheres_are_paired() {
        for height in [1, 2, 7, 256] {
            let map = EnvironmentMap::new(2 * height, height, vec![1.0; 2 * height * height]);
            let map = map.unwrap();
            for degree in [2, 300] {
                let nodes: Vec<Node> = map.nodes(Domain::Sphere, degree).unwrap();
                let n_pairs = pairs(&nodes).len();
                // A node at the equator has no reflection.
                assert_eq!(n_pairs, nodes.len().div_ceil(2), "{height} rows, degree {degree}");
            }
        }
    }
}
