//! Patterns of the sphere that are patterns of the square, mapped to directions.

use std::marker::PhantomData;

use sphvar_grammar::{Choice, Declaration, Parametric};

use crate::definition::Definition;
use crate::{
    Domain, Error, PatternFacts, Sampler, ScrambledPattern, Scrambling, Shifted, SphereMap,
};

/// The randomization of a pattern of the square before it is mapped to directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Randomization {
    /// The pattern of the definition, always the same.
    None,
    /// A uniform random shift modulo 1 (Cranley and Patterson 1976).
    Shift,
    /// A random digital shift, [`Scrambling::Digital`].
    Digital,
    /// Nested uniform scrambling, [`Scrambling::Owen`].
    Owen,
}

impl Choice for Randomization {
    const CHOICES: &'static [(&'static str, Self)] = &[
        ("none", Self::None),
        ("shift", Self::Shift),
        ("digital", Self::Digital),
        ("owen", Self::Owen),
    ];
}

/// A [`ScrambledPattern`] that is a pattern of the sphere.
pub trait MappedPattern: ScrambledPattern {
    /// The randomization unless another is requested.
    const RANDOMIZATION: Randomization;

    /// Returns the known properties of the pattern of the sphere.
    fn facts_on_sphere(randomization: Randomization, map: SphereMap) -> PatternFacts;
}

/// Parameters of a [`MappedPattern`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MappedParameters<P> {
    /// The randomization on the square.
    pub randomization: Randomization,
    /// The map to directions.
    pub map: SphereMap,
    pattern: PhantomData<P>,
}

impl<P: MappedPattern> MappedParameters<P> {
    /// The default parameters.
    pub const DEFAULT: Self = Self::new(P::RANDOMIZATION, SphereMap::Cylinder);

    /// Returns the parameters with a randomization and a map.
    #[must_use]
    pub const fn new(randomization: Randomization, map: SphereMap) -> Self {
        Self { randomization, map, pattern: PhantomData }
    }
}

impl<P: MappedPattern> Default for MappedParameters<P> {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl<P: MappedPattern> Parametric for MappedParameters<P> {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let summary = "randomization on the square, before any rotation";
        d.choice("randomization", summary, &mut self.randomization);
        declare_map(d, &mut self.map);
    }
}

impl<P: MappedPattern> Definition for MappedParameters<P> {
    fn facts(&self) -> PatternFacts {
        P::facts_on_sphere(self.randomization, self.map)
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        let scrambled =
            |scrambling| self.map.build(n_points, domain, |n| P::scrambled(n, scrambling));
        match self.randomization {
            Randomization::None => scrambled(Scrambling::None),
            Randomization::Digital => scrambled(Scrambling::Digital),
            Randomization::Owen => scrambled(Scrambling::Owen),
            Randomization::Shift => self
                .map
                .build(n_points, domain, |n| Ok(Shifted::new(P::scrambled(n, Scrambling::None)?))),
        }
    }
}

/// Declares the map of a pattern of the square to directions.
pub(super) fn declare_map(d: &mut Declaration<'_>, map: &mut SphereMap) {
    d.choice("map", "map from the square, or from a square for each face of HEALPix", map);
}
