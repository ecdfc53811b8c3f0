//! Texts and numbers of points of warped patterns.

use sphvar_integrands::grammar::ResolveError;
use sphvar_samplers::{
    FileResolver, PointFile, PointFileParameters, ProfileTable, SamplerFamily, Square,
};
use sphvar_variance::{Error, WarpedPattern};

use super::warped;

#[test]
fn texts_are_read_as_they_are_written() {
    for text in [
        "sobol:warp=cosine",
        "sobol:warp=vmf:kappa=50",
        "sobol:warp=\"vmf:kappa=50 @ 40/10\"",
        "poisson-disk-square:wrapped=no,warp=cosine",
        "r2:warp=\"env:a.exr,interpolation=constant,floor=0.1\"",
        "jittered-square:warp=\"env:a.exr * cosine\"",
        "sobol:warp=\"0.25 * cosine + 0.75 * env:a.exr\",heuristic=power",
        "sobol:warp=\"cosine + cylinder\"",
        // Names of files with quotes, separators and a key.
        r#"sobol:warp="env:\"a,warp=b.exr\"""#,
        r#"sobol:warp="env:\"a \\\" b + c.exr\" * cosine""#,
    ] {
        assert!(WarpedPattern::is_warped(text), "{text}");
        let pattern = warped(text);
        assert_eq!(pattern.to_string(), text);
        assert_eq!(warped(&pattern.to_string()), pattern, "{text}");
    }
    // Order and defaults are normalized.
    let text = "poisson-disk-square:heuristic=balance,warp=\"cosine + cylinder\",wrapped=no";
    let written = "poisson-disk-square:wrapped=no,warp=\"cosine + cylinder\"";
    assert_eq!(warped(text).to_string(), written);
    for text in
        ["sobol", "jittered", "profile:\"a,warp=b\"", "file:a.csv", "sobol:heuristic=power", ""]
    {
        assert!(!WarpedPattern::is_warped(text), "{text}");
    }
}

#[test]
fn invalid_texts_name_the_fault() {
    for (text, part) in [
        ("sobol", "warp"),
        ("sobol:warp=", "the parameter warp is missing"),
        ("sobol:warp=\" \"", "the parameter warp is missing"),
        ("sobol:warp=\"cosine + \"", "no operand"),
        ("sobol:warp=cosin", "cosine"),
        ("sobol:warp=cosine,heuristic=power", "remove it"),
        ("sobol:warp=\"cosine + cylinder\",heuristic=best", "balance"),
        ("sobol:warp=cosine,warp=cylinder", "twice"),
        ("jittered:warp=cosine", "sampler"),
        ("sobol:scramble=no,warp=cosine", "scramble"),
        ("sobol:warp=\"0 * cosine + 1 * cylinder\"", "positive"),
        ("sobol:warp=\"-1 * cosine + 2 * cylinder\"", "positive"),
        ("sobol:warp=\"2 * cosine\"", "single"),
        ("file:a.csv,warp=cosine", "a.csv"),
        (":warp=cosine", "no name"),
        ("sobol:warp=phong:n=3,floor=0.1", "unknown parameter \"floor\""),
        ("r2:warp=env:a.exr,floor=0.1,up=y", "r2:warp=\"env:a.exr,floor=0.1,up=y\""),
        (
            "poisson-disk-square:wrapped=no,warp=cylinder + env:a.exr,floor=0.1,heuristic=power",
            "poisson-disk-square:wrapped=no,warp=\"cylinder + env:a.exr,floor=0.1\",heuristic=power",
        ),
        ("sobol:warp=\"cosine", "quote"),
    ] {
        let error = text.parse::<WarpedPattern>().unwrap_err().to_string();
        assert!(error.contains(part), "{text}: {error}");
    }
}

/// Three sets of 5 points in a file.
struct Five;

impl FileResolver for Five {
    fn profile(&self, _: &std::path::Path) -> Result<ProfileTable, ResolveError> {
        unimplemented!("there is no profile")
    }

    fn points(&self, _: &PointFileParameters) -> Result<Vec<PointFile>, ResolveError> {
        unimplemented!("there are no directions")
    }

    fn square_points(
        &self,
        _: &sphvar_samplers::SquarePointFileParameters,
    ) -> Result<Vec<PointFile<[f64; 2]>>, ResolveError> {
        let points = (0..5).map(|i| [f64::from(i) / 5.0, 0.5]).collect();
        let sets = vec![sphvar_samplers::PointSet::new(points)];
        Ok(vec![PointFile { name: "a.csv".into(), sets, ..PointFile::default() }])
    }
}

