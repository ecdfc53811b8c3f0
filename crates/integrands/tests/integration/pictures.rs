//! Environment maps from pictures: orientation, mirroring, rotation, octahedral projection.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;
use sphvar_integrands::{Domain, EnvironmentMap, Integrand, PictureLayout, Projection};

fn picture() -> Vec<f64> {
    (0..128).map(|k| f64::from((k * 37 + k * k) % 101)).collect()
}

fn direction(theta: f64, phi: f64) -> DVec3 {
    DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

fn octahedral() -> PictureLayout {
    PictureLayout { projection: Projection::Octahedral, ..PictureLayout::default() }
}

/// The relation of the emitter `envmap` of Mitsuba 3 between direction and column,
/// `u = atan2(x, -z)/(2 pi)` with +y up, determined from renderings of a map with the values u:
/// 0.25 at +x, 0.5 at +z, 0.75 at -x.
#[test]
fn the_orientation_of_pictures_matches_mitsuba() {
    let (width, height) = (16, 8);
    let texels = picture();
    let map = EnvironmentMap::from_picture(width, height, texels.clone(), PictureLayout::default());
    let map = map.unwrap();
    for i in 0..height {
        for j in 0..width {
            let u = (j as f64 + 0.5) / width as f64 * TAU;
            let theta = PI * (i as f64 + 0.5) / height as f64;
            // atan2(x, -z) = u, and y up.
            let y_up = DVec3::new(theta.sin() * u.sin(), theta.cos(), -theta.sin() * u.cos());
            let z_up = DVec3::new(y_up.x, -y_up.z, y_up.y);
            let (got, expected) = (map.eval(z_up), texels[i * width + j]);
            assert!((got - expected).abs() < 1e-9, "({i}, {j}): {got}, not {expected}");
        }
    }
}

#[test]
fn mirror_and_turn_move_the_same_function() {
    let make = |layout| EnvironmentMap::from_picture(16, 8, picture(), layout).unwrap();
    let (plain, rotation) = (make(PictureLayout::default()), 0.7);
    let mirrored = make(PictureLayout { mirror: true, ..PictureLayout::default() });
    let rotated = make(PictureLayout { rotation, ..PictureLayout::default() });
    let both = make(PictureLayout { mirror: true, rotation, ..PictureLayout::default() });
    for k in 0..200 {
        // At the poles themselves there is no longitude.
        let (theta, phi) = (PI * (f64::from(k) + 0.5) / 200.0, 0.37 * f64::from(k));
        let value = plain.eval(direction(theta, phi));
        for (map, phi) in [(&mirrored, -phi), (&rotated, phi + rotation), (&both, rotation - phi)] {
            let got = map.eval(direction(theta, phi));
            assert!((got - value).abs() < 1e-9, "{k}: {got}, not {value}");
        }
    }
    let energy = |map: &EnvironmentMap| {
        let energy = map.energy(Domain::Sphere, 12).unwrap();
        (energy.per_band().to_vec(), energy.total())
    };
    let (expected, total) = energy(&plain);
    for map in [&mirrored, &rotated, &both] {
        let (got, square) = energy(map);
        assert!((square - total).abs() < 1e-12 * total, "{square} {total}");
        for (l, (a, b)) in got.iter().zip(&expected).enumerate() {
            assert!((a - b).abs() < 1e-11 * total, "{l}: {a} {b}");
        }
    }
    // The coefficients are those of the evaluated function: by quadrature at (l, m) = (1, 1), int f
    // Re(conj Y_11), Y_11 = -sqrt(3/8pi) sin(theta) e^{i phi}.
    let alm = rotated.alm(Domain::Sphere, 2).unwrap();
    let n = 1000;
    let mut sum = [0.0; 2];
    for i in 0..n {
        for j in 0..2 * n {
            let theta = PI * (f64::from(i) + 0.5) / f64::from(n);
            let phi = PI * (f64::from(j) + 0.5) / f64::from(n);
            let weight = theta.sin() * rotated.eval(direction(theta, phi));
            let amplitude = -(3.0 / (8.0 * PI)).sqrt() * theta.sin() * weight;
            sum[0] += amplitude * phi.cos();
            sum[1] -= amplitude * phi.sin();
        }
    }
    let area = (PI / f64::from(n)).powi(2);
    let got = alm[(1, 1)];
    assert!((got.re - area * sum[0]).abs() < 1e-3, "{got} {sum:?}");
    assert!((got.im - area * sum[1]).abs() < 1e-3, "{got} {sum:?}");
}

/// `EqualAreaSquareToSphere` of pbrt-v4, written out.
fn square_to_sphere(u: f64, v: f64) -> DVec3 {
    let (u, v) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    let signed = 1.0 - (u.abs() + v.abs());
    let r = 1.0 - signed.abs();
    let octant = if r == 0.0 { 1.0 } else { (v.abs() - u.abs()) / r + 1.0 };
    let phi = octant * PI / 4.0;
    let s = r * (2.0 - r * r).sqrt();
    let z = (1.0 - r * r).copysign(signed);
    DVec3::new(phi.cos().copysign(u) * s, phi.sin().copysign(v) * s, z)
}

#[test]
fn octahedral_maps_reproduce_smooth_functions() {
    let f = |dir: DVec3| 2.0 + dir.x + 0.5 * dir.y * dir.z - 0.25 * dir.z;
    let side = 64;
    let at = |k: usize| (k as f64 + 0.5) / side as f64;
    let texels: Vec<f64> =
        (0..side * side).map(|k| f(square_to_sphere(at(k % side), at(k / side)))).collect();
    let make = |layout| EnvironmentMap::from_picture(side, side, texels.clone(), layout).unwrap();
    let map = make(octahedral());
    let mirrored = make(PictureLayout { mirror: true, ..octahedral() });
    for k in 0..500 {
        let dir = direction(PI * f64::from(k) / 499.0, 2.4 * f64::from(k));
        assert!((map.eval(dir) - f(dir)).abs() < 0.05, "{dir}: {} {}", map.eval(dir), f(dir));
        let over = DVec3::new(dir.x, -dir.y, dir.z);
        assert!((mirrored.eval(over) - f(dir)).abs() < 0.05, "{dir}");
    }
    let integral = map.exact(Domain::Sphere).unwrap();
    assert!((integral - 8.0 * PI).abs() < 2e-3, "{integral}");
    let error = EnvironmentMap::from_picture(4, 2, vec![0.0; 8], octahedral()).unwrap_err();
    assert!(error.to_string().contains("square"), "{error}");
}

/// The reported position of an invalid texel refers to the picture.
#[test]
fn invalid_texels_are_located() {
    let mut texels = vec![1.0; 32];
    texels[2 * 8 + 3] = f64::NAN;
    let error = EnvironmentMap::from_picture(8, 4, texels, PictureLayout::default());
    let message = error.unwrap_err().to_string();
    assert!(message.contains("(row 2, column 3)"), "{message}");
    let flat = EnvironmentMap::new(8, 4, vec![1.0; 32]).unwrap().with_first_longitude(FRAC_PI_2);
    assert!((flat.exact(Domain::Hemisphere).unwrap() - TAU).abs() < 1e-12);
}
