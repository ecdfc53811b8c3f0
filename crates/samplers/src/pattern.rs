use std::fmt;
use std::str::FromStr;

use sphvar_grammar::{Parameter, Spec, describe, read, text};

#[cfg(doc)]
use crate::PointFileParameters;
use crate::definition::WithoutFiles;
use crate::hash::fnv1a;
use crate::of_pattern::OfPattern;
use crate::{
    Domain, Error, FibonacciParameters, FileResolver, Pattern, PatternFacts, Sampler, ValidCounts,
};

impl Pattern {
    /// The spherical Fibonacci lattice with its default offset.
    pub const FIBONACCI: Self = Self::Fibonacci(FibonacciParameters::DEFAULT);

    /// The patterns without parameters whose realizations are inexpensive: the default of a
    /// comparison.
    pub const ELEMENTARY: [Self; 4] =
        [Self::WhiteNoise, Self::Jittered, Self::Healpix, Self::FIBONACCI];

    /// Reads `name` or `name:key=value,key=value`; `files` reads the files that the text names.
    ///
    /// ```
    /// use sphvar_samplers::{DiskMode, Pattern, PoissonDiskParameters};
    /// let disks: Pattern = "poisson-disk:radius=2,mode=saturated".parse()?;
    /// let parameters = PoissonDiskParameters { mode: DiskMode::Saturated, radius: Some(2.0) };
    /// assert_eq!(disks, Pattern::PoissonDisk(parameters));
    /// assert_eq!(disks.to_string(), "poisson-disk:mode=saturated,radius=2");
    /// let wrong = "riesz:s=5".parse::<Pattern>().unwrap_err();
    /// assert_eq!(wrong.to_string(), "riesz:s=5: s must be in [0, 4], got 5");
    /// # Ok::<(), sphvar_samplers::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Grammar`] with place, reason and valid values; [`Error::File`] if `files` cannot
    /// read a file.
    pub fn parse(text: &str, files: &dyn FileResolver) -> Result<Self, Error> {
        let spec = Spec::parse(text)?;
        let mut pattern =
            Self::known().find(|pattern| pattern.name() == spec.name).ok_or_else(|| {
                let names: Vec<&str> = Self::known().map(|pattern| pattern.name()).collect();
                sphvar_grammar::Error::unknown_name("sampler", &spec.name, &names)
            })?;
        pattern.with_definition(|definition| {
            read(definition, spec)?;
            definition.resolve(files)
        })?;
        Ok(pattern)
    }

