//! `sphvar sample` with patterns of which every prefix is a set of the pattern.

use crate::workplace::Workplace;

/// Returns the points of a CSV file, without weights, as they are written.
fn points(text: &str, columns: usize) -> Vec<String> {
    let lines = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    lines.map(|line| line.split(',').take(columns).collect::<Vec<_>>().join(",")).collect()
}

/// Sets of fewer points are the heads of larger ones in every realization: as they are, rotated,
/// shifted and mapped to a density.
#[test]
fn heads_of_sequences_do_not_depend_on_the_number_of_points() {
    let place = Workplace::new();
    for (sampler, columns, flags) in [
        ("sobol", 3, "-s 1"),
        ("sobol", 3, "--rotate"),
        ("sobol:randomization=shift,map=octahedral", 3, "--hemisphere --rotate -s 2"),
        ("halton:randomization=owen", 3, "--hemisphere"),
        ("pmj02:map=healpix", 3, "--rotate"),
        ("r2", 3, ""),
        ("white-noise", 3, "--rotate"),
        ("best-candidate", 3, "--rotate"),
        ("sobol", 2, "--square"),
        ("sobol:randomization=digital", 2, "--square --shift"),
        ("pmj02", 2, "--square --shift -s 3"),
        ("halton", 2, "--square --shift"),
        ("sobol:warp=cosine", 3, "--hemisphere"),
        ("halton:randomization=owen,warp=vmf:kappa=5", 3, "-s 4"),
    ] {
        let run = |n: usize| {
            place.run(&format!("sample {sampler} -n {n} -m 2 {flags} -o {n}-{{i}}.csv")).ok();
            [0, 1].map(|i| points(&place.text(&format!("{n}-00000{i}.csv")), columns))
        };
        let (few, many) = (run(25), run(70));
        assert_ne!(few[0], few[1], "{sampler} {flags}");
        for (few, many) in few.iter().zip(&many) {
            assert_eq!((few.len(), many.len()), (25, 70), "{sampler} {flags}");
            assert_eq!(few[..], many[..25], "{sampler} {flags}");
        }
    }
}

#[test]
fn randomizations_and_maps_are_parameters() {
    let place = Workplace::new();
    // Lines are wrapped.
    let listed = |arguments: &str| {
        let text = place.run(&format!("list samplers {arguments}")).ok().stdout;
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let text = listed("sobol hammersley r2 pmj02");
    for part in [
        "randomization=owen",
        "randomization=shift",
        "none, shift, digital, owen",
        "map=cylinder",
        "cylinder, octahedral, healpix",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let text = listed("halton --square");
    assert!(text.contains("none, digital, owen"), "{text}");
    for (sampler, advice) in [
        ("sobol:randomization=owens", "owen"),
        ("r2:randomization=owen", "none, shift"),
        ("pmj02:map=disk", "cylinder, octahedral, healpix"),
        ("sobol:map=healpix,warp=cosine", "map"),
    ] {
        place.run(&format!("sample {sampler} -n 8")).fails(2, &[advice]);
    }
    place.run("sample halton:randomization=shift --square -n 8").fails(2, &["none, digital, owen"]);
}
