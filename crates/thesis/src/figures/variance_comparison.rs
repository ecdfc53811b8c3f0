use sphvar_samplers::{Purpose, Streams};
use sphvar_scene::DirectionMode;
use sphvar_variance::{RateFit, VariancePoint, fit_rate};

use super::Recipe;
use super::bounded_column::asymptotic;
use super::crossover_claim::CrossoverClaim;
use super::occlusion::Occlusion;
use super::patterns::ThesisPattern;
use super::variance_study::VarianceStudy;
use crate::{
    Axis, Claim, Curve, Curves, Error, Figure, Job, Mark, Quantity, Results, Setting, Stated,
    TestIntegrand, Verdict,
};

/// Figure 7.9: the variances of five samplers side by side, of both test integrands and of a scene.
pub(crate) struct VarianceComparison;

const PATTERNS: [ThesisPattern; 5] = [
    ThesisPattern::WhiteNoise,
    ThesisPattern::PoissonDisk,
    ThesisPattern::Jittered,
    ThesisPattern::Ccvt,
    ThesisPattern::Healpix,
];
/// Those of which the thesis says that they fall faster than Poisson disk and white noise.
const FASTER: [ThesisPattern; 3] =
    [ThesisPattern::Ccvt, ThesisPattern::Healpix, ThesisPattern::Jittered];
/// What "the same rate" allows a difference of exponents beyond its interval.
const SAME_RATE: f64 = 0.05;
/// Directions of a hit point that all patterns can have, 6 nside^2; 294 is among them.
const DIRECTIONS: [usize; 9] = [24, 54, 96, 150, 216, 294, 384, 600, 1014];

/// One panel: what is integrated, and how the thesis's crossover is to be read there.
struct Panel {
    name: &'static str,
    title: &'static str,
    y: &'static str,
    crossover: f64,
    /// A tenth of that number: what can be read off a curve.
    tolerance: f64,
    remark: &'static str,
    /// The erratum about that number, for data that contradict it.
    erratum: Option<u8>,
    /// Rates are compared from this number of points on.
    from: f64,
}

const ON_SPHERE: &str = "\"just after 300\", for no integrand in particular; read to a tenth";
const PANELS: [Panel; 3] = [
    Panel {
        name: "a",
        title: "harmonic Y(4,0)",
        y: "variance of the integral",
        crossover: 300.0,
        tolerance: 30.0,
        remark: ON_SPHERE,
        erratum: Some(44),
        from: 192.0,
    },
    Panel {
        name: "b",
        title: "cap of 60 degrees",
        y: "variance of the integral",
        crossover: 300.0,
        tolerance: 30.0,
        remark: ON_SPHERE,
        erratum: Some(44),
        from: 192.0,
    },
    Panel {
        name: "c",
        title: "ambient occlusion in the Cornell box",
        y: "mean squared error",
        crossover: 294.0,
        tolerance: 29.0,
        remark: "read to a tenth",
        erratum: None,
        from: 96.0,
    },
];

impl Recipe for VarianceComparison {
    fn title(&self) -> &'static str {
        "Variances of five samplers side by side"
    }

    fn jobs(&self, setting: Setting) -> Vec<Job> {
        let trials =
            PATTERNS.into_iter().flat_map(|p| VarianceStudy { pattern: p, setting }.trials());
        let reference = Occlusion::measured(setting).reference();
        let renders = PATTERNS.into_iter().flat_map(|p| DIRECTIONS.map(|n| renders(p, n, setting)));
        trials.chain([reference]).chain(renders).collect()
    }

    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error> {
        for (number, panel) in PANELS.iter().enumerate() {
            let integrand = TestIntegrand::ALL.get(number).copied();
            let curve = |pattern| match integrand {
                Some(integrand) => VarianceStudy { pattern, setting }.measured(results, integrand),
                None => scene_errors(pattern, setting, results),
            };
            let curves: Result<Vec<_>, Error> =
                PATTERNS.into_iter().map(|p| Ok((p, curve(p)?))).collect();
            let curves = VarianceCurves(curves?);
            figure.panel(panel.name, panel.title, curves.drawn(panel));
            curves.claim_crossover(panel, setting.seed, number, figure);
            // The rate of Poisson disks is an asymptotic one; the scene has no more points than it has.
            let late =
                integrand.map_or(panel.from, |_| asymptotic(ThesisPattern::PoissonDisk, setting));
            curves.claim_rates(panel, late, figure);
        }
        let reference = Occlusion::measured(setting).reference_image(results)?.n_points;
        figure.note(format!(
            "c: halves of sphere sets turned at each hit point; {} renders each, against a reference of {reference} jittered \
             directions whose own error is in every value.",
            scene_renders(setting)
        ));
        figure.note(
            "CCVT has capacity 64 and random mass points (erratum 39). N is 12 nside^2 on the sphere, 6 nside^2 for \
             directions of a hit point (erratum 38).",
        );
        Ok(())
    }
}

fn scene_renders(setting: Setting) -> u64 {
    setting.scale.pick(4, 8)
}

fn renders(pattern: ThesisPattern, n_points: usize, setting: Setting) -> Job {
    let renders = scene_renders(setting);
    Occlusion::measured(setting).renders(pattern, n_points, DirectionMode::Rotated, renders)
}

/// The mean squared error of the scene over the number of directions.
fn scene_errors(
    pattern: ThesisPattern,
    setting: Setting,
    results: &Results,
) -> Result<Vec<VariancePoint>, Error> {
    let scene = Occlusion::measured(setting);
    let point = |&n: &usize| {
        let mse = scene.errors(results, &renders(pattern, n, setting))?.mse;
        Ok(VariancePoint { n_points: n as f64, variance: mse.value, stderr: mse.stderr })
    };
    DIRECTIONS.iter().map(point).collect()
}

