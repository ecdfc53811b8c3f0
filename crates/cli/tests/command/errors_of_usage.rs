//! Invalid command lines: exit status 2, and a message with the valid alternatives.

use crate::workplace::Workplace;

/// Runs each in an empty folder, which must stay empty.
fn assert_usage(cases: &[(&str, &[&str])]) {
    let place = Workplace::new();
    for (arguments, parts) in cases {
        place.run(arguments).fails(2, parts);
        assert!(place.names().is_empty(), "sphvar {arguments} left {:?}", place.names());
    }
}

#[test]
fn numbers_of_points() {
    assert_usage(&[
        ("sample white-noise -n 0", &["white-noise", "at least 1", "got 0"]),
        ("sample jittered -n 0 --nearest -o p.csv", &["at least 1", "got 0"]),
        ("spectrum healpix -n 0", &["at least 1", "got 0"]),
        ("variance fibonacci -n 12,0 --integrand cosine", &["at least 1", "got 0"]),
        ("compare -n 0 --integrand cosine", &["at least 1", "got 0"]),
        ("bounds --profile step -n 0", &["-n", "at least 1", "got 0"]),
        ("eval profile --profile step -n 0 --lmax 4", &["-n", "at least 1", "got 0"]),
        (
            "sample jittered -n 100 -o p.csv",
            &["100", "12 nside^2", "nearest valid count is 108", "--nearest"],
        ),
        (
            "sample healpix -n 25 --hemisphere",
            &["25", "hemisphere", "6 nside^2", "nearest valid count is 24"],
        ),
        (
            "variance jittered -n 13 --integrand cosine",
            &["13", "nearest valid count is 12", "--nearest"],
        ),
        ("bounds jittered -n 13 --profile step", &["13", "nearest valid count is 12", "--nearest"]),
        ("spectrum jittered -n 18446744073709551615 --nearest", &["jittered", "the maximum is"]),
        ("sample white-noise -n -3", &["-3"]),
        ("sample white-noise -n ten", &["ten", "--count"]),
        ("sample white-noise -n 1e-3", &["1e-3"]),
        ("sample white-noise", &["--count"]),
        ("spectrum", &["SAMPLER"]),
        ("spectrum jittered", &["--count"]),
        ("bounds jittered", &["--count"]),
        ("variance jittered --integrand cosine", &["--count"]),
    ]);
    let place = Workplace::new();
    let outcome = place.run("sample jittered -n 100 --nearest -o p.csv").ok();
    assert!(
        outcome.stderr.contains("108 points, the valid count nearest to the requested 100"),
        "{}",
        outcome.stderr
    );
    assert_eq!(place.text("p.csv").lines().count(), 1 + 108);
}

/// Every spelling of earlier versions, with its replacement.
#[test]
fn old_spellings_name_the_new_ones() {
    let count: &[&str] = &["'-n' or '--count'", "instead of"];
    let files: &[&str] = &["--points requires a file", "'-n' or '--count'"];
    assert_usage(&[
        ("sample jittered --points 12", count),
        ("sample jittered --points=12", count),
        ("variance jittered --points 12 --integrand cosine", count),
        ("compare jittered --points 12", count),
        ("choose --integrand cosine --points 12", count),
        ("bounds jittered --points 12", count),
        ("eval profile --profile step --points 12 --lmax 3", count),
        ("render cornell --sampler jittered --points 12", count),
        ("--quiet sample jittered --points 12", count),
        ("spectrum jittered --n-points 12", count),
        ("audit jittered --n-points 12", count),
        ("spectrum jittered --points 12", files),
        ("audit --points 10k", files),
        (
            "choose --integrand cosine --error 1% --max-points 12",
            &["'--max-count' instead of '--max-points'"],
        ),
        ("render cornell --reference-n 12", &["'--reference-count' instead of '--reference-n'"]),
        (
            "choose --integrand cosine -n 12 --sampler step",
            &["'--samplers' instead of '--sampler'"],
        ),
        ("spectrum --sampler step -n 12", &["[SAMPLER] without '--sampler'"]),
    ]);
    let place = Workplace::new();
    // A file name may be a number.
    place.write("12", "x,y,z\n0,0,1\n");
    place.run("spectrum --points 12 --lmax 2").ok();
}

#[test]
fn one_sampler_and_one_number_where_a_list_makes_no_sense() {
    let several: &[&str] =
        &["expected one sampler, got 2", "compare, variance and choose take several"];
    assert_usage(&[
        ("sample jittered,fibonacci -n 12", several),
        ("spectrum poisson-disk:mode=exact,radius=0.1,jittered -n 12", several),
        ("audit jittered,fibonacci -n 12", several),
        ("bounds jittered,fibonacci -n 12", several),
        ("render cornell --sampler jittered,fibonacci", several),
        ("sample all -n 12", &["expected one sampler, got all"]),
        ("sample jittered -n 12,48", &["expected one number", "12,48"]),
        ("choose --integrand cosine -n 12..48", &["expected one number", "12..48"]),
        ("spectrum jittered -n 12 --lmax 4.5", &["whole number", "4.5"]),
        ("spectrum jittered -n 12 --epsilon tiny", &["number", "tiny"]),
        ("spectrum jittered -n 12 -m 1.5", &["whole number", "1.5"]),
        ("bounds", &["SAMPLER", "--spectrum", "--profile"]),
        ("choose --integrand cosine", &["--error", "--count"]),
    ]);
}

