//! No output replaces an input or another output, and every form is found whatever the case of its extension.

use serde_json::Value;

use crate::workplace::Workplace;

const POINTS: &str = "x,y,z\n1,0,0\n0,1,0\n0,0,1\n";

#[test]
fn inputs_are_not_overwritten() {
    let place = Workplace::new();
    place.write("v.csv", POINTS);
    place.write("s.csv", "l,power\n0,3\n1,1\n2,1\n3,1\n");
    std::os::unix::fs::symlink(place.path("v.csv"), place.path("link.csv")).unwrap();
    for part in [1, 2] {
        place
            .run(&format!(
                "spectrum jittered -n 12 -m 4 --lmax 4 --shard {part}/2 --save {part}.shard"
            ))
            .ok();
    }
    let kept = ["v.csv", "s.csv", "1.shard"].map(|name| place.bytes(name));
    for command in [
        "spectrum --points v.csv -o v.csv",
        "spectrum --points v.csv -o link.csv",
        "spectrum --points link.csv -o ./v.csv",
        "healpix vec2pix --nside 2 v.csv -o v.csv",
        "bounds --spectrum s.csv -n 3 -o s.csv",
        "merge 1.shard 2.shard --save 1.shard",
    ] {
        place.run(command).fails(1, &["cannot write", "is an input of this command"]);
    }
    assert!(["v.csv", "s.csv", "1.shard"].map(|name| place.bytes(name)) == kept);
    // A copy is another file.
    place.run("spectrum --points v.csv -o w.csv").ok();
}

#[test]
fn outputs_have_files_of_their_own() {
    let place = Workplace::new();
    // Before any work, also by other names.
    std::fs::create_dir(place.path("folder")).unwrap();
    for name in ["q.csv", "./q.csv", "folder/../q.csv"] {
        let run = format!("spectrum white-noise -n 5 -m 3 --save q.csv -o {name}");
        place.run(&run).fails(1, &["q.csv", "--save names it"]);
    }
    // In another run it is replaced.
    place.run("spectrum white-noise -n 5 -m 3 -o q.csv").ok();
    place.run("spectrum white-noise -n 5 -m 3 -o q.csv").ok();
}

#[test]
fn extensions_are_known_in_any_case() {
    let place = Workplace::new();
    for name in ["a.CSV", "a.Json", "a.SVG"] {
        place.run(&format!("spectrum jittered -n 12 -m 3 -o {name}")).ok();
        assert!(!place.bytes(name).is_empty(), "{name}");
    }
}

#[test]
fn commands_in_provenances_are_quoted_for_a_shell() {
    let place = Workplace::new();
    let integrand = "cap:degrees=30 @ 40/10 * cosine + 0.5 * vmf:kappa=10";
    let mut command = place.command("variance jittered -n 12 -m 4 --json");
    let output = command.args(["--integrand", integrand]).output().unwrap();
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    let command = document["provenance"]["command"].as_str().unwrap();
    assert!(command.ends_with(&format!("--integrand '{integrand}'")), "{command}");
}

#[test]
fn repeated_samplers_and_counts_are_one_row() {
    let place = Workplace::new();
    let repeated = "variance fibonacci fibonacci -n 48,48 --integrand cosine -m 4 --json";
    assert_eq!(place.run(repeated).json()["rows"].as_array().unwrap().len(), 1);
}

/// Five points are fewer than any jittered pattern has.
#[test]
fn a_budget_below_the_smallest_count_leaves_a_sampler_out() {
    let place = Workplace::new();
    let document = place.run("choose jittered,fibonacci --integrand cosine -n 5 --json").json();
    assert_eq!(document["rows"].as_array().unwrap().len(), 1);
    assert_eq!(document["left_out"][0]["sampler"], "jittered");
    let reason = document["left_out"][0]["reason"].as_str().unwrap();
    assert!(reason.contains("minimum number of points, 12"), "{reason}");
}

/// The error of a prediction has two parts, under the same meanings in both commands.
#[test]
fn choose_and_variance_state_the_same_errors() {
    let place = Workplace::new();
    let question = "poisson-disk -n 96 --integrand cap:degrees=60 --json";
    let variance = place.run(&format!("variance {question} -m 4")).json();
    let choice = place.run(&format!("choose {question}")).json();
    let (row, best) = (&variance["rows"][0], &choice["rows"][0]);
    assert_eq!(row["predicted"], best["variance"]);
    assert_eq!(row["predicted_stderr"], best["variance_stderr"]);
    assert_eq!(row["predicted_tail_error"], best["variance_tail_error"]);
}

#[test]
fn completions_have_no_json_form() {
    Workplace::new().run("completions bash --json").fails(2, &["no JSON form"]);
}
