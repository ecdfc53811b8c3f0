use std::ops::Range;

use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::{Domain, PointSet, Purpose};
use sphvar_spectrum::{
    Accumulator, CoefficientSamples, OrderAccumulator, Resolution, SpectrumAccumulator, accumulate,
};
use sphvar_variance::Measurement;

use crate::piece::Piece;
use crate::plane_spectrum::{self, PlaneSums};
use crate::results::Outcome;
use crate::{Error, Pictures, PlaneEnsemble, TestIntegrand, ThesisEnsemble};

/// An ensemble and the statistics computed from it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Job {
    /// The mean power per degree.
    Spectrum {
        /// Of these sets.
        ensemble: ThesisEnsemble,
        /// The domain of the spectrum: hemisphere sets may be treated as sets of the sphere.
        domain: Domain,
        /// To this degree, inclusive.
        lmax: usize,
        /// The number of sets in the mean.
        sets: u64,
    },
    /// The mean power of every order, of sets treated as sets of the sphere.
    Orders {
        /// Of these sets.
        ensemble: ThesisEnsemble,
        /// To this degree, inclusive.
        lmax: usize,
        /// The number of sets in the mean.
        sets: u64,
    },
    /// One coefficient `S_lm = sum_k conj Y_lm(s_k)` of every set.
    Coefficient {
        /// Of these sets.
        ensemble: ThesisEnsemble,
        /// Its degree.
        l: usize,
        /// Its order, from 0 to l.
        m: usize,
        /// The number of sets.
        sets: u64,
    },
    /// Estimates of the integrals of both test functions, with the same sets, which differ from
    /// those of spectra.
    Trials {
        /// With these sets.
        ensemble: ThesisEnsemble,
        /// The number of sets.
        sets: u64,
    },
    /// Renders of the Cornell box.
    Pictures(Pictures),
    /// The mean power of every frequency, of sets of the unit square.
    PlaneSpectrum {
        /// Of these sets.
        ensemble: PlaneEnsemble,
        /// Of frequencies with `|k| <= kmax`, at least 2.
        kmax: usize,
        /// The number of sets in the mean.
        sets: u64,
    },
}

/// The nominal work of a piece, some four seconds of one core: the maximum loss if a run is
/// interrupted.
const PIECE_WORK: f64 = 7e7;
/// The nominal work of a point in a transform to a low degree, about: the location of its ring,
/// which the model of transforms omits.
const POINT_WORK: f64 = 2.0;
/// The nominal work of a point in both test functions.
const TRIAL_WORK: f64 = 0.5;

impl Job {
    /// Returns a text that distinguishes the job from all others, and from the same job with
    /// another number of sets.
    #[must_use]
    pub fn key(&self) -> String {
        format!("{} sets={}", self.key_of_set(), self.sets())
    }

    /// Returns a text that describes the work for each set.
    pub(crate) fn key_of_set(&self) -> String {
        match self {
            Self::Spectrum { ensemble, domain, lmax, .. } => {
                format!("spectrum on {domain} lmax={lmax} of {}", ensemble.key())
            }
            Self::Orders { ensemble, lmax, .. } => {
                format!("orders lmax={lmax} of {}", ensemble.key())
            }
            Self::Coefficient { ensemble, l, m, .. } => {
                format!("coefficient l={l} m={m} of {}", ensemble.key())
            }
            Self::Trials { ensemble, .. } => format!("trials of {}", ensemble.key()),
            Self::Pictures(pictures) => pictures.key(),
            Self::PlaneSpectrum { ensemble, kmax, .. } => {
                format!("spectrum kmax={kmax} of {}", ensemble.key())
            }
        }
    }

    /// Returns the number of sets, or of renders.
    #[must_use]
    pub fn sets(&self) -> u64 {
        match self {
            Self::Spectrum { sets, .. }
            | Self::Orders { sets, .. }
            | Self::Coefficient { sets, .. }
            | Self::Trials { sets, .. }
            | Self::PlaneSpectrum { sets, .. } => *sets,
            Self::Pictures(pictures) => pictures.renders,
        }
    }

