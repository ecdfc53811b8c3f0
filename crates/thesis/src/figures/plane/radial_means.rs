use sphvar_sh::Frequencies;
use sphvar_spectrum::{ExactSquareSpectrum, RadialSpectrum};

use super::panels::{
    KMAX, N_POINTS, SpectrumView, mean_power, mean_spectrum, omega_axis, radial_curve, realizations,
};
use crate::figures::Recipe;
use crate::figures::patterns::OTHER_COLOUR;
use crate::figures::significance::{at_most, largest_of_normal, verdict};
use crate::figures::square_patterns::PlanePattern;
use crate::{
    Axis, Claim, Curves, Error, Figure, Job, Mark, PlaneSpectrum, Quantity, Results, Setting,
    Stated,
};

/// Figure 4.6: radial means of white noise and jitter, beside their closed forms.
pub(crate) struct RadialMeans;

const PATTERNS: [PlanePattern; 2] = [PlanePattern::WhiteNoise, PlanePattern::Jittered];
/// "Close to zero" is read as a tenth of white noise, and "flat" as within a tenth of it.
const TENTH: f64 = 0.1;

impl Recipe for RadialMeans {
    fn title(&self) -> &'static str {
        "Radial means of white noise and jitter"
    }

    fn jobs(&self, setting: Setting) -> Vec<Job> {
        PATTERNS.map(|pattern| mean_spectrum(pattern, setting)).into()
    }

    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error> {
        for pattern in PATTERNS {
            let plane = results.plane(&mean_spectrum(pattern, setting))?;
            let exact = exact_mean(pattern)?;
            let title = |what: &str| format!("{}, N = {N_POINTS}: {what}", pattern.label());
            figure.panel(
                &format!("{}-spectrum", pattern.name()),
                title("mean power"),
                SpectrumView::WHOLE.field(&plane.spectrum, &[]),
            );
            let curves = vec![
                radial_curve("closed form", OTHER_COLOUR, Mark::Line, &exact, N_POINTS),
                radial_curve(
                    pattern.label(),
                    pattern.colour(),
                    Mark::Line,
                    &plane.radial,
                    N_POINTS,
                ),
            ];
            let y = Axis::linear("radial mean of the power");
            figure.panel(
                &format!("{}-radial", pattern.name()),
                title("radial mean"),
                Curves { x: omega_axis(), y, curves },
            );
            figure.claims.push(agreement(pattern, &plane.radial, &exact));
        }
        shape_of_jitter(results.plane(&mean_spectrum(PlanePattern::Jittered, setting))?, figure);
        figure.note(format!(
            "Means over {} sets and over rings of frequencies rho - 1/2 <= |k| < rho + 1/2. The closed form of jitter on n x n \
             cells is P(k) = 1 - sinc^2(k1/n) sinc^2(k2/n), sinc x = sin(pi x)/(pi x); its rings are averaged alike.",
            realizations(setting)
        ));
        Ok(())
    }
}

fn exact_mean(pattern: PlanePattern) -> Result<RadialSpectrum, Error> {
    let sampler = pattern.ensemble(N_POINTS).sampler()?;
    let exact = ExactSquareSpectrum::of(&*sampler)
        .ok_or_else(|| Error::Missing { key: format!("the exact spectrum of {sampler:?}") })?;
    Ok(RadialSpectrum::of(&exact.to(&Frequencies::new(KMAX)?, &())?))
}

/// The largest of the normalized differences decides.
fn agreement(pattern: PlanePattern, measured: &RadialSpectrum, exact: &RadialSpectrum) -> Claim {
    let rows = measured.rows().zip(exact.power());
    let scores: Vec<f64> = rows.map(|((_, p, stderr, _), exact)| (p - exact) / stderr).collect();
    let largest = scores.iter().fold(0.0, |a: f64, z| a.max(z.abs()));
    let chi2 = scores.iter().map(|z| z * z).sum::<f64>() / scores.len() as f64;
    let p_value = largest_of_normal(largest, scores.len());
    let (what, stated) = match pattern {
        PlanePattern::WhiteNoise => ("white noise: radial mean against 1", "flat"),
        _ => ("jittered: radial mean against its closed form", "Figure 4.6(d)"),
    };
    Claim::words(what, stated, verdict(p_value)).measured(Quantity::exact(largest)).because(
        format!(
            "largest difference over {} rings in standard errors, {}; chi2/dof {chi2:.3}",
            scores.len(),
            at_most(p_value)
        ),
    )
}

fn shape_of_jitter(jittered: &PlaneSpectrum, figure: &mut Figure) {
    let (power, stderr) = mean_power(jittered, 0.0..0.1);
    figure.claims.push(
        Claim::number(
            "jittered: mean power for omega below 0.1",
            Stated::AtMost(TENTH),
            Quantity::with_stderr(power, stderr),
        )
        .because("\"a region with power values close to zero near DC peak\", read as a tenth of white noise"),
    );
    let root = (N_POINTS as f64).sqrt();
    let largest = jittered
        .radial
        .rows()
        .filter(|row| row.0 as f64 >= root)
        .map(|(_, power, stderr, _)| ((power - 1.0).abs(), stderr))
        .fold((0.0, f64::NAN), |a, b| if b.0 > a.0 { b } else { a });
    figure.claims.push(
        Claim::number(
            "jittered: largest |P - 1| for omega above 1",
            Stated::AtMost(TENTH),
            Quantity::with_stderr(largest.0, largest.1),
        )
        .because(
            "\"after a characteristic frequency\", read as omega = 1, that of the cells, it \"appears to be flat, like \
             whitenoise\", read to a tenth",
        ),
    );
}
