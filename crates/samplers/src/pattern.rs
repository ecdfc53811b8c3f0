#[cfg(doc)]
use crate::PointFileParameters;
use crate::pattern_list::PatternList;
use crate::{Domain, Error, FibonacciParameters, FileResolver, Pattern, Sampler, ValidCounts};

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
    /// let parameters = PoissonDiskParameters {
    ///     mode: DiskMode::Saturated,
    ///     radius: Some(2.0),
    ///     ..PoissonDiskParameters::DEFAULT
    /// };
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
        Self::read(text, files)
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

    /// Returns whether all sets of the same number of points are identical up to rotation.
    #[must_use]
    pub fn is_deterministic(&self) -> bool {
        // A single point is the same set for every pattern; this number distinguishes patterns.
        const N_POINTS: usize = 12;
        let n_points = self.nearest_count(N_POINTS, Domain::Sphere);
        self.build(n_points, Domain::Sphere).is_ok_and(|sampler| !sampler.is_random())
    }

    /// Returns the number of points where none is requested: that of a single point file, or the
    /// smallest of a design of given degree; `None` for other patterns.
    #[must_use]
    pub fn default_count(&self, domain: Domain) -> Option<usize> {
        let by_parameters = self.clone().with_definition(|d| d.default_count(domain));
        self.own_count().or(by_parameters)
    }

    /// Returns the valid numbers of points on `domain`.
    #[must_use]
    pub fn valid_counts(&self, domain: Domain) -> ValidCounts {
        self.counts_in(domain)
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
        self.build_in(n_points, domain)
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
}
