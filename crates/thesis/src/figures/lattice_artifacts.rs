use sphvar_scene::{DirectionMode, ErrorReport};

use super::Recipe;
use super::occlusion::Occlusion;
use super::patterns::ThesisPattern;
use crate::{Claim, Error, Figure, Job, Quantity, Results, Setting, Stated, Verdict};

/// Figure 7.8: lattices that are the same at every hit point, and one that is turned.
pub(crate) struct LatticeArtifacts;

/// Numbers of directions that HEALPix centres have, 6 nside^2. One number says nothing of lattices in general.
const N_POINTS: [usize; 6] = [96, 150, 216, 294, 384, 486];
/// The one that is shown.
const SHOWN: usize = 384;

impl LatticeArtifacts {
    fn shared(pattern: ThesisPattern, n_points: usize, setting: Setting) -> Job {
        Occlusion::shown(setting).renders(pattern, n_points, DirectionMode::Shared, 1)
    }

    fn rotated(setting: Setting) -> Job {
        let renders = setting.scale.pick(4, 8);
        Occlusion::shown(setting).renders(
            ThesisPattern::Fibonacci,
            SHOWN,
            DirectionMode::Rotated,
            renders,
        )
    }
}

impl Recipe for LatticeArtifacts {
    fn title(&self) -> &'static str {
        "Cornell box with Fibonacci and HEALPix directions, shared and turned"
    }

    fn jobs(&self, setting: Setting) -> Vec<Job> {
        let of = |pattern| N_POINTS.map(|n| Self::shared(pattern, n, setting));
        let mut jobs = vec![Occlusion::shown(setting).reference(), Self::rotated(setting)];
        jobs.extend(of(ThesisPattern::Fibonacci));
        jobs.extend(of(ThesisPattern::Healpix));
        jobs
    }

    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error> {
        let scene = Occlusion::shown(setting);
        let shared = |pattern| Self::shared(pattern, SHOWN, setting);
        for (name, title, job) in [
            (
                "fibonacci-shared",
                "Fibonacci, the same everywhere",
                shared(ThesisPattern::Fibonacci),
            ),
            ("fibonacci-rotated", "Fibonacci, turned at each hit point", Self::rotated(setting)),
            ("healpix-shared", "HEALPix, the same everywhere", shared(ThesisPattern::Healpix)),
        ] {
            scene.panel(results, &job, (name, title.to_owned()), figure)?;
        }
        let reports = |pattern| -> Result<Vec<ErrorReport>, Error> {
            N_POINTS
                .iter()
                .map(|&n| scene.errors(results, &Self::shared(pattern, n, setting)))
                .collect()
        };
        let (fibonacci, healpix) =
            (reports(ThesisPattern::Fibonacci)?, reports(ThesisPattern::Healpix)?);
        // The mean square error of the means over squares of 8 by 8 pixels, but for a factor.
        let of_squares = |r: &ErrorReport| (r.structure.value * r.mse.value).sqrt();
        for (what, of, remark) in [
            (
                "error of 8 by 8 pixels together (rms), Fibonacci over HEALPix",
                &of_squares as &dyn Fn(&ErrorReport) -> f64,
                "what the eye sees as bands",
            ),
            (
                "structure of the errors, Fibonacci over HEALPix",
                &|r: &ErrorReport| r.structure.value,
                "the share of the error that whole squares have in common, from 1 to 64",
            ),
        ] {
            let claim =
                Claim::number(what, Stated::AtLeast(1.0), mean_ratio(&fibonacci, &healpix, of))
                    .because(format!(
                        "artifacts of Fibonacci are said to be way more visible; {remark}; geometric mean over N = {} to \
                         {}, at N = {SHOWN} {:.2}",
                        N_POINTS[0],
                        N_POINTS[5],
                        of(&fibonacci[4]) / of(&healpix[4])
                    ));
            let wrong = claim.verdict == Verdict::Wrong;
            figure.claims.push(if wrong { claim.erratum(43) } else { claim });
        }
        let turned = scene.errors(results, &Self::rotated(setting))?;
        figure.claims.push(
            Claim::number(
                "structure of the errors, Fibonacci turned",
                Stated::About { value: 1.0, tolerance: 0.1 },
                Quantity::with_student(
                    turned.structure.value,
                    turned.structure.stderr,
                    turned.renders as f64 - 1.0,
                ),
            )
            .because(
                "artifacts are said to turn into noise: errors of pixels are independent at 1",
            ),
        );
        figure.note(
            "A shared lattice has one picture, whose error depends on N and on how the lattice lies to the room: intervals \
             are those of the mean over several N.",
        );
        Ok(())
    }
}

/// The geometric mean over the numbers of directions of the ratio of two numbers, with its interval by their scatter.
fn mean_ratio(a: &[ErrorReport], b: &[ErrorReport], of: &dyn Fn(&ErrorReport) -> f64) -> Quantity {
    geometric_mean(a.iter().zip(b).map(|(a, b)| of(a) / of(b)))
}

/// The geometric mean of some numbers.
fn geometric_mean(numbers: impl Iterator<Item = f64>) -> Quantity {
    let logs: Vec<f64> = numbers.map(f64::ln).collect();
    let n = logs.len() as f64;
    let mean = logs.iter().sum::<f64>() / n;
    let scatter: f64 = logs.iter().map(|x| (x - mean).powi(2)).sum();
    let log = Quantity::with_student(mean, (scatter / (n * (n - 1.0))).sqrt(), n - 1.0);
    Quantity { value: mean.exp(), interval: (log.interval.0.exp(), log.interval.1.exp()) }
}

#[cfg(test)]
mod tests {
    use super::geometric_mean;

    /// The quantile of 97.5 % of Student's t with 5 degrees of freedom (any table).
    const T_OF_6: f64 = 2.570_581_835_636_3;

    #[test]
    fn a_geometric_mean_has_students_interval() {
        let got = geometric_mean([2.0, 8.0, 2.0, 8.0, 2.0, 8.0].into_iter());
        assert!((got.value - 4.0).abs() < 16.0 * f64::EPSILON, "{got:?}");
        // Deviations of ln 2 each: standard error ln 2/sqrt(5).
        let factor = (T_OF_6 * 2f64.ln() / 5f64.sqrt()).exp();
        // The quantile is found by iteration.
        assert!((got.interval.1 / (4.0 * factor) - 1.0).abs() < 1e-9, "{got:?}");
        assert!((got.interval.0 / (4.0 / factor) - 1.0).abs() < 1e-9, "{got:?}");
    }
}
