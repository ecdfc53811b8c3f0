//! Measures the time of a run.

use std::time::Instant;

use sphvar_accuracy::{Effort, Subject};

/// The minimum total time of all runs, in seconds.
const MIN_SECONDS: f64 = 0.1;

/// Returns the median of the times of several runs, in seconds.
///
/// One untimed run comes first and brings code and memory into the caches.
pub(super) fn median_seconds(subject: &mut dyn Subject, effort: Effort) -> f64 {
    let min_calls = match effort {
        Effort::Quick => 3,
        Effort::Full => 5,
    };
    subject.run();
    let mut times: Vec<f64> = Vec::new();
    let begin = Instant::now();
    while times.len() < min_calls || begin.elapsed().as_secs_f64() < MIN_SECONDS {
        let start = Instant::now();
        subject.run();
        times.push(start.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use sphvar_accuracy::Errors;

    use super::*;

    struct Sleeper {
        runs: u32,
        millis: u64,
    }

    impl Subject for Sleeper {
        fn run(&mut self) {
            self.runs += 1;
            // The first of the timed runs is an outlier.
            let millis = if self.runs == 2 { 20 * self.millis } else { self.millis };
            std::thread::sleep(Duration::from_millis(millis));
        }

        fn errors(&mut self) -> Errors {
            Errors::default()
        }
    }

    #[test]
    fn enough_runs_are_timed_without_outliers() {
        let mut long = Sleeper { runs: 0, millis: 40 };
        let seconds = median_seconds(&mut long, Effort::Full);
        assert_eq!(long.runs, 6);
        assert!((0.04..0.8).contains(&seconds), "{seconds}");
        let mut short = Sleeper { runs: 0, millis: 1 };
        assert!(median_seconds(&mut short, Effort::Quick) >= 0.001);
        assert!(short.runs > 4, "{}", short.runs);
    }
}
