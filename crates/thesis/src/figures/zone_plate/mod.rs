//! Pictures of a zone plate with about one sample per pixel, and the structure of their errors.

mod aliasing;
mod screen;

use self::aliasing::{Aliasing, BLOCK};
use self::screen::Screen;
use super::Recipe;
use super::square_patterns::PlanePattern;
use crate::{Claim, Error, Figure, Job, Picture, Quantity, Results, Setting, Stated, Verdict};

/// A figure with pictures of the zone plate `sin(x^2 + y^2)`.
pub(crate) enum ZonePlates {
    /// Figure 4.1: the reference, regular and jittered samples.
    Test,
    /// Figure 4.8: low-discrepancy points, and random ones for comparison.
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
            Self::Patterns => &[Halton, Hammersley, Fibonacci, WhiteNoise, PoissonDisk],
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
        if matches!(self, Self::Test) {
            figure.panel(
                "reference",
                "Reference",
                picture(
                    &screen.mitchell()?,
                    "The limit N = infinity of samples per pixel, with the filter of Mitchell and Netravali".to_owned(),
                ),
            );
        }
        let mut tests = Vec::new();
        for &pattern in self.patterns() {
            let test = Test::run(pattern, &screen, &exact, setting)?;
            figure.panel(
                pattern.name(),
                format!("{}, one sample per pixel", pattern.label()),
                picture(&test.first, test.caption()),
            );
            figure.claims.extend(self.claim(pattern, test.structure));
            tests.push(test);
        }
        if let (Self::Patterns, [halton, hammersley, fibonacci, ..]) = (self, &tests[..]) {
            figure.claims.extend(comparisons([halton, hammersley, fibonacci]));
        }
        self.notes(&screen, setting, figure);
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
            (Self::Patterns, Hammersley | Fibonacci) => (
                structured,
                "\"effects of high energy Fourier peaks\", which section 4.1.1 ascribes to the pattern, read as twice the \
                 structure of noise",
            ),
            _ => return None,
        };
        let what = format!("{}: structure of the error of the zone plate", pattern.label());
        Some(Claim::number(what, stated, structure).because(because))
    }

    fn notes(&self, screen: &Screen, setting: Setting, figure: &mut Figure) {
        if matches!(self, Self::Patterns) {
            figure.note(
                "Figure 4.1 has the reference and the pictures with regular and jittered samples.",
            );
        }
        notes(screen, setting, figure);
    }
}

/// Returns the comparisons of Halton, Hammersley and Fibonacci points.
fn comparisons(tests: [&Test; 3]) -> [Claim; 3] {
    let [halton, hammersley, fibonacci] = tests.map(|test| test.noise);
    let structures = tests.map(|test| test.structure.value);
    let compared = |what: &str, stated, holds, value, others: String| {
        Claim::words(what, stated, if holds { Verdict::Holds } else { Verdict::Wrong })
            .measured(Quantity::exact(value))
            .because(others)
    };
    [
        compared(
            "Halton: structure of the error of the zone plate, below those of Hammersley and Fibonacci",
            "shows less artifacts",
            structures[0] < structures[1].min(structures[2]),
            structures[0],
            format!("Hammersley {:.3}, Fibonacci {:.3}", structures[1], structures[2]),
        ),
        compared(
            "Halton: noise of the zone plate, above those of Hammersley and Fibonacci",
            "appears more noisy",
            halton > hammersley.max(fibonacci),
            halton,
            format!(
                "Hammersley {hammersley:.3}, Fibonacci {fibonacci:.3}; the mean squared error without the strongest \
                 frequency of each block"
            ),
        ),
        compared(
            "Fibonacci lattice: noise of the zone plate, below those of Halton and Hammersley",
            "structural artifacts, with less noise",
            fibonacci < halton.min(hammersley),
            fibonacci,
            format!(
                "Halton {halton:.3}, Hammersley {hammersley:.3}; the lattice has {} points, the others {}",
                tests[2].n_points, tests[0].n_points
            ),
        ),
    ]
}

/// The pictures of a pattern.
struct Test {
    n_points: usize,
    /// The first picture.
    first: Vec<f64>,
    /// The mean over all pictures.
    mse: f64,
    structure: Quantity,
    noise: f64,
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
        let n_points = ensemble.n_points;
        Ok(Self { n_points, first, mse: mean(|a| a.mse), structure, noise: mean(|a| a.noise) })
    }

    fn caption(&self) -> String {
        let Quantity { value, interval: (low, high) } = self.structure;
        let interval = if low < high { format!(" ({low:.2} to {high:.2})") } else { String::new() };
        format!(
            "N = {}, MSE {:.3}, structure {value:.2}{interval}, noise {:.3}",
            self.n_points, self.mse, self.noise
        )
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
         {BLOCK} pixels, relative to that of independent errors. Independent errors have 1, a wave 24. Pixels without a \
         sample repeat a neighbour, which correlates errors; of white noise they are a share of 1/e, so that its \
         structure exceeds 1. Noise is the MSE without the strongest frequency of each block. Means over {} pictures of \
         random patterns, with 95 % intervals of the structure.",
        realizations(setting)
    ));
}

#[cfg(test)]
mod tests;
