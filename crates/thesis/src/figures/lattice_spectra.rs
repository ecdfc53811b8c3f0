use sphvar_spectrum::Spectrum;

use super::Recipe;
use super::bound_claims::no_power;
use super::patterns::ThesisPattern;
use super::point_panel::sphere_points;
use super::spectra::{mean_spectrum, omega_axis, spectrum_curve};
use crate::{
    Axis, Claim, Curve, Curves, Error, Figure, Job, Mark, Quantity, Results, Setting, Stated,
    ThesisEnsemble, Verdict,
};

/// Figure 4.10: HEALPix centres and the Fibonacci lattice with their spectra.
pub(crate) struct LatticeSpectra;

const LATTICES: [ThesisPattern; 2] = [ThesisPattern::Healpix, ThesisPattern::Fibonacci];
/// The number of points of the pictures.
const N_SHOWN: usize = 1024;
/// The power that is indistinguishable from 0 in a plot whose axis reaches the peaks.
const VISIBLE: f64 = 0.01;
/// The largest power of any random pattern of the thesis is its bound of CCVT, 2: a peak is higher.
const PEAK: f64 = 2.0;

impl Recipe for LatticeSpectra {
    fn title(&self) -> &'static str {
        "HEALPix centres and the Fibonacci lattice, and their mean spectra"
    }

    fn jobs(&self, setting: Setting) -> Vec<Job> {
        LATTICES.iter().map(|&lattice| mean_spectrum(lattice, setting)).collect()
    }

    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error> {
        let mut low = Vec::new();
        for lattice in LATTICES {
            let spectrum = results.spectrum(&mean_spectrum(lattice, setting))?;
            let n = spectrum.n_points();
            let shown = ThesisEnsemble::sphere(lattice.pattern(), N_SHOWN).unrotated();
            figure.panel(
                &format!("{}-points", lattice.name()),
                format!("{}, N = {}", lattice.label(), shown.n_points),
                sphere_points(shown.set(setting.seed, 0)?),
            );
            let curve = spectrum_curve(lattice.label(), lattice.colour(), spectrum);
            low.push(low_degrees(&curve));
            figure.panel(
                &format!("{}-spectrum", lattice.name()),
                format!("{}, N = {n}", lattice.label()),
                Curves {
                    x: omega_axis(),
                    y: Axis::linear("mean angular power P"),
                    curves: vec![curve],
                },
            );
            claims(lattice, spectrum, figure);
        }
        figure.panel(
            "low-degrees",
            "Where the power seems to be zero",
            Curves { x: omega_axis(), y: Axis::log("mean angular power P"), curves: low },
        );
        figure.note(
            "The thesis states no number of points here; HEALPix has 12 nside^2. One set is the whole ensemble, because \
             rotations keep the power of a degree: there are no errors of sampling.",
        );
        Ok(())
    }
}

/// Returns the degrees below sqrt(N) that do not vanish.
fn low_degrees(curve: &Curve) -> Curve {
    /// Far above the rounding of odd degrees, about 1e-28, and below any nonzero power.
    const NOTHING: f64 = 1e-20;
    let points = curve.points.iter().copied().filter(|p| p[0] < 1.0 && p[1] > NOTHING);
    Curve::new(curve.label.clone(), curve.colour, Mark::Markers, points)
}

fn claims(lattice: ThesisPattern, spectrum: &Spectrum, figure: &mut Figure) {
    let name = lattice.label();
    let n = spectrum.n_points() as f64;
    let rows: Vec<(f64, f64)> =
        spectrum.rows().filter(|r| r.0 > 0).map(|(l, p, _)| (l as f64 / n.sqrt(), p)).collect();
    let highest = |from: f64, to: f64| {
        let inside = rows.iter().copied().filter(|r| from <= r.0 && r.0 < to);
        inside.fold((0.0, 0.0), |a, b| if b.1 > a.1 { b } else { a })
    };
    let (at, low) = highest(0.0, 1.0);
    figure.claims.push(
        Claim::number(
            format!("{name}: largest power for omega < 1"),
            Stated::About { value: 0.0, tolerance: VISIBLE },
            Quantity::exact(low),
        )
        .because(format!(
            "4.2.1 describes the plot: \"a zero-value low-frequency region\"; the largest is at omega = {at:.3}"
        )),
    );
    if lattice == ThesisPattern::Healpix {
        figure.claims.push(no_power(lattice, spectrum));
        figure.claims.push(
            Claim::number(
                format!("{name}: N P(2), 0 for a step profile"),
                Stated::About { value: 0.0, tolerance: f64::EPSILON * n },
                Quantity::exact(n * spectrum.power()[2]),
            )
            .erratum_if(Verdict::Wrong, 12)
            .because(
                "6.2.2: \"a low-frequency region with no energy\", read as exactly none, as a step profile has it; odd degrees \
                 vanish, even ones fall as 1/N",
            ),
        );
    }
    let (at, peak) = highest(1.0, f64::INFINITY);
    let verdict = if peak > PEAK { Verdict::Holds } else { Verdict::Wrong };
    figure.claims.push(
        Claim::words(format!("{name}: the region is followed by"), "high energy peaks", verdict)
            .measured(Quantity::exact(peak))
            .because(format!(
                "the highest lies at omega = {at:.3}; random patterns of the thesis stay below {PEAK}"
            )),
    );
    let (at, late) = highest(3.0, 4.0);
    let weighted: f64 =
        (1..=spectrum.lmax()).map(|l| (2 * l + 1) as f64 * spectrum.power()[l]).sum();
    let mean = weighted / (spectrum.lmax() * (spectrum.lmax() + 2)) as f64;
    figure.claims.push(
        Claim::number(
            format!("{name}: limit of the power, the largest for omega from 3 to 4"),
            Stated::About { value: 1.0, tolerance: 0.1 },
            Quantity::exact(late),
        )
        .erratum_if(Verdict::Wrong, 9)
        .because(format!(
            "peaks persist (this one at omega = {at:.3}); the mean over all degrees to {}, weighted by 2l+1, is {mean:.3}",
            spectrum.lmax()
        )),
    );
}
