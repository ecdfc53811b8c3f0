//! Specifications of integrands: parsing, display and errors.

use std::f64::consts::PI;
use std::path::Path;

use proptest::prelude::*;
use proptest::sample::select;
use sphvar_healpix::Nside;
use sphvar_integrands::grammar::{DefaultValue, Parameter, ParameterKind, ResolveError};
use sphvar_integrands::{
    BandParameters, CapParameters, Domain, DoubleCapParameters, EnvironmentMap,
    EnvironmentParameters, Error, Expression, Factor, HalfSpaceParameters, HarmonicParameters,
    HealpixMap, HealpixMapParameters, Integrand, IntegrandResolver, MissingPixels, NoFiles,
    PhongParameters, Summand, Term, UpAxis, VonMisesFisherParameters,
};

fn built(text: &str) -> Box<dyn Integrand> {
    text.parse::<Expression>().unwrap().build(&NoFiles).unwrap()
}

#[test]
fn terms_show_required_and_non_default_parameters() {
    for (text, shown) in [
        ("ylm:l=4", "ylm:l=4"),
        ("ylm:m=-3,l=4", "ylm:l=4,m=-3"),
        ("ylm:l=4,m=0", "ylm:l=4"),
        ("half-space", "half-space"),
        ("half-space:height=0.5", "half-space:height=0.5"),
        ("env:file=a.exr", "env:a.exr"),
        ("env:\"a,b.exr\",up=-x,channel=r", "env:\"a,b.exr\",channel=r,up=-x"),
        ("map:a.fits,missing=mean,hdu=MAP", "map:a.fits,hdu=MAP,missing=mean"),
        ("band:field=2,decay=1.5,mean=0,lmax=9", "band:lmax=9,decay=1.5,mean=0,field=2"),
        ("energy:file=a.csv,quantity=cl", "energy:a.csv,quantity=cl"),
        ("alm:hdu=2,file=a.fits", "alm:a.fits,hdu=2"),
    ] {
        assert_eq!(text.parse::<Term>().unwrap().to_string(), shown);
    }
    for term in Term::all() {
        assert_eq!(term.to_string().parse(), Ok(term.clone()));
        assert!(!term.summary().is_empty());
    }
    let forms: Vec<String> = Term::all().iter().map(Term::form).collect();
    assert_eq!(forms[0], "ylm:l=4[,m=0]");
    assert_eq!(forms[3], "half-space[:height=0]");
    assert_eq!(
        *forms.iter().find(|form| form.starts_with("env")).unwrap(),
        "env:FILE[,channel=NAME][,layer=NAME][,projection=latlong|octahedral][,up=z|y|x|-z|-y|-x]\
         [,mirror=no|yes][,rotate=0]"
    );
}

#[test]
fn expressions_are_sums_of_products_of_rotated_terms() {
    let expression: Expression =
        "-1e-3 * cosine @ 12/34 @ 1/2/3 * 2 - cap:degrees=60".parse().unwrap();
    let cap = Term::Cap(CapParameters { degrees: 60.0 });
    let cosine = Factor { term: Term::Cosine, rotations: vec![[12.0, 34.0, 0.0], [1.0, 2.0, 3.0]] };
    let factors = vec![Factor { term: cap, rotations: Vec::new() }];
    let expected =
        vec![Summand { weight: -2e-3, factors: vec![cosine] }, Summand { weight: -1.0, factors }];
    assert_eq!(expression.summands, expected);
    assert_eq!(expression.to_string(), "-0.002 * cosine @ 12/34 @ 1/2/3 - cap:degrees=60");
    for (text, exact) in [
        ("2", 8.0 * PI),
        ("1 - cosine", 3.0 * PI),
        ("cosine * half-space", PI),
        ("0.5 * cap:degrees=60 @ 30/0 @ 0/90", 0.5 * PI),
    ] {
        let got = built(text).exact(Domain::Sphere).unwrap();
        assert!((got - exact).abs() < 1e-14 * exact, "{text}: {got}, not {exact}");
    }
}

