//! The JSON schema of all documents of `--json`, which is generated from their types. A test
//! compares it with the file in the repository.

use std::path::Path;

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde_json::{Value, json};

use crate::commands::accuracy::record::AccuracyBody;
use crate::commands::audit::report::AuditBody;
use crate::commands::bounds::BoundsBody;
use crate::commands::choose::record::ChoiceBody;
use crate::commands::compare::record::ComparisonBody;
use crate::commands::eval::{CapBody, HarmonicBody, LegendreBody, ProfileBody};
use crate::commands::fit::FitBody;
use crate::commands::fixed_orientation::FixedOrientationBody;
use crate::commands::healpix::HealpixBody;
use crate::commands::integrate::IntegrateBody;
use crate::commands::lights::LightsBody;
use crate::commands::list::ListBody;
use crate::commands::over_rotations::OverRotationsBody;
use crate::commands::plan::status::StatusBody;
use crate::commands::plan::{Manifest, PlanBody};
use crate::commands::progressive::record::ProgressiveBody;
use crate::commands::quality::QualityBody;
use crate::commands::quality::square_record::SquareQualityBody;
use crate::commands::render::sheet::SheetBody;
use crate::commands::render::single::RenderBody;
use crate::commands::render::study::StudyBody;
use crate::commands::reproduce::ReproductionBody;
use crate::commands::rotations::measures::MeasuresBody;
use crate::commands::rotations::sets::RotationSetsBody;
use crate::commands::sample::realized_sets::SampleBody;
use crate::commands::spectrum::report::SpectrumBody;
use crate::commands::spectrum::square_report::SquareSpectrumBody;
use crate::commands::variance::VarianceBody;
use crate::commands::weights::WeightsBody;
use crate::report::Document;
use crate::run_log::LogLine;
use crate::shards::PartBody;

/// The variable that makes the test write the file instead of comparing it.
const WRITE: &str = "SPHVAR_WRITE_SCHEMA";

/// Returns the schema of a document with a body of type `T`.
fn document<T: JsonSchema + 'static>(generator: &mut SchemaGenerator) -> Schema {
    let mut schema = Document::<'static, T>::json_schema(generator);
    if let Some(description) = T::json_schema(generator).get("description") {
        schema.insert("description".to_owned(), description.clone());
    }
    schema
}

/// Returns every document under the words of its command.
fn documents(generator: &mut SchemaGenerator) -> Vec<(&'static str, Schema)> {
    vec![
        ("--shard", document::<PartBody>(generator)),
        ("accuracy", document::<AccuracyBody>(generator)),
        ("audit", document::<AuditBody>(generator)),
        ("bounds", document::<BoundsBody>(generator)),
        ("choose", document::<ChoiceBody>(generator)),
        ("compare", document::<ComparisonBody>(generator)),
        ("eval cap-power", document::<CapBody>(generator)),
        ("eval legendre", document::<LegendreBody>(generator)),
        ("eval profile", document::<ProfileBody>(generator)),
        ("eval ylm", document::<HarmonicBody>(generator)),
        ("fit", document::<FitBody>(generator)),
        ("healpix", document::<HealpixBody<'static, f64, 1>>(generator)),
        ("integrate", document::<IntegrateBody>(generator)),
        ("lights", document::<LightsBody>(generator)),
        ("list", document::<ListBody>(generator)),
        ("plan", document::<PlanBody>(generator)),
        ("plan status", document::<StatusBody>(generator)),
        ("progressive", document::<ProgressiveBody>(generator)),
        ("quality", document::<QualityBody>(generator)),
        ("quality --square", document::<SquareQualityBody>(generator)),
        ("render", document::<RenderBody>(generator)),
        ("render --sheet", document::<SheetBody>(generator)),
        ("render --study", document::<StudyBody>(generator)),
        ("reproduce", document::<ReproductionBody>(generator)),
        ("rotations", document::<MeasuresBody>(generator)),
        ("rotations -o", document::<RotationSetsBody>(generator)),
        ("sample", document::<SampleBody<[f64; 3]>>(generator)),
        ("spectrum", document::<SpectrumBody>(generator)),
        ("spectrum --square", document::<SquareSpectrumBody>(generator)),
        ("variance", document::<VarianceBody>(generator)),
        ("variance --no-rotate", document::<FixedOrientationBody>(generator)),
        ("variance --rotations", document::<OverRotationsBody>(generator)),
        ("weights", document::<WeightsBody>(generator)),
    ]
}

fn schema() -> Value {
    let mut generator = SchemaSettings::draft2020_12().for_serialize().into_generator();
    let documents = documents(&mut generator);
    let files = json!({
        "manifest.json of plan": Manifest::json_schema(&mut generator),
        "lines of --log": LogLine::json_schema(&mut generator),
    });
    let mut definitions = generator.take_definitions(true);
    definitions.sort_keys();
    let documents =
        documents.into_iter().map(|(name, schema)| (name.to_owned(), schema.to_value()));
    let mut schema = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Documents of sphvar",
        "description": "What `sphvar COMMAND --json` prints. Every document is described under `documents` by the \
            name of its command. Numbers that cannot be given are null. Keys may be added. Other files that scripts may read \
            are under `files`.",
        "documents": documents.collect::<serde_json::Map<_, _>>(),
        "files": files,
        "$defs": definitions,
    });
    unwrap_descriptions(&mut schema);
    schema
}

/// Removes the line breaks of comments.
fn unwrap_descriptions(schema: &mut Value) {
    match schema {
        Value::Object(map) => {
            for (key, value) in map {
                match value {
                    Value::String(text) if key == "description" => *text = text.replace('\n', " "),
                    other => unwrap_descriptions(other),
                }
            }
        }
        Value::Array(list) => list.iter_mut().for_each(unwrap_descriptions),
        _ => (),
    }
}

#[test]
fn the_schema_in_docs_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/schema.json");
    let text = serde_json::to_string_pretty(&schema()).unwrap() + "\n";
    if std::env::var_os(WRITE).is_some() {
        std::fs::write(path, text).unwrap();
        return;
    }
    let stored = std::fs::read_to_string(path).unwrap_or_default();
    assert!(
        stored == text,
        "docs/schema.json is not that of the types; `just schema` or {WRITE}=1 cargo test -p sphvar-cli --lib \
         schema writes it"
    );
}

/// Every field of every document has a description.
#[test]
fn every_field_is_described() {
    let mut bare = Vec::new();
    collect_bare("", &schema(), &mut bare);
    assert!(bare.is_empty(), "{bare:#?}");
}

/// Collects the paths of properties without a description.
fn collect_bare(path: &str, schema: &Value, bare: &mut Vec<String>) {
    let Some(map) = schema.as_object() else { return };
    for (key, value) in map {
        let path = format!("{path}/{key}");
        if key == "properties" {
            let properties = value.as_object().into_iter().flatten();
            let bare_here = properties.filter(|(_, p)| p["description"].as_str().is_none());
            bare.extend(bare_here.map(|(name, _)| format!("{path}/{name}")));
        }
        collect_bare(&path, value, bare);
    }
}
