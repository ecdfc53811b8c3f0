//! Directional lights of environment maps: their light, and the error of the irradiance against its
//! definition.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec3, EulerRot};
use rand::{Rng, RngExt};
use sphvar_integrands::{Domain, EnvironmentMap, Integrand};
use sphvar_samplers::{AdaptedCcvt, Fibonacci, Pattern, PointSet, Purpose, Sampler, Streams};
use sphvar_scene::{
    DirectionalLight, Error, IrradianceReference, RgbEnvironment, irradiance_of, luminance,
};

fn rng(realization: u64) -> impl Rng {
    Streams::new(21, Purpose::Pattern, 0).realization(realization)
}

fn maps(height: usize, texel: impl Fn(usize, usize) -> [f64; 3]) -> [EnvironmentMap; 3] {
    let width = 2 * height;
    let map = |c: usize| {
        let texels = (0..height * width).map(|k| texel(k / width, k % width)[c]).collect();
        EnvironmentMap::new(width, height, texels).unwrap().with_first_longitude(0.3)
    };
    [map(0), map(1), map(2)]
}

fn environment(height: usize, texel: impl Fn(usize, usize) -> [f64; 3]) -> RgbEnvironment {
    RgbEnvironment::new(maps(height, texel), DQuat::IDENTITY).unwrap()
}

/// Returns a map of random colours whose texels differ by factors up to e^4.
fn random_environment(height: usize) -> RgbEnvironment {
    let mut rng = rng(height as u64);
    let colours: Vec<[f64; 3]> = (0..2 * height * height)
        .map(|_| {
            let level = (4.0 * rng.random::<f64>()).exp();
            rng.random::<[f64; 3]>().map(|x| level * (0.2 + x))
        })
        .collect();
    environment(height, |i, j| colours[i * 2 * height + j])
}

fn uniform(environment: &RgbEnvironment, points: &[DVec3]) -> Vec<DirectionalLight> {
    environment.uniform_lights(&PointSet::new(points.to_vec()))
}

fn cells(environment: &RgbEnvironment, n: usize, capacity: usize) -> Vec<DirectionalLight> {
    let ccvt = AdaptedCcvt::new(n, capacity, environment.luminance_warp()).unwrap();
    let tessellation = ccvt.tessellate(&mut rng(1), &()).unwrap();
    assert!(tessellation.is_settled());
    environment.cell_lights(&tessellation)
}

/// Returns the radiance of patches of a fine grid, as lights at their centres: `steps` x `steps`
/// patches for each texel.
fn patches(environment: &RgbEnvironment, steps: usize) -> Vec<DirectionalLight> {
    let map = &environment.channels()[0];
    let (rows, columns) = (steps * map.height(), steps * map.width());
    let mut lights = Vec::new();
    for i in 0..rows {
        let theta = |edge: f64| PI * edge / rows as f64;
        let z = [theta(i as f64).cos(), theta(i as f64 + 1.0).cos()];
        let (sin, cos) = theta(i as f64 + 0.5).sin_cos();
        for j in 0..columns {
            let phi = TAU * (j as f64 + 0.5) / columns as f64;
            let direction = DVec3::new(sin * phi.cos(), sin * phi.sin(), cos);
            let solid_angle = (z[0] - z[1]) * TAU / columns as f64;
            let irradiance = environment.radiance(direction).map(|x| x * solid_angle);
            lights.push(DirectionalLight { direction, irradiance });
        }
    }
    lights
}

fn normals(n: usize) -> Vec<DVec3> {
    Fibonacci::new(n, Domain::Sphere).unwrap().sample(&mut rng(0)).unwrap().points
}

#[test]
fn irradiance_is_its_integral() {
    let environment = random_environment(8);
    let reference = IrradianceReference::new(&environment).unwrap();
    let (normals, patches) = (normals(50), patches(&environment, 24));
    for (normal, got) in normals.iter().zip(reference.irradiance(&normals).unwrap()) {
        let expected = irradiance_of(&patches, &[*normal])[0];
        for c in 0..3 {
            // The error of the midpoint rule.
            assert!((got[c] / expected[c] - 1.0).abs() < 2e-4, "{got:?} {expected:?}");
        }
    }
}

