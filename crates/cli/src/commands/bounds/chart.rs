//! The chart of a spectrum between its profiles.

use sphvar_bounds::{Profile, ProfileShape};
use sphvar_samplers::Domain;

use super::record::BoundRecord;
use super::source::Measured;
use crate::commands::power_chart::{PowerCurve, ShownBands, power_chart};
use crate::error::CliError;
use crate::plots::{Chart, Ink, Series, Spread, Style};

/// The number of values of a profile between two degrees of omega.
const STEPS: u32 = 200;
/// The frequency at which profiles end if there is no spectrum.
const LAST_FREQUENCY: f64 = 4.0;

/// Returns the chart of the spectrum with its errors and every profile over `l / sqrt N`: upper
/// profiles as solid lines, lower ones dashed, the profiles of a family in one colour.
pub(super) fn chart(
    records: &[BoundRecord],
    measured: Option<&Measured>,
    n_points: usize,
) -> Result<Chart, CliError> {
    let scale = (n_points as f64).sqrt();
    let (mut low, mut high) = (1.0 / scale, LAST_FREQUENCY);
    let mut curves = Vec::new();
    if let Some(measured) = measured {
        let spectrum = measured.spectrum()?;
        let rows: Vec<(usize, f64, f64)> = spectrum
            .degrees()
            .map(|l| (l, measured.power(l), measured.stderr(l)))
            // Power at rounding level cannot be drawn on a logarithmic axis.
            .filter(|row| row.1 > sphvar_bounds::MeasuredSpectrum::NO_POWER)
            .collect();
        low = rows.first().map_or(low, |row| row.0 as f64 / scale);
        high = measured.lmax() as f64 / scale;
        curves.push(PowerCurve { label: measured.label.clone(), n_points, rows, ink: Ink::Black });
    }
    let profiles = || records.iter().map(|record| outline(&record.profile, low, high));
    let values = profiles().flatten().map(|point| point.1);
    let floor = (curves.iter().flat_map(|curve| &curve.rows).map(|row| row.1))
        .chain(values)
        .filter(|&power| power > 0.0)
        .fold(f64::INFINITY, f64::min);
    // A step alone has no values below its plateau that would determine the lower end of the axis.
    let floor = if curves.is_empty() { 0.1 * floor } else { floor };
    let mut families: Vec<&str> = Vec::new();
    let mut series = Vec::new();
    for (record, mut points) in records.iter().zip(profiles()) {
        let family = record.family();
        let rank = families.iter().position(|&f| f == family).unwrap_or_else(|| {
            families.push(family);
            families.len() - 1
        });
        // A step that rises from 0 is drawn from below the axis.
        for point in &mut points {
            point.1 = if point.0 >= record.profile.alpha() { point.1.max(floor) } else { point.1 };
        }
        let label = match record.side() {
            "given" => record.profile_name(),
            side => format!("{side} {}", record.profile_name()),
        };
        let style = if record.side() == "lower" { Style::Dashed } else { Style::Solid };
        series.push(Series { label, points, spread: Spread::None, style, ink: Ink::Rank(rank) });
    }
    let has_sides = records.iter().any(|record| record.side() != "given");
    let chart = power_chart(Domain::TEXTS, &curves, series);
    Ok(if has_sides {
        chart.with_note("Solid colours: upper profiles. Dashed colours: lower profiles.")
    } else {
        chart
    })
}

/// Returns a profile at evenly spaced logarithms of omega, with both values at its break.
fn outline(profile: &Profile, low: f64, high: f64) -> Vec<(f64, f64)> {
    let at = |omega: f64| {
        let part = omega / profile.alpha();
        let rise = match profile.shape() {
            ProfileShape::Constant => 1.0,
            ProfileShape::Step => f64::from(u8::from(part >= 1.0)),
            ProfileShape::Polynomial { exponent } => part.min(1.0).powf(exponent),
        };
        (omega, profile.offset() + profile.gamma() * rise)
    };
    let ratio = (high / low).ln();
    let mut points: Vec<_> =
        (0..=STEPS).map(|i| at(low * (ratio * f64::from(i) / f64::from(STEPS)).exp())).collect();
    let alpha = profile.alpha();
    if (low..high).contains(&alpha) && profile.shape() != ProfileShape::Constant {
        let place = points.partition_point(|p| p.0 < alpha);
        points.insert(place, at(alpha));
        if profile.shape() == ProfileShape::Step {
            points.insert(place, (alpha, profile.offset()));
        }
    }
    points
}
