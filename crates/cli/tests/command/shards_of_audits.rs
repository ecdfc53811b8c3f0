//! `audit` in parts.

use crate::parts_of_runs::WholeRun;
use crate::workplace::Workplace;

const FEW: &str = "--lmax 2 --alpha 0.5";

#[test]
fn parts_of_audits_are_merged_to_one_run() {
    let place = Workplace::new();
    let whole = WholeRun::new(&place, &format!("audit jittered -n 12 -m 31 {FEW}"));
    for parts in [1, 3, 16] {
        whole.check(parts);
    }
    // A finished part that is run again does not change.
    let before = place.bytes("7-of-16.shard");
    whole.part(7, 16);
    assert!(place.bytes("7-of-16.shard") == before);
    let run = format!("audit fibonacci -n 10 -m 30 --hemisphere --unrotated {FEW}");
    WholeRun::new(&place, &run).check(4);
}

#[test]
fn parts_of_files_are_merged_to_one_run() {
    let place = Workplace::new();
    place.run("sample jittered -n 12 -m 40 -o sets.npy").ok();
    for source in ["--points sets.npy", "file:sets.npy", "file:sets.npy -m 33"] {
        WholeRun::new(&place, &format!("audit {source} {FEW}")).check(3);
    }
    place.write("sets.npy", place.bytes("sets.npy").split_last().unwrap().1);
    place.run("merge 1-of-3.shard 2-of-3.shard 3-of-3.shard").fails(1, &["sets.npy"]);
}

#[test]
fn partial_merges_of_audits_need_enough_realizations() {
    let place = Workplace::new();
    let whole = WholeRun::new(&place, &format!("audit white-noise -n 5 -m 60 --unrotated {FEW}"));
    let (first, last) = (whole.part(1, 4), whole.part(4, 4));
    let named = "merge 1-of-4.shard 4-of-4.shard --partial --json";
    assert_eq!(place.run(named).json()["realizations"], 30);
    place.run(&format!("merge {first} --partial")).fails(1, &["at least 30", "has 15"]);
    place.run(&format!("merge {last} {first}")).fails(1, &["parts 2, 3 of 4"]);
}
