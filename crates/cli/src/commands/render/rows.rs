//! Rows of pictures.

use std::ops::Range;

use sphvar_scene::{CropWindow, Image};

use crate::error::CliError;

/// Returns the numbers of all pixels of an image: values, spreads, coverage and sampled spreads.
fn numbers(image: &mut Image) -> [&mut Vec<f64>; 4] {
    let Image { values, spreads, coverage, sampled_spreads, .. } = image;
    [values, spreads, coverage, sampled_spreads]
}

/// Adds an image with the rows below.
///
/// # Errors
///
/// If it has another width or other directions, which only a changed file has.
pub(super) fn append_below(image: &mut Image, mut below: Image) -> Result<(), CliError> {
    if (image.width, image.n_points) != (below.width, below.n_points) {
        return Err(CliError::File("the saved rows of pictures have another form".to_owned()));
    }
    for (all, more) in numbers(image).into_iter().zip(numbers(&mut below)) {
        all.append(more);
    }
    image.height = image.height.saturating_add(below.height);
    image.rays = image.rays.saturating_add(below.rays);
    Ok(())
}

/// Returns some rows of an image, counted from the top. The rays of the whole image belong to the
/// first row.
pub(super) fn rows_of(image: &Image, rows: Range<usize>) -> Image {
    let rays = if rows.start == 0 { image.rays } else { 0 };
    let mut part = Image { height: rows.len(), rays, ..image.clone() };
    for of_pixels in numbers(&mut part) {
        of_pixels.truncate(rows.end * image.width);
        of_pixels.drain(..of_pixels.len().min(rows.start * image.width));
    }
    part
}

/// Returns whether an image has all numbers of the pixels of a region.
pub(super) fn is_complete(image: &Image, region: CropWindow) -> bool {
    let n_pixels = region.width * region.height;
    let Image { values, spreads, coverage, sampled_spreads, .. } = image;
    (image.width, image.height) == (region.width, region.height)
        && [values, spreads, coverage].iter().all(|numbers| numbers.len() == n_pixels)
        && [0, n_pixels].contains(&sampled_spreads.len())
}

#[cfg(test)]
mod tests {
    use super::{CropWindow, Image, append_below, is_complete, rows_of};

    fn image(is_sampled: bool) -> Image {
        let numbers = |first: u32| -> Vec<f64> { (first..first + 12).map(f64::from).collect() };
        Image {
            width: 3,
            height: 4,
            values: numbers(0),
            spreads: numbers(20),
            coverage: numbers(40),
            n_points: 6,
            rays: 72,
            sampled_spreads: if is_sampled { numbers(60) } else { Vec::new() },
        }
    }

    #[test]
    fn rows_add_up_to_their_image() {
        let region = CropWindow { x: 5, y: 7, width: 3, height: 4 };
        for whole in [image(false), image(true)] {
            for cut in 0..=4 {
                let mut sum = rows_of(&whole, 0..cut);
                assert_eq!(is_complete(&sum, region), cut == 4);
                append_below(&mut sum, rows_of(&whole, cut..4)).unwrap();
                assert_eq!(sum.values, whole.values, "cut at {cut}");
                assert_eq!(sum.coverage, whole.coverage, "cut at {cut}");
                assert_eq!(sum.sampled_spreads, whole.sampled_spreads, "cut at {cut}");
                assert!(is_complete(&sum, region), "cut at {cut}");
            }
        }
    }

    #[test]
    fn other_forms_are_errors() {
        let region = CropWindow { x: 0, y: 0, width: 3, height: 4 };
        let mut short = image(true);
        short.sampled_spreads.pop();
        assert!(!is_complete(&short, region));
        let mut wide = image(false);
        wide.width = 4;
        append_below(&mut wide, image(false)).unwrap_err();
        let mut others = image(false);
        others.n_points = 7;
        append_below(&mut others, image(false)).unwrap_err();
    }
}
