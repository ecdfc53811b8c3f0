use sphvar_scene::{DirectionMode, ErrorReport, Image, RenderErrors};

use super::patterns::ThesisPattern;
use crate::{Error, Figure, Job, Lighting, Picture, Pictures, Quantity, Results, Setting};

/// The Cornell box at one size: its reference image and the errors of renders against it.
#[derive(Clone, Copy)]
pub(crate) struct BoxStudy {
    lighting: Lighting,
    side: usize,
    reference_points: usize,
}

/// The fraction of pixels darker than white in a picture of direct light.
const EXPOSURE: f64 = 0.99;

impl BoxStudy {
    /// Ambient occlusion, in displayed pictures. The reference of the thesis has 32k directions.
    pub(crate) fn shown(setting: Setting) -> Self {
        Self {
            lighting: Lighting::Ambient,
            side: setting.scale.pick(192, 256),
            reference_points: setting.scale.pick(8192, 32_768),
        }
    }

    /// Direct light of the lamp, in displayed pictures.
    pub(crate) fn lamp(setting: Setting) -> Self {
        Self { lighting: Lighting::Lamp, ..Self::shown(setting) }
    }

    /// Ambient occlusion, in pictures of which only the error is used.
    pub(crate) fn measured(setting: Setting) -> Self {
        Self {
            lighting: Lighting::Ambient,
            side: setting.scale.pick(96, 128),
            reference_points: setting.scale.pick(16_384, 32_768),
        }
    }

    /// Returns the job of the reference image.
    pub(crate) fn reference(self) -> Job {
        Job::Pictures(Pictures {
            pattern: None,
            lighting: self.lighting,
            n_points: self.reference_points,
            mode: DirectionMode::Antipodal,
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
            lighting: self.lighting,
            n_points,
            mode,
            side: self.side,
            renders,
        })
    }

    /// Returns the reference image.
    pub(crate) fn reference_image(self, results: &Results) -> Result<&Image, Error> {
        first(results, &self.reference())
    }

    /// Returns the errors of renders against the reference image.
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
        figure.panel(name, title, self.picture(results, image, caption)?);
        Ok(())
    }

    /// Returns an image as a picture: ambient occlusion unscaled, light scaled so that nearly all
    /// of the reference is darker than white.
    pub(crate) fn picture(
        self,
        results: &Results,
        image: &Image,
        caption: String,
    ) -> Result<Picture, Error> {
        let white = match self.lighting {
            Lighting::Ambient => 1.0,
            Lighting::Lamp => quantile(&self.reference_image(results)?.values, EXPOSURE),
        };
        let values = image.values.iter().map(|value| (value / white).min(1.0)).collect();
        Ok(Picture { size: [image.width, image.height], values, caption })
    }
}

/// Returns the value that a fraction of the values does not exceed.
fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "an index below the number of values"
    )]
    let index = (share * sorted.len().saturating_sub(1) as f64) as usize;
    sorted.get(index).copied().unwrap_or(f64::NAN)
}

/// Returns the ratio of the mean squared errors of two reports, with the interval of Student's t,
/// because there are few renders.
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

/// Returns the geometric mean of some numbers, with the interval of their scatter.
pub(crate) fn geometric_mean(numbers: impl Iterator<Item = f64>) -> Quantity {
    let logs: Vec<f64> = numbers.map(f64::ln).collect();
    let n = logs.len() as f64;
    let mean = logs.iter().sum::<f64>() / n;
    let scatter: f64 = logs.iter().map(|x| (x - mean).powi(2)).sum();
    let log = Quantity::with_student(mean, (scatter / (n * (n - 1.0))).sqrt(), n - 1.0);
    Quantity { value: mean.exp(), interval: (log.interval.0.exp(), log.interval.1.exp()) }
}

#[cfg(test)]
mod tests {
    use super::{geometric_mean, quantile};

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

    #[test]
    fn nearly_all_values_are_below_a_high_quantile() {
        let values: Vec<f64> = (0..100).rev().map(f64::from).collect();
        for (share, expected) in [(0.0, 0.0), (0.5, 49.0), (0.99, 98.0), (1.0, 99.0)] {
            let got: f64 = quantile(&values, share);
            assert!(got.total_cmp(&expected).is_eq(), "{share}: {got}");
        }
    }
}
