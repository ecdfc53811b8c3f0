/// The shape of the rise of a [`Profile`](crate::Profile) to its plateau.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ProfileShape {
    /// The plateau from the first degree on; `alpha` is only the unit of the axis.
    Constant,
    /// Zero below the break, the plateau from the break on.
    Step,
    /// The power `exponent >= 0` of `l / (alpha sqrt N)` below the break.
    Polynomial {
        /// The power `b`; 1 is the linear profile, 2 the quadratic one, 0 the constant one.
        exponent: f64,
    },
}
