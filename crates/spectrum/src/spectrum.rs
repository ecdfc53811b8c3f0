use sphvar_sh::{Bands, Domain, TailClasses};

use crate::error::check_equal;
use crate::{Accumulator, ClassMoments, Error, Moments, Realization, SpectralBands};

/// Mean power per band of an ensemble, with its standard error. The bands of the sphere are the
/// degrees.
///
/// `P(l) = (4 pi / N) 1/(2l+1) sum_m |sum_k conj Y_lm(s_k)|^2`: white noise has P(l) = 1 for
/// l >= 1, and every set has P(0) = N. On the hemisphere only even degrees
/// exist; entries of odd degrees are 0 and have no meaning.
///
/// For weighted points, N is the effective number `(sum w)^2/sum w^2`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(
        try_from = "Fields<B>",
        bound(
            serialize = "B: serde::Serialize",
            deserialize = "B: Bands + serde::Deserialize<'de>"
        )
    )
)]
pub struct Spectrum<B: Bands = Domain> {
    bands: B,
    n_points: usize,
    n_effective: f64,
    realizations: u64,
    power: Vec<f64>,
    stderr: Vec<f64>,
    #[cfg_attr(feature = "serde", serde(serialize_with = "crate::class_values::serialize"))]
    tail: B::Tail,
    #[cfg_attr(feature = "serde", serde(serialize_with = "crate::class_values::serialize"))]
    tail_stderr: B::Tail,
}

/// Deserialized fields of a [`Spectrum`] before validation.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
#[serde(bound(deserialize = "B: Bands + serde::Deserialize<'de>"))]
struct Fields<B: Bands> {
    bands: B,
    n_points: usize,
    n_effective: f64,
    realizations: u64,
    power: Vec<f64>,
    stderr: Vec<f64>,
    #[serde(deserialize_with = "crate::class_values::deserialize")]
    tail: B::Tail,
    #[serde(deserialize_with = "crate::class_values::deserialize")]
    tail_stderr: B::Tail,
}

#[cfg(feature = "serde")]
impl<B: Bands> TryFrom<Fields<B>> for Spectrum<B> {
    type Error = &'static str;

    fn try_from(fields: Fields<B>) -> Result<Self, Self::Error> {
        let Fields { bands, n_points, n_effective, realizations, power, stderr, tail, tail_stderr } =
            fields;
        if power.is_empty() || power.len() != stderr.len() {
            return Err("a spectrum without power or with another number of errors");
        }
        Ok(Self { bands, n_points, n_effective, realizations, power, stderr, tail, tail_stderr })
    }
}

impl<B: Bands> Spectrum<B> {
    /// Returns a spectrum known in closed form: no realizations, standard errors of 0.
    ///
    /// `power` is indexed by band, starting at 0. The first entry is replaced by N, the power of
    /// band 0 of every set, and entries of bands that do not exist by 0. The [`tail`](Self::tail)
    /// is that of points in general position, 1.
    ///
    /// # Panics
    ///
    /// Panics if `power` is empty.
    #[must_use]
    pub fn exact(bands: B, n_points: usize, mut power: Vec<f64>) -> Self {
        assert!(!power.is_empty(), "power must have at least one entry, that of band 0");
        power[0] = n_points as f64;
        for (band, p) in power.iter_mut().enumerate() {
            if !bands.has_band(band) {
                *p = 0.0;
            }
        }
        let stderr = vec![0.0; power.len()];
        let tail_stderr = B::Tail::all(0.0);
        let spectrum = Self {
            bands,
            n_points,
            n_effective: n_points as f64,
            realizations: 0,
            power,
            stderr,
            tail: tail_stderr,
            tail_stderr,
        };
        spectrum.with_tail(B::Tail::all(1.0))
    }

    /// Returns the same spectrum with another mean power beyond its last band, known without error.
    #[must_use]
    pub fn with_tail(mut self, tail: B::Tail) -> Self {
        self.tail = existing(&self.bands, tail);
        self.tail_stderr = B::Tail::all(0.0);
        self
    }

    /// Returns the mean power beyond the bands of the spectrum by class (on the sphere, of even and
    /// of odd degrees): the limit of the average over bands. On the sphere it is 1 unless points
    /// coincide or are antipodal, see [`tail_power`](crate::tail_power).
    ///
    /// On the hemisphere the value of odd degrees is 0 and has no meaning.
    #[must_use]
    pub fn tail(&self) -> B::Tail {
        self.tail
    }

