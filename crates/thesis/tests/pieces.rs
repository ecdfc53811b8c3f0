//! Results in pieces are bit-identical to a single run, and stored pieces are not recomputed.

use std::collections::BTreeMap;
use std::sync::Mutex;

use sphvar_samplers::{Domain, Pattern, SquarePattern};
use sphvar_scene::DirectionMode;
use sphvar_thesis::{
    Error, Job, JobPiece, Lighting, NoStore, Pictures, PlaneEnsemble, Results, Scale, Setting,
    Store, ThesisEnsemble, run, run_pieces, work,
};

const SETTING: Setting = Setting { scale: Scale::Quick, seed: 5 };

/// Stores pieces in memory and counts accesses.
#[derive(Default)]
struct Memory {
    pieces: Mutex<BTreeMap<String, Vec<u8>>>,
    saved: Mutex<usize>,
    /// The maximum number of pieces that can be saved.
    capacity: Option<usize>,
}

impl Store for Memory {
    fn load(&self, key: &str) -> Option<Vec<u8>> {
        self.pieces.lock().unwrap().get(key).cloned()
    }

    fn save(&self, key: &str, bytes: &[u8]) -> Result<(), String> {
        let mut saved = self.saved.lock().unwrap();
        if self.capacity.is_some_and(|capacity| *saved >= capacity) {
            return Err("the store is full".to_owned());
        }
        *saved += 1;
        self.pieces.lock().unwrap().insert(key.to_owned(), bytes.to_vec());
        Ok(())
    }
}

fn done(jobs: &[Job], store: &dyn Store) -> Result<Results, Error> {
    let mut results = Results::new(SETTING);
    run(jobs, store, &mut results, &())?;
    Ok(results)
}

/// Renders that take two seconds each by the model and less on any machine: they are divided into
/// pieces.
fn costly(renders: u64) -> Job {
    Job::Pictures(Pictures {
        pattern: Some(Pattern::FIBONACCI),
        lighting: Lighting::Ambient,
        n_points: 9600,
        mode: DirectionMode::Shared,
        side: 44,
        renders,
    })
}

fn jobs() -> Vec<Job> {
    let white = ThesisEnsemble::sphere(Pattern::WhiteNoise, 40);
    let half = ThesisEnsemble::visible_half(Pattern::Jittered, 24);
    vec![
        Job::Spectrum { ensemble: half, domain: Domain::Hemisphere, lmax: 6, sets: 9 },
        Job::Orders { ensemble: white.clone(), lmax: 5, sets: 7 },
        Job::Coefficient { ensemble: white.clone(), l: 4, m: 3, sets: 11 },
        Job::Trials { ensemble: white, sets: 10 },
        Job::Pictures(Pictures {
            pattern: Some(Pattern::FIBONACCI),
            lighting: Lighting::Ambient,
            n_points: 8,
            mode: DirectionMode::Rotated,
            side: 12,
            renders: 2,
        }),
        Job::PlaneSpectrum {
            ensemble: PlaneEnsemble::new(SquarePattern::JitteredSquare, 16),
            kmax: 6,
            sets: 8,
        },
    ]
}

#[test]
fn kept_pieces_are_the_same_as_new_ones() {
    let store = Memory::default();
    let first = done(&jobs(), &store).unwrap();
    let saved = *store.saved.lock().unwrap();
    assert!(saved >= 6);
    let second = done(&jobs(), &store).unwrap();
    assert_eq!(*store.saved.lock().unwrap(), saved, "nothing is done twice");
    let jobs = jobs();
    assert_eq!(first.spectrum(&jobs[0]).unwrap(), second.spectrum(&jobs[0]).unwrap());
    assert_eq!(first.orders(&jobs[1]).unwrap(), second.orders(&jobs[1]).unwrap());
    assert_eq!(first.coefficients(&jobs[2]).unwrap(), second.coefficients(&jobs[2]).unwrap());
    assert_eq!(first.trials(&jobs[3]).unwrap(), second.trials(&jobs[3]).unwrap());
    assert_eq!(first.pictures(&jobs[4]).unwrap(), second.pictures(&jobs[4]).unwrap());
    assert_eq!(first.plane(&jobs[5]).unwrap(), second.plane(&jobs[5]).unwrap());
}

