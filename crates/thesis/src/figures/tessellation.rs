use glam::DVec3;
use sphvar_samplers::{Ccvt, Domain, Pattern, Purpose, Streams};

use super::Recipe;
use super::patterns::{CAPACITY, MASS_POINTS, ThesisPattern};
use super::point_panel::sphere_points;
use crate::{Claim, Error, Figure, Job, Quantity, Results, Setting, ThesisEnsemble, Verdict};

/// Figure 7.3: the sites of a capacity-constrained tessellation.
pub(crate) struct TessellationSites;

/// The number of points, which the thesis does not state.
const N_POINTS: usize = 1024;
/// Directions of a lattice to a site, which find its cell's area to some percent.
const PROBES: usize = 64;
/// `10 pi/(9 sqrt 3)`: N times the mean squared distance from the middle of a regular hexagon, area 4 pi/N.
const HEXAGONS: f64 = 2.015_333_362_7;

impl Recipe for TessellationSites {
    fn title(&self) -> &'static str {
        "Sites of a capacity-constrained tessellation"
    }

    fn jobs(&self, _: Setting) -> Vec<Job> {
        Vec::new()
    }

    fn compose(&self, setting: Setting, _: &Results, figure: &mut Figure) -> Result<(), Error> {
        let pattern = ThesisPattern::Ccvt.pattern();
        let streams = Streams::new(setting.seed, Purpose::Pattern, pattern.stream_group(N_POINTS));
        let ccvt = Ccvt::new(N_POINTS, Domain::Sphere, CAPACITY, MASS_POINTS)?;
        let tessellation = ccvt.tessellate(&mut streams.realization(0))?;
        let sites = tessellation.sites();
        let white = ThesisEnsemble::sphere(ThesisPattern::WhiteNoise.pattern(), N_POINTS)
            .set(setting.seed, 0)?;
        let (spread, of_white) = (spread_of_areas(&sites)?, spread_of_areas(&white)?);
        figure.panel("points", format!("CCVT, N = {N_POINTS}"), sphere_points(sites));
        // What m random mass points leave open of an area.
        let noise = 1.0 / (CAPACITY as f64).sqrt();
        let verdict = if spread < noise { Verdict::Holds } else { Verdict::Wrong };
        figure.claims.push(
            Claim::words("areas of the cells", "equal capacities", verdict)
                .found(Quantity::single(spread))
                .because(format!(
                    "found is the spread of the areas of the sites' Voronoi cells in parts of the mean, beside {of_white:.2} of \
                     white noise; the number {CAPACITY} of random mass points leaves {noise:.3} open"
                )),
        );
        let verdict = if tessellation.is_settled() { Verdict::Holds } else { Verdict::Wrong };
        figure.claims.push(
            Claim::words("no exchange of mass points lowers the energy", "geodesic CCVT", verdict)
                .found(Quantity::single(tessellation.energy()))
                .because(format!(
                    "found is N times the mean squared geodesic distance to the site; no pattern is below regular \
                     hexagons, {HEXAGONS:.3}"
                )),
        );
        figure.note(format!(
            "{CAPACITY} random mass points to a site. The thesis states neither their number nor their kind, which decide the power \
             of the lowest degrees (erratum 39)."
        ));
        Ok(())
    }
}

/// The standard deviation of the areas of the Voronoi cells over their mean, by the nearest sites of a lattice.
fn spread_of_areas(sites: &[DVec3]) -> Result<f64, Error> {
    let probes = ThesisEnsemble::sphere(Pattern::Fibonacci, PROBES * sites.len()).unturned();
    let mut areas = vec![0_u32; sites.len()];
    for probe in probes.set(0, 0)? {
        let mut nearest = (f64::NEG_INFINITY, 0);
        for (k, site) in sites.iter().enumerate() {
            let cosine = site.dot(probe);
            if cosine > nearest.0 {
                nearest = (cosine, k);
            }
        }
        areas[nearest.1] += 1;
    }
    let mean = PROBES as f64;
    let variance: f64 = areas.iter().map(|&a| (f64::from(a) - mean).powi(2)).sum();
    Ok((variance / sites.len() as f64).sqrt() / mean)
}
