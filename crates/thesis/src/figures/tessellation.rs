use glam::DVec3;
use sphvar_samplers::{Ccvt, Domain, MassPoints, Pattern, Purpose, Streams};

use super::Recipe;
use super::mass_points::{NOTE, with_both_kinds};
use super::patterns::{CAPACITY, ThesisPattern};
use super::point_panel::sphere_points;
use crate::{Claim, Error, Figure, Job, Quantity, Results, Setting, ThesisEnsemble, Verdict};

/// Figure 7.3: the sites of a capacity-constrained tessellation.
pub(crate) struct TessellationSites;

/// The number of points, which the thesis does not state.
const N_POINTS: usize = 1024;
/// Lattice directions per site, which give the area of its cell to some percent.
const PROBES: usize = 64;
/// `10 pi/(9 sqrt 3)`: N times the mean squared distance from the middle of a regular hexagon, area
/// 4 pi/N.
const HEXAGONS: f64 = 2.015_333_362_7;

impl Recipe for TessellationSites {
    fn title(&self) -> &'static str {
        "Sites of a capacity-constrained tessellation"
    }

    fn jobs(&self, _: Setting) -> Vec<Job> {
        Vec::new()
    }

    fn compose(&self, setting: Setting, _: &Results, figure: &mut Figure) -> Result<(), Error> {
        let white = ThesisEnsemble::sphere(ThesisPattern::WhiteNoise.pattern(), N_POINTS)
            .set(setting.seed, 0)?;
        let of_white = spread_of_areas(&white)?;
        let tessellation = |kind: ThesisPattern, mass| -> Result<_, Error> {
            let group = kind.pattern().stream_group(N_POINTS);
            let streams = Streams::new(setting.seed, Purpose::Pattern, group);
            let ccvt = Ccvt::new(N_POINTS, Domain::Sphere, CAPACITY, mass)?;
            Ok(ccvt.tessellate(&mut streams.realization(0))?)
        };
        let random = tessellation(ThesisPattern::CcvtRandom, MassPoints::White)?;
        let lattice = tessellation(ThesisPattern::CcvtFibonacci, MassPoints::Fibonacci)?;
        let of = |kind| if kind == ThesisPattern::CcvtRandom { &random } else { &lattice };
        for kind in [ThesisPattern::CcvtRandom, ThesisPattern::CcvtFibonacci] {
            let title = format!("{}, N = {N_POINTS}", kind.label());
            figure.panel(kind.name(), title, sphere_points(of(kind).sites()));
        }
        // The relative uncertainty of an area from m random mass points.
        let noise = 1.0 / (CAPACITY as f64).sqrt();
        let areas = |kind| {
            let spread = spread_of_areas(&of(kind).sites())?;
            let verdict = if spread < noise { Verdict::Holds } else { Verdict::Wrong };
            Ok(Claim::words("areas of the cells", "equal capacities", verdict)
                .measured(Quantity::single(spread))
                .because(format!(
                    "the spread of the areas of the sites' Voronoi cells in parts of the mean, {of_white:.2} for white noise; \
                     the capacity of {CAPACITY} random mass points leaves {noise:.3} open"
                )))
        };
        figure.claims.push(with_both_kinds(None, areas)?);
        let settled = |kind| {
            let verdict = if of(kind).is_settled() { Verdict::Holds } else { Verdict::Wrong };
            let what = "no exchange of mass points lowers the energy";
            Ok(Claim::words(what, "geodesic CCVT", verdict)
                .measured(Quantity::single(of(kind).energy()))
                .because(format!(
                    "where the algorithm ends; N times the mean squared geodesic distance to the site, at least that of \
                     regular hexagons, {HEXAGONS:.3}"
                )))
        };
        figure.claims.push(with_both_kinds(None, settled)?.by_construction());
        figure.note(NOTE);
        Ok(())
    }
}

/// Returns the standard deviation of the areas of the Voronoi cells over their mean, by the nearest
/// sites of a lattice.
fn spread_of_areas(sites: &[DVec3]) -> Result<f64, Error> {
    let probes = ThesisEnsemble::sphere(Pattern::FIBONACCI, PROBES * sites.len()).unrotated();
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
