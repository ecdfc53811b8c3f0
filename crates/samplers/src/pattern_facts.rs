use crate::{Domain, Pattern};

/// What is known of a pattern before anything is computed, in words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PatternFacts {
    /// How the time for a set grows with its number of points N.
    pub cost: &'static str,
    /// The power P(l), white noise 1, as l goes to 0.
    pub law: &'static str,
    /// The exponents of N that the variance falls with for smooth integrands, or `exact`.
    pub best_rate: &'static str,
    /// The exponent for integrands with jumps.
    pub worst_rate: &'static str,
    /// Who described the pattern.
    pub source: &'static str,
}

impl PatternFacts {
    /// Returns how the variance falls with N, in words: `N^-2 for smooth integrands, ...`.
    #[must_use]
    pub fn rates(&self) -> String {
        let powers = |rates: &str| {
            let parts = rates.split(", ");
            let power = |r: &str| if r.starts_with('-') { format!("N^{r}") } else { r.to_owned() };
            parts.map(power).collect::<Vec<_>>().join(" or ")
        };
        let (smooth, jumps) = (powers(self.best_rate), powers(self.worst_rate));
        format!("{smooth} for smooth integrands, {jumps} for those with jumps")
    }
}

impl Pattern {
    /// The facts of the pattern with its usual parameters. Laws and rates were measured with this
    /// program where the source has none; `docs/theory.md` has the figures.
    #[must_use]
    pub fn facts(&self) -> PatternFacts {
        let facts = |cost, law, best_rate, worst_rate, source| PatternFacts {
            cost,
            law,
            best_rate,
            worst_rate,
            source,
        };
        match self {
            Self::WhiteNoise => facts("N", "1", "-1", "-1", "definition"),
            Self::Jittered => facts(
                "N",
                "1.1186 l(l+1)/N",
                "-2",
                "-1.5",
                "Gorski et al. 2005 (cells); Singh 2015",
            ),
            Self::Healpix => {
                facts("N", "0 (odd l), c_l/N (even l)", "-2", "-1.5", "Gorski et al. 2005")
            }
            Self::Fibonacci => facts("N", "irregular, N^-2 to N^-4", "-3", "-1.5", "Gonzalez 2010"),
            Self::PoissonDisk { .. } => facts(
                "N",
                "0.0596 (exact), 0.0578 (saturated)",
                "-1",
                "-1",
                "Cook 1986; Gamito and Maddock 2009",
            ),
            Self::Ccvt { .. } => facts(
                "N m log m",
                "1/m (white mass), 0.0145 (l-1)l(l+1)(l+2)/N^2 (else)",
                "-1 (white mass), -3",
                "-1 (white mass), -1.5",
                "Balzer, Schloemer and Deussen 2009",
            ),
            Self::Step { .. } | Self::Blue { .. } => facts(
                "N log N",
                "0 for l <= alpha sqrt(N)",
                "exact",
                "-1.5",
                "this project; Graef and Potts 2011",
            ),
            Self::Profile { .. } => {
                facts("N log N", "as requested", "as requested", "as requested", "this project")
            }
            Self::EqualArea { .. } => facts("N", "1.0472 l(l+1)/N", "-2", "-1.5", "Leopardi 2006"),
            Self::Spiral => facts("N", "irregular", "-2", "-1.5", "Rakhmanov, Saff and Zhou 1994"),
            Self::BestCandidate { .. } => facts("N^2", "0.075", "-1", "-1", "Mitchell 1991"),
            Self::Lloyd { .. } => facts(
                "N log N a step",
                "white noise's where the steps do not reach",
                "-1",
                "-1",
                "Lloyd 1982; Du, Faber and Gunzburger 1999",
            ),
            Self::Riesz { .. } => facts(
                "N^2 a step",
                "1e-5 l at N = 1024, where the steps reach",
                "-2",
                "-1.5",
                "Hardin and Saff 2004",
            ),
            Self::Sobol => facts("N", "irregular", "-2.7", "-1.5", "Sobol 1967; Owen 1995"),
            Self::Halton => {
                facts("N", "irregular", "-2", "-1.5", "Halton 1960; Cranley and Patterson 1976")
            }
            Self::Hammersley => {
                facts("N", "irregular", "-3", "-1.5", "Hammersley 1960; Cranley and Patterson 1976")
            }
        }
    }

    /// Returns [`Sampler::nominal_work`](crate::Sampler::nominal_work) of the sampler of `n_points` points, or of
    /// the nearest number that there is; that of points at a unit each where there is none.
    #[must_use]
    pub fn nominal_work(&self, n_points: usize) -> f64 {
        let sampler = self.build(self.nearest_count(n_points, Domain::Sphere), Domain::Sphere);
        sampler.map_or(n_points as f64, |sampler| sampler.nominal_work())
    }
}

#[cfg(test)]
mod tests {
    use super::Pattern;

    #[test]
    fn rates_are_powers_of_n_or_words() {
        for (name, rates) in [
            ("white-noise", "N^-1 for smooth integrands, N^-1 for those with jumps"),
            ("step", "exact for smooth integrands, N^-1.5 for those with jumps"),
            (
                "ccvt",
                "N^-1 (white mass) or N^-3 for smooth integrands, N^-1 (white mass) or N^-1.5 for \
                 those with jumps",
            ),
        ] {
            assert_eq!(Pattern::from_name(name).unwrap().facts().rates(), rates);
        }
    }

    /// The milliseconds of `docs/performance.md` at 1024 points, within a factor of 2.
    #[test]
    fn works_are_those_that_were_measured() {
        const UNIT_MILLISECONDS: f64 = 60e-6;
        let measured = [
            0.033, 0.022, 0.011, 0.017, 2.29, 27.1, 46.3, 25.6, 8.36, 0.030, 0.024, 49.5, 9.30,
            420.0, 0.066, 0.020, 0.016,
        ];
        for (pattern, milliseconds) in Pattern::ALL.into_iter().zip(measured) {
            let ratio = UNIT_MILLISECONDS * pattern.nominal_work(1024) / milliseconds;
            // A unit a point is the least.
            let most = if milliseconds < 0.1 { 6.0 } else { 2.0 };
            assert!((0.5..most).contains(&ratio), "{pattern}: {ratio}");
        }
        for pattern in Pattern::ALL {
            assert!(pattern.nominal_work(1 << 20).is_finite() && pattern.nominal_work(0) >= 0.0);
        }
    }
}
