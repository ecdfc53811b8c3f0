use sphvar_bounds::{IntegrandClass, Profile};
use sphvar_samplers::Domain;

use super::Recipe;
use super::patterns::OTHER_COLOUR;
use super::profile_rates::rate_claim;
use crate::{
    Axis, Claim, Curve, Curves, Error, Figure, Job, Quantity, Results, Setting, Stated,
    TestIntegrand,
};

/// Figure 6.1: the power of the best and of the worst integrand, and the rates under a constant
/// profile.
pub(crate) struct IntegrandClasses;

/// The N of the axis.
const N_POINTS: usize = 1024;
/// omega = 2.
const LMAX: usize = 64;
/// The last degree of the best case; that of its test function is 4.
const BAND: usize = 16;

impl Recipe for IntegrandClasses {
    fn title(&self) -> &'static str {
        "Power of the best and the worst integrand"
    }

    fn jobs(&self, _: Setting) -> Vec<Job> {
        Vec::new()
    }

    fn compose(&self, _: Setting, _: &Results, figure: &mut Figure) -> Result<(), Error> {
        let best = IntegrandClass::band_limited(1.0, BAND)?;
        let cap = TestIntegrand::Cap.function()?.energy(Domain::Sphere, LMAX)?;
        // The mean that the cap's energy oscillates about is 2 sin(theta_0)/l^2.
        let scale = 2.0 * 60f64.to_radians().sin();
        let worst = IntegrandClass::power_law(scale, 2.0)?;
        let power = |class: IntegrandClass| move |l: usize| class.energy(l) / (2 * l + 1) as f64;
        figure.panel(
            "best-case",
            format!("Best case: constant to degree {BAND}, zero beyond"),
            axes(
                Axis::linear("power of the integrand"),
                vec![Curve::line("band-limited", OTHER_COLOUR, over_omega(power(best)))],
            ),
        );
        figure.panel(
            "worst-case",
            "Worst case: power O(l^-3), energy O(l^-2)",
            axes(
                Axis::log("power of the integrand"),
                vec![
                    Curve::line(
                        "cap of 60 degrees",
                        OTHER_COLOUR + 1,
                        over_omega(|l| cap.per_band()[l] / (2 * l + 1) as f64),
                    ),
                    Curve::line("energy c l^-2", OTHER_COLOUR, over_omega(power(worst))),
                ],
            ),
        );
        let constant = Profile::constant(1.0)?;
        for (case, class, erratum) in [("best", best, 22), ("worst", worst, 21)] {
            let what = format!("constant profile, {case} case");
            figure.claims.push(rate_claim(&what, class, &constant, -1.0, erratum));
        }
        let weight = |l: usize| (2 * l + 1) as f64 / l as f64;
        figure.claims.push(
            Claim::number(
                "weight (2l+1) l^-3 of 6.2 for a power l^-3, largest ratio to 1/l^2",
                // The constant a'_F of 6.2 is free; this is the smallest that serves.
                Stated::AtMost(3.0),
                Quantity::exact((1..=LMAX).map(weight).fold(0.0, f64::max)),
            )
            .erratum(23)
            .because(
                "6.2 is an inequality with a free constant: (2l+1) l^-3 <= 3 l^-2 for every l; the ratio falls to 2. The \
                 thesis writes P_S for P_F",
            ),
        );
        figure.note(format!(
            "omega = l/sqrt(N) with N = {N_POINTS}; the thesis divides by another alpha in each figure (erratum 8)."
        ));
        Ok(())
    }
}

fn over_omega(power: impl Fn(usize) -> f64) -> Vec<(f64, f64)> {
    let root = (N_POINTS as f64).sqrt();
    (1..=LMAX).map(|l| (l as f64 / root, power(l))).collect()
}

fn axes(y: Axis, curves: Vec<Curve>) -> Curves {
    Curves { x: Axis::linear("omega = l/sqrt(N)"), y, curves }
}
