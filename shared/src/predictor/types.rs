//! What goes into a tick and what comes out of it.

use crate::real::Real;
use crate::solve::SolveStatus;
use crate::track::Pose;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Limits beyond which motion in the grasp is flagged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Limits {
    /// How far to look ahead.
    pub horizon_s: f32,
    /// Sag (downward motion in the grasp) that is flagged.
    pub sag_m: f32,
    /// Rotation in the grasp that is flagged while holding or sliding.
    pub rotation_rad: f32,
    /// Slip speed below which a finger counts as sticking.
    pub slip_m_s: f32,
    /// Share of the friction limit that a held grasp shall keep below.
    pub target_utilisation: f32,
    /// Distance between model and measured pose at which the model starts anew.
    pub divergence_m: f32,
    /// Slip nearer than this, by the trend of the measured load, is flagged.
    pub slip_warning_s: f32,
    /// Loss of a held grasp nearer than this, by the same trend, is flagged.
    pub drop_warning_s: f32,
    /// Range of the fingertip sensors: a force at or beyond it is saturated.
    pub force_range_n: f32,
    /// Range of their torques.
    pub torque_range_nm: f32,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            horizon_s: 0.1,
            sag_m: 0.002,
            rotation_rad: 0.05,
            slip_m_s: 0.0005,
            target_utilisation: 0.8,
            divergence_m: 0.003,
            slip_warning_s: 0.25,
            drop_warning_s: 0.5,
            force_range_n: 200.0,
            torque_range_nm: 5.0,
        }
    }
}

/// What reaches the predictor each tick. Anything not measured is `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<R: Real> {
    /// Time stamp; rises.
    pub t_s: R,
    /// Grip force commanded, each finger.
    pub grip_cmd_n: R,
    /// World; `None` where nothing is grasped.
    pub gripper: Option<Pose<R>>,
    /// World.
    pub object: Option<Pose<R>>,
    /// World.
    pub pusher: Option<Pose<R>>,
    /// Force (N) and torque (N m) on the object, gripper axes, about the patch centre.
    pub finger: [Option<[R; 6]>; 2],
}

/// State of one finger.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize, Schema)]
pub struct FingerPrediction {
    /// Share of the friction limit used now, by the measured wrench; `None`: not measured.
    pub measured_utilisation: Option<f32>,
    /// The same by the model.
    pub model_utilisation: f32,
    /// Largest utilisation of the look-ahead.
    pub peak_utilisation: f32,
    /// Slip speed now, by the model; zero while sticking.
    pub slip_speed_m_s: f32,
    /// Direction of slip now or, while sticking, of the predicted slip: angle in the finger
    /// plane from gripper X towards gripper Z.
    pub slip_direction_rad: f32,
    /// Whether it slips, or will.
    pub slip: Slip,
}

/// Slip of one finger, now or foreseen.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize, Schema)]
pub enum Slip {
    /// It sticks, and no slip is foreseen within the horizon.
    #[default]
    None,
    /// It sticks; slip begins after so long, s.
    In(f32),
    /// It slips.
    Now,
}

impl Slip {
    /// Time until slip begins, s; zero while it slips, `None` where none is foreseen.
    pub fn in_s(self) -> Option<f32> {
        match self {
            Slip::None => None,
            Slip::In(t_s) => Some(t_s),
            Slip::Now => Some(0.0),
        }
    }
}

