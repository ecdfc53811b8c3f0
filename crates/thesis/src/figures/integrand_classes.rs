use sphvar_bounds::{IntegrandClass, Profile};
use sphvar_samplers::Domain;
use sphvar_variance::{VariancePoint, fit_rate};

use super::Recipe;
use super::patterns::OTHER_COLOUR;
use crate::{
    Axis, Claim, Curve, Curves, Error, Figure, Job, Quantity, Results, Setting, Stated,
    TestIntegrand,
};

/// Figure 6.1: the power of the best and of the worst integrand, and the rates that follow.
pub(crate) struct IntegrandClasses;

/// The N of the axis.
const N_POINTS: usize = 1024;
/// omega = 2.
const LMAX: usize = 64;
/// The last degree of the best case; that of its test function is 4.
const BAND: usize = 16;
/// Rates are read off between these N.
const FAR: [usize; 3] = [1_000_000, 10_000_000, 100_000_000];

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
        claim_rates(best, worst, figure)?;
        let cubic = IntegrandClass::cubic_power(scale)?;
        let constant = Profile::constant(1.0)?;
        let variance = |class: IntegrandClass| class.variance(&constant, N_POINTS, Domain::Sphere);
        figure.claims.push(
            Claim::number(
                "sum of 6.2 for a power of exactly l^-3 over the sum with 1/l^2",
                Stated::About { value: 1.0, tolerance: 0.0 },
                Quantity::exact(variance(cubic) / variance(worst)),
            )
            .erratum(23)
            .because("1/l^2 is the weight of an energy c l^-2; a power l^-3 has 2 l^-2 + l^-3, here under white noise"),
        );
        figure.note(format!(
            "omega = l/sqrt(N) with N = {N_POINTS}; the thesis divides by another alpha in each figure (erratum 8)."
        ));
        Ok(())
    }
}

/// The rates of section 6.2 from the closed forms at large N.
fn claim_rates(
    best: IntegrandClass,
    worst: IntegrandClass,
    figure: &mut Figure,
) -> Result<(), Error> {
    let (alpha, gamma) = (1.0, 1.0);
    let constant = ("constant", Profile::constant(gamma)?);
    let step = ("step", Profile::step(alpha, gamma)?);
    let quadratic = ("quadratic", Profile::quadratic(alpha, gamma)?);
    for ((name, profile), class, case, rate, erratum) in [
        (constant, best, "best", -1.0, 22),
        (constant, worst, "worst", -1.0, 21),
        (quadratic, best, "best", -2.0, 22),
        (step, worst, "worst", -1.5, 25),
        (quadratic, worst, "worst", -1.5, 28),
    ] {
        let point = |&n: &usize| VariancePoint {
            n_points: n as f64,
            variance: class.variance(&profile, n, Domain::Sphere),
            stderr: 0.0,
        };
        let points: Vec<VariancePoint> = FAR.iter().map(point).collect();
        let slope = fit_rate(&points).map_or(f64::NAN, |fit| fit.slope);
        figure.claims.push(
            Claim::number(
                format!("rate of the {name} profile, {case} case"),
                Stated::About { value: rate, tolerance: 0.005 },
                Quantity::exact(slope),
            )
            .erratum(erratum)
            .because(
                "closed form between N = 1e6 and 1e8; the erratum changes factors, not the rate",
            ),
        );
    }
    let far = best.variance(&step.1, FAR[0], Domain::Sphere);
    figure.claims.push(
        Claim::number(
            "variance of the step profile, best case, beyond N = (l0/alpha)^2",
            Stated::About { value: 0.0, tolerance: 0.0 },
            Quantity::exact(far),
        )
        .erratum(24)
        .because("closed form at N = 1e6; the thesis writes l for l0"),
    );
    Ok(())
}

fn over_omega(power: impl Fn(usize) -> f64) -> Vec<(f64, f64)> {
    let root = (N_POINTS as f64).sqrt();
    (1..=LMAX).map(|l| (l as f64 / root, power(l))).collect()
}

fn axes(y: Axis, curves: Vec<Curve>) -> Curves {
    Curves { x: Axis::linear("omega = l/sqrt(N)"), y, curves }
}
