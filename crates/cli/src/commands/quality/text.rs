//! The table of `quality` for a terminal.

use std::collections::BTreeSet;

use sphvar_spectrum::quality::Measure;

use super::Measured;
use super::record::{QualityRecord, Tails};
use crate::report::{number, table};

/// Returns the table of measures, with a column or two for each sampler or file, and the remarks.
pub(super) fn text(measured: &[Measured], records: Vec<&QualityRecord>) -> String {
    let single = measured.len() == 1;
    let mut heading = vec!["measure".to_owned()];
    for m in measured {
        if single {
            heading.push("value".to_owned());
        }
        heading.push(if single { "scaled".to_owned() } else { m.source.name.clone() });
    }
    heading.extend(["scale", "hexagonal", "white noise"].map(str::to_owned));
    let mut rows = vec![counts(measured, single)];
    for measure in Measure::ALL {
        rows.push(measure_row(measure, measured, single));
    }
    let mut text = String::new();
    if let [only] = measured {
        text += &format!("{}, {}\n", only.source.name, only.domain().name());
    }
    let heading: Vec<&str> = heading.iter().map(String::as_str).collect();
    text += &table(&heading, rows, 1);
    text.push('\n');

    let mut heading = vec!["property"];
    heading.extend(records.iter().map(|r| if single { "value" } else { r.sampler() }));
    text += &table(&heading, properties(&records), 1);
    for record in &records {
        for remark in &record.remarks {
            let of = if single { String::new() } else { format!("{}: ", record.sampler()) };
            text += &format!("{of}{remark}\n");
        }
    }
    text
}

fn counts(measured: &[Measured], single: bool) -> Vec<String> {
    let mut row = vec!["points N".to_owned()];
    for m in measured {
        row.push(m.n_points().to_string());
        if single {
            row.push(String::new());
        }
    }
    row.extend([const { String::new() }; 3]);
    row
}

fn measure_row(measure: Measure, measured: &[Measured], single: bool) -> Vec<String> {
    let mut row = vec![measure.name()];
    for m in measured {
        let several = m.quality.sets.len() > 1;
        let shown = |moments: Option<sphvar_spectrum::Moments>| match moments {
            Some(m) if several => number::with_uncertainty(m.mean(), m.standard_error()),
            Some(m) => number::value(m.mean()),
            None => number::MISSING.to_owned(),
        };
        if single {
            row.push(shown(m.quality.moments(|set| measure.value(set))));
        }
        row.push(shown(m.quality.moments(|set| measure.scaled(set))));
    }
    let scale = match measure {
        Measure::RieszEnergy(_) => "constant".to_owned(),
        Measure::MeshRatio => "1".to_owned(),
        Measure::WorstCaseError(1) => "N".to_owned(),
        _ => format!("N^{}", measure.power()),
    };
    let white = measured.first().and_then(|m| {
        let (n, domain) = (m.n_points(), m.domain());
        measure.white_noise(n, domain).map(|value| value * measure.scale(n, domain))
    });
    let white = number::optional(white, number::value);
    row.extend([scale, number::value(measure.hexagonal_limit()), white]);
    row
}

/// Returns the rows of what has no scale.
fn properties(records: &[&QualityRecord]) -> Vec<Vec<String>> {
    let row = |name: String, cell: &dyn Fn(&QualityRecord) -> String| {
        std::iter::once(name).chain(records.iter().map(|r| cell(r))).collect::<Vec<_>>()
    };
    let mut rows = vec![row("exact degree".to_owned(), &|r| r.exact_degree.to_string())];
    let degrees: BTreeSet<usize> =
        records.iter().flat_map(|r| r.condition.keys().copied()).collect();
    for degree in degrees {
        let cell = |r: &QualityRecord| {
            number::optional(r.condition.get(&degree).copied().flatten(), number::value)
        };
        rows.push(row(format!("condition of fits to degree {degree}"), &cell));
    }
    rows.push(row("exponent of low degrees".to_owned(), &|r| {
        let h = &r.hyperuniformity;
        match (h.exponent, h.exponent_interval) {
            (Some(b), interval) => {
                format!("{} ({})", number::rate(b), number::interval(interval, number::rate))
            }
            _ => number::MISSING.to_owned(),
        }
    }));
    rows.push(row("hyperuniformity class".to_owned(), &|r| {
        r.hyperuniformity.class.unwrap_or(number::MISSING).to_owned()
    }));
    let p_value = |name: &str, of: fn(&QualityRecord) -> Option<Tails>| {
        row(format!("p-value by {name}"), &|r| number::optional(of(r), smaller_tail))
    };
    rows.push(p_value("cap discrepancy", |r| r.p_value.cap_discrepancy_l2));
    rows.push(p_value("generalized discrepancy", |r| r.p_value.generalized_discrepancy));
    if records.iter().any(|r| r.rank.is_some()) {
        let place = |name: &str, of: fn(&super::rank::RankRecord) -> usize| {
            row(format!("rank by {name}"), &|r| {
                r.rank.as_ref().map_or(number::MISSING.to_owned(), |rank| {
                    format!("{} of {}", of(rank), rank.of)
                })
            })
        };
        rows.push(place("cap discrepancy", |rank| rank.cap_discrepancy_l2));
        rows.push(place("worst-case error, s = 2", |rank| rank.worst_case_error_2));
    }
    rows
}

/// Returns the probability of the tail that is the smaller one, with the name of the tail. Below
/// 1e-10 the distribution holds in order of magnitude only.
fn smaller_tail(tails: Tails) -> String {
    const RESOLVED: f64 = 1e-10;
    let (end, p) =
        if tails.lower < tails.upper { ("lower", tails.lower) } else { ("upper", tails.upper) };
    match p {
        p if p < RESOLVED => format!("{end} < {RESOLVED:e}"),
        p => format!("{end} {}", number::ratio(p)),
    }
}
