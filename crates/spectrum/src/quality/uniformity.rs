use std::f64::consts::{LN_2, PI};

use num_complex::Complex;
use sphvar_samplers::PointSet;
use sphvar_sh::Domain;

use super::Unavailable;

/// The statistic of a test of uniformity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UniformityStatistic {
    /// The L2 cap discrepancy: `N D^2 = sum_l P(l)/((2l-1)(2l+3))`.
    CapDiscrepancy,
    /// The generalised discrepancy of Cui and Freeden 1997: `N D^2 = sum_l P(l)/(4 pi l(l+1))`.
    GeneralizedDiscrepancy,
}

impl UniformityStatistic {
    /// Returns the factor of P(l) in N D^2.
    fn factor(self, l: usize) -> f64 {
        let l = l as f64;
        match self {
            Self::CapDiscrepancy => 1.0 / ((2.0 * l - 1.0) * (2.0 * l + 3.0)),
            Self::GeneralizedDiscrepancy => 1.0 / (4.0 * PI * l * (l + 1.0)),
        }
    }

    /// Returns the sum of all factors, the mean of N D^2.
    pub(super) fn mean(self, domain: Domain) -> f64 {
        match (self, domain) {
            (Self::CapDiscrepancy, Domain::Sphere) => 1.0 / 3.0,
            (Self::CapDiscrepancy, Domain::Hemisphere) => 1.0 / 12.0,
            (Self::GeneralizedDiscrepancy, Domain::Sphere) => 1.0 / (4.0 * PI),
            (Self::GeneralizedDiscrepancy, Domain::Hemisphere) => (1.0 - LN_2) / (4.0 * PI),
        }
    }
}

/// The discrepancy of one realization.
#[derive(Clone, Copy, Debug)]
pub struct ObservedDiscrepancy {
    n_effective: f64,
    /// `sum w^4/(sum w^2)^2`, 1/N for equal weights.
    fourth: f64,
    discrepancy: f64,
}

impl ObservedDiscrepancy {
    /// Returns the discrepancy of a set.
    #[must_use]
    pub fn new(set: &PointSet, discrepancy: f64) -> Self {
        let mut scaled: PointSet = PointSet { points: Vec::new(), weights: set.weights.clone() };
        scaled.normalize_weights();
        let squares = || scaled.weights.iter().map(|w| w * w);
        let fourth = if set.weights.is_empty() {
            1.0 / set.len() as f64
        } else {
            squares().map(|s| s * s).sum::<f64>() / squares().sum::<f64>().powi(2)
        };
        Self { n_effective: set.n_effective(), fourth, discrepancy }
    }

    /// Returns N D^2 with the variance that its distribution has at large N.
    fn standardized(&self, mean: f64) -> f64 {
        let value = self.n_effective * self.discrepancy * self.discrepancy;
        mean + (value - mean) / (1.0 - self.fourth).sqrt()
    }
}

/// The probabilities of a statistic under the hypothesis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TailProbabilities {
    /// That of a value as small or smaller: small where the points are more regular than random.
    pub lower: f64,
    /// That of a value as large or larger: small where they cluster.
    pub upper: f64,
}

/// The fewest points with equal weights for which the distribution holds. In 20,000 sets of 8 points
/// 6.2 % of the values were in the lower tail of 5 %, and 1.7 % in that of 1 %; of 20 points 5.5 %
/// and 1.3 %. The upper tails and the hemisphere were closer.
const MIN_POINTS: f64 = 8.0;

/// Tests the hypothesis that the points are independent and uniform, with their weights, by the
/// discrepancies of one or more independent realizations.
///
/// Then `(2l + 1) P(l)` tends to a chi-square variable of `2l + 1` degrees of freedom, independent
/// for all l (on the hemisphere the even ones), and N D^2 to their sum with the factors of the
/// statistic over `2l + 1` (Choirat and Seri 2013). Its mean is exact at any N and its variance is
/// smaller by `1 - sum w^4/(sum w^2)^2`, which is `1 - 1/N`: the value is standardized accordingly.
/// The distribution function is the inverse Laplace transform along the vertical line through the
/// saddle point of the integrand, to a relative accuracy of 1e-8 in both tails, however small.
///
/// The distribution is asymptotic: a probability of 0.05 holds to a fourth of itself from 8 points
/// on and to a tenth from 20 on, one of 0.01 to 0.7 and 0.3; much smaller ones show the order of
/// magnitude of their logarithm only, and underflow to 0.
///
/// # Errors
///
/// [`Unavailable`] for fewer than 8 points, for weighted ones if `(sum w^2)^2/sum w^4` is below 8.
///
/// # References
///
/// C. Choirat and R. Seri, "Computational aspects of Cui-Freeden statistics for equidistribution on
/// the sphere", Math. Comp. 82(284), 2013, for the distribution; H. E. Daniels, "Tail probability
/// approximations", Int. Stat. Rev. 55, 1987, for the contour.
pub fn test_uniformity(
    statistic: UniformityStatistic,
    domain: Domain,
    observed: &[ObservedDiscrepancy],
) -> Result<TailProbabilities, Unavailable> {
    if observed.is_empty() {
        return Err(Unavailable::new("there is no realization"));
    }
    let mean = statistic.mean(domain);
    let mut standardized = 0.0;
    for o in observed {
        // The sum of squares 0 of weights that are all 0 makes it NaN.
        if o.fourth.is_nan() || o.fourth * MIN_POINTS > 1.0 + 1e-9 {
            return Err(Unavailable::new(format!(
                "the distribution needs {MIN_POINTS} points of comparable weight: \
                 (sum w^2)^2/sum w^4 is {:.3}",
                1.0 / o.fourth
            )));
        }
        standardized += o.standardized(mean);
    }
    let copies = observed.len() as f64;
    Ok(NullDistribution::new(statistic, domain).tails(standardized / copies, copies))
}

