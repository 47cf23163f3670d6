//! `simulate`: a data set of what a model predicts.

use std::path::Path;

use stickslip_analysis::model::file::default_model;
use stickslip_analysis::run::simulate::prepare;
use stickslip_analysis::simulate;
use stickslip_data::{Index, TableFormat};

#[test]
fn what_a_model_predicts_is_a_data_set_that_the_same_model_predicts_again() {
    let mut few =
        Index::open(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo")).expect("the demo");
    few.trials.truncate(3);
    let folder = tempfile::tempdir().expect("folder");
    let model = default_model();
    for tables in [TableFormat::Csv, TableFormat::Parquet] {
        let out = folder.path().join(format!("{tables:?}"));
        let report = simulate(&few, &model, &out, tables, &()).expect("simulated");
        assert_eq!((report.trials, report.refused.len()), (3, 0));
        let predicted = Index::open(&out).expect("reads");
        for (ordinal, info) in predicted.trials.iter().enumerate() {
            let trial = predicted.read_trial(info).expect("reads");
            let prepared = prepare(&predicted.description, &trial, ordinal).expect("prepares");
            let again = prepared.simulate(&model);
            // Motion of gripper and pusher is smoothed once more: that alone may differ.
            for (at, (row, measured)) in again.signals.iter().zip(&prepared.measured).enumerate() {
                for (channel, (a, b)) in row.iter().zip(measured).enumerate() {
                    let bound = match channel {
                        0..3 => 2e-5,
                        3..6 => 5e-4,
                        // While contact is made, a micrometre of path is a force.
                        _ if at < 50 => continue,
                        k if k % 6 < 3 => 0.25,
                        _ => 5e-3,
                    };
                    assert!((a - b).abs() <= bound, "{} row {at}, channel {channel}: {a} {b}", info.trial);
                }
            }
        }
    }
}
