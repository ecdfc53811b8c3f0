/// The smallest accuracy that can be requested: rounding leaves no better one.
pub const MIN_EPSILON: f64 = 1e-13;

/// The largest accuracy that can be requested.
pub const MAX_EPSILON: f64 = 1e-1;

/// The largest frequency of a transform: its grid has up to 50000 x 50000 numbers.
pub const MAX_KMAX: usize = 10_000;