    /// Returns the nominal work of each set.
    pub(crate) fn work_of_set(&self) -> f64 {
        match self {
            Self::Spectrum { ensemble, lmax, .. } | Self::Orders { ensemble, lmax, .. } => {
                ensemble.work(*lmax)
            }
            Self::Coefficient { ensemble, l, .. } => {
                ensemble.work(*l) + POINT_WORK * ensemble.n_points as f64
            }
            Self::Trials { ensemble, .. } => {
                ensemble.pattern.nominal_work(ensemble.n_points)
                    + TRIAL_WORK * ensemble.n_points as f64
            }
            Self::Pictures(pictures) => pictures.work(),
            Self::PlaneSpectrum { ensemble, kmax, .. } => plane_spectrum::work(ensemble, *kmax),
        }
    }

    /// Returns the pieces, each a range of sets. They depend on the job alone, not on the number of
    /// sets: a longer run reuses the complete pieces of a shorter one.
    pub(crate) fn pieces(&self) -> impl Iterator<Item = Range<u64>> + use<> {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a positive number, and too large ones become the largest"
        )]
        let length = ((PIECE_WORK / self.work_of_set()) as u64).max(1);
        let sets = self.sets();
        (0..sets.div_ceil(length)).map(move |i| i * length..((i + 1) * length).min(sets))
    }

    /// Runs the job for a range of sets.
    pub(crate) fn work(&self, seed: u64, sets: Range<u64>) -> Result<Piece, Error> {
        Ok(match self {
            Self::Spectrum { ensemble, domain, lmax, .. } => {
                let empty = SpectrumAccumulator::new(*domain, ensemble.used_points(), *lmax);
                Piece::Spectrum(Box::new(accumulated(ensemble, seed, *lmax, sets, &empty)?))
            }
            Self::Orders { ensemble, lmax, .. } => {
                let empty = OrderAccumulator::new(*lmax)?;
                Piece::Orders(accumulated(ensemble, seed, *lmax, sets, &empty)?)
            }
            Self::Coefficient { ensemble, l, m, .. } => {
                let empty = CoefficientSamples::new(*l, *m);
                Piece::Coefficients(accumulated(ensemble, seed, *l, sets, &empty)?.finish())
            }
            Self::Trials { ensemble, .. } => Piece::Trials(estimates(ensemble, seed, sets)?),
            Self::Pictures(pictures) => Piece::Pictures(pictures.render(seed, sets)?),
            Self::PlaneSpectrum { ensemble, kmax, .. } => {
                Piece::Plane(Box::new(PlaneSums::run(ensemble, *kmax, seed, sets)?))
            }
        })
    }

    /// Merges the pieces, in their order.
    pub(crate) fn finish(&self, pieces: Vec<Piece>) -> Result<Outcome, Error> {
        let lost = || Error::Missing { key: self.key() };
        let mut pieces = pieces.into_iter();
        let mut whole = pieces.next().ok_or_else(lost)?;
        for piece in pieces {
            match (&mut whole, piece) {
                (Piece::Spectrum(whole), Piece::Spectrum(piece)) => whole.merge(&piece),
                (Piece::Orders(whole), Piece::Orders(piece)) => whole.merge(&piece),
                (Piece::Coefficients(whole), Piece::Coefficients(piece)) => whole.extend(piece),
                (Piece::Trials(whole), Piece::Trials(piece)) => {
                    for (whole, piece) in whole.iter_mut().zip(piece) {
                        whole.extend(piece);
                    }
                }
                (Piece::Pictures(whole), Piece::Pictures(piece)) => whole.extend(piece),
                (Piece::Plane(whole), Piece::Plane(piece)) => whole.merge(&piece),
                _ => return Err(lost()),
            }
        }
        Ok(match whole {
            Piece::Spectrum(accumulator) => {
                let spectrum = accumulator.finish()?;
                let exact = self.sets() == 1;
                Outcome::Spectrum(if exact { spectrum.into_exact() } else { spectrum })
            }
            Piece::Orders(accumulator) => Outcome::Orders(accumulator.finish()),
            Piece::Coefficients(samples) => Outcome::Coefficients(samples),
            Piece::Trials(estimates) => Outcome::Trials(estimates.map(Measurement::new)),
            Piece::Pictures(images) => Outcome::Pictures(images),
            Piece::Plane(sums) => Outcome::Plane(Box::new(sums.finish(self.sets() == 1)?)),
        })
    }
}

