use crate::{Domain, Error};

/// The prescribed power P(l) (1 for white noise) of a pattern at every degree from 1 to a last one;
/// higher degrees are free.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectralTarget {
    /// Powers by degree; degree 0 is ignored.
    power: Vec<f64>,
}

impl SpectralTarget {
    /// Returns the target `power[l]` for every degree l from 1; `power[0]` is ignored.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a power is negative or not finite.
    pub fn new(power: Vec<f64>) -> Result<Self, Error> {
        match power.iter().skip(1).find(|p| !(p.is_finite() && **p >= 0.0)) {
            Some(&got) => Err(Error::Parameter {
                name: "a target power",
                range: "finite and at least 0",
                got,
            }),
            None => Ok(Self { power }),
        }
    }

    /// Returns the last degree that has a target.
    #[must_use]
    pub fn last_degree(&self) -> usize {
        self.power.len().saturating_sub(1)
    }

    /// Returns the target at degree `l`, if any: on the hemisphere odd degrees have none.
    #[must_use]
    pub fn at(&self, l: usize, domain: Domain) -> Option<f64> {
        self.power.get(l).copied().filter(|_| l > 0 && domain.has_degree(l))
    }

    /// Returns the degrees that have a target, each with its target.
    pub(crate) fn degrees(&self, domain: Domain) -> impl Iterator<Item = (usize, f64)> {
        (0..self.power.len()).filter_map(move |l| Some((l, self.at(l, domain)?)))
    }

    /// Returns the number of coefficients that must vanish: `2l + 1` for each degree whose target
    /// is 0. N points have `2N - 3` degrees of freedom modulo rotations.
    #[must_use]
    pub fn constraints(&self, domain: Domain) -> usize {
        self.degrees(domain).filter(|(_, p)| *p == 0.0).map(|(l, _)| 2 * l + 1).sum()
    }

    /// Returns the pair correlation at distance 0 that the target implies, with white noise beyond
    /// it,
    ///
    /// ```text
    /// g2(0) = 1 + (1/N) sum_l (2l+1) (P(l) - 1).
    /// ```
    ///
    /// A negative value is impossible, so no pattern has such a spectrum; above 1 points attract
    /// each other.
    #[must_use]
    pub fn pair_correlation_at_zero(&self, n_points: usize, domain: Domain) -> f64 {
        let excess: f64 = self.degrees(domain).map(|(l, p)| (2 * l + 1) as f64 * (p - 1.0)).sum();
        1.0 + excess / n_points as f64
    }
}

#[cfg(test)]
mod tests {
    use super::{Domain, SpectralTarget};

    #[test]
    fn counts_are_those_of_the_harmonics() {
        // Degrees 1 to 3 have 15 harmonics; degree 2 alone 5.
        let target = SpectralTarget::new(vec![9.0, 0.0, 0.0, 0.0, 1.0]).unwrap();
        assert_eq!(target.constraints(Domain::Sphere), 15);
        assert_eq!(target.constraints(Domain::Hemisphere), 5);
        let g2 = target.pair_correlation_at_zero(15, Domain::Sphere);
        assert!(g2.abs() < 1e-15, "{g2}");
        assert!(target.pair_correlation_at_zero(14, Domain::Sphere) < 0.0);
        assert_eq!(target.at(3, Domain::Hemisphere), None);
        assert_eq!((target.at(0, Domain::Sphere), target.at(5, Domain::Sphere)), (None, None));
    }

    #[test]
    fn invalid_powers_are_rejected() {
        for bad in [-1e-9, f64::NAN, f64::INFINITY] {
            assert!(SpectralTarget::new(vec![0.0, 1.0, bad]).is_err(), "{bad}");
            assert!(SpectralTarget::new(vec![bad, 1.0]).is_ok(), "degree 0 does not count: {bad}");
        }
    }
}