#[test]
fn errors_state_the_valid_values() {
    for (text, message) in [
        ("cap", "cap: the parameter degrees is missing"),
        ("cap:degrees=300", "cap:degrees=300: degrees must be in (0, 180], got 300"),
        ("cap:degrees=nan", "degrees must be in (0, 180], got NaN"),
        ("phong:n=-1", "phong:n=-1: n must be in [0, 1e6], got -1"),
        ("ylm:l=2.5", "l must be a whole number from 0, got 2.5"),
        ("ylm:l=2,n=1", "unknown parameter \"n\"; valid: l, m"),
        ("cosin", "unknown integrand \"cosin\" (did you mean \"cosine\"?); valid: ylm, cap, "),
        ("env:a.exr,up=w", "unknown up of env \"w\"; valid: z, y, x, -z, -y, -x"),
        ("env", "env: the file is missing: env:FILE"),
        ("cosine +  + cosine", "an operator has no operand on one side"),
        ("cosine @ 181/0", "THETA in [0, 180], got \"181/0\""),
    ] {
        let error = text.parse::<Expression>().unwrap_err().to_string();
        assert!(error.contains(message), "{text}: {error}");
    }
    let product = vec!["cosine"; Expression::MAX_FACTORS + 1].join(" * ");
    assert_eq!(product.parse::<Expression>(), Err(Error::TooManyFactors { max: 64 }));
    for (text, message) in [
        ("ylm:l=2,m=3", "ylm:l=2,m=3: the order must satisfy |m| <= l"),
        ("1e200 * cosine + 1", "a weight must be 0 or between 1e-150 and 1e150"),
        ("env:a.exr", "cannot read a.exr: an integrand from a file needs a resolver"),
        ("1 + map:a.fits", "cannot read a.fits"),
    ] {
        let error = text.parse::<Expression>().unwrap().build(&NoFiles).map(drop).unwrap_err();
        assert!(error.to_string().contains(message), "{text}: {error}");
    }
}

/// A map that is 1 at its pole and 0 else, and one that is constant, whatever the files.
struct Maps;

impl IntegrandResolver for Maps {
    fn environment(&self, wanted: &EnvironmentParameters) -> Result<EnvironmentMap, ResolveError> {
        assert_eq!(wanted.file, Path::new("sky.exr"));
        assert_eq!(wanted.picture.channel.as_deref(), Some("r"));
        let mut texels = vec![0.0; 32 * 16];
        texels[..64].fill(1.0);
        EnvironmentMap::new(32, 16, texels).map_err(ResolveError::new)
    }

    fn healpix_map(&self, wanted: &HealpixMapParameters) -> Result<HealpixMap, ResolveError> {
        assert_eq!((wanted.field.as_deref(), wanted.missing), (Some("1"), MissingPixels::Zero));
        let nside = Nside::new(1).map_err(ResolveError::new)?;
        HealpixMap::new(nside, vec![2.0; 12]).map_err(ResolveError::new)
    }
}

#[test]
fn files_are_read_by_the_resolver() {
    let value =
        |text: &str, dir| text.parse::<Expression>().unwrap().build(&Maps).unwrap().eval(dir);
    for (axis, up) in [("z", UpAxis::PlusZ), ("y", UpAxis::PlusY), ("-x", UpAxis::MinusX)] {
        let text = format!("env:sky.exr,channel=r,up={axis} + map:a.fits,field=1,missing=0");
        assert!((value(&text, up.direction()) - 3.0).abs() < 1e-12, "{text}");
        assert!((value(&text, -up.direction()) - 2.0).abs() < 1e-12, "{text}");
    }
}

/// Returns a value of a parameter as text.
fn value(parameter: Parameter) -> BoxedStrategy<String> {
    match parameter.kind {
        ParameterKind::Integer { min, max } => (min..=max).prop_map(|n| n.to_string()).boxed(),
        ParameterKind::Number(range) => {
            let extremes = [5e-324, 1e-300, -0.0, 0.5, 1.0, 90.0, 1e22, range.low(), range.high()];
            prop_oneof![select(extremes.to_vec()), any::<f64>()]
                .prop_filter("outside", move |x| range.contains(*x))
                .prop_map(|x| x.to_string())
                .boxed()
        }
        ParameterKind::Choice(names) => select(names).prop_map(str::to_owned).boxed(),
        ParameterKind::Text(_) => {
            let texts = ["cosine", "\"cap:degrees=60 @ 1/2 + 2 * ylm:l=2,m=1\""];
            select(texts.map(str::to_owned).to_vec()).boxed()
        }
        _ => select(vec!["a", "\"a,b\"", "\"x + y\"", "\"k=v\"", "\"\\\"\\\\\"", "dir/b.c"])
            .prop_map(str::to_owned)
            .boxed(),
    }
}

