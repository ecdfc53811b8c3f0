use num_complex::Complex;
use sphvar_nufft::parts::Real;
use sphvar_sh::{Alm, Domain};
use sphvar_sht::{DenseRingTransform, MirroredRings, RingSums};

use super::HealpixMap;
use super::belt_rings::BeltRings;
use super::cap_rings::{CapNode, CapRings};
use super::height_rule::HeightRule;
use crate::Error;

/// The Fourier coefficients over longitude of a map at the nodes of a quadrature over height.
struct Heights<'a> {
    rule: &'a HeightRule,
    lmax: usize,
    caps: CapRings,
    cap_nodes: Vec<CapNode>,
    belt: BeltRings,
}

/// Returns the coefficients of a map on a domain.
pub(super) fn coefficients(map: &HealpixMap, domain: Domain, lmax: usize) -> Result<Alm, Error> {
    let n = map.n();
    let rule = HeightRule::new(n, lmax)?;
    let transform = DenseRingTransform::new(lmax, rule.colatitudes())?;
    let whole = domain == Domain::Sphere;
    let caps = CapRings::new(&rule, &transform, |ring| {
        [Some(map.ring(ring - 1)), whole.then(|| map.ring(4 * n - 1 - ring))]
    });
    let nodes = |panel| rule.panel(panel).1.iter().map(move |node| (panel, node));
    let cap_nodes = (0..n).flat_map(nodes).map(|(panel, node)| caps.node(panel, node)).collect();
    let belt = map.belt(domain);
    let belt = BeltRings::new(n, lmax, belt);
    Ok(transform.adjoint(&Heights { rule: &rule, lmax, caps, cap_nodes, belt })?)
}

impl MirroredRings for Heights<'_> {
    #[inline(always)]
    fn add<const FUSED: bool>(&self, first: usize, sums: &mut RingSums<'_>) {
        let mut values = [[Complex::ZERO; RingSums::ORDERS]; 2];
        for (pair, node) in self.cap_nodes.iter().enumerate() {
            if !sums.is_negligible(pair) {
                self.caps.evaluate::<FUSED>(node, first, self.lmax, &mut values);
                sums.add::<FUSED>(pair, &values);
            }
        }
        self.add_belt::<FUSED>(first, sums);
    }
}

impl Heights<'_> {
    #[inline(always)]
    fn add_belt<const FUSED: bool>(&self, first: usize, sums: &mut RingSums<'_>) {
        let n = self.rule.nside();
        let orders = self.belt.orders(first);
        let (_, nodes) = self.rule.panel(n);
        // The intervals of the ring at the start of a panel shrink, those of the next one grow.
        let half = std::f64::consts::FRAC_PI_4 / n as f64;
        let width = |m: usize, share: f64| match m {
            0 => 2.0 * half * share,
            m if m > self.lmax => 0.0,
            m => 2.0 * (m as f64 * half * share).sin() / m as f64,
        };
        let widths = |share: f64, weight: f64| -> [f64; RingSums::ORDERS] {
            std::array::from_fn(|i| weight * width(first + i, share))
        };
        let widths: Vec<_> = nodes
            .iter()
            .map(|node| [1.0 - node.share, node.share].map(|share| widths(share, node.weight)))
            .collect();
        let last = self.belt.len() - 1;
        // Without a southern part, its rings are absent.
        let ring = |ring: usize| {
            let south = if last == 2 * n {
                self.belt.get(last - ring, &orders)
            } else {
                [Complex::ZERO; RingSums::ORDERS]
            };
            [self.belt.get(ring, &orders), south]
        };
        let mut from = ring(0);
        let mut values = [[Complex::ZERO; RingSums::ORDERS]; 2];
        for panel in 0..n {
            let to = ring(panel + 1);
            let (pair, nodes) = self.rule.panel(n + panel);
            for (pair, widths) in (pair..pair + nodes.len()).zip(&widths) {
                if sums.is_negligible(pair) {
                    continue;
                }
                for (values, (from, to)) in values.iter_mut().zip(from.iter().zip(&to)) {
                    for i in 0..RingSums::ORDERS {
                        let ([before, after], from, to) =
                            ([widths[0][i], widths[1][i]], from[i], to[i]);
                        values[i] = Complex::new(
                            from.re.times_plus::<FUSED>(before, to.re * after),
                            from.im.times_plus::<FUSED>(before, to.im * after),
                        );
                    }
                }
                sums.add::<FUSED>(pair, &values);
            }
            from = to;
        }
    }
}
