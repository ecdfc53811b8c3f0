/// A column as its file describes it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Column {
    /// Empty if it has no name.
    pub(super) name: String,
    /// The number of numbers in a row; 0 if they cannot be read as numbers.
    pub(super) items: usize,
    /// The unit where the file states it, empty otherwise.
    pub(super) unit: String,
}

impl Column {
    /// Returns a column of one number in a row.
    pub(super) fn single(name: impl Into<String>) -> Self {
        Self { name: name.into(), items: 1, unit: String::new() }
    }
}
