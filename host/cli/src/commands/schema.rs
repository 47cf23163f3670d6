//! `stickslip schema`: what the JSON documents of the commands hold, made from the types that are printed.

use anyhow::bail;
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};
use stickslip_analysis::{check, compare, diagnose, run, score, simulate, suggest, tuning};
use stickslip_data::import::{cmu_push, tribometer};
use stickslip_device::session;
use stickslip_report::terminal::{Output, table};

use super::{board, calibrate, demo, effects, fitted, import, lcp, man, monitor, new, rig};

/// Command line of `stickslip schema`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip schema diagnose
  stickslip schema import recording
  stickslip --json schema compare > compare.schema.json")]
pub struct Args {
    /// Command whose document is described [default: all that print one are listed]
    #[arg(value_name = "COMMAND")]
    command: Vec<String>,
}

/// A command, the name of its document, and what that holds.
struct Document {
    command: &'static str,
    name: String,
    schema: fn() -> Value,
}

fn of<T: JsonSchema>() -> Value {
    let settings =
        SchemaSettings::draft2020_12().for_serialize().with(|settings| settings.inline_subschemas = true);
    settings.into_generator().into_root_schema_for::<T>().to_value()
}

fn documents() -> Vec<Document> {
    let first = |command: &'static str, schema: fn() -> Value| {
        let word = command.split(' ').next().unwrap_or(command);
        Document { command, name: format!("stickslip-{word}/1"), schema }
    };
    vec![
        first("check", of::<check::Report>),
        first("calibrate", of::<Vec<calibrate::Written>>),
        Document {
            command: "compare",
            name: compare::document::SCHEMA.to_owned(),
            schema: of::<compare::document::Comparison>,
        },
        first("diagnose", of::<diagnose::report::Report>),
        first("add", of::<fitted::Written>),
        first("refit", of::<fitted::Written>),
        first("effects", of::<Vec<effects::Effect>>),
        first("effects EFFECT", of::<effects::Effect>),
        first("predictor", of::<Vec<tuning::Table>>),
        first("suggest", of::<suggest::Report>),
        first("replay", of::<run::summary::Document>),
        first("score", of::<score::document::Document>),
        first("stream", of::<session::Outcome>),
        first("monitor", of::<monitor::Summary>),
        first("board", of::<board::Done>),
        first("board info", of::<board::About>),
        first("board selftest", of::<board::Checks>),
        first("board monitor", of::<monitor::Summary>),
        first("simulate", of::<simulate::Report>),
        first("new", of::<new::Report>),
        first("import recording", of::<super::import_recording::RecordingReport>),
        first("import cmu-push", of::<import::Report<cmu_push::Verification>>),
        first("import tribometer", of::<import::Report<tribometer::Verification>>),
        first("rig", of::<rig::Report>),
        first("rig list-effects", of::<Vec<rig::EffectRow>>),
        first("lcp", of::<lcp::Document>),
        first("man", of::<man::Report>),
        first("demo", of::<demo::Report>),
    ]
}

/// As it is printed: the name first, rows of a list under `results`.
fn printed(document: &Document) -> Value {
    let mut schema = (document.schema)();
    let name = json!({ "const": document.name, "description": "Command and version of this document" });
    if schema["type"] == "array" {
        let head = schema.as_object_mut().and_then(|keys| keys.remove("$schema"));
        schema = json!({ "$schema": head, "type": "object", "properties": { "results": schema } });
        schema["properties"]["results"]["description"] = json!("One entry for each");
    }
    if let Some(own) = schema["properties"].as_object_mut() {
        let mut keys = Map::from_iter([("schema".to_owned(), name)]);
        keys.extend(own.clone().into_iter().filter(|(key, _)| key != "schema"));
        *own = keys;
    }
    schema
}

/// # Errors
/// A command that prints no document.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let documents = documents();
    if args.command.is_empty() {
        let mut shown = table(["command", "schema"]);
        for document in &documents {
            shown.add_row([document.command, &document.name]);
        }
        output.table(&shown);
        output.next(["schema", "diagnose"]);
        let names: Map<String, Value> =
            documents.iter().map(|document| (document.command.to_owned(), json!(document.name))).collect();
        return output.document(&names);
    }
    let wanted = args.command.join(" ");
    let Some(document) = documents.iter().find(|document| document.command == wanted) else {
        let known: Vec<&str> = documents.iter().map(|document| document.command).collect();
        bail!("no document of `{wanted}`; there are those of {}", known.join(", "));
    };
    let schema = printed(document);
    let mut shown = table(["key", "value", "meaning"]);
    rows("", &schema, &mut |row| {
        shown.add_row(row);
    });
    output.table(&shown);
    output.document(&schema)
}

/// One row for each key that has a meaning of its own: its path (`[]` rows of a list, `*` names of entries), type,
/// description.
fn rows(path: &str, schema: &Value, row: &mut impl FnMut([String; 3])) {
    // An optional value is one of its schema and null.
    let inner = schema["anyOf"].as_array().and_then(|any| any.iter().find(|one| one["type"] != "null"));
    let at = inner.unwrap_or(schema);
    let meaning = schema["description"].as_str().or(at["description"].as_str()).unwrap_or_default();
    if !meaning.is_empty() && !path.is_empty() {
        row([path.to_owned(), value(schema), meaning.split_whitespace().collect::<Vec<_>>().join(" ")]);
    }
    let join = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    for (key, below) in at["properties"].as_object().into_iter().flatten() {
        rows(&join(key), below, row);
    }
    for form in at["oneOf"].as_array().into_iter().flatten() {
        for (key, below) in form["properties"].as_object().into_iter().flatten() {
            rows(&join(key), below, row);
        }
    }
    if at["additionalProperties"].is_object() {
        rows(&join("*"), &at["additionalProperties"], row);
    }
    let items = &at["items"];
    if ["properties", "items", "additionalProperties", "oneOf"].iter().any(|key| items.get(*key).is_some()) {
        rows(&format!("{path}[]"), items, row);
    }
}

/// A schema's type in words.
fn value(schema: &Value) -> String {
    let texts = |list: &Value, of: fn(&Value) -> String| -> Vec<String> {
        list.as_array().into_iter().flatten().map(of).filter(|text| !text.is_empty()).collect()
    };
    if let Some(one) = schema.get("const") {
        return one.to_string();
    }
    for key in ["enum", "oneOf", "anyOf"] {
        if schema.get(key).is_some() {
            let of: fn(&Value) -> String = if key == "enum" { Value::to_string } else { value };
            return texts(&schema[key], of).join(" or ");
        }
    }
    let kind = match &schema["type"] {
        Value::String(kind) => kind.clone(),
        Value::Array(kinds) => kinds.iter().filter_map(Value::as_str).collect::<Vec<_>>().join(" or "),
        _ => "any".to_owned(),
    };
    match (&schema["prefixItems"], &schema["items"]) {
        (tuple @ Value::Array(_), _) => format!("[{}]", texts(tuple, value).join(", ")),
        (_, items @ Value::Object(_)) => format!("{kind} of {}", value(items)),
        _ => kind,
    }
}