/// By brute force over 1000 normals, with the map as 2000 patches, for lights at random, adapted and
/// coincident directions. The difference is that of the mean over 1000 normals and the patches.
#[test]
fn errors_are_those_over_all_normals() {
    let environment = random_environment(8);
    let reference = IrradianceReference::new(&environment).unwrap();
    let patches = patches(&environment, 12);
    let white =
        Pattern::WhiteNoise.build(60, Domain::Sphere).unwrap().sample(&mut rng(2)).unwrap().points;
    let mut repeated = white[..20].to_vec();
    repeated.extend_from_slice(&white[..20]);
    let normals = normals(1000);
    let exact: Vec<[f64; 3]> = irradiance_of(&patches, &normals);
    for (name, lights) in [
        ("white", uniform(&environment, &white)),
        ("repeated", uniform(&environment, &repeated)),
        ("one", uniform(&environment, &white[..1])),
        ("cells", cells(&environment, 16, 64)),
        ("median cut", environment.median_cut(13).unwrap()),
        ("none", Vec::new()),
    ] {
        let got = reference.relative_error(&lights).unwrap();
        let measure = |of: &dyn Fn([f64; 3]) -> f64| {
            let sums =
                irradiance_of(&lights, &normals).into_iter().zip(&exact).map(|(lit, &exact)| {
                    let lit = of(lit);
                    [(lit - of(exact)).powi(2), of(exact).powi(2)]
                });
            let [error, norm] = sums.fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
            (error / norm).sqrt()
        };
        let expected = measure(&luminance);
        let of_luminance = got.luminance.unwrap();
        assert!((of_luminance / expected - 1.0).abs() < 0.02, "{name}: {of_luminance} {expected}");
        for c in 0..3 {
            let (got, expected) = (got.channels[c].unwrap(), measure(&|colour| colour[c]));
            assert!((got / expected - 1.0).abs() < 0.02, "{name}, {c}: {got} {expected}");
        }
    }
}

/// Lights at the centres of patches have the errors of the midpoint rule, which fall as the square
/// of their size: degrees beyond the largest one are included.
#[test]
fn errors_of_fine_patches_vanish() {
    let environment = random_environment(4);
    let reference = IrradianceReference::new(&environment).unwrap();
    let error =
        |steps| reference.relative_error(&patches(&environment, steps)).unwrap().luminance.unwrap();
    let (coarse, fine) = (error(2), error(8));
    assert!(fine < 1e-3 && (8.0..32.0).contains(&(coarse / fine)), "{coarse} {fine}");
}

#[test]
fn cells_share_the_luminance_and_have_all_light() {
    let environment = random_environment(8);
    let lights = cells(&environment, 40, 256);
    let exact = environment.channels().each_ref().map(|map| map.exact(Domain::Sphere).unwrap());
    for light in &lights {
        let ratio = 40.0 * luminance(light.irradiance) / luminance(exact);
        assert!((ratio - 1.0).abs() < 1e-12, "{ratio}");
    }
    for (c, exact) in exact.iter().enumerate() {
        let sum: f64 = lights.iter().map(|light| light.irradiance[c]).sum();
        assert!((sum / exact - 1.0).abs() < 2e-3, "{sum} {exact}");
    }
}

/// Texels of negative light, as resampling of suns leaves them, keep their light.
#[test]
fn negative_light_is_subtracted() {
    let environment = environment(8, |i, j| if (i, j) == (3, 4) { [50.0; 3] } else { [-0.1; 3] });
    let exact = environment.channels()[0].exact(Domain::Sphere).unwrap();
    for lights in [cells(&environment, 30, 256), environment.median_cut(30).unwrap()] {
        assert!(lights.iter().any(|light| light.irradiance[0] < 0.0));
        let sum: f64 = lights.iter().map(|light| light.irradiance[0]).sum();
        assert!((sum / exact - 1.0).abs() < 0.02, "{sum} {exact}");
    }
}

#[test]
fn median_cuts_of_powers_of_two_share_the_luminance() {
    // Smooth light and many texels, so that lines between texels are close to medians.
    let environment = environment(64, |i, j| {
        let (theta, phi) = (PI * (i as f64 + 0.5) / 64.0, TAU * j as f64 / 128.0);
        [1.5 + theta.cos(), 1.2 + theta.sin() * phi.sin(), 1.1 + phi.cos()]
    });
    let lights = environment.median_cut(16).unwrap();
    let values: Vec<f64> = lights.iter().map(|light| luminance(light.irradiance)).collect();
    let total: f64 = values.iter().sum();
    for value in &values {
        assert!((16.0 * value / total - 1.0).abs() < 0.1, "{values:?}");
    }
    let exact = environment.channels().each_ref().map(|map| map.exact(Domain::Sphere).unwrap());
    // The map is bilinear between the centres of the texels that the cut adds.
    assert!((total / luminance(exact) - 1.0).abs() < 1e-3, "{total}");
}

