use sphvar_samplers::{Purpose, Streams};
use sphvar_scene::DirectionMode;
use sphvar_variance::{RateFit, VariancePoint, fit_rate};

use super::Recipe;
use super::bounded_column::asymptotic;
use super::box_study::BoxStudy;
use super::crossover_claim::CrossoverClaim;
use super::disk_placement::with_dart_throwing;
use super::mass_points::{NOTE, with_both_kinds};
use super::patterns::ThesisPattern;
use super::variance_study::VarianceStudy;
use crate::{
    Axis, Claim, Curve, Curves, Error, Figure, Job, Mark, Quantity, Results, Setting, Stated,
    TestIntegrand, Verdict,
};

/// Figure 7.9: the variances of five samplers, of CCVT with both kinds of mass points, side by
/// side, of both test integrands and of a scene.
pub(crate) struct VarianceComparison;

const PATTERNS: [ThesisPattern; 6] = [
    ThesisPattern::WhiteNoise,
    ThesisPattern::PoissonDisk,
    ThesisPattern::Jittered,
    ThesisPattern::CcvtRandom,
    ThesisPattern::CcvtFibonacci,
    ThesisPattern::Healpix,
];
/// The tolerance of "the same rate" for a difference of exponents, in addition to its interval.
const SAME_RATE: f64 = 0.05;
/// Numbers of directions per hit point that are valid for all patterns, 6 nside^2; 294 is among
/// them.
const DIRECTIONS: [usize; 9] = [24, 54, 96, 150, 216, 294, 384, 600, 1014];

/// One panel: the integrand and the crossover stated in the thesis.
struct Panel {
    name: &'static str,
    title: &'static str,
    y: &'static str,
    crossover: f64,
    /// A tenth of that number, the reading precision of a curve.
    tolerance: f64,
    remark: &'static str,
    /// The erratum about that number.
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
        let reference = BoxStudy::measured(setting).reference();
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
            // The rate of Poisson disks is an asymptotic one; the scene has only its own numbers of
            // points.
            let late =
                integrand.map_or(panel.from, |_| asymptotic(ThesisPattern::PoissonDisk, setting));
            curves.claim_rates(panel, late, figure)?;
        }
        let reference = BoxStudy::measured(setting).reference_image(results)?.n_points;
        figure.note(format!(
            "c: halves of sphere sets, rotated at each hit point; {} renders each, against a reference of {reference} jittered \
             directions, whose error is contained in every value.",
            scene_renders(setting)
        ));
        figure.note(NOTE);
        figure.note(
            "N is 12 nside^2 on the sphere, 6 nside^2 for directions of a hit point (erratum 38).",
        );
        Ok(())
    }
}

fn scene_renders(setting: Setting) -> u64 {
    setting.scale.pick(4, 8)
}

fn renders(pattern: ThesisPattern, n_points: usize, setting: Setting) -> Job {
    let renders = scene_renders(setting);
    BoxStudy::measured(setting).renders(pattern, n_points, DirectionMode::Rotated, renders)
}

