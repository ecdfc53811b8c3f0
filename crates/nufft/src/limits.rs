/// The minimum accuracy parameter epsilon, limited by rounding.
pub const MIN_EPSILON: f64 = 1e-13;

/// The maximum accuracy parameter epsilon.
pub const MAX_EPSILON: f64 = 1e-1;

/// The maximum frequency of a transform; its grid has up to 50000 x 50000 numbers.
pub const MAX_KMAX: usize = 10_000;

/// The maximum frequency of a transform on the circle; its grid has up to 5 million numbers.
pub const MAX_CIRCLE_KMAX: usize = 1 << 20;