#[test]
fn extreme_maps_have_their_light() {
    let sun = |i: usize, j: usize| if (i, j) == (2, 3) { [1e20, 8e19, 3e19] } else { [1.0; 3] };
    let texel = |i: usize, j: usize| if (i, j) == (2, 3) { [1.0, 2.0, 3.0] } else { [0.0; 3] };
    for environment in [
        environment(8, sun),
        environment(8, texel),
        environment(1, |_, j| [j as f64, 1.0, 0.0]),
        random_environment(2),
    ] {
        let exact = environment.channels().each_ref().map(|map| map.exact(Domain::Sphere).unwrap());
        let reference = IrradianceReference::new(&environment).unwrap();
        for n in [1, 2, 7, 300] {
            for (name, lights, tolerance) in [
                ("cells", cells(&environment, n, 64), 1e-12),
                // Texels of 22 degrees are not the bilinear map.
                ("median cut", environment.median_cut(n).unwrap(), 1.0),
            ] {
                assert_eq!(lights.len(), n, "{name}");
                assert!(lights.iter().all(|light| light.direction.is_normalized()));
                let sum: f64 = lights.iter().map(|light| luminance(light.irradiance)).sum();
                assert!((sum / luminance(exact) - 1.0).abs() < tolerance, "{name} {n}: {sum}");
                let error = reference.relative_error(&lights).unwrap();
                assert!(error.luminance.unwrap() < 2.0, "{name} {n}: {error:?}");
                assert!(error.channels[0].unwrap().is_finite());
            }
        }
    }
    // A channel without light has no relative error.
    let red = environment(2, |_, _| [1.0, 0.0, 0.0]);
    let lights = cells(&red, 4, 16);
    let error = IrradianceReference::new(&red).unwrap().relative_error(&lights).unwrap();
    assert!(error.luminance.is_some() && error.channels[1].is_none());
}

#[test]
fn unusable_maps_are_errors() {
    let new = |maps: [EnvironmentMap; 3]| RgbEnvironment::new(maps, DQuat::IDENTITY);
    let map = |n: usize, value| EnvironmentMap::new(2 * n, n, vec![value; 2 * n * n]).unwrap();
    assert!(matches!(new([0.0; 3].map(|x| map(2, x))), Err(Error::Density(_))));
    assert!(matches!(new([2, 2, 3].map(|n| map(n, 1.0))), Err(Error::Channels)));
    let shifted = map(2, 1.0).with_first_longitude(1.0);
    assert!(matches!(new([map(2, 1.0), shifted, map(2, 1.0)]), Err(Error::Channels)));
    let environment = new([1.0, 2.0, 3.0].map(|x| map(2, x))).unwrap();
    assert!(matches!(environment.median_cut(0), Err(Error::Setting { .. })));
}

/// A rotation is that of every light, whether it is stated as the first longitude of the map or as
/// a rotation of the environment.
#[test]
fn lights_rotate_with_the_environment() {
    let texel = |i: usize, j: usize| [1.0 + i as f64, 1.0 + (i * j) as f64, 2.0];
    let maps = maps(4, texel);
    let original = environment(4, texel);
    let shifted = maps.clone().map(|map| map.with_first_longitude(1.3));
    let tilt = DQuat::from_euler(EulerRot::ZYX, 0.4, 1.0, -2.0);
    for (maps, rotation, total) in
        [(shifted, DQuat::IDENTITY, DQuat::from_rotation_z(1.0)), (maps, tilt, tilt)]
    {
        let rotated = RgbEnvironment::new(maps, rotation).unwrap();
        let rotate = |lights: Vec<DirectionalLight>| {
            lights
                .into_iter()
                .map(|light| DirectionalLight { direction: total * light.direction, ..light })
        };
        let methods: [fn(&RgbEnvironment) -> Vec<DirectionalLight>; 2] = [
            |environment| environment.median_cut(5).unwrap(),
            |environment| {
                let sample = environment.luminance_warp().sample([0.1, 0.2]);
                environment.lights(&[sample.point], &[1.0 / sample.density])
            },
        ];
        for method in methods {
            let expected = rotate(method(&original));
            for (a, b) in expected.zip(method(&rotated)) {
                assert!((a.direction - b.direction).length() < 1e-12, "{a:?} {b:?}");
                let difference = (a.irradiance[1] - b.irradiance[1]).abs();
                assert!(difference < 1e-11 * a.irradiance[1], "{a:?} {b:?}");
            }
        }
        let reference = IrradianceReference::new(&rotated).unwrap();
        let normal = DVec3::new(0.48, 0.6, 0.64);
        let unrotated = IrradianceReference::new(&original).unwrap();
        let [a, b] = [
            reference.irradiance(&[total * normal]).unwrap()[0],
            unrotated.irradiance(&[normal]).unwrap()[0],
        ];
        assert!((a[1] / b[1] - 1.0).abs() < 1e-10, "{a:?} {b:?}");
        // Tessellations are divided in random directions.
        let error = |lights: Vec<_>| reference.relative_error(&lights).unwrap().luminance.unwrap();
        assert!(error(cells(&rotated, 40, 64)) < 0.04);
        assert!(error(rotate(cells(&original, 40, 64)).collect()) < 0.04);
        assert!(error(cells(&original, 40, 64)) > 0.1);
    }
}
