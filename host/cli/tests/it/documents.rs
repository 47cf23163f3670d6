//! The JSON documents of the commands hold what `stickslip schema` describes.

use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

use crate::common::push;

/// The program.
pub fn stickslip() -> Command {
    Command::cargo_bin("stickslip").expect("built")
}

/// The JSON document that `command` printed. Every key in it is one that `stickslip schema` describes, and of the
/// type that it says.
pub fn document(command: &str, printed: &[u8]) -> Value {
    let document: Value = serde_json::from_slice(printed).expect("one JSON document");
    let mut words = vec!["--json", "schema"];
    words.extend(command.split(' '));
    let described = stickslip().args(words).output().expect("run").stdout;
    let schema: Value = serde_json::from_slice(&described).expect("a JSON document");
    is_described(command, &document, &schema);
    document
}

fn is_described(path: &str, value: &Value, schema: &Value) {
    if let Some(any) = schema["anyOf"].as_array() {
        let of = any.iter().find(|one| (one["type"] == "null") == value.is_null());
        return is_described(path, value, of.unwrap_or_else(|| panic!("{path}: {value} is not described")));
    }
    // One of several forms: the one that has the same keys.
    if let (Some(forms), Some(keys)) = (schema["oneOf"].as_array(), value.as_object()) {
        let has = |form: &&Value| keys.keys().all(|key| form["properties"].get(key).is_some());
        let form = forms.iter().find(has).unwrap_or_else(|| panic!("{path}: {value} is not described"));
        return is_described(path, value, form);
    }
    let kind = match value {
        Value::Null => "null",
        Value::Bool(_) => "boolean",
        Value::Number(_) => "number",
        Value::String(_) => "string",
        Value::Array(_) => "array",
        Value::Object(_) => "object",
    };
    let is = |name: &Value| name == kind || kind == "number" && name == "integer";
    let fits = match &schema["type"] {
        Value::Array(kinds) => kinds.iter().any(is),
        Value::Null => true,
        one => is(one),
    };
    assert!(fits, "{path}: {value} where {} is described", schema["type"]);
    match value {
        Value::Object(keys) => {
            for (key, below) in keys {
                let of = schema["properties"].get(key).or(schema.get("additionalProperties"));
                let of = of.unwrap_or_else(|| panic!("{path}.{key} is not described"));
                is_described(&format!("{path}.{key}"), below, of);
            }
        }
        Value::Array(rows) => {
            for (at, below) in rows.iter().enumerate() {
                let of = schema["prefixItems"].get(at).unwrap_or(&schema["items"]);
                is_described(&format!("{path}[{at}]"), below, of);
            }
        }
        _ => {}
    }
}

fn of(command: &str, words: &[&str], folder: &Path) -> Value {
    let output = stickslip().current_dir(folder).arg("--json").args(words).output().expect("run");
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    document(command, &output.stdout)
}

#[test]
fn documents_of_the_quick_commands_hold_what_their_schemas_describe() {
    let (_keep, data) = push(|text| text);
    let data = data.as_path();
    of("check", &["check", "."], data);
    of("compare", &["compare", "."], data);
    of("replay", &["replay", "."], data);
    of("score", &["score", "."], data);
    of("simulate", &["simulate", ".", "--out", "simulated"], data);
    of("predictor", &["predictor"], data);
    of("effects EFFECT", &["effects", "adhesion"], data);
    of("rig list-effects", &["rig", "--list-effects"], data);
    of("rig", &["rig", "--out", "made", "--plan", "demo", "--runs", "1", "--objects", "obj4"], data);
    of("lcp", &["lcp", "--generate", "4", "--solver", "contact"], data);
    of("new", &["new", "trials/linear_push-obj4-g20-v10-s0-r1.csv", "--out", "mapping.toml"], data);
}

#[test]
fn replay_and_score_say_which_numbers_of_the_predictor_a_file_sets_and_nothing_without_one() {
    let (_keep, data) = push(|text| text);
    let data = data.as_path();
    std::fs::write(data.join("predictor.toml"), "[health]\nstuck = 5\n").expect("written");
    for command in ["replay", "score"] {
        let set = of(command, &[command, ".", "--predictor", "predictor.toml"], data);
        let expected = serde_json::json!([{ "key": "health.stuck", "value": [5.0], "default": [3.0] }]);
        assert_eq!(set["tuned"], expected, "{command}");
        assert_eq!(of(command, &[command, "."], data)["tuned"], Value::Null, "{command}");
        let words = [command, ".", "--predictor", "predictor.toml", "--html", "page.html"];
        let text = stickslip().current_dir(data).args(words).output().expect("run").stdout;
        let text = String::from_utf8(text).expect("text");
        assert!(text.contains("predictor: health.stuck 5 (default 3)"), "{text}");
        let page = std::fs::read_to_string(data.join("page.html")).expect("a page");
        assert!(page.contains("predictor: <b>health.stuck 5 (default 3)</b>"), "{command}");
    }
    std::fs::write(data.join("predictor.toml"), "[health]\nstuk = 5\n").expect("written");
    let refused = stickslip()
        .current_dir(data)
        .args(["replay", ".", "--predictor", "predictor.toml"])
        .output()
        .expect("run");
    let told = String::from_utf8(refused.stderr).expect("text");
    assert!(
        told.contains("predictor.toml:2:1: `stuk` is not known in [health]; did you mean `stuck`?"),
        "{told}"
    );
    assert_eq!(refused.status.code(), Some(1));
}

#[test]
fn every_key_of_every_document_has_a_meaning_in_words() {
    let here = Path::new(".");
    let names = stickslip().args(["--json", "schema"]).output().expect("run").stdout;
    let names: Value = serde_json::from_slice(&names).expect("a document");
    let commands: Vec<&String> =
        names.as_object().expect("an object").keys().filter(|key| *key != "schema").collect();
    assert!(commands.len() > 15, "{commands:?}");
    for command in commands {
        let mut words = vec!["schema"];
        words.extend(command.split(' '));
        let output = stickslip().current_dir(here).arg("--json").args(&words).output().expect("run");
        let schema: Value = serde_json::from_slice(&output.stdout).expect("a document");
        has_meanings(command, &schema);
    }
}

fn has_meanings(path: &str, schema: &Value) {
    let one = schema["anyOf"].as_array().and_then(|any| any.iter().find(|one| one["type"] != "null"));
    let at = one.unwrap_or(schema);
    for (key, below) in at["properties"].as_object().into_iter().flatten() {
        let path = format!("{path}.{key}");
        let inner = below["anyOf"][0]["description"].as_str();
        let words = below["description"].as_str().or(inner).unwrap_or_default();
        assert!(!words.is_empty(), "{path} has no meaning");
        assert!(!words.contains("[`"), "{path} points into the code: {words}");
        has_meanings(&path, below);
    }
    for inner in [&at["items"], &at["additionalProperties"]] {
        if inner.is_object() {
            has_meanings(&format!("{path}[]"), inner);
        }
    }
}
