use glam::DVec3;
use sphvar_integrands::{Domain, Expression, Integrand, WarpExpression};
use sphvar_warps::{Support, Warp};

use super::{Sky, message};

/// Points of the square next to its sides and corners, which are poles and seams of maps. At u = 0 and
/// u = 1, the poles themselves, a map has as many values as longitudes.
fn points() -> Vec<[f64; 2]> {
    let inner = (1..23).map(|k| f64::from(k) / 23.0).chain([1e-12, 0.5]);
    let heights: Vec<f64> = inner.clone().chain([1.0 - 1e-12]).collect();
    let longitudes: Vec<f64> = inner.chain([0.0, 1.0 - f64::EPSILON / 2.0]).collect();
    heights.iter().flat_map(|&u| longitudes.iter().map(move |&v| [u, v])).collect()
}

fn warp_of(text: &str, domain: Domain) -> std::sync::Arc<dyn Warp> {
    text.parse::<WarpExpression>().unwrap().strategies(domain, &Sky).unwrap()[0].warp.clone()
}

fn integrand_of(text: &str) -> Box<dyn Integrand> {
    text.parse::<Expression>().unwrap().build(&Sky).unwrap()
}

/// Asserts that f/p is the integral of f wherever the density is sampled.
fn assert_proportional(text: &str, domain: Domain) {
    let (warp, f) = (warp_of(text, domain), integrand_of(text));
    let ratio = |point| {
        let sample = warp.sample(point);
        (sample, f.eval(sample.point) / sample.density)
    };
    let (_, constant) = ratio([0.4, 0.6]);
    if let Some(exact) = f.exact(domain) {
        assert!((constant / exact - 1.0).abs() < 1e-13, "{text}: {constant}, {exact}");
    }
    for point in points() {
        let (sample, ratio) = ratio(point);
        // The longitude of a rotated direction next to the pole is rounded.
        let from_pole = point[0].min(1.0 - point[0]).sqrt();
        let is_rotated = text.contains(" @ ") || text.contains("up=");
        let tolerance = if is_rotated { 1e-13 + 4e-15 / from_pole } else { 1e-13 };
        // A cosine of 0 at the horizon.
        if sample.density > 1e-12 {
            let error = ratio / constant - 1.0;
            assert!(error.abs() < tolerance, "{text}, {domain:?}, {point:?}: {error:e}");
        }
        let density = warp.density(sample.point);
        assert!(
            (density - sample.density).abs() <= tolerance * density.max(1.0),
            "{text}, {point:?}"
        );
    }
    for dir in [DVec3::NEG_X, DVec3::new(-1.0, -1e-300, 1.0), DVec3::new(1e-3, 1e-4, 1.0)] {
        let dir = dir.normalize();
        let (value, density) = (f.eval(dir), warp.density(dir));
        assert!((value - constant * density).abs() < 1e-13 * constant, "{text}, {dir}: {value}");
    }
}

#[test]
fn maps_are_proportional_to_the_integrand_of_the_same_text() {
    for text in [
        "env:a.exr",
        "env:a.exr,mirror=yes,rotate=123",
        "env:a.exr,projection=octahedral,rotate=-77",
        "env:a.exr,up=y,rotate=10",
        "env:a.exr,up=-z",
        "env:a.exr @ 40/10/70",
        "env:a.exr,up=-x @ 40/10/70 @ 0/45",
        "env:a.exr @ 0/0/200",
    ] {
        assert_proportional(text, Domain::Sphere);
    }
    for text in ["env:a.exr", "env:a.exr,rotate=50 @ 0/20", "env:a.exr,up=-x @ 90/30"] {
        assert_proportional(text, Domain::Hemisphere);
    }
}

#[test]
fn products_are_proportional_to_the_integrand_of_the_same_text() {
    for text in [
        "env:a.exr * cosine",
        "cosine * env:a.exr,rotate=30,mirror=yes @ 0/25",
        "env:a.exr,projection=octahedral * cosine",
        "env:a.exr,up=y * cosine @ 90/90",
        "env:a.exr @ 40/10/70 * cosine @ 40/10",
        "cosine @ 120/-40/5 * env:a.exr @ 0/0/9 @ 120/-40",
    ] {
        assert_proportional(text, Domain::Sphere);
    }
    assert_proportional("env:a.exr * cosine", Domain::Hemisphere);
    assert_eq!(warp_of("env:a.exr * cosine", Domain::Sphere).support(), Support::UpperHemisphere);
    for text in
        ["env:a.exr,up=y * cosine", "env:a.exr * cosine @ 10/0", "env:a.exr @ 180/0 * cosine"]
    {
        let expression: WarpExpression = text.parse().unwrap();
        let error = message(expression.strategies(Domain::Hemisphere, &Sky));
        let expected = format!("the cosine of {text} must be about the pole of the map");
        assert!(error.contains(&expected), "{text}: {error}");
    }
}

#[test]
fn lobes_and_caps_are_proportional_to_the_integrand_of_the_same_text() {
    for text in [
        "cosine",
        "cosine @ 30/60",
        "phong:n=0",
        "phong:n=20.5 @ 170/3 @ 4/5/6",
        "vmf:kappa=0",
        "vmf:kappa=300 @ 40/10",
        "cap:degrees=1e-3 @ 89/0",
        "cap:degrees=90",
        "cap:degrees=180",
    ] {
        let (warp, f) = (warp_of(text, Domain::Sphere), integrand_of(text));
        let exact = f.exact(Domain::Sphere).unwrap();
        for [u, v] in points() {
            // Directions on the edge of the support are rounded to either side.
            let point = [u.clamp(1e-6, 1.0 - 1e-6), v.clamp(1e-6, 1.0 - 1e-6)];
            let sample = warp.sample(point);
            let ratio = f.eval(sample.point) / sample.density;
            assert!((ratio / exact - 1.0).abs() < 1e-9, "{text}, {point:?}: {ratio}, {exact}");
        }
    }
    assert_eq!(warp_of("cap:degrees=90", Domain::Sphere).support(), Support::UpperHemisphere);
}

#[test]
fn constant_maps_and_floors_mix_as_stated() {
    let bilinear = warp_of("env:a.exr", Domain::Sphere);
    let constant = warp_of("env:a.exr,interpolation=constant", Domain::Sphere);
    let mixed = warp_of("env:a.exr,floor=0.25", Domain::Sphere);
    let uniform = warp_of("cylinder", Domain::Sphere).density(DVec3::Z);
    let mut differ = false;
    for point in points() {
        let dir = bilinear.map(point);
        let expected = 0.75 * bilinear.density(dir) + 0.25 * uniform;
        assert!((mixed.density(dir) / expected - 1.0).abs() < 1e-13);
        differ |= (constant.density(dir) / bilinear.density(dir) - 1.0).abs() > 0.1;
    }
    assert!(differ);
}
