//! The mean squared error of every spherical harmonic against the variance formula.

use sphvar_spectrum::HomogeneityAudit;

use super::report::Ensemble;
use crate::plots::{Chart, Ink, Panel, Scale, Series, Spread, Style};

/// The part of the distance between two degrees over which the orders are spread.
const ORDERS: f64 = 0.7;
/// Ratios below this are 0 to rounding. They occur for an unrotated lattice that integrates a
/// harmonic exactly.
const ROUNDING: f64 = 1e-12;
/// If all ratios are within this factor of 1, the axis is linear.
const LINEAR_RATIO: f64 = 5.0;

/// Returns the chart of the ratios of each audit with their intervals; the title is that of the
/// sampler.
pub(super) fn chart(
    sampler: &str,
    n_points: usize,
    alpha: f64,
    audits: &[(Ensemble, HomogeneityAudit)],
) -> Chart {
    let series: Vec<Series> = (audits.iter().enumerate())
        .map(|(rank, (ensemble, audit))| {
            let shown = |ratio: f64| if ratio > ROUNDING { ratio } else { f64::NAN };
            let place = |l: usize, m: usize| l as f64 + ORDERS * (m as f64 / (l + 1) as f64);
            Series {
                label: ensemble.name().to_owned(),
                points: audit.ratios.iter().map(|r| (place(r.l, r.m), shown(r.ratio))).collect(),
                spread: Spread::Ranges(audit.ratios.iter().map(|r| (r.low, r.high)).collect()),
                style: Style::Markers,
                ink: Ink::Rank(rank),
            }
        })
        .collect();
    let ratios = || series.iter().flat_map(|s| &s.points).map(|point| point.1);
    let is_wide = ratios()
        .filter(|r| r.is_finite())
        .any(|r| !(1.0 / LINEAR_RATIO..=LINEAR_RATIO).contains(&r));
    let panel = Panel {
        y_scale: if is_wide { Scale::Log } else { Scale::Linear },
        reference: Some(1.0),
        ..Panel::log("mean squared error / variance formula", series)
    };
    Chart {
        title: format!("Integration errors of Y_lm with {sampler}, N = {n_points}"),
        x_label: "degree l, orders m = 0 to l from left to right".to_owned(),
        x_scale: Scale::Linear,
        panels: vec![panel],
        notes: vec![format!(
            "Bars: intervals that hold for all l and m together with probability {}. Ratios of 0 (to rounding) are \
             left out.",
            1.0 - alpha
        )],
    }
}
