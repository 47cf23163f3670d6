//! The predictor in single precision, as a board calls it.
//!
//! These functions are compiled in this crate, for speed: what is generic would be compiled with the firmware, and that is
//! compiled for size (`[profile.firmware]` in the workspace's Cargo.toml).

use crate::predictor::{ModelError, Plan, Prediction, Predictor, validate, validate_limits};
use crate::wire::{ModelPackage, Sample};

/// # Errors
/// What the predictor cannot run.
pub fn check(package: &ModelPackage) -> Result<(), ModelError> {
    let (scene, model, limits) = package;
    validate(scene, model).and_then(|()| validate_limits(limits))
}

/// A predictor of a package that passed [`check`], in place of the one before. In a run it goes on: with the plan,
/// the friction learnt and the object.
#[inline(never)]
pub fn install(package: ModelPackage, place: &mut Option<Predictor<f32>>, running: bool) {
    let (scene, model, limits) = package;
    match place {
        Some(predictor) if running => predictor.swap(scene, model, limits),
        _ => *place = Some(Predictor::of_valid(scene, model, limits)),
    }
}

/// For a run at this place of its data set.
#[inline(never)]
pub fn begin(predictor: &mut Predictor<f32>, trial: f32) {
    predictor.restart();
    predictor.set_trial(trial);
}

/// What the gripper will do.
#[inline(never)]
pub fn set_plan(predictor: &mut Predictor<f32>, plan: Plan) {
    predictor.set_plan(plan);
}

/// The tick.
#[inline(never)]
pub fn take(predictor: &mut Predictor<f32>, sample: &Sample) -> Prediction {
    predictor.take(sample)
}
