use sphvar_integrands::{
    Domain, EnvironmentParameters, Error, IntegrandResolver, Interpolation, NoFiles,
    WarpExpression, WarpTerm,
};

use super::{Picture, Sky, message};

/// Every warp with parameters that are not the default ones.
const TERMS: [&str; 9] = [
    "cylinder",
    "octahedral",
    "cosine",
    "cap:degrees=30",
    "phong:n=3.5",
    "vmf:kappa=50",
    "env:sky.exr",
    "env:\"a,b + c.exr\",channel=r,layer=front,up=y,mirror=yes,rotate=-30,interpolation=constant,floor=0.1",
    "env:\"caf\\xe9 \\\".exr\",projection=octahedral,up=-z",
];

const DOMAINS: [Domain; 2] = [Domain::Sphere, Domain::Hemisphere];

#[test]
fn every_warp_has_a_text_and_a_map_on_both_domains() {
    for text in TERMS {
        let term: WarpTerm = text.parse().unwrap();
        assert_eq!(term.to_string(), text);
        for domain in DOMAINS {
            let warp = term.build(domain, &Sky).unwrap();
            let sample = warp.sample([0.3, 0.6]);
            assert!((sample.density / warp.density(sample.point) - 1.0).abs() < 1e-12, "{text}");
            assert!((sample.point.length() - 1.0).abs() < 1e-15, "{text}");
        }
    }
    for term in WarpTerm::all() {
        let is_tested = TERMS.iter().any(|text| text.split(':').next() == Some(term.name()));
        assert!(is_tested, "{term}");
        assert_eq!(term.to_string().parse::<WarpTerm>().unwrap(), term);
        assert!(!term.summary().is_empty() && term.form().starts_with(term.name()));
        assert!(term.parameters().iter().all(|parameter| !parameter.summary.ends_with('.')));
    }
}

#[test]
fn uniform_maps_caps_and_pictures_are_restricted_to_the_hemisphere() {
    for text in [
        "cylinder",
        "octahedral",
        "cap:degrees=120",
        "env:a.exr",
        "env:a.exr,floor=0.2 @ 0/30",
        "cylinder @ 0/30",
    ] {
        let expression: WarpExpression = text.parse().unwrap();
        let strategies = expression.strategies(Domain::Hemisphere, &Sky).unwrap();
        for k in 0..100 {
            let point = [f64::from(k) / 100.0, f64::from(k * 37 % 100) / 100.0];
            assert!(strategies[0].warp.map(point).z >= 0.0, "{text}");
        }
    }
    // These have another axis.
    for text in ["cylinder @ 90/0", "env:a.exr,up=y", "cap:degrees=60 @ 180/0"] {
        let expression: WarpExpression = text.parse().unwrap();
        let warp = expression.strategies(Domain::Hemisphere, &Sky).unwrap()[0].warp.clone();
        let point = |k: u32| [f64::from(k) / 100.0, f64::from(k * 37 % 100) / 100.0];
        let below = (0..100).filter(|&k| warp.map(point(k)).z < 0.0).count();
        assert!(below > 5, "{text}: {below}");
    }
}

#[test]
fn expressions_have_texts() {
    for text in [
        "cosine",
        "vmf:kappa=50 @ 40/10",
        "cap:degrees=20 @ 90/0/45 @ 10/20",
        "env:sky.exr * cosine",
        "cosine @ 30/60 * env:sky.exr,floor=0.5 @ 30/60/90",
        "cosine + env:sky.exr",
        "0.3 * cosine + 0.7 * env:\"a + b * c.exr\" * cosine",
        "1 * cosine + 3 * cylinder + 0.25 * vmf:kappa=2",
    ] {
        let expression: WarpExpression = text.parse().unwrap();
        assert_eq!(expression.to_string(), text);
        let strategies = expression.strategies(Domain::Hemisphere, &Sky).unwrap();
        assert_eq!(strategies.len(), expression.n_strategies());
        let total: f64 = strategies.iter().map(|strategy| strategy.share).sum();
        assert!((total - 1.0).abs() < 1e-15, "{text}: {total}");
    }
    let of = |text: &str| text.parse::<WarpExpression>().unwrap();
    // Equal shares and several numbers of one warp.
    assert_eq!(of("1 * cosine + 1 * cylinder"), of("cosine + cylinder"));
    assert_eq!(of("2 * 3 * cosine + cylinder * 2"), of("6 * cosine + 2 * cylinder"));
    let huge = of("1e308 * cosine + 1e308 * cylinder + 1e-308 * octahedral").shares();
    assert!((huge[0] - 0.5).abs() < 1e-15 && (huge[1] - 0.5).abs() < 1e-15, "{huge:?}");
}

