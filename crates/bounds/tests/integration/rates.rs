//! Rates and large-N forms against the closed forms.

use sphvar_bounds::{ConvergenceRate, Domain, Error, IntegrandClass, Profile};

const DOMAINS: [Domain; 2] = [Domain::Sphere, Domain::Hemisphere];

fn slope(class: &IntegrandClass, profile: &Profile, domain: Domain, from: usize, to: usize) -> f64 {
    let ratio = class.variance(profile, to, domain) / class.variance(profile, from, domain);
    ratio.ln() / (to as f64 / from as f64).ln()
}

#[test]
fn rates_match_the_table() -> Result<(), Error> {
    let plain = |exponent| ConvergenceRate::Algebraic { exponent, log: false };
    let best = IntegrandClass::band_limited(1.0, 5)?;
    let worst = IntegrandClass::power_law(1.0, 2.0)?;
    let steep = IntegrandClass::power_law(1.0, 2.5)?;
    let model = IntegrandClass::cubic_power(1.0)?;
    let both = IntegrandClass::flat_then_power_law(1.0, 5, 1.0, 2.0)?;
    for domain in DOMAINS {
        let beyond = if domain == Domain::Sphere { 25.0 / 4.0 } else { 16.0 / 4.0 };
        for (profile, expected) in [
            (Profile::constant(2.0)?, [plain(-1.0), plain(-1.0), plain(-1.0)]),
            (
                Profile::step(2.0, 1.0)?,
                [ConvergenceRate::Zero { beyond }, plain(-1.5), plain(-1.75)],
            ),
            (Profile::polynomial(0.5, 2.0, 1.0)?, [plain(-1.25), plain(-1.25), plain(-1.25)]),
            (
                Profile::linear(2.0, 1.0)?,
                [
                    plain(-1.5),
                    ConvergenceRate::Algebraic { exponent: -1.5, log: true },
                    plain(-1.5),
                ],
            ),
            (
                Profile::polynomial(1.5, 2.0, 1.0)?,
                [
                    plain(-1.75),
                    plain(-1.5),
                    ConvergenceRate::Algebraic { exponent: -1.75, log: true },
                ],
            ),
            (Profile::quadratic(2.0, 1.0)?, [plain(-2.0), plain(-1.5), plain(-1.75)]),
            (Profile::polynomial(7.0, 2.0, 1.0)?, [plain(-4.5), plain(-1.5), plain(-1.75)]),
            (
                Profile::quadratic(2.0, 1.0)?.with_offset(0.1)?,
                [plain(-1.0), plain(-1.0), plain(-1.0)],
            ),
            (Profile::step(2.0, 0.0)?.with_offset(0.1)?, [plain(-1.0), plain(-1.0), plain(-1.0)]),
        ] {
            let found = [best, worst, steep].map(|class| class.rate(&profile, domain));
            assert_eq!(found, expected, "{profile:?} {domain:?}");
            for class in [model, both] {
                assert_eq!(
                    class.rate(&profile, domain),
                    expected[1],
                    "{class:?} {profile:?} {domain:?}"
                );
            }
        }
        let never = ConvergenceRate::Zero { beyond: 0.0 };
        assert_eq!(worst.rate(&Profile::constant(0.0)?, domain), never, "zero profile");
        assert_eq!(
            IntegrandClass::band_limited(1.0, 0)?.rate(&Profile::constant(1.0)?, domain),
            never,
            "no band"
        );
        assert_eq!(
            IntegrandClass::power_law(0.0, 2.0)?.rate(&Profile::constant(1.0)?, domain),
            never,
            "no energy"
        );
        // Absent energy must not determine the rate.
        let headless = IntegrandClass::flat_then_power_law(1.0, 5, 0.0, 2.0)?;
        assert_eq!(
            headless.rate(&Profile::step(2.0, 1.0)?, domain),
            ConvergenceRate::Zero { beyond },
            "flat head only"
        );
    }
    let odd = IntegrandClass::band_limited(1.0, 1)?;
    assert_eq!(
        odd.rate(&Profile::constant(1.0)?, Domain::Hemisphere),
        ConvergenceRate::Zero { beyond: 0.0 },
        "no even degree"
    );
    Ok(())
}

#[test]
fn a_step_is_zero_exactly_beyond_its_rate() -> Result<(), Error> {
    let class = IntegrandClass::band_limited(1.0, 6)?;
    for domain in DOMAINS {
        // (6 / 0.5)^2 = 144, all exact.
        let profile = Profile::step(0.5, 1.0)?;
        assert_eq!(class.rate(&profile, domain), ConvergenceRate::Zero { beyond: 144.0 });
        assert!(class.variance(&profile, 144, domain) > 0.0, "{domain:?}: at the break");
        assert_eq!(
            class.variance(&profile, 145, domain).to_bits(),
            0.0_f64.to_bits(),
            "{domain:?}: beyond"
        );
    }
    Ok(())
}

