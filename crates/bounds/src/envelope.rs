//! The tightest break and plateau for the confidence limits of a spectrum, at a given exponent and
//! offset.

use crate::zeta::hurwitz_zeta;
use crate::{MeasuredSpectrum, Side};

/// Confidence limits of a spectrum on one side, with the weights of the worst case `l^-p`.
#[derive(Debug, Clone)]
pub(crate) struct Envelope {
    side: Side,
    degrees: Vec<f64>,
    limits: Vec<f64>,
    /// The strictest limit from a degree on, which a plateau that begins there must satisfy.
    strictest: Vec<f64>,
    /// `l^-p`.
    weights: Vec<f64>,
    /// The sum of the weights from a degree on, including those beyond the spectrum.
    tails: Vec<f64>,
}

/// A break `L` and a plateau, with the value `sum_l l^-p P(l)` of their profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Candidate {
    pub(crate) value: f64,
    pub(crate) exponent: f64,
    pub(crate) offset: f64,
    pub(crate) break_degree: f64,
    pub(crate) gamma: f64,
}

impl Envelope {
    /// Returns the envelope of limits, one for each degree of the spectrum, with weights
    /// `l^-decay`.
    pub(crate) fn new(
        side: Side,
        spectrum: &MeasuredSpectrum<'_>,
        limits: Vec<f64>,
        decay: f64,
    ) -> Self {
        let degrees: Vec<f64> = spectrum.degrees().map(|l| l as f64).collect();
        let weights: Vec<f64> = degrees.iter().map(|l| l.powf(-decay)).collect();
        // Beyond the spectrum: degrees l = step j from the next j on.
        let step = degrees[0];
        let next = degrees[degrees.len() - 1] / step + 1.0;
        let mut tail = step.powf(-decay) * hurwitz_zeta(decay, next);
        // From the smallest terms to the largest, to limit rounding.
        let mut tails: Vec<f64> =
            weights.iter().rev().map(|w| running(&mut tail, |t| t + w)).collect();
        tails.reverse();
        let mut bound = limits[limits.len() - 1];
        let mut strictest: Vec<f64> =
            limits.iter().rev().map(|&x| running(&mut bound, |b| stricter(side, b, x))).collect();
        strictest.reverse();
        Self { side, degrees, limits, strictest, weights, tails }
    }

    /// Returns `sum_l l^-p`, the value of the profile that is 1 everywhere.
    pub(crate) fn white(&self) -> f64 {
        self.tails[0]
    }

    /// Returns the limit that every offset must satisfy; the offset of a best bound does not exceed
    /// it.
    pub(crate) fn largest_offset(&self) -> f64 {
        self.strictest[0]
    }

    /// Returns the best break and plateau, or `None` if none satisfies the limits.
    ///
    /// The break is restricted to the spectrum, since a plateau beyond it would be determined by no
    /// degree.
    pub(crate) fn best(&self, exponent: f64, offset: f64) -> Option<Candidate> {
        if self.side == Side::Lower && offset > self.strictest[0] {
            return None;
        }
        if exponent.is_infinite() {
            self.best_step(offset)
        } else {
            Some(self.sweep(exponent, exponent, offset))
        }
    }

    /// Returns a bound on the value of all profiles whose exponent and offset lie in these ranges;
    /// it is the exact optimum if the ranges are points.
    ///
    /// For upper bounds a smaller exponent requires a lower plateau and a larger exponent gives a
    /// smaller sum. The best break with the plateau of the one end and the sum of the other is
    /// therefore at least as good as any profile of the range. The same applies to the offset. For
    /// lower bounds the two ends are exchanged.
    pub(crate) fn relaxed(&self, exponent: (f64, f64), offset: (f64, f64)) -> Option<f64> {
        let (plateau, sum, high, low) = match self.side {
            Side::Upper => (exponent.0, exponent.1, offset.1, offset.0),
            Side::Lower => (exponent.1, exponent.0, offset.0, offset.1),
        };
        let found = if plateau.is_infinite() {
            self.best(plateau, high)?
        } else {
            self.sweep(plateau, sum, high)
        };
        Some(found.value + (low - high) * self.white())
    }

