use crate::Pattern;

/// What is known of a pattern before anything is computed, in words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PatternFacts {
    /// How the time for a set grows with its number of points N.
    pub cost: &'static str,
    /// The power P(l), white noise 1, as l goes to 0.
    pub law: &'static str,
    /// The exponent of N that the variance falls with for smooth integrands.
    pub best_rate: &'static str,
    /// The exponent for integrands with jumps.
    pub worst_rate: &'static str,
    /// Who described the pattern.
    pub source: &'static str,
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
                facts("N log N", "as asked for", "as asked for", "as asked for", "this project")
            }
            Self::EqualArea { .. } => facts("N", "1.04 l(l+1)/N", "-2", "-1.5", "Leopardi 2006"),
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
}
