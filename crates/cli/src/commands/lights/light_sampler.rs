use std::fmt;

use sphvar_integrands::{Heuristic, Strategy};
use sphvar_samplers::{
    AdaptedCcvt, Domain, Ensemble, Pattern, PointSet, Progress, Purpose, Realizations, Sampler,
    Square, SquarePattern, SquareSampler, Streams,
};
use sphvar_scene::{DirectionalLight, RgbEnvironment};
use sphvar_variance::{AdaptedPattern, WarpedPattern, WarpedRealizations, WarpedText};

use crate::error::CliError;
use crate::integrands::strategies_of;
use crate::memory::check_points;
use crate::patterns::{DirectionSampler, PatternKind, build, parse_pattern, parse_sampler};
use crate::session::Session;
use crate::spec::{Spec, unknown_name};

/// The name of the density of the map in specifications.
const LUMINANCE: &str = "luminance";
/// The name of the algorithm of Debevec.
const MEDIAN_CUT: &str = "median-cut";
/// The name of the pattern that has `density`.
const CCVT: &str = "ccvt";
/// The default capacity of cells of equal luminance; 256 reduces errors by a tenth and takes four to
/// six times as long.
const DEFAULT_CAPACITY: usize = AdaptedPattern::DEFAULT_CAPACITY;

/// A way to choose lights.
pub(super) enum LightSampler {
    MedianCut,
    Cells {
        capacity: usize,
    },
    Uniform(Pattern),
    /// A pattern mapped to the luminance of the map.
    Luminance {
        text: WarpedText,
        pattern: SquarePattern,
    },
    /// A pattern mapped to other densities.
    Warped {
        pattern: WarpedPattern,
        strategies: Vec<Strategy>,
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
    pub(super) fn parse_list(text: &str, session: &Session) -> Result<Vec<Self>, CliError> {
        let specs = Spec::parse_list(text)?;
        specs.into_iter().map(|spec| Self::parse(spec, session)).collect()
    }

    fn parse(mut spec: Spec, session: &Session) -> Result<Self, CliError> {
        if spec.name == MEDIAN_CUT {
            spec.finish(&[])?;
            return Ok(Self::MedianCut);
        }
        if WarpedText::is_warped(&spec.text) {
            return Self::parse_warped(&spec.text, session);
        }
        let density = if spec.name == CCVT { spec.take("density") } else { None };
        let Some(density) = density else {
            check_name(&spec.name)?;
            return Ok(Self::Uniform(parse_pattern(&spec.text, session)?));
        };
        if density != LUMINANCE {
            return Err(unknown_name("density", &density, &[LUMINANCE]));
        }
        let mut capacity = DEFAULT_CAPACITY;
        spec.replace_number("capacity", &mut capacity)?;
        spec.finish(&["density", "capacity"])?;
        Ok(Self::Cells { capacity })
    }

    fn parse_warped(text: &str, session: &Session) -> Result<Self, CliError> {
        let parts: WarpedText = text.parse().map_err(CliError::usage)?;
        if parts.warp == LUMINANCE && parts.heuristic.is_none() {
            let pattern = parse_pattern(&parts.pattern, session)?;
            return Ok(Self::Luminance { text: parts, pattern });
        }
        let names_luminance = parts.warp.split([' ', ',']).any(|word| word == LUMINANCE);
        if names_luminance {
            return Err(CliError::Usage(format!(
                "{text}: {LUMINANCE} is a density by itself only; name the map in expressions, as in \
                 \"0.9 * env:FILE + 0.1 * cylinder\""
            )));
        }
        Ok(match parse_sampler(text, session)? {
            DirectionSampler::Uniform(pattern) => Self::Uniform(pattern),
            DirectionSampler::Adapted(pattern) => {
                let own = format!("{CCVT}:density={LUMINANCE}");
                return Err(CliError::Usage(format!("{pattern}: lights has {own} only")));
            }
            DirectionSampler::Warped(pattern) => {
                let strategies = strategies_of(&[&pattern.warp], Domain::Sphere, session)?;
                Self::Warped { pattern, strategies: strategies.concat() }
            }
        })
    }

    /// Returns the source of `n` lights.
    pub(super) fn source<'a>(
        &self,
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
            Self::Uniform(pattern) => Method::Uniform(build(pattern, n, Domain::Sphere, nearest)?),
            Self::Luminance { pattern, .. } => Method::Warped {
                samplers: vec![build(pattern, n, Square, nearest)?],
                strategies: vec![Strategy { warp: environment.luminance_warp(), share: 1.0 }],
                heuristic: Heuristic::default(),
            },
            Self::Warped { pattern, strategies } => {
                let valid = pattern.nearest_count(n);
                if valid != n && !nearest {
                    return Err(CliError::Usage(format!(
                        "{pattern}: {n} points are not valid; the nearest valid count is {valid} (use --nearest)"
                    )));
                }
                environment
                    .check_support(strategies)
                    .map_err(|e| CliError::Failed(format!("{pattern}: {e}")))?;
                Method::Warped {
                    samplers: pattern.samplers(valid).map_err(CliError::usage)?,
                    strategies: strategies.clone(),
                    heuristic: pattern.heuristic,
                }
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
            Self::Uniform(pattern) => pattern.fmt(f),
            Self::Luminance { text, .. } => text.fmt(f),
            Self::Warped { pattern, .. } => pattern.fmt(f),
        }
    }
}

/// The realizations of the lights of a sampler.
pub(super) struct LightSource<'a> {
    method: Method,
    setting: Setting<'a>,
}

enum Method {
    MedianCut(usize),
    Cells(AdaptedCcvt),
    Uniform(Box<dyn Sampler>),
    Warped {
        samplers: Vec<Box<dyn SquareSampler>>,
        strategies: Vec<Strategy>,
        heuristic: Heuristic,
    },
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
            Method::Uniform(sampler) => sampler.nominal_work(),
            Method::Warped { samplers, .. } => samplers.iter().map(|s| s.nominal_work()).sum(),
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
        let realized = |sets: &dyn Ensemble| -> Result<PointSet, CliError> {
            let mut set = PointSet::default();
            sets.realize_into(index, &mut set, progress).map_err(CliError::failed)?;
            Ok(set)
        };
        match &self.method {
            Method::MedianCut(n) => environment.median_cut(*n).map_err(CliError::failed),
            Method::Cells(ccvt) => {
                let mut rng = streams(ccvt.n_points()).realization(index);
                let cells = ccvt.tessellate(&mut rng, progress).map_err(CliError::failed)?;
                Ok(environment.cell_lights(&cells))
            }
            Method::Uniform(sampler) => {
                let sets = Realizations::rotated(&**sampler, streams(sampler.stream_group()));
                Ok(environment.uniform_lights(&realized(&sets)?))
            }
            Method::Warped { samplers, strategies, heuristic } => {
                let purpose = Purpose::Pattern;
                let sets = WarpedRealizations::new(strategies, *heuristic, samplers, seed, purpose);
                let set = realized(&sets)?;
                Ok(environment.lights(&set.points, &set.weights))
            }
        }
    }
}
