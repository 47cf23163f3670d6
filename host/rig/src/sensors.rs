//! What the sensors make of the true values: gain, misalignment, crosstalk, constant
//! and drifting errors, white noise, delay, and the steps of the recording: 0.1 mN, 1 uN m, 0.1 um and
//! 1e-7 in a quaternion, all far below the noise.

use nalgebra::{UnitQuaternion, Vector3};
use rand::Rng;
use rand_distr::StandardNormal;

use stickslip_data::{Pose, Sample, Wrench};

use super::truth::SensorErrors;
use super::world::Exact;

/// Which sensors the trial has.
#[derive(Clone, Copy, Debug)]
pub struct Equipment {
    /// Fingertip force/torque sensors.
    pub fingers: bool,
    /// Force/torque sensor behind the pusher.
    pub pusher: bool,
    /// Orientation of a moving pusher, quaternion w, x, y, z.
    pub rod_attitude: [f64; 4],
}

/// The newest of `exact` as it is measured; `None` where there is none. To be called once for each, in order: the
/// errors are drawn from `rng`.
pub fn measure(
    exact: &[Exact],
    errors: &SensorErrors,
    equipment: &Equipment,
    rng: &mut impl Rng,
) -> Option<Sample> {
    let (first, now) = (exact.first()?, exact.last()?);
    let since_s = now.t_s - first.t_s;
    let error = |k: usize| std::array::from_fn(|c| errors.bias[k][c] + errors.drift[k][c] * since_s);
    let object = delayed(exact, exact.len() - 1, errors.mocap_latency_s);
    Some(Sample {
        t_s: recorded(now.t_s, 1e6),
        grip_cmd_n: equipment.fingers.then_some(recorded(now.grip_n, 1e4)),
        gripper: equipment.fingers.then(|| noisy_pose(now.gripper, errors.pose_noise, rng)),
        object: Some(noisy_pose(object, errors.pose_noise, rng)),
        pusher: now.rod.map(|p| noisy_pose((p, equipment.rod_attitude), errors.pose_noise, rng)),
        finger: [0, 1].map(|f| {
            equipment.fingers.then(|| {
                let seen = finger_reading(&now.finger[f], errors);
                noisy_wrench(&seen, &error(f), errors.noise[0], rng)
            })
        }),
        pusher_wrench: equipment.pusher.then(|| {
            let seen = match equipment.fingers {
                true => now.pusher,
                false => pusher_reading(&now.pusher, errors),
            };
            noisy_wrench(&seen, &error(2), errors.noise[1], rng)
        }),
    })
}

fn finger_reading(w: &[f64; 6], errors: &SensorErrors) -> [f64; 6] {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), errors.misalignment_rad);
    let mut seen = turned(w, &turn);
    seen[0] += errors.crosstalk * w[1];
    seen.map(|x| x * (1.0 + errors.gain))
}

fn pusher_reading(w: &[f64; 6], errors: &SensorErrors) -> [f64; 6] {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), errors.misalignment_rad);
    let mut seen = turned(w, &turn);
    seen[1] += errors.crosstalk * w[0];
    seen.map(|x| x * (1.0 + errors.gain))
}

fn turned(w: &[f64; 6], turn: &UnitQuaternion<f64>) -> [f64; 6] {
    let (f, t) = (turn * Vector3::new(w[0], w[1], w[2]), turn * Vector3::new(w[3], w[4], w[5]));
    [f.x, f.y, f.z, t.x, t.y, t.z]
}

/// The object's pose as it was `latency_s` ago, linear between samples.
fn delayed(exact: &[Exact], i: usize, latency_s: f64) -> ([f64; 3], [f64; 4]) {
    let now = exact[i].t_s - latency_s;
    let after = exact.partition_point(|e| e.t_s < now);
    if latency_s <= 0.0 || after == 0 {
        return exact[if latency_s <= 0.0 { i } else { 0 }].object;
    }
    let (a, b) = (&exact[after - 1], &exact[after]);
    let share = (now - a.t_s) / (b.t_s - a.t_s);
    let mix = |x: f64, y: f64| x + (y - x) * share;
    let position = std::array::from_fn(|k| mix(a.object.0[k], b.object.0[k]));
    // Neighbouring samples turn by far less than a right angle: straight mixing will do.
    let q: [f64; 4] = std::array::from_fn(|k| mix(a.object.1[k], b.object.1[k]));
    let size = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    (position, q.map(|x| x / size))
}

fn noisy_wrench(w: &[f64; 6], bias: &[f64; 6], noise: [f64; 2], rng: &mut impl Rng) -> Wrench {
    let x: [f64; 6] = std::array::from_fn(|k| {
        let sigma = if k < 3 { noise[0] } else { noise[1] };
        w[k] + bias[k] + sigma * rng.sample::<f64, _>(StandardNormal)
    });
    Wrench {
        force_n: [x[0], x[1], x[2]].map(|f| recorded(f, 1e4)),
        torque_nm: [x[3], x[4], x[5]].map(|t| recorded(t, 1e6)),
    }
}

fn noisy_pose(pose: ([f64; 3], [f64; 4]), noise: [f64; 2], rng: &mut impl Rng) -> Pose {
    let position_m = pose.0.map(|x| recorded(x + noise[0] * rng.sample::<f64, _>(StandardNormal), 1e7));
    let turn: [f64; 3] = std::array::from_fn(|_| noise[1] * rng.sample::<f64, _>(StandardNormal));
    let [w, x, y, z] = pose.1;
    let q = UnitQuaternion::from_scaled_axis(Vector3::from(turn))
        * UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, x, y, z));
    Pose { position_m, quaternion: [q.w, q.i, q.j, q.k].map(|x| recorded(x, 1e7)) }
}

/// Rounded to steps of `1 / per_unit`.
fn recorded(x: f64, per_unit: f64) -> f64 {
    // Adding zero turns a negative zero into a plain one.
    (x * per_unit).round() / per_unit + 0.0
}
