//! Disks that keep a minimum distance, on any domain divided into cells: random sequential
//! addition, and the region that disks leave free.

mod decreasing;
mod free_arcs;
mod free_region;
mod poisson_count;
mod sequential_addition;
mod subdivision;

pub(crate) use decreasing::decreasing_into;
pub(crate) use free_arcs::FreeArcs;
pub(crate) use free_region::FreeRegion;
pub(crate) use sequential_addition::{End, SequentialAddition, attempts, exact_into};
pub(crate) use subdivision::Subdivision;