/// The variances of every pattern for one integrand.
struct VarianceCurves(Vec<(ThesisPattern, Vec<VariancePoint>)>);

impl VarianceCurves {
    fn of(&self, pattern: ThesisPattern) -> &[VariancePoint] {
        self.0.iter().find(|c| c.0 == pattern).map_or(&[], |c| &c.1)
    }

    fn drawn(&self, panel: &Panel) -> Curves {
        let curve = |(pattern, points): &(ThesisPattern, Vec<VariancePoint>)| {
            let points = points.iter().map(|p| [p.n_points, p.variance, p.stderr]);
            Curve::new(pattern.label(), pattern.colour(), Mark::Line, points)
        };
        Curves {
            x: Axis::log("number of points N"),
            y: Axis::log(panel.y),
            curves: self.0.iter().map(curve).collect(),
        }
    }

    fn claim_crossover(&self, panel: &Panel, seed: u64, number: usize, figure: &mut Figure) {
        let (jittered, disk) =
            (self.of(ThesisPattern::Jittered), self.of(ThesisPattern::PoissonDisk));
        let streams = Streams::new(seed, Purpose::Resample, number);
        let claim = CrossoverClaim {
            what: format!("crossover of jittered and Poisson disk, {}", panel.title),
            value: panel.crossover,
            tolerance: panel.tolerance,
            remark: panel.remark,
        }
        .judge(jittered, disk, streams);
        figure.claims.push(match panel.erratum {
            Some(number) if claim.verdict == Verdict::Wrong => claim.erratum(number),
            _ => claim,
        });
    }

    fn claim_rates(&self, panel: &Panel, late: f64, figure: &mut Figure) {
        let rate_from = |pattern, from: f64| {
            let tail: Vec<VariancePoint> =
                self.of(pattern).iter().copied().filter(|p| p.n_points >= from).collect();
            fit_rate(&tail)
        };
        let rate = |pattern| rate_from(pattern, panel.from);
        let [disk, white] = [ThesisPattern::PoissonDisk, ThesisPattern::WhiteNoise];
        for (pattern, slower) in
            FASTER.into_iter().flat_map(|faster| [(faster, disk), (faster, white)])
        {
            let claim = Claim::number(
                format!(
                    "exponent of {} less that of {}, {}",
                    pattern.label(),
                    slower.label(),
                    panel.title
                ),
                Stated::AtMost(0.0),
                difference(rate(pattern).as_ref(), rate(slower).as_ref()),
            );
            let fitted = format!("fitted from N = {} on", panel.from);
            // Mass points of a fixed capacity are an offset, too.
            figure.claims.push(match pattern {
                ThesisPattern::Ccvt => claim.erratum(40).because(format!(
                    "{fitted}; with random mass points of a fixed capacity both end in N^-1"
                )),
                _ => claim.because(fitted),
            });
        }
        let (of_disk, of_white) = (rate_from(disk, late), rate_from(white, late));
        let claim = Claim::number(
            format!("exponent of Poisson disk less that of white noise, {}", panel.title),
            Stated::About { value: 0.0, tolerance: SAME_RATE },
            difference(of_disk.as_ref(), of_white.as_ref()),
        );
        let said = format!(
            "its rate is said to be no better than that of white noise; fitted from N = {late} on"
        );
        // Of an asymptotic rate, a curve that bends still says nothing against.
        let bends = of_disk.is_some_and(|fit| fit.is_pre_asymptotic());
        figure.claims.push(if bends && claim.verdict == Verdict::Wrong {
            Claim { verdict: Verdict::Undecided, ..claim }.because(format!(
                "{said}, where the curve of Poisson disk still bends significantly: undecided, though the exponents differ"
            ))
        } else {
            claim.because(said)
        });
        figure.claims.push(
            Claim::number(
                format!("exponent of jittered less that of CCVT, {}", panel.title),
                Stated::About { value: 0.0, tolerance: SAME_RATE },
                difference(
                    rate(ThesisPattern::Jittered).as_ref(),
                    rate(ThesisPattern::Ccvt).as_ref(),
                ),
            )
            .erratum(40)
            .because("jitter is said to be as good as CCVT in its rate"),
        );
        let [jittered, ccvt] = [ThesisPattern::Jittered, ThesisPattern::Ccvt].map(|p| self.of(p));
        let pairs = jittered.iter().rev().find_map(|j| {
            let same = |c: &&VariancePoint| c.n_points.to_bits() == j.n_points.to_bits();
            ccvt.iter().find(same).map(|c| (j, c))
        });
        let Some((jittered, ccvt)) = pairs else { return };
        let ratio = jittered.variance / ccvt.variance;
        let relative = (jittered.stderr / jittered.variance).hypot(ccvt.stderr / ccvt.variance);
        figure.claims.push(
            Claim::number(
                format!("variance of jittered over that of CCVT, {}", panel.title),
                Stated::AtLeast(1.0),
                Quantity::with_stderr(ratio, ratio * relative),
            )
            .erratum(40)
            .because(format!(
                "its variance is said to be the higher one; N = {}; mass points of capacity 64 leave CCVT a floor, which \
                 jitter is below at degree 4 from some 1400 points on",
                ccvt.n_points
            )),
        );
    }
}

/// The difference of two exponents, with the interval of independent errors.
fn difference(a: Option<&RateFit>, b: Option<&RateFit>) -> Quantity {
    let (Some(a), Some(b)) = (a, b) else {
        return Quantity::single(f64::NAN);
    };
    let half = |fit: &RateFit| 0.5 * (fit.interval.1 - fit.interval.0);
    let value = a.slope - b.slope;
    let half = half(a).hypot(half(b));
    Quantity { value, interval: (value - half, value + half) }
}
