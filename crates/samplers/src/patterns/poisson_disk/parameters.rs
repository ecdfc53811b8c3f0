use sphvar_grammar::{Declaration, Parametric, Range};

use super::{BoundaryPoissonDisk, DecreasingPoissonDisk, DiskMode, DiskPlacement, PoissonDisk};
use crate::definition::Definition;
use crate::{CostOrder, Domain, Error, PatternFacts, Rate, Sampler};

/// Parameters of the pattern [`PoissonDisk`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoissonDiskParameters {
    /// The criterion by which a set is complete.
    pub mode: DiskMode,
    /// The minimum chord times sqrt(N), or [`PoissonDisk::default_radius`].
    pub radius: Option<f64>,
    /// The method by which points are placed.
    pub placement: DiskPlacement,
}

impl PoissonDiskParameters {
    /// The default parameters.
    pub const DEFAULT: Self =
        Self { mode: DiskMode::Exact, radius: None, placement: DiskPlacement::DartThrowing };
}

impl Default for PoissonDiskParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parametric for PoissonDiskParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        d.choice(
            "mode",
            "exactly N points, or the number at which the set is saturated",
            &mut self.mode,
        );
        let summary = "minimum chord times sqrt(N), on the hemisphere times sqrt(2N)";
        d.optional_number("radius", Range::POSITIVE, summary, "by N", &mut self.radius);
        d.choice("placement", "method by which points are placed", &mut self.placement);
    }
}

impl Definition for PoissonDiskParameters {
    fn facts(&self) -> PatternFacts {
        let low_degrees = match (self.placement, self.mode) {
            (DiskPlacement::DartThrowing, DiskMode::Exact) => "0.0596",
            (DiskPlacement::DartThrowing, DiskMode::Saturated) => "0.0578",
            (DiskPlacement::Boundary, _) => "0.04, twice that at l = 1",
            (DiskPlacement::Decreasing, _) => "0.08",
        };
        PatternFacts {
            cost: match (self.placement, self.mode) {
                (DiskPlacement::Boundary, DiskMode::Exact) => {
                    CostOrder { exponent: 1.5, ..CostOrder::LINEAR }
                }
                _ => CostOrder::LINEAR,
            },
            low_degrees,
            smooth_rate: Rate::power(-1.0),
            jump_rate: Rate::power(-1.0),
            is_extensible: false,
            source: match self.placement {
                DiskPlacement::DartThrowing => "Cook 1986; Gamito and Maddock 2009",
                DiskPlacement::Boundary => "Dunbar and Humphreys 2006",
                DiskPlacement::Decreasing => "McCool and Fiume 1992",
            },
        }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        let Self { mode, radius, placement } = *self;
        Ok(match placement {
            DiskPlacement::DartThrowing => {
                Box::new(PoissonDisk::new(n_points, domain, mode, radius)?)
            }
            DiskPlacement::Boundary => {
                Box::new(BoundaryPoissonDisk::new(n_points, domain, mode, radius)?)
            }
            DiskPlacement::Decreasing => {
                Box::new(DecreasingPoissonDisk::new(n_points, domain, mode, radius)?)
            }
        })
    }
}
