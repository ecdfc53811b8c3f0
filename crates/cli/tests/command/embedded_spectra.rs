//! Spectra of `embedding::Session` that are merged and stored.

use std::sync::Arc;

use sphvar_cli::embedding::{Session, SpectrumAnswer};

fn spectrum(words: &str, part: Option<[u64; 2]>) -> Result<SpectrumAnswer, String> {
    let words: Vec<String> = words.split(' ').map(str::to_owned).collect();
    Session::new(Arc::new(())).spectrum(&words, part).map_err(|failure| failure.message)
}

/// The document without the time.
fn result(spectrum: &SpectrumAnswer) -> String {
    let (start, _) = spectrum.document().split_once("\"seconds\"").unwrap();
    start.to_owned()
}

#[test]
fn parts_merge_in_any_order_to_one_run() {
    for words in [
        "spectrum jittered -n 48 -m 11 --lmax 9",
        "spectrum white-noise -n 60 -m 11 --lmax 9 --hemisphere",
        "spectrum jittered-square --square -n 64 -m 11 --kmax 6",
    ] {
        let whole = spectrum(words, None).unwrap();
        let parts = [1, 2, 3].map(|i| spectrum(words, Some([i, 3])).unwrap());
        for order in [[0, 1, 2], [2, 0, 1], [1, 2, 0]] {
            let [a, b, c] = order.map(|i| &parts[i]);
            let stored = SpectrumAnswer::of_bytes(&a.bytes().unwrap()).unwrap();
            let merged = stored.merged(b).unwrap().merged(c).unwrap();
            assert_eq!(result(&merged), result(&whole), "{words} {order:?}");
        }
        let error = parts[0].merged(&whole).unwrap_err().message;
        assert_eq!(error, "realization 0 is in the spectrum and in the other", "{words}");
    }
}

#[test]
fn spectra_that_have_no_common_sums_are_rejected() {
    let of = |words: &str| spectrum(&format!("spectrum {words}"), None).unwrap();
    let white = of("white-noise -n 12 -m 2 --lmax 4 --seed 1");
    for (other, expected) in [
        (of("white-noise -n 12 -m 2 --lmax 4 --seed 2"), "different seeds: 1 and 2"),
        (of("jittered -n 12 -m 2 --lmax 4 --seed 1"), "different samplers"),
        (of("white-noise -n 12 -m 2 --lmax 5 --seed 1"), "realization 0 is in"),
        (of("jittered -n 12 --exact --lmax 4"), "closed form"),
        (of("white-square --square -n 12 -m 2 --kmax 4"), "unit square and of the sphere"),
    ] {
        for error in [white.merged(&other), other.merged(&white)].map(Result::unwrap_err) {
            let is_named = error.message.contains(expected.trim_end_matches(": 1 and 2"));
            assert!(is_named, "{expected}: {}", error.message);
        }
    }
    for (words, part, expected) in [
        ("spectrum jittered -n 12 --exact", [1, 2], "closed form has no parts"),
        ("spectrum jittered -n 12 --pairs", [1, 2], "pair correlation has no parts"),
        ("spectrum jittered -n 12", [3, 2], "1 <= I <= K"),
        ("spectrum jittered -n 12", [0, 0], "1 <= I <= K"),
        ("spectrum fibonacci -n 12", [2, 2], "a deterministic pattern has one set"),
        ("quality fibonacci -n 12", [1, 1], "the command spectrum"),
    ] {
        let error = spectrum(words, Some(part)).unwrap_err();
        assert!(error.contains(expected), "{words}: {error}");
    }
}

#[test]
fn damaged_bytes_are_rejected() {
    let stored = spectrum("spectrum white-noise -n 4 -m 2 --lmax 2", None).unwrap();
    let stored = stored.bytes().unwrap();
    for wrong in [&b""[..], b"sphvar shard 4\n", &stored[..stored.len() / 2], &stored[1..]] {
        let error = SpectrumAnswer::of_bytes(wrong).unwrap_err().message;
        assert!(error.contains("expected a stored spectrum"), "{error}");
    }
    // No change of a byte is a panic.
    for i in 0..stored.len() {
        let mut changed = stored.clone();
        changed[i] ^= 0x55;
        let _ = SpectrumAnswer::of_bytes(&changed).and_then(|read| read.merged(&read));
    }
}
