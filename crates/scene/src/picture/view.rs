use crate::{Camera, CropWindow, DirectionSets, Error, Scene};

/// A view of a scene by a camera: an image or a part of one.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    size: [usize; 2],
    region: CropWindow,
    rays_per_side: usize,
}

impl<'a> View<'a> {
    /// The maximum side of an image.
    pub const MAX_SIDE: usize = 1 << 15;
    /// The maximum number of primary rays of a pixel per side.
    pub const MAX_RAYS_PER_SIDE: usize = 16;

    /// Returns a view of the whole image of `[width, height]` pixels, with one primary ray through
    /// the centre of each.
    ///
    /// # Errors
    ///
    /// Returns [`Error::ImageSize`] for a side of 0 or beyond [`Self::MAX_SIDE`].
    pub fn new(scene: &'a Scene, camera: &'a Camera, size: [usize; 2]) -> Result<Self, Error> {
        const {
            assert!(
                (View::MAX_SIDE * View::MAX_RAYS_PER_SIDE).pow(2) as u64 <= DirectionSets::MAX_HITS
            );
        };
        let [width, height] = size;
        if !size.iter().all(|side| (1..=Self::MAX_SIDE).contains(side)) {
            return Err(Error::ImageSize { width, height, max: Self::MAX_SIDE });
        }
        let region = CropWindow { x: 0, y: 0, width, height };
        Ok(Self { scene, camera, size, region, rays_per_side: 1 })
    }

    /// Returns the part `region` of the view: the values are the same as in the whole image.
    ///
    /// # Errors
    ///
    /// Returns [`Error::CropWindow`] if it is empty or not within the image.
    pub fn with_region(self, region: CropWindow) -> Result<Self, Error> {
        let [width, height] = self.size;
        let fits = |from: usize, length: usize, whole: usize| {
            length > 0 && from < whole && length <= whole - from
        };
        if !(fits(region.x, region.width, width) && fits(region.y, region.height, height)) {
            return Err(Error::CropWindow { region, width, height });
        }
        Ok(Self { region, ..self })
    }

    /// Returns the view with a box filter: the mean over `per_side` by `per_side` primary rays on a
    /// regular grid in each pixel, each with separate directions.
    ///
    /// # Errors
    ///
    /// Returns [`Error::RaysPerSide`] for 0 or beyond [`Self::MAX_RAYS_PER_SIDE`].
    pub fn with_rays_per_side(self, per_side: usize) -> Result<Self, Error> {
        if !(1..=Self::MAX_RAYS_PER_SIDE).contains(&per_side) {
            return Err(Error::RaysPerSide { got: per_side, max: Self::MAX_RAYS_PER_SIDE });
        }
        Ok(Self { rays_per_side: per_side, ..self })
    }

    /// Returns the scene.
    #[must_use]
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// Returns the camera.
    #[must_use]
    pub fn camera(&self) -> &'a Camera {
        self.camera
    }

    /// Returns the width and height of the whole image.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Returns the rendered part.
    #[must_use]
    pub fn region(&self) -> CropWindow {
        self.region
    }

    /// Returns the number of primary rays of a pixel per side.
    #[must_use]
    pub fn rays_per_side(&self) -> usize {
        self.rays_per_side
    }
}
