use std::path::{Path, PathBuf};
use std::sync::Arc;

use sphvar_grammar::{Declaration, Parametric, Range};

use crate::definition::{Definition, FileResolver};
use crate::{
    CostOrder, Domain, Error, PatternFacts, PowerProfile, ProfileTable, Rate, Sampler, SinglePeak,
    SpectralControl,
};

/// Parameters of the pattern [`SpectralControl::profile`].
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileParameters {
    /// The power at each degree.
    pub profile: PowerProfile,
    /// The minimum distance in units of the spacing of a hexagonal lattice.
    pub core: f64,
}

impl ProfileParameters {
    /// The default parameters.
    pub const DEFAULT: Self = Self { profile: PowerProfile::QUADRATIC, core: 0.0 };
}

impl Default for ProfileParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The meanings of the parameters of a profile.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ProfileWords {
    pub(crate) table: &'static str,
    pub(crate) edge: &'static str,
    pub(crate) single_peak: SinglePeak,
    pub(crate) exponent: &'static str,
    pub(crate) alpha: &'static str,
    pub(crate) offset: &'static str,
    pub(crate) to: &'static str,
}

const DEGREES: ProfileWords = ProfileWords {
    table: "table of l,power or of gamma,g instead of colour, edge or b to `to`",
    edge: "edge of single-peak blue noise instead of b to offset, l/sqrt(N)",
    single_peak: SinglePeak::DEFAULT,
    exponent: "exponent of l/sqrt(N)",
    alpha: "where the profile levels off, l/sqrt(N)",
    offset: "power at degree 0",
    to: "where the target ends, l/sqrt(N)",
};

/// Declares the parameters of a profile.
pub(crate) fn declare_profile(
    profile: &mut PowerProfile,
    words: ProfileWords,
    d: &mut Declaration<'_>,
) {
    let table = match &*profile {
        PowerProfile::Table { name, .. } | PowerProfile::PairCorrelation { name, .. } => {
            Some(PathBuf::from(&**name))
        }
        _ => None,
    };
    let mut file = table.clone();
    d.file("file", words.table, "none", &mut file);
    let is_table = file.is_some();
    if let Some(file) = file.filter(|file| Some(file) != table.as_ref()) {
        // The powers are read once all parameters are known.
        let name = file.to_string_lossy().into();
        *profile = PowerProfile::Table { name, power: [].into() };
    }
    if !is_table {
        let mut colour = match profile {
            PowerProfile::Colour(colour) => Some(*colour),
            _ => None,
        };
        let summary = "colour of noise instead of edge or b to `to`";
        d.optional_choice("colour", summary, "none", &mut colour);
        if let Some(colour) = colour {
            *profile = PowerProfile::Colour(colour);
        }
    }
    if !is_table && !matches!(profile, PowerProfile::Colour(_)) {
        let mut edge = match profile {
            PowerProfile::SinglePeak(profile) => Some(profile.edge),
            _ => None,
        };
        d.optional_number("edge", Range::POSITIVE, words.edge, "none", &mut edge);
        match (edge, &mut *profile) {
            (Some(edge), PowerProfile::SinglePeak(profile)) => profile.edge = edge,
            (Some(edge), _) => {
                *profile = PowerProfile::SinglePeak(SinglePeak { edge, ..words.single_peak });
            }
            (None, _) => (),
        }
    }
    match profile {
        PowerProfile::Polynomial { exponent, alpha, gamma, offset, to } => {
            d.number("b", Range::AT_LEAST_0, words.exponent, exponent);
            d.number("alpha", Range::POSITIVE, words.alpha, alpha);
            d.number("gamma", Range::AT_LEAST_0, "level above the offset", gamma);
            d.number("offset", Range::AT_LEAST_0, words.offset, offset);
            d.number("to", PowerProfile::TO_RANGE, words.to, to);
        }
        PowerProfile::SinglePeak(SinglePeak { peak, width, to, .. }) => {
            let summary = "integral of the peak at the edge";
            d.optional_number("peak", Range::AT_LEAST_0, summary, "by edge and width", peak);
            d.number("width", Range::POSITIVE, "width of edge and peak", width);
            d.number("to", PowerProfile::TO_RANGE, words.to, to);
        }
        _ => (),
    }
}

/// Reads the table that a profile names.
pub(crate) fn resolve_profile(
    profile: &mut PowerProfile,
    files: &dyn FileResolver,
) -> Result<(), Error> {
    if let PowerProfile::Table { name, power } = profile {
        match files.profile(Path::new(&**name))? {
            ProfileTable::Powers(read) => *power = read.into(),
            ProfileTable::PairCorrelation(g) => {
                *profile = PowerProfile::PairCorrelation { name: Arc::clone(name), g: g.into() };
            }
        }
    }
    Ok(())
}

impl Parametric for ProfileParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        declare_profile(&mut self.profile, DEGREES, d);
        let summary = "minimum distance in units of a hexagonal lattice's";
        d.number("core", SpectralControl::CORE_RANGE, summary, &mut self.core);
    }
}

impl Definition for ProfileParameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEARITHMIC,
            low_degrees: "as requested",
            smooth_rate: Rate::AsRequested,
            jump_rate: Rate::AsRequested,
            is_extensible: false,
            source: "this project",
        }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        let profile = SpectralControl::profile(n_points, domain, &self.profile)?;
        Ok(Box::new(profile.with_core(self.core)?))
    }

    fn resolve(&mut self, files: &dyn FileResolver) -> Result<(), Error> {
        resolve_profile(&mut self.profile, files)
    }
}
