//! What users read uses the field's terms: words that only this project once used are searched for in the manual, the help,
//! the schemas, and the descriptions of effects and of the predictor's numbers.

use std::fs;
use std::path::Path;

use clap::CommandFactory;
use serde_json::Value;
use stickslip_cli::commands::Cli;
use stickslip_shared::effect::Info;
use stickslip_shared::effects;

use crate::documents::stickslip;

/// Each with what to write instead.
const PRIVATE: [(&str, &str); 18] = [
    ("tell", "distinguish, show, send"),
    ("tells", "distinguishes, shows, sends"),
    ("told", "stated, detected, sent"),
    ("telling", "stating"),
    ("give way", "deform"),
    ("gives way", "deforms"),
    ("gave way", "deformed"),
    ("giving way", "deforming"),
    ("meets", "touches, satisfies"),
    ("met", "found, satisfied"),
    ("by hand", "manually"),
    ("dear", "expensive"),
    ("dearer", "more expensive"),
    ("hang on", "depend on"),
    ("hangs on", "depends on"),
    ("hung on", "depended on"),
    ("place", "position; channel and phase"),
    ("places", "positions; channels and phases"),
];
/// Ordinary English with one of these words in it.
const ORDINARY: [&str; 1] = ["in place of"];

/// The private words in `text`, code in backticks left out: names of keys stay as they are.
fn private(text: &str) -> Vec<&'static str> {
    let prose: String = text.split('`').step_by(2).collect::<Vec<_>>().join(" ");
    let letters = |c: char| if c.is_alphanumeric() || c == '_' { c.to_ascii_lowercase() } else { ' ' };
    let words: String = prose.chars().map(letters).collect();
    let mut words = format!(" {} ", words.split_whitespace().collect::<Vec<_>>().join(" "));
    for phrase in ORDINARY {
        words = words.replace(&format!(" {phrase} "), "  ");
    }
    PRIVATE.iter().map(|(word, _)| *word).filter(|word| words.contains(&format!(" {word} "))).collect()
}

/// Adds `at` with the private words of `text` to `found`, and what to write instead.
fn search(at: &str, text: &str, found: &mut Vec<String>) {
    for word in private(text) {
        let instead = PRIVATE.iter().find(|(of, _)| *of == word).map_or("", |(_, instead)| instead);
        found.push(format!("{at}: '{word}' ({instead}): {text}"));
    }
}

fn none(found: &[String]) {
    assert!(found.is_empty(), "private words:\n{}", found.join("\n"));
}

#[test]
fn private_words_are_found_in_prose_and_neither_in_names_nor_in_ordinary_phrases() {
    assert_eq!(private("Slip is told late; the pads give\nway."), ["told", "give way"]);
    assert!(
        private("`spread_told`, spread_told and `would_tell` stand in place of method and metal.").is_empty()
    );
}

#[test]
fn no_private_word_is_in_the_manual_the_readme_or_the_changelog() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut pages = vec![top.join("README.md"), top.join("CHANGELOG.md")];
    // docs/lab is a record: its folder is not entered.
    let docs = fs::read_dir(top.join("docs")).expect("docs/").map(|entry| entry.expect("an entry").path());
    pages.extend(docs.filter(|path| path.extension().is_some_and(|ending| ending == "md")));
    assert!(pages.len() > 20, "{pages:?}");
    let mut found = Vec::new();
    for page in &pages {
        let text = fs::read_to_string(page).expect("a page");
        for (line, words) in text.lines().enumerate() {
            search(&format!("{}:{}", page.display(), line + 1), words, &mut found);
        }
    }
    none(&found);
}

/// Searches every text of a document, or, with `key`, those under this key.
fn search_document(at: &str, document: &Value, key: Option<&str>, found: &mut Vec<String>) {
    match document {
        Value::Object(entries) => {
            for (name, below) in entries {
                let at = format!("{at}.{name}");
                match below {
                    Value::String(text) if key.is_none_or(|key| key == name) => search(&at, text, found),
                    _ => search_document(&at, below, key, found),
                }
            }
        }
        Value::Array(rows) => rows.iter().for_each(|row| search_document(at, row, key, found)),
        _ => {}
    }
}

fn printed(words: &[&str]) -> Value {
    let output = stickslip().arg("--json").args(words).output().expect("run");
    serde_json::from_slice(&output.stdout).expect("a document")
}

#[test]
fn no_private_word_is_in_the_schemas_the_predictors_numbers_or_the_help() {
    let mut found = Vec::new();
    let schemas = printed(&["schema"]);
    let commands: Vec<&str> = schemas
        .as_object()
        .expect("an object")
        .keys()
        .map(String::as_str)
        .filter(|key| *key != "schema")
        .collect();
    assert!(commands.len() > 15, "{commands:?}");
    for command in commands {
        let words: Vec<&str> = ["schema"].into_iter().chain(command.split(' ')).collect();
        let schema = printed(&words);
        for key in ["description", "title"] {
            search_document(command, &schema, Some(key), &mut found);
        }
    }
    search_document("predictor", &printed(&["predictor"]), Some("what"), &mut found);
    search_help(Cli::command(), &mut found);
    none(&found);
}

fn search_help(mut command: clap::Command, found: &mut Vec<String>) {
    let name = format!("{} --help", command.get_name());
    for line in command.render_long_help().to_string().lines() {
        search(&name, line, found);
    }
    command.get_subcommands().for_each(|below| search_help(below.clone(), found));
}

#[test]
fn no_private_word_describes_an_effect() {
    let mut found = Vec::new();
    for info in effects::REGISTRY {
        let Info { id, summary, signature, on_robot, parameters, .. } = info;
        for text in [*summary, *signature, *on_robot].into_iter().chain(parameters.iter().map(|p| p.what)) {
            search(id, text, &mut found);
        }
    }
    none(&found);
}
