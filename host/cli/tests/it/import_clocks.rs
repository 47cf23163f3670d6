//! Clocks that `import` finds, on the rig: a recording of two devices, one of which counts from its own start.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use stickslip_rig::{Condition, Nuisance, Primitive, Reality, STEP_S, Setup, objects, run};

use crate::documents::{document, stickslip};

/// Added to the motion capture's time to get the forces', s.
const OFFSET_S: f64 = 417.2931;
/// Pushes.
const RUNS: usize = 6;

const POSE: [&str; 7] = ["x", "y", "z", "qw", "qx", "qy", "qz"];

/// Pushes of the rig with the paper's noise: forces at 250 Hz, poses at 125 Hz with their own clock.
fn record(folder: &Path, seed: u64, pusher: bool) {
    let description = objects::bench("clocks");
    let reality = Reality::draw(&description, Nuisance::PAPER, seed);
    let setup = Setup { description, reality, step_s: STEP_S };
    for number in 1..=RUNS {
        let speed_m_s = [0.01, 0.02][number % 2];
        let condition =
            Condition { grip_n: 20.0, speed_m_s, ..Condition::new(Primitive::LinearPush, "obj4") };
        let trial = run(&setup, &condition, number, seed).expect("the rig runs").trial;
        let names = |body: &str| POSE.map(|end| format!("{body}_{end}")).join(",");
        let mut forces = "t,f1x,f1y,f1z,f2x,f2y,f2z,px,py,pz\n".to_owned();
        let mut poses = format!("t,{},{}\n", names("o"), names("g"));
        for (row, sample) in trial.samples.iter().enumerate() {
            let of = |wrench: Option<stickslip_data::Wrench>| {
                wrench.expect("measured").force_n.map(|f| f.to_string()).join(",")
            };
            let [one, two] = sample.finger.map(of);
            let _ = writeln!(forces, "{},{one},{two},{}", sample.t_s, of(sample.pusher_wrench));
            if row % 2 == 0 {
                let at = |pose: Option<stickslip_data::Pose>| {
                    let pose = pose.expect("measured");
                    let cells = pose.position_m.iter().chain(&pose.quaternion);
                    cells.map(f64::to_string).collect::<Vec<_>>().join(",")
                };
                let t = sample.t_s - OFFSET_S;
                let _ = writeln!(poses, "{t},{},{}", at(sample.object), at(sample.gripper));
            }
        }
        fs::write(folder.join(format!("r{number}_ft.csv")), forces).expect("written");
        fs::write(folder.join(format!("r{number}_mocap.csv")), poses).expect("written");
    }
    let wrench = |name: &str, column: &str, acts_on: &str| {
        format!(
            "[streams.{name}]\nforce = [\"{column}x\", \"{column}y\", \"{column}z\"]\nacts_on = \"{acts_on}\"\n"
        )
    };
    let pose = |name: &str, body: &str| {
        format!(
            "[streams.{name}]\nposition = [\"{body}_x\", \"{body}_y\", \"{body}_z\"]\n\
             quaternion_wxyz = [\"{body}_qw\", \"{body}_qx\", \"{body}_qy\", \"{body}_qz\"]\n"
        )
    };
    let description =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo/dataset.toml"))
            .expect("the demo's rig");
    // The demo's description under `dataset`.
    let dataset: String = description
        .lines()
        .filter(|line| !line.starts_with("format"))
        .map(|line| match line.strip_prefix("[[") {
            Some(rest) => format!("[[dataset.{rest}\n"),
            None if line.starts_with('[') => line.replacen('[', "[dataset.", 1) + "\n",
            None => line.to_owned() + "\n",
        })
        .collect();
    let mapping = format!(
        "format = \"stickslip-mapping/1\"\n[trials]\npattern = '^r(?<run>\\d)$'\n\
         constants = {{ object = \"obj4\", primitive = \"linear_push\", grip_n = 20 }}\n[dataset]\n{dataset}\
         [[streams]]\nname = \"ft\"\nfile = \"{{trial}}_ft.csv\"\ntime = {{ column = \"t\" }}\n{}{}{}\
         [[streams]]\nname = \"mocap\"\nfile = \"{{trial}}_mocap.csv\"\n\
         time = {{ column = \"t\", clock = \"estimated\" }}\n{}{}",
        wrench("finger1", "f1", "object"),
        wrench("finger2", "f2", "object"),
        if pusher { wrench("pusher", "p", "object") } else { String::new() },
        pose("object", "o"),
        pose("gripper", "g"),
    );
    fs::write(folder.join("mapping.toml"), mapping).expect("written");
}

#[test]
#[ignore = "long: make test-host-rest"]
fn the_clock_of_a_motion_capture_is_found_within_its_interval_with_and_without_a_sensor_in_the_pusher() {
    for (seed, pusher) in [(3, true), (4, true), (5, false), (6, false)] {
        let folder = tempfile::tempdir().expect("a folder");
        record(folder.path(), seed, pusher);
        let words = ["--json", "import", "recording", "mapping.toml", "--out", "data", "--html", "mine.html"];
        let output = stickslip().current_dir(folder.path()).args(words).output().expect("run");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let told = document("import recording", &output.stdout);
        let offsets = told["offsets"].as_array().expect("offsets");
        assert_eq!(offsets.len(), RUNS);
        let of = |key: &str| offsets[0][key].as_f64().expect("a number");
        let (error_s, half_s) = (of("offset_s") - OFFSET_S, of("uncertainty_s"));
        println!(
            "seed {seed}: error {:.2} ms of {:.2} ms, {} trials",
            error_s * 1e3,
            half_s * 1e3,
            of("trials")
        );
        assert_eq!(of("trials"), RUNS as f64, "seed {seed}: the trials do not agree");
        assert!(error_s.abs() <= half_s && half_s < 0.01, "seed {seed}: {error_s} of {half_s}");
        // Poses come at half the rate: a model needs them in the first row.
        let index = stickslip_data::Index::open(&folder.path().join("data")).expect("a data set");
        for info in &index.trials {
            let first = index.read_trial(info).expect("read").samples[0];
            assert!(first.object.is_some() && first.gripper.is_some(), "{}", info.trial);
        }
        let page = fs::read_to_string(folder.path().join("mine.html")).expect("a page");
        assert!(
            page.matches("<svg").count() >= 2 * RUNS && page.contains("clock of mocap: 417.29"),
            "{seed}"
        );
    }
}
