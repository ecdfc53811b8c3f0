use sphvar_scene::{DirectionMode, ErrorReport};

use super::Recipe;
use super::box_study::{BoxStudy, geometric_mean};
use super::patterns::ThesisPattern;
use crate::{Claim, Error, Figure, Job, Quantity, Results, Setting, Stated};

/// Figure 4.13: direct light with the same regular directions at every hit point, and with randomly
/// rotated ones. The thesis uses another scene; this is the Cornell box with its lamp.
pub(crate) struct DirectLight;

/// Valid numbers of directions of HEALPix centres, 6 nside^2. A single number is not representative
/// of lattices in general.
const N_POINTS: [usize; 6] = [96, 150, 216, 294, 384, 486];
/// The displayed number.
const SHOWN: usize = 384;
/// "High correlation between different pixels" is read as at least this structure: independent
/// errors of pixels have 1.
const CORRELATED: f64 = 2.0;
/// Tolerance of the structure of noise from 1.
const NOISE: f64 = 0.1;

impl DirectLight {
    fn shared(n_points: usize, setting: Setting) -> Job {
        let study = BoxStudy::lamp(setting);
        study.renders(ThesisPattern::Healpix, n_points, DirectionMode::Shared, 1)
    }

    fn rotated(setting: Setting) -> Job {
        let renders = setting.scale.pick(4, 8);
        let study = BoxStudy::lamp(setting);
        study.renders(ThesisPattern::Healpix, SHOWN, DirectionMode::Rotated, renders)
    }
}

impl Recipe for DirectLight {
    fn title(&self) -> &'static str {
        "Direct light with and without random rotations of regular directions"
    }

    fn jobs(&self, setting: Setting) -> Vec<Job> {
        let mut jobs = vec![BoxStudy::lamp(setting).reference(), Self::rotated(setting)];
        jobs.extend(N_POINTS.map(|n| Self::shared(n, setting)));
        jobs
    }

    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error> {
        let study = BoxStudy::lamp(setting);
        let reference = study.reference_image(results)?;
        let caption = format!("N = {}", reference.n_points);
        let picture = study.picture(results, reference, caption)?;
        figure.panel("reference", "Reference, jittered directions", picture);
        for (name, title, job) in [
            ("shared", "HEALPix, no rotation", Self::shared(SHOWN, setting)),
            ("rotated", "HEALPix, rotated at each hit point", Self::rotated(setting)),
        ] {
            study.panel(results, &job, (name, title.to_owned()), figure)?;
        }
        let structure = |&n: &usize| -> Result<f64, Error> {
            Ok(study.errors(results, &Self::shared(n, setting))?.structure.value)
        };
        let shared: Result<Vec<f64>, Error> = N_POINTS.iter().map(structure).collect();
        figure.claims.push(correlated(shared?));
        figure.claims.push(noise(&study.errors(results, &Self::rotated(setting))?));
        figure.note(
            "The structure is 64 times the mean square of the error of 8 by 8 pixels together over that of a pixel: 1 for \
             independent errors, 64 for equal ones. The scene of the thesis is not described; this is the Cornell box with \
             its lamp and white diffuse surfaces.",
        );
        Ok(())
    }
}

/// "Full of structural artifacts due to high correlation between different pixels."
fn correlated(structures: Vec<f64>) -> Claim {
    Claim::number(
        "structure of the errors, HEALPix without rotation",
        Stated::AtLeast(CORRELATED),
        geometric_mean(structures.into_iter()),
    )
    .because(format!(
        "\"high correlation between different pixels\", read as twice that of independent errors; geometric mean over N = {} \
         to {}",
        N_POINTS[0],
        N_POINTS[N_POINTS.len() - 1]
    ))
}

/// "A simple perturbation of samples at each hitpoint turns these artifacts into noise."
fn noise(rotated: &ErrorReport) -> Claim {
    let dof = rotated.renders as f64 - 1.0;
    Claim::number(
        "structure of the errors, HEALPix rotated",
        Stated::About { value: 1.0, tolerance: NOISE },
        Quantity::with_student(rotated.structure.value, rotated.structure.stderr, dof),
    )
    .because(format!(
        "\"turns these artifacts into noise\": errors of pixels are independent at 1; N = {SHOWN}"
    ))
}

#[cfg(test)]
mod tests {
    use super::correlated;
    use crate::Verdict;

    #[test]
    fn independent_errors_are_no_artifacts() {
        for (structure, expected) in [(8.0, Verdict::Holds), (1.0, Verdict::Wrong)] {
            let around = [0.95, 1.0, 1.05].map(|factor| factor * structure).to_vec();
            assert_eq!(correlated(around).verdict, expected, "{structure}");
        }
    }
}
