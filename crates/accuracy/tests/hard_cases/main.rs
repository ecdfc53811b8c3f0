//! A test for each hard case, with the same name.

use sphvar_accuracy::{Area, HardCase, hard_cases};

/// Defines a test for each name, and the list of names. Attributes of a name are those of its test.
macro_rules! hard_cases {
    ($($(#[$attribute:meta])* $name:ident),* $(,)?) => {
        pub(crate) const NAMES: &[&str] = &[$(stringify!($name)),*];
        $(
            #[test]
            $(#[$attribute])*
            fn $name() {
                crate::assert_held(stringify!($name));
            }
        )*
    };
}

mod fits;
mod harmonics;
mod indexing;
mod predictions;
mod quality;
mod spectra;
mod square;
mod transforms;
mod warps;
mod weights;

fn all() -> impl Iterator<Item = HardCase> {
    Area::ALL.into_iter().flat_map(hard_cases)
}

/// Measures a hard case and compares it with its bound.
fn assert_held(name: &str) {
    let case = all().find(|case| case.name == name);
    let case = case.unwrap_or_else(|| panic!("unknown hard case {name}"));
    let errors = (case.measure)();
    assert!(errors.count() > 0, "{name}: nothing was compared");
    let (max, bound, worst) = (errors.max(), case.bound, errors.worst());
    assert!(max <= bound, "{name}: error {max:e} above the bound {bound:e} at {worst}");
}

#[test]
fn every_hard_case_has_a_test() {
    let areas = [
        harmonics::NAMES,
        indexing::NAMES,
        transforms::NAMES,
        spectra::NAMES,
        predictions::NAMES,
        quality::NAMES,
        weights::NAMES,
        fits::NAMES,
        square::NAMES,
        warps::NAMES,
    ];
    let mut tested = areas.concat();
    let mut listed: Vec<_> = all().map(|case| case.name).collect();
    tested.sort_unstable();
    listed.sort_unstable();
    assert_eq!(tested, listed);
}
