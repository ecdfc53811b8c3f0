use glam::DVec3;

use crate::{Error, Integrand};

/// Several real functions of direction that are evaluated on the same directions, such as the
/// channels of a picture.
///
/// A vector of integrands, owned or borrowed, is one, with a component for each; a vector of vector integrands has the
/// components of all of them, one after another.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_integrands::{Integrand, VectorIntegrand};
///
/// let (mean, square) = (|d: DVec3| d.z, |d: DVec3| d.z * d.z);
/// let moments: Vec<&dyn Integrand> = vec![&mean, &square];
/// let mut values = [0.0; 4];
/// moments.eval_into(&[DVec3::X, DVec3::NEG_Z], &mut values)?;
/// assert_eq!(values, [0.0, 0.0, -1.0, 1.0]);
/// # Ok::<(), sphvar_integrands::Error>(())
/// ```
pub trait VectorIntegrand: Sync {
    /// Returns the number of components.
    fn components(&self) -> usize;

    /// Writes `values[i * components + c]`, the value of component c at direction i.
    ///
    /// # Errors
    ///
    /// [`Error::Evaluation`] if values are unavailable.
    ///
    /// # Panics
    ///
    /// May panic unless `values` has `components` values for each direction.
    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error>;
}

impl VectorIntegrand for Vec<&dyn Integrand> {
    fn components(&self) -> usize {
        self.len()
    }

    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        eval_each(self.iter().copied(), dirs, values)
    }
}

impl VectorIntegrand for Vec<Box<dyn Integrand>> {
    fn components(&self) -> usize {
        self.len()
    }

    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        eval_each(self.iter().map(|integrand| &**integrand), dirs, values)
    }
}

fn eval_each<'a>(
    integrands: impl ExactSizeIterator<Item = &'a dyn Integrand>,
    dirs: &[DVec3],
    values: &mut [f64],
) -> Result<(), Error> {
    let width = integrands.len();
    let mut of_one = vec![0.0; dirs.len()];
    for (c, integrand) in integrands.enumerate() {
        integrand.eval_into(dirs, &mut of_one)?;
        for (row, value) in values.chunks_exact_mut(width).zip(&of_one) {
            row[c] = *value;
        }
    }
    Ok(())
}

impl VectorIntegrand for Vec<&dyn VectorIntegrand> {
    fn components(&self) -> usize {
        self.iter().map(|part| part.components()).sum()
    }

    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        let (width, mut first) = (self.components(), 0);
        for part in self {
            let own = part.components();
            let mut of_part = vec![0.0; own * dirs.len()];
            part.eval_into(dirs, &mut of_part)?;
            if own > 0 {
                let rows = values.chunks_exact_mut(width).zip(of_part.chunks_exact(own));
                rows.for_each(|(row, of_part)| row[first..first + own].copy_from_slice(of_part));
            }
            first += own;
        }
        Ok(())
    }
}
