//! Functions of an embedding program in questions and integrals of `embedding::Session`.

use std::sync::Arc;

use glam::DVec3;
use sphvar_cli::embedding::{FailureKind, Session};
use sphvar_integrands::{Domain, Error, Integrand, SampledFunction, VectorIntegrand};

use crate::workplace::Workplace;

fn words(text: &str) -> Vec<String> {
    text.split(' ').map(|word| word.replace('~', " ")).collect()
}

/// A session with a clamped cosine, of which only values are known, and a polynomial.
fn session() -> Session {
    let session = Session::new(Arc::new(()));
    let kink: Arc<dyn Integrand + Send + Sync> = Arc::new(|dir: DVec3| dir.z.max(0.0));
    session.add_function("kink", kink);
    session.add_function("slope", Arc::new(SampledFunction::new(|dir: DVec3| dir.z, 1)));
    session
}

struct Two;

impl VectorIntegrand for Two {
    fn components(&self) -> usize {
        2
    }

    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        for (row, dir) in values.chunks_exact_mut(2).zip(dirs) {
            row.copy_from_slice(&[dir.z.max(0.0), dir.z * dir.z]);
        }
        Ok(())
    }
}

#[test]
fn integrals_of_functions_are_those_of_the_same_integrands() {
    let integrate = |integrand: &str| {
        let question = format!("integrate --rtol 1e-3 --seed 3 --integrand {integrand}");
        session().integrate(&words(&question), None).unwrap()
    };
    for (function, known) in [
        ("function:kink", "cosine"),
        ("2~*~function:kink~@~30/40~+~0.5", "2~*~cosine~@~30/40~+~0.5"),
    ] {
        let (function, known) = (integrate(function), integrate(known));
        assert_eq!(function.values, known.values);
        assert_eq!(function.failure, None);
        // The nodes give the value.
        let nodes = function.nodes().unwrap();
        assert_eq!(nodes.points.len(), nodes.weights.len());
    }
    assert!(integrate("function:kink").document.contains("\"exact\":null"));
    let question = words("integrate --rtol 1e-3 --seed 3 --integrand two");
    let two = session().integrate(&question, Some(&Two)).unwrap();
    assert_eq!((two.values.len(), two.errors.len()), (2, 2));
    assert!((two.values[1] / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 1e-3);
    // A tolerance that is not met has a result too.
    let question = words("integrate --rtol 1e-9 --max-points 1000 --integrand function:kink");
    let missed = session().integrate(&question, None).unwrap();
    assert!(missed.failure.unwrap().contains("the tolerance is not met"));
}

#[test]
fn expressions_have_functions_of_the_program_but_the_command_has_none() {
    let energy = |text: &str| session().energy(text, Domain::Sphere, 4).map_err(|e| e.message);
    let (ours, known) = (energy("3 * function:slope").unwrap(), energy("3 * ylm:l=1").unwrap());
    let ratio = ours.per_band()[1] / known.per_band()[1];
    assert!((ratio / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 1e-12, "{ratio}");
    assert!(energy("function:other").unwrap_err().contains("function:other"));
    let error = session().integrate(&words("quality fibonacci -n 12"), None).unwrap_err();
    assert_eq!(
        (error.kind, &*error.message),
        (FailureKind::Usage, "expected the command integrate")
    );
    let place = Workplace::new();
    place
        .run("integrate --integrand function:f")
        .fails(2, &["function:f", "only programs that use the library"]);
}
