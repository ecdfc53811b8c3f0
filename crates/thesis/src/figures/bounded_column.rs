use sphvar_bounds::{Profile, ThesisBound};
use sphvar_integrands::Energy;
use sphvar_variance::{VariancePoint, fit_rate};

use super::patterns::{BOUND_COLOUR, ThesisPattern};
use super::significance;
use super::variance_study::{VarianceStudy, bound, energy};
use crate::{
    Axis, Claim, Curve, Curves, Error, Mark, Quantity, Results, Setting, Stated, TestIntegrand,
    Verdict,
};

/// Rates are fitted from this N on.
const ASYMPTOTIC: f64 = 768.0;
/// The same for CCVT, for which no such large sets are available.
const ASYMPTOTIC_CCVT: f64 = 192.0;
/// The same for Poisson disks with many large sets: the offset dominates the variance of the cap
/// only for many points.
const ASYMPTOTIC_DISKS: f64 = 3072.0;
/// Half a unit of the last digit of exponents such as 1.5.
const RATE_TOLERANCE: f64 = 0.05;
/// The tolerance of "consistent" for a ratio of variances, in addition to its error.
const CONSISTENT: f64 = 0.02;
/// Points of a curve of bounds for each doubling of N.
const PER_DOUBLING: usize = 4;

/// The variance of one integrand with one pattern over the number of points, within the thesis's
/// bounds.
pub(crate) struct BoundedColumn {
    pattern: ThesisPattern,
    /// The first number of points that the rate is fitted from.
    from: f64,
    bounds: ThesisBound,
    integrand: TestIntegrand,
    energy: Energy,
    measured: Vec<VariancePoint>,
    predicted: Vec<VariancePoint>,
}

impl BoundedColumn {
    /// Returns the column from the results of a study's jobs.
    pub(crate) fn new(
        pattern: ThesisPattern,
        bounds: ThesisBound,
        integrand: TestIntegrand,
        setting: Setting,
        results: &Results,
    ) -> Result<Self, Error> {
        let study = VarianceStudy { pattern, setting };
        let from = asymptotic(pattern, setting);
        Ok(Self {
            pattern,
            from,
            bounds,
            integrand,
            energy: energy(integrand)?,
            measured: study.measured(results, integrand)?,
            predicted: study.predicted(results, integrand)?,
        })
    }

