use std::fmt;
use std::sync::Arc;

/// The error of a reader of files named in a specification.
#[derive(Clone, Debug)]
pub struct ResolveError(Arc<dyn std::error::Error + Send + Sync>);

impl ResolveError {
    /// Wraps an error of a reader.
    pub fn new(error: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Self {
        Self(Arc::from(error.into()))
    }

    /// Returns the wrapped error, if it is an `E`.
    #[must_use]
    pub fn downcast_ref<E: std::error::Error + 'static>(&self) -> Option<&E> {
        self.0.downcast_ref()
    }
}

impl fmt::Display for ResolveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl std::error::Error for ResolveError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.0.source()
    }
}

/// Errors are equal if their messages are equal.
impl PartialEq for ResolveError {
    fn eq(&self, other: &Self) -> bool {
        self.to_string() == other.to_string()
    }
}
