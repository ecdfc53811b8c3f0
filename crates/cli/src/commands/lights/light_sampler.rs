use std::fmt;

use sphvar_integrands::Strategy;
use sphvar_samplers::{
    AdaptedCcvt, Domain, Pattern, PointSet, Progress, Purpose, Realizations, Sampler, Square,
    SquarePattern, SquareRealizations, SquareSampler, Streams,
};
use sphvar_scene::{DirectionalLight, RgbEnvironment};
use sphvar_variance::WarpedText;

use crate::error::CliError;
use crate::integrands::parse_warp;
use crate::memory::check_points;
use crate::patterns::{PatternKind, build, parse_pattern};
use crate::spec::{Spec, unknown_name};

/// The name of the density of the map in specifications.
const LUMINANCE: &str = "luminance";
/// The name of the algorithm of Debevec.
const MEDIAN_CUT: &str = "median-cut";
/// The name of the pattern that has `density`.
const CCVT: &str = "ccvt";
/// The default capacity of cells of equal luminance; 256 reduces errors by a tenth and takes four to
/// six times as long.
const DEFAULT_CAPACITY: usize = 64;

/// A way to choose lights.
pub(super) enum LightSampler {
    MedianCut,
    Cells {
        capacity: usize,
    },
    Directions(Pattern),
    Warped {
        text: WarpedText,
        pattern: SquarePattern,
        /// The density, if it is not the luminance of the map.
        density: Option<Strategy>,
    },
}

/// The map, and how samplers choose lights from it.
#[derive(Clone, Copy)]
pub(super) struct Setting<'a> {
    pub(super) environment: &'a RgbEnvironment,
    /// Whether the valid count nearest to N is used.
    pub(super) nearest: bool,
    pub(super) seed: u64,
}

impl LightSampler {
    pub(super) fn parse_list(text: &str, quiet: bool) -> Result<Vec<Self>, CliError> {
        let specs = Spec::parse_list(text)?;
        specs.into_iter().map(|spec| Self::parse(spec, quiet)).collect()
    }

    fn parse(mut spec: Spec, quiet: bool) -> Result<Self, CliError> {
        if spec.name == MEDIAN_CUT {
            spec.finish(&[])?;
            return Ok(Self::MedianCut);
        }
        if WarpedText::is_warped(&spec.text) {
            let text: WarpedText = spec.text.parse().map_err(CliError::usage)?;
            let pattern = parse_pattern(&text.pattern, quiet)?;
            let density = match &*text.warp {
                LUMINANCE => None,
                warp => Some(parse_warp(warp, Domain::Sphere, quiet)?),
            };
            return Ok(Self::Warped { text, pattern, density });
        }
        let density = if spec.name == CCVT { spec.take("density") } else { None };
        let Some(density) = density else {
            check_name(&spec.name)?;
            return Ok(Self::Directions(parse_pattern(&spec.text, quiet)?));
        };
        if density != LUMINANCE {
            return Err(unknown_name("density", &density, &[LUMINANCE]));
        }
        let mut capacity = DEFAULT_CAPACITY;
        spec.replace_number("capacity", &mut capacity)?;
        spec.finish(&["density", "capacity"])?;
        Ok(Self::Cells { capacity })
    }

    /// Returns the source of `n` lights.
    pub(super) fn source<'a>(
        &'a self,
        n: usize,
        setting: Setting<'a>,
    ) -> Result<LightSource<'a>, CliError> {
        check_points(n)?;
        let Setting { environment, nearest, .. } = setting;
        let method = match self {
            Self::MedianCut => Method::MedianCut(n),
            &Self::Cells { capacity } => {
                let ccvt = AdaptedCcvt::new(n, capacity, environment.luminance_warp());
                Method::Cells(ccvt.map_err(CliError::usage)?)
            }
            Self::Directions(pattern) => {
                Method::Directions(build(pattern, n, Domain::Sphere, nearest)?)
            }
            Self::Warped { pattern, density, .. } => {
                Method::Warped(build(pattern, n, Square, nearest)?, density.as_ref())
            }
        };
        Ok(LightSource { method, setting })
    }
}

/// Rejects names that are none of a pattern of directions.
fn check_name(name: &str) -> Result<(), CliError> {
    if Pattern::is_name(name) {
        return Ok(());
    }
    if SquarePattern::is_name(name) {
        return Err(CliError::Usage(format!(
            "{name} is a pattern of the unit square: {name}:warp={LUMINANCE} maps it to directions"
        )));
    }
    let known = Pattern::known();
    let names: Vec<&str> = [MEDIAN_CUT].into_iter().chain(known.map(|p| p.name())).collect();
    Err(unknown_name("sampler", name, &names))
}

/// Writes the form that is read.
impl fmt::Display for LightSampler {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::MedianCut => f.write_str(MEDIAN_CUT),
            Self::Cells { capacity: DEFAULT_CAPACITY } => write!(f, "{CCVT}:density={LUMINANCE}"),
            Self::Cells { capacity } => {
                write!(f, "{CCVT}:density={LUMINANCE},capacity={capacity}")
            }
            Self::Directions(pattern) => pattern.fmt(f),
            Self::Warped { text, .. } => text.fmt(f),
        }
    }
}

/// The realizations of the lights of a sampler.
pub(super) struct LightSource<'a> {
    method: Method<'a>,
    setting: Setting<'a>,
}

enum Method<'a> {
    MedianCut(usize),
    Cells(AdaptedCcvt),
    Directions(Box<dyn Sampler>),
    Warped(Box<dyn SquareSampler>, Option<&'a Strategy>),
}

impl LightSource<'_> {
    /// Returns whether realizations differ.
    pub(super) fn is_random(&self) -> bool {
        !matches!(self.method, Method::MedianCut(_))
    }

    /// Returns the nominal work of a realization.
    pub(super) fn nominal_work(&self) -> f64 {
        match &self.method {
            Method::MedianCut(n) => *n as f64,
            Method::Cells(ccvt) => ccvt.nominal_work(),
            Method::Directions(sampler) => sampler.nominal_work(),
            Method::Warped(sampler, _) => sampler.nominal_work(),
        }
    }

    /// Returns the lights of a realization.
    pub(super) fn lights(
        &self,
        index: u64,
        progress: &dyn Progress,
    ) -> Result<Vec<DirectionalLight>, CliError> {
        let Setting { environment, seed, .. } = self.setting;
        let streams = |group| Streams::new(seed, Purpose::Pattern, group);
        match &self.method {
            Method::MedianCut(n) => environment.median_cut(*n).map_err(CliError::failed),
            Method::Cells(ccvt) => {
                let mut rng = streams(ccvt.n_points()).realization(index);
                let cells = ccvt.tessellate(&mut rng, progress).map_err(CliError::failed)?;
                Ok(environment.cell_lights(&cells))
            }
            Method::Directions(sampler) => {
                let sets = Realizations::rotated(&**sampler, streams(sampler.stream_group()));
                let mut set = PointSet::default();
                sets.realize_into(index, &mut set, progress).map_err(CliError::failed)?;
                Ok(environment.uniform_lights(&set))
            }
            Method::Warped(sampler, density) => {
                let sets = SquareRealizations::shifted(&**sampler, streams(sampler.stream_group()));
                let mut set = PointSet::default();
                sets.realize_into(index, &mut set, progress).map_err(CliError::failed)?;
                let warp = density
                    .map_or_else(|| environment.luminance_warp(), |density| density.warp.clone());
                Ok(environment.warped_lights(&set, &*warp))
            }
        }
    }
}
