use sphvar_bounds::{Bound, MeasuredSpectrum, Side, ThesisBound};
use sphvar_spectrum::Spectrum;

use super::patterns::ThesisPattern;
use super::spectra::{exact_jitter, mean_power};
use crate::{Claim, Error, Figure, Quantity, Stated, Verdict};

/// The confidence of all degrees together at which a bound is refuted or proved.
const CONFIDENCE: f64 = 0.99;

/// What counts as low degrees of CCVT, and as no power there.
const LOW: f64 = 0.25;
const NO_POWER: f64 = 1e-3;

/// Whether a mean spectrum is within the thesis's two profiles.
///
/// A bound is wrong if some degree refutes it, all degrees together; it holds if every degree's mean is within it, whether
/// or not that is proved. It is undecided if a mean is beyond, but may be so by chance.
///
/// [`Claim::number`] is not used here: by its rule a bound would be undecided wherever it touches the spectrum, as most of
/// the thesis's do, and one interval says nothing of all degrees together.
pub(crate) fn claim_bounds(
    pattern: ThesisPattern,
    bounds: &ThesisBound,
    sampled: &Spectrum,
    figure: &mut Figure,
) -> Result<(), Error> {
    // The upper bound of jitter is touched from below at high degrees: only the exact spectrum tells on which side.
    let exact = if pattern == ThesisPattern::Jittered {
        let (n, lmax) = (sampled.n_points(), sampled.lmax());
        Some(exact_jitter(n, lmax)?)
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
                "a bound holds if every mean is within it; {proved} at 99 % for all degrees together; largest excess {z:.1} \
                 standard errors"
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

/// "A low-frequency region with no energy", which sections 6.2.2 and 7.4 see in CCVT.
pub(crate) fn no_power(spectrum: &Spectrum) -> Claim {
    let root = (spectrum.n_points() as f64).sqrt();
    let (power, stderr) = mean_power(spectrum, |l| l > 0 && l as f64 <= LOW * root);
    Claim::number(
        format!("CCVT: mean power for omega below {LOW}"),
        Stated::AtMost(NO_POWER),
        Quantity::with_stderr(power, stderr),
    )
    .erratum(40)
    .because(format!(
        "\"no energy\" is read as a thousandth of white noise; capacity 64 with random mass points leaves 1/64 = {:.4}; \
         the thesis states no capacity (erratum 39)",
        1.0 / 64.0
    ))
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

#[cfg(test)]
mod tests {
    use sphvar_bounds::thesis_bounds;
    use sphvar_samplers::Domain;
    use sphvar_spectrum::Spectrum;

    use super::{claim_bounds, no_power};
    use crate::figures::patterns::ThesisPattern;
    use crate::{Claim, Figure, FigureId, Verdict};

    fn claims(fill: impl Fn(&mut Figure)) -> Vec<Claim> {
        let id: FigureId = "7.4".parse().unwrap();
        let mut figure = Figure { id, panels: Vec::new(), claims: Vec::new(), notes: Vec::new() };
        fill(&mut figure);
        figure.claims
    }

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
            let got = claims(|figure| {
                let bounds = thesis_bounds()[0];
                claim_bounds(ThesisPattern::WhiteNoise, &bounds, &flat(power), figure).unwrap();
            });
            assert_eq!([got[0].verdict, got[1].verdict], expected, "{power}: {got:?}");
            let ratio = got[0].found.unwrap().value;
            assert!((ratio - power / 1.3).abs() < 4.0 * f64::EPSILON, "{power}: {ratio}");
        }
    }

    #[test]
    fn power_at_low_degrees_is_seen() {
        for (power, expected) in [(1e-4, Verdict::Holds), (1.0 / 64.0, Verdict::Wrong)] {
            let got = no_power(&flat(power));
            assert_eq!(got.verdict, expected, "{got:?}");
            let mean = got.found.unwrap().value;
            assert!((mean / power - 1.0).abs() < 16.0 * f64::EPSILON, "{power}: {mean}");
        }
    }
}
