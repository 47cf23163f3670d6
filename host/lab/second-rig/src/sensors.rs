//! What the sensors make of the truth: errors that are constant, that drift, that scatter, late
//! and rare poses, and steps.

use nalgebra::{SMatrix, SVector, UnitQuaternion, Vector3};
use rand::Rng;
use serde::Serialize;

use crate::physics::body::Frame;
use crate::physics::record::{Record, Wrench};
use crate::random::{normal, stream};
use crate::trial::{Pickup, TrialSpec};

/// Stated data of one force-torque sensor.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Stated {
    /// N, standard deviation.
    pub force_noise_n: f64,
    /// N, bound on a constant error.
    pub force_uncertainty_n: f64,
    /// N m.
    pub torque_noise_nm: f64,
    /// N m.
    pub torque_uncertainty_nm: f64,
}

/// True errors of one force-torque sensor: force in the first three places, torque in the others.
#[derive(Clone, Debug, Serialize)]
pub struct Faults {
    /// Constant, N and N m.
    pub bias: [f64; 6],
    /// By the end of a minute, N and N m.
    pub drift_per_min: [f64; 6],
    /// Relative.
    pub gain: f64,
    /// Turn of its axes, rad.
    pub misaligned: Vector3<f64>,
    /// Share of each channel that shows in each other one (lengths in 20 mm).
    pub crosstalk: SMatrix<f64, 6, 6>,
}

impl Faults {
    /// None at all.
    pub fn none() -> Self {
        Self {
            bias: [0.0; 6],
            drift_per_min: [0.0; 6],
            gain: 0.0,
            misaligned: Vector3::zeros(),
            crosstalk: SMatrix::zeros(),
        }
    }
}

/// How the object's pose comes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PoseRate {
    /// In every sample.
    Full,
    /// At this rate (Hz), straight lines between.
    Interpolated(f64),
    /// At this rate (Hz), other cells empty.
    Gaps(f64),
}

/// All sensors of a rig.
#[derive(Clone, Debug, Serialize)]
pub struct Sensors {
    /// Hz.
    pub rate_hz: f64,
    /// Force sensors average over this time, s.
    pub window_s: f64,
    /// Does dataset.toml state anything about the sensors?
    pub stated: bool,
    /// Fingers.
    pub finger: Stated,
    /// Pusher.
    pub pusher: Stated,
    /// m.
    pub position_noise_m: f64,
    /// rad.
    pub rotation_noise_rad: f64,
    /// The gripper's pose has the same noise; otherwise it is exact.
    pub gripper_noisy: bool,
    /// True errors of finger 1, finger 2, pusher.
    pub faults: [Faults; 3],
    /// The object's pose is late, s.
    pub latency_s: f64,
    /// The pose's clock is ahead of the force's, s (a nuisance, within a sample or two).
    pub clock_s: f64,
    /// Pose.
    pub pose_rate: PoseRate,
    /// Steps of force (N), torque (N m), position (m).
    pub steps: [f64; 3],
    /// Share of the noise's variance that is low-passed at a tenth of the rate.
    pub coloured: f64,
    /// Has the pusher a force sensor?
    pub pusher_measured: bool,
}

impl Sensors {
    /// No noise, no error, no steps.
    pub fn perfect(rate_hz: f64) -> Self {
        let exact = Stated {
            force_noise_n: 0.0,
            force_uncertainty_n: 0.0,
            torque_noise_nm: 0.0,
            torque_uncertainty_nm: 0.0,
        };
        Self {
            rate_hz,
            window_s: 1.0 / rate_hz,
            stated: true,
            finger: exact,
            pusher: exact,
            position_noise_m: 0.0,
            rotation_noise_rad: 0.0,
            gripper_noisy: false,
            faults: std::array::from_fn(|_| Faults::none()),
            latency_s: 0.0,
            clock_s: 0.0,
            pose_rate: PoseRate::Full,
            steps: [0.0; 3],
            coloured: 0.0,
            pusher_measured: true,
        }
    }
}

/// One row as written: `None` is an empty cell.
#[derive(Clone, Debug)]
pub struct Row {
    /// s.
    pub t_s: f64,
    /// N.
    pub grip_cmd_n: f64,
    /// Position and quaternion w, x, y, z.
    pub gripper: [f64; 7],
    /// The same.
    pub object: Option<[f64; 7]>,
    /// The same, of a pusher that moves.
    pub pusher: Option<[f64; 7]>,
    /// Finger 1, finger 2.
    pub fingers: [[f64; 6]; 2],
    /// Pusher.
    pub pusher_wrench: Option<[f64; 6]>,
}

