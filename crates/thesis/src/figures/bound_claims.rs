use sphvar_bounds::{Bound, MeasuredSpectrum, Side, ThesisBound};
use sphvar_spectrum::Spectrum;

use super::patterns::ThesisPattern;
use super::spectra::{exact_jitter, mean_power};
use crate::{Claim, Error, Quantity, Stated, Verdict};

/// The confidence of all degrees together at which a bound is refuted or proved.
const CONFIDENCE: f64 = 0.99;

/// The low degrees of CCVT, and the threshold for no power there.
const LOW: f64 = 0.25;
const NO_POWER: f64 = 1e-3;

/// Returns claims that a mean spectrum is below the upper and above the lower of the thesis's
/// profiles.
///
/// A bound is wrong if some degree refutes it, all degrees together; it holds if every degree's
/// mean is within it, whether or not that is proved. It is undecided if a mean violates it, but
/// possibly by chance.
///
/// [`Claim::number`] is not used here: by its rule a bound would be undecided wherever it touches
/// the spectrum, as most of the thesis's do, and a single interval does not apply to all degrees
/// together.
pub(crate) fn within_bounds(
    pattern: ThesisPattern,
    bounds: &ThesisBound,
    sampled: &Spectrum,
) -> Result<[Claim; 2], Error> {
    // The upper bound of jitter is touched from below at high degrees: only the exact spectrum
    // tells on which side.
    let exact = if pattern == ThesisPattern::Jittered {
        let (n, lmax) = (sampled.n_points(), sampled.lmax());
        Some(exact_jitter(n, lmax)?)
    } else {
        None
    };
    let spectrum = exact.as_ref().unwrap_or(sampled);
    let n = spectrum.n_points();
    let measured = MeasuredSpectrum::from_spectrum(spectrum)?;
    let claim = |bound: Bound| -> Result<Claim, Error> {
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
        // The degree that contradicts a bound, or else the one that is nearest to it.
        let l = if got.holds { got.extreme_degree } else { got.worst_degree };
        let profile = bound.profile.power(l, n);
        let ratio =
            Quantity::with_stderr(spectrum.power()[l] / profile, spectrum.stderr()[l] / profile);
        let source = if spectrum.is_exact() {
            "exact spectrum".to_owned()
        } else {
            let side = if got.z > 0.0 { "beyond the bound by" } else { "within the bound by" };
            format!(
                "every mean is compared; the extreme one is {side} {:.1} standard errors",
                got.z.abs()
            )
        };
        Ok(Claim::words(
            format!("{}: {} bound of the spectrum", pattern.subject(), bound.side),
            stated(pattern, bound.side),
            verdict,
        )
        .measured(ratio)
        .because(format!("power over bound at l = {l}, N = {n}; {source}")))
    };
    Ok([claim(Bound::upper(bounds.upper))?, claim(Bound::lower(bounds.lower))?])
}

/// "A low-frequency region with no energy", which section 6.2.2 sees in HEALPix and CCVT, read as a
/// thousandth of white noise.
pub(crate) fn no_power(pattern: ThesisPattern, spectrum: &Spectrum) -> Claim {
    let root = (spectrum.n_points() as f64).sqrt();
    let (power, stderr) = mean_power(spectrum, |l| l > 0 && l as f64 <= LOW * root);
    Claim::number(
        format!("{}: mean power for omega below {LOW}", pattern.subject()),
        Stated::AtMost(NO_POWER),
        Quantity::with_stderr(power, stderr),
    )
    .because("6.2.2: \"a low-frequency region with no energy\", read as at most a thousandth of white noise")
}

/// Returns the statement of the thesis.
fn stated(pattern: ThesisPattern, side: Side) -> &'static str {
    match (pattern, side) {
        (ThesisPattern::PoissonDisk, Side::Upper) => "below 1.8",
        (ThesisPattern::PoissonDisk, Side::Lower) => "above 0.055",
        (ThesisPattern::Jittered, Side::Upper) => "below min(1, (l/(0.2 sqrt N))^2)",
        (ThesisPattern::Jittered, Side::Lower) => "above 0.4 min(1, (l/(sqrt 0.6 sqrt N))^2)",
        (ThesisPattern::CcvtRandom | ThesisPattern::CcvtFibonacci, Side::Upper) => {
            "below 2 min(1, (l/(sqrt 0.05 sqrt N))^2)"
        }
        (ThesisPattern::CcvtRandom | ThesisPattern::CcvtFibonacci, Side::Lower) => {
            "above 0.05 min(1, (l/(sqrt 2.85 sqrt N))^2)"
        }
        (_, Side::Upper) => "below 1.3",
        (_, Side::Lower) => "above 0.7",
    }
}

#[cfg(test)]
mod tests {
    use sphvar_bounds::thesis_bounds;
    use sphvar_samplers::Domain;
    use sphvar_spectrum::Spectrum;

    use super::{no_power, within_bounds};
    use crate::Verdict;
    use crate::figures::patterns::ThesisPattern;

    fn flat(power: f64) -> Spectrum {
        Spectrum::exact(Domain::Sphere, 1024, vec![power; 65])
    }

    #[test]
    fn bounds_hold_or_are_wrong() {
        for (power, expected) in [
            (1.0, [Verdict::Holds, Verdict::Holds]),
            (1.4, [Verdict::Wrong, Verdict::Holds]),
            (0.6, [Verdict::Holds, Verdict::Wrong]),
        ] {
            let bounds = thesis_bounds()[0];
            let got = within_bounds(ThesisPattern::WhiteNoise, &bounds, &flat(power)).unwrap();
            assert_eq!([got[0].verdict, got[1].verdict], expected, "{power}: {got:?}");
            let ratio = got[0].measured.unwrap().value;
            assert!((ratio - power / 1.3).abs() < 4.0 * f64::EPSILON, "{power}: {ratio}");
        }
    }

    #[test]
    fn power_at_low_degrees_is_detected() {
        for (power, expected) in [(1e-4, Verdict::Holds), (1.0 / 64.0, Verdict::Wrong)] {
            let got = no_power(ThesisPattern::CcvtRandom, &flat(power));
            assert_eq!(got.verdict, expected, "{got:?}");
            let mean = got.measured.unwrap().value;
            assert!((mean / power - 1.0).abs() < 16.0 * f64::EPSILON, "{power}: {mean}");
        }
    }
}
