//! The output of `progressive`: records, tables and the chart.

use super::ProgressiveArgs;
use super::chart::chart;
use super::record::{PrefixRecord, ProgressiveBody, SequenceRecord};
use super::reference::Reference;
use super::sequence_errors::SequenceErrors;
use super::study::IntegralErrors;
use crate::error::CliError;
use crate::global::Global;
use crate::plots::Chart;
use crate::report::{Forms, Provenance, csv_of, emit, number, table_of};

/// The errors on all integrals, and what is estimated.
pub(super) struct Results {
    integrals: Vec<IntegralErrors>,
    subject: String,
}

impl Results {
    pub(super) fn new(integrals: Vec<IntegralErrors>, subject: String) -> Self {
        Self { integrals, subject }
    }

    /// Writes the results in the requested form.
    pub(super) fn emit(self, args: &ProgressiveArgs, global: &Global) -> Result<(), CliError> {
        let provenance = Provenance::new(&global.session, global.seed);
        let text = self.text();
        let chart = self.chart();
        let body = self.body();
        let forms = Forms {
            csv: &|| csv_of(&provenance, &body.rows),
            chart: Some(&|| Ok(chart.clone())),
            text: &|| text.clone(),
        };
        emit(args.out.out.as_deref(), global, &provenance, &body, &forms)
    }
}

impl Results {
    fn body(self) -> ProgressiveBody {
        let mut body =
            ProgressiveBody { rows: Vec::new(), sequences: Vec::new(), reference: Vec::new() };
        for IntegralErrors { name, sequences, reference } in self.integrals {
            body.reference.extend(reference.records(&name.name));
            for SequenceErrors { rows, summary, .. } in sequences {
                body.rows.extend(rows);
                body.sequences.push(summary);
            }
        }
        body
    }

    /// Returns the chart of the main integral.
    fn chart(&self) -> Chart {
        let main = self.integrals.iter().find(|integral| integral.name.is_main);
        let (sequences, reference) = main
            .map_or((&[][..], None), |integral| (&*integral.sequences, Some(&integral.reference)));
        chart(sequences, reference, &self.subject)
    }

    fn are_listed(&self) -> bool {
        self.integrals.iter().flat_map(|i| &i.sequences).all(|s| s.prefixes.are_listed)
    }

    fn text(&self) -> String {
        let mut text = String::new();
        for integral in &self.integrals {
            let label = integral.name.label.as_ref();
            let of_label = label.map_or(String::new(), |label| format!(", {label}"));
            text += &format!("Standard errors of {}{of_label}\n\n", self.subject);
            text += &tables(integral, self.are_listed());
        }
        text + &self.explanation()
    }

    /// Returns what the columns mean.
    fn explanation(&self) -> String {
        let mut summaries = self.integrals.iter().flat_map(|i| &i.sequences).map(|s| &s.summary);
        let first_n = summaries.clone().map(|s| s.first_n).min().unwrap_or(1);
        let basis = match summaries.any(|s| s.basis == "measured") {
            true => "predicted or, without a prediction, measured",
            false => "predicted",
        };
        let mut text =
            format!("rate: exponent b of the {basis} variance ~ N^b, from N = {first_n}.\n");
        let reference = self.integrals.iter().map(|integral| &integral.reference);
        let name = reference.clone().find_map(Reference::name);
        let has_factors =
            self.integrals.iter().flat_map(|i| &i.sequences).any(|s| s.summary.factors > 0);
        if let Some((name, counts)) =
            name.zip(reference.map(|r| &r.counts).next()).filter(|_| has_factors)
        {
            let compared = counts.iter().filter(|n| **n >= first_n).count();
            let which = match self.are_listed() {
                true => "the listed N".to_owned(),
                false => format!("{compared} of the N"),
            };
            text += &format!(
                "factor: standard error divided by that of {name} with N points,\n\
                 or the most below that it has; mean and worst over {which} from {first_n}.\n"
            );
        }
        text
    }
}

/// Returns the tables of one integral, its remarks, and the sequence with the least mean factor.
fn tables(integral: &IntegralErrors, are_listed: bool) -> String {
    let sequences = &integral.sequences;
    let name = integral.reference.name();
    let rows = sequences.iter().flat_map(|sequence| sequence.in_table(sequences.len()));
    let mut text = table_of(&PrefixRecord::columns(name.is_some()), rows);
    text.push('\n');
    let summaries = || sequences.iter().map(|sequence| &sequence.summary);
    text += &table_of(&SequenceRecord::columns(name.is_some()), summaries());
    text.push('\n');
    for SequenceRecord { label, remark, .. } in summaries() {
        text.extend(remark.map(|remark| format!("{label}: {remark}.\n")));
    }
    let factors = summaries().filter_map(|s| Some((s, s.mean_factor?, s.worst_factor?)));
    let best = factors.min_by(|a, b| a.1.total_cmp(&b.1));
    if let (Some((best, mean, worst)), Some(name)) = (best, name) {
        let SequenceRecord { label, factors, first_n, n, worst_n, .. } = best;
        let mean = format!("{label}, {} times the standard error of {name}", number::ratio(mean));
        let at = match are_listed {
            true => format!("the listed N from {first_n}"),
            false => format!("{factors} numbers of points from {first_n} to {n}"),
        };
        text += &match (factors, worst_n) {
            (1, Some(n)) => format!("Least factor: {mean} at N = {n}.\n"),
            _ => {
                let worst = number::ratio(worst);
                format!("Least mean factor: {mean};\nat most {worst} times at {at}.\n")
            }
        };
    }
    text
}
