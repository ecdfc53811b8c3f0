use crate::error::Error;

/// Resizes `values` with default values.
///
/// # Errors
///
/// [`Error::OutOfMemory`] if allocation fails; `values` is then as before.
pub fn resize<T: Clone + Default>(values: &mut Vec<T>, len: usize) -> Result<(), Error> {
    let missing = len.saturating_sub(values.len());
    values
        .try_reserve_exact(missing)
        .map_err(|_| Error::OutOfMemory { len, bytes_each: size_of::<T>() })?;
    values.resize(len, T::default());
    Ok(())
}