/// Number of degrees of which the tails are known.
const DEGREES: usize = 20_000;

/// The distribution of N D^2 of independent uniform points.
struct NullDistribution {
    mean: f64,
    /// Degrees of freedom and coefficients by degree.
    terms: Vec<(f64, f64)>,
    /// The sums of `f c`, `f c^2` and `f c^3` from a term on.
    rests: Vec<[f64; 3]>,
}

impl NullDistribution {
    fn new(statistic: UniformityStatistic, domain: Domain) -> Self {
        let degrees = (domain.degree_step()..=DEGREES).step_by(domain.degree_step());
        let terms: Vec<(f64, f64)> = degrees
            .map(|l| {
                let freedom = 2.0 * l as f64 + 1.0;
                (freedom, statistic.factor(l) / freedom)
            })
            .collect();
        let mean = statistic.mean(domain);
        let known: f64 = terms.iter().rev().map(|(f, c)| f * c).sum();
        let mut rest = [mean - known, 0.0, 0.0];
        let mut rests: Vec<[f64; 3]> = terms
            .iter()
            .rev()
            .map(|(f, c)| {
                let mut term = *f;
                for sum in &mut rest {
                    term *= c;
                    *sum += term;
                }
                rest
            })
            .collect();
        rests.reverse();
        Self { mean, terms, rests }
    }

    /// Returns the number of terms to be taken one by one for arguments up to this magnitude; of
    /// the others, whose argument is below 1e-3, the cumulants are summed.
    fn n_terms(&self, magnitude: f64) -> usize {
        let is_large = |&&(_, c): &&(f64, f64)| c * magnitude > 1e-3;
        self.terms.iter().take_while(is_large).count().clamp(32, self.terms.len() - 1)
    }

    /// Returns the logarithm of E exp(s T).
    fn cumulant(&self, s: Complex<f64>, n_terms: usize) -> Complex<f64> {
        let mut sum: Complex<f64> = Complex::ZERO;
        // A product of factors near 1 has one logarithm, unless its phase could pass pi.
        for (freedom, c) in &self.terms[..n_terms] {
            sum -= 0.5 * freedom * (1.0 - 2.0 * c * s).ln();
        }
        let [first, second, third] = self.rests[n_terms];
        sum + s * (first + s * (second + s * (4.0 / 3.0 * third)))
    }

    /// Returns the first two derivatives of the cumulant function.
    fn derivatives(&self, s: f64) -> (f64, f64) {
        let n_terms = self.n_terms(s.abs());
        let [first, second, third] = self.rests[n_terms];
        let start =
            (first + 2.0 * second * s + 4.0 * third * s * s, 2.0 * second + 8.0 * third * s);
        self.terms[..n_terms].iter().fold(start, |(mean, variance), (freedom, c)| {
            let scaled = c / (1.0 - 2.0 * c * s);
            (mean + freedom * scaled, variance + 2.0 * freedom * scaled * scaled)
        })
    }

