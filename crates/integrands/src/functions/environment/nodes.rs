//! The quadrature over theta.

use std::f64::consts::{FRAC_PI_2, PI};

use sphvar_sh::{Colatitude, Domain, GaussLegendre};

use super::EnvironmentMap;
use crate::Error;

/// A node of the quadrature over theta.
pub(super) struct Node {
    pub(super) colatitude: Colatitude,
    /// The rows on either side and the share of the second.
    pub(super) rows: (usize, usize),
    pub(super) share: f64,
    /// Weight of the rule times sin(theta).
    pub(super) weight: f64,
}

impl EnvironmentMap {
    /// Returns nodes and weights for integrals over theta of the map times functions of degree up to
    /// `degree`, to rounding.
    pub(super) fn nodes(&self, domain: Domain, degree: usize) -> Result<Vec<Node>, Error> {
        self.nodes_between(&[], domain, degree)
    }

    /// Returns [`nodes`](Self::nodes) for functions that are not smooth at some increasing
    /// colatitudes.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "row numbers and node counts are small"
    )]
    pub(super) fn nodes_between(
        &self,
        edges: &[f64],
        domain: Domain,
        degree: usize,
    ) -> Result<Vec<Node>, Error> {
        let end = match domain {
            Domain::Sphere => PI,
            Domain::Hemisphere => FRAC_PI_2,
        };
        let step = PI / self.height as f64;
        // The phase varies by `degree step / 2` radians to either side of the middle of a panel;
        // with more than half that number of nodes the error of the rule falls faster than
        // exponentially.
        let rule = GaussLegendre::new((0.25 * degree as f64 * step) as usize + 12)?;
        let last = self.height - 1;
        let mut nodes = Vec::new();
        let mut from = 0.0;
        // Panel p lies between the centres of rows p - 1 and p.
        for panel in 0..=self.height {
            let to = if panel > last { end } else { f64::min((panel as f64 + 0.5) * step, end) };
            if to <= from {
                break;
            }
            let rows = (panel.saturating_sub(1), panel.min(last));
            let (start, end_of_panel) = (from, to);
            let within = edges.iter().copied().filter(|&x| start < x && x < end_of_panel);
            for to in within.chain([end_of_panel]) {
                let half = 0.5 * (to - from);
                for (&x, &w) in rule.nodes().iter().zip(rule.weights()) {
                    let theta = from + half * (1.0 + x);
                    let colatitude = Colatitude::from_theta(theta)?;
                    let share = theta / step + 0.5 - panel as f64;
                    let weight = half * w * colatitude.sin();
                    nodes.push(Node { colatitude, rows, share, weight });
                }
                from = to;
            }
        }
        Ok(nodes)
    }
}
