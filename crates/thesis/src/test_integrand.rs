use sphvar_integrands::{Cap, Harmonic, Integrand};

use crate::Error;

/// The two functions that the thesis integrates over the sphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TestIntegrand {
    /// The harmonic of degree 4 and order 0, orthonormal: the best case.
    Harmonic,
    /// 1 within 60 degrees of the pole, else 0: the worst case.
    Cap,
}

impl TestIntegrand {
    /// Both, in the order of [`Results::trials`](crate::Results::trials).
    pub const ALL: [Self; 2] = [Self::Harmonic, Self::Cap];

    /// Returns the text for headings.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Harmonic => "harmonic Y(4,0)",
            Self::Cap => "cap of 60 degrees",
        }
    }

    /// Returns the function.
    ///
    /// # Errors
    ///
    /// [`Error::Variance`], although the parameters are valid.
    pub fn function(self) -> Result<Box<dyn Integrand>, Error> {
        Ok(match self {
            Self::Harmonic => Box::new(Harmonic::new(4, 0)?),
            Self::Cap => Box::new(Cap::from_degrees(60.0)?),
        })
    }
}
