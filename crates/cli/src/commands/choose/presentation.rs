//! The answer as table, JSON, CSV and plot.

use super::args::ChooseArgs;
use super::benefit::benefit;
use super::candidate::MAX_FACTOR;
use super::chart::chart;
use super::crossings;
use super::question::{Question, Requested};
use super::ranking::Ranking;
use super::recommendation::recommendation;
use super::record::{CandidateRecord, ChoiceBody};
use crate::error::CliError;
use crate::global::Global;
use crate::report::{Forms, Provenance, csv_of, emit, number, table_of};

/// The maximum number of rows of a table.
const MAX_ROWS: usize = 40;

/// The complete answer.
pub(super) struct Answer<'a> {
    /// The main ranking first.
    rankings: Vec<Ranking<'a>>,
    body: ChoiceBody,
}

impl<'a> Answer<'a> {
    /// Returns the answer from rankings, of which the first decides.
    pub(super) fn new(mut rankings: Vec<Ranking<'a>>, seed: u64) -> Result<Self, CliError> {
        let rows = rankings.iter().flat_map(|ranking| &ranking.rows);
        let rows = rows.map(|row| row.record.clone()).collect();
        let ranking = &mut rankings[0];
        let (reason, recommendation) = recommendation(ranking)?;
        let question = &ranking.question;
        let (error_requested, points_requested, max_points) = match question.requested {
            Requested::Error { standard_error, max_points, .. } => {
                (Some(standard_error), None, Some(max_points))
            }
            Requested::Points(n) => (None, Some(n), None),
        };
        let body = ChoiceBody {
            integrand: question.integrand.clone(),
            domain: ranking.domain.clone(),
            integral: question.integral,
            error_requested,
            points_requested,
            max_points,
            cost_per_sample: question.cost_per_sample,
            white_noise_points: ranking.white_noise_points,
            rows,
            left_out: std::mem::take(&mut ranking.left_out),
            crossovers: crossings::between(&ranking.rows, seed),
            reason,
            density_benefit: benefit(ranking),
            recommendation,
        };
        Ok(Self { rankings, body })
    }

    /// Writes and prints the answer in the requested form.
    pub(super) fn emit(&self, args: &ChooseArgs, global: &Global) -> Result<(), CliError> {
        let provenance = Provenance::new(global.seed);
        let forms = Forms {
            csv: &|| csv_of(&provenance, &self.body.rows),
            chart: Some(&|| {
                let Ranking { question, rows, white_variance, .. } = &self.rankings[0];
                Ok(chart(question, rows, *white_variance))
            }),
            text: &|| self.text(),
        };
        emit(args.out.out.as_deref(), global, &provenance, &self.body, &forms)
    }

    fn text(&self) -> String {
        let body = &self.body;
        let (mut text, mut rows) = (String::new(), &*body.rows);
        // The table of the first ranking comes last, above what is said about it.
        let mut tables = Vec::new();
        for ranking in &self.rankings {
            let (own, others) = rows.split_at(ranking.rows.len());
            tables.push(table(&ranking.question, own));
            rows = others;
        }
        tables.reverse();
        text += &tables.concat();
        let question = &self.rankings[0].question;
        let own = &body.rows[..self.rankings[0].rows.len()];
        let (reached, out_of_reach): (Vec<&CandidateRecord>, Vec<&CandidateRecord>) =
            own.iter().partition(|row| row.n.is_some());
        if !reached.is_empty() {
            text += &explanation(question);
        }
        if let (Requested::Error { max_points, .. }, false) =
            (&question.requested, out_of_reach.is_empty())
        {
            let is_behind = |row: &&CandidateRecord| row.basis == "behind";
            let (behind, beyond): (Vec<&CandidateRecord>, Vec<&CandidateRecord>) =
                out_of_reach.into_iter().partition(is_behind);
            let names = |rows: &[&CandidateRecord]| {
                rows.iter().map(|row| &*row.label).collect::<Vec<_>>().join(", ")
            };
            if !behind.is_empty() {
                text += &format!(
                    "More than {MAX_FACTOR} times the points of the best required: {}\n",
                    names(&behind)
                );
            }
            if !beyond.is_empty() {
                text += &format!(
                    "Out of reach with {max_points} points (--max-count): {}\n",
                    names(&beyond)
                );
            }
        }
        let empty = |row: &CandidateRecord| {
            let last = row.last_empty_degree.filter(|&last| last > 0)?;
            Some(format!("{} {last}", row.label))
        };
        let empty: Vec<String> = own.iter().filter_map(empty).collect();
        if !empty.is_empty() {
            text += &format!("Largest degree without power: {}\n", empty.join(", "));
        }
        for left in &body.left_out {
            text += &format!("Not considered: {} ({})\n", left.label, left.reason);
        }
        for crossing in body.crossovers.iter().filter(|c| c.matters()).take(8) {
            text += &crossing.crossover.line();
        }
        text += &body.recommendation;
        text += "\n";
        if let Some(benefit) = &body.density_benefit {
            text += &format!("{}\n", benefit.sentence);
        }
        text
    }
}

/// Returns the heading and the table of the candidates within reach.
fn table(question: &Question, rows: &[CandidateRecord]) -> String {
    let mut text = match &question.requested {
        Requested::Error { text, standard_error, .. } => {
            let requested = match question.integral {
                Some(integral) if question.relative(*standard_error).is_some() => {
                    format!(
                        "{text}, {} of the {} {}",
                        number::value(*standard_error),
                        question.quantity,
                        number::value(integral)
                    )
                }
                _ => text.clone(),
            };
            format!("Points for a standard error of {requested}: {}\n\n", question.integrand)
        }
        Requested::Points(n) => {
            format!("Standard errors with about {n} points: {}\n\n", question.integrand)
        }
    };
    let mut reached: Vec<&CandidateRecord> = rows.iter().filter(|row| row.n.is_some()).collect();
    if !reached.is_empty() {
        let n_more = reached.len().saturating_sub(MAX_ROWS);
        reached.truncate(MAX_ROWS);
        text += &table_of(&CandidateRecord::columns(question, &reached), reached);
        if n_more > 0 {
            text += &format!("({n_more} more: --json or -o FILE.csv)\n");
        }
        text += "\n";
    }
    text
}

/// Returns the meaning of the columns.
fn explanation(question: &Question) -> String {
    let relative = if question.integral.is_some() { ", relative to it" } else { "" };
    let error = match question.quantity {
        "irradiance" => format!(
            "standard error of the irradiance, its root mean square over all normals{relative}; +-:\nits uncertainty"
        ),
        quantity => format!("one standard error of the {quantity}{relative}; +-: its uncertainty"),
    };
    format!(
        "error: {error}. reduction: variance of white\n\
         noise with the same number of points divided by this one. rate: exponent of the variance\n\
         against N near this N.\n\n"
    )
}

/// Returns a line for one row, printed before all are known.
pub(super) fn line(record: &CandidateRecord) -> String {
    let CandidateRecord { label, basis, .. } = record;
    match record.n {
        Some(_) => {
            let error = record.error_text(record.relative_error.or(record.error));
            format!("{label:<28} N = {:<8} error {error}", record.count())
        }
        None => format!("{label:<28} {basis}"),
    }
}
