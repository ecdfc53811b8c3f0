use sphvar_integrands::grammar::ResolveError;
use sphvar_integrands::{
    Error, ImageParameters, IntegrandResolver, NoFiles, SquareExpression, SquareImage, SquareTerm,
};
use sphvar_sh::{Frequencies, TailClasses};

/// A resolver with one picture.
struct Picture;

impl IntegrandResolver for Picture {
    fn square_image(&self, wanted: &ImageParameters) -> Result<SquareImage, ResolveError> {
        let texels = vec![1.0, 2.0, 3.0, 4.0];
        SquareImage::new(2, 2, texels, wanted.interpolation)
            .map_err(|error| ResolveError::new(error.to_string()))
    }
}

#[test]
fn every_integrand_has_a_text() {
    let texts = [
        "disk:radius=0.1",
        "disk:radius=0.5,u=0,v=1",
        "half-plane:angle=45",
        "half-plane:angle=-30,offset=0.25",
        "gaussian:width=0.01,v=0.25",
        "exponential:a=1,b=-2",
        "zone-plate",
        "zone-plate:scale=50",
        "image:a.png,channel=r,interpolation=constant",
        "wave:k1=-3,k2=0",
    ];
    for text in texts {
        let term: SquareTerm = text.parse().unwrap();
        assert_eq!(term.to_string(), text);
        let integrand = term.build(&Picture).unwrap();
        assert!(integrand.exact().is_some(), "{text}");
    }
    for term in SquareTerm::all() {
        let is_listed = texts.iter().any(|text| text.split(':').next() == Some(term.name()));
        assert!(is_listed, "{term}");
        assert_eq!(term.to_string().parse::<SquareTerm>().unwrap(), term);
        assert!(!term.summary().is_empty() && term.form().starts_with(term.name()));
        assert!(term.parameters().iter().all(|parameter| !parameter.summary.ends_with('.')));
    }
}

#[test]
fn wrong_texts_are_errors_that_name_what_is_right() {
    for (text, message) in [
        ("disc:radius=0.1", "unknown integrand \"disc\" (did you mean \"disk\"?); valid: disk,"),
        ("disk", "disk: the parameter radius is missing"),
        ("disk:radius=0", "radius must be in [1e-9, 0.5], got 0"),
        ("wave:k1=0.5,k2=1", "k1 must be a whole number from -16777216 to 16777216"),
        ("zone-plate:scale=1e3", "scale must be in [1e-9, 100], got 1000"),
        ("image", "image: the file is missing: image:FILE"),
        ("image:a.png,interpolation=cubic", "interpolation"),
    ] {
        let error = text.parse::<SquareTerm>().unwrap_err().to_string();
        assert!(error.contains(message), "{text}: {error}");
    }
    let image: SquareTerm = "image:a.png".parse().unwrap();
    assert!(matches!(image.build(&NoFiles), Err(Error::File(_))));
}

#[test]
fn sums_and_products_are_functions() {
    let points = [[0.1, 0.2], [0.5, 0.5], [0.9, 0.3]];
    let of = |text: &str| text.parse::<SquareExpression>().unwrap().build(&NoFiles).unwrap();
    let texts = [
        "2 * wave:k1=1,k2=0 - 0.5 * zone-plate * disk:radius=0.3 + 4",
        "3 * wave:k1=1,k2=0",
        "gaussian:width=0.2",
        "disk:radius=0.3 * disk:radius=0.2,u=0.4",
    ];
    for text in texts {
        let expression: SquareExpression = text.parse().unwrap();
        assert_eq!(expression.to_string(), text);
    }
    let [sum, multiple, single, product] = texts.map(of);
    let [wave, plate, disk] = ["wave:k1=1,k2=0", "zone-plate", "disk:radius=0.3"].map(of);
    let mut values = [0.0; 3];
    sum.eval_into(&points, &mut values).unwrap();
    for (point, value) in points.into_iter().zip(values) {
        let expected = 2.0 * wave.eval(point) - 0.5 * plate.eval(point) * disk.eval(point) + 4.0;
        assert!((sum.eval(point) - expected).abs() < 1e-15);
        assert_eq!(sum.eval(point).to_bits(), value.to_bits());
    }
    // A multiple has nine times the energy, and three times the variation.
    let frequencies = Frequencies::new(5).unwrap();
    let energy = multiple.energy(&frequencies).unwrap();
    assert_eq!(energy, wave.energy(&frequencies).unwrap().of_multiple(3.0));
    assert_eq!(multiple.variation(), wave.variation().map(|v| 3.0 * v));
    assert_eq!(single.feature_size(), Some(0.2));
    // The lens of two disks of radii 0.3 and 0.2, whose centres have the distance 0.1.
    let (integral, error) = product.integral_estimate().unwrap();
    assert!(product.exact().is_none() && error > 0.0);
    let area = std::f64::consts::PI * 0.04;
    assert!((integral - area).abs() < 4.0 * error, "{integral} {area} {error}");
    let energy = product.energy(&frequencies).unwrap();
    let (total, stated) = (energy.centred().sum(), energy.centred_stderr().sum());
    assert!((total - area * (1.0 - area)).abs() < 4.0 * stated, "{total}, {stated}");
    // Smooth sums are exact.
    let smooth = of("gaussian:width=0.2 * exponential:a=1,b=2 - 3 * wave:k1=2,k2=1");
    assert!(smooth.energy(&frequencies).unwrap().errors().is_none());
    assert!(smooth.exact().is_some());
    // Features that values would miss are errors, not numbers.
    let narrow = of("gaussian:width=1e-5 + wave:k1=1,k2=0");
    assert!(matches!(narrow.energy(&frequencies), Err(Error::NoEnergy { .. })));
    assert!(narrow.exact().is_some());
}

#[test]
fn wrong_expressions_are_errors() {
    for (text, message) in [
        ("disk:radius=0.2 +", "disk:radius=0.2 +"),
        ("disk:radius=0.2 * ", "an operator has no operand"),
        ("zone-plate @ 30/0", "zone-plate @ 30/0"),
        ("2 * cap:degrees=60", "unknown integrand \"cap\""),
    ] {
        let error = text.parse::<SquareExpression>().unwrap_err().to_string();
        assert!(error.contains(message), "{text}: {error}");
    }
    let heavy: SquareExpression = "1e200 * zone-plate".parse().unwrap();
    let error = heavy.build(&NoFiles).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("a weight must be 0 or between 1e-150 and 1e150"), "{error}");
}
