//! Trials of the rig and the models' answers to them.

use rayon::prelude::*;
use stickslip_shared::model::{Base, Friction, Model};

use stickslip_analysis::channels::Signals;
use stickslip_analysis::run::simulate::{Prepared, prepare};
use stickslip_rig::{self, Condition, Nuisance, Reality, STEP_S, Setup, objects};

/// Friction of the bench and of the models.
#[derive(Clone, Copy, Debug)]
pub struct Bench {
    /// Fingers.
    pub finger: f64,
    /// Pusher (platform while rolling).
    pub pusher: f64,
}

/// One trial: as the rig measured it, as both models predict it.
pub struct Run {
    /// Ready to simulate.
    pub prepared: Prepared,
    /// The rig's measurement.
    pub rig: Vec<Signals>,
    /// Hard contact.
    pub hard: Vec<Signals>,
    /// Soft contact.
    pub soft: Vec<Signals>,
    /// Samples in which the gripper or pusher moves.
    pub moving: std::ops::Range<usize>,
}

impl Bench {
    /// The middle of the paper's ranges.
    pub const PAPER: Self = Self { finger: 0.4, pusher: 0.25 };

    /// A model with this friction.
    pub fn model(&self, base: Base<f64>) -> Model<f64> {
        // A platform under the object has the support's coefficient.
        let friction = Friction { finger: self.finger, pusher: self.pusher, support: self.pusher };
        Model::base(base, friction)
    }

    /// Runs rig and models on each condition.
    ///
    /// # Errors
    /// Where the rig refuses a condition.
    pub fn runs(&self, conditions: &[Condition]) -> anyhow::Result<Vec<Run>> {
        let description = objects::bench("findings");
        let mut reality = Reality::ideal(self.finger, self.pusher);
        reality.mu_platform = self.pusher;
        reality.nuisance = Nuisance { noise: 0.2, ..Nuisance::NONE };
        let setup = Setup { description, reality, step_s: STEP_S };
        conditions
            .par_iter()
            .map(|condition| {
                let trial = stickslip_rig::simulate(&setup, condition, 1, 1).map_err(anyhow::Error::msg)?;
                let prepared = prepare(&setup.description, &trial, 0)?;
                let speed = prepared.drive_speed();
                let first = speed.iter().position(|s| *s > 1e-5).unwrap_or(0);
                let last = speed.iter().rposition(|s| *s > 1e-5).unwrap_or(0);
                let hard = prepared.simulate(&self.model(Base::Hard)).signals;
                let soft = prepared.simulate(&self.model(Base::rubber_pad())).signals;
                let rig = prepared.measured.clone();
                Ok(Run { prepared, rig, hard, soft, moving: first..last + 1 })
            })
            .collect()
    }
}

impl Run {
    /// `f` of the rig's, the hard and the soft model's signals.
    pub fn each<T>(&self, f: impl Fn(&[Signals]) -> T) -> [T; 3] {
        [f(&self.rig), f(&self.hard), f(&self.soft)]
    }

    /// Samples of a part of the motion, `from` and `to` as shares of it.
    pub fn part(&self, from: f64, to: f64) -> std::ops::Range<usize> {
        let n = self.moving.len() as f64;
        let at = |share: f64| self.moving.start + (share * n) as usize;
        at(from)..at(to).max(at(from) + 1)
    }

    /// Mean of a channel over a part of the motion.
    pub fn mean(&self, signals: &[Signals], channel: usize, from: f64, to: f64) -> f64 {
        let rows = signals.get(self.part(from, to)).unwrap_or_default();
        let seen: Vec<f64> = rows.iter().map(|r| r[channel]).filter(|x| x.is_finite()).collect();
        seen.iter().sum::<f64>() / seen.len() as f64
    }

    /// Change of a channel from the first sample to the end of the motion.
    pub fn change(&self, signals: &[Signals], channel: usize) -> f64 {
        let end = self.part(0.97, 1.0);
        let rows = signals.get(end).unwrap_or_default();
        let mean = rows.iter().map(|r| r[channel]).sum::<f64>() / rows.len() as f64;
        mean - signals.first().map_or(f64::NAN, |r| r[channel])
    }
}

/// Three figures as text: rig, hard, soft.
pub fn texts<T>(values: [T; 3], show: impl Fn(&T) -> String) -> [String; 3] {
    values.map(|v| show(&v))
}
