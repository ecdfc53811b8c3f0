use sphvar_integrands::{Domain, Expression, WarpExpression};

use super::Sky;

fn proposed(text: &str, domain: Domain) -> Vec<String> {
    let integrand: Expression = text.parse().unwrap();
    let warps = WarpExpression::proposed(&integrand, domain);
    for warp in &warps {
        // Texts name the same warps, which can be built.
        assert_eq!(warp.to_string().parse::<WarpExpression>().unwrap(), *warp);
        let strategies = warp.strategies(domain, &Sky);
        assert!(strategies.is_ok(), "{text}: {warp}: {strategies:?}");
    }
    warps.iter().map(WarpExpression::to_string).collect()
}

#[test]
fn densities_follow_from_the_integrand() {
    let (sphere, hemisphere) = (Domain::Sphere, Domain::Hemisphere);
    let constant = "env:a.exr,interpolation=constant";
    for (text, domain, expected) in [
        (
            "env:a.exr * cosine",
            hemisphere,
            &[
                "env:a.exr * cosine",
                &format!("{constant} * cosine"),
                "env:a.exr",
                constant,
                "cosine",
                "env:a.exr + cosine",
                "cylinder",
                "octahedral",
            ][..],
        ),
        // The cosine has another axis.
        (
            "cosine * env:a.exr,up=y,channel=rgb",
            hemisphere,
            &[
                "env:a.exr,up=y",
                "env:a.exr,up=y,interpolation=constant",
                "cosine",
                "env:a.exr,up=y + cosine",
                "cylinder",
                "octahedral",
            ],
        ),
        ("ylm:l=4", sphere, &["cylinder", "octahedral"]),
        ("3", sphere, &["cylinder", "octahedral"]),
        ("abs-cosine", hemisphere, &["cosine", "cylinder", "octahedral"]),
        ("abs-cosine", sphere, &["cylinder", "octahedral"]),
        (
            "half-space:height=0.5",
            sphere,
            &["cap:degrees=60.00000000000001", "cylinder", "octahedral"],
        ),
        (
            "0.2 * vmf:kappa=50 @ 40/10 - 3 * phong:n=9 + 1",
            sphere,
            &[
                "vmf:kappa=50 @ 40/10",
                "phong:n=9",
                "vmf:kappa=50 @ 40/10 + phong:n=9 + cylinder",
                "cylinder",
                "octahedral",
            ],
        ),
        ("vmf:kappa=5 + vmf:kappa=5", hemisphere, &["vmf:kappa=5", "cylinder", "octahedral"]),
        (
            "filtered:fwhm=5,of=\"vmf:kappa=50 @ 40/10\" @ 20/0",
            hemisphere,
            &["vmf:kappa=50 @ 40/10 @ 20/0", "cylinder", "octahedral"],
        ),
    ] {
        assert_eq!(proposed(text, domain), expected, "{text}");
    }
}

#[test]
fn long_sums_are_proposed_without_their_combination() {
    let sum: Vec<String> = (1..=70).map(|k| format!("vmf:kappa={k}")).collect();
    let texts = proposed(&sum.join(" + "), Domain::Sphere);
    assert_eq!(texts.len(), 72);
}
