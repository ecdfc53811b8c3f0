//! The machine and the date of the measurements.

use std::time::{SystemTime, UNIX_EPOCH};

use schemars::JsonSchema;
use serde::Serialize;
use sysinfo::{CpuRefreshKind, RefreshKind, System};

/// The machine on which the times were measured.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(crate) struct Machine {
    /// The processor's name, or the architecture where it does not tell.
    pub(super) cpu: String,
    /// The number of logical processors.
    pub(super) cores: usize,
    /// The number of threads of this run.
    pub(super) threads: usize,
}

impl Machine {
    pub(super) fn of_this_run() -> Self {
        let wanted = RefreshKind::nothing().with_cpu(CpuRefreshKind::nothing());
        let system = System::new_with_specifics(wanted);
        let brand = system.cpus().first().map_or("", |cpu| cpu.brand().trim());
        Self {
            cpu: if brand.is_empty() { std::env::consts::ARCH } else { brand }.to_owned(),
            cores: system.cpus().len(),
            threads: rayon::current_num_threads(),
        }
    }

    /// Returns a one-line description of the machine.
    pub(super) fn phrase(&self) -> String {
        format!("{}, {} cores, {} available threads", self.cpu, self.cores, self.threads)
    }
}

/// Returns today's date in UTC as YYYY-MM-DD.
pub(super) fn today() -> String {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    date_of_day(since.as_secs() / 86_400)
}

/// Returns the date of a day counted from 1970-01-01.
///
/// Years are counted from March, so that the leap day is the last day of a year: day `d` of a year
/// is in month `(5 d + 2)/153`, because any five months that start in March or August have 153
/// days.
fn date_of_day(day: u64) -> String {
    /// Days from 0000-03-01 to 1970-01-01.
    const TO_EPOCH: u64 = 719_468;
    /// Days in 400 years.
    const CYCLE: u64 = 146_097;
    let day = day + TO_EPOCH;
    let (cycle, in_cycle) = (day / CYCLE, day % CYCLE);
    // Removes the leap days of every 4, 100 and 400 years.
    let year = (in_cycle - in_cycle / 1460 + in_cycle / 36_524 - in_cycle / (CYCLE - 1)) / 365;
    let in_year = in_cycle - (365 * year + year / 4 - year / 100);
    let from_march = (5 * in_year + 2) / 153;
    let date = in_year - (153 * from_march + 2) / 5 + 1;
    let (month, later) = if from_march < 10 { (from_march + 3, 0) } else { (from_march - 9, 1) };
    format!("{:04}-{month:02}-{date:02}", 400 * cycle + year + later)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates() {
        let known = [
            (0, "1970-01-01"),
            (59, "1970-03-01"),
            (789, "1972-02-29"),
            (790, "1972-03-01"),
            (10_956, "1999-12-31"),
            (11_016, "2000-02-29"),
            (20_000, "2024-10-04"),
            (47_540, "2100-02-28"),
            (47_541, "2100-03-01"),
        ];
        for (day, date) in known {
            assert_eq!(date_of_day(day), date, "day {day}");
        }
    }

    #[test]
    fn every_day_follows_the_one_before() {
        let fields = |day| -> Vec<u64> {
            date_of_day(day).split('-').map(|field| field.parse().unwrap()).collect()
        };
        let lengths = |year: u64| {
            let leap =
                year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
            [31, if leap { 29 } else { 28 }, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31]
        };
        let (mut year, mut month, mut date) = (1970, 1, 1);
        for day in 0..200_000 {
            assert_eq!(fields(day), [year, month, date], "day {day}");
            date += 1;
            if date > lengths(year)[usize::try_from(month - 1).unwrap()] {
                (month, date) = (month + 1, 1);
            }
            if month > 12 {
                (year, month) = (year + 1, 1);
            }
        }
    }
}
