//! Controlled spectra: invalid parameters, small numbers of points, and the contract of samplers.

use std::time::{Duration, Instant};

use glam::DVec3;
use sphvar_samplers::{
    Domain, Error, NoiseColour, PointSet, PowerProfile, Purpose, Sampler, SpectralControl,
    SpectralTarget, Streams,
};
use sphvar_sht::ExactTransform;

const DOMAINS: [Domain; 2] = [Domain::Sphere, Domain::Hemisphere];

fn sample(control: &SpectralControl, realization: u64) -> Result<Vec<DVec3>, Error> {
    let streams = Streams::new(20_250_701, Purpose::Pattern, control.n_points());
    Ok(control.sample(&mut streams.realization(realization))?.points)
}

/// Returns the name of the rejected parameter.
fn rejected<T: std::fmt::Debug>(result: Result<T, Error>) -> &'static str {
    match result {
        Err(Error::Parameter { name, .. }) => name,
        other => panic!("not a rejected parameter: {other:?}"),
    }
}

fn zeros(last: usize) -> SpectralTarget {
    SpectralTarget::new(vec![0.0; last + 1]).expect("valid powers")
}

#[test]
fn parameters_outside_their_range_are_rejected() {
    const OUTSIDE: [f64; 4] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1e-9];
    for domain in DOMAINS {
        for alpha in OUTSIDE.into_iter().chain([1.39, 10.0, 1e300]) {
            for flat in [None, Some(0.0), Some(2.0)] {
                let step = SpectralControl::step(100, domain, Some(alpha), flat);
                assert_eq!(rejected(step), "alpha", "{domain} {alpha} {flat:?}");
            }
            assert_eq!(
                rejected(SpectralControl::blue(100, domain, Some(alpha))),
                "alpha",
                "{alpha}"
            );
        }
        for flat in OUTSIDE.into_iter().chain([8.1, 1e300]) {
            let step = SpectralControl::step(100, domain, None, Some(flat));
            assert_eq!(rejected(step), "flat", "{domain} {flat}");
        }
        for core in OUTSIDE.into_iter().chain([0.96, 1.0, 1e300]) {
            let step = SpectralControl::step(100, domain, None, None).expect("valid parameters");
            assert_eq!(rejected(step.with_core(core)), "core", "{domain} {core}");
        }
        // The ends belong to the ranges.
        for (alpha, flat, core) in [(0.0, 0.0, 0.0), (1.38, 0.0, 0.95), (0.5, 8.0, 0.0)] {
            // Many points have the degrees of freedom for the largest alpha.
            let step = SpectralControl::step(100_000, domain, Some(alpha), Some(flat));
            let with_core = step.and_then(|step| step.with_core(core));
            assert!(with_core.is_ok(), "{domain} {alpha} {flat} {core}: {with_core:?}");
        }
    }
}

#[test]
fn numbers_of_points_outside_their_range_are_rejected() {
    const COUNT: &str = "the number of points";
    let profile = PowerProfile::QUADRATIC;
    for domain in DOMAINS {
        for n in [0, 1 << 32, usize::MAX] {
            assert_eq!(rejected(SpectralControl::step(n, domain, None, None)), COUNT, "{n}");
            assert_eq!(rejected(SpectralControl::blue(n, domain, None)), COUNT, "{n}");
            assert_eq!(rejected(SpectralControl::profile(n, domain, &profile)), COUNT, "{n}");
            assert_eq!(rejected(SpectralControl::new("test", n, zeros(1), domain)), COUNT, "{n}");
        }
    }
}

#[test]
fn invalid_powers_are_rejected() {
    for power in [f64::NAN, f64::INFINITY, -1e-300, -1.0] {
        for at in 1..4 {
            let mut powers = vec![1.0; 4];
            powers[at] = power;
            assert_eq!(
                rejected(SpectralTarget::new(powers.clone())),
                "a target power",
                "{powers:?}"
            );
            let table = PowerProfile::Table { name: "table".into(), power: powers.into() };
            let control = SpectralControl::profile(50, Domain::Sphere, &table);
            assert_eq!(rejected(control), "a target power", "{power} at degree {at}");
        }
    }
    let polynomial = |exponent, alpha, gamma, offset, to| {
        let profile = PowerProfile::Polynomial { exponent, alpha, gamma, offset, to };
        rejected(SpectralControl::profile(50, Domain::Sphere, &profile))
    };
    for bad in [f64::NAN, f64::INFINITY, -1.0] {
        assert_eq!(polynomial(bad, 1.0, 1.0, 0.0, 2.0), "the exponent b", "{bad}");
        assert_eq!(polynomial(2.0, bad, 1.0, 0.0, 2.0), "alpha", "{bad}");
        assert_eq!(polynomial(2.0, 1.0, bad, 0.0, 2.0), "gamma", "{bad}");
        assert_eq!(polynomial(2.0, 1.0, 1.0, bad, 2.0), "offset", "{bad}");
        assert_eq!(polynomial(2.0, 1.0, 1.0, 0.0, bad), "to", "{bad}");
    }
}

