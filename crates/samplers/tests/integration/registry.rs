//! The list of patterns: texts, ranges and facts, compared with the samplers.

use std::path::Path;

use proptest::prelude::*;
use proptest::sample::select;
use sphvar_samplers::grammar::{DefaultValue, Parameter, ParameterKind, ResolveError, Value};
use sphvar_samplers::{
    BestCandidateParameters, BlueParameters, CcvtParameters, DesignParameters, DiskMode,
    DiskPlacement, Domain, Error, FileResolver, MassPoints, NoiseColour, Pattern, PointFile,
    PointFileParameters, PointSet, PoissonDiskParameters, PowerProfile, ProfileParameters,
    ProfileTable, Purpose, Rate, RieszParameters, SpectralControl, StepParameters, Streams,
};

#[test]
fn a_pattern_shows_the_parameters_that_are_not_defaults() {
    for pattern in Pattern::ALL {
        assert_eq!(pattern.to_string(), pattern.name());
        assert_eq!(pattern.name().parse(), Ok(pattern));
    }
    let disks = PoissonDiskParameters {
        mode: DiskMode::Saturated,
        radius: Some(2.5),
        placement: DiskPlacement::Boundary,
    };
    let disks = Pattern::PoissonDisk(disks);
    let text = "poisson-disk:mode=saturated,radius=2.5,placement=boundary";
    assert_eq!(disks.to_string(), text);
    let step = StepParameters { alpha: Some(0.5), flat: Some(0.0), ..StepParameters::DEFAULT };
    assert_eq!(Pattern::Step(step).to_string(), "step:alpha=0.5,flat=0");
    // Streams follow from the text.
    assert_eq!(Pattern::FIBONACCI.stream_group(0), 0xcf67_9803);
}

#[test]
fn errors_state_the_valid_values() {
    for (text, message) in [
        ("bluish", "unknown sampler \"bluish\" (did you mean \"blue\"?); valid: white-noise, "),
        ("riesz:s=5", "riesz:s=5: s must be in [0, 4], got 5"),
        ("lloyd:iterations=-1", "iterations must be a whole number from 0 to 4294967295, got -1"),
        ("lloyd:iterations=1.5", "iterations must be a whole number from 0 to 4294967295, got 1.5"),
        ("lloyd:iterations=x", "iterations must be a number, got \"x\""),
        ("poisson-disk:radius=nan", "radius must be finite and above 0, got NaN"),
        ("poisson-disk:rad=2", "unknown parameter \"rad\""),
        ("poisson-disk:rad=2", "valid: mode (exact, saturated), radius"),
        ("poisson-disk:radus=2", "(did you mean \"radius\"?)"),
        ("ccvt:mass=whit", "unknown mass of ccvt \"whit\" (did you mean \"white\"?)"),
        ("spiral:2", "unexpected value \"2\"; valid parameters: none"),
        ("profile:table.csv", "cannot read table.csv: a pattern from a file needs a resolver"),
        ("profile:table.csv,b=2", "unknown parameter \"b\"; valid: file, core"),
        (
            "profile:colour=blue,b=2",
            "unknown parameter \"b\"; valid: file, colour (pink, green, blue), core",
        ),
        ("profile:colour=brown", "unknown colour of profile \"brown\"; valid: pink, green, blue"),
        ("profile:color=blue", "(did you mean \"colour\"?)"),
        ("profile:to=9", "to must be in (0, 8], got 9"),
    ] {
        let error = text.parse::<Pattern>().unwrap_err().to_string();
        assert!(error.contains(message), "{text}: {error}");
    }
}

#[test]
fn colours_replace_the_parameters_of_a_profile() {
    for colour in NoiseColour::ALL {
        let text = format!("profile:colour={colour},core=0.25");
        let profile = PowerProfile::Colour(colour);
        let pattern = Pattern::Profile(ProfileParameters { profile, core: 0.25 });
        assert_eq!(text.parse(), Ok(pattern.clone()));
        assert_eq!(pattern.to_string(), text);
    }
}