/// Output of one tick. The default foresees nothing and warns of nothing.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize, Schema)]
pub struct Prediction {
    /// See [`flags`].
    pub flags: u32,
    /// See [`validity`]; zero: nothing to object.
    pub validity: u32,
    /// Finger 1 (+Y), finger 2 (-Y).
    pub finger: [FingerPrediction; 2],
    /// Downward motion in the grasp since the start that was not intended, of the object's
    /// material point that lay between the pads.
    pub sag_m: f32,
    /// Sag expected at the end of the horizon.
    pub sag_ahead_m: f32,
    /// Rotation of the object in the grasp since the start.
    pub rotation_rad: f32,
    /// Time until the grasp is lost; `None`: not within the horizon.
    pub drop_in_s: Option<f32>,
    /// Grip force of each finger that keeps the target utilisation; `None` where the plan does not
    /// mean to hold.
    pub holding_grip_n: Option<f32>,
    /// Friction coefficient of the fingers, learnt on-line from slips and near slips: as likely more as less.
    pub friction: f32,
    /// There is more than this with the probability 0.9875; `holding_grip_n` counts on it.
    pub friction_least: f32,
    /// Probability that the friction suffices for the load measured now, and for what it comes to within the horizon by its
    /// trend, the grip command and the plan. `None` where the plan does not mean to hold, while it slips, and where no
    /// wrench is usable. What gives no sign before (a knock, friction that falls) is not in it.
    pub hold_probability: Option<f32>,
    /// Object in the grasp, model: position (m) in the gripper frame.
    pub position_m: [f32; 3],
    /// Object in the grasp, model: `w, x, y, z`.
    pub quaternion: [f32; 4],
    /// Model's wrench of each finger on the object.
    pub finger_wrench: [[f32; 6]; 2],
    /// Model's force of the pusher on the object, world axes.
    pub pusher_force_n: [f32; 3],
    /// Worst of the tick.
    pub solver_status: SolveStatus,
    /// Largest momentum error of the tick's solves, N.
    pub solver_residual_n: f32,
    /// Newton steps of the tick.
    pub solver_iterations: u16,
}

/// Bits of [`Prediction::flags`].
pub mod flags {
    /// Finger 1 slips now.
    pub const SLIP_1: u32 = 1;
    /// Finger 2 slips now.
    pub const SLIP_2: u32 = 1 << 1;
    /// Finger 1 will slip within the horizon.
    pub const SLIP_AHEAD_1: u32 = 1 << 2;
    /// Finger 2 will slip within the horizon.
    pub const SLIP_AHEAD_2: u32 = 1 << 3;
    /// Slip, now or ahead, that the plan does not intend.
    pub const UNEXPECTED: u32 = 1 << 4;
    /// Sag beyond its limit, now or ahead.
    pub const SAG: u32 = 1 << 5;
    /// Rotation in the grasp beyond its limit.
    pub const ROTATION: u32 = 1 << 6;
    /// The grasp will be lost within the horizon.
    pub const DROP: u32 = 1 << 7;
    /// The object touches the pusher.
    pub const PUSHING: u32 = 1 << 8;
    /// The flags cannot be relied on, raised or not: see the validity word.
    pub const UNSURE: u32 = 1 << 9;
}

