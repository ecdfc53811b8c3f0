//! The homogeneity audit: its false-alarm rate for homogeneous ensembles, and its detection of
//! inhomogeneous ones with the size of the error.

use glam::{DMat3, DQuat, DVec3};
use rand::Rng;
use sphvar_samplers::{
    Domain, Ensemble, Error, Pattern, PointSet, Progress, Purpose, Realizations, Sampler, Streams,
    rotate, uniform_rotation,
};
use sphvar_spectrum::{
    Accumulator, AuditFamily, AuditSettings, AuditVerdict, HomogeneityAccumulator,
    HomogeneityAudit, Resolution, accumulate,
};
use sphvar_tests::exact_jitter_orders;

const SEED: u64 = 11;

fn coefficients(
    sets: &dyn Ensemble,
    sampler: &dyn Sampler,
    lmax: usize,
    count: u64,
) -> HomogeneityAccumulator {
    let empty = HomogeneityAccumulator::new(sampler.domain(), lmax).unwrap();
    let resolution = Resolution::new(lmax, sampler.n_points());
    accumulate(sets, resolution, 0..count, &empty, &()).unwrap()
}

/// Returns the audit of a sampler as it draws.
fn drawn(
    sampler: &dyn Sampler,
    lmax: usize,
    count: u64,
    settings: &AuditSettings,
) -> HomogeneityAudit {
    let streams = Streams::new(settings.seed, Purpose::Pattern, sampler.n_points());
    let sets = Realizations::unrotated(sampler, streams);
    coefficients(&sets, sampler, lmax, count).audit(settings, None, &()).unwrap()
}

/// A function that draws a rotation.
type RotationDistribution = fn(&mut dyn Rng) -> DMat3;

/// The ensemble of a sampler, rotated with any distribution of rotations; with `uniform_rotation`
/// that of `Realizations::rotated`.
struct RandomlyRotated<'a> {
    sampler: &'a dyn Sampler,
    streams: Streams,
    distribution: RotationDistribution,
}

impl RandomlyRotated<'_> {
    fn rotation(&self, index: u64) -> DMat3 {
        (self.distribution)(&mut self.streams.randomization(index))
    }
}

impl Ensemble for RandomlyRotated<'_> {
    fn realize_into(
        &self,
        index: u64,
        set: &mut PointSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        Realizations::unrotated(self.sampler, self.streams).realize_into(index, set, progress)?;
        rotate(self.rotation(index), self.sampler.domain(), &mut set.points);
        Ok(())
    }
}

/// Returns the audit of a sampler whose sets are rotated by such rotations.
fn audit_rotated(
    sampler: &dyn Sampler,
    lmax: usize,
    count: u64,
    settings: &AuditSettings,
    distribution: RotationDistribution,
) -> HomogeneityAudit {
    let streams = Streams::new(settings.seed, Purpose::Pattern, sampler.n_points());
    let sets = RandomlyRotated { sampler, streams, distribution };
    let coefficients = coefficients(&sets, sampler, lmax, count);
    let rotations: Vec<DMat3> = (0..count).map(|i| sets.rotation(i)).collect();
    coefficients.audit(settings, Some(&rotations), &()).unwrap()
}

/// Returns the shortest rotation of a random direction to another, which is not uniform: its mean
/// is I/3.
fn one_random_vector_to_another(rng: &mut dyn Rng) -> DMat3 {
    let (a, b) = (uniform_rotation(rng) * DVec3::Z, uniform_rotation(rng) * DVec3::Z);
    DMat3::from_quat(DQuat::from_rotation_arc(a, b))
}

/// Audits of small homogeneous ensembles, far from normal: a single point, strata, an antipodal
/// lattice.
///
/// p-values are uniform on multiples of 1/50, so in every family the number of those up to 0.2 is
/// binomial; beyond 4.5 standard deviations it is with probability 7e-6, over 5 families 4e-5. The
/// number of rejections of whole audits is at most that expected for alpha, again within 4.5
/// deviations. Of 210 audits that is a rate between 0.08 and 0.32.
#[test]
fn false_alarms_are_as_rare_as_promised() {
    const AUDITS: u64 = 70;
    const ALPHA: f64 = 0.2;
    let cases = [
        (Pattern::WhiteNoise, 1, Domain::Sphere),
        (Pattern::Jittered, 12, Domain::Sphere),
        (Pattern::FIBONACCI, 15, Domain::Hemisphere),
    ];
    let (mut objections, mut small) = (0, [0; 5]);
    for (pattern, n, domain) in &cases {
        let sampler = pattern.build(*n, *domain).unwrap();
        for i in 0..AUDITS {
            let settings = AuditSettings { alpha: ALPHA, tolerance: 0.2, seed: SEED + i };
            assert_eq!(settings.replicates(), 49);
            let audit = audit_rotated(&*sampler, 4, 30, &settings, uniform_rotation);
            objections += u32::from(audit.verdict == AuditVerdict::Inhomogeneous);
            assert_eq!(audit.findings.len(), AuditFamily::ALL.len());
            for (finding, small) in audit.findings.iter().zip(&mut small) {
                *small += u32::from(finding.p_value <= ALPHA);
            }
        }
    }
    let audits = (AUDITS * cases.len() as u64) as f64;
    let (expected, deviation) = (ALPHA * audits, (ALPHA * (1.0 - ALPHA) * audits).sqrt());
    assert!(f64::from(objections) < expected + 4.5 * deviation, "{objections} of {audits}");
    for (family, count) in AuditFamily::ALL.iter().zip(small) {
        let z = (f64::from(count) - expected) / deviation;
        assert!(z.abs() < 4.5, "{}: {count} of {audits} p-values to {ALPHA}", family.name());
    }
}