/// A table of two powers, whatever the file.
struct Table;

impl FileResolver for Table {
    fn profile(&self, file: &Path) -> Result<ProfileTable, ResolveError> {
        if file == Path::new("none") {
            Err(ResolveError::new("no file"))
        } else {
            Ok(ProfileTable::Powers(vec![0.0, 0.5]))
        }
    }

    fn points(&self, _: &PointFileParameters) -> Result<Vec<PointFile>, ResolveError> {
        Err(ResolveError::new("no points"))
    }
}

#[test]
fn files_are_read_by_the_resolver() {
    for (text, shown) in [
        ("profile:a.csv", "profile:a.csv"),
        ("profile:core=0.5,file=a.csv", "profile:a.csv,core=0.5"),
        ("profile:\"a,b=c + d.csv\"", "profile:\"a,b=c + d.csv\""),
    ] {
        let pattern = Pattern::parse(text, &Table).unwrap();
        let Pattern::Profile(ProfileParameters {
            profile: PowerProfile::Table { power, .. }, ..
        }) = &pattern
        else {
            panic!("{pattern:?}");
        };
        assert_eq!(**power, [0.0, 0.5]);
        assert_eq!(pattern.to_string(), shown);
        assert_eq!(Pattern::parse(shown, &Table), Ok(pattern));
    }
    let error = Pattern::parse("profile:none", &Table).unwrap_err();
    assert_eq!(error, Error::File(ResolveError::new("no file")));
}

/// Returns a value of a parameter as text, among them the ends of its range.
fn value(parameter: Parameter) -> BoxedStrategy<String> {
    match parameter.kind {
        ParameterKind::Integer { min, max } => {
            prop_oneof![Just(min), Just(max), min..=max].prop_map(|n| n.to_string()).boxed()
        }
        ParameterKind::Number(range) => {
            let extremes = [0.0, -0.0, 5e-324, 1e-300, 0.1, 1.0, 1e22, f64::MAX, range.high()];
            let width = range.high().min(1e3) - range.low();
            prop_oneof![
                select(extremes.to_vec()),
                any::<f64>(),
                (0.0..1.0).prop_map(move |share| range.low() + share * width)
            ]
            .prop_filter("outside", move |x| range.contains(*x))
            .prop_map(|x| x.to_string())
            .boxed()
        }
        ParameterKind::Choice(names) => select(names).prop_map(str::to_owned).boxed(),
        other => panic!("{other}"),
    }
}

fn any_text() -> impl Strategy<Value = String> {
    let texts = |pattern: Pattern| {
        let mut parameters = pattern.parameters();
        // A file, a colour or an edge excludes other parameters.
        parameters.retain(|parameter| {
            parameter.kind != ParameterKind::File && !["colour", "edge"].contains(&parameter.name)
        });
        let items: Vec<_> = parameters
            .into_iter()
            .map(|parameter| {
                let name = parameter.name;
                proptest::option::of(value(parameter).prop_map(move |v| format!("{name}={v}")))
            })
            .collect();
        let name = pattern.name();
        items.prop_shuffle().prop_map(move |items| {
            let items: Vec<String> = items.into_iter().flatten().collect();
            format!("{name}:{}", items.join(","))
        })
    };
    select(Pattern::ALL.to_vec()).prop_flat_map(texts)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn displayed_patterns_parse_to_themselves(text in any_text()) {
        let pattern: Pattern = text.parse().unwrap();
        let shown = pattern.to_string();
        prop_assert_eq!(shown.parse::<Pattern>(), Ok(pattern.clone()));
        prop_assert_eq!(shown.parse::<Pattern>().unwrap().to_string(), shown.clone());
        // Exactly the values that differ from the defaults are shown, bit by bit.
        for parameter in pattern.parameters() {
            let given = text.split([':', ',']).find_map(|item| {
                item.strip_prefix(parameter.name)?.strip_prefix('=')
            });
            let default = match &parameter.default {
                DefaultValue::Value(value) => Some(value.to_string()),
                _ => None,
            };
            let expected = given.filter(|given| default.as_deref() != Some(given));
            let item = expected.map(|value| format!("{}={value}", parameter.name));
            let is_shown = shown.split([':', ',']).any(|shown| Some(shown) == item.as_deref());
            prop_assert_eq!(is_shown, item.is_some(), "{} of {}", parameter.name, shown);
        }
    }
}

