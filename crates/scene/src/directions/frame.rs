use glam::{DMat3, DVec3};

/// Returns the rotation that maps +z to the unit vector `normal`.
///
/// It has no branch at a pole and is continuous except at z = 0, where it jumps (Duff et al.,
/// Building an Orthonormal Basis, Revisited, JCGT 6(1), 2017).
pub(crate) fn frame(normal: DVec3) -> DMat3 {
    let sign = 1f64.copysign(normal.z);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    DMat3::from_cols(
        DVec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        DVec3::new(b, sign + normal.y * normal.y * a, -normal.y),
        normal,
    )
}

#[cfg(test)]
mod tests {
    use super::{DMat3, DVec3, frame};

    #[test]
    fn frames_are_rotations() {
        let tiny = DVec3::new(1e-9, -1e-12, -1.0).normalize();
        for n in [DVec3::Z, -DVec3::Z, DVec3::X, -DVec3::Y, DVec3::ONE.normalize(), tiny] {
            let f = frame(n);
            assert_eq!(f * DVec3::Z, n);
            // Each entry is a sum of two products of numbers up to 1.
            let off = f * f.transpose() - DMat3::IDENTITY;
            assert!(off.to_cols_array().iter().all(|x| x.abs() < 8.0 * f64::EPSILON), "{n}: {off}");
            assert!(f.determinant() > 0.0, "{n}");
        }
    }
}
