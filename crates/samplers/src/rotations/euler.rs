use std::f64::consts::TAU;

use glam::DQuat;

/// Returns the Euler angles `[alpha, beta, gamma]` of a rotation in the z-y-z convention, in radians:
///
/// ```text
/// R = Rz(alpha) Ry(beta) Rz(gamma),   alpha, gamma in [0, 2 pi),  beta in [0, pi].
/// ```
///
/// The rotation is active. It turns by gamma about z, then by beta about y, then by alpha about z,
/// all fixed axes; equally, by alpha about z, by beta about the new y and by gamma about the new z
/// (intrinsic z-y'-z''). alpha and beta are the longitude and the colatitude of the image of z. Where beta is
/// 0 or pi, only the sum or the difference of the other two is determined, and gamma is 0.
///
/// # Examples
///
/// ```
/// use glam::DQuat;
/// use sphvar_samplers::{euler_zyz, rotation_from_euler_zyz};
///
/// let angles = euler_zyz(DQuat::from_rotation_y(0.5) * DQuat::from_rotation_z(2.0));
/// assert!((angles[1] - 0.5).abs() < 1e-15 && (angles[2] - 2.0).abs() < 1e-15);
/// let back = rotation_from_euler_zyz(angles);
/// assert!((euler_zyz(back)[2] - 2.0).abs() < 1e-15);
/// ```
#[must_use]
pub fn euler_zyz(rotation: DQuat) -> [f64; 3] {
    let DQuat { x, y, z, w } = rotation;
    let (swing, twist) = (x.hypot(y), w.hypot(z));
    let beta = 2.0 * swing.atan2(twist);
    let half_sum = z.atan2(w);
    let half_difference = (-x).atan2(y);
    let [alpha, gamma] = if swing == 0.0 {
        [2.0 * half_sum, 0.0]
    } else if twist == 0.0 {
        [2.0 * half_difference, 0.0]
    } else {
        [half_sum + half_difference, half_sum - half_difference]
    };
    [wrapped(alpha), beta, wrapped(gamma)]
}

/// Returns the rotation with the Euler angles of [`euler_zyz`].
#[must_use]
pub fn rotation_from_euler_zyz([alpha, beta, gamma]: [f64; 3]) -> DQuat {
    let (sin_beta, cos_beta) = (0.5 * beta).sin_cos();
    let (sin_sum, cos_sum) = (0.5 * (alpha + gamma)).sin_cos();
    let (sin_difference, cos_difference) = (0.5 * (alpha - gamma)).sin_cos();
    DQuat::from_xyzw(
        -sin_beta * sin_difference,
        sin_beta * cos_difference,
        cos_beta * sin_sum,
        cos_beta * cos_sum,
    )
}

/// Returns an angle in [0, 2 pi).
fn wrapped(angle: f64) -> f64 {
    let wrapped = angle.rem_euclid(TAU);
    // Angles slightly below 0 round to 2 pi.
    if wrapped < TAU { wrapped } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use glam::{DMat3, DQuat, DVec3};

    use super::{euler_zyz, rotation_from_euler_zyz};
    use crate::{Purpose, RotationPattern, Streams};

    fn check(q: DQuat) {
        let angles @ [alpha, beta, gamma] = euler_zyz(q);
        assert!((0.0..TAU).contains(&alpha) && (0.0..TAU).contains(&gamma), "{angles:?}");
        assert!((0.0..=PI).contains(&beta), "{angles:?}");
        let product = DMat3::from_rotation_z(alpha)
            * DMat3::from_rotation_y(beta)
            * DMat3::from_rotation_z(gamma);
        for matrix in [product, DMat3::from_quat(rotation_from_euler_zyz(angles))] {
            let off = (matrix - DMat3::from_quat(q)).to_cols_array();
            assert!(off.iter().all(|x| x.abs() < 4e-15), "{q}: {angles:?}, {off:?}");
        }
        let image = DVec3::new(beta.sin() * alpha.cos(), beta.sin() * alpha.sin(), beta.cos());
        assert!((q * DVec3::Z).distance(image) < 2e-15, "{q}");
    }

    #[test]
    fn angles_determine_the_rotation() {
        let mut rng = Streams::new(9, Purpose::Pattern, 0).realization(0);
        let uniform = RotationPattern::Uniform.build(500).unwrap().sample(&mut rng).unwrap();
        for q in uniform.points {
            check(q);
            check(-q);
        }
    }

    #[test]
    fn angles_near_the_poles_determine_the_rotation() {
        for by in [0.0, 1e-300, 1e-17, 1e-9, -1e-9, 1e-3] {
            for turn in [0.0, -0.0, 1.0, -1.0, PI, 3.0, TAU] {
                let z = DQuat::from_rotation_z(turn);
                check((z * DQuat::from_rotation_x(by)).normalize());
                check((z * DQuat::from_rotation_x(PI + by)).normalize());
                check((z * DQuat::from_rotation_y(PI - by)).normalize());
            }
        }
        for turn in [DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0), DQuat::from_xyzw(0.0, 1.0, 0.0, 0.0)] {
            check(turn);
            assert!(euler_zyz(turn)[2] <= 0.0);
        }
    }
}
