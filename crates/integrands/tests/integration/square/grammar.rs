use sphvar_integrands::grammar::ResolveError;
use sphvar_integrands::{
    Error, ImageParameters, IntegrandResolver, NoFiles, SquareImage, SquareTerm,
};

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
