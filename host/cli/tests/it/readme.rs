//! The figures and the picture of README.md, made anew: they must be what the code gives today.

use std::path::{Path, PathBuf};

use stickslip_analysis::channels::NAMES;
use stickslip_analysis::compare::{NamedModel, Options, compare};
use stickslip_analysis::model::file::default_model;
use stickslip_analysis::run::simulate::prepare;
use stickslip_report::overlay::picture;
use stickslip_rig::{Condition, Primitive, Reality, STEP_S, Setup, objects, run};
use stickslip_shared::model::{Base, Friction, Model};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Push force (N) and sag (mm) at the end of the paper's push, of the rig and of the model.
fn push(mu: f64) -> [(f64, f64); 2] {
    let description = objects::bench("ideal");
    let setup = Setup { description: description.clone(), reality: Reality::ideal(mu, 0.25), step_s: STEP_S };
    let mut condition = Condition::new(Primitive::LinearPush, "obj4");
    condition.grip_n = 20.0;
    let outcome = run(&setup, &condition, 1, 7).expect("the rig runs");
    let prepared = prepare(&description, &outcome.trial, 0).expect("the trial is complete");
    let friction = Friction { finger: mu, pusher: 0.25, support: 0.3 };
    let modelled = prepared.simulate(&Model::base(Base::Hard, friction));
    let at = |name: &str| NAMES.iter().position(|n| *n == name).expect("a channel");
    let (force, height) = (at("pusher_fx_n"), at("object_z_m"));
    // In the middle of the slide.
    let end = prepared.t_s.len() / 2;
    [&prepared.measured, &modelled.signals]
        .map(|rows| (rows[end][force].abs(), 1e3 * (rows[0][height] - rows[rows.len() - 1][height])))
}

/// The numbers of the table's row that begins with `name`.
fn row(readme: &str, name: &str) -> [f64; 2] {
    let line = readme.lines().find(|l| l.starts_with(&format!("| {name}"))).expect(name);
    let mut cells = line.split('|').skip(2).map(|c| {
        c.trim().split(' ').next().and_then(|n| n.parse().ok()).unwrap_or_else(|| panic!("{line}: no number"))
    });
    [cells.next().expect("mu 0.15"), cells.next().expect("mu 0.40")]
}

#[test]
fn the_table_of_the_papers_push_is_what_model_and_rig_give() {
    let readme = std::fs::read_to_string(repository().join("README.md")).expect("README.md");
    let mut wrong = String::new();
    for (k, mu) in [0.15, 0.40].into_iter().enumerate() {
        let [rig, model] = push(mu);
        for (name, value, within) in [
            ("push force, this model", model.0, 0.006),
            ("push force, springs", rig.0, 0.006),
            ("sag over 14.9 mm, this model", model.1, 0.006),
            ("sag, the rig", rig.1, 0.006),
        ] {
            let said = row(&readme, name)[k];
            if (said - value).abs() > within {
                wrong += &format!("{name}, mu {mu}: README {said}, now {value:.4}\n");
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn the_picture_is_that_of_todays_comparison() {
    let dataset = stickslip_data::read(&repository().join("data/demo")).expect("data/demo");
    let models = [NamedModel::own("base", "default", default_model())];
    let trial = Some("linear_push-obj4-g20-v10-s0-r1".to_owned());
    let comparison = compare(&dataset.clone().into(), &models, &Options { trial, ..Options::default() }, &())
        .expect("compared");
    let trace = comparison.traces.first().expect("a trial is drawn");
    let channels: Vec<usize> = ["pusher_fx_n", "finger1_fx_n", "object_x_m", "object_z_m"]
        .iter()
        .map(|name| NAMES.iter().position(|n| n == name).expect("a channel"))
        .collect();
    let now = picture(trace, &channels);
    let file = repository().join("docs/comparison.svg");
    if std::env::var_os("STICKSLIP_WRITE_PICTURE").is_some() {
        std::fs::write(&file, &now).expect("docs/comparison.svg");
    }
    let drawn = std::fs::read_to_string(&file).unwrap_or_default();
    assert!(
        drawn == now,
        "docs/comparison.svg is not of today: run this test with STICKSLIP_WRITE_PICTURE=1 and look at it"
    );
}

#[test]
fn the_moving_picture_is_that_of_todays_lift() {
    let trials =
        stickslip_cli::grip_loop::run(&stickslip_cli::grip_loop::Options::demonstration()).expect("lifts");
    let saved =
        trials.iter().find(|trial| trial.saved()).expect("an object that is kept by the advice alone");
    let now = stickslip_cli::moving::picture(saved);
    roxmltree::Document::parse(&now).expect("SVG");
    let file = repository().join("docs/lift.svg");
    if std::env::var_os("STICKSLIP_WRITE_PICTURE").is_some() {
        std::fs::write(&file, &now).expect("docs/lift.svg");
    }
    let drawn = std::fs::read_to_string(&file).unwrap_or_default();
    assert!(
        drawn == now,
        "docs/lift.svg is not of today: run this test with STICKSLIP_WRITE_PICTURE=1 and look at it"
    );
}
