//! Shared statistics of the cross-crate checks.
