//! A model with friction pyramids in every command that takes a model, on the smallest data that it works on.

use std::path::Path;

use serde_json::Value;
use stickslip_data::{Dataset, write};
use stickslip_rig::objects::bench;
use stickslip_rig::plan::{PlanName, conditions};
use stickslip_rig::{Nuisance, Reality, STEP_S, Setup, simulate};
use tempfile::TempDir;

use crate::documents::{document, stickslip};

const SEED: u64 = 11;

fn model(formulation: &str) -> String {
    format!(
        "format = \"stickslip-model/1\"\nbase = \"hard\"\nformulation = \"{formulation}\"\n\
         [friction]\nfinger = 0.38\npusher = 0.22\nsupport = 0.3\n"
    )
}

/// Four pushes of two conditions, and a model of each formulation.
fn pushes() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let description = bench("pyramids");
    let reality = Reality::draw(&description, Nuisance::PAPER, SEED);
    let setup = Setup { description: description.clone(), reality, step_s: STEP_S };
    let all = conditions(PlanName::PushSmall, &[], SEED, 1.0);
    let some = all.iter().step_by(all.len().div_ceil(2));
    let trials =
        some.flat_map(|c| (1..=2).map(|run| simulate(&setup, c, run, SEED).expect("a trial"))).collect();
    write(&Dataset { folder: "pyramids".into(), description, trials }, folder.path()).expect("written");
    for formulation in ["cone", "lcp"] {
        std::fs::write(folder.path().join(format!("{formulation}.toml")), model(formulation))
            .expect("written");
    }
    folder
}

fn json(folder: &Path, command: &str, formulation: &str) -> Value {
    let file = format!("{formulation}.toml");
    let output = stickslip()
        .current_dir(folder)
        .args([command, ".", "--model", &file, "--json"])
        .output()
        .expect("run");
    assert!(output.status.success(), "{command} {file}: {}", String::from_utf8_lossy(&output.stderr));
    document(command, &output.stdout)
}

#[test]
#[ignore = "long: make test-host-rest"]
fn compare_diagnose_and_score_take_a_model_with_pyramids_and_judge_it_by_its_own_predictions() {
    let folder = pushes();
    for command in ["compare", "diagnose", "score"] {
        let [cone, lcp] = ["cone", "lcp"].map(|formulation| json(folder.path(), command, formulation));
        let text = |document: &Value| document.to_string().replace("lcp.toml", "cone.toml");
        assert!(text(&cone).len() > 500, "{command}: {cone}");
        // A pyramid has less friction than its cone between its edges: were they the same, one had not been used.
        assert_ne!(text(&cone), text(&lcp), "{command}: both formulations predict the same");
    }
}