/// Bits of [`Prediction::validity`]: reasons to doubt the prediction.
pub mod validity {
    /// A solve ended without reaching its tolerance.
    pub const SOLVER: u32 = 1;
    /// Model and measured pose had parted; the model was restarted at the measurement.
    pub const DIVERGED: u32 = 1 << 1;
    /// The sample was unusable (time did not rise, no gripper pose), or in a run on a board none was there; the last prediction
    /// is repeated.
    pub const SAMPLE: u32 = 1 << 2;
    /// A gap in the samples was too long to bridge; the model was restarted.
    pub const GAP: u32 = 1 << 3;
    /// No fingertip wrench: utilisation is the model's alone.
    pub const NO_WRENCH: u32 = 1 << 4;
    /// No plan: the look-ahead assumes that the present motion goes on.
    pub const NO_PLAN: u32 = 1 << 5;
    /// The model has not started: it waits for a first sample with the object's pose.
    pub const WAITING: u32 = 1 << 6;
    /// Contact points beyond the capacity were left out.
    pub const POINTS_LOST: u32 = 1 << 7;
    /// The measured wrench was not finite.
    pub const WRENCH: u32 = 1 << 8;
    /// One finger's wrench is missing: the other stands for both.
    pub const ONE_FINGER: u32 = 1 << 9;
    /// A wrench repeats itself: the sensor is stuck or its link stale. It is not used.
    pub const STUCK: u32 = 1 << 10;
    /// A wrench is at the end of its range. It is not used.
    pub const SATURATED: u32 = 1 << 11;
    /// Constant error: the fingers' normal forces do not cancel while holding, or the start shows
    /// more than a constant error may be.
    pub const BIASED: u32 = 1 << 12;
    /// Model and measured wrench or pose disagree for three samples: slip by the model alone is
    /// not flagged.
    pub const MODEL: u32 = 1 << 13;
    /// A step of the look-ahead ended without reaching its tolerance: what lies beyond it is
    /// a best answer.
    pub const FORESIGHT: u32 = 1 << 14;
    /// No look-ahead is finished yet: only the present is predicted.
    pub const NO_FORESIGHT: u32 = 1 << 15;
    /// The object's measured pose is far from the model's, and not used until it stays there; or it repeats
    /// itself as no measurement does, and is not used; or each is given for several samples, and is late; or the fingers have let the
    /// object fall for 24 ms and it does not show that. Or the pusher, which was there at first, is not measured: the step was
    /// made without it.
    pub const POSE: u32 = 1 << 16;
    /// The model asks for friction pyramids, and a step was not solved with them within its part of the
    /// work: it was solved with the exact cone. No doubt of the flags.
    pub const CONE_INSTEAD: u32 = 1 << 17;

    /// Doubts under which the flags cannot be relied on.
    pub const UNRELIABLE: u32 = SOLVER
        | DIVERGED
        | SAMPLE
        | GAP
        | NO_WRENCH
        | WAITING
        | POINTS_LOST
        | WRENCH
        | ONE_FINGER
        | STUCK
        | SATURATED
        | BIASED
        | FORESIGHT
        | POSE;
}

impl Prediction {
    /// Every output word, for comparing two sides bit for bit; NaNs are all the same NaN. What was not
    /// measured counts as NaN, what is not foreseen as -1.
    pub fn words(&self) -> impl Iterator<Item = u32> + '_ {
        let bits = |x: f32| x.canonical_bits() as u32;
        let fingers = self.finger.iter().flat_map(move |f| {
            [
                f.measured_utilisation.unwrap_or(f32::NAN),
                f.model_utilisation,
                f.peak_utilisation,
                f.slip_speed_m_s,
                f.slip_direction_rad,
                f.slip.in_s().unwrap_or(-1.0),
            ]
            .map(bits)
        });
        let rest = [
            self.sag_m,
            self.sag_ahead_m,
            self.rotation_rad,
            self.drop_in_s.unwrap_or(-1.0),
            self.holding_grip_n.unwrap_or(f32::NAN),
            self.friction,
            self.friction_least,
            self.hold_probability.unwrap_or(f32::NAN),
        ];
        [self.flags, self.validity, u32::from(self.solver_status as u8), u32::from(self.solver_iterations)]
            .into_iter()
            .chain(fingers)
            .chain(rest.into_iter().map(bits))
            .chain(self.position_m.into_iter().map(bits))
            .chain(self.quaternion.into_iter().map(bits))
            .chain(self.finger_wrench.iter().flatten().map(move |x| bits(*x)))
            .chain(self.pusher_force_n.into_iter().map(bits))
            .chain([bits(self.solver_residual_n)])
    }

    /// Hash of every output word (FNV-1a), continued from `before`.
    pub fn hash(&self, before: u32) -> u32 {
        self.words()
            .flat_map(u32::to_le_bytes)
            .fold(before, |h, b| (h ^ u32::from(b)).wrapping_mul(0x0100_0193))
    }
}

/// Where a hash of predictions begins.
pub const HASH_START: u32 = 0x811c_9dc5;
