//! The loop closed: predictor and grip advice, as the board runs them, command the rig's grip.
//!
//! Each trial is run twice from the same seed: with the planned grip, and with the advised one. Objects are lost
//! where neither finger touches at the end. The gripper follows the advice within its own lag and loses of it what the
//! scenario takes. For `stickslip demo` and the study `stickslip-lab grip-loop`.

use anyhow::Context;
use rayon::prelude::*;
use serde::Serialize;
use stickslip_analysis::model::file::default_model;
use stickslip_analysis::run::replay::{Converter, feed};
use stickslip_rig::condition::{Condition, Scenario};
use stickslip_rig::plan::{self, PlanName};
use stickslip_rig::{Exact, Nuisance, Reality, STEP_S, Setup, objects};
use stickslip_shared::predictor::{Limits, Predictor};
use stickslip_shared::wire::{GripLimits, TICK_US};
use stickslip_unit::grip::GripAdvice;

/// What is run.
#[derive(Clone, Debug)]
pub struct Options {
    /// Plan of the rig.
    pub plan: PlanName,
    /// Of the plan's objects; empty: all.
    pub objects: Vec<String>,
    /// Seed of plan, reality and runs.
    pub seed: u64,
    /// Whether the object's pose is measured after the first sample.
    pub sees_object: bool,
    /// Of the gripper.
    pub limits: GripLimits,
}

impl Options {
    /// Lifts of one object, steady ones and each way of losing it. The advice was developed on another seed
    /// (docs/lab/grip-loop.md).
    #[must_use]
    pub fn demonstration() -> Self {
        Self {
            plan: PlanName::Lift,
            objects: vec!["obj4".to_owned()],
            seed: 2,
            sees_object: true,
            limits: GripLimits::default(),
        }
    }
}

/// One trial, without and with the loop.
#[derive(Clone, Debug, Serialize)]
pub struct Pair {
    /// Of the trial.
    pub label: String,
    /// What happens in it.
    pub scenario: &'static str,
    /// Grip that the plan commands at first, N.
    pub planned_n: f64,
    /// With the planned grip.
    pub open: Course,
    /// With the advised one.
    pub closed: Course,
}

/// A pair with all that happened in it.
#[derive(Clone, Debug)]
pub struct Trial {
    /// What came of it.
    pub pair: Pair,
    /// Each moment, with the planned grip and with the advised one.
    pub exact: [Vec<Exact>; 2],
}

impl Trial {
    /// Is the object lost with the planned grip and kept with the advised one?
    #[must_use]
    pub fn saved(&self) -> bool {
        !self.pair.open.kept && self.pair.closed.kept
    }
}

/// How a run went.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Course {
    /// The object is still in the grasp.
    pub kept: bool,
    /// How far it moved in the grasp, m.
    pub slid_m: f64,
    /// Largest force that a finger pressed with, N.
    pub peak_n: f64,
}

/// Normal force below which a finger does not touch, N.
const TOUCH_N: f64 = 0.05;
/// Samples at the end that tell whether the object is there: 0.1 s.
const END: usize = 25;

impl Course {
    fn of(exact: &[Exact]) -> Self {
        let pressed = |e: &Exact| e.finger.map(|w| w[1].abs()).into_iter().fold(0.0, f64::max);
        let kept = exact.iter().rev().take(END).all(|e| pressed(e) > TOUCH_N);
        let held = |e: &Exact| e.object.0[2] - e.gripper.0[2];
        // From where it hangs after the lift: the table carries it before.
        let hung = exact.iter().position(|e| e.support[2].abs() < TOUCH_N).unwrap_or(0);
        let from = exact.get(hung).map_or(0.0, held);
        let slid_m = exact.iter().skip(hung).map(|e| (held(e) - from).abs()).fold(0.0, f64::max);
        Self {
            kept,
            slid_m: if kept { slid_m } else { f64::NAN },
            peak_n: exact.iter().map(pressed).fold(0.0, f64::max),
        }
    }
}

/// Name of what happens.
fn name(scenario: &Scenario) -> &'static str {
    match scenario {
        Scenario::Steady => "steady",
        Scenario::DecayingGrip { .. } => "decaying grip",
        Scenario::SuddenLoad { .. } => "sudden load",
        Scenario::Bumps { .. } => "bumps",
        Scenario::SoftCreep { .. } => "soft creep",
        Scenario::HeavierThanTold { .. } => "heavier than stated",
        Scenario::OffCentre { .. } => "off centre",
        Scenario::FrictionDrop { .. } => "friction drops",
        Scenario::Jam { .. } => "jam",
    }
}

/// Runs every trial of the plan twice.
///
/// # Errors
/// A condition that does not suit, or a scene that the predictor refuses.
pub fn run(options: &Options) -> anyhow::Result<Vec<Trial>> {
    let conditions = plan::conditions(options.plan, &options.objects, options.seed, 1.0);
    let used: Vec<_> = conditions.iter().map(|c| c.object.as_str()).collect();
    let primitives: Vec<_> = conditions.iter().map(|c| c.primitive.name()).collect();
    let description = objects::trimmed(objects::bench("grip-loop"), &primitives, &used);
    let reality = Reality::draw(&description, Nuisance::PAPER, options.seed);
    let setup = Setup { description, reality, step_s: STEP_S };
    let trials = conditions
        .par_iter()
        .map(|condition| trial(&setup, condition, options).with_context(|| condition.label.clone()));
    trials.collect()
}

fn trial(setup: &Setup, condition: &Condition, options: &Options) -> anyhow::Result<Trial> {
    let open = stickslip_rig::run(setup, condition, 1, options.seed).map_err(anyhow::Error::msg)?;
    let fed = feed(&setup.description, &open.trial)?;
    let mut predictor = Predictor::<f32>::new(fed.scene, default_model().cast(), Limits::default())
        .map_err(|why| anyhow::anyhow!("the predictor refuses the scene ({why:?})"))?;
    let mut plan = fed.plan;
    // Nobody planned what happens to the grip.
    plan.segments.iter_mut().for_each(|segment| segment.grip_n = condition.grip_n as f32);
    predictor.set_plan(plan);
    let mut convert = Converter::new(&open.trial);
    let mut advice = GripAdvice::new(options.limits);
    let tick_s = TICK_US as f32 * 1e-6;
    let closed = stickslip_rig::run_controlled(setup, condition, 1, options.seed, &mut |sample| {
        let mut sample = convert.sample(sample);
        if !options.sees_object && sample.seq > 0 {
            sample.object = None;
        }
        let prediction = predictor.take(&sample);
        advice.follow(&prediction, condition.grip_n as f32, tick_s).map(f64::from)
    });
    let closed = closed.map_err(anyhow::Error::msg)?;
    let pair = Pair {
        label: condition.label.clone(),
        scenario: name(&condition.scenario),
        planned_n: condition.grip_n,
        open: Course::of(&open.exact),
        closed: Course::of(&closed.exact),
    };
    Ok(Trial { pair, exact: [open.exact, closed.exact] })
}