    /// Returns the standard error of the [`tail`](Self::tail).
    #[must_use]
    pub fn tail_stderr(&self) -> B::Tail {
        self.tail_stderr
    }

    /// Returns whether the power of every band is known without error.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        self.stderr.iter().all(|&e| e == 0.0)
    }

    /// Returns the same spectrum for weighted points with this effective number, which also becomes
    /// the power of band 0.
    #[must_use]
    pub fn with_n_effective(mut self, n_effective: f64) -> Self {
        self.n_effective = n_effective;
        self.power[0] = n_effective;
        self
    }

    /// Returns the bands of the spectrum, starting at band 0.
    #[must_use]
    pub fn bands(&self) -> &B {
        &self.bands
    }

    /// Returns the number of points of a realization.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.n_points
    }

    /// Returns the mean effective number of points, `(sum w)^2/sum w^2`; for equal weights, the
    /// mean number of points.
    #[must_use]
    pub fn n_effective(&self) -> f64 {
        self.n_effective
    }

    /// Returns the number of realizations averaged; 0 for a spectrum in closed form.
    #[must_use]
    pub fn realizations(&self) -> u64 {
        self.realizations
    }

    /// Returns the last band, inclusive; on the sphere, the maximum degree.
    #[must_use]
    pub fn lmax(&self) -> usize {
        self.power.len() - 1
    }

    /// Returns the mean power, indexed by band from 0.
    #[must_use]
    pub fn power(&self) -> &[f64] {
        &self.power
    }

    /// Returns the standard error of the mean power, indexed by band from 0: 0 where the power is
    /// known exactly, NaN where a single realization does not determine it.
    #[must_use]
    pub fn stderr(&self) -> &[f64] {
        &self.stderr
    }

    /// Returns the same spectrum with standard errors of 0.
    ///
    /// Use it for a deterministic pattern, of which every realization has the same power, and for a
    /// point set that is studied for its own sake.
    #[must_use]
    pub fn into_exact(mut self) -> Self {
        self.stderr.fill(0.0);
        self.tail_stderr = B::Tail::all(0.0);
        self
    }

    /// Returns the same spectrum with powers that are rounding errors replaced by 0: those up to
    /// `1e-24 N`, where N is the effective number of points.
    ///
    /// A transform to the default accuracy, 1e-12, has errors up to that fraction of the sum of the
    /// weights in every coefficient, so it does not distinguish these powers from 0. Use it for
    /// deterministic sets, such as lattices, whose power is exactly 0 in many bands.
    #[must_use]
    pub fn without_rounding(mut self) -> Self {
        /// The square of the default accuracy of transforms.
        const ROUNDING: f64 = 1e-24;
        let floor = ROUNDING * self.n_effective;
        self.power.iter_mut().filter(|power| **power <= floor).for_each(|power| *power = 0.0);
        self
    }

    /// Returns a copy without the powers of bands other than 0.
    #[must_use]
    pub fn first_band(&self) -> Self {
        Self {
            bands: self.bands.clone(),
            power: self.power[..1].to_vec(),
            stderr: self.stderr[..1].to_vec(),
            ..*self
        }
    }

    /// Returns the existing bands, starting at 0, each with its mean power and standard error.
    pub fn rows(&self) -> impl Iterator<Item = (usize, f64, f64)> {
        let rows = self.power.iter().zip(&self.stderr).enumerate();
        rows.map(|(band, (&p, &e))| (band, p, e)).filter(|row| self.bands.has_band(row.0))
    }
}

impl Spectrum {
    /// Returns the domain of the points.
    #[must_use]
    pub fn domain(&self) -> Domain {
        self.bands
    }
}

/// Returns the values with those of classes without bands replaced by 0.
fn existing<B: Bands>(bands: &B, value: B::Tail) -> B::Tail {
    B::Tail::from_fn(|class| if bands.has_class(class) { value.get(class) } else { 0.0 })
}

/// Accumulates the power per band; [`finish`](Self::finish) returns the [`Spectrum`].
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SpectrumAccumulator<B: Bands = Domain> {
    bands: B,
    n_points: usize,
    n_effective: Moments,
    powers: Vec<Moments>,
    tail: ClassMoments<B::Tail>,
}

