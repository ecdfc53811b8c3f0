/// The reason why an integrand cannot be built or its energy is unavailable.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter is outside its range.
    #[error("{name} must be {range}, got {got}")]
    Parameter {
        /// The parameter.
        name: &'static str,
        /// Its valid values in words.
        range: &'static str,
        /// The value given.
        got: f64,
    },
    /// The order of a harmonic exceeds its degree.
    #[error("the order must satisfy |m| <= l, got l = {l}, m = {m}")]
    Order {
        /// The degree.
        l: usize,
        /// The order.
        m: i64,
    },
    /// A coefficient of a real function is not finite, or not real for m = 0.
    #[error(
        "the coefficient l = {l}, m = {m} is {re} + {im} i; those of a real function are finite, and real \
         for m = 0"
    )]
    Coefficient {
        /// The degree.
        l: usize,
        /// The order.
        m: usize,
        /// Its real part.
        re: f64,
        /// Its imaginary part.
        im: f64,
    },
    /// An energy is negative or not finite.
    #[error("the energy of degree {l} must be finite and not negative, got {got}")]
    Energy {
        /// The degree.
        l: usize,
        /// The energy.
        got: f64,
    },
    /// The energy per degree of the integrand is unknown.
    #[error("the energy per degree of this integrand is not known: {reason}")]
    NoEnergy {
        /// Why.
        reason: &'static str,
    },
    /// The integrand cannot be evaluated.
    #[error("the integrand cannot be evaluated: {reason}")]
    Evaluation {
        /// Why.
        reason: String,
    },
    /// The values of an integrand are too large or too small for variances, which scale as their
    /// squares.
    #[error(
        "the root mean square of the integrand must be between 1e-151 and 1e151, got {got:e} \
         (values of about 1e-150 to 1e150)"
    )]
    Magnitude {
        /// The root mean square.
        got: f64,
    },
    /// A quaternion does not represent a rotation.
    #[error(
        "a rotation needs finite angles or a quaternion of positive length, got length {length}"
    )]
    Rotation {
        /// Length of the quaternion.
        length: f64,
    },
    /// The weight of a term is infinite, NaN or out of the usable range.
    #[error("a weight must be 0 or between 1e-150 and 1e150 in magnitude, got {got:e}")]
    Weight {
        /// The weight.
        got: f64,
    },
    /// The number of values of a HEALPix map does not match its nside.
    #[error("a HEALPix map of nside {nside} has {expected} pixels, got {got} values")]
    PixelCount {
        /// Pixels along the edge of a base pixel.
        nside: u32,
        /// `12 nside^2`.
        expected: u64,
        /// Values given.
        got: usize,
    },
    /// Pixels of a HEALPix map have no value.
    #[error(
        "{count} pixels of the map have no value (NaN, infinite or UNSEEN = -1.6375e30), the first is \
         {first} in its order; fill them: an integral requires all pixels"
    )]
    Pixels {
        /// The number of pixels without a value.
        count: usize,
        /// The first, 0-based in the order of the values.
        first: usize,
    },
    /// The width of an environment map is not twice its height.
    #[error("an environment map must be 2:1 (width = 2 height), got {width} x {height}")]
    Shape {
        /// Texels in a row.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// An octahedral map is not square.
    #[error("an octahedral map must be square (width = height), got {width} x {height}")]
    Square {
        /// Texels in a row.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// The number of texels of an environment map does not match its size.
    #[error("a map of {width} x {height} has {} texels, got {got}", width.saturating_mul(*height))]
    TexelCount {
        /// Texels in a row.
        width: usize,
        /// Rows.
        height: usize,
        /// Texels given.
        got: usize,
    },
    /// A texel of an environment map is infinite or NaN.
    #[error("texel (row {row}, column {column}) is {value}; every texel must be finite")]
    Texel {
        /// Row from the top, 0-based.
        row: usize,
        /// Column from the left, 0-based.
        column: usize,
        /// Its value.
        value: f64,
    },
    /// A specification that names an unknown integrand or parameter, or a value out of range.
    #[error(transparent)]
    Grammar(#[from] sphvar_grammar::Error),
    /// A file named in an integrand specification cannot be read.
    #[error(transparent)]
    File(#[from] sphvar_grammar::ResolveError),
    /// A part of an expression cannot be built.
    #[error("{text}: {reason}")]
    OfTerm {
        /// The part.
        text: String,
        /// Why.
        reason: Box<Self>,
    },
    /// An operator of an expression lacks an operand.
    #[error("\"{text}\": an operator has no operand on one side")]
    NoOperand {
        /// The expression.
        text: String,
    },
    /// The rotation of an expression is malformed.
    #[error("@ requires THETA/PHI or THETA/PHI/PSI in degrees, THETA in [0, 180], got \"{text}\"")]
    Angles {
        /// The angles.
        text: String,
    },
    /// A product of an expression has too many factors.
    #[error("a product has at most {max} integrands; this one has more")]
    TooManyFactors {
        /// The largest number.
        max: usize,
    },
    /// A density is 0 where the integrand is not.
    #[error(
        "the density is 0 where the integrand is not: at theta = {theta:.1}, phi = {phi:.1} degrees; \
         {} % of the integral of |f| is lost; add a warp that is positive there, as in \
         \"0.9 * cosine + 0.1 * cylinder\", or for a map use floor=0.1",
        percent(*share)
    )]
    ZeroDensity {
        /// The colatitude of a direction that no point reaches, in degrees.
        theta: f64,
        /// Its longitude in degrees, in [0, 360).
        phi: f64,
        /// The share of `int |f|` in such directions.
        share: f64,
    },
    /// The shares of the warps in a sum are not positive numbers, or only some warps have one.
    #[error("\"{text}\": {reason}")]
    Shares {
        /// The sum.
        text: String,
        /// What is wrong, and the valid form.
        reason: String,
    },
    /// A product of warps has no warp.
    #[error(
        "no map samples the product {text}; a product of warps must be a map times the cosine, as in \
         \"env:FILE * cosine\" (a sum, as in \"cosine + env:FILE\", samples each with its own points)"
    )]
    NoWarp {
        /// The product.
        text: String,
    },
    /// A map and the cosine of a product have different axes.
    #[error(
        "the cosine of {text} must be about the pole of the map: rotate both alike, and the map \
         further about its pole alone"
    )]
    CosineAxis {
        /// The product.
        text: String,
    },
    /// A warp cannot be built.
    #[error(transparent)]
    Warp(#[from] sphvar_warps::Error),
    /// A harmonic evaluation or transform rejected its input.
    #[error(transparent)]
    Harmonics(#[from] sphvar_sh::Error),
}

/// Returns a share in percent, with two digits where it is small.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent < 0.01 { format!("{percent:.1e}") } else { format!("{percent:.2}") }
}
