use sphvar_scene::DirectionMode;

use super::Recipe;
use super::box_study::{BoxStudy, mse_ratio};
use super::disk_placement::with_dart_throwing;
use super::mass_points::{NOTE, with_both_kinds};
use super::patterns::ThesisPattern;
use crate::{Claim, Error, Figure, Job, Results, Setting, Stated};

/// Figures 7.5 and 7.6: the Cornell box with three samplers, each with three numbers of directions.
pub(crate) struct CornellBoxes {
    title: &'static str,
    patterns: &'static [ThesisPattern],
    comparisons: &'static [Comparison],
}

/// The mean squared errors of two patterns at one number of directions, and the statement of the
/// thesis about their ratio.
struct Comparison {
    patterns: [ThesisPattern; 2],
    n_points: usize,
    stated: Stated,
    remark: &'static str,
}

/// Valid numbers of directions of jittered sets on the hemisphere, 6 nside^2. The thesis does not
/// state its numbers.
const N_POINTS: [usize; 3] = [24, 96, 384];

impl CornellBoxes {
    /// Figure 7.5.
    pub(crate) const RANDOM: Self = Self {
        title: "Cornell box with white noise, jittered and Poisson disk directions",
        patterns: &[ThesisPattern::WhiteNoise, ThesisPattern::Jittered, ThesisPattern::PoissonDisk],
        comparisons: &[
            Comparison {
                patterns: [ThesisPattern::Jittered, ThesisPattern::PoissonDisk],
                n_points: N_POINTS[0],
                stated: Stated::AtLeast(1.0),
                remark: "jitter is said to be worse where directions are few",
            },
            Comparison {
                patterns: [ThesisPattern::Jittered, ThesisPattern::PoissonDisk],
                n_points: N_POINTS[2],
                stated: Stated::AtMost(1.0),
                remark: "jitter is said to be better after 294 directions",
            },
        ],
    };
    /// Figure 7.6.
    pub(crate) const EVEN: Self = Self {
        title: "Cornell box with white noise, CCVT and HEALPix directions",
        patterns: &[
            ThesisPattern::WhiteNoise,
            ThesisPattern::CcvtRandom,
            ThesisPattern::CcvtFibonacci,
            ThesisPattern::Healpix,
        ],
        comparisons: &[
            Comparison {
                patterns: [ThesisPattern::Healpix, ThesisPattern::WhiteNoise],
                n_points: N_POINTS[2],
                stated: Stated::AtMost(1.0),
                remark: "homogenized regular directions are said to give good results",
            },
            Comparison {
                patterns: [ThesisPattern::CcvtRandom, ThesisPattern::WhiteNoise],
                n_points: N_POINTS[2],
                stated: Stated::AtMost(1.0),
                remark: "the asymptotic behaviour of CCVT is said to be better",
            },
        ],
    };

    fn job(pattern: ThesisPattern, n_points: usize, setting: Setting) -> Job {
        let renders = setting.scale.pick(3, 6);
        BoxStudy::shown(setting).renders(pattern, n_points, DirectionMode::Rotated, renders)
    }
}

impl Recipe for CornellBoxes {
    fn title(&self) -> &'static str {
        self.title
    }

    fn jobs(&self, setting: Setting) -> Vec<Job> {
        let mut jobs = vec![BoxStudy::shown(setting).reference()];
        for n in N_POINTS {
            jobs.extend(self.patterns.iter().map(|&pattern| Self::job(pattern, n, setting)));
        }
        jobs
    }

    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error> {
        let scene = BoxStudy::shown(setting);
        for n in N_POINTS {
            for &pattern in self.patterns {
                let job = Self::job(pattern, n, setting);
                let name = format!("{}-{n}", pattern.name());
                let title = format!("{}, {n} directions", pattern.label());
                scene.panel(results, &job, (&name, title), figure)?;
            }
        }
        for comparison in self.comparisons {
            figure.claims.push(comparison.claim(setting, results)?);
        }
        figure.note(format!(
            "Sphere sets of 2 N points, rotated at each hit point, of which the visible half is kept (erratum 13); each mean \
             squared error is that of {} renders.",
            setting.scale.pick(3, 6)
        ));
        figure.note(
            "The thesis prints its numbers of directions and errors inside the pictures only, so those here cannot be \
             compared one by one.",
        );
        if self.patterns.iter().any(|pattern| pattern.is_ccvt()) {
            figure.note(NOTE);
        }
        Ok(())
    }
}

impl Comparison {
    fn claim(&self, setting: Setting, results: &Results) -> Result<Claim, Error> {
        let [a, b] = self.patterns;
        let claim = |a: ThesisPattern| {
            let errors = |pattern| {
                let job = CornellBoxes::job(pattern, self.n_points, setting);
                BoxStudy::shown(setting).errors(results, &job)
            };
            Ok(Claim::number(
                format!(
                    "mean squared error of {} over {}, N = {}",
                    a.subject(),
                    b.label(),
                    self.n_points
                ),
                self.stated.clone(),
                mse_ratio(&errors(a)?, &errors(b)?),
            )
            .because(self.remark))
        };
        match (a, b) {
            (ThesisPattern::CcvtRandom, _) => with_both_kinds(None, claim),
            (_, ThesisPattern::PoissonDisk) => claim(a).map(with_dart_throwing),
            _ => claim(a),
        }
    }
}

/// Figure 7.7: the reference image.
pub(crate) struct ReferenceImage;

impl Recipe for ReferenceImage {
    fn title(&self) -> &'static str {
        "Reference image of the Cornell box"
    }

    fn jobs(&self, setting: Setting) -> Vec<Job> {
        vec![BoxStudy::shown(setting).reference()]
    }

    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error> {
        let study = BoxStudy::shown(setting);
        let image = study.reference_image(results)?;
        let n = image.n_points;
        figure.panel(
            "reference",
            "Ambient occlusion, jittered directions",
            study.picture(results, image, format!("N = {n}"))?,
        );
        figure.note(format!(
            "One ray through the centre of each pixel and {n} jittered directions (the thesis: 32k) at each hit point, as \
             antipodal pairs rotated uniformly. With {n} independent directions the mean squared error would be {:.1e}; jitter's is \
             smaller by about sqrt(N)/2.",
            image.white_noise_variance(n)
        ));
        Ok(())
    }
}
