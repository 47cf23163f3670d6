//! What may be added to a model: the effects of the list, and the user's formulas.

use stickslip_shared::effects::formula::{self, Formula};
use stickslip_shared::effects::{Effect, Info, MAX_PARAMETERS, REGISTRY, find};
use stickslip_shared::model::{MAX_FORMULAS, Model};

use crate::model::file::{EffectEntry, ModelFile};
use crate::model::names::{self, UnknownEffect};

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

    /// The effect of an entry of a model file; `None` where this build does not know it.
    pub fn of(entry: &EffectEntry) -> Option<Self> {
        let program = entry.formula.as_ref().map(|f| f.program.clone());
        Some(Self { info: entry.info()?, program })
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

    /// Whether `model` has it, or has no room for one more formula.
    pub fn is_excluded_by(&self, model: &Model<f64>) -> bool {
        match &self.program {
            None => model.effects.iter().any(|e| e.code == self.info.code),
            Some(program) => model.formulas.len() >= MAX_FORMULAS || model.formulas.contains(program),
        }
    }
}

/// A model with the description of each of its effects. The model itself knows its formulas as
/// programs only; their names, units and bounds are those of the user's file.
#[derive(Clone, Debug)]
pub struct Described {
    /// What the predictor runs.
    pub model: Model<f64>,
    /// One for each effect of the model, in its order.
    pub infos: Vec<&'static Info>,
}

impl From<&Model<f64>> for Described {
    /// Formulas are described as [`formula::INFO`] does.
    fn from(model: &Model<f64>) -> Self {
        let infos = model.effects.iter().map(|e| e.info().unwrap_or(&formula::INFO)).collect();
        Self { model: model.clone(), infos }
    }
}

impl From<&ModelFile> for Described {
    fn from(file: &ModelFile) -> Self {
        let model = file.to_model();
        let infos = file.effects.iter().filter_map(EffectEntry::info).take(model.effects.len()).collect();
        Self { model, infos }
    }
}

/// Takes the effect in `slot` out of `model`, with its program where it is a formula.
pub fn remove(model: &mut Model<f64>, slot: usize) {
    let Some(effect) = model.effects.get(slot) else { return };
    if effect.code == formula::CODE {
        let place = model.effects.iter().take(slot).filter(|e| e.code == formula::CODE).count();
        if place < model.formulas.len() {
            model.formulas.remove(place);
        }
    }
    model.effects.remove(slot);
}

/// The effect called `name`: a listed one with its typical parameters, or one of `formulas` as it is.
///
/// # Errors
/// Where there is none; the error proposes names that are alike.
pub fn named(name: &str, formulas: &[EffectEntry]) -> Result<EffectEntry, UnknownEffect> {
    if let Some(info) = find(name) {
        return Ok(EffectEntry::typical(info));
    }
    let found = formulas.iter().find(|f| f.name() == name).cloned();
    found.ok_or_else(|| {
        let mut known: Vec<&str> = formulas.iter().map(EffectEntry::name).collect();
        for id in names::listed() {
            known.push(id);
        }
        UnknownEffect(names::unknown(name, known.into_iter()))
    })
}
