//! What may be added to a model: the effects of the list, and the user's formulas.

use stickslip_shared::effects::formula::Formula;
use stickslip_shared::effects::{Effect, Info, MAX_PARAMETERS, REGISTRY};
use stickslip_shared::model::Model;

/// An effect that may be added to a model: one of the list, or the user's own formula.
#[derive(Clone, Debug)]
pub struct CandidateEffect {
    /// Description.
    pub info: &'static Info,
    /// What runs, for a formula.
    pub program: Option<Formula<f64>>,
}

impl CandidateEffect {
    /// All effects of the list.
    pub fn listed() -> Vec<CandidateEffect> {
        REGISTRY.iter().map(|info| CandidateEffect { info, program: None }).collect()
    }

    /// `model` with the effect as its last.
    pub fn on(&self, model: &Model<f64>, parameters: [f64; MAX_PARAMETERS]) -> Model<f64> {
        let mut model = model.clone();
        let _ = model.effects.push(Effect { code: self.info.code, parameters });
        if let Some(program) = &self.program {
            let _ = model.formulas.push(program.clone());
        }
        model
    }
}
