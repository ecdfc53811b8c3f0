use sphvar_scene::{DirectionMode, ErrorReport, Image, RenderErrors};

use super::patterns::ThesisPattern;
use crate::{Error, Figure, Job, Picture, Pictures, Quantity, Results, Setting};

/// The Cornell box with ambient occlusion, at one size: its reference image and what others are measured by.
#[derive(Clone, Copy)]
pub(crate) struct Occlusion {
    side: usize,
    reference_points: usize,
}

impl Occlusion {
    /// Pictures that are looked at. The thesis's reference has 32k directions.
    pub(crate) fn shown(setting: Setting) -> Self {
        Self {
            side: setting.scale.pick(192, 256),
            reference_points: setting.scale.pick(8192, 32_768),
        }
    }

    /// Pictures of which only the error is wanted.
    pub(crate) fn measured(setting: Setting) -> Self {
        Self {
            side: setting.scale.pick(96, 128),
            reference_points: setting.scale.pick(16_384, 32_768),
        }
    }

    /// The job of the reference image.
    pub(crate) fn reference(self) -> Job {
        Job::Pictures(Pictures {
            pattern: None,
            n_points: self.reference_points,
            mode: DirectionMode::Projective,
            side: self.side,
            renders: 1,
        })
    }

    /// Renders with about `n_points` directions on the visible hemisphere.
    pub(crate) fn renders(
        self,
        pattern: ThesisPattern,
        n_points: usize,
        mode: DirectionMode,
        renders: u64,
    ) -> Job {
        Job::Pictures(Pictures {
            pattern: Some(pattern.pattern()),
            n_points,
            mode,
            side: self.side,
            renders,
        })
    }

    /// The reference image.
    pub(crate) fn reference_image(self, results: &Results) -> Result<&Image, Error> {
        first(results, &self.reference())
    }

    /// The errors of renders against the reference image.
    pub(crate) fn errors(self, results: &Results, renders: &Job) -> Result<ErrorReport, Error> {
        let mut errors = RenderErrors::new(self.reference_image(results)?);
        for image in results.pictures(renders)? {
            errors.push(image)?;
        }
        Ok(errors.report())
    }

    /// Adds the first of some renders, with the error of all of them.
    pub(crate) fn panel(
        self,
        results: &Results,
        renders: &Job,
        (name, title): (&str, String),
        figure: &mut Figure,
    ) -> Result<(), Error> {
        let image = first(results, renders)?;
        let mse = self.errors(results, renders)?.mse.value;
        let caption = format!("N = {}, MSE {mse:.2e}", image.n_points);
        figure.panel(name, title, picture(image, caption));
        Ok(())
    }
}

/// An image as a picture.
pub(crate) fn picture(image: &Image, caption: String) -> Picture {
    Picture { size: [image.width, image.height], values: image.values.clone(), caption }
}

/// The ratio of the mean squared errors of two reports, with the interval of Student's t: there are few renders.
///
/// ```text
/// nu = (u_a^2 + u_b^2)^2 / (u_a^4/(R_a - 1) + u_b^4/(R_b - 1)),   u the relative errors of R renders
/// ```
///
/// degrees of freedom (Welch 1947, Biometrika 34, 28).
pub(crate) fn mse_ratio(a: &ErrorReport, b: &ErrorReport) -> Quantity {
    let ratio = a.mse.value / b.mse.value;
    let [of_a, of_b] = [a, b].map(|r| (r.mse.stderr / r.mse.value).powi(2));
    let square = of_a + of_b;
    let dof = square * square
        / (of_a * of_a / (a.renders as f64 - 1.0) + of_b * of_b / (b.renders as f64 - 1.0));
    Quantity::with_student(ratio, ratio * square.sqrt(), dof)
}

fn first<'a>(results: &'a Results, job: &Job) -> Result<&'a Image, Error> {
    results.pictures(job)?.first().ok_or_else(|| Error::Missing { key: job.key() })
}
