//! The answer as table, JSON, CSV and plot.

use super::args::ChooseArgs;
use super::benefit::benefit;
use super::candidate::MAX_FACTOR;
use super::chart::chart;
use super::crossings;
use super::question::{Question, Requested};
use super::ranking::Ranking;
use super::recommendation::recommendation;
use super::record::{CandidateRecord, ChoiceBody, LeftOut};
use super::row::{Row, SAME_ERROR, distinct, recommended};
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
        let provenance = Provenance::new(&global.session, global.seed);
        let forms = Forms {
            csv: &|| csv_of(&provenance, &self.body.rows),
            chart: Some(&|| {
                let Ranking { question, rows, white_variance, .. } = &self.rankings[0];
                Ok(chart(question, rows, *white_variance))
            }),
            text: &|| self.text(args.samplers.list().is_some()),
        };
        emit(args.out.out.as_deref(), global, &provenance, &self.body, &forms)
    }

    /// Returns the answer in words; rows that the user names, `is_named`, are all shown.
    fn text(&self, is_named: bool) -> String {
        let body = &self.body;
        // The table of the first ranking comes last, above what is said about it.
        let tables = self.rankings.iter().rev();
        let mut text: String = tables.map(|ranking| table(ranking, is_named)).collect();
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
        text += &left_out(&body.left_out);
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

/// Returns a line for each reason why samplers were not considered.
fn left_out(all: &[LeftOut]) -> String {
    let mut reasons: Vec<&str> = Vec::new();
    for left in all {
        if !reasons.contains(&&*left.reason) {
            reasons.push(&left.reason);
        }
    }
    let line = |reason: &str| {
        let of_reason = all.iter().filter(|left| left.reason == reason);
        let labels: Vec<&str> = of_reason.map(|left| &*left.label).collect();
        format!("Not considered: {} ({reason})\n", labels.join(", "))
    };
    reasons.into_iter().map(line).collect()
}

/// Returns the heading and the table of the candidates within reach. Unless `is_named`, one row stands
/// for all patterns that buy nothing with a density.
fn table(ranking: &Ranking<'_>, is_named: bool) -> String {
    let Ranking { question, rows, .. } = ranking;
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
    let shown: Vec<(&Row, usize)> = if is_named {
        rows.iter().map(|row| (row, 0)).collect()
    } else {
        distinct(rows, recommended(rows, question))
    };
    let shown = || shown.iter().filter(|(row, _)| row.record.n.is_some());
    let mut reached: Vec<&CandidateRecord> = shown().map(|(row, _)| &row.record).collect();
    if !reached.is_empty() {
        let n_more = reached.len().saturating_sub(MAX_ROWS);
        reached.truncate(MAX_ROWS);
        text += &table_of(&CandidateRecord::columns(question, &reached), reached);
        if n_more > 0 {
            text += &format!("({n_more} more: --json or -o FILE.csv)\n");
        }
        for (row, n_others) in shown().take(MAX_ROWS).filter(|(_, n_others)| *n_others > 0) {
            let (warp, percent) = (row.warp.as_deref().unwrap_or_default(), 100.0 * SAME_ERROR);
            let patterns = if *n_others == 1 { "pattern has" } else { "patterns have" };
            text += &format!(
                "({n_others} other {patterns} the same error with {warp}, that of independent points \
                 to {percent} %)\n"
            );
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
