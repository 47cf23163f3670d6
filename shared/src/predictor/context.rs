//! What the predictor knows besides the tracked object: parameters, plan, time, and what was learnt of sensors and
//! friction.

use super::clock::Clock;
use super::params::Params;
use super::plan::{Intent, Plan, Segment};
use super::sag::planned_slide;
use super::types::{Limits, Prediction, flags};
use crate::health::Health;
use crate::model::{Model, Scene};
use crate::observer::Observer;
use crate::real::Real;
use crate::track;

/// All but the tracked object: that is large, and is worked on where it lies.
#[derive(Clone, Debug)]
pub(super) struct Context<R: Real> {
    pub(super) scene: Scene<R>,
    pub(super) model: Model<R>,
    pub(super) limits: Limits,
    pub(super) params: Params,
    pub(super) track: track::Params<R>,
    /// Its start counted from the epoch.
    pub(super) plan: Plan,
    pub(super) clock: Clock,
    pub(super) trial: R,
    pub(super) health: Health<R>,
    pub(super) observer: Observer<R>,
    /// Friction while sliding over that at rest, by the model's effects.
    pub(super) sliding: R,
    /// By how much the object's pose is late, by the model's effects, s.
    pub(super) late_s: R,
    /// Arm of a finger's torsional friction, the model's effects included, m.
    pub(super) torsion_arm_m: R,
    pub(super) last: Prediction,
    /// Of the last tick that stepped.
    pub(super) work: u32,
    /// Of the other formulation.
    pub(super) testimony: super::witness::Testimony,
}

impl<R: Real> Context<R> {
    /// The last prediction, with a doubt more.
    pub(super) fn repeat(&mut self, doubt: u32) -> Prediction {
        Prediction {
            validity: self.last.validity | doubt,
            flags: self.last.flags | flags::UNSURE,
            ..self.last
        }
    }

    /// What a segment means: a slide too slow to be one is none.
    pub(super) fn intended(&self, segment: &Segment) -> Intent {
        match segment.intent {
            Intent::Slide if planned_slide(segment, R::of(f64::from(self.limits.slip_m_s))).is_none() => {
                Intent::Hold
            }
            intent => intent,
        }
    }
}