fn accumulated<A: Accumulator>(
    ensemble: &ThesisEnsemble,
    seed: u64,
    lmax: usize,
    sets: Range<u64>,
    empty: &A,
) -> Result<A, Error> {
    let resolution = Resolution::new(lmax, ensemble.used_points());
    ensemble
        .with_sets(seed, Purpose::Pattern, |all| Ok(accumulate(all, resolution, sets, empty, &())?))
}

/// `area/N sum_k f(s_k)` of each set, for both test functions.
fn estimates(
    ensemble: &ThesisEnsemble,
    seed: u64,
    sets: Range<u64>,
) -> Result<[Vec<f64>; 2], Error> {
    let [harmonic, cap] = TestIntegrand::ALL.map(TestIntegrand::function);
    let functions = [harmonic?, cap?];
    let area = ensemble.domain().area();
    let pairs: Result<Vec<[f64; 2]>, Error> = ensemble.with_sets(seed, Purpose::Trial, |all| {
        let estimate = |set: &mut PointSet, index| {
            all.realize_into(index, set, &())?;
            Ok([0, 1].map(|i| {
                let values: Vec<f64> = set.points.iter().map(|&p| functions[i].eval(p)).collect();
                area * set.mean(&values)
            }))
        };
        sets.into_par_iter().map_init(PointSet::default, estimate).collect()
    });
    let pairs = pairs?;
    Ok([0, 1].map(|i| pairs.iter().map(|pair| pair[i]).collect()))
}

#[cfg(test)]
mod tests {
    use sphvar_samplers::{Pattern, SquarePattern};

    use super::{Domain, Job, PlaneEnsemble, ThesisEnsemble};
    use crate::{Results, Scale, Setting};

    /// Exact sums and lists do not depend on the division into pieces.
    #[test]
    fn pieces_of_any_length_give_the_same_bits() {
        let white = ThesisEnsemble::sphere(Pattern::WhiteNoise, 40);
        let half = ThesisEnsemble::visible_half(Pattern::Jittered, 24);
        let jobs = [
            Job::Spectrum { ensemble: half, domain: Domain::Hemisphere, lmax: 6, sets: 9 },
            Job::Orders { ensemble: white.clone(), lmax: 5, sets: 9 },
            Job::Coefficient { ensemble: white.clone(), l: 4, m: 3, sets: 9 },
            Job::Trials { ensemble: white, sets: 9 },
            Job::PlaneSpectrum {
                ensemble: PlaneEnsemble::new(SquarePattern::JitteredSquare, 16),
                kmax: 5,
                sets: 9,
            },
        ];
        let finished = |job: &Job, cuts: &[u64]| {
            let pieces = cuts.windows(2).map(|cut| job.work(1, cut[0]..cut[1]).unwrap()).collect();
            let mut results = Results::new(Setting { scale: Scale::Quick, seed: 1 });
            results.insert(job, job.finish(pieces).unwrap());
            results
        };
        let both =
            jobs.each_ref().map(|job| (finished(job, &[0, 9]), finished(job, &[0, 1, 6, 9])));
        let [spectra, orders, coefficients, trials, plane] = both;
        let same = spectra.0.spectrum(&jobs[0]).unwrap() == spectra.1.spectrum(&jobs[0]).unwrap();
        assert!(same, "spectra");
        assert_eq!(orders.0.orders(&jobs[1]).unwrap(), orders.1.orders(&jobs[1]).unwrap());
        let (whole, cut) = coefficients;
        assert_eq!(whole.coefficients(&jobs[2]).unwrap(), cut.coefficients(&jobs[2]).unwrap());
        assert_eq!(trials.0.trials(&jobs[3]).unwrap(), trials.1.trials(&jobs[3]).unwrap());
        let plane = [&plane.0, &plane.1].map(|results| results.plane(&jobs[4]).unwrap());
        assert_eq!(plane[0], plane[1]);
    }
}
