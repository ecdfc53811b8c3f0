//! The closed forms of the variance against sums over degrees, and the identities between them.

use proptest::prelude::{Just, Strategy, prop_assert, prop_oneof, proptest};
use sphvar_bounds::{
    Domain, Error, IntegrandClass, Profile, ProfileShape, generalized_harmonic, hurwitz_zeta,
    trigamma, variance_bound,
};

/// sqrt N = 64 exactly, so `alpha = L / 64` puts the break at any chosen L, including integers.
const N_POINTS: usize = 4096;
const BREAKS: [f64; 15] =
    [0.4, 0.5, 1.0, 1.5, 2.0, 2.75, 3.0, 7.0, 16.0, 33.25, 64.0, 100.5, 1000.0, 9999.5, 1e4];
const EXPONENTS: [f64; 9] = [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 7.0];
const DECAYS: [f64; 3] = [2.0, 2.5, 3.0];
const DOMAINS: [Domain; 2] = [Domain::Sphere, Domain::Hemisphere];

/// The closed form and the slow sum are each accurate to about 1e-14; the break enters with b = 7
/// at most.
const TOLERANCE: f64 = 1e-12;

fn shapes() -> Vec<ProfileShape> {
    let mut shapes = vec![ProfileShape::Constant, ProfileShape::Step];
    shapes.extend(EXPONENTS.map(|exponent| ProfileShape::Polynomial { exponent }));
    shapes
}

fn close(value: f64, expected: f64) -> bool {
    (value - expected).abs() <= TOLERANCE * expected.abs()
}

/// Kahan summation, so that the reference is more accurate than the tested value.
fn kahan(terms: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut lost) = (0.0_f64, 0.0_f64);
    for term in terms {
        let corrected = term - lost;
        let next = sum + corrected;
        lost = (next - sum) - corrected;
        sum = next;
    }
    sum
}

/// Returns the definition: every degree up to `last`, then the plateau times the tail energy of
/// `c l^-p`.
///
/// The tail is the midpoint rule for the integral of x^-p with its first correction; from degree
/// 3e4 on, the next correction is below 1e-17 of it.
fn slow_variance(
    class: &IntegrandClass,
    decays: &[(f64, f64)],
    profile: &Profile,
    domain: Domain,
    last: usize,
) -> f64 {
    slow_variance_of(N_POINTS, class, decays, profile, domain, last)
}

fn slow_variance_of(
    n_points: usize,
    class: &IntegrandClass,
    decays: &[(f64, f64)],
    profile: &Profile,
    domain: Domain,
    last: usize,
) -> f64 {
    let (first, step) = (domain.degree_step(), domain.degree_step());
    let body =
        kahan((first..=last).step_by(step).map(|l| class.energy(l) * profile.power(l, n_points)));
    let count = (last / step) as f64;
    let tail: f64 = decays
        .iter()
        .map(|&(c, p)| {
            let x = count + 0.5;
            c * (step as f64).powf(-p) * (x.powf(1.0 - p) / (p - 1.0) - p / 24.0 * x.powf(-p - 1.0))
        })
        .sum();
    domain.variance_factor(n_points) * (body + tail * profile.supremum())
}

#[test]
fn band_limited_closed_forms_equal_the_sums() -> Result<(), Error> {
    for shape in shapes() {
        for break_degree in BREAKS {
            let profile = Profile::new(shape, break_degree / 64.0, 1.25)?;
            // Bands below, at and above the break.
            for last in [0, 1, 2, 3, 4, 7, 8, 16, 31, 64, 101, 500, 1000, 12_000] {
                let class = IntegrandClass::band_limited(0.75, last)?;
                for domain in DOMAINS {
                    let value = class.variance(&profile, N_POINTS, domain);
                    let slow = slow_variance(&class, &[], &profile, domain, last);
                    assert!(
                        close(value, slow),
                        "{shape:?} L {break_degree} l0 {last} {domain:?}: {value:e} {slow:e}"
                    );
                }
            }
        }
    }
    Ok(())
}

