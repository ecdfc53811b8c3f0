//! The same seed gives the same bytes with any number of threads, and another seed gives different
//! ones.

use crate::workplace::Workplace;

/// Returns standard output and all files of a run, without its time.
fn traces(arguments: &str) -> Vec<(String, Vec<u8>)> {
    let place = Workplace::new();
    let stdout = without_seconds(&place.run(arguments).ok().stdout);
    let mut traces = vec![("standard output".to_owned(), stdout.into_bytes())];
    for name in place.names() {
        if place.path(&name).is_dir() {
            for inner in place.names_in(&name) {
                let path = format!("{name}/{inner}");
                traces.push((path.clone(), place.bytes(&path)));
            }
        } else if name.ends_with(".json") {
            let text = without_seconds(&place.text(&name));
            traces.push((name, text.into_bytes()));
        } else {
            traces.push((name.clone(), place.bytes(&name)));
        }
    }
    traces
}

fn without_seconds(text: &str) -> String {
    let Some((before, rest)) = text.split_once("\"seconds\":") else {
        return text.to_owned();
    };
    format!("{before}{}", rest.trim_start_matches(|c: char| c != ',' && c != '}'))
}

/// Runs with 1, 2 and 3 threads and then with another seed; the files in `fixed` do not depend on
/// the seed.
fn assert_reproducible(arguments: &str, fixed: &[&str]) {
    let one = traces(&format!("{arguments} --threads 1"));
    for threads in ["--threads 2", "-j 3", "-j2", "--threads=3", ""] {
        let other = traces(&format!("{arguments} {threads}"));
        let names = |t: &[(String, Vec<u8>)]| t.iter().map(|t| t.0.clone()).collect::<Vec<_>>();
        assert_eq!(names(&other), names(&one), "{arguments} {threads}");
        for ((name, a), (_, b)) in one.iter().zip(&other) {
            assert!(a == b, "{name} differs between --threads 1 and {threads:?}: {arguments}");
        }
        if threads == "-j 3" && arguments.starts_with("compare") {
            // Three runs suffice for the slowest command.
            break;
        }
    }
    let reseeded = traces(&format!("{arguments} --seed 1"));
    for ((name, a), (_, b)) in one.iter().zip(&reseeded) {
        let expected = fixed.contains(&&**name) || a.is_empty();
        // The provenance contains the seed, so only the text below it is compared.
        let body = |bytes: &[u8]| {
            let text = String::from_utf8_lossy(bytes).into_owned();
            let lines = text.lines().filter(|l| !l.starts_with('#') && !l.contains("seed"));
            lines.collect::<Vec<_>>().join("\n")
        };
        if !name.ends_with(".json") && name != "standard output" {
            assert_eq!(body(a) == body(b), expected, "{name} with another seed: {arguments}");
        }
    }
}

#[test]
fn sample() {
    for name in ["p.csv", "p.npy", "p.ply"] {
        assert_reproducible(&format!("sample jittered -n 48 -m 5 --rotate -o {name}"), &[]);
    }
}

#[test]
fn spectrum() {
    assert_reproducible(
        "spectrum jittered -n 48 -m 37 --lmax 20 --json -o s.csv --per-order lm.csv --coefficient 3 2 a.csv",
        &[],
    );
    assert_reproducible("spectrum white-noise -n 100 -m 11 --lmax 20 -o s.json", &[]);
}

#[test]
fn variance() {
    assert_reproducible(
        "variance jittered,white-noise -n 12,48 --integrand cap:degrees=60 -m 50 --json -o v.csv",
        &[],
    );
}

#[test]
fn bounds() {
    assert_reproducible("bounds jittered -n 48 -m 33 --profile poly:b=2 --json -o b.csv", &[]);
}

#[test]
fn compare() {
    assert_reproducible(
        "compare jittered,poisson-disk -n 12,27 --integrand cosine -m 10 --spectrum-realizations 10 --json -o out",
        &["out/integrand.svg"],
    );
}

/// The printed numbers of all values depend on the seed, also in JSON.
#[test]
fn seeds_differ() {
    let place = Workplace::new();
    let power = |seed: u32| {
        let arguments = format!("spectrum jittered -n 48 -m 5 --lmax 6 --json --seed {seed}");
        place.run(&arguments).json()["power"].clone()
    };
    assert_eq!(power(3), power(3));
    let (a, b) = (power(3), power(4));
    for l in 1..=6 {
        assert_ne!(a[l], b[l], "degree {l}");
    }
}

/// The realizations of a run are the first ones of a longer run.
#[test]
fn longer_runs_extend_shorter_ones() {
    let place = Workplace::new();
    let set = |m: u32| {
        place.run(&format!("sample white-noise -n 9 -m {m} --rotate --json")).json()["points"]
            .clone()
    };
    let (few, many) = (set(2), set(5));
    assert_eq!(few[0], many[0]);
    assert_eq!(few[1], many[1]);
    assert_ne!(many[1], many[2]);
}
