/// Where finished pieces of work are kept, so that they need not be done again.
pub trait Store: Sync {
    /// The bytes that were kept under `key`; `None` if there are none, or none that can be trusted.
    fn load(&self, key: &str) -> Option<Vec<u8>>;

    /// Keeps bytes under `key`: whole or not at all, whatever happens.
    ///
    /// # Errors
    ///
    /// What is wrong, in words.
    fn save(&self, key: &str, bytes: &[u8]) -> Result<(), String>;
}

/// Keeps nothing.
#[derive(Clone, Copy, Debug)]
pub struct Nothing;

impl Store for Nothing {
    fn load(&self, _: &str) -> Option<Vec<u8>> {
        None
    }

    fn save(&self, _: &str, _: &[u8]) -> Result<(), String> {
        Ok(())
    }
}