#[test]
fn shares_are_replaced_and_expressions_combined() {
    let of = |text: &str| text.parse::<WarpExpression>().unwrap();
    let sum = WarpExpression::combined(&[of("cosine"), of("2 * cylinder + 3 * vmf:kappa=4")]);
    assert_eq!(sum.as_ref().unwrap().to_string(), "cosine + cylinder + vmf:kappa=4");
    let shares = sum.unwrap().with_shares(&[0.5, 0.25, 0.25]).unwrap();
    assert_eq!(shares.to_string(), "0.5 * cosine + 0.25 * cylinder + 0.25 * vmf:kappa=4");
    assert_eq!(shares.shares(), [0.5, 0.25, 0.25]);
    assert_eq!(of("cosine").with_shares(&[7.0]).unwrap(), of("cosine"));
    for wrong in [&[0.5, 0.5][..], &[1.0, 0.0, 1.0], &[1.0, f64::NAN, 1.0], &[]] {
        assert!(matches!(shares.with_shares(wrong), Err(Error::Shares { .. })), "{wrong:?}");
    }
    assert!(WarpExpression::combined(&[]).is_err());
    assert!(WarpExpression::combined(&vec![of("cosine"); 65]).is_err());
}

#[test]
fn wrong_texts_are_errors_that_name_what_is_right() {
    for (text, message) in [
        ("", "an operator has no operand"),
        (
            "cosin",
            "unknown warp \"cosin\" (did you mean \"cosine\"?); valid: cylinder, octahedral, cosine,",
        ),
        ("ylm:l=2", "unknown warp \"ylm\"; valid: cylinder"),
        ("vmf", "vmf: the parameter kappa is missing"),
        ("vmf:kapa=5", "kappa"),
        ("vmf:kappa=-1", "kappa must be in [0, 1e6], got -1"),
        ("cap:degrees=0", "degrees must be in (0, 180], got 0"),
        ("phong:n=NaN", "n must be in [0, 1e6], got NaN"),
        ("cosine:n=2", "cosine:n=2: unknown parameter \"n\"; valid: none"),
        ("env", "env: the file is missing: env:FILE"),
        ("env:a.exr,floor=1", "floor must be in [0, 1), got 1"),
        ("env:a.exr,interpolation=cubic", "valid: bilinear, constant"),
        ("env:\"a.exr", "the quote is not closed"),
        ("cosine @ 200/0", "THETA in [0, 180]"),
        ("cosine @ NaN/0", "THETA in [0, 180]"),
        ("2 * cosine", "a single warp samples all points; remove the number"),
        ("1 * cosine", "a single warp samples all points; remove the number"),
        ("0.3 * cosine + cylinder", "give every warp a share of the points, or none"),
        ("cosine + 1 * cylinder", "give every warp a share of the points, or none"),
        ("-1 * cosine + 2 * cylinder", "a share of the points must be a positive number, got -1"),
        ("cosine - cylinder", "a share of the points must be a positive number, got -1"),
        ("0 * cosine + 1 * cylinder", "a share of the points must be a positive number, got 0"),
        ("NaN * cosine + 1 * cylinder", "a share of the points must be a positive number, got NaN"),
        ("inf * cosine + 1 * cylinder", "a share of the points must be a positive number, got inf"),
        ("1e200 * 1e200 * cosine + 1 * cylinder", "a positive number, got inf"),
        ("0.5 + cosine", "the share 0.5 has no warp"),
        ("cosine +", "unknown warp \"cosine +\""),
        ("cosine + ", "an operator has no operand"),
        ("vmf:kappa=2 * vmf:kappa=3", "no map samples the product vmf:kappa=2 * vmf:kappa=3;"),
        ("cosine * cosine", "no map samples the product"),
        ("env:a.exr * env:a.exr", "a product of warps must be a map times the cosine"),
        ("env:a.exr * cosine * cosine", "no map samples the product"),
    ] {
        let error = text.parse::<WarpExpression>().unwrap_err().to_string();
        assert!(error.contains(message), "{text}: {error}");
    }
    let long = ["cosine"; 65].join(" + ");
    let error = long.parse::<WarpExpression>().unwrap_err().to_string();
    assert!(error.contains("a sum has 1 to 64 warps, not 65"), "{error}");
}

