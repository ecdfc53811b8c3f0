//! Point files as a pattern: texts, options, numbers of points, and errors that name file and set.

use glam::DVec3;
use sphvar_samplers::grammar::ResolveError;
use sphvar_samplers::{
    Domain, Error, FileResolver, Pattern, PointFile, PointFileParameters, PointSet, PointSets,
    ProfileTable, Purpose, Realizations, Sampler, SamplerFamily, Streams, ValidCounts,
};

/// Files in memory: each set is `n` points on the upper half, the first set with weights.
struct Memory;

fn set(n: u32, seed: f64) -> PointSet {
    let points = (0..n).map(|k| DVec3::new(f64::from(k), seed, 1.0 + seed).normalize());
    PointSet::new(points.collect())
}

fn file(name: &str, sets: Vec<PointSet>) -> PointFile {
    PointFile { name: name.to_owned(), sets, ..PointFile::default() }
}

impl FileResolver for Memory {
    fn profile(&self, _: &std::path::Path) -> Result<ProfileTable, ResolveError> {
        Err(ResolveError::new("no profile"))
    }

    fn points(&self, source: &PointFileParameters) -> Result<Vec<PointFile>, ResolveError> {
        let of_template = |n: u32, stated: usize| PointFile {
            stated_count: Some(stated),
            ..file(&format!("t-{stated}.npy"), vec![set(n, 0.1), set(n, 0.2)])
        };
        let weighted = |weights: &[f64]| PointSet {
            weights: weights.to_vec(),
            ..set(u32::try_from(weights.len()).unwrap(), 0.3)
        };
        Ok(match source.file().to_str().unwrap() {
            "a/one.csv" | "b/one.csv" => vec![file("one.csv", vec![set(7, 0.5)])],
            "three.csv" => vec![file("three.csv", vec![set(5, 0.1), set(6, 0.2), set(6, 0.3)])],
            "t-{n}.npy" => vec![of_template(12, 12), of_template(48, 48)],
            "wrong-{n}.npy" => vec![of_template(12, 12), of_template(40, 48)],
            "twice-{n}.npy" => vec![of_template(12, 12), of_template(12, 12)],
            "none-{n}.npy" => vec![],
            "weights.csv" => vec![file("weights.csv", vec![weighted(&[1.0, 2.0, -0.5])])],
            "nothing.csv" => vec![PointFile {
                starts: vec!["nothing.csv:2".to_owned(), "nothing.csv:4".to_owned()],
                ..file("nothing.csv", vec![weighted(&[1.0, 2.0]), weighted(&[1e300, -1e300])])
            }],
            "below.csv" => vec![PointFile {
                first_below: Some("below.csv:3: z = -0.5".to_owned()),
                ..file("below.csv", vec![PointSet::new(vec![DVec3::X, -DVec3::Z])])
            }],
            other => return Err(ResolveError::new(format!("cannot open {other}"))),
        })
    }
}

fn parsed(text: &str) -> Result<Pattern, Error> {
    Pattern::parse(text, &Memory)
}

#[test]
fn texts_and_labels() {
    for (text, shown, label) in [
        ("file:a/one.csv", "file:a/one.csv", "file:one.csv"),
        ("file:\"a/one.csv\",normalize=no", "file:a/one.csv", "file:one.csv"),
        (
            "file:skip-invalid=yes,columns=\"ra,dec\",file=a/one.csv,hdu=2,fold=yes",
            "file:a/one.csv,columns=\"ra,dec\",hdu=2,skip-invalid=yes,fold=yes",
            "file:one.csv,columns=\"ra,dec\",hdu=2,skip-invalid=yes,fold=yes",
        ),
    ] {
        let pattern = parsed(text).unwrap();
        assert_eq!((&*pattern.to_string(), &*pattern.label()), (shown, label));
        assert_eq!(parsed(shown), Ok(pattern.clone()));
        assert_eq!((pattern.name(), pattern.own_count()), ("file", Some(7)));
    }
    let Pattern::PointFile(mut file) = parsed("file:a/one.csv").unwrap() else { unreachable!() };
    file.has_long_label = true;
    assert_eq!(Pattern::PointFile(file).label(), "file:a/one.csv");
    assert!(Pattern::known().any(|p| p.name() == "file"));
    assert!(Pattern::ALL.iter().all(|p| p.name() != "file"));
    let unknown = "fil:x".parse::<Pattern>().unwrap_err().to_string();
    assert!(unknown.contains("did you mean \"file\"?"), "{unknown}");
}

