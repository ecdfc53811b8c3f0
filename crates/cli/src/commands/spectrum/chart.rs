//! The chart of one spectrum.

use sphvar_spectrum::Spectrum;

use crate::commands::power_chart::{PowerCurve, power_chart};
use crate::plots::{Chart, Ink};

/// Returns the chart of the spectrum of `name`.
pub(super) fn chart(name: &str, spectrum: &Spectrum) -> Chart {
    let curve = PowerCurve::new("", spectrum, f64::INFINITY, Ink::Rank(0));
    Chart {
        title: format!("Angular power spectrum of {name}, N = {}", spectrum.n_points()),
        ..power_chart::<sphvar_samplers::Domain>(&[curve], Vec::new())
    }
}