#[test]
fn closed_forms_with_tails_equal_the_sums() -> Result<(), Error> {
    const LAST: usize = 30_000;
    for shape in shapes() {
        for break_degree in BREAKS {
            let profile = Profile::new(shape, break_degree / 64.0, 1.25)?.with_offset(0.03125)?;
            let mut classes =
                vec![(IntegrandClass::cubic_power(0.5)?, vec![(1.0, 2.0), (0.5, 3.0)])];
            for p in DECAYS {
                classes.push((IntegrandClass::power_law(3.0, p)?, vec![(3.0, p)]));
            }
            for last in [5, 40] {
                classes.push((
                    IntegrandClass::flat_then_power_law(0.75, last, 3.0, 2.0)?,
                    vec![(3.0, 2.0)],
                ));
            }
            for (class, decays) in classes {
                for domain in DOMAINS {
                    let value = class.variance(&profile, N_POINTS, domain);
                    let slow = slow_variance(&class, &decays, &profile, domain, LAST);
                    assert!(
                        close(value, slow),
                        "{class:?} {shape:?} L {break_degree} {domain:?}: {value:e} {slow:e}"
                    );
                }
            }
        }
    }
    Ok(())
}

/// The formulas of the table, one by one, on the sphere.
#[test]
fn closed_forms_match_the_table() -> Result<(), Error> {
    let scale = Domain::Sphere.variance_factor(N_POINTS);
    for break_degree in BREAKS {
        let (alpha, n) = (break_degree / 64.0, break_degree.floor());
        let n_whole = (0..=10_000_u64).rev().find(|&k| k as f64 <= break_degree).unwrap_or(0);
        for l0 in [1_usize, 5, 63, 64, 70] {
            let x = l0 as f64;
            let class = IntegrandClass::band_limited(1.0, l0)?;
            let variance =
                |profile: Profile| class.variance(&profile, N_POINTS, Domain::Sphere) / scale;
            let constant = variance(Profile::constant(1.0)?);
            assert!(close(constant, x * (x + 2.0)), "constant, l0 {l0}: {constant}");
            let ceil = break_degree.ceil();
            let expected = if x >= ceil { (x + 1.0).powi(2) - ceil * ceil } else { 0.0 };
            let step = variance(Profile::step(alpha, 1.0)?);
            assert!(close(step, expected), "step, l0 {l0} L {break_degree}: {step} {expected}");
            for b in EXPONENTS {
                let risen = |m: u64| {
                    (2.0 * generalized_harmonic(m, -b - 1.0) + generalized_harmonic(m, -b))
                        / break_degree.powf(b)
                };
                let expected = if x <= break_degree {
                    risen(l0 as u64)
                } else {
                    risen(n_whole) + x * (x + 2.0) - n * (n + 2.0)
                };
                let value = variance(Profile::polynomial(b, alpha, 1.0)?);
                assert!(
                    close(value, expected),
                    "b {b}, l0 {l0} L {break_degree}: {value} {expected}"
                );
            }
        }
        for p in DECAYS {
            let class = IntegrandClass::power_law(1.0, p)?;
            let variance =
                |profile: Profile| class.variance(&profile, N_POINTS, Domain::Sphere) / scale;
            let step = variance(Profile::step(alpha, 1.0)?);
            assert!(
                close(step, hurwitz_zeta(p, break_degree.ceil())),
                "step, p {p} L {break_degree}: {step}"
            );
            for b in EXPONENTS {
                let expected = generalized_harmonic(n_whole, p - b) / break_degree.powf(b)
                    + hurwitz_zeta(p, n + 1.0);
                let value = variance(Profile::polynomial(b, alpha, 1.0)?);
                assert!(
                    close(value, expected),
                    "b {b}, p {p} L {break_degree}: {value} {expected}"
                );
            }
        }
        let quadratic = IntegrandClass::power_law(1.0, 2.0)?.variance(
            &Profile::quadratic(alpha, 1.0)?,
            N_POINTS,
            Domain::Sphere,
        ) / scale;
        let expected = n / break_degree.powi(2) + trigamma(n + 1.0);
        assert!(close(quadratic, expected), "b = p = 2, L {break_degree}: {quadratic} {expected}");
    }
    // Best case of the quadratic profile as a polynomial: l0 (l0+1) (3 l0^2 + 5 l0 + 1) / (6 L^2).
    let class = IntegrandClass::band_limited(1.0, 10)?;
    let value = class.variance(&Profile::quadratic(0.5, 1.0)?, N_POINTS, Domain::Sphere) / scale;
    assert!(close(value, 110.0 * 351.0 / (6.0 * 1024.0)), "quadratic best case: {value}");
    Ok(())
}

