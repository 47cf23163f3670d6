//! The object's pose as motion capture shows it late: where the object was, seen from where its carrier is.
//!
//! A step of the model shows it late by `latency` times the speed at that moment ([`stickslip_shared::effects::mocap_latency`]); an
//! object that has just been stopped, by a plate that it was carried to, has none, and is seen to move on for as long as the
//! pose is late. Along a recorded trial what was before is known.

use nalgebra::UnitQuaternion;
use stickslip_shared::contact::SLOTS;
use stickslip_shared::step::State;
use stickslip_shared::track::{Pose, Poses};

use crate::channels::{Signals, object_channels};
use crate::run::motion::between;

/// The object along a trial, in steps of the model.
#[derive(Clone, Debug, Default)]
pub struct Track {
    /// Time in s and the object in the world, at each step.
    object: Vec<(f64, Pose<f64>)>,
    /// The carrier in the world, and how many samples were recorded with the step.
    carrier: Vec<(Pose<f64>, usize)>,
}

impl Track {
    /// A step that ended in `state`, with the carrier as it is `at` that time, and is recorded for all of the first `samples`
    /// that none before was recorded for.
    pub fn push(&mut self, at: &Poses<f64>, state: &State<f64, SLOTS>, samples: usize) {
        let local = Pose { position_m: state.position_m, rotation: state.rotation };
        self.object.push((at.t_s, at.carrier.to_world(&local)));
        self.carrier.push((at.carrier, samples));
    }

    /// Where `late_s` is not zero, puts the channels of the pose that much later (early where it is negative) into `signals`;
    /// `start` is the object's rotation at the start. Before the first step, and after the last, it rests.
    pub fn show(&self, late_s: f64, start: &UnitQuaternion<f64>, signals: &mut [Signals]) {
        if late_s == 0.0 {
            return;
        }
        let times = self.object.iter().map(|(t_s, _)| t_s - late_s);
        let was = between(&self.object, times).unwrap_or_default();
        let mut from = 0;
        for (object, (carrier, to)) in was.iter().zip(&self.carrier) {
            let pose = object_channels(&carrier.to_local(object), start);
            for row in signals.iter_mut().take(*to).skip(from) {
                row[..6].copy_from_slice(&pose);
            }
            from = *to;
        }
    }
}
