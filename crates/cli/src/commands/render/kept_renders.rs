//! What is kept of renders until their errors are known.

use serde::{Deserialize, Serialize};
use sphvar_scene::{Image, RenderErrors};

use crate::error::CliError;

/// The pixels of renders in order: 8 bytes each, 16 of directions of densities. Errors need all values
/// in order, because sums of rounded numbers would depend on the division into parts.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct KeptRenders {
    n_points: usize,
    renders: Vec<KeptRender>,
    /// Occlusion rays and their time.
    pub(super) rays: u64,
    pub(super) seconds: f64,
}

#[derive(Debug, Serialize, Deserialize)]
struct KeptRender {
    values: Vec<f64>,
    sampled_spreads: Vec<f64>,
}

impl KeptRenders {
    /// Returns no renders with `n_points` directions.
    pub(super) fn new(n_points: usize) -> Self {
        Self { n_points, renders: Vec::new(), rays: 0, seconds: 0.0 }
    }

    /// Returns the number of renders.
    pub(super) fn count(&self) -> u64 {
        self.renders.len() as u64
    }

    /// Adds a render whose rays took a time.
    pub(super) fn push(&mut self, image: Image, seconds: f64) {
        self.rays += image.rays;
        self.seconds += seconds;
        let Image { values, sampled_spreads, .. } = image;
        self.renders.push(KeptRender { values, sampled_spreads });
    }

    /// Adds the renders that follow.
    ///
    /// # Errors
    ///
    /// If they have another number of directions.
    pub(super) fn append(&mut self, others: Self) -> Result<(), CliError> {
        if self.n_points != others.n_points {
            return Err(other_form());
        }
        self.renders.extend(others.renders);
        self.rays = self.rays.saturating_add(others.rays);
        self.seconds += others.seconds;
        Ok(())
    }

    /// Returns the errors relative to the reference image, which shows the same view.
    ///
    /// # Errors
    ///
    /// If the renders are of another size, which only a changed file has.
    pub(super) fn errors(self, reference: &Image) -> Result<RenderErrors<'_>, CliError> {
        let mut errors = RenderErrors::new(reference);
        let mut image = Image {
            spreads: Vec::new(),
            sampled_spreads: Vec::new(),
            n_points: self.n_points,
            rays: 0,
            ..reference.clone()
        };
        let n_pixels = reference.values.len();
        let n_spreads = self.renders.first().map_or(0, |first| first.sampled_spreads.len());
        for KeptRender { values, sampled_spreads } in self.renders {
            let is_of_view = values.len() == n_pixels && sampled_spreads.len() == n_spreads;
            if !is_of_view || ![0, n_pixels].contains(&n_spreads) {
                return Err(other_form());
            }
            (image.values, image.sampled_spreads) = (values, sampled_spreads);
            errors.push(&image).map_err(CliError::failed)?;
        }
        Ok(errors)
    }
}

fn other_form() -> CliError {
    CliError::File("the saved renders have another form".to_owned())
}

#[cfg(test)]
mod tests {
    use super::{Image, KeptRenders, RenderErrors};

    fn image(value: f64, sampled_spreads: Vec<f64>) -> Image {
        Image {
            width: 8,
            height: 8,
            values: (0..64).map(|i| value * (1.0 + f64::from(i))).collect(),
            spreads: vec![0.25; 64],
            coverage: vec![1.0; 64],
            n_points: 16,
            rays: 5,
            sampled_spreads,
        }
    }

    /// Returns the renders as one piece of a file for each.
    fn kept(images: &[Image]) -> KeptRenders {
        let pieces = images.iter().map(|image| {
            let mut kept = KeptRenders::new(image.n_points);
            kept.push(image.clone(), 0.5);
            postcard::from_bytes(&postcard::to_stdvec(&kept).unwrap()).unwrap()
        });
        let mut all = KeptRenders::new(16);
        pieces.for_each(|piece| all.append(piece).unwrap());
        all
    }

    #[test]
    fn kept_renders_have_the_errors_of_their_images() {
        let reference = image(0.1, Vec::new());
        for spreads in [Vec::new(), vec![0.3; 64]] {
            let images = [0.1, 0.11, 0.07].map(|value| image(value, spreads.clone()));
            let mut errors = RenderErrors::new(&reference);
            images.iter().for_each(|image| errors.push(image).unwrap());
            let kept = kept(&images);
            assert_eq!((kept.count(), kept.rays, kept.seconds), (3, 15, 1.5));
            let restored = kept.errors(&reference).unwrap();
            assert_eq!(restored.report(), errors.report());
            assert_eq!(restored.squared_errors(), errors.squared_errors());
        }
    }

    #[test]
    fn renders_of_another_size_are_errors() {
        let reference = image(0.1, Vec::new());
        let spread = image(0.1, vec![0.3; 64]);
        let short = Image { values: vec![0.5; 63], ..reference.clone() };
        let mixed = [reference.clone(), spread];
        let few = image(0.1, vec![0.3; 63]);
        for images in [&[short][..], &mixed, &[few]] {
            assert!(kept(images).errors(&reference).is_err());
        }
        let other = KeptRenders::new(17);
        assert!(kept(&[reference]).append(other).is_err());
    }
}