/// Constructors reject values outside the listed ranges and accept the ends of the ranges.
#[test]
fn ranges_match_the_constructors() {
    let ccvt = |capacity| Pattern::Ccvt(CcvtParameters { capacity, mass: MassPoints::White });
    let step = |alpha, flat, core| {
        Pattern::Step(StepParameters { alpha: Some(alpha), flat: Some(flat), core })
    };
    let blue = |core| Pattern::Blue(BlueParameters { core, ..BlueParameters::DEFAULT });
    let riesz = |s| Pattern::Riesz(RieszParameters { s, iterations: 1 });
    let candidates = |factor| Pattern::BestCandidate(BestCandidateParameters { factor });
    let radius = |radius| {
        let radius = Some(radius);
        Pattern::PoissonDisk(PoissonDiskParameters { radius, ..PoissonDiskParameters::DEFAULT })
    };
    let profile = |exponent, alpha, gamma, offset, to| {
        let profile = PowerProfile::Polynomial { exponent, alpha, gamma, offset, to };
        Pattern::Profile(ProfileParameters { profile, core: 0.0 })
    };
    let core = SpectralControl::STEP_CORE;
    let cases = [
        ccvt(0),
        ccvt(1),
        step(0.0, 0.0, core),
        step(1.38, 8.0, core),
        step(-1e-9, 0.0, core),
        step(1.381, 0.0, core),
        step(0.5, -1e-9, core),
        step(0.5, 8.1, core),
        step(0.5, 1.0, 0.95),
        step(0.5, 1.0, 0.951),
        blue(0.0),
        blue(0.95),
        blue(-1e-9),
        blue(f64::NAN),
        riesz(0.0),
        riesz(4.0),
        riesz(4.1),
        riesz(-1e-300),
        candidates(0),
        candidates(1),
        radius(0.0),
        radius(-1.0),
        radius(f64::INFINITY),
        radius(5e-324),
        profile(0.0, 1.0, 0.0, 0.0, 8.0),
        profile(-1e-9, 1.0, 1.0, 0.0, 2.0),
        profile(f64::INFINITY, 1.0, 1.0, 0.0, 2.0),
        profile(2.0, 0.0, 1.0, 0.0, 2.0),
        profile(2.0, 1e-9, 1.0, 0.0, 2.0),
        profile(2.0, 1.0, -1e-9, 0.0, 2.0),
        profile(2.0, 1.0, 1.0, -1e-9, 2.0),
        profile(2.0, 1.0, 1.0, 0.0, 0.0),
        profile(2.0, 1.0, 1.0, 0.0, 8.1),
    ];
    let mut rejected = 0;
    for pattern in cases {
        // A million points have enough degrees of freedom for every alpha in the range.
        let built = pattern.build(1_000_000, Domain::Sphere);
        let out_of_range = matches!(
            &built,
            Err(Error::Parameter { .. }) | Err(Error::Infeasible { pattern: "poisson-disk", .. })
        );
        let read = pattern.to_string().parse::<Pattern>();
        assert_eq!(read.is_err(), out_of_range, "{pattern}: {read:?} and {built:?}");
        rejected += usize::from(read.is_err());
    }
    assert_eq!(rejected, 21);
}

