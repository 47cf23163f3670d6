//! The rig: a synthetic reality that makes data sets like a real bench does.
//!
//! It shares nothing with the predictor. Contacts are springs, dampers and bristles on
//! many points, stepped at some ten microseconds ([`patch`]); the predictor solves
//! complementarity problems at 4 ms. Runs differ as in the paper (friction, placing,
//! pressure), sensors err within what the data set states, and hidden effects put in
//! physics that a base model does not have. Everything follows from one seed.
//! `docs/rig.md` describes the geometry and the readings of the paper.

pub mod body;
pub mod condition;
pub mod drive;
pub mod fingers;
pub mod hidden;
pub mod law;
pub mod objects;
pub mod patch;
pub mod plan;
pub mod reality;
pub mod scene;
pub mod sensors;
pub mod shape;
pub mod surroundings;
pub mod truth;
pub mod world;

use stickslip_data::{Description, Sample, Trial, TrialInfo};

pub use condition::{Condition, Primitive, Scenario};
pub use hidden::{HiddenEffect, Kind};
pub use reality::{Nuisance, Reality};
pub use truth::Truth;
pub use world::Exact;

/// Step of the simulation, s. Halving it changes forces by less than 1 % (tested).
pub const STEP_S: f64 = 4e-5;

/// A bench: what is told about it, and what is really so.
#[derive(Clone, Debug)]
pub struct Setup {
    /// `dataset.toml`.
    pub description: Description,
    /// What its reader is not told.
    pub reality: Reality,
    /// Step of the simulation, s.
    pub step_s: f64,
}

/// One run as it really was, and as it was measured.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// As measured.
    pub trial: Trial,
    /// True values at each sample.
    pub exact: Vec<Exact>,
    /// True parameters.
    pub truth: Truth,
}

/// Runs one trial and keeps the truth beside the measurement. Deterministic: the same
/// setup, condition, run and seed give the same bits.
///
/// # Errors
/// Says which value of the condition or the description does not suit.
pub fn run(setup: &Setup, condition: &Condition, run: usize, seed: u64) -> Result<Outcome, String> {
    run_controlled(setup, condition, run, seed, &mut |_| None)
}

/// The same with a controller of the grip in the loop: it sees each sample as it is measured and may command the
/// grip force of each finger from then on, N; `None`: as planned.
///
/// # Errors
/// As [`run`].
pub fn run_controlled(
    setup: &Setup,
    condition: &Condition,
    run: usize,
    seed: u64,
    control: &mut dyn FnMut(&Sample) -> Option<f64>,
) -> Result<Outcome, String> {
    let description = &setup.description;
    let object = description
        .objects
        .iter()
        .find(|o| o.id == condition.object)
        .ok_or_else(|| format!("{}: no object {}", condition.label, condition.object))?;
    let name = format!("{}-r{run}", condition.label);
    let mut rng = reality::stream(seed, &name);
    let mut of_condition = reality::stream(seed, &condition.label);
    let truth = setup.reality.truth(description, object, condition, &mut rng, &mut of_condition);
    let placing = setup.reality.placing(&mut rng);
    let mut scene = scene::set(description, object, condition, truth, placing)?;
    let period_s = 1.0 / description.sample_rate_hz;
    let errors = scene.world.truth.sensors.clone();
    let mut samples = Vec::new();
    let exact = scene.world.run(scene.drive, period_s, setup.step_s, &mut |so_far| {
        let sample = sensors::measure(so_far, &errors, &scene.equipment, &mut rng)?;
        let commanded_n = control(&sample);
        samples.push(sample);
        commanded_n
    });
    let truth = scene.world.truth;
    let used = |on: bool, value: f64| on.then_some(value);
    let p = condition.primitive;
    let info = TrialInfo {
        file: format!("trials/{name}.csv"),
        trial: name,
        object: condition.object.clone(),
        primitive: p.name().into(),
        grip_n: used(p != Primitive::PlanarPush, condition.grip_n),
        speed_m_s: used(p != Primitive::Pivot, condition.speed_m_s),
        speed_rad_s: used(p == Primitive::Pivot, condition.speed_rad_s),
        slope_rad: used(matches!(p, Primitive::LinearPush | Primitive::PlanarPush), condition.slope_rad),
        pusher_offset_m: used(
            matches!(p, Primitive::Pivot | Primitive::PlanarPush),
            condition.pusher_offset_m,
        ),
        run: i64::try_from(run).ok(),
        pusher: scene.pusher,
        extra: Default::default(),
    };
    Ok(Outcome { trial: Trial { info, samples }, exact, truth })
}

/// Runs one trial and keeps only the measurement; see [`run`].
///
/// # Errors
/// As [`run`].
pub fn simulate(setup: &Setup, condition: &Condition, run: usize, seed: u64) -> Result<Trial, String> {
    self::run(setup, condition, run, seed).map(|outcome| outcome.trial)
}