/// 100 points have 197 degrees of freedom, which allow 191 vanishing coefficients: degrees 1 to 12
/// (168 coefficients) but not 13 (195) on the sphere, 2 to 18 (189) but not 20 (230) on the
/// hemisphere.
#[test]
fn more_zeros_than_degrees_of_freedom_are_infeasible() {
    for (domain, max_degree, beyond) in [(Domain::Sphere, 12, 13), (Domain::Hemisphere, 19, 20)] {
        let feasible = SpectralControl::new("test", 100, zeros(max_degree), domain);
        assert!(feasible.is_ok(), "{domain}: {feasible:?}");
        match SpectralControl::new("test", 100, zeros(beyond), domain) {
            Err(Error::Infeasible { pattern: "test", n_points: 100, reason }) => {
                let coefficients = zeros(beyond).constraints(domain).to_string();
                assert!(reason.contains(&coefficients) && reason.contains("197"), "{reason}");
                assert!(reason.contains("191"), "no word of what would be possible: {reason}");
            }
            other => panic!("{domain}: {other:?}"),
        }
    }
    // One point has no degrees of freedom, but an empty target is feasible.
    assert!(SpectralControl::new("test", 1, zeros(0), Domain::Sphere).is_ok());
    assert!(SpectralControl::new("test", 1, zeros(1), Domain::Sphere).is_err());
}

#[test]
fn few_points_succeed_or_fail_quickly() {
    // The longest time was 0.09 s; the limit has a margin for a busy machine.
    const LIMIT: Duration = Duration::from_secs(5);
    for domain in DOMAINS {
        for n in 1..=40 {
            let profile = |profile| SpectralControl::profile(n, domain, &profile);
            let coloured = |colour| profile(PowerProfile::Colour(colour));
            let mut controls = vec![
                ("step", SpectralControl::step(n, domain, None, None)),
                ("bare step", SpectralControl::step(n, domain, None, Some(0.0))),
                ("steepest step", SpectralControl::step(n, domain, Some(1.38), None)),
                ("blue", SpectralControl::blue(n, domain, None)),
                ("profile", profile(PowerProfile::QUADRATIC)),
                ("pink profile", coloured(NoiseColour::Pink)),
                ("green profile", coloured(NoiseColour::Green)),
            ];
            // Descents that stall take longest.
            if n.is_power_of_two() {
                controls.push(("blue profile", coloured(NoiseColour::Blue)));
            }
            for (name, control) in controls {
                let start = Instant::now();
                let points = control.and_then(|control| sample(&control, 0));
                let elapsed = start.elapsed();
                assert!(elapsed < LIMIT, "{name} of {n}, {domain}: {elapsed:?}, {points:?}");
                match points {
                    Ok(points) => assert_eq!(points.len(), n, "{name} of {n}, {domain}"),
                    // The defaults are always feasible.
                    Err(Error::Infeasible { n_points, .. })
                        if name == "steepest step" || name.ends_with("profile") =>
                    {
                        assert_eq!(n_points, n, "{name}");
                    }
                    Err(other) => panic!("{name} of {n}, {domain}: {other}"),
                }
            }
        }
    }
}

#[test]
fn it_meets_the_contract_of_samplers() {
    for domain in DOMAINS {
        for n in [1, 2, 5, 64, 333] {
            for flat in [None, Some(0.0)] {
                let step =
                    SpectralControl::step(n, domain, Some(0.8), flat).expect("valid parameters");
                assert_eq!((step.n_points(), step.domain()), (n, domain));
                assert!(step.is_random());
                let case = format!("{domain}, N = {n}, flat {flat:?}");
                let points = sample(&step, 1).expect(&case);
                assert_eq!(points.len(), n, "{case}");
                for p in &points {
                    // One normalisation, and a sign.
                    assert!((p.length() - 1.0).abs() <= 4.0 * f64::EPSILON, "{case}: {p}");
                    assert!(domain == Domain::Sphere || p.z.is_sign_positive(), "{case}: {p}");
                }

                let streams = Streams::new(20_250_701, Purpose::Pattern, n);
                for dirt in [vec![], vec![DVec3::NAN; 7], vec![DVec3::INFINITY; n + 3]] {
                    let weights = vec![2.0; dirt.len()];
                    let mut buffer = PointSet { points: dirt, weights };
                    step.sample_into(&mut streams.realization(1), &mut buffer).expect(&case);
                    assert!(bit_identical(&points, &buffer.points), "{case}: not the same again");
                    assert_eq!(buffer.weights, [], "{case}");
                }
                // Through a mutable buffer that holds another realization.
                let mut buffer = PointSet::new(sample(&step, 2).expect(&case));
                assert!(
                    !bit_identical(&points, &buffer.points),
                    "{case}: two realizations are the same"
                );
                step.sample_into(&mut streams.realization(1), &mut buffer).expect(&case);
                assert!(bit_identical(&points, &buffer.points), "{case}: not the same again");
            }
        }
    }
}

fn bit_identical(a: &[DVec3], b: &[DVec3]) -> bool {
    let bits = |points: &[DVec3]| -> Vec<_> {
        points.iter().map(|p| p.to_array().map(f64::to_bits)).collect()
    };
    bits(a) == bits(b)
}

