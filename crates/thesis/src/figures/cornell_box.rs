use sphvar_scene::DirectionMode;

use super::Recipe;
use super::occlusion::{Occlusion, mse_ratio, picture};
use super::patterns::ThesisPattern;
use crate::{Claim, Error, Figure, Job, Results, Setting, Stated};

/// Figures 7.5 and 7.6: the Cornell box with three samplers, each with three numbers of directions.
pub(crate) struct CornellBoxes {
    title: &'static str,
    patterns: [ThesisPattern; 3],
    comparisons: &'static [Comparison],
}

/// The mean squared errors of two patterns at one number of directions, and what the thesis says of their ratio.
struct Comparison {
    patterns: [ThesisPattern; 2],
    n_points: usize,
    stated: Stated,
    remark: &'static str,
}

/// Numbers of directions that jittered sets have on the hemisphere, 6 nside^2. The thesis's are not in its text.
const N_POINTS: [usize; 3] = [24, 96, 384];

impl CornellBoxes {
    /// Figure 7.5.
    pub(crate) const RANDOM: Self = Self {
        title: "Cornell box with white noise, jittered and Poisson disk directions",
        patterns: [ThesisPattern::WhiteNoise, ThesisPattern::Jittered, ThesisPattern::PoissonDisk],
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
        patterns: [ThesisPattern::WhiteNoise, ThesisPattern::Ccvt, ThesisPattern::Healpix],
        comparisons: &[
            Comparison {
                patterns: [ThesisPattern::Healpix, ThesisPattern::WhiteNoise],
                n_points: N_POINTS[2],
                stated: Stated::AtMost(1.0),
                remark: "homogenized regular directions are said to give good results",
            },
            Comparison {
                patterns: [ThesisPattern::Ccvt, ThesisPattern::WhiteNoise],
                n_points: N_POINTS[2],
                stated: Stated::AtMost(1.0),
                remark: "the asymptotic behaviour of CCVT is said to be better",
            },
        ],
    };

    fn job(pattern: ThesisPattern, n_points: usize, setting: Setting) -> Job {
        let renders = setting.scale.pick(3, 6);
        Occlusion::shown(setting).renders(pattern, n_points, DirectionMode::Rotated, renders)
    }
}

impl Recipe for CornellBoxes {
    fn title(&self) -> &'static str {
        self.title
    }

    fn jobs(&self, setting: Setting) -> Vec<Job> {
        let mut jobs = vec![Occlusion::shown(setting).reference()];
        for n in N_POINTS {
            jobs.extend(self.patterns.map(|pattern| Self::job(pattern, n, setting)));
        }
        jobs
    }

    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error> {
        let scene = Occlusion::shown(setting);
        for n in N_POINTS {
            for pattern in self.patterns {
                let job = Self::job(pattern, n, setting);
                let name = format!("{}-{n}", pattern.name());
                let title = format!("{}, {n} directions", pattern.label());
                scene.panel(results, &job, (&name, title), figure)?;
            }
        }
        for comparison in self.comparisons {
            let [a, b] = comparison.patterns;
            let n = comparison.n_points;
            let errors = |pattern| scene.errors(results, &Self::job(pattern, n, setting));
            figure.claims.push(
                Claim::number(
                    format!("mean squared error of {} over {}, N = {n}", a.label(), b.label()),
                    comparison.stated.clone(),
                    mse_ratio(&errors(a)?, &errors(b)?),
                )
                .because(comparison.remark),
            );
        }
        figure.note(format!(
            "Sphere sets of 2 N points, turned at each hit point, of which the visible half is kept (erratum 13); each mean \
             squared error is that of {} renders.",
            setting.scale.pick(3, 6)
        ));
        figure.note(
            "The thesis prints its numbers of directions and errors inside the pictures only, so those here cannot be \
             compared one by one. CCVT has capacity 64 and random mass points (erratum 39).",
        );
        Ok(())
    }
}

/// Figure 7.7: the reference image.
pub(crate) struct ReferenceImage;

impl Recipe for ReferenceImage {
    fn title(&self) -> &'static str {
        "Reference image of the Cornell box"
    }

    fn jobs(&self, setting: Setting) -> Vec<Job> {
        vec![Occlusion::shown(setting).reference()]
    }

    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error> {
        let image = Occlusion::shown(setting).reference_image(results)?;
        let n = image.n_points;
        figure.panel(
            "reference",
            "Ambient occlusion, jittered directions",
            picture(image, format!("N = {n}")),
        );
        figure.note(format!(
            "One ray through the centre of each pixel and {n} jittered directions (the thesis: 32k) at each hit point, as \
             lines turned uniformly. With {n} independent directions the mean squared error would be {:.1e}; jitter's is \
             smaller by about sqrt(N)/2.",
            image.white_noise_variance(n)
        ));
        Ok(())
    }
}
