use sphvar_samplers::Domain;

use super::Recipe;
use crate::{
    Axis, Claim, Curve, Curves, Error, Figure, Job, Quantity, Results, Setting, Stated,
    TestIntegrand, Verdict,
};

/// Figure C.1: the energy of the cap per degree and its bound.
pub(crate) struct CapPower;

/// The figure's last degree.
const LMAX: usize = 256;
/// sin of 60 degrees.
const SIN: f64 = 0.866_025_403_784_438_6;

impl Recipe for CapPower {
    fn title(&self) -> &'static str {
        "Energy of the cap of 60 degrees and its bound"
    }

    fn jobs(&self, _: Setting) -> Vec<Job> {
        Vec::new()
    }

    fn compose(&self, _: Setting, _: &Results, figure: &mut Figure) -> Result<(), Error> {
        let energy = TestIntegrand::Cap.function()?.energy(Domain::Sphere, LMAX)?;
        let energy = |l: usize| energy.per_degree()[l];
        // C.20 with its constant corrected.
        let bound = |l: usize| {
            let l = l as f64;
            16.0 / (SIN * (2.0 * l + 1.0) * (2.0 * l - 1.0))
        };
        for (name, first, last) in [("a", 1, LMAX), ("b", 1, 32), ("c", 64, LMAX)] {
            let over = |f: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
                (first..=last).map(|l| (l as f64, f(l))).collect()
            };
            figure.panel(
                name,
                format!("Degrees {first} to {last}"),
                Curves {
                    x: Axis::linear("degree l"),
                    y: Axis::log("energy E(l) of the cap"),
                    curves: vec![
                        Curve::line("cap, theta_0 = 60 degrees", 0, over(&energy)),
                        Curve::line("bound 16/(sin theta_0 (2l+1)(2l-1))", 1, over(&bound)),
                    ],
                },
            );
        }
        let ratio = (1..=LMAX).map(|l| energy(l) / bound(l)).fold(0.0, f64::max);
        figure.claims.push(
            Claim::number(
                "energy of the cap over the bound C.20 with 16 for 64 pi, largest of degrees 1 to 256",
                Stated::AtMost(1.0),
                Quantity::exact(ratio),
            )
            .erratum(35)
            .because("the thesis's constant 64 pi belongs to harmonics of norm 4 pi"),
        );
        let mean: f64 = (1..=LMAX).map(|l| (l * l) as f64 * energy(l)).sum::<f64>() / LMAX as f64;
        figure.claims.push(
            Claim::words("decay of the energy", "O(l^-2), power O(l^-3)", Verdict::Holds)
                .found(Quantity::exact(mean / (2.0 * SIN)))
                .because(
                    "l^2 E(l) has the mean 2 sin theta_0: found is their ratio, over 256 degrees",
                ),
        );
        Ok(())
    }
}