#[test]
fn a_file_has_its_own_number_of_points() {
    let one = parsed("file:a/one.csv").unwrap();
    assert_eq!(one.valid_counts(Domain::Sphere).to_string(), "7");
    assert_eq!(one.nearest_count(1000, Domain::Sphere), 7);
    assert!(one.is_deterministic());
    let error = one.build(8, Domain::Sphere).unwrap_err().to_string();
    assert!(error.contains("N must be 7; the nearest valid count is 7"), "{error}");
    // The mean of 5, 6 and 6 is 5.67.
    let three = parsed("file:three.csv").unwrap();
    assert_eq!(three.own_count(), Some(6));
    assert!(three.build(6, Domain::Hemisphere).unwrap().is_random());

    let template = parsed("file:t-{n}.npy").unwrap();
    assert_eq!(template.own_count(), None);
    let counts = ValidCounts::Listed(vec![12, 48].into());
    assert_eq!(template.valid_counts(Domain::Sphere), counts);
    for n in [12, 48] {
        let sampler = template.build(n, Domain::Sphere).unwrap();
        assert_eq!(sampler.n_points(), n);
        assert_eq!(sampler.stream_group(), template.stream_group(n));
    }
}

/// The random streams of a file follow from its content, not from its name.
#[test]
fn streams_follow_from_the_content() {
    let group = |text: &str| parsed(text).unwrap().build(7, Domain::Sphere).unwrap().stream_group();
    assert_eq!(group("file:a/one.csv"), group("file:b/one.csv"));
    assert_ne!(group("file:a/one.csv"), parsed("file:three.csv").unwrap().stream_group(6));
}

#[test]
fn sets_and_weights_are_those_of_the_file() {
    let weights = parsed("file:weights.csv").unwrap().build(3, Domain::Sphere).unwrap();
    let set = weights.sample(&mut Streams::new(0, Purpose::Pattern, 0).realization(0)).unwrap();
    assert_eq!(set.weights, [1.0, 2.0, -0.5]);
    let below = parsed("file:below.csv,fold=yes").unwrap();
    let folded = below.build(2, Domain::Hemisphere).unwrap();
    let drawn = Realizations::unrotated(&*folded, Streams::new(0, Purpose::Pattern, 0));
    assert_eq!(drawn.realize(0).unwrap().points, [DVec3::X, DVec3::Z]);
    // On the sphere nothing is folded.
    let whole = below.build(2, Domain::Sphere).unwrap();
    let drawn = Realizations::unrotated(&*whole, Streams::new(0, Purpose::Pattern, 0));
    assert_eq!(drawn.realize(0).unwrap().points, [DVec3::X, -DVec3::Z]);
}

#[test]
fn errors_name_file_place_and_set() {
    for (text, parts) in [
        ("file:missing.csv", &["cannot open missing.csv"][..]),
        ("file:\"\"", &["the name of the file is empty"]),
        ("file", &["the file is missing: file:FILE"]),
        ("file:nothing.csv", &["nothing.csv:4", "set 1 (0-based)", "sum to 0"]),
        ("file:wrong-{n}.npy", &["t-48.npy", "states 48 points, but it has 40"]),
        ("file:twice-{n}.npy", &["t-12.npy and t-12.npy", "both have 12 points"]),
        ("file:none-{n}.npy", &["there is no file"]),
        ("file:a/one.csv,fold=maybe", &["unknown fold of file \"maybe\"", "no, yes"]),
    ] {
        let message = parsed(text).unwrap_err().to_string();
        for part in parts {
            assert!(message.contains(part), "{text}: {message}");
        }
    }
    let below = parsed("file:below.csv").unwrap();
    let message = below.build(2, Domain::Hemisphere).unwrap_err().to_string();
    for part in ["below.csv:3", "z = -0.5", "fold=yes"] {
        assert!(message.contains(part), "{message}");
    }
    assert!(below.build(2, Domain::Sphere).is_ok());
    let unread = "file:a.csv".parse::<Pattern>().unwrap_err().to_string();
    assert!(unread.contains("needs a resolver"), "{unread}");
    let default = Pattern::PointFile(PointFileParameters::DEFAULT);
    assert!(default.build(5, Domain::Sphere).is_err());
}

#[test]
fn point_sets_are_a_family() {
    let sets = PointSets::new(vec![set(7, 0.5)], Domain::Sphere).unwrap().with_name("mine");
    assert_eq!((sets.to_string(), sets.nearest_count(99, Domain::Sphere)), ("mine".to_owned(), 7));
    let family: &dyn SamplerFamily = &sets;
    assert_eq!(family.build(7, Domain::Sphere).unwrap().n_points(), 7);
    let message = family.build(8, Domain::Sphere).unwrap_err().to_string();
    assert!(message.contains("mine has no pattern of 8 points"), "{message}");
    let message = family.build(7, Domain::Hemisphere).unwrap_err().to_string();
    assert!(message.contains("mine are on the sphere"), "{message}");
    // A mean number of 1 does not make points independent.
    let sizes = [1, 1, 1, 2].map(|n| set(n, 0.5)).to_vec();
    let mixed = PointSets::new(sizes, Domain::Sphere).unwrap();
    assert!(mixed.n_points() == 1 && !mixed.is_independent());
}
