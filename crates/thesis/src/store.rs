/// Storage for finished pieces of work, so that they need not be recomputed.
pub trait Store: Sync {
    /// Returns the bytes stored under `key`; `None` if there are none or they are not intact.
    fn load(&self, key: &str) -> Option<Vec<u8>>;

    /// Stores bytes under `key` atomically.
    ///
    /// # Errors
    ///
    /// A description of the failure.
    fn save(&self, key: &str, bytes: &[u8]) -> Result<(), String>;
}

/// A store that discards everything.
#[derive(Clone, Copy, Debug)]
pub struct NoStore;

impl Store for NoStore {
    fn load(&self, _: &str) -> Option<Vec<u8>> {
        None
    }

    fn save(&self, _: &str, _: &[u8]) -> Result<(), String> {
        Ok(())
    }
}