/// Jitter of 768 cells as drawn: the audit rejects them, and its intervals contain the ratios of the
/// quadrature, all of them with probability 0.99; for rotated sets it does not reject (0.99).
#[test]
#[ignore = "statistics"]
fn jitter_is_homogeneous_only_when_rotated() {
    const REALIZATIONS: u64 = 2000;
    const LMAX: usize = 4;
    let sampler = Pattern::Jittered.build(768, Domain::Sphere).unwrap();
    let settings = AuditSettings::new(SEED);
    let audit = drawn(&*sampler, LMAX, REALIZATIONS, &settings);
    assert_eq!(audit.verdict, AuditVerdict::Inhomogeneous);
    let rejected = |family| audit.finding(family).unwrap().rejected;
    // Stratified, so free of bias; its expected difference in (4, 0) is 3.7 standard errors and in
    // (4, 3) 5.
    assert!(!rejected(AuditFamily::Means));
    assert!(rejected(AuditFamily::Orders) && rejected(AuditFamily::Covariances));
    assert!(audit.finding(AuditFamily::Rotations).is_none());

    let exact = exact_jitter_orders(8, LMAX);
    let degree = |l: usize| {
        let both_signs: f64 = (1..=l).map(|m| 2.0 * exact[(l, m)].re).sum();
        (exact[(l, 0)].re + both_signs) / (2 * l + 1) as f64
    };
    assert_eq!(audit.ratios.len(), 2 + 3 + 4 + 5);
    for r in &audit.ratios {
        let expected = exact[(r.l, r.m)].re / degree(r.l);
        assert!(r.low < expected && expected < r.high, "{r:?}, by quadrature {expected}");
        // |S_lm|^2 of nearly normal coefficients scatters by its mean, by sqrt(2) of it for m = 0.
        assert!(r.stderr < 1.6 / (REALIZATIONS as f64).sqrt(), "{r:?}");
    }
    let y40 = audit.ratios.iter().find(|r| (r.l, r.m) == (4, 0)).unwrap();
    assert!(
        (exact[(4, 0)].re / degree(4) - 1.1156).abs() < 6e-5
            && y40.low < 1.1156
            && 1.1156 < y40.high
    );

    let audit = audit_rotated(&*sampler, LMAX, REALIZATIONS, &settings, uniform_rotation);
    assert_eq!(audit.verdict, AuditVerdict::Homogeneous, "{audit:#?}");
    // Critical value and margin are some 5 standard errors of sqrt(2/2000).
    assert!((0.1..0.2).contains(&audit.detectable), "{}", audit.detectable);
}

#[test]
fn rotations_that_are_not_uniform_are_found() {
    const REALIZATIONS: u64 = 300;
    let settings = AuditSettings::new(SEED);
    let sampler = Pattern::Jittered.build(48, Domain::Sphere).unwrap();
    let audit = audit_rotated(&*sampler, 4, REALIZATIONS, &settings, one_random_vector_to_another);
    assert_eq!(audit.verdict, AuditVerdict::Inhomogeneous);
    let rotations = audit.finding(AuditFamily::Rotations).unwrap();
    assert!(rotations.rejected, "{rotations:?}");
    // The largest entry of the mean is one of the diagonal, 1/3 on average; an entry's standard
    // error is below 1/sqrt(3 R) = 0.033.
    assert!((rotations.value - 1.0 / 3.0).abs() < 0.15, "{rotations:?}");
    assert!(["E R_xx", "E R_yy", "E R_zz"].contains(&&*rotations.worst), "{rotations:?}");
}

/// A single repeated set has only bias: the mean squared error of a coefficient is its square.
#[test]
fn a_fixed_set_is_not_an_ensemble() {
    let settings = AuditSettings::new(SEED);
    let sampler = Pattern::FIBONACCI.build(60, Domain::Sphere).unwrap();
    let audit = drawn(&*sampler, 5, 40, &settings);
    assert_eq!(audit.verdict, AuditVerdict::Inhomogeneous);
    assert!(audit.finding(AuditFamily::Means).unwrap().rejected);
    let (bias, worst) = (audit.bias.unwrap(), audit.worst_ratio().unwrap());
    assert_eq!((bias.l, bias.m), (worst.l, worst.m));
    // Sums of 40 equal numbers, divided again.
    assert!((bias.share / worst.ratio - 1.0).abs() < 1e-12, "{bias:?}, {worst:?}");
    assert!(worst.ratio > 1.0 && worst.stderr < 1e-12, "{worst:?}");
}

