//! The engine itself, in a Python process: trials go in, their signals come out.

use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{Command, Stdio};

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use stickslip_shared::model::Friction;
use stickslip_shared::track::Pose;
use thiserror::Error;

use super::Setting;
use super::mjcf::mjcf;
use stickslip_analysis::channels::{COUNT, object_channels};
use stickslip_analysis::run::simulate::{Prepared, Simulated};

const SCRIPT: &str = include_str!("../../../../tools/mujoco/run.py");
/// Names the Python that has the wheel.
const VARIABLE: &str = "STICKSLIP_MUJOCO_PYTHON";
/// Exit code of the script without the wheel.
const NO_WHEEL: i32 = 3;

/// Why the engine could not be run.
#[derive(Debug, Error)]
pub enum EngineError {
    /// No Python environment.
    #[error(
        "MuJoCo is not set up: there is no {python}. `make mujoco-setup` makes a Python environment there with the wheel \
         `mujoco` from PyPI; or set {VARIABLE} to a python that has it. `--export DIR` needs neither"
    )]
    Absent {
        /// Where it was looked for.
        python: PathBuf,
    },
    /// Python without the wheel.
    #[error("{python} has no MuJoCo ({why}): `make mujoco-setup`, or `{python} -m pip install mujoco numpy`")]
    NoWheel {
        /// Which.
        python: PathBuf,
        /// What it said.
        why: String,
    },
    /// It stopped.
    #[error("the MuJoCo process failed: {0}")]
    Failed(String),
}

/// What the engine gave for one trial.
#[derive(Clone, Debug)]
pub struct Run {
    /// Signals, one row for each sample.
    pub simulated: Simulated,
    /// Contact points of the pusher that bear force, at each sample.
    pub pusher_points: Vec<u32>,
    /// Steps.
    pub steps: usize,
    /// Time in them, s.
    pub step_s: f64,
    /// Warnings of the engine (unstable states).
    pub warnings: usize,
    /// Its version.
    pub version: String,
}

#[derive(Serialize)]
struct Job {
    xml: String,
    t_s: Vec<f64>,
    gripper: Option<Vec<[f64; 7]>>,
    grip_n: Vec<f64>,
    reference_m: [f64; 3],
    rests: bool,
}

