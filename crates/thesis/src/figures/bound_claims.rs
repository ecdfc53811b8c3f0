use sphvar_bounds::{Bound, MeasuredSpectrum, Side, ThesisBound};
use sphvar_samplers::{Domain, Pattern};
use sphvar_spectrum::{Spectrum, exact_spectrum};

use super::patterns::ThesisPattern;
use crate::{Claim, Error, Figure, Quantity, Verdict};

/// The confidence of all degrees together at which a bound is refuted or proved.
const CONFIDENCE: f64 = 0.99;

/// Whether a mean spectrum is within the thesis's two profiles.
///
/// A bound is wrong if some degree refutes it, all degrees together; it holds if every degree's mean is within it. It
/// is undecided if a mean is beyond, but may be so by chance.
pub(crate) fn claim_bounds(
    pattern: ThesisPattern,
    bounds: &ThesisBound,
    sampled: &Spectrum,
    figure: &mut Figure,
) -> Result<(), Error> {
    // The upper bound of jitter is touched from below at high degrees: only the exact spectrum tells on which side.
    let exact = if pattern == ThesisPattern::Jittered {
        let (n, lmax) = (sampled.n_points(), sampled.lmax());
        Some(exact_spectrum(&Pattern::Jittered, n, Domain::Sphere, lmax, &|_| ())?)
    } else {
        None
    };
    let spectrum = exact.as_ref().unwrap_or(sampled);
    let n = spectrum.n_points();
    let measured = MeasuredSpectrum::from_spectrum(spectrum)?;
    for bound in [Bound::upper(bounds.upper), Bound::lower(bounds.lower)] {
        let got = bound.check(&measured, CONFIDENCE)?;
        let within = match bound.side {
            Side::Upper => got.extreme_ratio <= 1.0,
            Side::Lower => got.extreme_ratio >= 1.0,
        };
        let verdict = match (got.holds, within) {
            (false, _) => Verdict::Wrong,
            (true, true) => Verdict::Holds,
            (true, false) => Verdict::Undecided,
        };
        // The degree that refutes a bound, or else the one that is nearest to it.
        let l = if got.holds { got.extreme_degree } else { got.worst_degree };
        let profile = bound.profile.power(l, n);
        let found =
            Quantity::with_stderr(spectrum.power()[l] / profile, spectrum.stderr()[l] / profile);
        let (words, erratum) = stated(pattern, bound.side);
        let source = if spectrum.is_exact() {
            "exact spectrum".to_owned()
        } else {
            let proved = if got.proved { "proved" } else { "not proved" };
            let z = got.z;
            format!(
                "{proved} at 99 % for all degrees together; largest excess {z:.1} standard errors"
            )
        };
        let mut claim = Claim::words(
            format!("{}: {} bound of the spectrum", pattern.label(), bound.side),
            words,
            verdict,
        )
        .found(found)
        .because(format!("found: power over bound at l = {l}, N = {n}; {source}"));
        claim.erratum = erratum;
        figure.claims.push(claim);
    }
    Ok(())
}

/// What the thesis states, and the erratum about it.
fn stated(pattern: ThesisPattern, side: Side) -> (&'static str, Option<u8>) {
    match (pattern, side) {
        (ThesisPattern::PoissonDisk, Side::Upper) => ("below 1.8", None),
        (ThesisPattern::PoissonDisk, Side::Lower) => ("above 0.055", Some(30)),
        (ThesisPattern::Jittered, Side::Upper) => ("below min(1, (l/(0.2 sqrt N))^2)", None),
        (ThesisPattern::Jittered, Side::Lower) => {
            ("above 0.4 min(1, (l/(sqrt 0.6 sqrt N))^2)", None)
        }
        (ThesisPattern::Ccvt, Side::Upper) => {
            ("below 2 min(1, (l/(sqrt 0.05 sqrt N))^2)", Some(39))
        }
        (ThesisPattern::Ccvt, Side::Lower) => {
            ("above 0.05 min(1, (l/(sqrt 2.85 sqrt N))^2)", Some(39))
        }
        (_, Side::Upper) => ("below 1.3", None),
        (_, Side::Lower) => ("above 0.7", None),
    }
}
