//! Checks that need several crates.

mod bounds;
mod choice;
mod determinism;
mod hemisphere;
mod homogeneity;
mod homogeneity_audit;
mod identities;
mod low_degree_power;
mod pictures;
mod policy;
mod random_fields;
mod samplers;
mod sequences;
mod spectra;
mod spectral_control;
mod square;
mod theory_errata;
mod theory_references;
mod unbiasedness;
mod variance;
mod warped;
