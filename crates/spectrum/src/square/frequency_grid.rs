use sphvar_sh::Frequencies;

/// Returns values per frequency as a square grid, for heat maps.
///
/// `per_band` has one value for each band, such as [`Spectrum::power`](crate::Spectrum::power). The
/// grid has `2 half + 1` rows from k2 = half to -half, each with the frequencies k1 = -half to half,
/// and values of k also at -k. The frequency 0 and those without a value are NaN.
///
/// # Examples
///
/// ```
/// use sphvar_sh::{Bands, Frequencies};
/// use sphvar_spectrum::frequency_grid;
///
/// let bands = Frequencies::new(1)?;
/// let norms: Vec<f64> = (0..bands.len()).map(|band| bands.radius(band)).collect();
/// let grid = frequency_grid(&bands, &norms, 1);
/// assert!(grid[0].is_nan() && grid[4].is_nan());
/// assert_eq!([grid[1], grid[3], grid[5], grid[7]], [1.0; 4]);
/// # Ok::<(), sphvar_sh::Error>(())
/// ```
#[must_use]
pub fn frequency_grid(frequencies: &Frequencies, per_band: &[f64], half: usize) -> Vec<f64> {
    let side = 2 * half + 1;
    let mut grid = vec![f64::NAN; side * side];
    for (band, value) in per_band.iter().enumerate().take(frequencies.len()).skip(1) {
        let [k1, k2] = frequencies.frequency(band);
        for [k1, k2] in [[k1, k2], [-k1, -k2]] {
            let place = |k: i32| half.checked_add_signed(isize::try_from(k).ok()?);
            if let (Some(column), Some(row)) = (place(k1), place(-k2))
                && column < side
                && row < side
            {
                grid[row * side + column] = *value;
            }
        }
    }
    grid
}

#[cfg(test)]
mod tests {
    use sphvar_sh::Frequencies;

    use super::frequency_grid;

    /// Compares with a search for every cell.
    #[test]
    fn cells_have_the_values_of_their_frequencies() {
        for (kmax, axis_max, half) in [(5, 5, 5), (5, 9, 7), (5, 5, 2), (0, 0, 3), (3, 3, 0)] {
            let bands = Frequencies::new(kmax).unwrap().with_axes(axis_max).unwrap();
            let values: Vec<f64> = (0..bands.len()).map(|band| band as f64).collect();
            let grid = frequency_grid(&bands, &values, half);
            let side = 2 * half + 1;
            assert_eq!(grid.len(), side * side);
            for (i, value) in grid.iter().enumerate() {
                let at = |i: usize| i32::try_from(i).unwrap() - i32::try_from(half).unwrap();
                let k = [at(i % side), -at(i / side)];
                let expected = bands.band_of(k).filter(|band| *band > 0);
                let got = value.is_finite().then_some(*value);
                assert_eq!(got, expected.map(|band| band as f64), "{kmax} {axis_max} {k:?}");
            }
        }
    }
}
