//! What the pages and tables are made of: outlines of point clouds, schemas of documents, command lines.

use std::path::Path;

use stickslip_analysis::model::file::default_model;
use stickslip_analysis::score::document::{Options, score_tuned};
use stickslip_analysis::score::figures::Class;
use stickslip_analysis::score::rate::Rate;
use stickslip_analysis::score::truth::Kind;
use stickslip_data::Index;
use stickslip_report::outline::hull;
use stickslip_report::plot::{Chart, Line, MODELS};
use stickslip_report::score::verdict;
use stickslip_report::terminal::{command_line, with_schema};
use stickslip_report::words::effects_in_words;

#[test]
fn effects_are_told_in_words_and_the_rest_of_a_text_stays() {
    let text = "not visible in these data: support_pressure, mass_error; see my_effect in a_file.toml";
    let words = "not visible in these data: support pressure, mass error; see my_effect in a_file.toml";
    assert_eq!(effects_in_words(text), words);
}

#[test]
fn the_outline_of_a_square_with_points_inside_is_the_square() {
    let points = vec![[0.0, 0.0], [1.0, 1.0], [0.5, 0.5], [1.0, 0.0], [0.2, 0.7], [0.0, 1.0]];
    assert_eq!(hull(points), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
}

#[test]
fn every_document_has_a_schema_and_one_of_its_own_stays() {
    let of = |json| -> serde_json::Value {
        serde_json::from_str(&with_schema(Some("stickslip-x/1"), &json).unwrap()).unwrap()
    };
    assert_eq!(of(serde_json::json!({ "a": 1 })), serde_json::json!({ "schema": "stickslip-x/1", "a": 1 }));
    assert_eq!(of(serde_json::json!([1])), serde_json::json!({ "schema": "stickslip-x/1", "results": [1] }));
    assert_eq!(of(serde_json::json!({ "schema": "own/2" })), serde_json::json!({ "schema": "own/2" }));
}

#[test]
fn a_command_line_can_be_copied_whatever_the_paths_are() {
    let words = ["compare", "my data", "--model", "it's.toml"];
    let line = command_line(words);
    assert_eq!(shlex::split(&line).unwrap()[1..], words);
}

/// Texts beside the y axis of a chart through `values`, from the top.
fn beside(values: &[f64], least_span: f64) -> Vec<String> {
    let points = values.iter().zip(0..).map(|(y, x)| (f64::from(x), *y)).collect();
    let line = Line { points, colour: MODELS[0], width: 1 };
    let svg = Chart { size: (360, 170), least_span, lines: vec![line], ..Chart::default() }.svg();
    let document = roxmltree::Document::parse(&svg).expect("an svg");
    let texts = document.descendants().filter(|n| n.has_tag_name("text"));
    let right = texts.filter(|n| n.attribute("text-anchor") == Some("end"));
    right.map(|n| n.text().unwrap_or_default().trim().to_owned()).collect()
}

#[test]
fn numbers_beside_an_axis_differ_also_where_the_signal_is_constant() {
    let constant = [-20.0; 5];
    let nearly: Vec<f64> = (0..9).map(|k| 20.0 + 1e-4 * f64::from(k)).collect();
    let noise: Vec<f64> = (0..9).map(|k| 20.0 + 1e-9 * f64::from(k)).collect();
    let small: Vec<f64> = (0..9).map(|k| 1e-8 * f64::from(k)).collect();
    for values in [&constant[..], &[0.0; 5], &[3e-7; 5], &[1.5e6; 5], &nearly, &noise, &small] {
        for least in [0.0, 0.02] {
            let texts = beside(values, least);
            let mut alone = texts.clone();
            alone.sort();
            alone.dedup();
            assert!(texts.len() > 1 && alone.len() == texts.len(), "{values:?}, {least}: {texts:?}");
        }
    }
}

#[test]
fn the_sentence_of_a_score_counts_each_false_alarm_once_whatever_events_there_were() {
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo");
    let mut index = Index::open(&demo).expect("the demo");
    index.trials.truncate(1);
    let mut score = score_tuned(&index, &default_model(), &Default::default(), &Options::default(), &())
        .expect("a score");
    for row in &mut score.rows {
        let count = match row.class.kind() {
            Kind::Slip => 4,
            Kind::Moved => 10,
            Kind::Drop => 0,
        };
        // Two classes of slip and two of drop share what is false of their kind.
        row.false_alarm_rate = Rate::of(count, 60.0).filter(|_| row.class != Class::SlipIntended);
    }
    for events in [0, 3] {
        score.rows.iter_mut().for_each(|row| (row.events, row.in_time) = (events, events));
        let (_, said) = verdict(&score);
        assert!(said.ends_with("false alarms: 14."), "{said}");
    }
}
