//! Effects of the jaw.

use rand_chacha::ChaCha8Rng;
use serde_json::{Map, Value};

use super::scale::{Scale, named};
use crate::random::{log_uniform, sign};
use crate::reality::Reality;

type Out = Map<String, Value>;

pub fn face_tilt(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    r.taper = (0.008 * s.level).min(0.06) * sign(rng);
    r.jaw.gear_n_m = log_uniform(rng, 8e3, 4e4);
    named([("slope_rad", r.taper), ("jaw_n_m", r.jaw.gear_n_m)])
}

pub fn loss(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    r.jaw.loss = (0.1 * s.level).min(0.5) * if rand::Rng::random_bool(rng, 0.8) { 1.0 } else { -0.6 };
    named([("fraction", r.jaw.loss)])
}

pub fn lag(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    let recovery = log_uniform(rng, 0.05, 1.0);
    // The share lost by the end of a push of the plan's distance and speed.
    let lost = (0.15 * s.level).min(0.6);
    let slid = recovery * (1.0 - (-s.distance_m / s.speed_m_s / recovery).exp()) * s.speed_m_s;
    r.jaw.slip_loss_most = 0.7;
    r.jaw.slip_loss_1_m = lost / slid;
    r.jaw.slip_recovery_s = recovery;
    named([("loss_1_m", r.jaw.slip_loss_1_m), ("recovery_s", recovery), ("share_at_typical_speed", lost)])
}