/// The hemisphere's best case: J = floor(min(l0, L) / 2), K = floor(l0 / 2).
#[test]
fn hemisphere_best_case_matches_the_table() -> Result<(), Error> {
    for break_degree in [1.0_f64, 3.0, 16.0, 33.25, 64.0] {
        for l0 in [2_u64, 3, 15, 16, 40, 101] {
            for b in EXPONENTS {
                let floor = (0..100_u64).rev().find(|&k| k as f64 <= break_degree).unwrap_or(0);
                let (j, k) = (l0.min(floor) / 2, l0 / 2);
                let (jf, kf) = (j as f64, k as f64);
                let risen = 4.0 * generalized_harmonic(j, -b - 1.0) + generalized_harmonic(j, -b);
                let expected = b.exp2() * risen / break_degree.powf(b)
                    + (kf * (2.0 * kf + 3.0) - jf * (2.0 * jf + 3.0));
                let class = IntegrandClass::band_limited(1.0, usize::try_from(l0).unwrap_or(0))?;
                let profile = Profile::polynomial(b, break_degree / 64.0, 1.0)?;
                let value = class.variance(&profile, N_POINTS, Domain::Hemisphere)
                    / Domain::Hemisphere.variance_factor(N_POINTS);
                assert!(
                    close(value, expected),
                    "b {b} L {break_degree} l0 {l0}: {value} {expected}"
                );
            }
        }
    }
    Ok(())
}

#[test]
fn extreme_parameters_give_finite_sums_or_errors() -> Result<(), Error> {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0] {
        assert!(IntegrandClass::band_limited(bad, 3).is_err(), "power {bad}");
        assert!(IntegrandClass::power_law(bad, 2.0).is_err(), "scale {bad}");
        assert!(IntegrandClass::power_law(1.0, bad).is_err(), "decay {bad}");
        assert!(IntegrandClass::cubic_power(bad).is_err(), "scale {bad}");
        assert!(IntegrandClass::flat_then_power_law(1.0, 3, 1.0, bad).is_err(), "decay {bad}");
    }
    assert!(IntegrandClass::power_law(1.0, 1.0).is_err(), "decay 1 has infinite energy");
    let classes = [
        IntegrandClass::band_limited(1.0, usize::MAX)?,
        IntegrandClass::band_limited(1.0, 0)?,
        IntegrandClass::power_law(1.0, 1.0 + 1e-12)?,
        IntegrandClass::power_law(1.0, 500.0)?,
        IntegrandClass::cubic_power(1.0)?,
        IntegrandClass::flat_then_power_law(1.0, usize::MAX - 1, 1.0, 3.0)?,
    ];
    let mut profiles = Vec::new();
    for alpha in [1e-300, 1e-3, 1e3, 1e300] {
        for shape in [ProfileShape::Constant, ProfileShape::Step].into_iter().chain(
            [0.0, 1e-300, 1.0, 1e3, 1e9, 1e300]
                .map(|exponent| ProfileShape::Polynomial { exponent }),
        ) {
            profiles.push(Profile::new(shape, alpha, 1.0)?);
            profiles.push(Profile::new(shape, alpha, 0.0)?.with_offset(1.0)?);
        }
    }
    for class in classes {
        for profile in &profiles {
            for n_points in [1, 2, 1_000_000_000_000, usize::MAX] {
                for domain in DOMAINS {
                    let value = class.variance(profile, n_points, domain);
                    let white = class.variance(&Profile::constant(1.0)?, n_points, domain);
                    assert!(
                        value >= 0.0 && value <= white * (1.0 + TOLERANCE),
                        "{class:?} {profile:?} N {n_points} {domain:?}: {value:e}, white {white:e}"
                    );
                    if let Some(asymptotic) = class.asymptotic_variance(profile, n_points, domain) {
                        assert!(
                            !asymptotic.variance.is_nan(),
                            "{class:?} {profile:?} N {n_points} {domain:?}"
                        );
                    }
                    let rate = class.rate(profile, domain);
                    assert!(!rate.to_string().contains("NaN"), "{class:?} {profile:?}: {rate}");
                }
            }
        }
        assert!(class.variance(&profiles[0], 0, Domain::Sphere).is_infinite(), "no points");
    }
    Ok(())
}

