use std::ops::Range;

use sphvar_samplers::Pattern;
use sphvar_scene::{
    CornellBox, DirectionMode, DirectionPlan, Estimator, Image, Integral, View, pixel_work, render,
};

use crate::Error;

/// What lights the Cornell box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Lighting {
    /// Light from all around: ambient occlusion, the open share of the hemisphere.
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

/// Renders of the Cornell box, each with sets of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Pictures {
    /// The pattern of directions; `None` for the reference: jittered, with about `n_points` directions, kept halves of
    /// none.
    pub pattern: Option<Pattern>,
    /// What lights the box.
    pub lighting: Lighting,
    /// The number of directions of a hit point, or the one that the pattern has next to it.
    pub n_points: usize,
    /// How sets become directions; the reference has its own way.
    pub mode: DirectionMode,
    /// Pixels on a side.
    pub side: usize,
    /// How many renders.
    pub renders: u64,
}

impl Pictures {
    /// The number of directions of a hit point that the pattern really has; of halves of sphere sets the expected one.
    #[must_use]
    pub fn legal_points(&self) -> usize {
        match &self.pattern {
            Some(pattern) => DirectionPlan::nearest_count(pattern, self.n_points),
            None => self.n_points,
        }
    }

    pub(crate) fn key(&self) -> String {
        let what = match &self.pattern {
            Some(pattern) => format!("{pattern} {}", self.mode.name()),
            None => "reference".to_owned(),
        };
        let lighting = self.lighting.name();
        format!("pictures {lighting} {what} n={} side={}", self.legal_points(), self.side)
    }

    /// The nominal work of a render.
    pub(crate) fn work(&self) -> f64 {
        let pixels = pixel_work(self.legal_points()) * (self.side * self.side) as f64;
        pixels + self.pattern.as_ref().map_or(0.0, |pattern| self.work_of_sets(pattern))
    }

    /// That of its sets.
    fn work_of_sets(&self, pattern: &Pattern) -> f64 {
        let n = self.legal_points();
        let sets = match self.mode {
            DirectionMode::Rotated | DirectionMode::Projective => {
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
                DirectionPlan::new(pattern.clone(), self.legal_points(), self.mode, seed)?
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
