//! The predictor's output, bit for bit, on recorded trials: the demonstration data and the worst
//! runs that the hunt has found. Code that is only moved keeps these hashes. Where one changes, the
//! predictor says something else: the commit that changes it says why.

use std::path::{Path, PathBuf};

use stickslip_analysis::model::file::default_model;
use stickslip_analysis::run::replay::{hash, replay};
use stickslip_data::Index;
use stickslip_lab::hunt::run::Case;
use stickslip_shared::predictor::{Limits, Predictor};

fn data(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data").join(folder)
}

/// Fails with the whole list as it is now, ready to be read beside the one expected.
fn assert_hashes(found: &[(String, u32)], expected: &[(&str, u32)]) {
    let same =
        found.len() == expected.len() && found.iter().zip(expected).all(|(f, e)| f.0 == e.0 && f.1 == e.1);
    let list: String =
        found.iter().map(|(name, hash)| format!("    (\"{name}\", 0x{hash:08x}),\n")).collect();
    assert!(same, "the predictions are now\n{list}");
}

#[test]
fn predictions_of_the_demonstration_trials_are_these_bits() {
    let index = Index::open(&data("demo")).expect("data/demo is part of the repository");
    let found: Vec<(String, u32)> = index
        .trials
        .iter()
        .enumerate()
        .map(|(ordinal, info)| {
            let trial = index.read_trial(info).expect("it is sound");
            let run = replay(&index.description, &trial, &default_model(), Limits::default(), ordinal);
            (info.trial.clone(), run.expect("replays").hash)
        })
        .collect();
    assert_hashes(&found, &DEMO);
}

#[test]
fn predictions_of_the_worst_runs_are_these_bits() {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(data("worst"))
        .expect("data/worst is part of the repository")
        .map(|e| e.expect("an entry").path())
        .filter(|p| p.extension().is_some_and(|e| e == "json"))
        .collect();
    paths.sort();
    let found: Vec<(String, u32)> = paths
        .iter()
        .map(|path| {
            let case: Case = serde_json::from_slice(&std::fs::read(path).expect("readable")).expect("a case");
            let (scene, model, limits) = case.model.clone();
            let mut predictor = Predictor::new(scene, model, limits).expect("accepted when it was found");
            predictor.set_plan(case.plan.clone());
            let all: Vec<_> = case.samples.iter().map(|s| predictor.take(s)).collect();
            (path.file_stem().unwrap_or_default().to_string_lossy().into_owned(), hash(&all))
        })
        .collect();
    assert_hashes(&found, &WORST);
}

const DEMO: [(&str, u32); 9] = [
    ("linear_push-obj4-g20-v10-s0-r1", 0x1a2c5cb6),
    ("pivot-obj4-g20-w10-o15-r1", 0xdc8cfaae),
    ("roll-obj1-g3-v15-r1", 0x5b1a4f1a),
    ("linear_push-obj4-g20-v10-s0-r2", 0x9607980a),
    ("pivot-obj4-g20-w10-o15-r2", 0xd0a9a7af),
    ("roll-obj1-g3-v15-r2", 0xf4d77d7e),
    ("linear_push-obj4-g20-v10-s0-r3", 0xa3b2fe33),
    ("pivot-obj4-g20-w10-o15-r3", 0x82fd2cdb),
    ("roll-obj1-g3-v15-r3", 0x49ceade9),
];
const WORST: [(&str, u32); 12] = [
    ("step-force-1", 0x4eea16d3),
    ("step-residual-1", 0xaf628979),
    ("step-velocity-1", 0x8db4a991),
    ("step-work-1", 0x722b7fbf),
    ("step-work-2", 0xa672b8e1),
    ("tick-work-1", 0x81d6f15f),
    ("tick-work-2", 0x0721b400),
    ("tick-work-3", 0x52a76b7f),
    ("tick-work-4", 0x376ad20d),
    ("tick-work-5", 0x920cd4ef),
    ("tick-work-6", 0x39b285da),
    ("tick-work-7", 0x382a84d2),
];