#[test]
fn pieces_that_do_not_fit_are_made_again() {
    let store = Memory::default();
    let first = done(&jobs(), &store).unwrap();
    let good = store.pieces.lock().unwrap().clone();
    // Every key holds the piece of another job.
    let mut exchanged: Vec<Vec<u8>> = good.values().cloned().collect();
    exchanged.rotate_left(1);
    *store.pieces.lock().unwrap() = good.keys().cloned().zip(exchanged).collect();
    let second = done(&jobs(), &store).unwrap();
    assert_eq!(*store.pieces.lock().unwrap(), good, "every piece is replaced");
    let jobs = jobs();
    assert_eq!(first.spectrum(&jobs[0]).unwrap(), second.spectrum(&jobs[0]).unwrap());
    assert_eq!(first.pictures(&jobs[4]).unwrap(), second.pictures(&jobs[4]).unwrap());
    assert_eq!(first.plane(&jobs[5]).unwrap(), second.plane(&jobs[5]).unwrap());
}

#[test]
fn an_interrupted_run_goes_on_where_it_stopped() {
    let store = Memory { capacity: Some(1), ..Memory::default() };
    let failed = done(&[costly(3)], &store);
    assert!(matches!(failed, Err(Error::Store { .. })), "{failed:?}");
    let store = Memory { capacity: None, ..store };
    let advanced = Mutex::new(0.0);
    let mut results = Results::new(SETTING);
    let jobs = [costly(3), costly(3)];
    run(&jobs, &store, &mut results, &|x| *advanced.lock().unwrap() += x).unwrap();
    let pieces = *store.saved.lock().unwrap();
    assert!(pieces > 1, "the job must fall into several pieces");
    // A sum of some products.
    let advanced = advanced.into_inner().unwrap();
    assert!((advanced / work(&jobs) - 1.0).abs() < 16.0 * f64::EPSILON);
    let undisturbed = done(&jobs[..1], &NoStore).unwrap();
    assert_eq!(results.pictures(&jobs[0]).unwrap(), undisturbed.pictures(&jobs[0]).unwrap());

    // A longer run reuses the complete pieces.
    let longer = [costly(5)];
    done(&longer, &store).unwrap();
    let fresh = Memory::default();
    done(&longer, &fresh).unwrap();
    assert!(*store.saved.lock().unwrap() - pieces < *fresh.saved.lock().unwrap());
}

#[test]
fn what_was_not_run_is_missing() {
    let results = done(&[], &NoStore).unwrap();
    for job in jobs() {
        assert!(!results.contains(&job));
        let message = results.spectrum(&job).unwrap_err().to_string();
        assert!(message.contains(&job.key()), "{message}");
    }
}

/// Each of three processes computes some pieces, and a fourth one has all of them.
#[test]
fn pieces_of_several_processes_complete_their_jobs() {
    let jobs = [jobs(), vec![costly(3)]].concat();
    let mut pieces = BTreeMap::new();
    for process in 0..3 {
        let (mut number, mut results) = (0, Results::new(SETTING));
        let keep = |piece: &JobPiece<'_>| -> Result<_, Error> {
            number += 1;
            if number % 3 == process {
                pieces.insert(piece.key().to_owned(), piece.compute()?);
            }
            Ok(None)
        };
        run_pieces(&jobs, &mut results, keep).unwrap();
        assert!(jobs.iter().all(|job| !results.contains(job)));
    }
    let whole = done(&jobs, &NoStore).unwrap();
    let merged = |pieces: &BTreeMap<String, Vec<u8>>| -> Result<Results, Error> {
        let mut results = Results::new(SETTING);
        run_pieces(&jobs, &mut results, |piece| Ok(pieces.get(piece.key()).cloned()))
            .map(|()| results)
    };
    let results = merged(&pieces).unwrap();
    assert_eq!(results.spectrum(&jobs[0]).unwrap(), whole.spectrum(&jobs[0]).unwrap());
    assert_eq!(results.pictures(&jobs[6]).unwrap(), whole.pictures(&jobs[6]).unwrap());
    // Of the last job the second piece is missing.
    let last = pieces.keys().find(|key| key.contains("n=9600") && !key.contains("sets=0")).cloned();
    let bytes = pieces.remove(last.as_ref().unwrap()).unwrap();
    let partial = merged(&pieces).unwrap();
    assert!(partial.contains(&jobs[5]) && !partial.contains(&jobs[6]));
    // Bytes of another number of sets.
    let first = pieces.values().next().unwrap().clone();
    for wrong in [first, bytes[..bytes.len() - 1].to_vec(), Vec::new()] {
        pieces.insert(last.clone().unwrap(), wrong);
        let error = merged(&pieces).unwrap_err();
        assert!(matches!(&error, Error::Piece { key } if key == last.as_ref().unwrap()), "{error}");
    }
}
