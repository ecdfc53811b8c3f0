use std::f64::consts::{PI, SQRT_2};

use glam::DVec3;
use num_complex::Complex;
use sphvar_sh::{Colatitude, LegendrePlan};

use super::DesignEquations;
use super::matrix::Matrix;
use crate::{Error, Progress};

/// The values and derivatives of the equations of a design at given points.
///
/// Equation (l, m) is `w_l sum_k Y_lm(s_k) = 0` for the real harmonics `Y_l0`, `sqrt 2 Re Y_lm` and
/// `sqrt 2 Im Y_lm`, m > 0. The weights `w_l = sqrt(4 pi/(N l(l + 1)))` make the rows of the
/// Jacobian of scattered points nearly orthonormal. The unknowns are the two components of a
/// rotation vector `omega_k` of each point, perpendicular to it: `s_k -> s_k + omega_k x s_k`.
///
/// Degrees above that of the design may be added with a smaller weight.
pub(super) struct Jacobian {
    plan: LegendrePlan,
    /// The degrees in ascending order, with the factors of their weights.
    degrees: Vec<(usize, f64)>,
    /// The index of the first equation of each degree; `None` for those that have none.
    first: Vec<Option<usize>>,
    n_equations: usize,
}

impl Jacobian {
    /// Returns the equations of a design and of the `n_more` next degrees, whose weights are
    /// multiplied by `factor`.
    ///
    /// # Errors
    ///
    /// [`Error::Degree`] if the degree is too large.
    pub(super) fn new(
        equations: DesignEquations,
        n_more: usize,
        factor: f64,
    ) -> Result<Self, Error> {
        let DesignEquations { degree, is_symmetric } = equations;
        let step = equations.domain().degree_step();
        let last = degree + n_more * step;
        let plan = LegendrePlan::new(last)
            .map_err(|error| Error::Degree { last, reason: error.to_string() })?;
        let mut first = vec![None; last + 1];
        let (mut degrees, mut n_equations) = (Vec::new(), 0);
        for l in (DesignEquations { degree: last, is_symmetric }).degrees() {
            first[l] = Some(n_equations);
            n_equations += 2 * l + 1;
            degrees.push((l, if l <= degree { 1.0 } else { factor }));
        }
        Ok(Self { plan, degrees, first, n_equations })
    }

    pub(super) fn n_equations(&self) -> usize {
        self.n_equations
    }

    /// Returns `w_l` of every degree.
    fn weights(&self, n_points: usize) -> Vec<f64> {
        let mut weights = vec![0.0; self.first.len()];
        for &(l, factor) in &self.degrees {
            weights[l] = factor * (4.0 * PI / (n_points * l * (l + 1)) as f64).sqrt();
        }
        weights
    }

    /// Returns the left sides of the equations.
    ///
    /// # Errors
    ///
    /// [`Error::Stopped`].
    pub(super) fn values(
        &self,
        points: &[DVec3],
        progress: &dyn Progress,
    ) -> Result<Vec<f64>, Error> {
        let mut values = vec![0.0; self.n_equations];
        let weights = self.weights(points.len());
        let mut harmonics = vec![Complex::default(); self.plan.index().len()];
        let mut lambda = vec![0.0; harmonics.len()];
        for (k, &point) in points.iter().enumerate() {
            if k.is_multiple_of(64) {
                progress.tick(0.0)?;
            }
            self.harmonics(point, &mut lambda, &mut harmonics);
            for &(l, _) in &self.degrees {
                let Some(first) = self.first[l] else { continue };
                for m in 0..=l {
                    add(
                        &mut values[first..],
                        m,
                        weights[l] * harmonics[self.plan.index().at(l, m)],
                    );
                }
            }
        }
        Ok(values)
    }

    /// Replaces `jacobian` by the derivatives, one row for each equation; columns 2k and 2k + 1 are
    /// the components of the rotation vector of point k along the axes that [`axes`] returns.
    ///
    /// # Errors
    ///
    /// [`Error::Stopped`].
    pub(super) fn derivatives(
        &self,
        points: &[DVec3],
        jacobian: &mut Matrix,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let weights = self.weights(points.len());
        let index = self.plan.index();
        let mut y = vec![Complex::default(); index.len()];
        let mut lambda = vec![0.0; y.len()];
        for (k, &point) in points.iter().enumerate() {
            if k.is_multiple_of(64) {
                progress.tick(0.0)?;
            }
            self.harmonics(point, &mut lambda, &mut y);
            let axes = axes(point);
            for &(l, _) in &self.degrees {
                let Some(first) = self.first[l] else { continue };
                for m in 0..=l {
                    let (degree, order) = (l as f64, m as f64);
                    let own = y[index.at(l, m)];
                    let above = if m < l { y[index.at(l, m + 1)] } else { Complex::default() };
                    // Y_l,-1 = -conj Y_l1.
                    let below =
                        if m > 0 { y[index.at(l, m - 1)] } else { -y[index.at(l, 1)].conj() };
                    // `x cross grad = i L`; `L_+- Y_lm = sqrt((l -+ m)(l +- m + 1)) Y_l,m+-1`
                    // (Edmonds 1957, eq. 2.3.1).
                    let raised = above * ((degree - order) * (degree + order + 1.0)).sqrt();
                    let lowered = below * ((degree + order) * (degree - order + 1.0)).sqrt();
                    let i = Complex::new(0.0, weights[l]);
                    let x_part = i * (raised + lowered) * 0.5;
                    let y_part = (raised - lowered) * (0.5 * weights[l]);
                    let z_part = i * own * order;
                    for (axis, column) in axes.iter().zip(2 * k..) {
                        let along = x_part * axis.x + y_part * axis.y + z_part * axis.z;
                        put(jacobian, first, m, column, along);
                    }
                }
            }
        }
        Ok(())
    }

