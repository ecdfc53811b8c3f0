//! The chart of a spectrum between its profiles.

use sphvar_bounds::{Profile, ProfileShape};

use super::record::BoundRecord;
use super::source::Measured;
use crate::commands::power_chart::power_chart;
use crate::error::CliError;
use crate::plots::{Chart, Series, Style};

/// Values of a profile between two degrees of omega.
const STEPS: u32 = 200;

/// The spectrum with its errors and every profile over `l / sqrt N`; upper and lower profiles of a family share colour
/// and entry in the legend.
pub(super) fn chart(
    records: &[BoundRecord],
    measured: Option<&Measured>,
    n_points: usize,
) -> Result<Chart, CliError> {
    let scale = (n_points as f64).sqrt();
    let (mut low, mut high) = (1.0 / scale, 4.0);
    let mut series = Vec::new();
    if let Some(measured) = measured {
        let spectrum = measured.spectrum()?;
        let shown: Vec<(usize, f64)> = spectrum
            .degrees()
            .map(|l| (l, measured.power(l)))
            // Power that is rounding has no place on a logarithmic axis.
            .filter(|&(_, power)| power > sphvar_bounds::MeasuredSpectrum::NO_POWER)
            .collect();
        (low, high) =
            (shown.first().map_or(low, |s| s.0 as f64 / scale), measured.lmax() as f64 / scale);
        series.push(Series {
            label: measured.label.clone(),
            points: shown.iter().map(|&(l, power)| (l as f64 / scale, power)).collect(),
            error: Some(shown.iter().map(|&(l, _)| measured.stderr(l)).collect()),
            style: Style::Markers,
            // Black, which no profile has.
            colour: 4,
        });
    }
    let mut named: Vec<&str> = Vec::new();
    for record in records {
        let family = record.family();
        let colour = match named.iter().position(|&f| f == family) {
            Some(place) => place,
            None => {
                named.push(family);
                named.len() - 1
            }
        };
        let label = match record.side() {
            "given" => record.profile_name(),
            side => format!("{side} {}", record.profile_name()),
        };
        series.push(Series {
            label,
            points: outline(&record.profile, low, high),
            error: None,
            style: Style::Line,
            colour: if colour < 4 { colour } else { colour + 1 },
        });
    }
    Ok(power_chart(series))
}

/// A profile at evenly spaced logarithms of omega, with its break.
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
    }
    points
}
