use crate::{Expression, Term};

impl Term {
    /// Returns the integrand to which a filter is applied.
    pub(crate) fn filtered(&self) -> Option<&Expression> {
        match self {
            Self::Filtered(filtered) => Some(&filtered.of),
            _ => None,
        }
    }
}
