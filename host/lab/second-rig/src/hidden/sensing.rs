//! Effects of the sensors.

use nalgebra::{SMatrix, Vector3};
use rand_chacha::ChaCha8Rng;
use serde_json::{Map, Value, json};

use super::scale::{Scale, named};
use crate::random::{chance, normal, pick, sign};
use crate::reality::Reality;

type Out = Map<String, Value>;

/// Both finger sensors, or the pusher's; where nothing is grasped only that.
fn which(s: &Scale, rng: &mut ChaCha8Rng) -> Vec<usize> {
    if s.grasped && chance(rng, 0.75) { vec![0, 1] } else { vec![2] }
}

pub fn gain(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    let gain = (0.06 * s.level).min(0.4) * sign(rng);
    let at = if r.sensors.pusher_measured { which(&s, rng) } else { vec![0, 1] };
    for &k in &at {
        r.sensors.faults[k].gain = gain;
    }
    let mut out = named([("gain", gain)]);
    out.insert("sensors".into(), json!(at));
    out
}

pub fn misalignment(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    let way = Vector3::new(normal(rng), normal(rng), normal(rng)).normalize();
    let turn = way * (0.04 * s.level).min(0.2);
    let k = pick(rng, &[0, 1, 2]);
    r.sensors.faults[k].misaligned = turn;
    let mut out = named([("x_rad", turn.x), ("y_rad", turn.y), ("z_rad", turn.z)]);
    out.insert("sensors".into(), json!([k]));
    out
}

pub fn crosstalk(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    let size = (0.025 * s.level).min(0.15);
    let at = which(&s, rng);
    for &k in &at {
        let mut m = SMatrix::<f64, 6, 6>::from_fn(|_, _| size * normal(rng));
        m.fill_diagonal(0.0);
        r.sensors.faults[k].crosstalk = m;
    }
    let mut out = named([("share", size)]);
    out.insert("sensors".into(), json!(at));
    out
}

pub fn bias(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    let k = pick(rng, &[0, 1, 2]);
    let stated = if k == 2 { r.sensors.pusher } else { r.sensors.finger };
    let times = 1.0 + 1.5 * s.level;
    let mut bias = [0.0; 6];
    for i in [rand::Rng::random_range(rng, 0..3), rand::Rng::random_range(rng, 3..6)] {
        let bound = if i < 3 { stated.force_uncertainty_n } else { stated.torque_uncertainty_nm };
        bias[i] = times * bound * sign(rng);
        r.sensors.faults[k].bias[i] = bias[i];
    }
    let mut out = named([("times_the_stated_uncertainty", times)]);
    out.insert("bias".into(), json!(bias));
    out.insert("sensors".into(), json!([k]));
    out
}

pub fn latency(r: &mut Reality, s: Scale, _: &mut ChaCha8Rng) -> Out {
    r.sensors.latency_s = (0.02 * s.level).min(0.12);
    named([("latency_s", r.sensors.latency_s)])
}
