use sphvar_grammar::{Declaration, Parametric, Range};

use super::{DiskMode, PoissonDisk};
use crate::definition::Definition;
use crate::{CostOrder, Domain, Error, PatternFacts, Rate, Sampler};

/// Parameters of the pattern [`PoissonDisk`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoissonDiskParameters {
    /// The criterion by which a set is complete.
    pub mode: DiskMode,
    /// The minimum chord times sqrt(N), or [`PoissonDisk::default_radius`].
    pub radius: Option<f64>,
}

impl PoissonDiskParameters {
    /// The default parameters.
    pub const DEFAULT: Self = Self { mode: DiskMode::Exact, radius: None };
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
    }
}

impl Definition for PoissonDiskParameters {
    fn facts(&self) -> PatternFacts {
        let low_degrees = match self.mode {
            DiskMode::Exact => "0.0596",
            DiskMode::Saturated => "0.0578",
        };
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees,
            smooth_rate: Rate::power(-1.0),
            jump_rate: Rate::power(-1.0),
            is_extensible: false,
            source: "Cook 1986; Gamito and Maddock 2009",
        }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        Ok(Box::new(PoissonDisk::new(n_points, domain, self.mode, self.radius)?))
    }
}
