//! What force sensors do to features, without simulating again.
//!
//! An effect of the sensors alone ([`stickslip_shared::effects::Role::Sensing`]) changes no motion, and features are means over bins: what it
//! makes of a mean is the mean of what it makes. That holds for constant errors, gains, turns and crosstalk, all linear
//! in the wrench as long as the grip keeps its sign. The peak of the onset is a departure from a mean, which a
//! constant does not change; that the peaks of all channels come together is an approximation, as is the wrench
//! before the effect by first order. So it serves for sensitivities; fits judge by simulations.

use nalgebra::UnitQuaternion;
use stickslip_shared::effects::{Effect, Environment, Reading, StepContext, find, law};
use stickslip_shared::model::Model;
use stickslip_shared::real::Vec3;

use crate::fit::features::{FEATURES, Features};
use crate::fit::free::Free;
use crate::fit::phases::{BINS, PEAK};

/// First channel of the sum of both fingers' wrenches, of their difference, and of the pusher's.
const SUM: usize = 6;
const DIFFERENCE: usize = 12;
const PUSHER: usize = 18;

/// Whether `free` is of an effect of the sensors alone.
pub fn is_sensed(free: &Free) -> bool {
    matches!(free, Free::Effect { effect, .. } if find(effect).is_some_and(|info| info.role.is_sensing()))
}

/// The features `predicted` as they are where `after` stands in place of `before`, which differ in effects of the sensors alone.
pub fn moved(predicted: &[Features], before: &Model<f64>, after: &Model<f64>) -> Vec<Features> {
    let pairs = || before.effects.iter().zip(&after.effects).filter(|(b, a)| b != a);
    let one = |features: &Features| {
        let mut out = features.clone();
        for (before, after) in pairs() {
            let mut without = features.clone();
            add(&mut without, &shown(before, features), -1.0);
            add(&mut out, &shown(before, &without), -1.0);
            add(&mut out, &shown(after, &without), 1.0);
        }
        out
    };
    predicted.iter().map(one).collect()
}

/// What `effect` adds to `features`.
pub fn shown(effect: &Effect<f64>, features: &Features) -> Features {
    let mut out = vec![0.0; FEATURES];
    let nothing = sensed(effect, [[0.0; 6]; 3]);
    for bin in 0..BINS {
        let of = |first: usize| -> [f64; 6] {
            std::array::from_fn(|axis| {
                let x = features[(first + axis) * BINS + bin];
                if x.is_finite() { x } else { 0.0 }
            })
        };
        let (sum, difference, pusher) = (of(SUM), of(DIFFERENCE), of(PUSHER));
        let finger = |sign: f64| std::array::from_fn(|axis| 0.5 * (sum[axis] + sign * difference[axis]));
        let wrenches = [finger(1.0), finger(-1.0), pusher];
        let after = sensed(effect, wrenches);
        for axis in 0..6 {
            let constant = |k: usize| if bin == PEAK { nothing[k][axis] } else { 0.0 };
            let change = |k: usize| after[k][axis] - wrenches[k][axis] - constant(k);
            out[(SUM + axis) * BINS + bin] = change(0) + change(1);
            out[(DIFFERENCE + axis) * BINS + bin] = change(0) - change(1);
            out[(PUSHER + axis) * BINS + bin] = change(2);
        }
    }
    out
}

/// What sensors with `effect` show of the wrenches of finger 1, finger 2 and pusher.
fn sensed(effect: &Effect<f64>, [finger1, finger2, pusher]: [[f64; 6]; 3]) -> [[f64; 6]; 3] {
    let (position_m, rotation) = (Vec3::zeros(), UnitQuaternion::identity());
    let mut reading = Reading { position_m, rotation, finger: [finger1, finger2], pusher };
    if let Some(law) = law::<f64>(effect.code) {
        law.sense(&effect.parameters, &nowhere(), &mut reading);
    }
    let [finger1, finger2] = reading.finger;
    [finger1, finger2, reading.pusher]
}

/// A step that effects of the sensors alone do not look at.
fn nowhere() -> StepContext<f64> {
    let (zero, still) = (Vec3::zeros(), UnitQuaternion::identity());
    let nothing = Environment { normal: zero, along_y: zero, turning_rad_s: zero, angular_rad_s: zero };
    StepContext {
        time_s: 0.0,
        dt_s: 0.0,
        trial: 0.0,
        grip_cmd_n: 0.0,
        grip_rate_n_s: 0.0,
        position_m: zero,
        rotation: still,
        carrier: still,
        slip_m: [0.0; 4],
        slip_speed_m_s: [0.0; 4],
        load_n: [0.0; 4],
        load_rate_n_s: [0.0; 4],
        environment: [nothing; 2],
        stretch_m: [[0.0; 2]; 2],
        fingers: None,
        pusher: None,
        whole_face: false,
        velocity_m_s: zero,
        angular_rad_s: zero,
    }
}

fn add(to: &mut Features, what: &Features, times: f64) {
    for (to, what) in to.iter_mut().zip(what) {
        *to += times * what;
    }
}
