use sphvar_scene::{DirectionMode, ErrorReport};

use super::Recipe;
use super::box_study::{BoxStudy, geometric_mean};
use super::patterns::ThesisPattern;
use crate::{Claim, Error, Figure, Job, Quantity, Results, Setting, Stated};

/// Figure 7.8: lattices that are the same at every hit point, and one that is rotated.
pub(crate) struct LatticeArtifacts;

/// Valid numbers of directions of HEALPix centres, 6 nside^2. A single number is not representative
/// of lattices in general.
const N_POINTS: [usize; 6] = [96, 150, 216, 294, 384, 486];
/// The displayed number.
const SHOWN: usize = 384;

impl LatticeArtifacts {
    fn shared(pattern: ThesisPattern, n_points: usize, setting: Setting) -> Job {
        BoxStudy::shown(setting).renders(pattern, n_points, DirectionMode::Shared, 1)
    }

    fn rotated(setting: Setting) -> Job {
        let renders = setting.scale.pick(4, 8);
        BoxStudy::shown(setting).renders(
            ThesisPattern::Fibonacci,
            SHOWN,
            DirectionMode::Rotated,
            renders,
        )
    }
}

impl Recipe for LatticeArtifacts {
    fn title(&self) -> &'static str {
        "Cornell box with Fibonacci and HEALPix directions, shared and rotated"
    }

    fn jobs(&self, setting: Setting) -> Vec<Job> {
        let of = |pattern| N_POINTS.map(|n| Self::shared(pattern, n, setting));
        let mut jobs = vec![BoxStudy::shown(setting).reference(), Self::rotated(setting)];
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
        let scene = BoxStudy::shown(setting);
        let shared = |pattern| Self::shared(pattern, SHOWN, setting);
        for (name, title, job) in [
            (
                "fibonacci-shared",
                "Fibonacci, the same everywhere",
                shared(ThesisPattern::Fibonacci),
            ),
            ("fibonacci-rotated", "Fibonacci, rotated at each hit point", Self::rotated(setting)),
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
        // The mean square error of the means over squares of 8 by 8 pixels, up to a factor.
        let of_squares = |r: &ErrorReport| (r.structure.value * r.mse.value).sqrt();
        for (what, of, remark) in [
            (
                "error of 8 by 8 pixels together (rms), Fibonacci over HEALPix",
                &of_squares as &dyn Fn(&ErrorReport) -> f64,
                "the error of means over squares, which the eye sees as bands",
            ),
            (
                "structure of the errors, Fibonacci over HEALPix",
                &|r: &ErrorReport| r.structure.value,
                "the share of the error that whole squares have in common, from 1 to 64",
            ),
        ] {
            let ratio = mean_ratio(&fibonacci, &healpix, of);
            figure.claims.push(
                Claim::without_measure(what, "Fibonacci \"way more visible\"", ratio)
                    .erratum(43)
                    .because(format!(
                        "{remark}; geometric mean over N = {} to {}, {:.2} at N = {SHOWN}",
                        N_POINTS[0],
                        N_POINTS[5],
                        of(&fibonacci[4]) / of(&healpix[4])
                    )),
            );
        }
        let rotated = scene.errors(results, &Self::rotated(setting))?;
        figure.claims.push(
            Claim::number(
                "structure of the errors, Fibonacci rotated",
                Stated::About { value: 1.0, tolerance: 0.1 },
                Quantity::with_student(
                    rotated.structure.value,
                    rotated.structure.stderr,
                    rotated.renders as f64 - 1.0,
                ),
            )
            .because("artifacts are stated to become noise: errors of pixels are independent at 1"),
        );
        figure.note(
            "A shared lattice has one picture, whose error depends on N and on how the lattice is oriented in the box: intervals \
             are those of the mean over several N.",
        );
        Ok(())
    }
}

/// Returns the geometric mean over the numbers of directions of the ratio of two numbers, with its
/// interval by their scatter.
fn mean_ratio(a: &[ErrorReport], b: &[ErrorReport], of: &dyn Fn(&ErrorReport) -> f64) -> Quantity {
    geometric_mean(a.iter().zip(b).map(|(a, b)| of(a) / of(b)))
}
