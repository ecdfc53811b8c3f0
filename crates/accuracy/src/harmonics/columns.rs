use crate::reference::{AcuteAngle, LegendreColumn};
use sphvar_sh::{Colatitude, LegendrePlan, Recurrence};

use super::{COLATITUDES, TWICE, documented_bound, orders, trial};
use crate::{Errors, Subject, Trial};

/// Returns trials of all degrees of an order at once, with coefficients computed on the fly and
/// precomputed.
pub(super) fn trials(lmax: usize) -> Vec<Trial> {
    // A column of order lmax has only one value, so orders in between are more informative.
    let [zero, one, half, ..] = orders(lmax);
    let orders = [zero, one, half, lmax - lmax / 4];
    let places: Vec<_> = COLATITUDES
        .into_iter()
        .map(|theta| (theta, Colatitude::from_theta(theta).expect("a colatitude")))
        .collect();
    let columns = Columns { lmax, orders: orders.to_vec(), places, out: Vec::new() };
    let count = columns.len();
    let recurrences = orders.map(|m| Recurrence::new(m, lmax)).to_vec();
    let mut trials = Vec::new();
    let mut add = |method, columns: Columns, fill: Fill| {
        let subject = Filled { columns: Columns { out: vec![0.0; count], ..columns }, fill };
        trials.push(Trial {
            relative_to: "(l + 1)/(lmax + 1) of the local amplitude",
            ..trial(method, format!("l to {lmax}"), count, documented_bound(lmax), TWICE, subject)
        });
    };
    let plan = LegendrePlan::new(lmax).expect("a degree in range");
    add("LegendrePlan", columns.clone(), Fill::Plan(plan));
    add("Recurrence", columns, Fill::Recurrences(recurrences));
    trials
}

/// Columns of several orders at several colatitudes.
#[derive(Clone)]
struct Columns {
    lmax: usize,
    orders: Vec<usize>,
    places: Vec<(f64, Colatitude)>,
    /// By order, then colatitude, then degree.
    out: Vec<f64>,
}

impl Columns {
    fn len(&self) -> usize {
        self.orders.iter().map(|m| (self.lmax + 1 - m) * self.places.len()).sum()
    }
}

enum Fill {
    Plan(LegendrePlan),
    /// One per order.
    Recurrences(Vec<Recurrence>),
}

struct Filled {
    columns: Columns,
    fill: Fill,
}

impl Subject for Filled {
    fn run(&mut self) {
        let Columns { lmax, orders, places, out } = &mut self.columns;
        let mut rest = &mut out[..];
        for (i, &m) in orders.iter().enumerate() {
            for &(_, colatitude) in &*places {
                let (column, after) = rest.split_at_mut(*lmax + 1 - m);
                match &self.fill {
                    Fill::Plan(plan) => plan.column_into(m, colatitude, column),
                    Fill::Recurrences(all) => all[i].column_into(colatitude, column),
                }
                rest = after;
            }
        }
    }

    fn errors(&mut self) -> Errors {
        let Columns { lmax, orders, places, out } = &self.columns;
        let mut errors = Errors::default();
        let mut values = out.iter();
        for &m in orders {
            for &(theta, _) in places {
                let exact = LegendreColumn::new(m as u64, AcuteAngle::from_theta(theta));
                for ((l, exact), &got) in (m..=*lmax).zip(exact).zip(values.by_ref()) {
                    // Lower degrees have a stricter documented bound.
                    let weight = (*lmax as f64 + 1.0) / (l as f64 + 1.0);
                    let error = exact.error_in_f64(got) * weight;
                    errors.push(error, || format!("l = {l}, m = {m}, theta = {theta:?}"));
                }
            }
        }
        errors
    }
}