#[test]
fn given_integrand_is_bounded_by_its_class() -> Result<(), Error> {
    // The energies of the class with their exact tail: the range must contain the closed form.
    let class = IntegrandClass::power_law(2.0, 2.0)?;
    for (domain, tail) in
        [(Domain::Sphere, 2.0 * trigamma(101.0)), (Domain::Hemisphere, 0.5 * trigamma(51.0))]
    {
        let energies: Vec<f64> = (0..=100).map(|l| class.energy(l)).collect();
        for shape in shapes() {
            for break_degree in BREAKS {
                let profile = Profile::new(shape, break_degree / 64.0, 0.8)?.with_offset(0.1)?;
                let exact = class.variance(&profile, N_POINTS, domain);
                let range = variance_bound(&profile, N_POINTS, domain, &energies, tail)?;
                let context = format!("{shape:?} L {break_degree} {domain:?}: {range:?} {exact:e}");
                assert!(range.lower <= exact * (1.0 + TOLERANCE), "{context}");
                assert!(range.upper >= exact * (1.0 - TOLERANCE), "{context}");
                // If the plateau begins within the listed degrees, the range is a point.
                if break_degree <= 100.5 {
                    assert!(close(range.lower, exact) && close(range.upper, exact), "{context}");
                }
            }
        }
    }
    let profile = Profile::linear(1.0, 1.0)?;
    for (energies, tail) in
        [(vec![0.0, f64::NAN], 0.0), (vec![0.0, -1.0], 0.0), (vec![], f64::NAN), (vec![], -1.0)]
    {
        assert!(
            variance_bound(&profile, 4, Domain::Sphere, &energies, tail).is_err(),
            "{energies:?} {tail}"
        );
    }
    assert_eq!(variance_bound(&profile, 0, Domain::Sphere, &[], 0.0), Err(Error::NoPoints));
    // All energy in the tail: from the first degree, 1/2 on the sphere and 2/2 on the hemisphere,
    // to the plateau.
    let sphere = variance_bound(&profile, 4, Domain::Sphere, &[], 1.0)?;
    assert!(close(sphere.upper, 2.0 * sphere.lower), "{sphere:?}");
    let hemisphere = variance_bound(&profile, 4, Domain::Hemisphere, &[1.0, 1.0], 1.0)?;
    assert!(close(hemisphere.upper, hemisphere.lower), "{hemisphere:?}");
    // Beyond lmax = 2 the next existing degree is 4, half way to the break at 8.
    let next = variance_bound(&profile, 64, Domain::Hemisphere, &[0.0; 3], 1.0)?;
    assert!(close(next.upper, 2.0 * next.lower), "{next:?}");
    Ok(())
}

fn any_profile() -> impl Strategy<Value = Profile> {
    let shape = prop_oneof![
        Just(ProfileShape::Constant),
        Just(ProfileShape::Step),
        (0.0..8.0_f64).prop_map(|exponent| ProfileShape::Polynomial { exponent }),
    ];
    (shape, -3.0..3.0_f64, 0.0..4.0_f64).prop_filter_map("valid", |(shape, log_alpha, gamma)| {
        Profile::new(shape, log_alpha.exp(), gamma).ok()
    })
}

fn any_class() -> impl Strategy<Value = IntegrandClass> {
    prop_oneof![
        (0_usize..200).prop_map(|last| IntegrandClass::band_limited(1.0, last)),
        (1.1..4.0_f64).prop_map(|p| IntegrandClass::power_law(1.0, p)),
        Just(1.0).prop_map(IntegrandClass::cubic_power),
        (0_usize..200, 1.1..4.0_f64)
            .prop_map(|(last, p)| IntegrandClass::flat_then_power_law(1.0, last, 0.5, p)),
    ]
    .prop_filter_map("valid", Result::ok)
}

fn any_domain() -> impl Strategy<Value = Domain> {
    prop_oneof![Just(Domain::Sphere), Just(Domain::Hemisphere)]
}