/// Returns the mean squared error of the scene over the number of directions.
fn scene_errors(
    pattern: ThesisPattern,
    setting: Setting,
    results: &Results,
) -> Result<Vec<VariancePoint>, Error> {
    let scene = BoxStudy::measured(setting);
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
        figure.claims.push(Claim { erratum: panel.erratum, ..with_dart_throwing(claim) });
    }

    /// Adds the claims about rates, which are fitted from the panel's number of points on, that of
    /// Poisson disk from `late`.
    fn claim_rates(&self, panel: &Panel, late: f64, figure: &mut Figure) -> Result<(), Error> {
        let fitted = format!("fitted from N = {} on", panel.from);
        for slower in [ThesisPattern::PoissonDisk, ThesisPattern::WhiteNoise] {
            let faster = |pattern: ThesisPattern| {
                let claim = Claim::number(
                    format!(
                        "exponent of {} less that of {}, {}",
                        pattern.subject(),
                        slower.label(),
                        panel.title
                    ),
                    Stated::AtMost(0.0),
                    self.difference([pattern, slower], panel.from),
                )
                .because(&fitted);
                match slower {
                    ThesisPattern::PoissonDisk => with_dart_throwing(claim),
                    _ => claim,
                }
            };
            figure.claims.extend([
                with_both_kinds(Some(40), |kind| Ok(faster(kind)))?,
                faster(ThesisPattern::Healpix),
                faster(ThesisPattern::Jittered),
            ]);
        }
        figure.claims.push(with_dart_throwing(self.disks_like_white_noise(panel, late)));
        let same_rate = |kind: ThesisPattern| {
            Claim::number(
                format!("exponent of jittered less that of {}, {}", kind.subject(), panel.title),
                Stated::About { value: 0.0, tolerance: SAME_RATE },
                self.difference([ThesisPattern::Jittered, kind], panel.from),
            )
            .because(format!("jitter is said to be as good as CCVT in its rate; {fitted}"))
        };
        figure.claims.push(with_both_kinds(Some(40), |kind| Ok(same_rate(kind)))?);
        figure.claims.push(with_both_kinds(Some(40), |kind| self.higher_variance(panel, kind))?);
        Ok(())
    }

    fn rate(&self, pattern: ThesisPattern, from: f64) -> Option<RateFit> {
        let tail: Vec<VariancePoint> =
            self.of(pattern).iter().copied().filter(|p| p.n_points >= from).collect();
        fit_rate(&tail)
    }

    /// Returns the difference of the exponents of two patterns from a number of points on.
    fn difference(&self, patterns: [ThesisPattern; 2], from: f64) -> Quantity {
        let [a, b] = patterns.map(|pattern| self.rate(pattern, from));
        difference(a.as_ref(), b.as_ref())
    }

    /// "The convergence rate of Poisson Disk sampling patterns is no better than white noise."
    fn disks_like_white_noise(&self, panel: &Panel, late: f64) -> Claim {
        let [disk, white] = [ThesisPattern::PoissonDisk, ThesisPattern::WhiteNoise];
        let claim = Claim::number(
            format!("exponent of Poisson disk less that of white noise, {}", panel.title),
            Stated::About { value: 0.0, tolerance: SAME_RATE },
            self.difference([disk, white], late),
        );
        let said = format!(
            "its rate is said to be no better than that of white noise; fitted from N = {late} on"
        );
        // A curve that is still curved does not contradict an asymptotic rate.
        let bends = self.rate(disk, late).is_some_and(|fit| fit.is_pre_asymptotic());
        if bends && claim.verdict == Verdict::Wrong {
            Claim { verdict: Verdict::Undecided, ..claim }.because(format!(
                "{said}, where the curve of Poisson disk still bends significantly: undecided, though the exponents differ"
            ))
        } else {
            claim.because(said)
        }
    }

    /// "Though the variance is higher": that of jittered over that of a kind of CCVT at the largest
    /// number of points that both have.
    fn higher_variance(&self, panel: &Panel, kind: ThesisPattern) -> Result<Claim, Error> {
        let [jittered, ccvt] = [ThesisPattern::Jittered, kind].map(|pattern| self.of(pattern));
        let pairs = jittered.iter().rev().find_map(|j| {
            let same = |c: &&VariancePoint| c.n_points.to_bits() == j.n_points.to_bits();
            ccvt.iter().find(same).map(|c| (j, c))
        });
        let missing =
            || Error::Missing { key: "a number of points of jittered and CCVT".to_owned() };
        let (jittered, ccvt) = pairs.ok_or_else(missing)?;
        let ratio = jittered.variance / ccvt.variance;
        let relative = (jittered.stderr / jittered.variance).hypot(ccvt.stderr / ccvt.variance);
        Ok(Claim::number(
            format!("variance of jittered over that of {}, {}", kind.subject(), panel.title),
            Stated::AtLeast(1.0),
            Quantity::with_stderr(ratio, ratio * relative),
        )
        .because(format!("its variance is said to be the higher one; N = {}", ccvt.n_points)))
    }
}

/// Returns the difference of two exponents, with the interval of independent errors.
fn difference(a: Option<&RateFit>, b: Option<&RateFit>) -> Quantity {
    let (Some(a), Some(b)) = (a, b) else {
        return Quantity::single(f64::NAN);
    };
    let half = |fit: &RateFit| 0.5 * (fit.interval.1 - fit.interval.0);
    let value = a.slope - b.slope;
    let half = half(a).hypot(half(b));
    Quantity { value, interval: (value - half, value + half) }
}