    /// Returns the saddle point, at which the tilted distribution has the mean `x`.
    fn saddle(&self, x: f64) -> f64 {
        let pole = 0.5 / self.terms[0].1;
        // In p = -ln(1 - s/pole), which covers both sides without end.
        let at = |p: f64| pole * -(-p).exp_m1();
        let (mut low, mut high) = (-60.0, 36.0);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if self.derivatives(at(middle)).0 < x { low = middle } else { high = middle }
        }
        at(0.5 * (low + high))
    }

    /// Returns the probabilities that the mean of `copies` independent values is at most and at
    /// least `x`.
    fn tails(&self, x: f64, copies: f64) -> TailProbabilities {
        if x <= 0.0 {
            return TailProbabilities { lower: 0.0, upper: 1.0 };
        }
        let deviation = (self.derivatives(0.0).1 / copies).sqrt();
        // The integrand has a pole at 0, to which the line keeps a distance.
        let distance = 0.5 / (deviation * copies);
        let saddle = self.saddle(x);
        let is_lower = x < self.mean;
        let line = if is_lower { saddle.min(-distance) } else { saddle.max(distance) };
        let pole = 0.5 / self.terms[0].1;
        let line = line.min(0.5 * (saddle.max(0.0) + pole));
        let one_tail = self.integral(line, x, copies).clamp(0.0, 1.0);
        if is_lower {
            TailProbabilities { lower: one_tail, upper: 1.0 - one_tail }
        } else {
            TailProbabilities { lower: 1.0 - one_tail, upper: one_tail }
        }
    }

    /// Returns `|1/(2 pi i) int exp(copies (K(s) - s x))/s ds|` along the line of real part `line`.
    fn integral(&self, line: f64, x: f64, copies: f64) -> f64 {
        let exponent =
            |s: Complex<f64>| copies * (self.cumulant(s, self.n_terms(s.norm())) - s * x);
        let origin = exponent(Complex::new(line, 0.0)).re;
        if origin < -745.0 {
            return 0.0;
        }
        let width = 1.0 / (copies * self.derivatives(line).1).sqrt();
        // The trapezoidal rule converges exponentially with the distance of the pole in steps.
        let step = (0.1 * width).min(line.abs() / 8.0);
        let mut sum = 0.5 / line.abs();
        let mut small = 0;
        for k in 1..MAX_NODES {
            let s = Complex::new(line, k as f64 * step);
            let value = (exponent(s) - origin).exp() / s;
            sum += value.re * line.signum();
            small = if value.norm() <= 1e-14 * sum.abs() { small + 1 } else { 0 };
            if small == 4 {
                break;
            }
        }
        sum * step / PI * origin.exp()
    }
}

/// Maximum number of nodes of the integral; some hundreds are taken.
const MAX_NODES: usize = 100_000;

#[cfg(test)]
mod tests {
    use sphvar_samplers::{Pattern, PointSet, Purpose, Realizations, Streams};
    use sphvar_sh::Domain;

    use super::{
        DEGREES, NullDistribution, ObservedDiscrepancy, UniformityStatistic, test_uniformity,
    };

    const CAP: UniformityStatistic = UniformityStatistic::CapDiscrepancy;
    const GENERALIZED: UniformityStatistic = UniformityStatistic::GeneralizedDiscrepancy;

    #[test]
    fn factors_sum_to_the_mean() {
        for statistic in [CAP, GENERALIZED] {
            for domain in [Domain::Sphere, Domain::Hemisphere] {
                let degrees = (domain.degree_step()..=DEGREES).step_by(domain.degree_step());
                let sum: f64 = degrees.map(|l| statistic.factor(l)).sum();
                // The rest is about the last factor times the number of degrees.
                let rest = statistic.factor(DEGREES) * DEGREES as f64 / domain.degree_step() as f64;
                assert!((sum + rest - statistic.mean(domain)).abs() < 1e-4 * rest, "{domain}");
            }
        }
    }

    /// The integral of Imhof 1961 for the same distribution, without tilt: absolute accuracy.
    fn imhof(null: &NullDistribution, x: f64) -> f64 {
        let terms = &null.terms[..300];
        let rest = null.mean - terms.iter().map(|(f, c)| f * c).sum::<f64>();
        let integrand = |u: f64| {
            let angle: f64 = terms.iter().map(|(f, c)| f * (2.0 * c * u).atan()).sum();
            let log: f64 = terms.iter().map(|(f, c)| f * (2.0 * c * u).powi(2).ln_1p()).sum();
            (0.5 * angle + u * (rest - x)).sin() / (u * (0.25 * log).exp())
        };
        let step = 0.03 / null.mean;
        let nodes = (0..8000).map(|k| (f64::from(k) + 0.5) * step);
        0.5 + nodes.map(integrand).sum::<f64>() * step / std::f64::consts::PI
    }

    #[test]
    fn tails_match_the_integral_of_imhof() {
        for (statistic, domain) in [(CAP, Domain::Sphere), (GENERALIZED, Domain::Hemisphere)] {
            let null = NullDistribution::new(statistic, domain);
            for ratio in [0.3, 0.5, 0.9, 0.999, 1.0, 1.001, 1.2, 2.0, 5.0] {
                let x = ratio * null.mean;
                let tails = null.tails(x, 1.0);
                let expected = imhof(&null, x);
                assert!((tails.upper - expected).abs() < 1e-7, "{ratio}: {tails:?}, {expected}");
                assert!((tails.upper + tails.lower - 1.0).abs() < 1e-12);
            }
            // Both tails decrease without end.
            let lower: Vec<f64> =
                [0.1, 0.05, 0.02].map(|r| null.tails(r * null.mean, 1.0).lower).to_vec();
            assert!(lower[0] > lower[1] && lower[1] > lower[2] && lower[0] < 1e-3, "{lower:?}");
            assert!(null.tails(40.0 * null.mean, 1.0).upper > 0.0);
            assert!(null.tails(1e-9, 4.0).lower <= 0.0);
        }
    }

