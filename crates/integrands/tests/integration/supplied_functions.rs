//! Functions that the program supplies: as terms of expressions, with a degree that is given or
//! found at first use, evaluated in batches, and failing.

use std::f64::consts::PI;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use sphvar_integrands::grammar::ResolveError;
use sphvar_integrands::{
    DeferredFunction, Domain, Error, Expression, FunctionParameters, Integrand, IntegrandResolver,
    NoFiles, SampledFunction, SharedFunction, Term, Tolerance,
};

/// A function of batches that counts its values; those beyond a limit are unavailable.
#[derive(Clone)]
struct Counted {
    of: fn(DVec3) -> f64,
    count: Arc<AtomicUsize>,
    max: usize,
}

impl Counted {
    fn new(of: fn(DVec3) -> f64) -> Self {
        Self { of, count: Arc::default(), max: usize::MAX }
    }

    fn count(&self) -> usize {
        self.count.load(Ordering::Relaxed)
    }
}

impl Integrand for Counted {
    /// Only batches are evaluated.
    fn eval(&self, _: DVec3) -> f64 {
        f64::NAN
    }

    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        let count = dirs.len() + self.count.fetch_add(dirs.len(), Ordering::Relaxed);
        if count > self.max {
            return Err(Error::Evaluation { reason: "too many values".to_owned() });
        }
        values.iter_mut().zip(dirs).for_each(|(value, dir)| *value = (self.of)(*dir));
        Ok(())
    }
}

fn clamped_cosine(dir: DVec3) -> f64 {
    dir.z.max(0.0)
}

fn wave(dir: DVec3) -> f64 {
    0.5 * (dir.z * dir.z * 3.0 - 1.0) * (5.0 / (4.0 * PI)).sqrt()
}

