//! Samplers of renders: uniform patterns of directions, and patterns of the square that are mapped to
//! densities.

use std::sync::Arc;

use glam::DQuat;
use sphvar_grammar::split_outside;
use sphvar_integrands::{Domain, Heuristic, WarpExpression, WarpFactor, WarpTerm};
use sphvar_samplers::{Pattern, SquarePattern};
use sphvar_scene::{Density, DirectionMode, LightMap};
use sphvar_variance::{Error, WarpedText};

use super::stage::Stage;
use crate::error::CliError;
use crate::integrands::strategies_of;
use crate::patterns::{SamplerName, check_square_pattern, parse_pattern, parse_patterns};
use crate::session::Session;
use crate::spec::Spec;

/// The densities of a render apart from those of every command, for help texts.
pub(super) const LIGHT_DENSITIES: &str = "light | triangles";

/// The sampler of the directions at each shading point.
#[derive(Clone, PartialEq)]
pub(super) enum RenderSampler {
    /// Uniform directions.
    Uniform(Pattern, DirectionMode),
    /// Directions of densities.
    Warped(Box<WarpedSampler>),
}

/// A pattern of the square with the densities to which it is mapped.
#[derive(Clone, PartialEq)]
pub(super) struct WarpedSampler {
    pub(super) pattern: SquarePattern,
    densities: Vec<(NamedDensity, f64)>,
    pub(super) heuristic: Heuristic,
    text: WarpedText,
}

/// A density as the user names it.
#[derive(Clone, PartialEq)]
enum NamedDensity {
    /// The solid angle of the light.
    Light(LightMap),
    /// A map about the normal.
    Surface(WarpExpression),
    /// An environment map; whether its own text orients its pole.
    World { map: WarpExpression, has_pole: bool },
}

impl RenderSampler {
    /// Reads a sampler; `mode` is that of uniform directions.
    pub(super) fn parse(
        text: &str,
        mode: DirectionMode,
        session: &Session,
    ) -> Result<Self, CliError> {
        if WarpedText::is_warped(text) {
            return Ok(Self::Warped(Box::new(WarpedSampler::parse(text, session)?)));
        }
        Ok(Self::Uniform(parse_pattern(text, session)?, mode))
    }

    /// Reads a list of samplers, in which uniform ones come first.
    pub(super) fn parse_list(
        text: &str,
        mode: DirectionMode,
        session: &Session,
    ) -> Result<Vec<Self>, CliError> {
        let texts = Spec::parse_list(text)?.into_iter().map(|spec| spec.text);
        let (warped, uniform): (Vec<_>, Vec<_>) = texts.partition(|t| WarpedText::is_warped(t));
        let mut samplers = Vec::new();
        // Together, so that the labels of files of the same name differ.
        if !uniform.is_empty() {
            let patterns = parse_patterns(&uniform.join(","), session)?;
            samplers.extend(patterns.into_iter().map(|pattern| Self::Uniform(pattern, mode)));
        }
        for text in warped {
            samplers.push(Self::parse(&text, mode, session)?);
        }
        Ok(samplers)
    }

    /// Returns whether directions have other densities than the uniform one.
    pub(super) fn is_warped(&self) -> bool {
        matches!(self, Self::Warped(_))
    }

    /// Returns the name in results.
    pub(super) fn name(&self) -> SamplerName {
        match self {
            Self::Uniform(pattern, _) => SamplerName::of(pattern),
            Self::Warped(sampler) => {
                let label = WarpedText { pattern: sampler.pattern.label(), ..sampler.text.clone() };
                SamplerName {
                    text: sampler.text.to_string(),
                    label: label.to_string(),
                    is_file: matches!(sampler.pattern, SquarePattern::PointFile(_)),
                }
            }
        }
    }

    /// Returns the mapping of sets to directions, for results.
    pub(super) fn mode(&self) -> &'static str {
        match self {
            Self::Uniform(_, mode) => mode.name(),
            Self::Warped(_) => "shifted",
        }
    }
}

impl WarpedSampler {
    fn parse(text: &str, session: &Session) -> Result<Self, CliError> {
        let parts: WarpedText = text.parse().map_err(CliError::usage)?;
        check_square_pattern(&parts.pattern)?;
        let pattern: SquarePattern = parse_pattern(&parts.pattern, session).map_err(|error| {
            let unquoted = |quoted| CliError::usage(Error::Unquoted { quoted });
            parts.quoted(text).map_or(error, unquoted)
        })?;
        let densities = densities(&parts.warp)?;
        if parts.heuristic.is_some() && densities.len() == 1 {
            return Err(CliError::Usage(format!(
                "{text}: heuristic= weights several densities, but warp= has one"
            )));
        }
        let text = WarpedText { pattern: pattern.to_string(), ..parts };
        let heuristic = text.heuristic.unwrap_or_default();
        Ok(Self { pattern, densities, heuristic, text })
    }

