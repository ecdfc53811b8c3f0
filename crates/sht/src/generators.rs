use glam::DVec3;
use num_complex::Complex;
use sphvar_sh::Alm;

/// The coefficients of the three components of `x cross grad f`, the derivatives of f with respect
/// to rotations of the points about the x, y and z axes. They are functions of the same degree as
/// f, and no axis is singled out.
#[derive(Clone, Debug)]
pub(crate) struct RotationDerivatives([Alm; 3]);

impl RotationDerivatives {
    /// Returns the derivatives of the function with coefficients `alm`, reusing the memory of
    /// earlier ones.
    ///
    /// With the angular momentum operators `x cross grad = i L` and `L_z Y_lm = m Y_lm`; see
    /// [`ladder`].
    pub(crate) fn of(alm: &Alm, memory: Option<Self>) -> Self {
        let memory = memory.filter(|old| old.0[0].lmax() == alm.lmax());
        let mut derivatives = memory.unwrap_or_else(|| Self(std::array::from_fn(|_| alm.clone())));
        let [x, y, z] = &mut derivatives.0;
        for m in 0..=alm.lmax() {
            for (k, &a) in alm.column(m).iter().enumerate() {
                let (raised, lowered) = ladder(alm, m, k);
                x.column_mut(m)[k] = I * (raised + lowered) * 0.5;
                y.column_mut(m)[k] = (raised - lowered) * 0.5;
                z.column_mut(m)[k] = I * a * m as f64;
            }
        }
        derivatives
    }

    /// Returns the function itself followed by its three derivatives.
    pub(crate) fn functions<'a>(&'a self, alm: &'a Alm) -> [&'a Alm; 4] {
        let [x, y, z] = &self.0;
        [alm, x, y, z]
    }
}

const I: Complex<f64> = Complex::new(0.0, 1.0);

/// Returns the coefficients of degree m + k and order m of `L_+ f` and `L_- f`,
/// `L_+- Y_lm = sqrt((l -+ m)(l +- m + 1)) Y_l,m+-1` (Edmonds 1957, eq. 2.3.1).
fn ladder(alm: &Alm, m: usize, k: usize) -> (Complex<f64>, Complex<f64>) {
    let lower = if m > 0 { alm.column(m - 1) } else { &[] };
    let upper = if m < alm.lmax() { alm.column(m + 1) } else { &[] };
    let (l, order) = ((m + k) as f64, m as f64);
    let above = k.checked_sub(1).and_then(|k| upper.get(k)).copied();
    let above = above.unwrap_or_default();
    // a_l,-1 = -conj a_l1.
    let below = lower.get(k + 1).copied().unwrap_or_else(|| -above.conj());
    let raised = below * ((l - order + 1.0) * (l + order)).sqrt();
    let lowered = above * ((l + order + 1.0) * (l - order)).sqrt();
    (raised, lowered)
}

/// Writes the components of `x cross v`, whose product with the rotation derivatives of a function
/// at a point x is that of its gradient with v.
pub(crate) fn moments_into(points: &[DVec3], vectors: &[DVec3], moments: &mut [Vec<f64>; 3]) {
    for (axis, moments) in moments.iter_mut().enumerate() {
        moments.clear();
        moments.extend(points.iter().zip(vectors).map(|(x, v)| x.cross(*v)[axis]));
    }
}

/// Writes the adjoint of the gradient from the coefficients of the three components of
/// [`moments_into`]: rotation derivatives are antisymmetric, so minus the sum of those derivatives
/// of the three functions, each about its own axis.
pub(crate) fn gradient_adjoint(components: &[Alm; 3], out: &mut Alm) {
    let [x, y, z] = components;
    for m in 0..=out.lmax() {
        for k in 0..out.column(m).len() {
            let ((raised_x, lowered_x), (raised_y, lowered_y)) = (ladder(x, m, k), ladder(y, m, k));
            let about_x = I * (raised_x + lowered_x) * 0.5;
            let about_y = (raised_y - lowered_y) * 0.5;
            let about_z = I * z.column(m)[k] * m as f64;
            out.column_mut(m)[k] = -(about_x + about_y + about_z);
        }
    }
}

/// Computes values and tangent gradients from the values of a function and its rotation
/// derivatives, given point by point.
///
/// # Panics
///
/// Panics if `values` or `gradients` differ from `points` in length.
pub(crate) fn tangent_gradients(
    functions: &[f64],
    points: &[DVec3],
    values: &mut [f64],
    gradients: &mut [DVec3],
) {
    assert_eq!(values.len(), points.len(), "one value per point");
    assert_eq!(gradients.len(), points.len(), "one gradient per point");
    let places = values.iter_mut().zip(gradients).zip(points);
    for (((value, gradient), point), [f, x, y, z]) in places.zip(functions.as_chunks::<4>().0) {
        *value = *f;
        // (x cross grad f) cross x = grad f for a tangent gradient.
        *gradient = DVec3::new(*x, *y, *z).cross(*point);
    }
}