proptest! {
    #[test]
    fn every_closed_form_equals_its_sum(
        profile in any_profile(), g0 in prop_oneof![Just(0.0), 0.0..1.0_f64], domain in any_domain(),
        n in 1_usize..20_000, l0 in 0_usize..3000, p in 1.1..4.0_f64, a in 0.01..3.0_f64, c in 0.01..3.0_f64
    ) {
        // Breaks reach e^3 sqrt(20000) = 2841, and from 5000 on the first neglected term of the
        // tail is below 1e-15.
        const LAST: usize = 5000;
        let Ok(profile) = profile.with_offset(g0) else { unreachable!("valid") };
        for (class, decays) in [
            (IntegrandClass::band_limited(a, l0), vec![]),
            (IntegrandClass::power_law(c, p), vec![(c, p)]),
            (IntegrandClass::cubic_power(c), vec![(2.0 * c, 2.0), (c, 3.0)]),
            (IntegrandClass::flat_then_power_law(a, l0, c, p), vec![(c, p)]),
        ] {
            let Ok(class) = class else { unreachable!("valid") };
            let value = class.variance(&profile, n, domain);
            let slow = slow_variance_of(n, &class, &decays, &profile, domain, LAST);
            prop_assert!(close(value, slow), "{class:?} {profile:?} N {n} {domain:?}: {value:e} {slow:e}");
        }
    }

    #[test]
    fn variance_is_linear_in_gamma_and_offset(
        profile in any_profile(), class in any_class(), domain in any_domain(), n in 1_usize..1_000_000, g0 in 0.0..2.0_f64
    ) {
        let variance = |p: Profile| class.variance(&p, n, domain);
        let (Ok(unit), Ok(white)) = (profile.with_gamma(1.0), Profile::constant(g0)) else { unreachable!("valid") };
        let Ok(lifted) = profile.with_offset(g0) else { unreachable!("valid") };
        let plain = variance(profile);
        prop_assert!(close(plain, profile.gamma() * variance(unit)), "gamma scales");
        prop_assert!(close(variance(lifted), plain + variance(white)), "offset adds");
    }

    #[test]
    fn variance_falls_with_points_and_with_the_exponent(
        profile in any_profile(), class in any_class(), domain in any_domain(), n in 1_usize..1_000_000, b in 0.0..8.0_f64
    ) {
        let slack = 1.0 + TOLERANCE;
        let here = class.variance(&profile, n, domain);
        prop_assert!(class.variance(&profile, n + 1, domain) <= here * slack, "more points");
        let at = |b: f64| Profile::polynomial(b, profile.alpha(), profile.gamma()).map(|p| class.variance(&p, n, domain));
        let (Ok(low), Ok(high)) = (at(b), at(b + 0.5)) else { unreachable!("valid") };
        prop_assert!(high <= low * slack, "steeper rise: {high:e} {low:e}");
    }

    #[test]
    fn steep_polynomials_tend_to_the_step(class in any_class(), domain in any_domain(), twice in 1_u32..200) {
        // Breaks at halves and wholes; below the break (l/L)^b is at most (1 - 1/200)^1e6.
        let alpha = f64::from(twice) / 128.0;
        let (Ok(steep), Ok(step)) = (Profile::polynomial(1e6, alpha, 1.0), Profile::step(alpha, 1.0)) else {
            unreachable!("valid")
        };
        let (value, limit) = (class.variance(&steep, N_POINTS, domain), class.variance(&step, N_POINTS, domain));
        prop_assert!(close(value, limit) || value < 1e-300, "L = {twice}/2: {value:e} {limit:e}");
    }

    #[test]
    fn hemisphere_is_the_sphere_at_half_the_break(profile in any_profile(), p in 1.1..4.0_f64, n in 1_usize..250_000) {
        // W_p^H(L) = 2^-p W_p(L/2): a quarter of the points halves L, and the prefactors are pi/4n
        // and 4 pi/n.
        let Ok(class) = IntegrandClass::power_law(1.0, p) else { unreachable!("valid") };
        let hemisphere = class.variance(&profile, 4 * n, Domain::Hemisphere);
        let sphere = class.variance(&profile, n, Domain::Sphere);
        // 4n and n have the same break, since sqrt(4n) = 2 sqrt(n) exactly.
        prop_assert!(close(hemisphere, sphere * (-p).exp2() / 16.0), "{hemisphere:e} {sphere:e}");
    }
}
