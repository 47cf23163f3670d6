//! Friction utilisation of each finger from its measured wrench, without motion: force
//! against the Coulomb limit.

use stickslip_shared::model::{Model, Scene};
use stickslip_shared::real::Real;
use stickslip_shared::wire::{
    FingerPrediction, FingerState, ModelFault, NEVER_MS, Plan, Prediction, Sample, SolverStatus,
};

use crate::slot::Control;

/// Coulomb's limit at the fingertips.
pub struct Holding {
    friction: f32,
}

impl Control for Holding {
    const CONTACTS: u16 = 24;

    fn build(_: Scene<f32>, model: Model<f32>) -> Result<Self, ModelFault> {
        let friction = model.friction.finger;
        if friction.is_finite() && friction > 0.0 {
            Ok(Self { friction })
        } else {
            Err(ModelFault::Parameter)
        }
    }

    fn restart(&mut self) {}

    fn set_plan(&mut self, _: &Plan) {}

    fn tick(&mut self, sample: &Sample) -> Prediction {
        let finger = sample.finger.map(|wrench| {
            let Some([fx, fy, fz, ..]) = wrench else {
                return FingerPrediction { slip_in_ms: NEVER_MS, ..Default::default() };
            };
            let used = (fx * fx + fz * fz).root() / (self.friction * fy.abs()).max(1e-6);
            let state = if used < 1.0 { FingerState::Sticking } else { FingerState::Slipping };
            FingerPrediction { state, utilisation: used, slip_in_ms: NEVER_MS, ..Default::default() }
        });
        Prediction {
            finger,
            drop_in_ms: NEVER_MS,
            solver: SolverStatus::Solved,
            ..Default::default()
        }
    }
}