#[test]
fn names() {
    assert_usage(&[
        (
            "sample jitered -n 12",
            &["sampler \"jitered\"", "did you mean \"jittered\"", "fibonacci"],
        ),
        ("sample Healpix -n 12", &["sampler \"Healpix\"", "did you mean \"healpix\""]),
        ("spectrum white-nois -n 12", &["did you mean \"white-noise\""]),
        ("variance jittered,zzz -n 12 --integrand cosine", &["\"zzz\"", "; valid: white-noise"]),
        ("compare jittered,fibonaci --integrand cosine", &["did you mean \"fibonacci\""]),
        ("bounds healpx -n 12 --profile step", &["did you mean \"healpix\""]),
        ("sample jittered:radius=2 -n 12", &["jittered:radius=2", "\"radius\""]),
        ("variance healpix -n 12 --integrand ylm", &["ylm", "l is missing"]),
        (
            "variance healpix -n 12 --integrand cosin",
            &["\"cosin\"", "did you mean \"cosine\"", "cap"],
        ),
        ("variance healpix -n 12 --integrand ylm:l=2,k=1", &["ylm:l=2,k=1", "\"k\"", "l, m"]),
        ("variance healpix -n 12 --integrand ylm:l=2,l=3", &["twice"]),
        ("variance healpix -n 12 --integrand ylm:l=two", &["l must be a number", "two"]),
        ("variance healpix -n 12 --integrand cap:60", &["cap:60", "degrees is missing"]),
        ("variance healpix -n 12 --integrand env:", &["file is missing", "env:FILE"]),
        ("bounds --profile stp -n 12", &["profile \"stp\"", "did you mean \"step\""]),
        ("bounds --profile poly -n 12", &["poly", "b is missing"]),
        ("bounds --profile step:beta=1 -n 12", &["\"beta\"", "alpha, gamma"]),
        ("eval profile --profile cubic -n 12 --lmax 3", &["\"cubic\"", "quadratic"]),
        ("smple jittered -n 12", &["smple", "sample"]),
        ("sample jittered -n 12 --sed 4", &["--sed", "--seed"]),
        ("healpix vec2pxi --nside 2 -", &["vec2pxi", "vec2pix"]),
    ]);
    // Without arguments, the complete help is shown as a usage error.
    let outcome = Workplace::new().run("");
    assert!(outcome.stderr.contains("Usage: sphvar") && outcome.stderr.contains("compare"));
    assert_eq!(outcome.status, Some(2));
}

#[test]
fn parameters() {
    let integrands: [(&str, &[&str]); 13] = [
        ("cap:degrees=0", &["degrees", "(0, 180]", "got 0"]),
        ("cap:degrees=181", &["degrees", "(0, 180]", "got 181"]),
        ("cap:degrees=nan", &["degrees", "(0, 180]", "NaN"]),
        ("cap:degrees=-inf", &["degrees", "(0, 180]"]),
        ("vmf:kappa=-1", &["kappa", "[0, 1e6]", "got -1"]),
        ("vmf:kappa=nan", &["kappa", "[0, 1e6]", "NaN"]),
        ("vmf:kappa=inf", &["kappa", "[0, 1e6]"]),
        ("ylm:l=2,m=3", &["|m| <= l", "l = 2, m = 3"]),
        ("ylm:l=2,m=-3", &["|m| <= l", "m = -3"]),
        ("ylm:l=-2", &["l must be a whole number from 0", "-2"]),
        ("ylm:l=1000001", &["ylm:l=1000001", "largest degree is 1000000"]),
        ("ylm:l=99999999999", &["largest degree is 1000000"]),
        ("ylm:l=3,m=1 --hemisphere", &["ylm:l=3,m=1", "odd", "use an even l"]),
    ];
    for (integrand, parts) in integrands {
        for command in [
            "variance healpix -n 24 --nearest",
            "compare healpix -n 24",
            "bounds --profile step -n 24",
        ] {
            assert_usage(&[(&format!("{command} --integrand {integrand}"), parts)]);
        }
    }
    assert_usage(&[
        ("bounds --profile poly:b=-1 -n 9", &["exponent is -1", "at least 0"]),
        ("bounds --profile poly:b=2,alpha=0 -n 9", &["alpha is 0", "above 0"]),
        ("bounds --profile poly:b=2,gamma=nan -n 9", &["gamma is NaN"]),
        ("bounds --profile step -n 9 --decay 1", &["decay is 1", "above 1"]),
        (
            "bounds --profile step -n 9 --confidence nan",
            &["confidence", "above 0 and below 1", "NaN"],
        ),
        (
            "bounds jittered -n 12 --profile step --confidence 1",
            &["confidence", "below 1", "got 1"],
        ),
        ("eval legendre --l 2 --m 3 --theta 1", &["|m| <= l", "l = 2, m = 3"]),
        ("eval legendre --l 2 --m 1 --theta 4", &["4", "[0, pi]"]),
        ("eval legendre --l 2 --m 1 --theta nan", &["NaN", "[0, pi]"]),
        ("eval ylm --l 2 --m -3 --theta 1 --phi 0", &["m = -3", "l = 2"]),
        ("eval ylm --l 2 --m 2 --theta 1 --phi inf", &["inf", "finite"]),
        ("eval cap-power --degrees 181 --lmax 3", &["degrees", "(0, 180]", "181"]),
        ("sample healpix -n 12 -j 1000000", &["1000000", "0..=1024"]),
        ("sample healpix -n 12 -s -1", &["-1"]),
    ]);
}