/// Odd degrees of antipodal sets have no power and are left out; on the hemisphere there are none.
#[test]
fn degrees_without_power_are_left_out() {
    let settings = AuditSettings { alpha: 0.1, tolerance: 10.0, seed: SEED };
    let sampler = Pattern::Healpix.build(48, Domain::Sphere).unwrap();
    let audit = audit_rotated(&*sampler, 5, 60, &settings, uniform_rotation);
    assert_eq!(audit.vanishing, [1, 3, 5]);
    assert!(audit.ratios.iter().all(|r| r.l.is_multiple_of(2)), "{:?}", audit.ratios);
    let sampler = Pattern::Jittered.build(24, Domain::Hemisphere).unwrap();
    let audit = audit_rotated(&*sampler, 5, 60, &settings, uniform_rotation);
    assert!(audit.vanishing.is_empty());
    assert_eq!(audit.ratios.len(), 3 + 5);
    // A lattice with a fourfold axis: S_41 is rounding and has no phase, in a family of its own.
    let sampler = Pattern::Healpix.build(12, Domain::Sphere).unwrap();
    let phases = drawn(&*sampler, 4, 60, &settings).finding(AuditFamily::Phases).unwrap().clone();
    assert!(phases.worst.contains("(4,4)"), "{phases:?}");
}

#[test]
fn a_few_realizations_tell_nothing() {
    let settings = AuditSettings { alpha: 0.1, tolerance: 0.2, seed: SEED };
    let sampler = Pattern::WhiteNoise.build(1, Domain::Sphere).unwrap();
    for count in [1, 2, 5] {
        let audit = drawn(&*sampler, 3, count, &settings);
        assert_eq!(audit.verdict, AuditVerdict::Undecided, "{count}: {audit:#?}");
        assert!(audit.detectable > settings.tolerance, "{}", audit.detectable);
        assert!(audit.findings.iter().all(|f| (0.01..=1.0).contains(&f.p_value)), "{audit:#?}");
    }
    assert!(drawn(&*sampler, 3, 1, &settings).detectable.is_infinite());
    // Any single rotation has the same size: a tie with every other.
    let one = audit_rotated(&*sampler, 3, 1, &settings, uniform_rotation);
    assert!(one.finding(AuditFamily::Rotations).unwrap().p_value >= 1.0, "{one:#?}");
    let empty = HomogeneityAccumulator::new(Domain::Sphere, 3).unwrap();
    assert_eq!(empty.audit(&settings, None, &()), Err(sphvar_spectrum::Error::NoRealizations));
}

#[test]
fn settings_out_of_range_are_rejected() {
    let sampler = Pattern::WhiteNoise.build(3, Domain::Sphere).unwrap();
    let streams = Streams::new(SEED, Purpose::Pattern, 3);
    let sets = Realizations::rotated(&*sampler, streams);
    let coefficients = coefficients(&sets, &*sampler, 2, 3);
    for (alpha, tolerance) in
        [(0.0, 0.2), (f64::NAN, 0.2), (0.6, 0.2), (0.01, 0.0), (0.01, f64::INFINITY)]
    {
        let settings = AuditSettings { alpha, tolerance, seed: 0 };
        let got = coefficients.audit(&settings, None, &());
        assert!(
            matches!(got, Err(sphvar_spectrum::Error::Setting { .. })),
            "{settings:?}: {got:?}"
        );
    }
    for (domain, lmax) in [(Domain::Sphere, 0), (Domain::Hemisphere, 1)] {
        let got = HomogeneityAccumulator::new(domain, lmax);
        assert!(
            matches!(got, Err(sphvar_spectrum::Error::Setting { .. })),
            "{domain} to {lmax}: {got:?}"
        );
    }
}

/// The order of realizations does not matter, and the rotated sets are those of the rotated
/// ensemble.
#[test]
fn an_audit_depends_on_the_sets_alone() {
    let settings = AuditSettings { alpha: 0.2, tolerance: 0.2, seed: SEED };
    let sampler = Pattern::Jittered.build(12, Domain::Sphere).unwrap();
    let streams = Streams::new(SEED, Purpose::Pattern, 12);
    let sets = Realizations::rotated(&*sampler, streams);
    let part = |range: std::ops::Range<u64>| {
        let empty = HomogeneityAccumulator::new(Domain::Sphere, 4).unwrap();
        accumulate(&sets, Resolution::new(4, 12), range, &empty, &()).unwrap()
    };
    let whole = part(0..20).audit(&settings, None, &()).unwrap();
    let mut parts = part(13..20);
    parts.merge(&part(0..13));
    assert_eq!(parts.audit(&settings, None, &()).unwrap(), whole);
    let same_sets = RandomlyRotated { sampler: &*sampler, streams, distribution: uniform_rotation };
    let (mut a, mut b) = (PointSet::default(), PointSet::default());
    for index in 0..20 {
        sets.realize_into(index, &mut a, &()).unwrap();
        same_sets.realize_into(index, &mut b, &()).unwrap();
        assert!(a == b && a.weights.is_empty(), "set {index}");
        assert_eq!(sets.rotation(index), same_sets.rotation(index));
    }
}
