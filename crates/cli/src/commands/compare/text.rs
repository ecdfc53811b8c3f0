//! The tables and conclusions of `compare`.

use super::record::{ComparisonBody, SamplerRecord};
use crate::commands::crossovers::CrossoverRecord;
use crate::commands::row_record::RowRecord;
use crate::commands::rows::Parts;
use crate::report::{number, table_of};

/// Returns the tables, their explanation, and the sampler with the largest variance reduction.
pub(super) fn text(body: &ComparisonBody, subject: &str) -> String {
    let mut text = format!("Variance of {subject}\n\n");
    text += &table_of(&RowRecord::columns(&body.rows, Parts::Both), &body.rows);
    text += &RowRecord::remarks(&body.rows);
    // Without a score there is no verdict.
    let scores: Vec<f64> = body.rows.iter().map(RowRecord::z).filter(|z| z.is_finite()).collect();
    let agreeing = scores.iter().filter(|z| z.abs() <= 3.0).count();
    let n_rows = scores.len();
    let without = body.rows.len() - n_rows;
    let agreement = format!(
        "Predicted and measured agree within 3 standard errors in {agreeing} of {n_rows} rows"
    );
    text += &match (n_rows, without) {
        (0, _) => "\nNo row has a verdict: too few trials hit the support of the integrand.\n\n"
            .to_owned(),
        (_, 0) => format!("\n{agreement}.\n\n"),
        _ => format!("\n{agreement}; {without} have no verdict.\n\n"),
    };
    text += &table_of(&SamplerRecord::columns(), &body.samplers);
    text += "\nrate: exponent b of variance ~ N^b; rate and reduction come from predicted or measured variances,\n\
             whichever are more precise. effective power: mean power of the pattern, weighted by the energies of\n\
             the integrand; white noise has 1. reduction: variance of white noise divided by this one.\n";
    if body.samplers.iter().any(|s| s.is_warped) {
        text +=
            "Both compare with white noise of uniform density, also those of warped patterns.\n";
    }
    if body.samplers.iter().any(|s| s.pre_asymptotic) {
        text +=
            "*: the rate changes over these numbers of points, it is not the asymptotic one yet.\n";
    }
    text += "\n";
    text.extend(body.crossovers.iter().map(CrossoverRecord::line));
    text + &verdict(&body.samplers)
}

/// Returns the sampler with the largest variance reduction at its largest number of points, by
/// predictions, which are more precise than measurements.
fn verdict(samplers: &[SamplerRecord]) -> String {
    let with_variance = samplers.iter().filter(|s| s.effective_power.is_finite());
    let Some(best) = with_variance.min_by(|a, b| a.effective_power.total_cmp(&b.effective_power))
    else {
        return "The integrand has no variance with any pattern: it is constant.\n".to_owned();
    };
    if best.variance_reduction.is_none() || best.effective_power <= 0.0 {
        let exact: Vec<&str> = samplers
            .iter()
            .filter(|s| s.variance_reduction.is_none())
            .map(|s| s.label.as_str())
            .collect();
        return format!("Exact to rounding: {}.\n", exact.join(", "));
    }
    let measured = best.measured_variance_reduction.zip(best.measured_variance_reduction_stderr);
    let measured = measured.map_or(String::new(), |(g, e)| {
        format!(", {} as measured", number::with_uncertainty(g, e))
    });
    let largest = format!(
        "Largest variance reduction: {} with N = {}, {} as predicted{measured}.\n",
        best.label,
        best.n,
        number::ratio(1.0 / best.effective_power),
    );
    largest + &effect_of_density(samplers)
}

/// Compares the best warped pattern with the best uniform one, if there are samplers of both kinds.
fn effect_of_density(samplers: &[SamplerRecord]) -> String {
    let best = |is_warped: bool| {
        let own = samplers.iter().filter(|s| s.is_warped == is_warped && s.effective_power > 0.0);
        own.min_by(|a, b| (a.effective_power).total_cmp(&b.effective_power))
    };
    best(true).zip(best(false)).map_or(String::new(), |(warped, uniform)| {
        format!(
            "Best density: {} has {} times the variance of {}, the best uniform pattern.\n",
            warped.label,
            number::ratio(warped.effective_power / uniform.effective_power),
            uniform.label
        )
    })
}