/// Compares with the distances to all other points.
#[test]
fn cores_keep_points_apart() {
    for domain in DOMAINS {
        for control in [
            SpectralControl::step(200, domain, None, None),
            SpectralControl::blue(200, domain, Some(0.8)),
        ] {
            let control = control.expect("valid parameters");
            let points = sample(&control, 3).expect("a realization");
            // The remaining overlap is at most sqrt(N 5e-21) of the minimum chord.
            let chord = control.core_chord() * (1.0 - 1e-8);
            for (i, p) in points.iter().enumerate() {
                for q in &points[..i] {
                    let apart = match domain {
                        Domain::Sphere => p.distance(*q),
                        Domain::Hemisphere => p.distance(*q).min(p.distance(-*q)),
                    };
                    assert!(apart >= chord, "{control:?}: {p} and {q} are {apart} apart");
                }
            }
        }
    }
}

/// Returns the power `P(l) = (4 pi/N)/(2l+1) sum_m |a_lm|^2` by the exact transform, not the one
/// descents use.
fn power(points: &[DVec3], lmax: usize) -> Vec<f64> {
    let alm = ExactTransform::new(lmax).expect("a low degree").adjoint(points, None);
    let power = alm.expect("a small table").power_per_degree();
    power.into_iter().map(|p| 4.0 * std::f64::consts::PI / points.len() as f64 * p).collect()
}

/// No power at any degree `l <= alpha sqrt(N)`, integer products included, for numbers of points
/// around squares and between; the degree after the reported last empty one has nonzero power.
#[test]
fn every_degree_to_alpha_sqrt_n_is_empty() {
    let check = |control: Result<SpectralControl, Error>, hundredths: usize| {
        let control = control.expect("a set that exists");
        let (n, domain) = (control.n_points(), control.domain());
        let case = format!("{domain}, N = {n}, alpha {hundredths} %");
        let promised = (hundredths * hundredths * n * domain.degree_step()).isqrt() / 100;
        let last = control.last_empty_degree();
        assert!(last + domain.degree_step() > promised && last <= promised, "{case}: {last}");
        let points = sample(&control, 0).expect(&case);
        let power = power(&points, last + 2);
        for (l, &p) in power.iter().enumerate().skip(1).filter(|row| domain.has_degree(row.0)) {
            assert_eq!(p <= 1e-18, l <= last, "{case}, last empty {last}: P({l}) = {p:e}");
        }
    };
    for domain in DOMAINS {
        for n in [3, 4, 6, 7, 10, 11, 12, 16, 17, 25, 49, 100, 150, 169] {
            check(SpectralControl::step(n, domain, Some(1.0), None), 100);
            check(SpectralControl::blue(n, domain, Some(1.0)), 100);
        }
        for hundredths in [10, 50, 80, 110, 120] {
            let alpha = f64::from(u32::try_from(hundredths).expect("a small number")) / 100.0;
            check(SpectralControl::step(150, domain, Some(alpha), None), hundredths);
        }
    }
}

/// Where no set has zero power up to sqrt(N), the default alpha is the largest feasible one and the
/// last empty degree is reported; a given alpha is an error that states the largest one, which
/// works.
#[test]
fn alphas_beyond_the_freedom_name_the_largest() {
    for (domain, n, last) in [
        (Domain::Sphere, 1, 0),
        (Domain::Sphere, 5, 1),
        (Domain::Sphere, 9, 2),
        (Domain::Hemisphere, 2, 0),
        (Domain::Hemisphere, 8, 2),
    ] {
        for control in
            [SpectralControl::step(n, domain, None, None), SpectralControl::blue(n, domain, None)]
        {
            let control = control.expect("what is possible");
            assert_eq!(control.last_empty_degree(), last, "{domain}, N = {n}");
            let points = sample(&control, 0).expect("a realization");
            let power = power(&points, last);
            let degrees = (1..=last).filter(|&l| domain.has_degree(l));
            assert!(degrees.map(|l| power[l]).all(|p| p <= 1e-18), "{domain}, N = {n}: {power:?}");
        }
        assert!(SpectralControl::step(n, domain, Some(1.0), None).is_err(), "{domain}, N = {n}");
    }
    for domain in DOMAINS {
        for n in [5, 9, 53, 100, 227, 5252] {
            let largest = SpectralControl::max_alpha(n, domain).expect("a number of points");
            if largest < SpectralControl::MAX_ALPHA {
                let requested = Some(largest + 1e-5);
                for result in [
                    SpectralControl::step(n, domain, requested, None),
                    SpectralControl::blue(n, domain, requested),
                ] {
                    let Err(Error::Infeasible { reason, .. }) = result else {
                        panic!("{domain}, N = {n}, alpha {requested:?}: {result:?}");
                    };
                    assert!(reason.contains(&largest.to_string()), "{reason}");
                }
            }
            let step = SpectralControl::step(n, domain, Some(largest), None);
            let max_degree = SpectralControl::max_empty_degree(n, domain);
            assert_eq!(step.map(|s| s.last_empty_degree()), max_degree, "{domain}, N = {n}");
        }
    }
}
