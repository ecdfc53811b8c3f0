use glam::DVec3;
use sphvar_healpix::{Cell, Nside, PixelOrder, Ring};

use super::Recipe;
use super::patterns::ThesisPattern;
use super::point_panel::VIEWPOINT;
use crate::{
    Claim, Directions, Error, Figure, Job, Quantity, Results, Setting, Stated, ThesisEnsemble,
};

/// Figure 7.1: white noise, HEALPix centres and jittered points, with the HEALPix cells.
pub(crate) struct Strata;

/// The resolution of the picture: 432 cells, few enough to be visible.
const NSIDE: u32 = 6;
const PATTERNS: [ThesisPattern; 3] =
    [ThesisPattern::WhiteNoise, ThesisPattern::Healpix, ThesisPattern::Jittered];

impl Recipe for Strata {
    fn title(&self) -> &'static str {
        "White noise, HEALPix centres and jittered points with their strata"
    }

    fn jobs(&self, _: Setting) -> Vec<Job> {
        Vec::new()
    }

    fn compose(&self, setting: Setting, _: &Results, figure: &mut Figure) -> Result<(), Error> {
        let order = Ring::new(Nside::new(NSIDE)?);
        let n = 12 * (NSIDE * NSIDE) as usize;
        let mut single = Vec::new();
        for pattern in PATTERNS {
            let points =
                ThesisEnsemble::sphere(pattern.pattern(), n).unrotated().set(setting.seed, 0)?;
            single.push(share_with_one(&order, &points));
            let lines = match pattern {
                ThesisPattern::WhiteNoise => Vec::new(),
                _ => cell_borders()?,
            };
            figure.panel(
                pattern.name(),
                format!("{}, N = {n}", pattern.label()),
                Directions { points, viewpoint: VIEWPOINT, lines },
            );
        }
        figure.claims.push(
            Claim::number(
                "area of the largest HEALPix cell over the smallest",
                Stated::About { value: 1.0, tolerance: 1e-4 },
                Quantity::exact(ratio_of_areas(&order)),
            )
            .because(
                "\"an equal area quadrangulation\", as HEALPix is defined; polygons of 512 sides, good to about 1e-5",
            )
            .by_construction(),
        );
        figure.claims.push(
            Claim::number(
                "jittered: share of the strata with exactly one point",
                Stated::About { value: 1.0, tolerance: 0.0 },
                Quantity::exact(single[2]),
            )
            .because(format!(
                "the sampler puts one point into each; of white noise it is {:.3}",
                single[0]
            ))
            .by_construction(),
        );
        figure.note("The thesis states no numbers of points here. Sets are not rotated.");
        Ok(())
    }
}

/// Returns the fraction of the pixels with exactly one of the points.
fn share_with_one(order: &Ring, points: &[DVec3]) -> f64 {
    let mut pixels: Vec<u64> = points.iter().map(|&p| order.pixel(p)).collect();
    pixels.sort_unstable();
    let alone = pixels.chunk_by(|a, b| a == b).filter(|same| same.len() == 1).count();
    alone as f64 / order.n_pixels() as f64
}

/// Returns the borders of all cells: the lines of the grid of each of the 12 faces.
fn cell_borders() -> Result<Vec<Vec<DVec3>>, Error> {
    const STEPS: u32 = 48;
    let whole = Nside::new(1)?;
    let mut lines = Vec::new();
    for face in 0..12 {
        let cell = Cell::new(whole, face, 0, 0)?;
        for k in 0..=NSIDE {
            let across = f64::from(k) / f64::from(NSIDE);
            let along = (0..=STEPS).map(|step| f64::from(step) / f64::from(STEPS));
            lines.push(along.clone().map(|t| cell.uniform_point(across, t)).collect());
            lines.push(along.map(|t| cell.uniform_point(t, across)).collect());
        }
    }
    Ok(lines)
}

/// Returns the area of the largest cell over that of the smallest, by polygons through points of
/// their borders.
fn ratio_of_areas(order: &Ring) -> f64 {
    let areas = (0..order.n_pixels()).map(|pixel| area(order.cell(pixel)));
    let (min, max) =
        areas.fold((f64::INFINITY, 0.0_f64), |(low, high), a| (low.min(a), high.max(a)));
    max / min
}

fn area(cell: Cell) -> f64 {
    const STEPS: u32 = 128;
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let border: Vec<DVec3> = (0..4 * STEPS)
        .map(|k| {
            let (from, to) = (corners[(k / STEPS) as usize], corners[(k / STEPS + 1) as usize % 4]);
            let t = f64::from(k % STEPS) / f64::from(STEPS);
            cell.uniform_point(from.0 + t * (to.0 - from.0), from.1 + t * (to.1 - from.1))
        })
        .collect();
    let centre = cell.centre();
    let next = border.iter().cycle().skip(1);
    border.iter().zip(next).map(|(&a, &b)| triangle_area(centre, a, b)).sum()
}

/// Returns the area of a spherical triangle (Van Oosterom and Strackee 1983), positive if its
/// corners are counter-clockwise.
fn triangle_area(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    2.0 * a.dot(b.cross(c)).atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}
