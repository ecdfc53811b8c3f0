//! Patterns against their definitions.

mod ccvt;
mod ccvt_square;
mod designs;
mod disk_placements;
mod dpp;
mod leja;
mod point_files;
mod poisson_disk;
mod poisson_disk_square;
mod progress;
mod registry;
mod rotations;
mod rules;
mod scrambling;
mod sequences;
mod spectral_control;
mod spectral_targets;
mod sphere_maps;
mod square;
mod square_patterns;
mod square_spectral_control;
mod survey;
mod tiled_disks;
mod zonal;
