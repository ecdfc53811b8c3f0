use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::Progress;

use crate::picture::integral::Workspace;
use crate::{Directions, Error, Estimator, Image, Integral, SetWeight, ShadingPoint, View};

/// The side of the square tiles, which are rendered one at a time.
const TILE: usize = 16;

/// One pixel.
#[derive(Clone, Copy, Debug, Default)]
struct Pixel {
    value: f64,
    spread: f64,
    sampled_spread: f64,
    coverage: f64,
    rays: u64,
}

/// Returns the image of a view, rendered in parallel over tiles. Ticks [`pixel_work`] for each
/// pixel and [`Directions::own_work`].
///
/// The estimator matters only for halves of weighted or sphere sets; importance sampling is
/// unbiased.
///
/// A pixel's value depends only on the view's scene, camera and size, the integral, the directions
/// and its position in the image.
///
/// # Errors
///
/// Returns the errors of [`Integral::check`], and [`Error::Sampler`] if a set cannot be
/// generated or `progress` stops the work.
///
/// # Examples
///
/// ```
/// use sphvar_samplers::Pattern;
/// use sphvar_scene::{
///     CornellBox, DirectionMode, DirectionPlan, Estimator, Integral, View, render,
/// };
///
/// let cornell = CornellBox::new();
/// let view = View::new(&cornell.scene, &cornell.camera, [32, 32])?;
/// let ambient = Integral::AmbientOcclusion { max_distance: f64::INFINITY, cosine: false };
/// let plan = DirectionPlan::new(Pattern::Jittered, 24, DirectionMode::Antipodal, 0)?;
/// let image = render(&view, &ambient, Estimator::Ratio, &plan.prepare(0)?, &())?;
/// // The box is open in front only.
/// assert!(image.mean() > 0.0 && image.mean() < 0.5);
/// # Ok::<(), sphvar_scene::Error>(())
/// ```
pub fn render(
    view: &View<'_>,
    integral: &Integral<'_>,
    estimator: Estimator,
    directions: &dyn Directions,
    progress: &dyn Progress,
) -> Result<Image, Error> {
    integral.check()?;
    let region = view.region();
    let across = region.width.div_ceil(TILE);
    let n_tiles = across * region.height.div_ceil(TILE);
    let corner = |tile: usize| [TILE * (tile % across), TILE * (tile / across)];
    let extent = |[x, y]: [usize; 2]| [TILE.min(region.width - x), TILE.min(region.height - y)];
    let tiles: Result<Vec<Vec<Pixel>>, Error> = (0..n_tiles)
        .into_par_iter()
        .map_init(Workspace::default, |workspace, tile| {
            let [left, top] = corner(tile);
            let [width, height] = extent([left, top]);
            let mut pixels = Vec::with_capacity(width * height);
            for y in top..top + height {
                for x in left..left + width {
                    let at = [region.x + x, region.y + y];
                    pixels.push(pixel(view, integral, estimator, directions, at, workspace)?);
                }
            }
            let work = pixel_work(directions.n_points()) + directions.own_work();
            let work = pixels.len() as f64 * work;
            progress.tick(work).map_err(sphvar_samplers::Error::from)?;
            Ok(pixels)
        })
        .collect();
    let n_pixels = region.width * region.height;
    let mut image = Image {
        width: region.width,
        height: region.height,
        values: vec![0.0; n_pixels],
        spreads: vec![0.0; n_pixels],
        coverage: vec![0.0; n_pixels],
        n_points: directions.n_points(),
        rays: 0,
        sampled_spreads: if directions.is_uniform() { Vec::new() } else { vec![0.0; n_pixels] },
    };
    for (tile, pixels) in tiles?.iter().enumerate() {
        let [left, top] = corner(tile);
        let [width, _] = extent([left, top]);
        for (i, pixel) in pixels.iter().enumerate() {
            let at = (top + i / width) * region.width + left + i % width;
            image.values[at] = pixel.value;
            image.spreads[at] = pixel.spread;
            image.coverage[at] = pixel.coverage;
            if let Some(spread) = image.sampled_spreads.get_mut(at) {
                *spread = pixel.sampled_spread;
            }
            image.rays += pixel.rays;
        }
    }
    Ok(image)
}

/// Returns the nominal work of a pixel with `n_points` directions: 100 ns per ray and a
/// microsecond.
#[must_use]
pub fn pixel_work(n_points: usize) -> f64 {
    1.6 * n_points as f64 + 16.0
}

fn pixel(
    view: &View<'_>,
    integral: &Integral<'_>,
    estimator: Estimator,
    directions: &dyn Directions,
    [x, y]: [usize; 2],
    workspace: &mut Workspace,
) -> Result<Pixel, Error> {
    let per_side = view.rays_per_side();
    let [width, _] = view.size();
    let mut pixel = Pixel::default();
    let mut hits = 0;
    for (j, i) in (0..per_side).flat_map(|j| (0..per_side).map(move |i| (j, i))) {
        let within = |cell: usize| (cell as f64 + 0.5) / per_side as f64;
        let dir = view.camera().direction(x as f64 + within(i), y as f64 + within(j), view.size());
        let Some(hit) = view.scene().closest_hit(view.camera().position(), dir) else {
            continue;
        };
        let index = (y * width + x) * per_side * per_side + j * per_side + i;
        let set = &mut workspace.directions;
        let point = ShadingPoint::new(view.scene(), &hit);
        let SetWeight { visible, expected } =
            directions.directions_into(&point, index as u64, set)?;
        let sums = integral.sums(view.scene(), &hit, workspace);
        pixel.value += estimator.factor(visible, expected) * sums.values;
        let over_visible = |sum: f64| if visible == 0.0 { 0.0 } else { sum / visible };
        let mean = over_visible(sums.values);
        // For a constant, rounding may leave slightly less than 0.
        let spread = (over_visible(sums.squares) - mean * mean).max(0.0);
        pixel.spread += spread;
        let n = directions.n_points() as f64;
        let squares = n * sums.squared_terms / (visible * visible);
        pixel.sampled_spread += (squares - mean * mean).max(0.0);
        hits += 1;
        pixel.rays += sums.rays;
    }
    let share = 1.0 / f64::from(hits.max(1));
    pixel.value *= share;
    pixel.spread *= share * share;
    pixel.sampled_spread *= share * share;
    pixel.coverage = f64::from(hits) / (per_side * per_side) as f64;
    Ok(pixel)
}