fn any_term() -> impl Strategy<Value = Term> {
    select(Term::all()).prop_flat_map(|term| {
        let items: Vec<_> = term
            .parameters()
            .into_iter()
            .map(|parameter| {
                let (name, is_required) =
                    (parameter.name, parameter.default == DefaultValue::Required);
                let given = value(parameter).prop_map(move |v| format!("{name}={v}"));
                if is_required {
                    given.prop_map(Some).boxed()
                } else {
                    proptest::option::of(given).boxed()
                }
            })
            .collect();
        items.prop_map(move |items| {
            let items: Vec<String> = items.into_iter().flatten().collect();
            format!("{}:{}", term.name(), items.join(",")).parse().unwrap()
        })
    })
}

fn any_expression() -> impl Strategy<Value = Expression> {
    let angle = || prop_oneof![Just(0.0), Just(-0.0), -1e3..1e3, Just(1e300)];
    let rotation = (0.0..180.0, angle(), angle()).prop_map(|(theta, phi, psi)| [theta, phi, psi]);
    let factor = (any_term(), prop::collection::vec(rotation, 0..3))
        .prop_map(|(term, rotations)| Factor { term, rotations });
    let weight = prop_oneof![Just(1.0), Just(-1.0), Just(0.0), Just(-0.0), -1e3..1e3, Just(1e-300)];
    let summand = (weight, prop::collection::vec(factor, 0..3))
        .prop_map(|(weight, factors)| Summand { weight, factors });
    prop::collection::vec(summand, 1..4).prop_map(|summands| Expression { summands })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn displayed_expressions_parse_to_themselves(expression in any_expression()) {
        let shown = expression.to_string();
        prop_assert_eq!(shown.parse::<Expression>(), Ok(expression), "{}", shown);
        let again: Expression = shown.parse().unwrap();
        prop_assert_eq!(again.to_string(), shown);
    }
}

/// Constructors reject values outside the listed ranges and accept the ends of the ranges.
#[test]
fn ranges_match_the_constructors() {
    let cap = |degrees| Term::Cap(CapParameters { degrees });
    let double = |degrees| Term::DoubleCap(DoubleCapParameters { degrees });
    let half = |height| Term::HalfSpace(HalfSpaceParameters { height });
    let lobe = |kappa| Term::VonMisesFisher(VonMisesFisherParameters { kappa });
    let phong = |n| Term::Phong(PhongParameters { n });
    let band = |decay| Term::Band(BandParameters { decay, ..BandParameters::default() });
    let ends = [
        ([band(-20.1), band(20.1)], [band(-20.0), band(20.0)]),
        ([cap(0.0), cap(180.1)], [cap(1e-9), cap(180.0)]),
        ([double(0.0), double(90.1)], [double(1e-9), double(90.0)]),
        ([half(-1.1), half(1.0)], [half(-1.0), half(0.999)]),
        ([lobe(-1e-9), lobe(1.1e6)], [lobe(0.0), lobe(1e6)]),
        ([phong(-1e-9), phong(1.1e6)], [phong(0.0), phong(1e6)]),
    ];
    for (outside, inside) in ends {
        for term in outside {
            assert!(term.build(&NoFiles).is_err(), "{term}");
            assert!(term.to_string().parse::<Term>().is_err(), "{term}");
        }
        for term in inside {
            assert!(term.build(&NoFiles).is_ok(), "{term}");
            assert_eq!(term.to_string().parse(), Ok(term));
        }
    }
    let bands = [0, usize::MAX].map(|lmax| BandParameters { lmax, ..BandParameters::default() });
    assert!(bands.into_iter().all(|band| Term::Band(band).build(&NoFiles).is_err()));
    let order = Term::Harmonic(HarmonicParameters { l: 2, m: -3 });
    assert!(order.build(&NoFiles).is_err());
}
