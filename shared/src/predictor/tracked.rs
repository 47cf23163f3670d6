//! The tracked object: its state in the model, where it was last measured, and what is counted from sample to sample.

use super::ahead::{Ahead, Foreseen};
use super::decide::Alarms;
use super::late::Waiting;
use super::params::Params;
use super::sag::Sag;
use crate::cone::Kept;
use crate::contact::SLOTS;
use crate::real::{Real, Rotation, Vec3};
use crate::step::State;
use crate::track::{Acceleration, PathFilter, Pose, Poses, Settling};

/// State of a started predictor.
#[derive(Clone, Debug)]
pub(super) struct Tracked<R: Real> {
    pub(super) state: State<R, SLOTS>,
    pub(super) poses: Poses<R>,
    pub(super) support: Option<Pose<R>>,
    /// Moves the pusher clear of the object, world.
    pub(super) seat_m: Vec3<R>,
    pub(super) reference_m: Vec3<R>,
    pub(super) start: Pose<R>,
    /// By the model, and by the measured pose.
    pub(super) sag: [Sag<R>; 2],
    pub(super) pushing: bool,
    /// Samples in a row in which model and measurement disagree.
    pub(super) apart: u8,
    /// Samples in a row whose measured pose has parted from the model's.
    pub(super) strayed: u8,
    /// Samples in a row whose step was not solved.
    pub(super) unsolved: u8,
    /// The object still settles on what carries it.
    pub(super) settling: Option<Settling<R>>,
    /// A look-ahead under way.
    pub(super) ahead: Option<Ahead<R>>,
    /// Factors of the last step, and of the last one of the look-ahead.
    pub(super) kept: [Kept<R>; 2],
    /// Where the object was last measured without a jump, in the gripper.
    pub(super) seen_m: Vec3<R>,
    /// Since then, s.
    pub(super) unseen_s: R,
    /// It was seen out of the fingers' reach.
    pub(super) away: bool,
    /// What the newest finished one found.
    pub(super) outlook: Option<Foreseen<R>>,
    pub(super) alarms: Alarms,
    /// Where the object last rested, in the gripper; how far the last slip went, object axes.
    pub(super) rest_m: Vec3<R>,
    pub(super) slipped_m: Vec3<R>,
    /// Planned velocity and angular velocity, and how long a change of it still matters.
    pub(super) motion: [[f32; 3]; 2],
    pub(super) settling_s: R,
    pub(super) gripper: PathFilter<R>,
    pub(super) pusher: Option<PathFilter<R>>,
    /// By the gripper's measured pose; for how long what it explains still matters, s.
    pub(super) acceleration: Acceleration<R>,
    pub(super) gaining_s: R,
    /// Where the object's poses are late.
    pub(super) waiting: Waiting<R>,
}

impl<R: Real> Tracked<R> {
    /// The planned motion changes, or the gripper gains or loses speed: the load does too.
    pub(super) fn steered(&self) -> bool {
        self.gaining_s > R::zero() || self.settling_s > R::zero()
    }

    /// Back in the grasp: what went before is no slip on the pads that the next one could be like.
    #[cold]
    pub(super) fn returned(&mut self) {
        self.rest_m = self.seen_m;
        self.slipped_m = Vec3::zeros();
        self.alarms = Alarms::default();
    }

    /// How far the object has come in this slip, or came in the last one.
    pub(super) fn note_slip(&mut self, slips: bool, attitude: &Rotation<R>) {
        let way = self.seen_m - self.rest_m;
        if slips {
            self.slipped_m = attitude.inverse_transform_vector(&way);
        } else {
            self.rest_m += way * R::of(0.1);
        }
    }

    /// One more slip as long as the last takes the pads' centres off the object: `edge_m` is
    /// the way left each way.
    pub(super) fn another_is_the_last(&self, edge_m: &[[R; 2]; 2], params: &Params) -> bool {
        let (noise_m, next) = (R::of(f64::from(params.edge_noise_m)), R::of(f64::from(params.next_slip)));
        [self.slipped_m.x, self.slipped_m.z].iter().zip(edge_m).any(|(moved, sides)| {
            let way = if *moved > R::zero() { sides[0] } else { sides[1] };
            moved.abs() > noise_m && moved.abs() * next > way
        })
    }
}
