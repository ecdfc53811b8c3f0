use std::f64::consts::PI;

use sphvar_samplers::Domain;

use super::Recipe;
use super::patterns::{BOUND_COLOUR, OTHER_COLOUR};
use crate::{
    Axis, Claim, Curve, Curves, Error, Figure, Job, Quantity, Results, Setting, Stated,
    TestIntegrand, Verdict,
};

/// Figure C.1: the energy of the cap per degree and its bound.
pub(crate) struct CapPower;

/// The last degree.
const LMAX: usize = 1024;
/// The first degree of the octaves from which exponents are computed.
const FIRST_OCTAVE: usize = 64;
/// sin of 60 degrees.
const SIN: f64 = 0.866_025_403_784_438_6;
/// `C_0 = 64 pi/sin theta_0`, as the thesis prints it.
const PRINTED: f64 = 64.0 * PI / SIN;
/// The same for orthonormal harmonics.
const CORRECT: f64 = 16.0 / SIN;

impl Recipe for CapPower {
    fn title(&self) -> &'static str {
        "Energy of the cap of 60 degrees and its bound"
    }

    fn jobs(&self, _: Setting) -> Vec<Job> {
        Vec::new()
    }

    fn compose(&self, _: Setting, _: &Results, figure: &mut Figure) -> Result<(), Error> {
        let energy = TestIntegrand::Cap.function()?.energy(Domain::Sphere, LMAX)?;
        let energy = energy.per_band();
        linear_panels(energy, figure);
        logarithmic_panel(energy, figure);
        claim_bounds(energy, figure);
        claim_decay(energy, figure);
        figure.note(
            "The thesis's \"power\" of C.12 is the energy of a degree, in harmonics of squared norm 4 pi. Here \
             harmonics are orthonormal: both the energy and its bound are 4 pi times smaller.",
        );
        Ok(())
    }
}

/// `1/((2l+1)(2l-1))`, with the sign that it has at l = 0.
fn decay(l: usize) -> f64 {
    let l = l as f64;
    1.0 / ((2.0 * l + 1.0) * (2.0 * l - 1.0))
}

fn over(first: usize, last: usize, f: impl Fn(usize) -> f64) -> Vec<(f64, f64)> {
    (first..=last).map(|l| (l as f64, f(l))).collect()
}

fn linear_panels(energy: &[f64], figure: &mut Figure) {
    for (name, first, last) in [("a", 1, 64), ("b", 1, 10), ("c", 10, 64)] {
        figure.panel(
            name,
            format!("Degrees {first} to {last}"),
            Curves {
                x: Axis::linear("degree l"),
                y: Axis::linear("energy E(l) of the cap"),
                curves: vec![
                    Curve::line(
                        "cap, theta_0 = 60 degrees",
                        OTHER_COLOUR,
                        over(first, last, |l| energy[l]),
                    ),
                    Curve::line(
                        "16/(sin theta_0 (2l+1)(2l-1))",
                        BOUND_COLOUR,
                        over(first, last, |l| CORRECT * decay(l)),
                    ),
                ],
            },
        );
    }
}

/// Both constants and the mean that the energy oscillates about.
fn logarithmic_panel(energy: &[f64], figure: &mut Figure) {
    let mean = |l: usize| 2.0 * SIN / (l * l) as f64;
    figure.panel(
        "logarithmic",
        format!("Degrees 1 to {LMAX}"),
        Curves {
            x: Axis::log("degree l"),
            y: Axis::log("energy E(l) of the cap"),
            curves: vec![
                Curve::line(
                    "cap, theta_0 = 60 degrees",
                    OTHER_COLOUR,
                    over(1, LMAX, |l| energy[l]),
                ),
                Curve::line(
                    "constant 16/sin theta_0",
                    BOUND_COLOUR,
                    over(1, LMAX, |l| CORRECT * decay(l)),
                ),
                Curve::line(
                    "constant 64 pi/sin theta_0, as printed",
                    OTHER_COLOUR + 1,
                    over(1, LMAX, |l| PRINTED * decay(l)),
                ),
                Curve::line("mean 2 sin theta_0/l^2", OTHER_COLOUR + 4, over(1, LMAX, mean)),
            ],
        },
    );
}

fn claim_bounds(energy: &[f64], figure: &mut Figure) {
    let printed = |l: usize| 4.0 * PI * energy[l];
    let ratio = (1..=LMAX).map(|l| printed(l) / (PRINTED * decay(l))).fold(0.0, f64::max);
    figure.claims.push(
        Claim::number(
            format!("energy C.12 over the bound C.20, largest of degrees 1 to {LMAX}"),
            Stated::AtMost(1.0),
            Quantity::exact(ratio),
        )
        .erratum(35)
        .because("both sides belong to harmonics of squared norm 4 pi, so the ratio is that of orthonormal ones too"),
    );
    figure.claims.push(
        Claim::number(
            "constant of C.20 in the norm of the variance formula 5.18",
            Stated::About { value: PRINTED, tolerance: 0.5 },
            Quantity::exact(CORRECT),
        )
        .erratum_if(Verdict::Wrong, 33)
        .because("16/sin theta_0; with 64 pi, which belongs to norm 4 pi, the formula gives 4 pi times the variance"),
    );
    figure.claims.push(
        Claim::number(
            "energy of degree 0, bound C.25",
            Stated::AtMost(PRINTED),
            Quantity::exact(printed(0)),
        )
        .erratum(36)
        .because("true and crude: it is 4 pi^2 (1 - cos theta_0)^2 in the thesis's norm"),
    );
    figure.claims.push(
        Claim::number(
            "power of degree 0, bound C.26",
            Stated::AtMost(PRINTED * decay(0)),
            Quantity::exact(printed(0)),
        )
        .erratum_if(Verdict::Wrong, 37)
        .because("(2l+1)^2 (2l-1) is -1 at l = 0: C.26 and the sum C.27 can only begin at l = 1"),
    );
}

/// Returns the exponent of a power law from its sums over the first and the last full octave, which
/// average out oscillations: `sum_{n < l <= 2n} l^-p` falls with `n^(1-p)`.
fn octave_exponent(f: impl Fn(usize) -> f64) -> f64 {
    let octave = |n: usize| (n + 1..=2 * n).map(&f).sum::<f64>();
    let (first, last) = (FIRST_OCTAVE, LMAX / 2);
    (octave(last) / octave(first)).ln() / (last as f64 / first as f64).ln() - 1.0
}

fn claim_decay(energy: &[f64], figure: &mut Figure) {
    let power = |l: usize| energy[l] / (2 * l + 1) as f64;
    for (what, stated, found) in [
        ("exponent of the cap's energy", -2.0, octave_exponent(|l| energy[l])),
        ("exponent of the cap's power", -3.0, octave_exponent(power)),
    ] {
        figure.claims.push(
            Claim::number(
                what,
                Stated::About { value: stated, tolerance: 0.05 },
                Quantity::exact(found),
            )
            .because(format!("from the means over octaves, degrees {FIRST_OCTAVE} to {LMAX}")),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::octave_exponent;

    #[test]
    fn exponents_of_power_laws_are_recovered() {
        for p in [1.5, 2.0, 3.0] {
            // Sums over octaves are integrals up to a relative p/(2n), n >= 64: twice that over ln
            // 8.
            let got = octave_exponent(|l| (l as f64).powf(-p));
            assert!((got + p).abs() < p / 64.0, "{p}: {got}");
        }
    }
}
