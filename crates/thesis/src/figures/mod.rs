//! The figures, one file each.

mod basis_functions;
mod bound_claims;
mod bounded_column;
mod bounded_variance;
mod box_study;
mod cap_power;
mod coefficient_clouds;
mod cornell_box;
mod crossover_claim;
mod direct_light;
mod disk_placement;
mod disk_points;
#[cfg(test)]
mod fast_tests;
mod integrand_classes;
mod lattice_artifacts;
mod lattice_spectra;
mod low_frequencies;
mod mass_points;
mod noise_colours;
mod open_hemisphere;
mod order_grid;
#[cfg(test)]
mod pattern_tests;
mod patterns;
mod plane;
mod point_panel;
mod profile_rates;
mod profiles;
mod radial_average;
mod rotated_lattices;
mod sampler_spectra;
mod significance;
mod spectra;
mod spectra_product;
mod square_patterns;
mod strata;
mod tessellation;
#[cfg(test)]
mod tests;
mod variance_comparison;
mod variance_study;
mod white_noise_orders;
mod zone_plate;

use crate::{Error, Figure, Job, Results, Setting};
use cornell_box::{CornellBoxes, ReferenceImage};
use profiles::ProfileShapes;
use rotated_lattices::RotatedLattice;
use zone_plate::ZonePlates;

/// The recipe of a figure: the jobs that it requires, and its panels and claims.
pub(crate) trait Recipe: Sync {
    /// Returns a short title of the figure.
    fn title(&self) -> &'static str;

    /// Returns the jobs that the figure requires.
    fn jobs(&self, setting: Setting) -> Vec<Job>;

    /// Fills the figure.
    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error>;
}

/// Every figure by its number, in the thesis's order.
pub(crate) const ALL: [(&str, &dyn Recipe); 34] = [
    ("2.2", &radial_average::RadialAverage),
    ("3.1", &basis_functions::BasisFunctions),
    ("4.1", &ZonePlates::Test),
    ("4.2", &plane::Peaks),
    ("4.3", &plane::WrappedDisks),
    ("4.4", &plane::DiskRealizations),
    ("4.5", &plane::MeanSpectra),
    ("4.6", &plane::RadialMeans),
    ("4.7", &plane::LowDiscrepancy),
    ("4.8", &ZonePlates::Patterns),
    ("4.9", &white_noise_orders::WhiteNoiseOrders),
    ("4.10", &lattice_spectra::LatticeSpectra),
    ("4.11", &RotatedLattice::HEALPIX),
    ("4.12", &RotatedLattice::FIBONACCI),
    ("4.13", &direct_light::DirectLight),
    ("4.14", &sampler_spectra::SamplerSpectra),
    ("4.15", &open_hemisphere::OpenHemisphere),
    ("4.16", &RotatedLattice::HEMISPHERICAL_FIBONACCI),
    ("4.17", &coefficient_clouds::CoefficientClouds),
    ("5.1", &spectra_product::SpectraProduct),
    ("6.1", &integrand_classes::IntegrandClasses),
    ("6.2", &ProfileShapes::Step),
    ("6.3", &ProfileShapes::Quadratic),
    ("7.1", &strata::Strata),
    ("7.2", &disk_points::DiskPoints),
    ("7.3", &tessellation::TessellationSites),
    ("7.4", &bounded_variance::BoundedVariance),
    ("7.5", &CornellBoxes::RANDOM),
    ("7.6", &CornellBoxes::EVEN),
    ("7.7", &ReferenceImage),
    ("7.8", &lattice_artifacts::LatticeArtifacts),
    ("7.9", &variance_comparison::VarianceComparison),
    ("7.10", &low_frequencies::LowFrequencies),
    ("C.1", &cap_power::CapPower),
];
