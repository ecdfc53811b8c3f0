use crate::error::Error;

/// Resizes `values`, or returns an error if allocation fails.
pub(crate) fn resize<T: Clone + Default>(values: &mut Vec<T>, len: usize) -> Result<(), Error> {
    let missing = len.saturating_sub(values.len());
    values
        .try_reserve_exact(missing)
        .map_err(|_| Error::OutOfMemory { len, bytes_each: size_of::<T>() })?;
    values.resize(len, T::default());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::resize;
    use crate::error::Error;

    #[test]
    fn a_failed_allocation_is_an_error() {
        let mut values = vec![1_u16; 3];
        resize(&mut values, 5).unwrap();
        assert_eq!(values, [1, 1, 1, 0, 0]);
        let error = resize(&mut values, usize::MAX).unwrap_err();
        assert_eq!(error, Error::OutOfMemory { len: usize::MAX, bytes_each: 2 });
        assert_eq!(values.len(), 5);
    }
}
