//! The figures of section 4.1: point sets of the unit square and their power spectra.

mod disk_realizations;
mod low_discrepancy;
mod mean_spectra;
mod panels;
mod peaks;
mod radial_means;
mod wrapped_disks;

pub(crate) use disk_realizations::DiskRealizations;
pub(crate) use low_discrepancy::LowDiscrepancy;
pub(crate) use mean_spectra::MeanSpectra;
pub(crate) use peaks::Peaks;
pub(crate) use radial_means::RadialMeans;
pub(crate) use wrapped_disks::WrappedDisks;
