use sphvar_sh::{Bands, ByAxis, Frequencies};

use crate::energy::{check_size, norm};
use crate::{Energy, Error};

/// Returns the energies of a function with a given mean, variances of its three parts
/// ([`SquareIntegrand::energy`](crate::SquareIntegrand::energy)) and squared moduli `|G_k|^2` of its
/// coefficients at k other than 0.
///
/// # Errors
///
/// [`Error::Harmonics`] if memory is exhausted.
pub(super) fn energy_of_coefficients(
    frequencies: &Frequencies,
    mean: f64,
    centred: ByAxis,
    mut square: impl FnMut([i32; 2]) -> f64,
) -> Result<Energy<Frequencies>, Error> {
    let mut per_band = zeros(frequencies.len())?;
    per_band[0] = mean * mean;
    for (band, energy) in per_band.iter_mut().enumerate().skip(1) {
        *energy = frequencies.multiplicity(band) * square(frequencies.frequency(band));
    }
    Ok(Energy::new(frequencies.clone(), per_band, centred))
}

/// Returns zeros, or an error if memory is exhausted.
pub(super) fn zeros<T: Clone + Default>(len: usize) -> Result<Vec<T>, Error> {
    let mut values = Vec::new();
    values
        .try_reserve_exact(len)
        .map_err(|_| sphvar_sh::Error::OutOfMemory { len, bytes_each: size_of::<T>() })?;
    values.resize(len, T::default());
    Ok(values)
}

/// Subtracts from at least one value the mean, of which `mean` is the formula, and returns it.
///
/// The sum of many values far from 0 loses their deviations, so the mean of differences from one of
/// them is taken, and corrected once. Equal values become exactly 0.
pub(super) fn centre(values: &mut [f64], mean: impl Fn(&[f64]) -> f64) -> f64 {
    let first = values[0];
    values.iter_mut().for_each(|x| *x -= first);
    let mut rest = 0.0;
    for _ in 0..2 {
        let of_differences = mean(values);
        values.iter_mut().for_each(|x| *x -= of_differences);
        rest += of_differences;
    }
    first + rest
}

/// Checks that the squares of values neither overflow nor underflow.
///
/// # Errors
///
/// [`Error::Magnitude`] if their root mean square is out of range.
pub(super) fn check_values(values: &[f64]) -> Result<(), Error> {
    check_size(norm(values.iter().copied()) / (values.len() as f64).sqrt())
}