    /// Returns the best break if the plateau follows from the exponent b and the sum is computed
    /// with the exponent s; with `b = s` this is the best profile.
    ///
    /// Between two neighbouring degrees the plateau must satisfy `A` and the head `C L^b`, with A
    /// and C fixed. Where A decides, the value of an upper bound falls with L. Where C decides, the
    /// value is `C (H L^(b-s) + T L^b)`, which rises for `b = s`. The best break is therefore at
    /// the crossing, `L^b = A/C`, or beyond it at the minimum of the second form,
    /// `L^s = H (s-b)/(T b)`, or at the nearest end. For lower bounds, with `s <= b`, rising and
    /// falling are exchanged. No search is needed: there is one candidate between two degrees,
    /// `O(lmax)` in all.
    fn sweep(&self, b: f64, s: f64, offset: f64) -> Candidate {
        let over = |limit: f64| (limit - offset).max(0.0);
        let candidate = |sum: f64, gamma: f64, break_degree: f64| Candidate {
            value: offset * self.white() + gamma * sum,
            exponent: b,
            offset,
            break_degree,
            gamma,
        };
        let mut best = candidate(self.tails[0], over(self.strictest[0]), self.degrees[0]);
        if b == 0.0 && s == 0.0 {
            return best;
        }
        let one_exponent = b.to_bits() == s.to_bits();
        // l^b and l^s of the last degree below the break; the requirement of the head; the sum of
        // l^(s-p).
        let powers = |l: f64| (l.powf(b), if one_exponent { l.powf(b) } else { l.powf(s) });
        let mut before = powers(self.degrees[0]);
        let mut head = over(self.limits[0]) / before.0;
        let mut sum = self.weights[0] * before.1;
        for k in 1..self.degrees.len() {
            let here = powers(self.degrees[k]);
            let (plateau, tail) = (over(self.strictest[k]), self.tails[k]);
            // If the head requires nothing, the larger break is better.
            let crossing = if head > 0.0 { plateau / head } else { here.0 };
            let mut at = if crossing <= before.0 {
                before
            } else if crossing >= here.0 {
                here
            } else {
                (crossing, if one_exponent { crossing } else { crossing.powf(s / b) })
            };
            if self.side == Side::Upper && s > b {
                let required = sum * (s - b) / (tail * b);
                if required >= here.1 {
                    at = here;
                } else if required > at.1 {
                    at = (required.powf(b / s), required);
                }
            }
            let gamma = stricter(self.side, plateau, head * at.0);
            let break_degree = if one_exponent { at.0.powf(b.recip()) } else { f64::NAN };
            let found = candidate(sum / at.1 + tail, gamma, break_degree);
            if self.better(found.value, best.value) {
                best = found;
            }
            head = stricter(self.side, head, over(self.limits[k]) / here.0);
            sum += self.weights[k] * here.1;
            before = here;
        }
        best
    }

    fn best_step(&self, offset: f64) -> Option<Candidate> {
        let mut best: Option<Candidate> = None;
        for k in 1..self.degrees.len() {
            if self.side == Side::Upper && self.limits[k - 1] > offset + MeasuredSpectrum::NO_POWER
            {
                break;
            }
            let gamma = (self.strictest[k] - offset).max(0.0);
            let value = offset * self.white() + gamma * self.tails[k];
            if best.is_none_or(|b| self.better(value, b.value)) {
                let break_degree = 0.5 * (self.degrees[k - 1] + self.degrees[k]);
                best =
                    Some(Candidate { value, exponent: f64::INFINITY, offset, break_degree, gamma });
            }
        }
        best
    }

    /// Returns whether the first value makes a tighter bound than the second.
    pub(crate) fn better(&self, value: f64, than: f64) -> bool {
        match self.side {
            Side::Upper => value < than,
            Side::Lower => value > than,
        }
    }

    pub(crate) fn side(&self) -> Side {
        self.side
    }
}

/// Returns the stricter of two limits, which a bound must satisfy to satisfy both.
fn stricter(side: Side, a: f64, b: f64) -> f64 {
    match side {
        Side::Upper => a.max(b),
        Side::Lower => a.min(b),
    }
}

fn running(state: &mut f64, next: impl FnOnce(f64) -> f64) -> f64 {
    *state = next(*state);
    *state
}