impl<B: Bands> SpectrumAccumulator<B> {
    /// Returns an empty accumulator for bands up to `last`, inclusive, of sets of `n_points`.
    ///
    /// # Panics
    ///
    /// Panics if allocation of `last + 1` moments fails. There are no transforms for degrees beyond
    /// [`MAX_DEGREE`](sphvar_sh::MAX_DEGREE).
    #[must_use]
    pub fn new(bands: B, n_points: usize, last: usize) -> Self {
        let powers = vec![Moments::default(); last.saturating_add(1)];
        let n_effective = Moments::default();
        Self { bands, n_points, n_effective, powers, tail: ClassMoments::default() }
    }

    /// Returns the bands of the accumulated powers, starting at band 0.
    #[must_use]
    pub fn bands(&self) -> &B {
        &self.bands
    }

    /// Returns the number of points of a realization.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.n_points
    }

    /// Returns the last band, inclusive (on the sphere, the maximum degree); `None` without bands,
    /// which is possible only for deserialized accumulators.
    #[must_use]
    pub fn lmax(&self) -> Option<usize> {
        self.powers.len().checked_sub(1)
    }

    /// Returns the number of realizations added; `None` if the counts of the bands differ, which is
    /// possible only for deserialized accumulators.
    #[must_use]
    pub fn realizations(&self) -> Option<u64> {
        let count = self.powers.first()?.count();
        let mut all = self.powers.iter().chain([&self.n_effective]);
        let is_equal = all.all(|moments| moments.count() == count);
        (is_equal && self.tail.count() == Some(count)).then_some(count)
    }

    /// Adds the realizations of another accumulator exactly.
    ///
    /// # Errors
    ///
    /// [`Error::Mismatch`] if the accumulators differ in the number of points or in the bands.
    pub fn try_merge(&mut self, other: &Self) -> Result<(), Error> {
        check_equal("numbers of points", &self.n_points, &other.n_points)?;
        check_equal("domains or frequencies", &self.bands, &other.bands)?;
        check_equal("numbers of degrees", &self.powers.len(), &other.powers.len())?;
        self.merge_powers(other);
        Ok(())
    }

    /// Returns the mean power and its standard error, which is NaN for a single realization. For a
    /// single realization that is the whole ensemble, see [`Spectrum::into_exact`].
    ///
    /// # Errors
    ///
    /// [`Error::NoRealizations`] if nothing was accumulated.
    pub fn finish(&self) -> Result<Spectrum<B>, Error> {
        let realizations = self.powers.first().map_or(0, Moments::count);
        if realizations == 0 {
            return Err(Error::NoRealizations);
        }
        let exists = |band: usize, x: f64| if self.bands.has_band(band) { x } else { 0.0 };
        let by_band = |f: &dyn Fn(&Moments) -> f64| -> Vec<f64> {
            self.powers.iter().enumerate().map(|(band, m)| exists(band, f(m))).collect()
        };
        Ok(Spectrum {
            bands: self.bands.clone(),
            n_points: self.n_points,
            n_effective: self.n_effective.mean(),
            realizations,
            power: by_band(&Moments::mean),
            stderr: by_band(&Moments::standard_error),
            tail: existing(&self.bands, self.tail.mean()),
            tail_stderr: existing(&self.bands, self.tail.standard_error()),
        })
    }

    /// Adds one realization: its effective number of points, the power of every band starting at 0,
    /// and the mean power beyond the last band.
    pub fn push_powers(
        &mut self,
        n_effective: f64,
        powers: impl IntoIterator<Item = f64>,
        tail: B::Tail,
    ) {
        for (moments, power) in self.powers.iter_mut().zip(powers) {
            moments.push(power);
        }
        self.n_effective.push(n_effective);
        self.tail.push(tail);
    }

    fn merge_powers(&mut self, other: &Self) {
        for (mine, theirs) in self.powers.iter_mut().zip(&other.powers) {
            mine.merge(theirs);
        }
        self.n_effective.merge(&other.n_effective);
        self.tail.merge(&other.tail);
    }
}

impl SpectrumAccumulator {
    /// Returns the domain of the points.
    #[must_use]
    pub fn domain(&self) -> Domain {
        self.bands
    }
}

impl<B: SpectralBands> Accumulator<B> for SpectrumAccumulator<B> {
    fn push(&mut self, realization: &Realization<'_, B>) {
        self.push_powers(realization.n_effective(), realization.power(), realization.tail());
    }

    fn merge(&mut self, other: &Self) {
        self.merge_powers(other);
    }
}