/// Reads a record. Random numbers depend on the seed and the trial's name.
pub fn read(sensors: &Sensors, trial: &TrialSpec, record: &Record, seed: u64) -> Vec<Row> {
    let s = sensors;
    let rng = &mut stream(seed, &format!("sensors {}", trial.id));
    let samples = &record.samples;
    let moving = trial.pusher.as_ref().is_some_and(|(_, m)| !m.parts.is_empty());
    let mut colour = [[0.0; 6]; 3];
    let mut broad = [[0.0; 6]; 3];
    let phase: [f64; 3] = std::array::from_fn(|_| rng.random_range(0.0..std::f64::consts::TAU));
    let late = |t: f64| t - s.latency_s + s.clock_s;
    let frame_at = |t: f64| {
        let i = (t * s.rate_hz).clamp(0.0, (samples.len() - 1) as f64);
        let k = (i.floor() as usize).min(samples.len().saturating_sub(2));
        let next = samples.get(k + 1).unwrap_or(&samples[k]);
        between(&samples[k].object, &next.object, i - k as f64)
    };
    let mut coarse: Option<[(f64, Frame); 2]> = None;
    let mut rows = Vec::with_capacity(samples.len());
    for sample in samples {
        let t = sample.t_s;
        let mut wrench = |k: usize, truth: &Wrench, stated: &Stated| {
            let noise = [stated.force_noise_n, stated.torque_noise_nm];
            sense(
                s,
                &s.faults[k],
                truth,
                t,
                noise,
                &trial.pickup,
                phase[k],
                &mut colour[k],
                &mut broad[k],
                rng,
            )
        };
        let fingers = [wrench(0, &sample.fingers[0], &s.finger), wrench(1, &sample.fingers[1], &s.finger)];
        let pusher_wrench = (s.pusher_measured && trial.pusher.is_some())
            .then(|| wrench(2, &sample.pusher_wrench, &s.pusher));
        let object = match s.pose_rate {
            PoseRate::Full => Some(noisy(s, &frame_at(late(t)), rng)),
            PoseRate::Gaps(hz) => {
                let now = (t * hz + 1e-6).floor();
                let before = ((t - 1.0 / s.rate_hz) * hz + 1e-6).floor();
                (now > before || t < 1e-9).then(|| noisy(s, &frame_at(late(t)), rng))
            }
            PoseRate::Interpolated(hz) => {
                let first = (t * hz + 1e-6).floor() / hz;
                let fresh = |time: f64, rng: &mut _| (time, noise_frame(s, &frame_at(late(time)), rng));
                let pair = match coarse {
                    Some(pair) if (pair[0].0 - first).abs() < 1e-9 => pair,
                    Some(pair) if (pair[1].0 - first).abs() < 1e-9 => [pair[1], fresh(first + 1.0 / hz, rng)],
                    _ => [fresh(first, rng), fresh(first + 1.0 / hz, rng)],
                };
                coarse = Some(pair);
                Some(written(s, &between(&pair[0].1, &pair[1].1, (t - first) * hz)))
            }
        };
        let mut told = trial.gripper.at(t);
        told.velocity = Vector3::zeros();
        let gripper = if s.gripper_noisy { noisy(s, &told, rng) } else { written(s, &told) };
        rows.push(Row {
            t_s: t,
            grip_cmd_n: trial.grip_told.as_ref().unwrap_or(&trial.grip).at(t),
            gripper,
            object,
            pusher: trial.pusher.as_ref().filter(|_| moving).map(|(_, m)| written(s, &m.at(t))),
            fingers,
            pusher_wrench,
        });
    }
    rows
}

#[allow(clippy::too_many_arguments)]
fn sense(
    s: &Sensors,
    faults: &Faults,
    truth: &Wrench,
    t: f64,
    noise: [f64; 2],
    pickup: &Pickup,
    phase: f64,
    colour: &mut [f64; 6],
    broad: &mut [f64; 6],
    rng: &mut impl Rng,
) -> [f64; 6] {
    let turn = UnitQuaternion::new(faults.misaligned).inverse();
    let (f, m) = (turn * truth.force, turn * truth.torque);
    // Torques count as forces on an arm of 20 mm, so that crosstalk has no unit.
    let arm = 0.02;
    let pure = SVector::<f64, 6>::from_column_slice(&[f.x, f.y, f.z, m.x / arm, m.y / arm, m.z / arm]);
    let mixed = pure * (1.0 + faults.gain) + faults.crosstalk * pure;
    let keep = 1.0 - 0.2;
    let mut out = [0.0; 6];
    for i in 0..6 {
        let torque = i > 2;
        let value = if torque { mixed[i] * arm } else { mixed[i] };
        colour[i] = keep * colour[i] + (1.0_f64 - keep * keep).sqrt() * normal(rng);
        let white = normal(rng);
        let size = noise[usize::from(torque)];
        let mut error = size * (s.coloured.sqrt() * colour[i] + (1.0 - s.coloured).sqrt() * white);
        let scale = if torque { 0.01 } else { 1.0 };
        if pickup.sine_n > 0.0 {
            let angle = std::f64::consts::TAU * pickup.hz * t + phase + i as f64;
            error += scale * pickup.sine_n * angle.sin();
        }
        if pickup.broad_n > 0.0 {
            broad[i] = 0.6 * broad[i] + 0.8 * normal(rng);
            error += scale * pickup.broad_n * broad[i];
        }
        let reading = value + faults.bias[i] + faults.drift_per_min[i] * t / 60.0 + error;
        out[i] = stepped(reading, s.steps[usize::from(torque)]);
    }
    out
}

fn stepped(value: f64, step: f64) -> f64 {
    if step > 0.0 { (value / step).round() * step } else { value }
}

fn between(a: &Frame, b: &Frame, share: f64) -> Frame {
    let u = share.clamp(0.0, 1.0);
    Frame {
        position: a.position + (b.position - a.position) * u,
        rotation: a.rotation.try_slerp(&b.rotation, u, 1e-12).unwrap_or(a.rotation),
        ..*a
    }
}

fn noise_frame(s: &Sensors, frame: &Frame, rng: &mut impl Rng) -> Frame {
    let mut vector = || Vector3::new(normal(rng), normal(rng), normal(rng));
    let position = frame.position + vector() * s.position_noise_m;
    Frame {
        position,
        rotation: UnitQuaternion::new(vector() * s.rotation_noise_rad) * frame.rotation,
        ..*frame
    }
}

fn noisy(s: &Sensors, frame: &Frame, rng: &mut impl Rng) -> [f64; 7] {
    written(s, &noise_frame(s, frame, rng))
}

fn written(s: &Sensors, frame: &Frame) -> [f64; 7] {
    let p = frame.position.map(|x| stepped(x, s.steps[2]));
    let q = frame.rotation;
    [p.x, p.y, p.z, q.w, q.i, q.j, q.k]
}
