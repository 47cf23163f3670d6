//! What may be fitted: friction coefficients and parameters of effects.

use schemars::JsonSchema;
use serde::Serialize;
use stickslip_shared::effects::{Expected, Info, Parameter, Role, find};
use stickslip_shared::model::Model;

use crate::evidence::pads::{self, SD_OF_RANGE};
use crate::fit::campaign::Campaign;

/// A parameter of the model that is fitted.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Free {
    /// Friction of the fingertips.
    FingerFriction,
    /// Friction of the pusher.
    PusherFriction,
    /// Friction of the table.
    SupportFriction,
    /// A parameter of an effect.
    Effect {
        /// Place of the effect in the model.
        slot: usize,
        /// Place of the parameter in its description.
        parameter: usize,
        /// Its description.
        #[serde(skip)]
        of: &'static Parameter,
        /// Name of the effect, for a formula the user's.
        #[serde(skip)]
        effect: &'static str,
    },
}

impl Free {
    /// All parameters of the effect in `slot`.
    pub fn of_effect(info: &'static Info, slot: usize) -> Vec<Free> {
        let each = info.parameters.iter().enumerate();
        each.map(|(parameter, of)| Free::Effect { slot, parameter, of, effect: info.id }).collect()
    }

    /// The same parameter once the effect in `gone` is taken out; `None` for its own.
    pub fn without_slot(&self, gone: usize) -> Option<Free> {
        match *self {
            Free::Effect { slot, .. } if slot == gone => None,
            Free::Effect { slot, parameter, of, effect } if slot > gone => {
                Some(Free::Effect { slot: slot - 1, parameter, of, effect })
            }
            other => Some(other),
        }
    }

    /// Value in `model`; NaN where it does not have it.
    pub fn get(&self, model: &Model<f64>) -> f64 {
        match self {
            Free::FingerFriction => model.friction.finger,
            Free::PusherFriction => model.friction.pusher,
            Free::SupportFriction => model.friction.support,
            Free::Effect { slot, parameter, .. } => model
                .effects
                .get(*slot)
                .and_then(|e| e.parameters.get(*parameter))
                .copied()
                .unwrap_or(f64::NAN),
        }
    }

    /// Sets it, within its bounds.
    pub fn set(&self, model: &mut Model<f64>, value: f64) {
        let (low, high) = self.bounds();
        let value = value.clamp(low, high);
        match self {
            Free::FingerFriction => model.friction.finger = value,
            Free::PusherFriction => model.friction.pusher = value,
            Free::SupportFriction => model.friction.support = value,
            Free::Effect { slot, parameter, .. } => {
                if let Some(p) = model.effects.get_mut(*slot).and_then(|e| e.parameters.get_mut(*parameter)) {
                    *p = value;
                }
            }
        }
    }

    /// How far the strength of an effect is from its absence; zero for what has no absence, and for friction.
    pub fn departure(&self, model: &Model<f64>) -> f64 {
        match self {
            Self::Effect { of, .. } if of.typical != of.neutral => self.get(model) - of.neutral,
            _ => 0.0,
        }
    }

    /// Smallest and largest value that makes sense.
    pub fn bounds(&self) -> (f64, f64) {
        match self.described() {
            Some(p) => (p.low, p.high),
            None => (1e-3, 5.0),
        }
    }

    /// `change` within what a linear model may be trusted: friction at most doubles or halves.
    pub fn limited(&self, model: &Model<f64>, change: f64) -> f64 {
        match self {
            Free::Effect { .. } => change,
            _ => {
                let value = self.get(model).max(0.02);
                change.clamp(-0.5 * value, value)
            }
        }
    }

    /// Step of finite differences.
    pub fn step(&self, model: &Model<f64>) -> f64 {
        let value = self.get(model);
        let size = match self.described() {
            Some(p) => {
                let scale = (p.typical - p.neutral).abs();
                if scale > 0.0 { 0.1 * scale } else { 0.1 * p.typical.abs().max(1e-6) }
            }
            None => 0.02 * value.abs().max(0.05),
        };
        let (low, high) = self.bounds();
        if value + size > high && value - size >= low { -size } else { size }
    }

    /// Value where nothing is known: the one given, and for an effect that of its description.
    pub fn home(&self, given: &Model<f64>) -> f64 {
        match self.described() {
            Some(p) => p.neutral,
            None => self.get(given),
        }
    }

    /// What is expected of a property of pads and plate, and of a delay that was measured, before any fit: value and range.
    pub fn expected(&self, campaign: &Campaign) -> Option<(f64, [f64; 2])> {
        let of = self.described()?;
        if let Free::Effect { effect, .. } = self
            && find(effect).is_some_and(|info| info.role == Role::Delay)
        {
            let delay = campaign.delay?;
            let most_s = 0.5 * delay.within_s() / SD_OF_RANGE;
            return Some((delay.late_s, [delay.late_s - most_s, delay.late_s + most_s]));
        }
        campaign.pads().map_or_else(|| pads::unread(of), |pads| pads.expected(of))
    }

    /// Whether it is the compliance of pads that is read off the measurements.
    pub fn is_read_off(&self) -> bool {
        self.described().is_some_and(|p| p.expected == Some(Expected::ReadOff))
    }

    /// Whether every contact has it, as pads that do not stiffen are pads and a plate is even or hollow: at its bounds
    /// it is not pulled as far as it goes.
    pub fn is_usual(&self) -> bool {
        let usual = |of| matches!(of, Expected::Usual(..) | Expected::UsualBesideReadOff(..));
        self.described().and_then(|p| p.expected).is_some_and(usual)
    }

    fn described(&self) -> Option<&'static Parameter> {
        match self {
            Free::Effect { of, .. } => Some(of),
            _ => None,
        }
    }

    /// The coefficient's name in a model file; none for a parameter of an effect.
    pub fn coefficient(&self) -> Option<&'static str> {
        match self {
            Free::FingerFriction => Some("finger"),
            Free::PusherFriction => Some("pusher"),
            Free::SupportFriction => Some("support"),
            Free::Effect { .. } => None,
        }
    }

    /// Name with unit suffix; effects as `effect.parameter`.
    pub fn name(&self) -> String {
        match self {
            Free::Effect { effect, of, .. } => format!("{effect}.{}", of.name),
            _ => format!("friction.{}", self.coefficient().unwrap_or_default()),
        }
    }

    /// Unit as people write it.
    pub fn unit(&self) -> &'static str {
        self.described().map_or("1", |p| p.unit)
    }
}

/// The friction coefficients that the data set's contacts have.
pub fn base_parameters(campaign: &Campaign) -> Vec<Free> {
    let all = [Free::FingerFriction, Free::PusherFriction, Free::SupportFriction].into_iter().enumerate();
    let has = |k: usize| campaign.runs.iter().any(|r| r.prepared.frictions()[k]);
    all.filter(|(k, _)| has(*k)).map(|(_, free)| free).collect()
}
