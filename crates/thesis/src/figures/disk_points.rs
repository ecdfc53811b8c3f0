use glam::DVec3;
use sphvar_samplers::PoissonDisk;

use super::Recipe;
use super::patterns::ThesisPattern;
use super::point_panel::sphere_points;
use crate::{Claim, Error, Figure, Job, Quantity, Results, Setting, ThesisEnsemble, Verdict};

/// Figure 7.2: Poisson disk points.
pub(crate) struct DiskPoints;

/// The number of points, which the thesis does not state.
const N_POINTS: usize = 1024;

impl Recipe for DiskPoints {
    fn title(&self) -> &'static str {
        "Poisson disk points"
    }

    fn jobs(&self, _: Setting) -> Vec<Job> {
        Vec::new()
    }

    fn compose(&self, setting: Setting, _: &Results, figure: &mut Figure) -> Result<(), Error> {
        let set = |pattern: ThesisPattern| {
            ThesisEnsemble::sphere(pattern.pattern(), N_POINTS).unrotated().set(setting.seed, 0)
        };
        let points = set(ThesisPattern::PoissonDisk)?;
        let root = (N_POINTS as f64).sqrt();
        let shortest = root * shortest_chord(&points);
        let white = root * shortest_chord(&set(ThesisPattern::WhiteNoise)?);
        figure.panel("points", format!("Poisson disk, N = {N_POINTS}"), sphere_points(points));
        let radius = PoissonDisk::EXACT_RADIUS;
        let verdict = if shortest >= radius { Verdict::Holds } else { Verdict::Wrong };
        figure.claims.push(
            Claim::words(
                "shortest chord between two points, times sqrt(N)",
                "samples that are too close are rejected",
                verdict,
            )
            .measured(Quantity::single(shortest))
            .because(format!(
                "the sampler enforces {radius}; the thesis prints no radius, this one is of the author's published program. \
                 Of white noise the chord is {white:.3}"
            ))
            .by_construction(),
        );
        let fill = PoissonDisk::EXACT_RADIUS.powi(2) / 16.0;
        figure.note(format!(
            "Sets come from dart throwing with exactly N points; their disks of half the chord cover {fill:.3} of the sphere \
             (saturated sets: 0.547). The thesis rejects samples from a dense set and calls the result close to boundary \
             sampling (Dunbar and Humphreys). Its claims about spectra at low degrees and their bounds are checked with \
             boundary sampling too; others that dart throwing contradicts are undecided."
        ));
        Ok(())
    }
}

/// Returns the shortest chord between two points, by all pairs.
fn shortest_chord(points: &[DVec3]) -> f64 {
    let pairs = points
        .iter()
        .enumerate()
        .flat_map(|(i, p)| points[..i].iter().map(move |q| p.distance_squared(*q)));
    pairs.fold(f64::INFINITY, f64::min).sqrt()
}
