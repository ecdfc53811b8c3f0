use std::ops::Range;

use sphvar_samplers::Pattern;
use sphvar_scene::{
    CornellBox, DirectionMode, DirectionPlan, Estimator, Image, Integral, View, pixel_work, render,
};

use crate::Error;

/// The lighting of the Cornell box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Lighting {
    /// Uniform light: ambient occlusion, the visible fraction of the hemisphere.
    Ambient,
    /// The lamp in the ceiling, of radiance 1, on white diffuse surfaces: direct light.
    Lamp,
}

impl Lighting {
    const fn name(self) -> &'static str {
        match self {
            Self::Ambient => "occlusion",
            Self::Lamp => "lamp",
        }
    }
}

/// Renders of the Cornell box, each with independent sets.
#[derive(Clone, Debug, PartialEq)]
pub struct Pictures {
    /// The pattern of directions; `None` for the reference: jittered hemisphere sets with about
    /// `n_points` directions.
    pub pattern: Option<Pattern>,
    /// The lighting.
    pub lighting: Lighting,
    /// The number of directions per hit point; the pattern uses the nearest valid count.
    pub n_points: usize,
    /// The mapping of point sets to directions; the reference has its own.
    pub mode: DirectionMode,
    /// Pixels per side.
    pub side: usize,
    /// The number of renders.
    pub renders: u64,
}

impl Pictures {
    /// Returns the actual number of directions per hit point; for halves of sphere sets, the
    /// expected number.
    #[must_use]
    pub fn valid_points(&self) -> usize {
        match &self.pattern {
            Some(pattern) => DirectionPlan::nearest_count(pattern, self.n_points, self.mode),
            None => self.n_points,
        }
    }

    pub(crate) fn key(&self) -> String {
        let what = match &self.pattern {
            Some(pattern) => format!("{pattern} {}", self.mode.name()),
            None => "reference".to_owned(),
        };
        let lighting = self.lighting.name();
        format!("pictures {lighting} {what} n={} side={}", self.valid_points(), self.side)
    }

    /// Returns the nominal work of a render.
    pub(crate) fn work(&self) -> f64 {
        let pixels = pixel_work(self.valid_points()) * (self.side * self.side) as f64;
        pixels + self.pattern.as_ref().map_or(0.0, |pattern| self.work_of_sets(pattern))
    }

    /// That of its sets.
    fn work_of_sets(&self, pattern: &Pattern) -> f64 {
        let n = self.valid_points();
        let sets = match self.mode {
            DirectionMode::Rotated | DirectionMode::Antipodal => {
                DirectionPlan::default_sets(pattern, n)
            }
            DirectionMode::Shared | DirectionMode::Spun => 1,
            DirectionMode::Fresh => self.side * self.side,
        };
        sets as f64 * pattern.nominal_work(self.mode.set_points(n))
    }

    pub(crate) fn render(&self, seed: u64, renders: Range<u64>) -> Result<Vec<Image>, Error> {
        let plan = match &self.pattern {
            Some(pattern) => {
                DirectionPlan::new(pattern.clone(), self.valid_points(), self.mode, seed)?
            }
            None => DirectionPlan::reference(self.n_points, seed)?,
        };
        let CornellBox { scene, camera, light } = CornellBox::new();
        let view = View::new(&scene, &camera, [self.side; 2])?;
        let integral = match self.lighting {
            Lighting::Ambient => {
                Integral::AmbientOcclusion { max_distance: f64::INFINITY, cosine: false }
            }
            Lighting::Lamp => Integral::Light { light: &light, albedo: 1.0 },
        };
        let picture = |number| {
            let sets = plan.prepare(number)?;
            Ok(render(&view, &integral, Estimator::Ratio, &sets, &())?)
        };
        renders.map(picture).collect()
    }
}