/// HEALPix has 12 nside^2 pixels and 6 nside^2 antipodal pairs: the counts by definition.
#[test]
fn valid_counts_of_healpix_mass_are_those_with_whole_pixels() {
    for capacity in [1, 2, 3, 5, 7, 12, 16, 18, 27, 50, 64, 97, 100, 144] {
        let pattern: Pattern = format!("ccvt:mass=healpix,capacity={capacity}").parse().unwrap();
        for (domain, unit) in [(Domain::Sphere, 12), (Domain::Hemisphere, 6)] {
            let counts = pattern.valid_counts(domain);
            for n in 1..1500 {
                let pixels = capacity * n;
                let is_whole = (1..).map(|k| unit * k * k).find(|&p| p >= pixels) == Some(pixels);
                assert_eq!(counts.contains(n), is_whole, "{capacity} {domain} {n}");
                assert!(!is_whole || n > 200 || pattern.build(n, domain).is_ok(), "{pattern} {n}");
            }
        }
    }
}

#[test]
fn invalid_counts_are_rejected() {
    for pattern in Pattern::ALL {
        let rejected = pattern.build(0, Domain::Sphere).unwrap_err();
        assert_eq!(rejected, Error::NoPoints { pattern: pattern.to_string() });
        // The largest counts are handled too, without overflow or allocation.
        for n in [usize::MAX, usize::MAX / 12, 1 << 62] {
            let _ = pattern.build(n, Domain::Sphere);
        }
    }
    let rejected = Pattern::Healpix.build(13, Domain::Hemisphere).unwrap_err();
    let message = rejected.to_string();
    assert!(
        message.contains("the nearest valid count is 6") && message.contains("6 nside^2"),
        "{message}"
    );
}

/// Returns all patterns with every combination of their choices, and one with another number.
fn patterns_with_facts() -> Vec<Pattern> {
    let mut patterns = crate::sequences::patterns();
    patterns.push("fibonacci:offset=1.33".parse().unwrap());
    patterns
}

fn set(pattern: &Pattern, requested: usize, realization: u64) -> PointSet {
    let n = pattern.nearest_count(requested, Domain::Sphere);
    let sampler = pattern.build(n, Domain::Sphere).unwrap();
    let mut rng = Streams::new(0, Purpose::Pattern, 0).realization(realization);
    sampler.sample(&mut rng).unwrap()
}

/// Patterns with one set of every number of points, whatever their parameters.
const FIXED: [&str; 12] = [
    "healpix",
    "fibonacci",
    "spiral",
    "gauss-legendre",
    "driscoll-healy",
    "mcewen-wiaux",
    "lebedev",
    "icosahedral",
    "cube-sphere",
    "leja",
    "sukharev",
    "design",
];

#[test]
fn deterministic_patterns_have_one_set() {
    let mut deterministic = Vec::new();
    for pattern in patterns_with_facts() {
        let is_one = set(&pattern, 48, 0).points == set(&pattern, 48, 1).points;
        assert_eq!(pattern.is_deterministic(), is_one, "{pattern}");
        deterministic.extend(is_one.then(|| pattern.to_string()));
    }
    let is_expected = |name: &str| {
        let base = name.split(':').next().unwrap();
        FIXED.contains(&base) || name.contains("centred") || name.contains("randomization=none")
    };
    for pattern in patterns_with_facts() {
        let name = pattern.to_string();
        assert_eq!(deterministic.contains(&name), is_expected(&name), "{name}");
    }
}

#[test]
fn extensible_patterns_begin_with_their_smaller_sets() {
    for pattern in patterns_with_facts() {
        let large = set(&pattern, 192, 0);
        let begins = [48, 25].map(|n| large.points.starts_with(&set(&pattern, n, 0).points));
        let begins = begins == [true; 2];
        assert_eq!(pattern.facts().is_extensible, begins, "{pattern}");
    }
}

