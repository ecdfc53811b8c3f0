use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use sphvar_sh::GaussLegendre;

use crate::Error;

/// The behaviour of the integrand at the ends of an interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Ends {
    /// The integrand is analytic to both ends.
    Smooth,
    /// It may be a non-integer power of the distance to an end.
    Rough,
}

/// Cached rules on [0, 1] by number of nodes: fractions of the interval and weights.
#[derive(Default)]
pub(super) struct PanelRules(BTreeMap<(Ends, usize), Vec<(f64, f64)>>);

impl PanelRules {
    /// Returns the rule for functions that oscillate as `e^{ix}` over an interval of length
    /// `phase`.
    ///
    /// Rough ends are handled by `x = t^4 (35 - 84 t + 70 t^2 - 20 t^3)`, whose first three
    /// derivatives vanish at both ends: a power a becomes the power 4a + 3, which a root makes a
    /// polynomial.
    pub(super) fn rule(&mut self, ends: Ends, phase: f64) -> Result<&[(f64, f64)], Error> {
        let n = Self::len(ends, phase);
        Ok(match self.0.entry((ends, n)) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => place.insert(nodes(ends, n)?),
        })
    }

    /// Returns the number of nodes of the rule.
    pub(super) fn len(ends: Ends, phase: f64) -> usize {
        match ends {
            Ends::Smooth => node_count(0.5 * phase),
            // The maximum slope of the polynomial is 35/16.
            Ends::Rough => node_count(35.0 / 32.0 * phase) + ROUGH_NODES,
        }
    }
}

/// Returns the rule of n nodes on [0, 1].
fn nodes(ends: Ends, n: usize) -> Result<Vec<(f64, f64)>, Error> {
    let rule = GaussLegendre::new(n)?;
    let place = |(&x, &w): (&f64, &f64)| {
        let (t, rest, w) = (0.5 * (1.0 + x), 0.5 * (1.0 - x), 0.5 * w);
        match ends {
            Ends::Smooth => (t, w),
            Ends::Rough => (graded(t, rest), w * 140.0 * (t * rest).powi(3)),
        }
    };
    Ok(rule.nodes().iter().zip(rule.weights()).map(place).collect())
}

/// Nodes that a rule with rough ends has beyond those of the oscillation, for its own polynomial
/// and for branch points behind the ends.
const ROUGH_NODES: usize = 40;

/// Returns the smoothstep of degree 7 at t, `rest` being 1 - t.
fn graded(t: f64, rest: f64) -> f64 {
    let start = |t: f64| t.powi(4) * (35.0 + t * (-84.0 + t * (70.0 - 20.0 * t)));
    if t <= 0.5 { start(t) } else { 1.0 - start(rest) }
}

/// Returns the minimum number of Gauss-Legendre nodes on [-1, 1] for `e^{ikx}` to rounding.
///
/// The error is below `(e k/(4n))^{2n}`, the remainder of the Taylor series of degree 2n with
/// Stirling's formula; a few extra nodes allow for deviations from an exponential.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "not negative, and brought into range"
)]
pub(crate) fn node_count(k: f64) -> usize {
    /// `-ln` of the accuracy, 1e-18.
    const DIGITS: f64 = 41.0;
    let enough = |n: usize| {
        let n = n as f64;
        2.0 * n * (4.0 * n / (std::f64::consts::E * k.max(1e-3))).ln() >= DIGITS
    };
    // The remainder is below 1 from n = e k/4, and a few dozen more nodes always suffice.
    let mut n = (0.25 * std::f64::consts::E * k).ceil().min(1e9) as usize;
    while !enough(n + 1) {
        n += 1;
    }
    n + 4
}
