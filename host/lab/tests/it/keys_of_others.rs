//! Data sets that others made, scored with their keys.

use std::path::Path;

use stickslip_data::write;
use stickslip_lab::blind::generate::Class;
use stickslip_lab::blind::keys;
use stickslip_lab::blind::score::{Opened, figures};

use crate::diagnose_inputs::made;

fn opened(folder: &Path, key: &str) -> anyhow::Result<Opened> {
    let of_keys = folder.join("keys");
    std::fs::create_dir_all(&of_keys).unwrap();
    std::fs::write(of_keys.join("a.json"), key).unwrap();
    keys::run(&folder.join("data"), &of_keys, "a")
}

#[test]
#[ignore = "long: make test-host-rest"]
fn a_named_effect_is_right_or_wrong_by_the_key_and_soft_pads_are_no_wrong_name() {
    let folder = tempfile::tempdir().unwrap();
    let dataset = made("finger_friction_mismatch=0.4", 8, |_| true);
    write(&dataset, &folder.path().join("data/a")).unwrap();
    assert_eq!(keys::names(&folder.path().join("data")).unwrap(), ["a"]);

    let hidden = |id: &str, listed: bool, pads: f64| {
        format!(
            r#"{{"effects": [{{"id": "{id}", "level": 1.0, "listed": {listed}}}], "family": "bench-x", "pad_tangential_n_m": {pads}}}"#
        )
    };
    let right = opened(folder.path(), &hidden("finger_friction_mismatch", true, 1e6)).unwrap();
    assert_eq!((right.truth.class, right.truth.trials), (Class::One, dataset.trials.len()));
    let f = figures(std::slice::from_ref(&right));
    assert_eq!((f.single_named.found, f.single_wrong.found, f.families["bench-x"].found), (1, 0, 1));

    let mut wrong = right.clone();
    wrong.truth.effects = vec!["wear_drift".into()];
    assert_eq!(figures(std::slice::from_ref(&wrong)).single_wrong.found, 1);

    let mut pads = right;
    pads.named.push("contact_compliance");
    pads.truth.also_true = vec!["contact_compliance"];
    let f = figures(&[pads]);
    assert_eq!((f.single_named.found, f.single_wrong.found), (1, 0));
}

#[test]
fn a_missing_key_and_a_folder_without_data_sets_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let error = keys::names(folder.path()).unwrap_err().to_string();
    assert!(error.contains("dataset.toml"), "{error}");
    let error = format!("{:#}", keys::names(&folder.path().join("none")).unwrap_err());
    assert!(error.contains("none"), "{error}");
}
