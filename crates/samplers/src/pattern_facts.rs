use crate::{BestCandidate, Lloyd, Pattern, Riesz, SpectralControl};

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

    /// The seconds that a set of `n_points` takes to make on one core, roughly: a model for deciding how many
    /// sets are worth making, and for progress. Fitted to `docs/performance.md`, right to a factor of 2
    /// where it was measured, from 256 points on.
    #[must_use]
    pub fn seconds(&self, n_points: usize) -> f64 {
        let n = n_points as f64;
        let per_point = match self {
            Self::WhiteNoise => 33e-9,
            Self::Jittered | Self::Spiral => 24e-9,
            Self::Healpix => 12e-9,
            Self::Fibonacci | Self::Hammersley => 17e-9,
            Self::PoissonDisk { .. } => 2.5e-6,
            Self::Ccvt { capacity, .. } => {
                let mass = (*capacity).max(2) as f64;
                70e-9 * mass * mass.log2()
            }
            // A soft core takes as long again as the transforms.
            Self::Step { alpha, core, .. } => {
                19e-6 * descent(*alpha) * if *core > 0.0 { 2.5 } else { 1.0 }
            }
            Self::Blue { alpha, .. } => 27e-6 * descent(*alpha),
            Self::Profile { core, .. } => 8e-6 * if *core > 0.0 { 2.5 } else { 1.0 },
            Self::EqualArea { .. } => 29e-9,
            Self::BestCandidate { factor } => {
                47e-9 * n * f64::from(*factor) / f64::from(BestCandidate::DEFAULT_FACTOR)
            }
            Self::Lloyd { iterations } => {
                9.5e-6 * f64::from(*iterations) / f64::from(Lloyd::DEFAULT_ITERATIONS)
            }
            Self::Riesz { iterations, .. } => {
                400e-9 * n * f64::from(*iterations) / f64::from(Riesz::DEFAULT_ITERATIONS)
            }
            Self::Sobol => 70e-9,
            Self::Halton => 24e-9,
        };
        per_point * n
    }

    /// Returns the nominal work of making a set of `n_points`, in units of what a fast transform does
    /// for one point (some 60 ns of one core).
    ///
    /// Numbers of realizations follow from it, so that it is fixed by definition; [`Self::seconds`]
    /// can be refined without changing a result.
    #[must_use]
    pub fn nominal_work(&self, n_points: usize) -> f64 {
        let n = n_points as f64;
        let per_point = match self {
            Self::PoissonDisk { .. } => 40.0,
            Self::Ccvt { capacity, .. } => {
                let mass = (*capacity).max(2) as f64;
                1.2 * mass * mass.log2()
            }
            Self::Step { alpha, core, .. } => {
                320.0 * descent(*alpha) * if *core > 0.0 { 2.5 } else { 1.0 }
            }
            Self::Blue { alpha, .. } => 450.0 * descent(*alpha),
            Self::Profile { core, .. } => 130.0 * if *core > 0.0 { 2.5 } else { 1.0 },
            Self::BestCandidate { factor } => {
                0.8 * n * f64::from(*factor) / f64::from(BestCandidate::DEFAULT_FACTOR)
            }
            Self::Lloyd { iterations } => {
                160.0 * f64::from(*iterations) / f64::from(Lloyd::DEFAULT_ITERATIONS)
            }
            Self::Riesz { iterations, .. } => {
                6.5 * n * f64::from(*iterations) / f64::from(Riesz::DEFAULT_ITERATIONS)
            }
            _ => 1.0,
        };
        per_point * n
    }
}

/// The work of a descent that empties all degrees up to alpha sqrt(N) relative to that of alpha = 1,
/// from where it is taken not to fall: the size of the transforms times the steps,
/// `8 (1 + sqrt f)/(1 - sqrt f)` for a share f of the freedom.
fn descent(alpha: Option<f64>) -> f64 {
    let steps = |alpha: f64| {
        let root = (0.5 * alpha * alpha).min(SpectralControl::MOST_CONSTRAINED).sqrt();
        (1.0 + root) / (1.0 - root)
    };
    let usual = SpectralControl::DEFAULT_ALPHA;
    let alpha = alpha.unwrap_or(usual).max(usual);
    alpha * alpha * steps(alpha) / steps(usual)
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
    fn costs_are_those_that_were_measured() {
        let measured = [
            0.033, 0.022, 0.011, 0.017, 2.29, 27.1, 46.3, 25.6, 8.36, 0.030, 0.024, 49.5, 9.30,
            420.0, 0.066, 0.020, 0.016,
        ];
        for (pattern, milliseconds) in Pattern::ALL.into_iter().zip(measured) {
            let ratio = 1e3 * pattern.seconds(1024) / milliseconds;
            assert!((0.5..2.0).contains(&ratio), "{pattern}: {ratio}");
        }
        for pattern in Pattern::ALL {
            assert!(pattern.seconds(usize::MAX).is_finite() && pattern.seconds(0) >= 0.0);
        }
    }
}
