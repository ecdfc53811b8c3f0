//! A pixel's value is a function of the seed and the pixel.

use rayon::ThreadPoolBuilder;
use sphvar_samplers::Pattern;
use sphvar_scene::{
    CornellBox, CropWindow, DirectionMode, DirectionPlan, Estimator, Image, Integral, View, render,
};

const AMBIENT: Integral<'static> =
    Integral::AmbientOcclusion { max_distance: f64::INFINITY, cosine: false };
const SIZE: [usize; 2] = [37, 29];

fn picture(
    mode: DirectionMode,
    seed: u64,
    number: u64,
    region: Option<CropWindow>,
    k: usize,
) -> Image {
    let cornell = CornellBox::new();
    let mut view = View::new(&cornell.scene, &cornell.camera, SIZE).unwrap();
    view = view.with_rays_per_side(k).unwrap();
    if let Some(region) = region {
        view = view.with_region(region).unwrap();
    }
    let plan = DirectionPlan::new(Pattern::Jittered, 24, mode, seed).unwrap().with_sets(5).unwrap();
    let sets = plan.prepare(number).unwrap();
    render(&view, &AMBIENT, Estimator::Ratio, &sets, &()).unwrap()
}

#[test]
fn results_do_not_depend_on_threads() {
    for mode in DirectionMode::ALL {
        let with = |threads| {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| picture(mode, 7, 0, None, 1))
        };
        let one = with(1);
        assert_eq!(one, with(2), "{mode}");
        assert_eq!(one, with(5), "{mode}");
    }
}

#[test]
fn a_crop_window_equals_the_part_of_the_whole() {
    let region = CropWindow { x: 5, y: 9, width: 23, height: 18 };
    for mode in DirectionMode::ALL {
        let whole = picture(mode, 7, 1, None, 2);
        let part = picture(mode, 7, 1, Some(region), 2);
        assert_eq!((part.width, part.height), (region.width, region.height));
        for y in 0..region.height {
            for x in 0..region.width {
                let (i, j) = (y * region.width + x, (y + region.y) * SIZE[0] + x + region.x);
                assert_eq!(
                    part.values[i].to_bits(),
                    whole.values[j].to_bits(),
                    "{mode}: pixel ({x}, {y})"
                );
                assert_eq!(
                    part.spreads[i].to_bits(),
                    whole.spreads[j].to_bits(),
                    "{mode}: pixel ({x}, {y})"
                );
                let [coverage, expected] = [part.coverage[i], whole.coverage[j]].map(f64::to_bits);
                assert_eq!(coverage, expected, "{mode}: pixel ({x}, {y})");
            }
        }
    }
}

#[test]
fn seeds_and_renders_give_different_pictures() {
    for mode in DirectionMode::ALL {
        let one = picture(mode, 7, 0, None, 1);
        assert_ne!(one.values, picture(mode, 8, 0, None, 1).values, "{mode}");
        assert_ne!(one.values, picture(mode, 7, 1, None, 1).values, "{mode}");
    }
}

#[test]
fn crop_windows_and_sizes_out_of_range_are_rejected() {
    let cornell = CornellBox::new();
    for size in [[0, 4], [4, 0], [View::MAX_SIDE + 1, 4], [usize::MAX, 1]] {
        View::new(&cornell.scene, &cornell.camera, size).unwrap_err();
    }
    let view = View::new(&cornell.scene, &cornell.camera, [8, 6]).unwrap();
    for [x, y, width, height] in [
        [0, 0, 0, 1],
        [0, 0, 1, 0],
        [8, 0, 1, 1],
        [0, 6, 1, 1],
        [1, 0, 8, 6],
        [usize::MAX, 0, 2, 2],
    ] {
        let region = CropWindow { x, y, width, height };
        let message = view.with_region(region).unwrap_err().to_string();
        assert!(message.contains("8 by 6"), "{message}");
    }
    view.with_region(CropWindow { x: 7, y: 5, width: 1, height: 1 }).unwrap();
    for k in [0, View::MAX_RAYS_PER_SIDE + 1] {
        view.with_rays_per_side(k).unwrap_err();
    }
}