#[derive(Deserialize)]
struct Answer {
    object: Vec<[f64; 7]>,
    finger1: Vec<[f64; 6]>,
    finger2: Vec<[f64; 6]>,
    pusher: Vec<[f64; 6]>,
    normal: Vec<[f64; 4]>,
    points: Vec<[u32; 4]>,
    steps: usize,
    step_s: f64,
    warnings: usize,
    version: String,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Reply {
    Error { error: String },
    Answer(Box<Answer>),
}

/// The Python that is used: `STICKSLIP_MUJOCO_PYTHON`, or the environment of `make mujoco-setup`.
///
/// # Errors
/// Where neither is there.
pub fn python() -> Result<PathBuf, EngineError> {
    let python = match std::env::var_os(VARIABLE) {
        Some(path) => PathBuf::from(path),
        None => {
            let variable = |name| std::env::var_os(name).map(PathBuf::from);
            let data = variable("XDG_DATA_HOME")
                .or_else(|| variable("HOME").map(|h| h.join(".local/share")))
                .unwrap_or_default();
            let home = variable("STICKSLIP_MUJOCO_HOME").unwrap_or_else(|| data.join("stickslip/mujoco"));
            home.join("bin/python")
        }
    };
    if python.exists() { Ok(python) } else { Err(EngineError::Absent { python }) }
}

/// Runs the engine along `trials`, one after the other; a trial that it cannot run gets its
/// reason. `tick` is called after each.
///
/// # Errors
/// Where the engine is not there or stops.
pub fn run(
    trials: &[Prepared],
    friction: &[Friction<f64>],
    setting: Setting,
    tick: &dyn Fn(),
) -> Result<Vec<Result<Run, String>>, EngineError> {
    let python = python()?;
    let failed = |e: &dyn std::fmt::Display| EngineError::Failed(e.to_string());
    let mut child = Command::new(&python)
        .args(["-c", SCRIPT])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|e| failed(&e))?;
    let (Some(mut input), Some(output)) = (child.stdin.take(), child.stdout.take()) else {
        return Err(failed(&"it has no pipes"));
    };
    let mut lines = BufReader::new(output).lines();
    let mut out = Vec::with_capacity(trials.len());
    for (prepared, friction) in trials.iter().zip(friction) {
        let job = match mjcf(prepared, friction, setting) {
            Ok(xml) => job(prepared, xml),
            Err(why) => {
                out.push(Err(why));
                tick();
                continue;
            }
        };
        let text = serde_json::to_string(&job).map_err(|e| failed(&e))?;
        let answered =
            writeln!(input, "{text}").and_then(|()| input.flush()).ok().and_then(|()| lines.next());
        let Some(line) = answered else { break };
        let reply: Reply = serde_json::from_str(&line.map_err(|e| failed(&e))?).map_err(|e| failed(&e))?;
        out.push(match reply {
            Reply::Error { error } => Err(format!("MuJoCo: {error}")),
            Reply::Answer(answer) => Ok(converted(prepared, *answer)),
        });
        tick();
    }
    drop(input);
    let ended = child.wait_with_output().map_err(|e| failed(&e))?;
    let said = String::from_utf8_lossy(&ended.stderr).trim().to_owned();
    if ended.status.code() == Some(NO_WHEEL) {
        return Err(EngineError::NoWheel { python, why: said });
    }
    if out.len() < trials.len() || !ended.status.success() {
        return Err(EngineError::Failed(said));
    }
    Ok(out)
}

fn job(prepared: &Prepared, xml: String) -> Job {
    let poses = prepared.poses();
    let flat = |p: &Pose<f64>| {
        let (x, q) = (p.position_m, p.rotation);
        [x.x, x.y, x.z, q.w, q.i, q.j, q.k]
    };
    let reference = poses.first().and_then(|p| p.pusher).map_or_else(Vector3::zeros, |p| p.position_m);
    Job {
        xml,
        t_s: prepared.t_s.clone(),
        gripper: prepared.scene.fingers.map(|_| poses.iter().map(|p| flat(&p.carrier)).collect()),
        grip_n: prepared.grips_n().to_vec(),
        reference_m: reference.into(),
        rests: prepared.rests(),
    }
}

fn converted(prepared: &Prepared, answer: Answer) -> Run {
    let mut signals = Vec::with_capacity(answer.object.len());
    for (i, pose) in prepared.poses().iter().enumerate().take(answer.object.len()) {
        let mut row = [f64::NAN; COUNT];
        let [x, y, z, w, i1, j, k] = answer.object[i];
        let object = Pose {
            position_m: Vector3::new(x, y, z),
            rotation: UnitQuaternion::new_normalize(Quaternion::new(w, i1, j, k)),
        };
        let local = pose.carrier.to_local(&object);
        row[..6].copy_from_slice(&object_channels(&local, &prepared.start.rotation));
        if prepared.scene.fingers.is_some() {
            row[6..12].copy_from_slice(&answer.finger1[i]);
            row[12..18].copy_from_slice(&answer.finger2[i]);
        }
        if prepared.scene.pusher.is_some() {
            row[18..24].copy_from_slice(&answer.pusher[i]);
        }
        signals.push(row);
    }
    let n = signals.len();
    Run {
        simulated: Simulated {
            signals,
            unsolved: 0,
            worst_residual_n: 0.0,
            slip_m_s: vec![[f64::NAN; 2]; n],
            normal_n: answer.normal,
        },
        pusher_points: answer.points.iter().map(|p| p[2]).collect(),
        steps: answer.steps,
        step_s: answer.step_s,
        warnings: answer.warnings,
        version: answer.version,
    }
}
