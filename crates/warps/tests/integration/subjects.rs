//! The maps that the tests of every map examine.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use sphvar_warps::{
    ConcentricDisk, ConcentricHemisphere, CosineHemisphere, DensityMap, Interpolation,
    OctahedralSphere, Oriented, PhongLobe, SphericalRectangle, SphericalTriangle, UniformCap,
    VonMisesFisherLobe, Warp,
};

/// A map with its name.
pub(crate) type Subject = (String, Box<dyn Warp>);

/// Texels of values from 1 to 4 and of 0, and one of 100.
pub(crate) fn texels(width: usize, height: usize) -> Vec<f64> {
    let value = |k: usize| 1.0 + 3.0 * (k as f64 * 0.754_877_666_246_692_7).fract();
    let mut texels: Vec<f64> = (0..width * height).map(value).collect();
    texels[width * height / 3] = 100.0;
    texels
}

pub(crate) fn maps() -> Vec<Subject> {
    let mut maps: Vec<Subject> = Vec::new();
    for interpolation in [Interpolation::Constant, Interpolation::Bilinear] {
        for (width, height) in [(40, 20), (1, 1), (1, 7), (33, 1), (16, 3)] {
            let map = DensityMap::new(width, height, texels(width, height), interpolation).unwrap();
            let name = |text: &str| format!("{width} x {height} {interpolation:?}{text}");
            let cosine = map.clone().times_cosine().unwrap();
            let shifted = map.clone().with_first_longitude(2.5).with_floor(0.2).unwrap();
            let upper = map.clone().on_hemisphere().unwrap();
            maps.push((name(" * cosine"), Box::new(cosine.clone())));
            maps.push((name(" on the hemisphere"), Box::new(upper)));
            maps.push((name(" * cosine, floor"), Box::new(cosine.with_floor(0.3).unwrap())));
            maps.push((name(", floor, shifted"), Box::new(shifted)));
            maps.push((name(""), Box::new(map)));
        }
        let mut dark = texels(40, 20);
        dark[40 * 5..40 * 8].fill(0.0);
        dark.iter_mut().step_by(3).for_each(|x| *x = 0.0);
        let map = DensityMap::new(40, 20, dark, interpolation).unwrap();
        maps.push((format!("map with zeros {interpolation:?}"), Box::new(map)));
    }
    maps
}

pub(crate) fn all() -> Vec<Subject> {
    let mut all: Vec<Subject> = vec![
        ("sphere".to_owned(), Box::new(UniformCap::SPHERE)),
        ("hemisphere".to_owned(), Box::new(UniformCap::HEMISPHERE)),
        ("cap".to_owned(), Box::new(UniformCap::new(0.3).unwrap())),
        ("wide cap".to_owned(), Box::new(UniformCap::new(3.0).unwrap())),
        ("disk".to_owned(), Box::new(ConcentricDisk)),
        ("concentric hemisphere".to_owned(), Box::new(ConcentricHemisphere)),
        ("cosine".to_owned(), Box::new(CosineHemisphere)),
        ("octahedral".to_owned(), Box::new(OctahedralSphere)),
        ("octant".to_owned(), Box::new(SphericalTriangle::OCTANT)),
    ];
    for exponent in [0.0, 1.0, 2.5, 50.0] {
        all.push((format!("Phong {exponent}"), Box::new(PhongLobe::new(exponent).unwrap())));
    }
    for kappa in [0.0, 1e-12, 0.1, 3.0, 100.0] {
        all.push((format!("vMF {kappa}"), Box::new(VonMisesFisherLobe::new(kappa).unwrap())));
    }
    let lobe = PhongLobe::new(20.0).unwrap();
    let rotation = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 2.0);
    all.push(("rotated lobe".to_owned(), Box::new(Oriented::new(lobe, rotation))));
    let towards = Oriented::towards(lobe, DVec3::new(0.0, 0.0, -3.0)).unwrap();
    all.push(("lobe towards -z".to_owned(), Box::new(towards)));
    for (name, [a, b, c]) in [
        (
            "triangle",
            [DVec3::new(1.0, 0.2, 0.1), DVec3::new(0.1, 1.0, 0.3), DVec3::new(0.2, 0.1, 1.0)],
        ),
        (
            "large triangle",
            [DVec3::new(1.0, 0.0, 0.1), DVec3::new(-0.5, 0.8, 0.1), DVec3::new(-0.5, -0.9, 0.1)],
        ),
        ("negative triangle", [DVec3::Z, DVec3::new(0.5, 0.2, 1.0), DVec3::new(0.3, -0.4, 1.0)]),
    ] {
        all.push((name.to_owned(), Box::new(SphericalTriangle::new([a, b, c]).unwrap())));
    }
    for (name, corner, edges) in [
        ("rectangle", DVec3::new(-1.0, -1.0, 2.0), [2.0 * DVec3::X, 2.0 * DVec3::Y]),
        ("rectangle to the side", DVec3::new(2.0, 3.0, -0.7), [DVec3::X, 4.0 * DVec3::Y]),
        ("reversed rectangle", DVec3::new(-3.0, -0.5, 1.0), [2.0 * DVec3::X, 4.0 * DVec3::Z]),
        ("near rectangle", DVec3::new(-5.0, -7.0, 0.1), [9.0 * DVec3::X, 14.0 * DVec3::Y]),
    ] {
        let rectangle = SphericalRectangle::new(corner, edges[0], edges[1]).unwrap();
        all.push((name.to_owned(), Box::new(rectangle)));
    }
    all.extend(maps());
    all
}

/// Points of the open square by an additive recurrence.
pub(crate) fn points(n: usize) -> impl Iterator<Item = [f64; 2]> {
    const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
    (0..n).map(|k| STEPS.map(|step| (0.5 + k as f64 * step).fract()))
}

/// Points on the edges and corners of the square, and next to them.
pub(crate) fn edge_points() -> Vec<[f64; 2]> {
    let values =
        [0.0, f64::MIN_POSITIVE, 1e-17, 1e-8, 0.25, 0.5, 0.75, 1.0 - 1e-9, 1.0f64.next_down()];
    values.iter().flat_map(|&u| values.map(|v| [u, v])).collect()
}

/// Returns a cap that contains the samples, so that cells are as small as they are.
pub(crate) fn enclosing_cap(samples: &[DVec3]) -> Oriented<UniformCap> {
    let axis = samples.iter().sum::<DVec3>().normalize();
    let angle = samples.iter().map(|dir| dir.angle_between(axis)).fold(0.0, f64::max);
    let cap = UniformCap::new((angle * 1.01).min(PI)).expect("an angle");
    Oriented::towards(cap, axis).expect("an axis")
}