    /// Returns every pattern that can be parsed: [`Self::ALL`], and with empty parameters those
    /// that need a file.
    pub fn known() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().chain(Self::WITHOUT_DEFAULT)
    }

    /// Returns the name in tables and plots: the text of the pattern, for point files with the name
    /// of the file instead of its path unless [`PointFileParameters::has_long_label`] is set.
    #[must_use]
    pub fn label(&self) -> String {
        match self {
            Self::PointFile(file) => Self::PointFile(file.shortened()).to_string(),
            _ => self.to_string(),
        }
    }

    /// Returns the number of points of a pattern that has only one, because it is a single point
    /// file.
    #[must_use]
    pub fn own_count(&self) -> Option<usize> {
        match self {
            Self::PointFile(file) => file.own_count(),
            _ => None,
        }
    }

    /// Returns the parameters with their ranges, meanings and defaults, in the order of the text
    /// form.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        self.default_of_name().with_definition(|definition| describe(definition))
    }

    /// Returns the known properties of the pattern with its parameters.
    #[must_use]
    pub fn facts(&self) -> PatternFacts {
        self.clone().with_definition(|definition| definition.facts())
    }

    /// Returns whether all sets of the same number of points are identical up to rotation.
    #[must_use]
    pub fn is_deterministic(&self) -> bool {
        // A single point is the same set for every pattern; this number distinguishes patterns.
        const N_POINTS: usize = 12;
        let n_points = self.nearest_count(N_POINTS, Domain::Sphere);
        self.build(n_points, Domain::Sphere).is_ok_and(|sampler| !sampler.is_random())
    }

    /// Returns a number for [`Streams::new`](crate::Streams::new) that distinguishes the ensembles
    /// of one run: the number of points combined with a hash of the pattern's text (32-bit FNV-1a),
    /// or for a point file a hash of its content.
    #[must_use]
    pub fn stream_group(&self, n_points: usize) -> usize {
        let own = self.clone().with_definition(|definition| definition.stream_group(n_points));
        own.unwrap_or_else(|| fnv1a(self.to_string().as_bytes()) as usize ^ n_points)
    }

    /// Returns the valid numbers of points on `domain`.
    #[must_use]
    pub fn valid_counts(&self, domain: Domain) -> ValidCounts {
        self.clone().with_definition(|definition| definition.valid_counts(domain))
    }

    /// Returns the valid number of points nearest to `requested`, the smaller one of two equally near;
    /// never 0.
    #[must_use]
    pub fn nearest_count(&self, requested: usize, domain: Domain) -> usize {
        self.valid_counts(domain).nearest(requested)
    }

    /// Returns the sampler of this pattern with exactly `n_points` points; saturated Poisson disks
    /// have that number on average.
    ///
    /// ```
    /// use sphvar_samplers::{Domain, Error, Pattern};
    /// assert_eq!(Pattern::Jittered.build(972, Domain::Sphere)?.n_points(), 972);
    /// let rejected = Pattern::Jittered.build(1024, Domain::Sphere).unwrap_err();
    /// assert!(matches!(rejected, Error::InvalidCount { nearest: 972, .. }));
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::NoPoints`] for 0 points, [`Error::InvalidCount`] with the nearest valid number
    /// if the pattern does not exist with `n_points`, [`Error::TooManyPoints`] or
    /// [`Error::Parameter`] beyond the range of its indices and of its parameters,
    /// [`Error::Infeasible`] if it cannot exist.
    pub fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        if n_points == 0 {
            return Err(Error::NoPoints { pattern: self.to_string() });
        }
        let rule = self.valid_counts(domain);
        let nearest = rule.nearest(n_points);
        if nearest != n_points {
            let (pattern, requested) = (self.to_string(), n_points);
            return Err(Error::InvalidCount { pattern, domain, requested, nearest, rule });
        }
        let sampler =
            self.clone().with_definition(|definition| definition.build(n_points, domain))?;
        Ok(Box::new(OfPattern::new(sampler, self.stream_group(n_points))))
    }

    /// Returns [`Sampler::last_empty_degree`] of the sampler of `n_points` points; `None` if there
    /// is none.
    #[must_use]
    pub fn last_empty_degree(&self, n_points: usize, domain: Domain) -> Option<usize> {
        self.build(n_points, domain).ok()?.last_empty_degree()
    }

    /// Returns [`Sampler::nominal_work`] of the sampler of `n_points` points, or of the nearest
    /// valid count; one unit per point if the pattern cannot be built.
    #[must_use]
    pub fn nominal_work(&self, n_points: usize) -> f64 {
        let sampler = self.build(self.nearest_count(n_points, Domain::Sphere), Domain::Sphere);
        sampler.map_or(n_points as f64, |sampler| sampler.nominal_work())
    }

    /// Returns the pattern of the same name with its default parameters.
    fn default_of_name(&self) -> Self {
        let name = self.name();
        Self::known().find(|pattern| pattern.name() == name).unwrap_or(Self::WhiteNoise)
    }
}

/// Reads `name` or `name:key=value,key=value`; texts that name files need [`Pattern::parse`].
impl FromStr for Pattern {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        Self::parse(text, &WithoutFiles)
    }
}

/// Writes the name and, after a colon, the parameters that differ from the defaults.
impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut default = self.default_of_name();
        let text = self.clone().with_definition(|definition| {
            default.with_definition(|default| text(self.name(), definition, default))
        });
        f.pad(&text)
    }
}
