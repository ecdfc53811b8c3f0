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
    /// With the angular momentum operators `x cross grad = i L`, `L_z Y_lm = m Y_lm` and
    /// `L_+- Y_lm = sqrt((l -+ m)(l +- m + 1)) Y_l,m+-1` (Edmonds 1957, eq. 2.3.1).
    pub(crate) fn of(alm: &Alm, memory: Option<Self>) -> Self {
        let memory = memory.filter(|old| old.0[0].lmax() == alm.lmax());
        let mut derivatives = memory.unwrap_or_else(|| Self(std::array::from_fn(|_| alm.clone())));
        let [x, y, z] = &mut derivatives.0;
        let i = Complex::new(0.0, 1.0);
        for m in 0..=alm.lmax() {
            let own = alm.column(m);
            let lower = if m > 0 { alm.column(m - 1) } else { &[] };
            let upper = if m < alm.lmax() { alm.column(m + 1) } else { &[] };
            for (k, &a) in own.iter().enumerate() {
                let (l, order) = ((m + k) as f64, m as f64);
                let above = k.checked_sub(1).and_then(|k| upper.get(k)).copied();
                let above = above.unwrap_or_default();
                // a_l,-1 = -conj a_l1.
                let below = lower.get(k + 1).copied().unwrap_or_else(|| -above.conj());
                let raised = below * ((l - order + 1.0) * (l + order)).sqrt();
                let lowered = above * ((l + order + 1.0) * (l - order)).sqrt();
                x.column_mut(m)[k] = i * (raised + lowered) * 0.5;
                y.column_mut(m)[k] = (raised - lowered) * 0.5;
                z.column_mut(m)[k] = i * a * order;
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
