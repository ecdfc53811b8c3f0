//! Pictures of a zone plate with about one sample per pixel, and the structure of their errors.

mod aliasing;
mod screen;

use self::aliasing::{Aliasing, BLOCK};
use self::screen::Screen;
use super::Recipe;
use super::square_patterns::PlanePattern;
use crate::{Claim, Error, Figure, Job, Picture, Quantity, Results, Setting, Stated};

/// A figure with pictures of the zone plate `sin(x^2 + y^2)`.
pub(crate) enum ZonePlates {
    /// Figure 4.1: the reference, regular and jittered samples.
    Test,
    /// Figure 4.8: every pattern of chapter 4.1.
    Patterns,
}

/// Pixels per side; as many samples as pixels.
const SIDE: usize = 256;
/// A picture has structural artifacts if its structure is at least twice that of noise.
const STRUCTURED: f64 = 2.0;
/// A structure within this distance of that of noise counts as noise.
const LIKE_NOISE: f64 = 0.1;

impl ZonePlates {
    fn patterns(&self) -> &'static [PlanePattern] {
        use PlanePattern::{
            Fibonacci, Halton, Hammersley, Jittered, PoissonDisk, Regular, WhiteNoise,
        };
        match self {
            Self::Test => &[Regular, Jittered],
            Self::Patterns => {
                &[WhiteNoise, Jittered, PoissonDisk, Regular, Halton, Hammersley, Fibonacci]
            }
        }
    }
}

impl Recipe for ZonePlates {
    fn title(&self) -> &'static str {
        match self {
            Self::Test => "Zone plate with regular and jittered samples",
            Self::Patterns => "Zone plate and peaks of the power spectrum",
        }
    }

    fn jobs(&self, _: Setting) -> Vec<Job> {
        Vec::new()
    }

    fn compose(&self, setting: Setting, _: &Results, figure: &mut Figure) -> Result<(), Error> {
        let screen = Screen::new(SIDE)?;
        let exact = screen.pixel_means()?;
        figure.panel(
            "reference",
            "Reference",
            picture(
                &screen.mitchell()?,
                "The limit N = infinity of samples per pixel, with the filter of Mitchell and Netravali".to_owned(),
            ),
        );
        for &pattern in self.patterns() {
            let test = Test::run(pattern, &screen, &exact, setting)?;
            let Quantity { value: structure, .. } = test.structure;
            figure.panel(
                pattern.name(),
                format!("{}, one sample per pixel", pattern.label()),
                picture(
                    &test.first,
                    format!("N = {}, MSE {:.3}, structure {structure:.2}", test.n_points, test.mse),
                ),
            );
            figure.claims.extend(self.claim(pattern, test.structure));
        }
        notes(&screen, setting, figure);
        Ok(())
    }
}

impl ZonePlates {
    /// Returns the statement of the thesis about a picture, if there is one.
    fn claim(&self, pattern: PlanePattern, structure: Quantity) -> Option<Claim> {
        use PlanePattern::{Fibonacci, Hammersley, Jittered, Regular};
        let structured = Stated::AtLeast(STRUCTURED);
        let (stated, because) = match (self, pattern) {
            (Self::Test, Regular) => (
                structured,
                "\"shows number of structural artifacts\", read as twice the structure of noise",
            ),
            (Self::Test, Jittered) => (
                Stated::About { value: 1.0, tolerance: LIKE_NOISE },
                "\"turns these artifacts into noise\", whose structure is 1",
            ),
            (Self::Patterns, Regular | Hammersley | Fibonacci) => (
                structured,
                "\"effects of high energy Fourier peaks\", which section 4.1.1 ascribes to the pattern, read as twice the \
                 structure of noise",
            ),
            _ => return None,
        };
        let what = format!("{}: structure of the error of the zone plate", pattern.label());
        Some(Claim::number(what, stated, structure).because(because))
    }
}

/// The pictures of a pattern.
struct Test {
    n_points: usize,
    /// The first picture.
    first: Vec<f64>,
    /// The mean over all pictures.
    mse: f64,
    structure: Quantity,
}

impl Test {
    fn run(
        pattern: PlanePattern,
        screen: &Screen,
        exact: &[f64],
        setting: Setting,
    ) -> Result<Self, Error> {
        let ensemble = pattern.ensemble(SIDE * SIDE);
        let sets = if pattern.is_deterministic() { 1 } else { realizations(setting) };
        let mut first = Vec::new();
        let mut measured = Vec::new();
        for index in 0..sets {
            let picture = screen.render(&ensemble.set(setting.seed, index)?);
            measured.push(Aliasing::new(&picture, exact, screen.side));
            if index == 0 {
                first = picture;
            }
        }
        let n = measured.len() as f64;
        let mean = |value: fn(&Aliasing) -> f64| measured.iter().map(value).sum::<f64>() / n;
        let structure = mean(|a| a.structure);
        let squares: f64 = measured.iter().map(|a| (a.structure - structure).powi(2)).sum();
        let structure = match sets {
            1 => Quantity::exact(structure),
            _ => Quantity::with_student(structure, (squares / (n * (n - 1.0))).sqrt(), n - 1.0),
        };
        Ok(Self { n_points: ensemble.n_points, first, mse: mean(|a| a.mse), structure })
    }
}

/// Returns the number of pictures of random patterns.
fn realizations(setting: Setting) -> u64 {
    setting.scale.pick(4, 16)
}

/// Returns values from -1 to 1 as a picture, y upwards.
fn picture(values: &[f64], caption: String) -> Picture {
    let rows = values.chunks_exact(SIDE).rev();
    let values = rows.flatten().map(|value| (0.5 * (1.0 + value)).clamp(0.0, 1.0)).collect();
    Picture { size: [SIDE; 2], values, caption }
}

fn notes(screen: &Screen, setting: Setting, figure: &mut Figure) {
    figure.note(format!(
        "sin(x^2 + y^2), x and y from 0 to {:.1}, on {SIDE} x {SIDE} pixels; the thesis does not state its range. Pixels \
         resolve rings up to the frequency of one per two pixels, at 3/8 of each side; beyond, their exact mean tends to \
         0, and all that samples show is aliasing. Each pixel is the mean of its samples, or the nearest sample if it \
         has none.",
        screen.extent
    ));
    figure.note(format!(
        "Aliasing: MSE is the mean squared difference from the exact pixel means. It is similar for all patterns; they \
         differ in its structure, the share of the strongest frequency in the energy of the error in blocks of {BLOCK} x \
         {BLOCK} pixels, relative to that of independent errors. Noise has 1, a wave 24. Means over {} pictures of random \
         patterns.",
        realizations(setting)
    ));
}

#[cfg(test)]
mod tests;