    /// Replaces `harmonics` by `Y_lm` of a point, m >= 0.
    fn harmonics(&self, point: DVec3, lambda: &mut [f64], harmonics: &mut [Complex<f64>]) {
        let colatitude = Colatitude::from_direction(point);
        self.plan.eval_into(colatitude, lambda);
        let sin = colatitude.sin();
        // A pole has only functions of order 0, which have no longitude.
        let turn = if sin > 0.0 {
            Complex::new(point.x / sin, point.y / sin)
        } else {
            Complex::new(1.0, 0.0)
        };
        let mut phase = Complex::new(1.0, 0.0);
        for m in 0..=self.plan.lmax() {
            let column = self.plan.index().column(m);
            for (harmonic, value) in harmonics[column.clone()].iter_mut().zip(&lambda[column]) {
                *harmonic = phase * *value;
            }
            phase *= turn;
        }
    }

    /// Returns `sum_m |sum_k Y_lm|^2` by degree from 0, from the left sides of the equations.
    pub(super) fn squares(&self, values: &[f64], n_points: usize) -> Vec<f64> {
        let mut squares = vec![0.0; self.first.len()];
        let weights = self.weights(n_points);
        for &(l, _) in &self.degrees {
            let Some(first) = self.first[l] else { continue };
            let sum: f64 = values[first..][..2 * l + 1].iter().map(|v| v * v).sum();
            squares[l] = sum / (weights[l] * weights[l]);
        }
        squares
    }
}

/// Adds the real harmonics of order m to a degree's values.
fn add(values: &mut [f64], m: usize, harmonic: Complex<f64>) {
    if m == 0 {
        values[0] += harmonic.re;
    } else {
        values[2 * m - 1] += SQRT_2 * harmonic.re;
        values[2 * m] += SQRT_2 * harmonic.im;
    }
}

/// Stores the derivatives of the real harmonics of order m of the degree whose rows begin at
/// `first`.
fn put(jacobian: &mut Matrix, first: usize, m: usize, column: usize, derivative: Complex<f64>) {
    if m == 0 {
        jacobian.row_mut(first)[column] = derivative.re;
    } else {
        jacobian.row_mut(first + 2 * m - 1)[column] = SQRT_2 * derivative.re;
        jacobian.row_mut(first + 2 * m)[column] = SQRT_2 * derivative.im;
    }
}

/// Returns two orthonormal vectors that are perpendicular to a point.
pub(super) fn axes(point: DVec3) -> [DVec3; 2] {
    let (first, second) = point.any_orthonormal_pair();
    [first, second]
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sphvar_sh::real_ylm_at;

    use super::super::DesignEquations;
    use super::super::matrix::Matrix;
    use super::{Jacobian, axes};

    fn points() -> Vec<DVec3> {
        // Both poles, a point near one, the equator and points in general position.
        [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (1e-9, -2e-9, 1.0), (1.0, 0.0, 0.0), (-0.3, 0.4, 0.2)]
            .map(|(x, y, z)| DVec3::new(x, y, z).normalize())
            .into()
    }

    #[test]
    fn values_and_derivatives_match_their_definitions() {
        for is_symmetric in [false, true] {
            let equations = DesignEquations { degree: 6, is_symmetric };
            let jacobian = Jacobian::new(equations, 1, 0.25).unwrap();
            let points = points();
            let values = |points: &[DVec3]| {
                let mut values = Vec::new();
                let last = if is_symmetric { 8 } else { 7 };
                for l in 1..=last {
                    if is_symmetric && l % 2 == 1 {
                        continue;
                    }
                    let area = 4.0 * std::f64::consts::PI / points.len() as f64;
                    let weight = (area / (l * (l + 1)) as f64).sqrt();
                    let weight = if l > 6 { 0.25 * weight } else { weight };
                    let orders = (0..=i64::try_from(l).unwrap())
                        .flat_map(|m| if m == 0 { vec![0] } else { vec![m, -m] });
                    for m in orders {
                        let sum = |p: &DVec3| real_ylm_at(l, m, *p).unwrap();
                        values.push(weight * points.iter().map(sum).sum::<f64>());
                    }
                }
                values
            };
            let expected = values(&points);
            assert_eq!(jacobian.n_equations(), expected.len());
            let got = jacobian.values(&points, &()).unwrap();
            for (got, expected) in got.iter().zip(&expected) {
                assert!((got - expected).abs() < 1e-14, "{got}, {expected}");
            }
            let mut matrix = Matrix::zeros(expected.len(), 2 * points.len()).unwrap();
            jacobian.derivatives(&points, &mut matrix, &()).unwrap();
            for column in 0..2 * points.len() {
                const H: f64 = 1e-5;
                let omega = axes(points[column / 2])[column % 2];
                let at = |angle: f64| {
                    let mut moved = points.clone();
                    moved[column / 2] =
                        glam::DQuat::from_axis_angle(omega, angle) * moved[column / 2];
                    values(&moved)
                };
                for (i, (plus, minus)) in at(H).into_iter().zip(at(-H)).enumerate() {
                    let slope = (plus - minus) / (2.0 * H);
                    // Third derivatives are about l^2 times the first.
                    let got = matrix.row(i)[column];
                    assert!((got - slope).abs() < 1e-7, "{i}, {column}: {got}, {slope}");
                }
            }
        }
    }
}