/// A logarithm changes the exponent by less than a tenth here, whether nominal work has it or not, and
/// another method for few points by less than 0.03.
#[test]
fn costs_grow_as_the_nominal_work() {
    for pattern in patterns_with_facts() {
        let counts = [1000, 1_000_000].map(|n| pattern.nearest_count(n, Domain::Sphere));
        let [few, many] = counts.map(|n| pattern.nominal_work(n));
        let exponent = (many / few).ln() / (counts[1] as f64 / counts[0] as f64).ln();
        let cost = pattern.facts().cost;
        let above = exponent - cost.exponent;
        let max = 0.03 + 0.1 * cost.logarithm;
        assert!(above > -0.03 && above < max, "{pattern}: {exponent}, not {cost}");
    }
}

#[test]
fn rates_are_displayed_in_words() {
    for (text, rates) in [
        ("white-noise", "N^-1 for every integrand"),
        ("step", "exact for smooth integrands, N^-1.5 for those with jumps"),
        ("ccvt", "N^-3 for smooth integrands, N^-1.5 for those with jumps"),
        ("ccvt:mass=white", "N^-1 for every integrand"),
        ("profile", "as requested"),
        ("equal-area:placement=centred", "no known rate"),
    ] {
        assert_eq!(text.parse::<Pattern>().unwrap().facts().rates(), rates);
    }
    for pattern in patterns_with_facts() {
        let facts = pattern.facts();
        // The rate for jumps is never better than that for smooth integrands, and no pattern is
        // worse than white noise.
        if let (Rate::Power { exponent: smooth, .. }, Rate::Power { exponent: jump, .. }) =
            (facts.smooth_rate, facts.jump_rate)
        {
            assert!(smooth <= jump && jump <= -1.0, "{pattern}");
        }
        assert!(!facts.source.is_empty() && !facts.low_degrees.is_empty(), "{pattern}");
    }
}

/// Milliseconds at 1024 points on an AMD EPYC (Zen 4), for best candidates on one with AVX2, within a
/// factor of 2.
#[test]
fn nominal_work_matches_the_measured_times() {
    const UNIT_MILLISECONDS: f64 = 60e-6;
    let measured = [
        0.033, 0.022, 0.011, 0.017, 2.29, 27.1, 46.3, 25.6, 8.36, 0.030, 0.024, 10.0, 16.0, 9.30,
        4500.0, 420.0, 0.031, 0.020, 0.016, 0.022, 0.073, 0.015, 0.015, 0.016, 0.037, 0.038, 0.020,
        0.030, 1700.0,
    ];
    for (pattern, milliseconds) in Pattern::ALL.into_iter().zip(measured) {
        let ratio = UNIT_MILLISECONDS * pattern.nominal_work(1024) / milliseconds;
        // The minimum is one unit per point.
        let max_ratio = if milliseconds < 0.1 { 6.0 } else { 2.0 };
        assert!((0.5..max_ratio).contains(&ratio), "{pattern}: {ratio}");
    }
    for pattern in Pattern::ALL {
        assert!(pattern.nominal_work(1 << 20).is_finite() && pattern.nominal_work(0) >= 0.0);
    }
}

#[test]
fn parameters_are_listed_with_their_defaults() {
    let listed = Pattern::Step(StepParameters { alpha: Some(1.0), ..StepParameters::DEFAULT });
    let listed = listed.parameters();
    let names: Vec<_> = listed.iter().map(|parameter| parameter.name).collect();
    assert_eq!(names, ["alpha", "flat", "core"]);
    assert_eq!(listed[0].default, DefaultValue::Depends("by N"));
    assert_eq!(listed[2].default, DefaultValue::Value(Value::Number(0.3)));
    let design = Pattern::Design(DesignParameters { degree: Some(5), ..DesignParameters::DEFAULT });
    assert_eq!(design.parameters()[0].default, DefaultValue::Depends("by N"));
    assert_eq!(design.to_string(), "design:t=5");
    assert!(Pattern::Spiral.parameters().is_empty());
}