struct Functions(Vec<(&'static str, SharedFunction)>);

impl IntegrandResolver for Functions {
    fn function(&self, wanted: &FunctionParameters) -> Result<Box<dyn Integrand>, ResolveError> {
        let found = self.0.iter().find(|(name, _)| *name == wanted.name);
        let missing = || ResolveError::new(format!("no function {}", wanted.name));
        Ok(Box::new(found.ok_or_else(missing)?.1.clone()))
    }
}

fn functions() -> Functions {
    let deferred = |of| DeferredFunction::new(Counted::new(of), Tolerance::default()).unwrap();
    Functions(vec![
        ("wave", SharedFunction::new(deferred(wave))),
        ("given", SharedFunction::new(SampledFunction::new(Counted::new(wave), 2))),
        ("kink", SharedFunction::new(deferred(clamped_cosine))),
    ])
}

#[test]
fn the_term_is_read_and_displayed_but_not_listed() {
    for (text, shown) in [
        ("function:f", "function:f"),
        ("function:name=f", "function:f"),
        ("function:\"a,b + c\"", "function:\"a,b + c\""),
    ] {
        let term: Term = text.parse().unwrap();
        assert_eq!(term.to_string(), shown);
        assert_eq!(shown.parse(), Ok(term));
    }
    assert!(Term::all().iter().all(|term| term.name() != "function"));
    let error = |text: &str| text.parse::<Term>().unwrap_err().to_string();
    assert!(error("function").contains("name"), "{}", error("function"));
    assert!(error("function:f,degree=3").contains("degree"));
    assert!(!error("functoin:f").contains("values, function"), "{}", error("functoin:f"));
    let expression: Expression = "2 * function:f @ 30/0 - cosine".parse().unwrap();
    assert_eq!(expression.to_string(), "2 * function:f @ 30/0 - cosine");
    let error = expression.build(&NoFiles).map(drop).unwrap_err().to_string();
    assert!(error.contains("function:f: only programs"), "{error}");
}

/// Expressions with supplied functions have the integrals and energies of those with the built-in
/// ones, to rounding or to the stated error.
#[test]
fn expressions_with_supplied_functions_are_those_with_built_in_ones() {
    for (text, known) in [
        ("function:wave", "ylm:l=2"),
        ("function:given", "ylm:l=2"),
        ("2 * function:wave @ 30/40 - cosine", "2 * ylm:l=2 @ 30/40 - cosine"),
        ("function:wave * vmf:kappa=9 @ 50/0", "ylm:l=2 * vmf:kappa=9 @ 50/0"),
        ("function:wave * function:given", "ylm:l=2 * ylm:l=2"),
        (
            "filtered:fwhm=20,of=\"function:wave + cosine\"",
            "filtered:fwhm=20,of=\"ylm:l=2 + cosine\"",
        ),
        ("function:kink", "cosine"),
        ("function:kink @ 70/20", "cosine @ 70/20"),
        ("function:kink * ylm:l=2 @ 40/0", "cosine * ylm:l=2 @ 40/0"),
        ("0.5 * function:kink + function:wave @ 60/10", "0.5 * cosine + ylm:l=2 @ 60/10"),
    ] {
        let built = |text: &str| text.parse::<Expression>().unwrap().build(&functions()).unwrap();
        let (function, known) = (built(text), built(known));
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            let what = format!("{text}, {domain:?}");
            let energy = function.energy(domain, 40).unwrap_or_else(|e| panic!("{what}: {e}"));
            let expected = known.energy(domain, 40).unwrap();
            let (integral, error) = function.integral_estimate(domain).unwrap();
            let difference = (integral - known.exact(domain).unwrap()).abs();
            assert!(difference <= 3.0 * error + 1e-12, "{what}: {difference}, {error}");
            let total = expected.total();
            let difference = (energy.total() - total).abs();
            let error = energy.centred_stderr().sum();
            assert!(difference <= 3.0 * error + 1e-12 * total, "{what}: {difference}, {error}");
            assert!(error <= 1e-5 * total, "{what}: {error}");
        }
    }
}

#[test]
fn values_are_taken_when_energies_are_needed() {
    let counted = Counted::new(wave);
    let function = DeferredFunction::new(counted.clone(), Tolerance::default()).unwrap();
    function.eval_into(&[DVec3::Z; 3], &mut [0.0; 3]).unwrap();
    assert_eq!((counted.count(), function.feature_degree()), (3, Some(128)));
    function.energy(Domain::Hemisphere, 4).unwrap();
    let once = counted.count();
    assert!(once > 16_000, "{once}");
    assert_eq!(function.on(Domain::Hemisphere).unwrap().degree().map(|l| l >= 2), Some(true));
    assert_eq!(function.shape().unwrap().degree(), 2);
    assert!(counted.count() > once);
}

#[test]
fn functions_above_the_equator_are_not_evaluated_below() {
    let root = |dir: DVec3| dir.z.sqrt() * dir.z;
    let function = DeferredFunction::new(root, Tolerance::default()).unwrap();
    let shared = SharedFunction::new(function.clone());
    let error = shared.energy(Domain::Sphere, 4).unwrap_err();
    assert!(matches!(error, Error::Evaluation { .. }), "{error}");
    let above = SharedFunction::new(function.above_equator());
    let resolver = Functions(vec![("root", above)]);
    let product: Expression = "function:root * cosine".parse().unwrap();
    let product = product.build(&resolver).unwrap();
    let energy = product.energy(Domain::Hemisphere, 4).unwrap();
    // 2 int (z^(5/2))^2 over the hemisphere.
    let exact = 4.0 * PI / 6.0;
    assert!((energy.total() / exact - 1.0).abs() < 1e-6, "{}", energy.total());
}

/// The reason of an evaluation that fails arrives through quadratures of every kind.
#[test]
fn errors_of_evaluation_are_carried() {
    for max in [0, 20_000] {
        let function = Counted { max, ..Counted::new(clamped_cosine) };
        let sampled =
            || SampledFunction::new(Counted { count: Arc::default(), ..function.clone() }, 200);
        let deferred = DeferredFunction::new(function.clone(), Tolerance::default()).unwrap();
        let resolver = Functions(vec![
            ("a", SharedFunction::new(sampled())),
            ("b", SharedFunction::new(deferred)),
        ]);
        for text in [
            "function:a",
            "function:b",
            "2 * function:a @ 30/40 - cosine",
            "function:b * vmf:kappa=9 @ 50/0",
            "function:b + cap:degrees=30",
        ] {
            let built = text.parse::<Expression>().unwrap().build(&resolver).unwrap();
            for domain in [Domain::Sphere, Domain::Hemisphere] {
                let error = built.energy(domain, 300).unwrap_err();
                let is_carried = error.to_string().contains("too many values");
                assert!(is_carried, "{text}, {domain:?}: {error}");
                assert_eq!(built.exact(domain), None, "{text}");
            }
        }
    }
    let invalid = SampledFunction::new(|dir: DVec3| 1.0 / (dir.z - 1.0), 4);
    let error = invalid.eval_into(&[DVec3::X, DVec3::Z], &mut [0.0; 2]).unwrap_err().to_string();
    assert!(error.contains("x = 0, y = 0, z = 1") && error.contains("inf"), "{error}");
}
