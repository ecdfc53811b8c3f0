//! Quadrature rules: exact to their degree and not beyond, on both domains.

use std::collections::HashSet;
use std::f64::consts::PI;

use sphvar_samplers::{
    CubeRule, CubeSpacing, Domain, DriscollHealyRule, Error, Fibonacci, GaussLegendreRule,
    GeodesicRule, LebedevRule, McEwenWiauxRule, Pattern, PointSet, Purpose, Rule, Sampler, Streams,
};
use sphvar_sht::{FastTransform, Method, Transform, TransformWorkspace};

const DOMAINS: [Domain; 2] = [Domain::Sphere, Domain::Hemisphere];
const LEBEDEV_DEGREES: [usize; 32] = [
    3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31, 35, 41, 47, 53, 59, 65, 71, 77, 83, 89,
    95, 101, 107, 113, 119, 125, 131,
];

fn sample(sampler: &dyn Sampler) -> PointSet {
    let mut rng = Streams::new(0, Purpose::Pattern, 0).realization(0);
    sampler.sample(&mut rng).unwrap()
}

/// Returns the root of the energy of each degree, relative to degree 0.
fn errors(set: &PointSet, lmax: usize) -> Vec<f64> {
    let transform =
        Transform::new(Method::Auto, lmax, set.len(), FastTransform::MIN_EPSILON).unwrap();
    let mut alm = [sphvar_sh::Alm::zeros(lmax).unwrap()];
    let weights = (!set.weights.is_empty()).then_some(&*set.weights);
    let mut workspace = TransformWorkspace::default();
    transform.adjoint_batch_into(&[(&set.points, weights)], &mut workspace, &mut alm);
    let energy = alm[0].energy_per_degree();
    energy.iter().map(|e| (e / energy[0]).sqrt()).collect()
}

fn rules(domain: Domain) -> Vec<Box<dyn Sampler>> {
    let mut rules = Vec::<Box<dyn Sampler>>::new();
    for size in [1, 2, 3, 4, 7, 16, 33] {
        rules.push(Box::new(GaussLegendreRule::new(size, domain).unwrap()));
        rules.push(Box::new(DriscollHealyRule::new(size, domain).unwrap()));
        rules.push(Box::new(McEwenWiauxRule::new(size, domain).unwrap()));
        rules.push(Box::new(GeodesicRule::new(size, domain).unwrap()));
        for spacing in [CubeSpacing::Equiangular, CubeSpacing::Equidistant] {
            rules.push(Box::new(CubeRule::new(size, spacing, domain).unwrap()));
        }
    }
    for degree in LEBEDEV_DEGREES {
        rules.push(Box::new(LebedevRule::new(degree, domain).unwrap()));
    }
    rules
}

/// The sum over a degree of 2l + 1 <= 263 rounding errors, each of `sqrt(2l + 1)` times a few
/// `EPSILON` of the coordinates: below 1e-12. A degree that is not exact has an error of at least
/// 1e-5; the least one is that of the Gauss-Legendre rule of 33 rings.
#[test]
fn rules_are_exact_to_their_degree_and_not_beyond() {
    for domain in DOMAINS {
        for rule in rules(domain) {
            let set = sample(&*rule);
            let last = rule.last_empty_degree().unwrap();
            let next = last + domain.degree_step();
            let errors = errors(&set, next);
            for (l, error) in errors.iter().enumerate().skip(1) {
                if domain.has_degree(l) && l <= last {
                    assert!(*error < 1e-12, "{rule:?} {domain}: degree {l} has {error:e}");
                }
            }
            assert!(errors[next] > 1e-5, "{rule:?} {domain}: {next} has {:e}", errors[next]);
        }
    }
}

#[test]
fn nodes_are_distinct_unit_vectors_of_the_stated_number() {
    for domain in DOMAINS {
        for rule in rules(domain) {
            let set = sample(&*rule);
            assert_eq!(set.len(), rule.n_points(), "{rule:?}");
            let bits = |p: &glam::DVec3| {
                // On the hemisphere a node and its antipode are one point.
                let on_equator = domain == Domain::Hemisphere && p.z.abs() < 1e-12;
                let p = if on_equator && (p.y < -1e-12 || p.x < -1.0 + 1e-9) { -*p } else { *p };
                (p * 1e9).round().as_i64vec3()
            };
            let distinct: HashSet<_> = set.points.iter().map(bits).collect();
            assert_eq!(distinct.len(), set.len(), "{rule:?}");
            let is_unit = |p: &glam::DVec3| (p.length() - 1.0).abs() < 1e-15;
            assert!(set.points.iter().all(is_unit), "{rule:?}");
            assert!(domain == Domain::Sphere || set.points.iter().all(|p| p.z >= 0.0), "{rule:?}");
            if !set.weights.is_empty() {
                let sum: f64 = set.weights.iter().sum();
                assert!((sum / domain.area() - 1.0).abs() < 1e-13, "{rule:?}: {sum}");
            }
        }
    }
}

