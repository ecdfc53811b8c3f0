//! The chart of one spectrum.

use sphvar_samplers::Domain;
use sphvar_spectrum::Spectrum;

use crate::commands::power_chart::{PowerCurve, ShownBands, power_chart};
use crate::plots::{Chart, Ink};

/// Returns the chart of the spectrum of `name`.
pub(super) fn chart(name: &str, spectrum: &Spectrum) -> Chart {
    let (n_points, rows) = (spectrum.n_points(), Domain::power_by_radius(spectrum));
    let curve = PowerCurve::new("", n_points, &rows, f64::INFINITY, Ink::Rank(0));
    Chart {
        title: format!("Angular power spectrum of {name}, N = {n_points}"),
        ..power_chart(Domain::TEXTS, &[curve], Vec::new())
    }
}
