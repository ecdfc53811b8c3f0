use sphvar_integrands::{Integrand, VonMisesFisher};
use sphvar_samplers::Domain;
use sphvar_spectrum::Spectrum;
use sphvar_variance::predict;

use super::Recipe;
use super::patterns::{OTHER_COLOUR, ThesisPattern};
use super::spectra::exact_jitter;
use crate::{
    Axis, Claim, Curve, Curves, Error, Figure, Job, Quantity, Results, Setting, Stated, Verdict,
};

/// Figure 5.1: the spectra of a sampler and of an integrand, and their product, for N and 4 N
/// points.
pub(crate) struct SpectraProduct;

/// Valid numbers of points of jittered sets, one four times the other.
const N_POINTS: [usize; 2] = [300, 1200];
/// The last degree shown: 2 sqrt(N) for the larger number.
const LMAX: usize = 70;
/// The concentration of the integrand: half of its peak 4.8 degrees from its centre.
const KAPPA: f64 = 200.0;

impl Recipe for SpectraProduct {
    fn title(&self) -> &'static str {
        "Spectra of a sampler and an integrand, and their product"
    }

    fn jobs(&self, _: Setting) -> Vec<Job> {
        Vec::new()
    }

    fn compose(&self, _: Setting, _: &Results, figure: &mut Figure) -> Result<(), Error> {
        let spectra = [spectrum(N_POINTS[0])?, spectrum(N_POINTS[1])?];
        let energy = VonMisesFisher::new(KAPPA)?.energy(Domain::Sphere, LMAX)?;
        let integrand: Vec<f64> =
            energy.per_band().iter().zip(0..).map(|(e, l)| e / f64::from(2 * l + 1)).collect();
        // The height is arbitrary here; on a common axis the integrand begins at the sampler's
        // plateau.
        let scaled: Vec<f64> = integrand.iter().map(|p| p / integrand[1]).collect();
        for (name, count) in [("a", 1), ("b", 2)] {
            let mut curves: Vec<Curve> = spectra[..count].iter().map(sampler_curve).collect();
            curves.push(Curve::line("integrand (scaled)", OTHER_COLOUR, from_1(&scaled)));
            figure.panel(name, format!("Spectra, {}", numbers(count)), axes("power", curves));
        }
        let product = |s: &Spectrum| -> Vec<f64> {
            s.power().iter().zip(&scaled).map(|(p, f)| p * f).collect()
        };
        for (name, count) in [("c", 1), ("d", 2)] {
            let curves = spectra[..count]
                .iter()
                .map(|s| Curve::line(label(s), colour(s), from_1(&product(s))))
                .collect();
            figure.panel(
                name,
                format!("Product, {}", numbers(count)),
                axes("product of powers", curves),
            );
        }
        let [few, many] = &spectra;
        claim_scaling(few, many, figure);
        let sum = |s| product(s)[1..].iter().sum::<f64>();
        figure.claims.push(
            Claim::number(
                "product of the spectra, summed over degrees, for 4N over that for N",
                Stated::AtMost(1.0),
                Quantity::exact(sum(many) / sum(few)),
            )
            .because(
                "exact spectra; where the sampler is quadratic the product falls to a quarter",
            ),
        );
        let variance = |s| predict(s, &energy).variance;
        figure.claims.push(
            Claim::number(
                "variance for 4N over that for N",
                Stated::AtMost(1.0),
                Quantity::exact(variance(many) / variance(few)),
            )
            .because("white noise has 1/4, jitter comes to 1/16 where the integrand is smooth"),
        );
        figure.note(format!(
            "The thesis's figure is a sketch. Here the sampler is jittered (exact spectra, N = {} and {}), the integrand a \
             von Mises-Fisher lobe of kappa = {KAPPA}.",
            N_POINTS[0], N_POINTS[1]
        ));
        Ok(())
    }
}

fn spectrum(n_points: usize) -> Result<Spectrum, Error> {
    exact_jitter(n_points, LMAX)
}

/// "The sampler's spectrum scales along the frequency": its curves for N and 4N are one over
/// l/sqrt(N).
fn claim_scaling(few: &Spectrum, many: &Spectrum, figure: &mut Figure) {
    /// Details that a sketch does not show.
    const VISIBLE: f64 = 0.02;
    let difference =
        (1..=LMAX / 2).map(|l| (many.power()[2 * l] - few.power()[l]).abs()).fold(0.0, f64::max);
    let verdict = if difference <= VISIBLE { Verdict::Holds } else { Verdict::Wrong };
    figure.claims.push(
        Claim::words(
            "scaling with N",
            "the sampler's spectrum scales along the frequency axis",
            verdict,
        )
        .measured(Quantity::exact(difference))
        .because(format!(
            "largest |P_4N(2l) - P_N(l)| for l to {}; it holds if that is at most {VISIBLE}",
            LMAX / 2
        )),
    );
}

fn label(spectrum: &Spectrum) -> String {
    format!("jittered, N = {}", spectrum.n_points())
}

fn colour(spectrum: &Spectrum) -> usize {
    let second = spectrum.n_points() == N_POINTS[1];
    if second { OTHER_COLOUR + 1 } else { ThesisPattern::Jittered.colour() }
}

fn sampler_curve(spectrum: &Spectrum) -> Curve {
    Curve::line(label(spectrum), colour(spectrum), from_1(spectrum.power()))
}

fn from_1(values: &[f64]) -> Vec<(f64, f64)> {
    values.iter().enumerate().skip(1).map(|(l, &v)| (l as f64, v)).collect()
}

fn numbers(count: usize) -> &'static str {
    ["N points", "N and 4N points"][count - 1]
}

fn axes(y: &str, curves: Vec<Curve>) -> Curves {
    Curves { x: Axis::linear("degree l"), y: Axis::linear(y), curves }
}
