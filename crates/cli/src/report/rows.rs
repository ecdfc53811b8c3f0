//! Records as CSV. Names and order of the columns come from the type that JSON is written from, so
//! the two always agree.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::Serialize;
use serde_json::Value;

use super::{Provenance, full};
use crate::error::CliError;

/// A column of the CSV form of a record.
#[derive(Debug, PartialEq, Eq)]
struct Field {
    name: String,
    /// The key in JSON.
    key: String,
    /// The end of an interval, if the column is one.
    end: Option<usize>,
}

/// Returns CSV with the provenance as a comment, a heading and a row for each record.
///
/// Every field of the record is a column. An interval has two columns (`low` and `high` instead of
/// `interval`); a list of numbers or words has one, separated by spaces. Fields that are records
/// are omitted and appear in JSON only.
pub(crate) fn csv_of<'r, R: Serialize + JsonSchema + 'r>(
    provenance: &Provenance,
    records: impl IntoIterator<Item = &'r R>,
) -> Result<String, CliError> {
    Ok(format!("# {}\n{}", provenance.line(), csv_rows(records)?))
}

/// Returns the same without columns of fields that no record writes in JSON.
pub(crate) fn csv_of_present<R: Serialize + JsonSchema>(
    provenance: &Provenance,
    records: &[R],
) -> Result<String, CliError> {
    let values = records.iter().map(serde_json::to_value).collect::<Result<Vec<Value>, _>>();
    let values = values.map_err(CliError::failed)?;
    let is_present =
        |f: &Field| values.is_empty() || values.iter().any(|v| v.get(&f.key).is_some());
    let fields: Vec<Field> = fields::<R>().into_iter().filter(is_present).collect();
    Ok(format!("# {}\n{}", provenance.line(), rows_of(&fields, &values)))
}

/// Returns the same without the comment.
pub(crate) fn csv_rows<'r, R: Serialize + JsonSchema + 'r>(
    records: impl IntoIterator<Item = &'r R>,
) -> Result<String, CliError> {
    let values = records.into_iter().map(serde_json::to_value).collect::<Result<Vec<Value>, _>>();
    Ok(rows_of(&fields::<R>(), &values.map_err(CliError::failed)?))
}

fn rows_of(fields: &[Field], records: &[Value]) -> String {
    let mut rows = vec![fields.iter().map(|field| field.name.clone()).collect()];
    rows.extend(records.iter().map(|r| fields.iter().map(|field| field.cell(r)).collect()));
    written(&rows)
}

/// Returns CSV with the provenance as a comment, a heading and rows of cells, for data without a
/// record type.
pub(crate) fn csv(provenance: &Provenance, heading: &str, rows: &[Vec<String>]) -> String {
    format!("# {}\n{heading}\n{}", provenance.line(), written(rows))
}

fn written(rows: &[Vec<String>]) -> String {
    // In flexible mode, no write to memory fails: rows of different lengths are the only error.
    let mut writer = csv::WriterBuilder::new().flexible(true).from_writer(Vec::new());
    let written = rows.iter().try_for_each(|row| writer.write_record(row));
    let text = written.ok().and_then(|()| writer.into_inner().ok()).map(String::from_utf8);
    text.and_then(Result::ok).expect("text in memory can be written")
}

impl Field {
    fn cell(&self, record: &Value) -> String {
        let value = &record[&self.key];
        cell(self.end.map_or(value, |end| &value[end]))
    }
}

fn cell(value: &Value) -> String {
    match value {
        Value::Null | Value::Object(_) => String::new(),
        Value::Bool(holds) => holds.to_string(),
        Value::Number(number) if number.is_f64() => number.as_f64().map_or(String::new(), full),
        Value::Number(number) => number.to_string(),
        Value::String(text) => text.clone(),
        Value::Array(items) => items.iter().map(cell).collect::<Vec<_>>().join(" "),
    }
}

/// Returns the columns of a record type; no record is needed.
fn fields<R: JsonSchema>() -> Vec<Field> {
    let settings = SchemaSettings::draft2020_12()
        .for_serialize()
        .with(|settings| settings.inline_subschemas = true);
    let schema = settings.into_generator().into_root_schema_for::<R>();
    let properties = schema.get("properties").and_then(Value::as_object);
    properties.into_iter().flatten().flat_map(|(key, schema)| fields_of(key, schema)).collect()
}

fn fields_of(key: &str, schema: &Value) -> Vec<Field> {
    let field = |name: String, end| Field { name, key: key.to_owned(), end };
    let is_interval = schema["maxItems"] == 2;
    if is_interval {
        let stem = key.strip_suffix("interval").map_or(format!("{key}_"), str::to_owned);
        return vec![field(format!("{stem}low"), Some(0)), field(format!("{stem}high"), Some(1))];
    }
    let is_record = |schema: &Value| {
        let of_object = |schema: &Value| is_of_type(schema, "object");
        of_object(schema) || schema["anyOf"].as_array().is_some_and(|of| of.iter().any(of_object))
    };
    if is_record(schema) || is_record(&schema["items"]) {
        return Vec::new();
    }
    vec![field(key.to_owned(), None)]
}

fn is_of_type(schema: &Value, name: &str) -> bool {
    match &schema["type"] {
        Value::String(only) => only == name,
        Value::Array(names) => names.iter().any(|one| one == name),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Serialize, JsonSchema)]
    struct Inner {
        z: f64,
        a: Option<u64>,
    }

    #[derive(Serialize, JsonSchema)]
    struct Outer {
        name: String,
        #[serde(flatten)]
        inner: Inner,
        rate_interval: Option<(f64, f64)>,
        interval: (f64, f64),
        degrees: Vec<usize>,
        parts: Vec<Inner>,
        part: Option<Inner>,
        #[serde(skip_serializing_if = "Option::is_none")]
        sum: Option<f64>,
        holds: Option<bool>,
    }

    fn outer(name: &str, interval: Option<(f64, f64)>) -> Outer {
        Outer {
            name: name.to_owned(),
            inner: Inner { z: f64::NAN, a: Some(u64::MAX) },
            rate_interval: interval,
            interval: (0.5, f64::INFINITY),
            degrees: vec![1, 2],
            parts: vec![Inner { z: 1.0, a: None }],
            part: None,
            sum: None,
            holds: Some(true),
        }
    }

    #[test]
    fn columns_follow_the_fields() {
        let records = [outer("a,\"b\"", Some((-2.0, 1e-7))), outer("c", None)];
        let expected = "\
name,z,a,rate_low,rate_high,low,high,degrees,sum,holds
\"a,\"\"b\"\"\",,18446744073709551615,-2e0,1e-7,5e-1,,1 2,,true
c,,18446744073709551615,,,5e-1,,1 2,,true
";
        assert_eq!(csv_rows(&records).unwrap(), expected);
        let heading = expected.lines().next().unwrap();
        assert_eq!(csv_rows::<Outer>(&[]).unwrap(), format!("{heading}\n"));
        let provenance = Provenance::of("sphvar x".to_owned(), 3);
        let text = csv_of(&provenance, &records[..1]).unwrap();
        assert!(text.starts_with("# sphvar x (sphvar ") && text.contains(heading), "{text}");
    }
}