#[test]
fn local_slopes_match_recorded_values() -> Result<(), Error> {
    // Slopes from 1e6 to 1e8 points of the worst case, alpha = 1, to three digits.
    let class = IntegrandClass::power_law(1.0, 2.0)?;
    for (b, expected) in [(0.5, -1.248), (1.0, -1.448), (1.5, -1.498), (2.0, -1.5), (4.0, -1.5)] {
        let profile = Profile::polynomial(b, 1.0, 1.0)?;
        let found = slope(&class, &profile, Domain::Sphere, 1_000_000, 100_000_000);
        assert!((found - expected).abs() < 0.001, "b {b}: slope {found}, recorded {expected}");
    }
    Ok(())
}

#[test]
fn slopes_approach_the_rate() -> Result<(), Error> {
    let classes = [
        IntegrandClass::band_limited(1.0, 20)?,
        IntegrandClass::power_law(1.0, 2.0)?,
        IntegrandClass::power_law(1.0, 3.0)?,
        IntegrandClass::cubic_power(1.0)?,
        // A head small enough for the logarithm of the tail to be visible at these N.
        IntegrandClass::flat_then_power_law(1e-4, 20, 1.0, 2.0)?,
    ];
    let (from, to) = (10_000_000_000_000, 1_000_000_000_000_000);
    for class in classes {
        for b in [0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 7.0] {
            for domain in DOMAINS {
                let profile = Profile::polynomial(b, 0.5, 1.0)?;
                let ConvergenceRate::Algebraic { exponent, log } = class.rate(&profile, domain)
                else {
                    panic!("{class:?} b {b} {domain:?}: a polynomial never gives zero");
                };
                // The slope of N^e ln N between these two N is approximately e + 1 / ln N.
                let expected = exponent + if log { 1.0 / (1e14_f64).ln() } else { 0.0 };
                let found = slope(&class, &profile, domain, from, to);
                assert!(
                    (found - expected).abs() < 0.01,
                    "{class:?} b {b} {domain:?}: {found}, expected {expected}"
                );
            }
        }
    }
    Ok(())
}

#[test]
fn large_n_forms_are_within_twice_the_remainder() -> Result<(), Error> {
    let mut tested = 0;
    for p in [1.25, 2.0, 2.5, 3.0] {
        let classes = [
            IntegrandClass::power_law(2.0, p)?,
            IntegrandClass::cubic_power(2.0)?,
            IntegrandClass::flat_then_power_law(0.5, 4, 2.0, p)?,
            IntegrandClass::band_limited(0.5, 4)?,
        ];
        for class in classes {
            for b in
                [0.0, 0.25, 0.5, 1.0, 1.0 + 1e-9, 1.3, 1.5, 2.0, 2.5, 3.0, 4.0, 7.0, f64::INFINITY]
            {
                for n_points in [50, 300, 4096, 4321, 100_000, 10_000_000] {
                    for domain in DOMAINS {
                        let profile = if b.is_infinite() {
                            Profile::step(1.1, 0.7)?
                        } else {
                            Profile::polynomial(b, 1.1, 0.7)?
                        }
                        .with_offset(0.125)?;
                        let Some(form) = class.asymptotic_variance(&profile, n_points, domain)
                        else {
                            continue;
                        };
                        let exact = class.variance(&profile, n_points, domain);
                        // Rounding: the sums are accurate to about 1e-14, and the terms of the form
                        // may be ten times the value.
                        let allowed = 2.0 * form.remainder + 1e-13 * exact;
                        let error = (form.variance - exact).abs();
                        assert!(
                            error <= allowed,
                            "{class:?} b {b} N {n_points} {domain:?}: {form:?}, exact {exact:e}, error {error:e}"
                        );
                        tested += 1;
                    }
                }
            }
        }
    }
    assert!(tested > 2000, "only {tested} cases are in the range of validity");
    Ok(())
}

#[test]
fn large_n_forms_match_the_table() -> Result<(), Error> {
    let class = IntegrandClass::power_law(1.0, 2.0)?;
    let l = 64.0_f64;
    let value = |profile: Profile| {
        class
            .asymptotic_variance(&profile, 4096, Domain::Sphere)
            .map(|form| form.variance / Domain::Sphere.variance_factor(4096))
    };
    // zeta(1.5), zeta(0.5) and zeta(-1) from mpmath.
    for (b, expected) in [
        (0.5, 2.6123753486854883 / 8.0 - 1.0 / l),
        (1.0, (l.ln() + 0.577215664901532861 + 1.0) / l),
        (1.5, 3.0 / l - 1.4603545088095868 / 512.0),
        (2.0, 2.0 / l - 0.5 / (l * l)),
        (3.0, 1.5 / l - 1.0 / 12.0 / (l * l * l)),
    ] {
        let found = value(Profile::polynomial(b, 1.0, 1.0)?).unwrap_or(f64::NAN);
        assert!((found - expected).abs() <= 1e-14 * expected, "b {b}: {found} {expected}");
    }
    assert_eq!(value(Profile::step(1.0, 1.0)?), Some(1.0 / l));
    // Too few points: the break lies below p + b.
    assert_eq!(class.asymptotic_variance(&Profile::quadratic(1.0, 1.0)?, 9, Domain::Sphere), None);
    assert_eq!(class.asymptotic_variance(&Profile::quadratic(1.0, 1.0)?, 0, Domain::Sphere), None);
    Ok(())
}
