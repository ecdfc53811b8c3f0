use sphvar_samplers::Pattern;

use super::Recipe;
use super::order_grid::{OrderGrid, Style};
use crate::{
    Claim, Error, Figure, Job, Palette, Quantity, Results, Setting, Stated, ThesisEnsemble, Verdict,
};

/// Figure 4.9: the power of every order of white noise, as a triangle and as a square.
pub(crate) struct WhiteNoiseOrders;

/// The number of points, which the thesis does not state.
const N_POINTS: usize = 1024;
/// The last degree shown.
const LMAX: usize = 64;

fn job(sets: u64) -> Job {
    Job::Orders {
        ensemble: ThesisEnsemble::sphere(Pattern::WhiteNoise, N_POINTS),
        lmax: LMAX,
        sets,
    }
}

fn realizations(setting: Setting) -> u64 {
    setting.scale.pick(200, 1000)
}

impl Recipe for WhiteNoiseOrders {
    fn title(&self) -> &'static str {
        "Angular power spectrum of white noise"
    }

    fn jobs(&self, setting: Setting) -> Vec<Job> {
        vec![job(1), job(realizations(setting))]
    }

    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error> {
        let sets = realizations(setting);
        let style = Style { label: "power (4 pi/N) |S_lm|^2", palette: Palette::Heat };
        let one = OrderGrid::new(results.orders(&job(1))?);
        let many = OrderGrid::new(results.orders(&job(sets))?);
        figure.panel(
            "triangle",
            "(a) One set: degrees down, orders across",
            one.triangle(&style, |p| p),
        );
        figure.panel("square", "(b) The same, square-shaped", one.square(&style, 1, |p| p));
        figure.panel(
            "square-mean",
            format!("Mean over {sets} sets, square-shaped"),
            many.square(&style, 1, |p| p),
        );

        let highest = (1..=LMAX).flat_map(|l| one.degree(l)).map(|o| o.power).fold(0.0, f64::max);
        let centre = one.power(0);
        let verdict = if centre > highest { Verdict::Holds } else { Verdict::Wrong };
        figure.claims.push(
            Claim::words("peak at l = 0, m = 0", "the DC peak", verdict)
                .measured(Quantity::exact(centre))
                .because(format!(
                    "it is N = {N_POINTS} in every set by definition; the largest of the others is {highest:.2}"
                ))
                .by_construction(),
        );
        figure.claims.push(
            Claim::number(
                "power of white noise, mean over all orders of degrees 1 to 64",
                Stated::About { value: 1.0, tolerance: 0.01 },
                mean_power(&many),
            )
            .because("the thesis normalizes by N/mu, so that white noise has 1"),
        );
        figure.note(format!(
            "N = {N_POINTS}, which the thesis does not state. Degree 0 is left out of the pictures: its power is N."
        ));
        Ok(())
    }
}

/// Returns the mean over all orders but that of degree 0, m and -m counted both, with the errors of
/// independent orders.
fn mean_power(grid: &OrderGrid<'_>) -> Quantity {
    let (mut sum, mut variance, mut count) = (0.0, 0.0, 0.0);
    for order in (1..=grid.lmax()).flat_map(|l| grid.degree(l)) {
        let weight = if order.m == 0 { 1.0 } else { 2.0 };
        sum += weight * order.power;
        variance += (weight * order.stderr).powi(2);
        count += weight;
    }
    Quantity::with_stderr(sum / count, variance.sqrt() / count)
}