    /// Returns the text that every run accepts.
    pub(super) fn text(&self) -> String {
        self.text.to_string()
    }

    /// Returns the densities in the scene with their shares.
    pub(super) fn densities(
        &self,
        stage: &Stage,
        session: &Session,
    ) -> Result<Vec<(Density, f64)>, CliError> {
        let strategies = |warp: &WarpExpression, domain| {
            Ok::<_, CliError>(strategies_of(&[warp], domain, session)?.into_iter().flatten())
        };
        let mut densities = Vec::new();
        for (density, share) in &self.densities {
            match density {
                NamedDensity::Light(map) => {
                    let light = *stage.light().ok_or_else(|| {
                        CliError::Usage(format!(
                            "{}: the density of a light requires --integral light",
                            self.text
                        ))
                    })?;
                    densities.push((Density::Light { light, map: *map }, *share));
                }
                NamedDensity::Surface(warp) => {
                    let strategies = strategies(warp, Domain::Hemisphere)?;
                    densities.extend(strategies.map(|s| (Density::Surface(s.warp), *share)));
                }
                NamedDensity::World { map, has_pole } => {
                    let rotation =
                        if *has_pole { DQuat::IDENTITY } else { stage.rotation_of_map() };
                    let world = |warp: Arc<_>| Density::World { warp, rotation };
                    let strategies = strategies(map, Domain::Sphere)?;
                    densities.extend(strategies.map(|s| (world(s.warp), *share)));
                }
            }
        }
        Ok(densities)
    }
}

/// Reads a sum of densities with shares of the points: those of every command, and those of the
/// light.
fn densities(text: &str) -> Result<Vec<(NamedDensity, f64)>, CliError> {
    let summands = split_outside(text, " + ");
    let is_light = |summand: &str| light_map(summand).is_some();
    // Without a light, it is an expression of every command, with its errors.
    if !summands.iter().any(|summand| is_light(product(summand).0.trim())) {
        let warp: WarpExpression = text.parse().map_err(CliError::usage)?;
        let shares = warp.shares();
        let named = summands.iter().zip(shares);
        return named
            .map(|(summand, share)| Ok((named_density(product(summand).0)?, share)))
            .collect();
    }
    let shares: Vec<Option<f64>> = summands.iter().map(|summand| product(summand).1).collect();
    let stated = shares.iter().flatten().count();
    let wrong = |reason: &str| CliError::Usage(format!("{text}: {reason}"));
    if summands.len() == 1 && stated > 0 {
        return Err(wrong("a single warp samples all points; remove the number"));
    }
    if stated != 0 && stated < summands.len() {
        return Err(wrong("give every warp a share of the points, or none"));
    }
    if let Some(share) = shares.iter().flatten().find(|share| !(**share > 0.0 && share.is_finite()))
    {
        return Err(wrong(&format!(
            "a share of the points must be a positive number, got {share}"
        )));
    }
    let named = summands.iter().zip(shares);
    named.map(|(s, share)| Ok((named_density(product(s).0)?, share.unwrap_or(1.0)))).collect()
}

/// Returns a product without the number in front, and that number.
fn product(summand: &str) -> (&str, Option<f64>) {
    match summand.split_once(" * ") {
        Some((number, rest)) => match number.trim().parse() {
            Ok(number) => (rest, Some(number)),
            Err(_) => (summand, None),
        },
        None => (summand, None),
    }
}

fn light_map(name: &str) -> Option<LightMap> {
    match name {
        "light" => Some(LightMap::Automatic),
        "triangles" => Some(LightMap::Triangles),
        _ => None,
    }
}

/// Reads one density.
fn named_density(text: &str) -> Result<NamedDensity, CliError> {
    let text = text.trim();
    if let Some(map) = light_map(text) {
        return Ok(NamedDensity::Light(map));
    }
    let warp: WarpExpression = text.parse().map_err(CliError::usage)?;
    let factors = split_outside(text, " * ");
    if factors.len() > 1 {
        return Err(CliError::Usage(format!(
            "{text}: the cosine is about the pole of the map, but each surface has its own normal; use a \
             sum of both densities: \"{}\"",
            factors.join(" + ")
        )));
    }
    let factor: WarpFactor = text.parse().map_err(CliError::usage)?;
    Ok(match factor.term {
        WarpTerm::Environment(map) => {
            NamedDensity::World { map: warp, has_pole: map.environment.picture.up.is_some() }
        }
        _ => NamedDensity::Surface(warp),
    })
}