#[test]
fn files_of_points_have_their_own_number() {
    let pattern = WarpedPattern::parse("file:a.csv,warp=\"cosine + cylinder\"", &Five).unwrap();
    assert_eq!(pattern.own_count(), Some(10));
    assert_eq!(pattern.counts(1000), [5, 5]);
    assert_eq!(pattern.samplers(10).unwrap().len(), 2);
    assert_eq!(pattern.label(), "file:a.csv,warp=\"cosine + cylinder\"");
}

#[test]
fn counts_are_valid_parts_and_valid_totals_stay() {
    for text in [
        "sobol:warp=cosine",
        "jittered-square:warp=cosine",
        "sobol:warp=\"3 * cosine + 7 * cylinder\"",
        "jittered-square:warp=\"3 * cosine + 7 * cylinder\"",
        "jittered-square:warp=\"0.245 * cosine + 0.755 * cylinder\"",
        "jittered-square:warp=\"cosine + cylinder + vmf:kappa=3\"",
        "sobol:warp=\"1e-9 * cosine + 1 * cylinder + 1 * octahedral\"",
        "regular-square:warp=\"1e-9 * cosine + 1 * cylinder\"",
        "regular-square:warp=\"1e-300 * cosine + 1e300 * cylinder\"",
    ] {
        let pattern = warped(text);
        let mut last = 0;
        for n in (0..2000).chain([1 << 20, (1 << 40) + 1]) {
            let counts = pattern.counts(n);
            let total: usize = counts.iter().sum();
            assert_eq!(counts.len(), pattern.n_strategies());
            assert!(counts.iter().all(|&n| n > 0 && pattern.pattern.nearest_count(n) == n));
            assert_eq!(pattern.nearest_count(n), total, "{text}, {n}");
            assert_eq!(pattern.counts(total), counts, "{text}, {n}: a valid total stays");
            assert!(total >= last, "{text}, {n}: never decreasing");
            last = total;
            // Each part is off by half of a gap between squares, and by the steps between totals.
            let gap = 4.0 * counts.len() as f64 * ((n as f64).sqrt() + 4.0);
            assert!((total as f64 - n as f64).abs() <= gap, "{text}, {n}: {counts:?}");
        }
    }
    let sobol = warped("sobol:warp=\"3 * cosine + 7 * cylinder\"");
    assert_eq!(sobol.counts(100), [30, 70]);
    assert_eq!(sobol.counts(1), [1, 1]);
    // Without other limits every total is valid.
    for text in [
        "cosine + cylinder + octahedral",
        "1 * cosine + 3 * cylinder",
        "1e-9 * cosine + 1 * cylinder",
    ] {
        let pattern = warped(&format!("sobol:warp=\"{text}\""));
        let wrong = (pattern.n_strategies()..1000).find(|&n| pattern.nearest_count(n) != n);
        assert_eq!(wrong, None, "{text}");
    }
    assert_eq!(warped("sobol:warp=cosine").counts(usize::MAX), [usize::MAX]);
}

#[test]
fn invalid_totals_are_errors_that_name_the_next() {
    let pattern = warped("jittered-square:warp=\"1 * cosine + 3 * cylinder\"");
    assert_eq!(pattern.samplers(106).unwrap().len(), 2);
    let error = pattern.samplers(100).unwrap_err();
    assert!(matches!(error, Error::Total { requested: 100, nearest: 106, .. }), "{error}");
    assert!(error.to_string().contains("[25, 81], 106 together"), "{error}");
    // Of one warp, the error is the pattern's own.
    let error = warped("jittered-square:warp=cosine").samplers(70).unwrap_err();
    assert!(error.to_string().contains("the nearest valid count is 64"), "{error}");
    assert!(pattern.samplers(0).is_err() && warped("sobol:warp=cosine").samplers(0).is_err());
    // As a family of sets on the square it has one sampler.
    let single = warped("sobol:warp=cosine");
    assert_eq!(SamplerFamily::build(&single, 7, Square).unwrap().n_points(), 7);
    let error = SamplerFamily::build(&pattern, 106, Square).unwrap_err().to_string();
    assert!(error.contains("2 samplers"), "{error}");
}
