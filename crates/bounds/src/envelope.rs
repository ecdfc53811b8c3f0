//! The tightest break and plateau over the confidence limits of a spectrum, for a given exponent and offset.

use crate::zeta::hurwitz_zeta;
use crate::{MeasuredSpectrum, Side};

/// Confidence limits of a spectrum on one side, with the weights of the worst case `l^-p`.
#[derive(Debug, Clone)]
pub(crate) struct Envelope {
    side: Side,
    degrees: Vec<f64>,
    limits: Vec<f64>,
    /// The strictest of the limits from a degree on: what a plateau that begins there must clear.
    strictest: Vec<f64>,
    /// `l^-p`.
    weights: Vec<f64>,
    /// The sum of the weights from a degree on, those beyond the spectrum included.
    tails: Vec<f64>,
}

/// A break `L` and a plateau, with the value `sum_l l^-p P(l)` of the profile that they make.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Candidate {
    pub(crate) value: f64,
    pub(crate) exponent: f64,
    pub(crate) offset: f64,
    pub(crate) break_degree: f64,
    pub(crate) gamma: f64,
}

impl Envelope {
    /// Returns the envelope of limits, one for each degree of the spectrum, for weights `l^-decay`.
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
        // From the smallest terms to the largest, so that little is lost.
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

    /// Returns the largest degree over the smallest.
    pub(crate) fn span(&self) -> f64 {
        self.degrees[self.degrees.len() - 1] / self.degrees[0]
    }

    /// Returns the limit that every offset must clear: what no offset of a best bound is above.
    pub(crate) fn largest_offset(&self) -> f64 {
        self.strictest[0]
    }

    /// Returns the best break and plateau, or `None` if none clears the limits.
    ///
    /// The break lies within the spectrum: what a plateau would be that no degree has seen is unknown.
    pub(crate) fn best(&self, exponent: f64, offset: f64) -> Option<Candidate> {
        if self.side == Side::Lower && offset > self.strictest[0] {
            return None;
        }
        if exponent.is_infinite() {
            self.best_step(offset)
        } else {
            Some(self.best_polynomial(exponent, offset))
        }
    }

    /// Between two neighbouring degrees the plateau must clear `A`, the head `C L^b` with fixed A and C; the value falls
    /// with L where A decides and rises where C does, so that the best break is where both decide, `L^b = A/C`, or
    /// the nearest end. Lower bounds likewise with rising and falling exchanged. So the optimum is found without a
    /// search: at most one candidate between two degrees, `O(lmax)` in all.
    fn best_polynomial(&self, exponent: f64, offset: f64) -> Candidate {
        let over = |limit: f64| (limit - offset).max(0.0);
        let candidate = |sum: f64, gamma: f64, break_degree: f64| Candidate {
            value: offset * self.white() + gamma * sum,
            exponent,
            offset,
            break_degree,
            gamma,
        };
        let plain = over(self.strictest[0]);
        let mut best = candidate(self.tails[0], plain, self.degrees[0]);
        if exponent == 0.0 {
            return best;
        }
        // Degrees below the break: what their limits ask for, and the sum of l^(b-p).
        let mut before = self.degrees[0].powf(exponent);
        let mut head = over(self.limits[0]) / before;
        let mut sum = self.weights[0] * before;
        for k in 1..self.degrees.len() {
            let here = self.degrees[k].powf(exponent);
            let plateau = over(self.strictest[k]);
            // L^b; where the head asks for nothing, the farther break is the better one.
            let rise = if head > 0.0 { (plateau / head).clamp(before, here) } else { here };
            let gamma = stricter(self.side, plateau, head * rise);
            let found = candidate(sum / rise + self.tails[k], gamma, rise.powf(exponent.recip()));
            if self.better(found.value, best.value) {
                best = found;
            }
            head = stricter(self.side, head, over(self.limits[k]) / here);
            sum += self.weights[k] * here;
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

    /// Whether the first value makes a tighter bound than the second.
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

/// Returns what a bound must clear to clear both limits.
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
