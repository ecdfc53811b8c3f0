//! Optimization of point sets: the descent method, the energies it minimizes, and exact Voronoi
//! cells.

mod covering_radius;
mod descent;
pub(crate) mod design;
mod long_waves;
mod riesz_energy;
mod spectral_control;
mod square_spectral_control;
mod transforms;
pub(crate) mod voronoi;

pub use covering_radius::covering_radius;
pub(crate) use long_waves::remove_long_waves;
pub(crate) use riesz_energy::RieszEnergy;
pub use riesz_energy::riesz_energy;
pub use spectral_control::{
    NoiseColour, PowerProfile, SinglePeak, SpectralControl, SpectralTarget,
};
pub use square_spectral_control::SquareSpectralControl;