#[test]
fn numbers_of_realizations() {
    assert_usage(&[
        ("sample white-noise -n 12 -m 0 -o p.npy", &["-m", "at least 1", "got 0"]),
        ("spectrum white-noise -n 12 -m 0", &["-m", "at least 1", "got 0"]),
        ("bounds white-noise -n 12 -m 0 --profile step", &["at least 1 realization", "got 0"]),
        ("variance white-noise -n 12 -m 0 --integrand cosine", &["-m", "at least 4", "got 0"]),
        (
            "variance white-noise -n 12 -m 1 --integrand cosine -o v.csv",
            &["-m", "at least 4", "got 1"],
        ),
        (
            "compare white-noise -n 12 -m 1 --integrand cosine -o out",
            &["-m", "at least 4", "got 1"],
        ),
        (
            "variance white-noise -n 12 -m 4 --integrand cosine --spectrum-realizations 0",
            &["at least 1", "got 0"],
        ),
    ]);
}

#[test]
fn degrees_beyond_the_limit() {
    let parts: &[&str] = &["--lmax", "largest degree is 1000000", "1000001"];
    assert_usage(&[
        ("spectrum white-noise -n 100 --lmax 1000001 -o s.csv", parts),
        ("variance white-noise -n 100 --integrand cosine --lmax 1000001", parts),
        ("compare white-noise -n 100 --integrand cosine --lmax 1000001", parts),
        ("bounds white-noise -n 100 --profile step --lmax 1000001", parts),
        ("eval cap-power --degrees 60 --lmax 1000001", parts),
        ("eval profile --profile step -n 5 --lmax 1000001", parts),
        ("eval legendre --l 1000001 --m 0 --theta 1", &["--l", "largest degree is 1000000"]),
        ("spectrum white-noise -n 9 --lmax 18446744073709551615", &["largest degree is 1000000"]),
    ]);
}

#[test]
fn coefficients_out_of_range() {
    assert_usage(&[
        ("spectrum white-noise -n 9 --hemisphere --coefficient 3 0 c.csv", &["hemisphere", "even"]),
        (
            "spectrum healpix -n 12 --lmax 4 --coefficient 5 0 a.csv",
            &["M <= L <= lmax", "L = 5", "lmax = 4"],
        ),
        ("spectrum healpix -n 12 --lmax 4 --coefficient 2 3 a.csv", &["M <= L <= lmax", "M = 3"]),
        ("spectrum healpix -n 12 --lmax 4 --coefficient two 0 a.csv", &["L M FILE", "\"two\""]),
        ("spectrum healpix -n 12 --lmax 4 --coefficient 2 -1 a.csv", &["-1"]),
        ("spectrum healpix -n 12 --lmax 4 --coefficient 2 1", &["--coefficient", "3 values"]),
        ("spectrum healpix -n 12 --coefficient 2 1 - --json", &["--coefficient must name a file"]),
        ("spectrum healpix -n 12 --per-order - --json", &["--per-order must name a file"]),
    ]);
}

#[test]
fn closed_forms_that_do_not_exist() {
    let place = Workplace::new();
    place.write("p.csv", "x,y,z\n0,0,1\n");
    let outcome = place.run("spectrum --points p.csv --exact");
    outcome.fails(2, &["--exact", "--points", "cannot be used with"]);
    assert_usage(&[
        (
            "spectrum poisson-disk -n 12 --exact -o s.csv",
            &["poisson-disk", "has no closed form", "white-noise, jittered, healpix"],
        ),
        ("spectrum step:alpha=0.5 -n 12 --exact", &["step:alpha=0.5", "equal-area"]),
        ("spectrum jittered -n 13 --exact", &["13", "nearest valid count is 12", "--nearest"]),
        (
            "spectrum jittered -n 12 --exact --per-order lm.csv",
            &["--exact", "--per-order", "cannot be used with"],
        ),
        (
            "spectrum jittered -n 12 --exact --coefficient 1 0 a.csv",
            &["--exact", "--coefficient", "cannot be used with"],
        ),
        ("spectrum jittered -n 12 --exact -m 100", &["--exact", "--realizations"]),
        ("spectrum jittered -n 12 --exact --method fast", &["--exact", "--method"]),
        ("spectrum jittered -n 12 --exact --lmax 1000001", &["largest degree is 1000000"]),
    ]);
}
