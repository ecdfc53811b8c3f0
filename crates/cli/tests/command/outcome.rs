use std::process::Output;

use serde_json::Value;

/// The result of one run of the command.
#[derive(Debug)]
pub(crate) struct Outcome {
    arguments: String,
    pub(crate) status: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Outcome {
    /// Takes the output of a run and asserts that it is text without any trace of a panic.
    pub(crate) fn new(arguments: &str, output: Output) -> Self {
        let stderr = String::from_utf8(output.stderr).unwrap();
        for trace in ["panicked", "backtrace", "RUST_", "memory allocation"] {
            assert!(!stderr.contains(trace), "sphvar {arguments}\n{stderr}");
        }
        Self {
            arguments: arguments.to_owned(),
            status: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr,
        }
    }

    /// Asserts success and returns itself.
    pub(crate) fn ok(self) -> Self {
        assert_eq!(self.status, Some(0), "sphvar {}\n{}", self.arguments, self.stderr);
        self
    }

    /// Asserts success and that standard output is exactly one JSON document; returns it.
    pub(crate) fn json(self) -> Value {
        let outcome = self.ok();
        serde_json::from_str(&outcome.stdout)
            .unwrap_or_else(|e| panic!("sphvar {}: {e}\n{}", outcome.arguments, outcome.stdout))
    }

    /// Asserts the exit status, an empty standard output, and a message that contains all these
    /// parts.
    pub(crate) fn fails(self, status: i32, parts: &[&str]) {
        let Self { arguments, stdout, stderr, .. } = &self;
        assert_eq!(self.status, Some(status), "sphvar {arguments}\n{stderr}");
        assert_eq!(stdout, "", "sphvar {arguments}");
        assert!(stderr.lines().count() < 12, "a long message: sphvar {arguments}\n{stderr}");
        for part in parts {
            assert!(stderr.contains(part), "sphvar {arguments}\n{stderr}\nlacks {part:?}");
        }
    }
}

/// Returns whether two numbers agree up to the last bit, which `serde_json` may read incorrectly.
pub(crate) fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 2.0 * f64::EPSILON * b.abs()
}

/// Returns the keys of a JSON object, in the order of the document's type.
pub(crate) fn keys(value: &Value) -> Vec<&str> {
    value.as_object().unwrap_or_else(|| panic!("no object: {value}")).keys().map(|k| &**k).collect()
}

/// Returns a list of numbers.
pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().unwrap_or_else(|| panic!("no list: {value}"));
    list.iter().map(|x| x.as_f64().unwrap_or_else(|| panic!("no number: {x}"))).collect()
}

/// Asserts that an object has all these keys and possibly others.
#[track_caller]
pub(crate) fn assert_keys(value: &Value, wanted: &[&str]) {
    let got = keys(value);
    for key in wanted {
        assert!(got.contains(key), "{key} is missing: {got:?}");
    }
}
