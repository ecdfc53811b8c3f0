//! Capacity-constrained Voronoi tessellations of any space with mass points: the exchanges of mass
//! points between sites.

mod division;
mod lanes;
mod mass_space;
mod relaxation;
mod settled;
mod site_tree;
mod sizes;

#[cfg(test)]
pub(crate) use division::divide;
pub(crate) use lanes::{LANES, largest};
pub(crate) use mass_space::{MassSpace, Moments};
pub(crate) use relaxation::{MAX_PASSES, Relaxation, relax, settle};
pub use settled::Tessellation;
pub(crate) use sizes::{check_memory, check_sizes, nominal_work, work_per_pass};