/// Signs as published: all weights are positive except those of three Lebedev rules and of the
/// Driscoll-Healy pole.
#[test]
fn weights_are_positive_except_known_ones() {
    for rule in rules(Domain::Sphere) {
        let set = sample(&*rule);
        let negative = set.weights.iter().filter(|&&w| w < 0.0).count();
        let expected = match set.len() {
            74 => 8,
            230 => 6,
            266 => 18,
            _ => 0,
        };
        let is_lebedev = format!("{rule:?}").starts_with("Lebedev");
        assert_eq!(negative, if is_lebedev { expected } else { 0 }, "{rule:?}");
    }
    let zeros = |size| {
        let set = sample(&DriscollHealyRule::new(size, Domain::Sphere).unwrap());
        set.points.into_iter().zip(set.weights).filter(|(_, w)| *w <= 0.0).collect::<Vec<_>>()
    };
    assert_eq!(zeros(9), [(glam::DVec3::Z, 0.0)]);
}

/// `sum_k w_k f(theta_k)` over rings of `cos^n` against `2 pi` times its integral over z.
#[test]
fn zonal_monomials_are_integrated() {
    for n in 0..20_i32 {
        let exact = if n % 2 == 0 { 4.0 * PI / f64::from(n + 1) } else { 0.0 };
        let rules: [&dyn Sampler; 3] = [
            &GaussLegendreRule::new(10, Domain::Sphere).unwrap(),
            &DriscollHealyRule::new(10, Domain::Sphere).unwrap(),
            &McEwenWiauxRule::new(20, Domain::Sphere).unwrap(),
        ];
        for rule in rules {
            let set = sample(rule);
            let terms = set.points.iter().zip(&set.weights).map(|(p, w)| w * p.z.powi(n));
            let sum: f64 = terms.sum();
            assert!((sum - exact).abs() < 1e-13, "{rule:?}, z^{n}: {sum}, not {exact}");
        }
    }
}

/// With equal weights, the power at the first degree that the symmetry permits is N times a constant.
#[test]
fn grids_of_equal_weights_have_a_bias() {
    for (text, degree) in
        [("icosahedral", 6), ("cube-sphere", 4), ("cube-sphere:spacing=equidistant", 4)]
    {
        let pattern: Pattern = text.parse().unwrap();
        let amplitudes = [3000, 12000].map(|requested| {
            let n = pattern.nearest_count(requested, Domain::Sphere);
            errors(&sample(&*pattern.build(n, Domain::Sphere).unwrap()), degree)[degree]
        });
        assert!(amplitudes[0] > 0.01, "{text}: {amplitudes:?}");
        assert!((amplitudes[1] / amplitudes[0] - 1.0).abs() < 0.01, "{text}: {amplitudes:?}");
    }
}

#[test]
fn sizes_outside_the_range_are_rejected() {
    for size in [0, 32769, u32::MAX] {
        assert!(matches!(
            GaussLegendreRule::new(size, Domain::Sphere),
            Err(Error::Parameter { .. })
        ));
        assert!(matches!(GeodesicRule::new(size, Domain::Sphere), Err(Error::Parameter { .. })));
    }
    for degree in [0, 1, 4, 33, 133] {
        assert!(matches!(LebedevRule::new(degree, Domain::Sphere), Err(Error::Parameter { .. })));
    }
    let error = "lebedev".parse::<Pattern>().unwrap().build(100, Domain::Sphere).unwrap_err();
    assert!(error.to_string().contains("nearest valid count is 110"), "{error}");
    let largest = GaussLegendreRule::new(32768, Domain::Sphere).unwrap();
    assert_eq!(largest.n_nodes(), 2 << 30);
}

/// The heights of the default offset are `1 - (2j+1)/N` to the last bit; others keep to the
/// formula of Roberts.
#[test]
fn offsets_move_the_ends_of_the_fibonacci_lattice() {
    for domain in DOMAINS {
        let per_point = if domain == Domain::Sphere { 1.0 } else { 0.5 };
        for n in [1, 2, 3, 7, 1000, 1001] {
            let set = sample(&Fibonacci::new(n, domain).unwrap());
            for (j, p) in set.points.iter().enumerate() {
                let height = 1.0 - (2 * j + 1) as f64 * (per_point / n as f64);
                assert_eq!(p.z.to_bits(), height.to_bits(), "{domain}, N = {n}, j = {j}");
            }
        }
        for offset in [0.0, 0.25, 1.33, 1e6] {
            for n in [1, 2, 50] {
                let set = sample(&Fibonacci::with_offset(n, domain, offset).unwrap());
                let on_sphere = domain.count_on_sphere(n);
                for (j, p) in set.points.iter().enumerate() {
                    let span = on_sphere - 1.0 + 2.0 * offset;
                    let height = 1.0 - 2.0 * (j as f64 + offset) / span;
                    let height = if span > 0.0 { height } else { 0.0 };
                    assert!((p.z - height).abs() < 1e-15, "{offset}, {n}, {j}: {}", p.z);
                    assert!((p.length() - 1.0).abs() < 1e-15);
                }
            }
        }
    }
    for offset in [-0.1, f64::NAN, 1.1e6] {
        assert!(Fibonacci::with_offset(5, Domain::Sphere, offset).is_err());
    }
}
