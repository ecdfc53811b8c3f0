use num_complex::Complex;
use serde::{Deserialize, Serialize};
use sphvar_scene::Image;
use sphvar_spectrum::{OrderAccumulator, SpectrumAccumulator};

use crate::Job;
use crate::plane_spectrum::PlaneSums;

/// The result of a piece of a job.
#[derive(Serialize, Deserialize)]
pub(crate) enum Piece {
    Spectrum(Box<SpectrumAccumulator>),
    Orders(OrderAccumulator),
    Coefficients(Vec<Complex<f64>>),
    Trials([Vec<f64>; 2]),
    Pictures(Vec<Image>),
    Plane(Box<PlaneSums>),
}

impl Piece {
    /// Returns whether it has the form of a result of `job` for the given number of sets. Stored
    /// bytes may decode to anything; a result that does not fit is recomputed.
    pub(crate) fn fits(&self, job: &Job, sets: u64) -> bool {
        let as_many = |n: usize| n as u64 == sets;
        match (self, job) {
            (Self::Spectrum(sums), Job::Spectrum { ensemble, domain, lmax, .. }) => {
                sums.domain() == *domain
                    && sums.n_points() == ensemble.used_points()
                    && sums.lmax() == Some(*lmax)
                    && sums.realizations() == Some(sets)
            }
            (Self::Orders(sums), Job::Orders { lmax, .. }) => {
                sums.lmax() == *lmax && sums.realizations() == sets
            }
            (Self::Coefficients(samples), Job::Coefficient { .. }) => as_many(samples.len()),
            (Self::Trials(estimates), Job::Trials { .. }) => {
                estimates.iter().all(|of_one| as_many(of_one.len()))
            }
            (Self::Pictures(images), Job::Pictures(pictures)) => {
                as_many(images.len()) && images.iter().all(|image| is_square(image, pictures.side))
            }
            (Self::Plane(sums), Job::PlaneSpectrum { ensemble, kmax, .. }) => {
                sums.fits(ensemble, *kmax, sets)
            }
            _ => false,
        }
    }
}

fn is_square(image: &Image, side: usize) -> bool {
    let lengths = [image.values.len(), image.spreads.len(), image.coverage.len()];
    image.width == side && image.height == side && lengths.iter().all(|&n| n == side * side)
}

#[cfg(test)]
mod tests {
    use sphvar_samplers::{Domain, Pattern, SquarePattern};
    use sphvar_scene::DirectionMode;

    use super::{OrderAccumulator, Piece, SpectrumAccumulator};
    use crate::{Job, Lighting, Pictures, PlaneEnsemble, ThesisEnsemble};

    const SETS: u64 = 3;

    fn jobs() -> Vec<Job> {
        let white = ThesisEnsemble::sphere(Pattern::WhiteNoise, 40);
        let half = ThesisEnsemble::visible_half(Pattern::Jittered, 24);
        vec![
            Job::Spectrum { ensemble: half, domain: Domain::Hemisphere, lmax: 6, sets: SETS },
            Job::Orders { ensemble: white.clone(), lmax: 5, sets: SETS },
            Job::Coefficient { ensemble: white.clone(), l: 4, m: 3, sets: SETS },
            Job::Trials { ensemble: white, sets: SETS },
            Job::Pictures(Pictures {
                pattern: Some(Pattern::FIBONACCI),
                lighting: Lighting::Ambient,
                n_points: 8,
                mode: DirectionMode::Rotated,
                side: 12,
                renders: SETS,
            }),
            plane(24, 5),
        ]
    }

    fn plane(n_points: usize, kmax: usize) -> Job {
        let ensemble = PlaneEnsemble::new(SquarePattern::WhiteSquare, n_points);
        Job::PlaneSpectrum { ensemble, kmax, sets: SETS }
    }

    #[test]
    fn a_piece_fits_its_own_job_and_its_own_number_of_sets() {
        for (i, job) in jobs().iter().enumerate() {
            for (k, other) in jobs().iter().enumerate() {
                let piece = other.work(0, 0..SETS).unwrap();
                assert_eq!(piece.fits(job, SETS), i == k, "{} for {}", other.key(), job.key());
                assert!(!piece.fits(job, SETS + 1) && !piece.fits(job, SETS - 1));
            }
        }
    }

    #[test]
    fn pieces_of_other_sizes_do_not_fit() {
        let jobs = jobs();
        // A visible half of 48 points has 24.
        let spectrum =
            |domain, n, lmax| Piece::Spectrum(Box::new(SpectrumAccumulator::new(domain, n, lmax)));
        assert!(spectrum(Domain::Hemisphere, 24, 6).fits(&jobs[0], 0), "without sets");
        assert!(!spectrum(Domain::Hemisphere, 24, 6).fits(&jobs[0], SETS), "empty");
        assert!(!spectrum(Domain::Sphere, 24, 6).fits(&jobs[0], 0), "domain");
        assert!(!spectrum(Domain::Hemisphere, 25, 6).fits(&jobs[0], 0), "points");
        assert!(!spectrum(Domain::Hemisphere, 24, 7).fits(&jobs[0], 0), "degrees");
        let orders = |lmax| Piece::Orders(OrderAccumulator::new(lmax).unwrap());
        assert!(orders(5).fits(&jobs[1], 0) && !orders(5).fits(&jobs[1], SETS), "empty");
        assert!(!orders(4).fits(&jobs[1], 0), "degrees");
        assert!(!Piece::Trials([vec![0.0; 3], vec![0.0; 2]]).fits(&jobs[3], SETS), "one short");
        for other in [plane(25, 5), plane(24, 6)] {
            assert!(!other.work(0, 0..SETS).unwrap().fits(&jobs[5], SETS), "{}", other.key());
        }
        let Piece::Pictures(mut images) = jobs[4].work(0, 0..SETS).unwrap() else {
            panic!("renders give pictures")
        };
        images[1].coverage.pop();
        assert!(!Piece::Pictures(images).fits(&jobs[4], SETS), "a pixel is missing");
    }
}
