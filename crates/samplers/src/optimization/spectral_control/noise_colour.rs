use std::f64::consts::{E, PI};
use std::fmt;

use sphvar_grammar::Choice;

/// A colour of noise, as a power for every frequency `omega = l/sqrt(N)`.
///
/// Colours describe the power at low frequencies relative to white noise, whose power is 1. The
/// power of every point set tends to 1 at high frequencies, so each profile ends at a frequency
/// `end` and leaves the higher ones to the points. The pair correlation at distance 0 of points
/// that are white noise beyond it, `g2(0) = 1 + integral of 2 omega (P - 1)` in the limit of many
/// points, lies between 0 and 1: such points neither repel beyond what is possible nor cluster in
/// pairs.
///
/// # References
///
/// Ulichney 1987, *Digital Halftoning*, for pink and blue noise; Lau, Arce and Gallagher 1998,
/// doi:10.1109/5.735449, for green noise. Amplitudes and ends are original to this project.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NoiseColour {
    /// `P = 1/omega` to omega = 2.1: a power inversely proportional to the frequency. g2(0) = 0.79.
    Pink,
    /// `P = 1.6 omega^2 exp(1 - omega^2)` to omega = 2: most power at the middle frequencies,
    /// with the peak at the principal frequency sqrt(pi/M) of clusters of M = pi points.
    /// g2(0) = 0.95.
    Green,
    /// No power to omega = 1.1, and `P = 1 + exp(-(omega - sqrt(pi))^2/0.18)/4` from there to
    /// omega = 2.5: a sharp transition, the peak at the principal frequency sqrt(pi) of a square
    /// lattice, and white noise at high frequencies. g2(0) = 0.44.
    ///
    /// Few points have too few degrees of freedom, above all where one more degree has just become
    /// empty. Descents did not find 2 to 23, 25, 30, 31 and 41 points of the sphere, 2 to 13, 15 to
    /// 22, 27 to 29 and 42 of the hemisphere, or 1, 3, 5 to 9 and 13 of the square; they found all
    /// other numbers to 140 (60 on the hemisphere).
    ///
    /// Ulichney's ideal has the transition at the principal frequency, but more coefficients than
    /// the points have degrees of freedom would have to vanish for a transition beyond 1.41.
    Blue,
}

impl NoiseColour {
    /// Every colour, by increasing frequency of its peak.
    pub const ALL: [Self; 3] = [Self::Pink, Self::Green, Self::Blue];

    /// Returns the name: `pink`, `green` or `blue`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pink => "pink",
            Self::Green => "green",
            Self::Blue => "blue",
        }
    }

    /// Returns the power at a frequency `omega = l/sqrt(N)` from 0 to [`Self::end`]; pink noise has
    /// none at 0, which no target uses.
    #[must_use]
    pub fn power(self, omega: f64) -> f64 {
        match self {
            Self::Pink if omega > 0.0 => 1.0 / omega,
            Self::Pink => 0.0,
            Self::Green => 1.6 * E * omega.powi(2) * (-omega.powi(2)).exp(),
            Self::Blue if omega <= 1.1 => 0.0,
            Self::Blue => 1.0 + 0.25 * (-(omega - PI.sqrt()).powi(2) / 0.18).exp(),
        }
    }

    /// Returns the last frequency of the profile.
    #[must_use]
    pub const fn end(self) -> f64 {
        match self {
            Self::Pink => 2.1,
            Self::Green => 2.0,
            Self::Blue => 2.5,
        }
    }
}

impl Choice for NoiseColour {
    const CHOICES: &'static [(&'static str, Self)] = &[
        (Self::Pink.name(), Self::Pink),
        (Self::Green.name(), Self::Green),
        (Self::Blue.name(), Self::Blue),
    ];
}

impl fmt::Display for NoiseColour {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::NoiseColour;

    /// Returns `1 + integral of 2 omega (P - 1)` by the midpoint rule.
    fn pair_correlation_at_0(colour: NoiseColour) -> f64 {
        const STEPS: u32 = 20_000;
        let step = colour.end() / f64::from(STEPS);
        let terms = (0..STEPS).map(|i| {
            let omega = (f64::from(i) + 0.5) * step;
            2.0 * omega * (colour.power(omega) - 1.0) * step
        });
        1.0 + terms.sum::<f64>()
    }

    #[test]
    fn profiles_are_realizable() {
        // The stated values, to half a unit of their last digit. A step of the integrand costs the
        // midpoint rule at most one of its steps.
        for (colour, stated) in
            [(NoiseColour::Pink, 0.79), (NoiseColour::Green, 0.95), (NoiseColour::Blue, 0.44)]
        {
            let got = pair_correlation_at_0(colour);
            assert!((got - stated).abs() < 5e-3, "{colour}: {got}");
        }
    }

    /// Each colour has its peak where its name puts it, and continuous power except for the
    /// transition of blue noise.
    #[test]
    fn peaks_have_their_frequencies() {
        for (colour, peak) in [
            (NoiseColour::Pink, 0.01),
            (NoiseColour::Green, 1.0),
            (NoiseColour::Blue, std::f64::consts::PI.sqrt()),
        ] {
            let omegas = (1..).map(|i| f64::from(i) / 100.0).take_while(|x| *x <= colour.end());
            let largest = omegas.max_by(|a, b| colour.power(*a).total_cmp(&colour.power(*b)));
            assert!((largest.unwrap() - peak).abs() < 0.006, "{colour}: {largest:?}");
        }
    }
}