#[test]
fn maps_that_are_no_densities_are_errors() {
    let of = |text: &str, files: &Picture| {
        text.parse::<WarpExpression>().unwrap().strategies(Domain::Sphere, files)
    };
    let mut texels = vec![1.0; 8];
    texels[6] = f64::NAN;
    let error = message(of("env:a.exr", &Picture(texels)));
    assert!(error.contains("texel (row 1, column 2) is NaN"), "{error}");
    let error = message(of("env:a.exr", &Picture(vec![0.0; 8])));
    assert!(error.contains("env:a.exr: the density is 0 on the sphere"), "{error}");
    // Light below the horizon alone.
    let below = Picture(vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
    let constant: WarpExpression = "env:a.exr,interpolation=constant".parse().unwrap();
    assert!(constant.strategies(Domain::Sphere, &below).is_ok());
    let error = message(constant.strategies(Domain::Hemisphere, &below));
    assert!(error.contains("the density is 0 on the hemisphere z >= 0"), "{error}");
    let file: WarpExpression = "cosine + env:a.exr".parse().unwrap();
    assert!(matches!(file.strategies(Domain::Sphere, &NoFiles), Err(Error::File(_))));
}

/// The density of signed values is that of their magnitudes, so it is 0 nowhere that they are not.
#[test]
fn negative_texels_count_by_magnitude_with_a_remark() {
    let signed = Picture(vec![1.0, 2.0, -0.5, 4.0, 3.0, -1.0, 2.0, 1.0]);
    let magnitudes = Picture(signed.0.iter().map(|texel| texel.abs()).collect());
    for text in ["env:a.exr", "env:a.exr,interpolation=constant,floor=0.1 * cosine"] {
        let expression: WarpExpression = text.parse().unwrap();
        let of = |files: &Picture| {
            expression.strategies(Domain::Hemisphere, files).unwrap()[0].warp.clone()
        };
        let (of_signed, of_magnitudes) = (of(&signed), of(&magnitudes));
        for k in 0..100 {
            let point = [f64::from(k) / 100.0, f64::from(k * 37 % 100) / 100.0];
            assert_eq!(of_signed.sample(point), of_magnitudes.sample(point), "{text}");
        }
    }
    let parameters = EnvironmentParameters { file: "a.exr".into(), ..Default::default() };
    let remarks = |files: &Picture| {
        let mut remarks = Vec::new();
        let map = files.environment(&parameters).unwrap();
        parameters.density(map, Interpolation::Bilinear, |text| remarks.push(text)).unwrap();
        remarks
    };
    let expected = "a.exr: 2 of 8 texels are negative; the density takes their magnitudes";
    assert_eq!(remarks(&signed), [expected]);
    assert!(remarks(&magnitudes).is_empty());
}
