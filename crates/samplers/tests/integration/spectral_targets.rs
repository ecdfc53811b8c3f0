//! Targets of spectrum control beyond powers of the frequency: single-peak blue noise and pair
//! correlations.

use std::path::Path;

use glam::DVec3;
use sphvar_samplers::grammar::ResolveError;
use sphvar_samplers::{
    Domain, Error, FileResolver, Pattern, PointFile, PointFileParameters, PowerProfile,
    ProfileParameters, ProfileTable, Purpose, Sampler, SinglePeak, SpectralControl, SquarePattern,
    Streams,
};
use sphvar_sh::legendre_p;

const DOMAINS: [Domain; 2] = [Domain::Sphere, Domain::Hemisphere];

fn sample(sampler: &dyn Sampler) -> Vec<DVec3> {
    sampler.sample(&mut Streams::new(4, Purpose::Pattern, 0).realization(0)).unwrap().points
}

/// Returns the power at degree l by the addition theorem.
fn power(points: &[DVec3], l: usize) -> f64 {
    let pairs = points.iter().flat_map(|p| points.iter().map(|q| p.dot(*q).clamp(-1.0, 1.0)));
    pairs.map(|x| legendre_p(l, x).unwrap()).sum::<f64>() / points.len() as f64
}

#[test]
fn every_set_has_the_powers_of_its_target() {
    // Pairs nearer than 0.1 are rare, as in soft repulsion.
    let g = [[0.0, 0.2], [0.1, 0.9], [0.3, 1.0]];
    for profile in [
        PowerProfile::SinglePeak(SinglePeak::DEFAULT),
        PowerProfile::SinglePeak(SinglePeak { edge: 1.1, width: 0.2, ..SinglePeak::DEFAULT }),
        PowerProfile::PairCorrelation { name: "pairs".into(), g: g.into() },
    ] {
        for domain in DOMAINS {
            let control = SpectralControl::profile(120, domain, &profile).unwrap();
            let points = sample(&control);
            let last = control.target().last_degree();
            assert!(last >= 20, "{profile:?}");
            for l in (1..=last).filter(|l| domain.has_degree(*l)) {
                let (got, target) = (power(&points, l), control.target().at(l, domain).unwrap());
                assert!((got - target).abs() < 2e-6, "{profile:?} {domain} {l}: {got}, {target}");
            }
        }
    }
}

#[test]
fn single_peaks_have_the_grammar_of_profiles() {
    let edge = SinglePeak { edge: 1.25, ..SinglePeak::DEFAULT };
    let peak = SinglePeak { peak: Some(0.3), width: 0.05, to: 2.5, ..edge };
    for (text, profile) in
        [("profile:edge=1.25", edge), ("profile:edge=1.25,peak=0.3,width=0.05,to=2.5", peak)]
    {
        let profile = PowerProfile::SinglePeak(profile);
        let pattern = Pattern::Profile(ProfileParameters { profile, core: 0.0 });
        assert_eq!(text.parse(), Ok(pattern.clone()));
        assert_eq!(pattern.to_string().parse(), Ok(pattern));
    }
    let square: SquarePattern = "profile-square:edge=0.7".parse().unwrap();
    assert_eq!(square.to_string().parse(), Ok(square.clone()));
    // A set that misses its target is an error.
    let mut rng = Streams::new(4, Purpose::Pattern, 0).realization(0);
    assert!(square.build(150).unwrap().sample(&mut rng).is_ok());
    for (text, message) in [
        ("profile:edge=0", "edge must be finite and above 0, got 0"),
        ("profile:edge=1,b=2", "unknown parameter \"b\""),
        ("profile:colour=blue,edge=1", "unknown parameter \"edge\""),
        ("profile:peak=1", "unknown parameter \"peak\""),
    ] {
        let error = text.parse::<Pattern>().unwrap_err().to_string();
        assert!(error.contains(message), "{text}: {error}");
    }
}

/// A pair correlation in every file, except for one without values.
struct Correlations;

impl FileResolver for Correlations {
    fn profile(&self, file: &Path) -> Result<ProfileTable, ResolveError> {
        let g = if file == Path::new("none") { vec![] } else { vec![[0.1, 0.5], [0.2, 1.0]] };
        Ok(ProfileTable::PairCorrelation(g))
    }

    fn points(&self, _: &PointFileParameters) -> Result<Vec<PointFile>, ResolveError> {
        Err(ResolveError::new("no points"))
    }
}

#[test]
fn pair_correlations_come_from_files() {
    for text in ["profile:g.csv", "profile:g.csv,core=0.25"] {
        let pattern = Pattern::parse(text, &Correlations).unwrap();
        let Pattern::Profile(ProfileParameters { profile, .. }) = &pattern else {
            panic!("{pattern:?}")
        };
        assert!(matches!(profile, PowerProfile::PairCorrelation { g, .. } if g.len() == 2));
        assert_eq!(pattern.to_string(), text);
        assert!(pattern.build(50, Domain::Sphere).is_ok());
    }
    let built = Pattern::parse("profile:none", &Correlations).unwrap().build(50, Domain::Sphere);
    assert!(matches!(built, Err(Error::Infeasible { .. })), "{built:?}");
    let square = SquarePattern::parse("profile-square:g.csv", &Correlations).unwrap().build(50);
    assert!(matches!(square, Err(Error::Infeasible { .. })), "{square:?}");
}
