//! A record has the same numbers in CSV as in JSON.

use serde_json::Value;

use crate::outcome::same;
use crate::workplace::Workplace;

/// Returns the value of a record that a CSV column shows: that of its name, or an end of an
/// interval.
fn value<'a>(record: &'a Value, column: &str) -> Option<&'a Value> {
    let end = |suffix: &str, end: usize| {
        let stem = column.strip_suffix(suffix)?;
        let key = [format!("{stem}interval"), stem.trim_end_matches('_').to_owned()];
        let interval = key.iter().find_map(|key| record.get(key))?;
        Some(if interval.is_null() { interval } else { &interval[end] })
    };
    record.get(column).or_else(|| end("low", 0)).or_else(|| end("high", 1))
}

fn assert_cell(cell: &str, value: &Value, what: &str) {
    let is_same = match value {
        Value::Null => cell.is_empty(),
        Value::Number(number) => cell.parse().is_ok_and(|x: f64| same(x, number.as_f64().unwrap())),
        Value::String(text) => cell == text,
        Value::Bool(holds) => cell == holds.to_string(),
        Value::Array(items) => {
            cell == items.iter().map(Value::to_string).collect::<Vec<_>>().join(" ")
        }
        Value::Object(_) => false,
    };
    assert!(is_same, "{what}: {cell:?} in CSV, {value} in JSON");
}

#[test]
fn csv_has_what_json_has() {
    let place = Workplace::new();
    let study =
        "render cornell --study --samplers jittered --size 6 --reference-count 150 --cache none";
    for (arguments, key, only_in_json) in [
        ("variance jittered -n 12,48 --integrand cap:degrees=60 -m 20", "rows", &[][..]),
        ("variance white-noise -n 12 --integrand vmf:kappa=1e6 -m 10", "rows", &[]),
        (
            "choose --integrand cap:degrees=60 --error 5% --samplers jittered,healpix",
            "rows",
            &["curve"],
        ),
        ("bounds jittered -n 48 -m 30 --integrand ylm:l=2", "bounds", &[]),
        ("bounds --profile step -n 5", "bounds", &[]),
        (&format!("{study} -n 6,24 -m 3"), "rows", &[]),
    ] {
        let document = place.run(&format!("{arguments} --json -o table.csv")).json();
        let text = place.text("table.csv");
        assert!(text.starts_with("# sphvar "), "{text}");
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
        let columns = reader.headers().unwrap().clone();
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        let records = document[key].as_array().unwrap();
        assert_eq!(rows.len(), records.len(), "{arguments}");
        for (row, record) in rows.iter().zip(records) {
            for (column, cell) in columns.iter().zip(row) {
                let value = value(record, column).unwrap_or_else(|| panic!("{column}: {record}"));
                assert_cell(cell, value, &format!("{arguments}, {column}"));
            }
            let intervals = record.as_object().unwrap().values().filter(|v| is_interval(v)).count();
            let expected = record.as_object().unwrap().len() + intervals - only_in_json.len();
            // A null value does not show that a field is an interval.
            assert!(columns.len() >= expected, "{arguments}: {columns:?}, {record}");
        }
    }
}

fn is_interval(value: &Value) -> bool {
    value.as_array().is_some_and(|ends| ends.len() == 2 && ends.iter().all(Value::is_f64))
}