    /// Returns the discrepancy by all pairs.
    fn discrepancy(set: &PointSet, statistic: UniformityStatistic, domain: Domain) -> f64 {
        let kernel = |cosine: f64| {
            let chord = (2.0 - 2.0 * cosine).max(0.0).sqrt();
            match statistic {
                UniformityStatistic::CapDiscrepancy => 1.0 / 3.0 - chord / 4.0,
                UniformityStatistic::GeneralizedDiscrepancy => {
                    (1.0 - 2.0 * (0.5 * chord).ln_1p()) / (4.0 * std::f64::consts::PI)
                }
            }
        };
        let weight = |k: usize| set.weights.get(k).copied().unwrap_or(1.0);
        let (mut sum, mut total) = (0.0, 0.0);
        for (j, x) in set.points.iter().enumerate() {
            total += weight(j);
            for (k, y) in set.points.iter().enumerate() {
                let value = match domain {
                    Domain::Sphere => kernel(x.dot(*y)),
                    Domain::Hemisphere => 0.5 * (kernel(x.dot(*y)) + kernel(-x.dot(*y))),
                };
                sum += weight(j) * weight(k) * value;
            }
        }
        (sum / (total * total)).max(0.0).sqrt()
    }

    /// Returns the value below which the probability is `p`.
    fn quantile(null: &NullDistribution, p: f64) -> f64 {
        let (mut low, mut high) = (0.0, 10.0 * null.mean);
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            if null.tails(middle, 1.0).lower < p { low = middle } else { high = middle }
        }
        low
    }

    /// The number of p-values below 5 % in either tail is binomial: 5 standard deviations are 1e-6
    /// of false alarms; beside them the distribution may be off by a tenth at 20 points (1 %).
    #[test]
    fn levels_hold_for_independent_points() {
        const SETS: u64 = 2000;
        for (statistic, domain, weighted) in [
            (CAP, Domain::Sphere, false),
            (GENERALIZED, Domain::Sphere, true),
            (CAP, Domain::Hemisphere, false),
            (GENERALIZED, Domain::Hemisphere, false),
        ] {
            let null = NullDistribution::new(statistic, domain);
            let [first, last] = [0.05, 0.95].map(|p| quantile(&null, p));
            let white = Pattern::WhiteNoise.build(20, domain).unwrap();
            let sets = Realizations::unrotated(&*white, Streams::new(5, Purpose::Trial, 20));
            let (mut low, mut high) = (0_u64, 0_u64);
            for index in 0..SETS {
                let mut set = sets.realize(index).unwrap();
                if weighted {
                    set.weights = (0..20).map(|k| 1.0 + f64::from(k % 3)).collect();
                }
                let discrepancy = discrepancy(&set, statistic, domain);
                let value = ObservedDiscrepancy::new(&set, discrepancy).standardized(null.mean);
                low += u64::from(value < first);
                high += u64::from(value > last);
            }
            for count in [low, high] {
                assert!(count.abs_diff(SETS / 20) < 60, "{statistic:?}, {domain}: {low}, {high}");
            }
        }
    }

    #[test]
    fn regular_sets_are_in_the_lower_tail_and_clusters_in_the_upper() {
        let set = |pattern: Pattern| {
            let sampler = pattern.build(300, Domain::Sphere).unwrap();
            let sets = Realizations::rotated(&*sampler, Streams::new(0, Purpose::Pattern, 0));
            sets.realize(0).unwrap()
        };
        let p = |set: &PointSet| {
            let observed = ObservedDiscrepancy::new(set, discrepancy(set, CAP, Domain::Sphere));
            test_uniformity(CAP, Domain::Sphere, &[observed]).unwrap()
        };
        assert!(p(&set(Pattern::FIBONACCI)).lower < 1e-12);
        let white = set(Pattern::WhiteNoise);
        assert!(p(&white).lower > 1e-3 && p(&white).upper > 1e-3);
        let mut crowded = white.clone();
        for _ in 0..3 {
            crowded.points.extend_from_within(..60);
        }
        assert!(p(&crowded).upper < 0.01, "{:?}", p(&crowded));
        // One weight that outweighs all others leaves nothing to test.
        let mut dominated = white;
        dominated.weights = vec![1.0; 300];
        dominated.weights[0] = 1e4;
        let observed = ObservedDiscrepancy::new(&dominated, 0.5);
        assert!(test_uniformity(CAP, Domain::Sphere, &[observed]).is_err());
    }
}