    /// Measured and predicted variances between the bounds.
    pub(crate) fn curves(&self) -> Result<Curves, Error> {
        let max_points = self.measured.last().map_or(1.0, |p| p.n_points);
        let count = max_points.log2() * PER_DOUBLING as f64;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "numbers of points, from 1 to the most"
        )]
        let mut counts: Vec<usize> = (0..=count as usize)
            .map(|i| (i as f64 / PER_DOUBLING as f64).exp2().round() as usize)
            .collect();
        counts.dedup();
        let line = |label: &str, profile: &Profile| -> Result<Curve, Error> {
            let points: Result<Vec<_>, Error> =
                counts.iter().map(|&n| Ok((n as f64, bound(profile, n, &self.energy)?))).collect();
            Ok(Curve::line(label, BOUND_COLOUR, points?))
        };
        let series = |label: &str, mark, points: &[VariancePoint]| {
            let points = points.iter().map(|p| [p.n_points, p.variance, p.stderr]);
            Curve::new(label, self.pattern.colour(), mark, points)
        };
        Ok(Curves {
            x: Axis::log("number of points N"),
            y: Axis::log("variance of the integral"),
            curves: vec![
                line("upper bound", &self.bounds.upper)?,
                line("lower bound", &self.bounds.lower)?,
                series("predicted", Mark::Line, &self.predicted),
                series("measured", Mark::Markers, &self.measured),
            ],
        })
    }

    /// Returns the claims about the variance of a pattern. Every pattern and integrand has the same
    /// claims in the same order, except for the last one, about the lower bound.
    pub(crate) fn claims(&self) -> Result<Vec<Claim>, Error> {
        let mut claims = vec![self.rate(), self.agreement(), self.bounded()?];
        let quadratic_or_disk =
            matches!(self.pattern, ThesisPattern::Jittered | ThesisPattern::PoissonDisk);
        if quadratic_or_disk && self.integrand == TestIntegrand::Harmonic {
            claims.push(self.tighter()?);
        }
        Ok(claims)
    }

    fn named(&self, what: &str) -> String {
        format!("{}, {}: {what}", self.pattern.subject(), self.integrand.name())
    }

    /// Compares the exponent of the measured variance with that of the profile that bounds the
    /// spectrum in the thesis.
    fn rate(&self) -> Claim {
        let quadratic = self.pattern == ThesisPattern::Jittered || self.pattern.is_ccvt();
        let value = match (quadratic, self.integrand) {
            (false, _) => -1.0,
            (true, TestIntegrand::Harmonic) => -2.0,
            (true, TestIntegrand::Cap) => -1.5,
        };
        let from = self.from;
        let tail: Vec<VariancePoint> =
            self.measured.iter().copied().filter(|p| p.n_points >= from).collect();
        let fit = fit_rate(&tail);
        let (slope, interval) =
            fit.as_ref().map_or((f64::NAN, (f64::NAN, f64::NAN)), |fit| (fit.slope, fit.interval));
        let claim = Claim::number(
            self.named("exponent of N"),
            Stated::About { value, tolerance: RATE_TOLERANCE },
            Quantity { value: slope, interval },
        );
        let bends = fit.is_some_and(|fit| fit.is_pre_asymptotic());
        claim.because(format!(
            "fitted from N = {from} on{}",
            if bends { ", where the curve still bends significantly" } else { "" }
        ))
    }

    /// Returns the mean of measured over predicted variance, weighted by its errors.
    fn agreement(&self) -> Claim {
        let rows = self.measured.iter().zip(&self.predicted).filter_map(|(m, p)| {
            let error = (m.stderr / m.variance).hypot(p.stderr / p.variance);
            let usable = m.variance > 0.0 && p.variance > 0.0 && error > 0.0 && error.is_finite();
            // The logarithm is even about agreement, and its error independent of the value.
            usable.then(|| ((m.variance / p.variance).ln(), error.powi(-2)))
        });
        let (sum, weight) = rows.fold((0.0, 0.0), |(s, w), (x, v)| (s + v * x, w + v));
        let (ratio, stderr) = ((sum / weight).exp(), weight.powf(-0.5));
        Claim::number(
            self.named("measured over predicted variance"),
            Stated::About { value: 1.0, tolerance: CONSISTENT },
            Quantity::with_stderr(ratio, stderr),
        )
        .because(format!(
            "weighted mean over all N; \"consistent\" is read as within {CONSISTENT} of 1, beyond the error"
        ))
    }

    /// Returns the largest factor by which a measured variance is beyond a bound, and whether
    /// chance can explain it.
    fn bounded(&self) -> Result<Claim, Error> {
        let mut worst = (f64::NAN, f64::NAN);
        let mut largest_z = f64::NEG_INFINITY;
        for point in &self.measured {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "it was a number of points"
            )]
            let n = point.n_points as usize;
            let upper = bound(&self.bounds.upper, n, &self.energy)?;
            let lower = bound(&self.bounds.lower, n, &self.energy)?;
            let factor = (point.variance / upper).max(lower / point.variance);
            if worst.0.is_nan() || factor > worst.0 {
                worst = (factor, point.n_points);
            }
            let relative = point.stderr / point.variance;
            largest_z = largest_z.max(factor.ln() / relative);
        }
        // Either side of every interval is a comparison, and a normal variable has two sides.
        let p_value = if largest_z > 0.0 {
            significance::largest_of_normal(largest_z, self.measured.len())
        } else {
            1.0
        };
        let chance = if worst.0 > 1.0 {
            format!("; {}", significance::at_most(p_value))
        } else {
            String::new()
        };
        Ok(Claim::words(
            self.named("bounds of the variance"),
            "the variance is correctly bounded",
            within_bounds(worst.0, p_value),
        )
        .measured(Quantity::single(worst.0))
        .because(format!(
            "the largest factor by which a measured variance is beyond a bound (below 1: within), at N = {}{chance}",
            worst.1
        )))
    }

    /// Returns whether the lower bound is nearer than the upper one: `upper lower/measured^2` at
    /// the largest N.
    fn tighter(&self) -> Result<Claim, Error> {
        let last = self.measured.last().copied();
        let last =
            last.unwrap_or(VariancePoint { n_points: 1.0, variance: f64::NAN, stderr: f64::NAN });
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "it was a number of points"
        )]
        let n = last.n_points as usize;
        let upper = bound(&self.bounds.upper, n, &self.energy)?;
        let lower = bound(&self.bounds.lower, n, &self.energy)?;
        let ratio = upper * lower / (last.variance * last.variance);
        Ok(Claim::number(
            self.named("distance to the upper bound over that to the lower one, as factors"),
            Stated::AtLeast(1.0),
            Quantity::with_stderr(ratio, 2.0 * ratio * last.stderr / last.variance),
        )
        .because(format!("the lower bound is said to be the tighter one; at N = {n}")))
    }
}

/// Returns the number of points from which the variances of a pattern are fitted by the asymptotic
/// power law.
pub(crate) fn asymptotic(pattern: ThesisPattern, setting: Setting) -> f64 {
    match pattern {
        ThesisPattern::CcvtRandom | ThesisPattern::CcvtFibonacci => ASYMPTOTIC_CCVT,
        ThesisPattern::PoissonDisk => setting.scale.pick(ASYMPTOTIC, ASYMPTOTIC_DISKS),
        _ => ASYMPTOTIC,
    }
}

/// Returns the verdict for the largest factor beyond a bound: undecided if it exceeds the bound but
/// possibly by chance.
fn within_bounds(worst: f64, p_value: f64) -> Verdict {
    if worst <= 1.0 {
        Verdict::Holds
    } else if significance::verdict(p_value) == Verdict::Wrong {
        Verdict::Wrong
    } else {
        Verdict::Undecided
    }
}

#[cfg(test)]
mod tests {
    use super::{Verdict, within_bounds};

    #[test]
    fn a_violated_bound_never_holds() {
        for (worst, p, expected) in [
            (0.99, 1.0, Verdict::Holds),
            (1.13, 1.0, Verdict::Undecided),
            (1.13, 1e-3, Verdict::Undecided),
            (1.13, 1e-9, Verdict::Wrong),
            (f64::NAN, 1.0, Verdict::Undecided),
        ] {
            assert_eq!(within_bounds(worst, p), expected, "{worst}, {p}");
        }
    }
}
