//! What is imposed on a step, and what it changes.

use crate::effect::MEMORY;
use crate::model::{Base, MAX_EFFECTS, Model, RIGID_N_M, Scene};
use crate::real::{Real, Rotation, Vec3};
use crate::solve::DOF;

/// A body that moves as prescribed, seen from the carrier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moving<R: Real> {
    /// Origin, carrier frame.
    pub position_m: Vec3<R>,
    /// Body axes to carrier axes.
    pub rotation: Rotation<R>,
    /// Velocity of the origin relative to the carrier, carrier axes.
    pub velocity_m_s: Vec3<R>,
    /// Angular velocity relative to the carrier, carrier axes.
    pub angular_rad_s: Vec3<R>,
    /// Point about which its wrench is reported (its origin at the first sample), carrier frame.
    pub reference_m: Vec3<R>,
}

impl<R: Real> Moving<R> {
    /// Velocity of the body's point at `from_origin_m`, relative to the carrier.
    pub fn velocity_at(&self, from_origin_m: &Vec3<R>) -> Vec3<R> {
        self.velocity_m_s + self.angular_rad_s.cross(from_origin_m)
    }
}

/// What is imposed during one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive<R: Real> {
    /// Step.
    pub dt_s: R,
    /// Carrier axes to world axes at the beginning of the step.
    pub carrier: Rotation<R>,
    /// Absolute velocity of the carrier's origin, carrier axes.
    pub carrier_m_s: Vec3<R>,
    /// Absolute angular velocity of the carrier, carrier axes.
    pub carrier_rad_s: Vec3<R>,
    /// Pusher or environment.
    pub pusher: Option<Moving<R>>,
    /// Table: its frame's +X is the table's normal.
    pub support: Option<Moving<R>>,
    /// Grip force commanded, each finger.
    pub grip_n: R,
    /// Place of the trial in its data set.
    pub trial: R,
}

/// Memory of one contact point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slot<R: Real> {
    /// Tangential spring, m.
    pub spring_m: [R; 2],
    /// Distance slipped.
    pub slip_m: R,
    /// Slip speed in the last step; zero while sticking.
    pub speed_m_s: R,
    /// Time since it last slipped.
    pub rest_s: R,
    /// Normal force in the last step.
    pub load_n: R,
}

/// What rates are taken from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LastStep<R: Real> {
    /// Its duration.
    pub dt_s: R,
    /// Grip force commanded.
    pub grip_n: R,
    /// Normal force of each body at its beginning; `None` in the first, before which nothing was solved.
    pub load_n: Option<[R; 4]>,
}

/// Everything that changes from step to step.
#[derive(Clone, Debug, PartialEq)]
pub struct State<R: Real, const NC: usize> {
    /// Since the start.
    pub time_s: R,
    /// Centre of mass, carrier frame.
    pub position_m: Vec3<R>,
    /// Object axes to carrier axes.
    pub rotation: Rotation<R>,
    /// Velocity relative to the carrier: linear, angular, jaw opening.
    pub velocity: [R; DOF],
    /// Absolute velocity of the centre of mass, carrier axes.
    pub absolute_m_s: Vec3<R>,
    /// Absolute angular velocity, carrier axes.
    pub absolute_rad_s: Vec3<R>,
    /// Half the jaw opening at the start.
    pub jaw_half_m: R,
    /// Change of half the jaw opening since.
    pub jaw_m: R,
    /// One for each contact point.
    pub slots: [Slot<R>; NC],
    /// Face of the object that the slots of finger 1, finger 2, pusher and support belong to, see
    /// [`crate::shape::Face::number`]; `None` before the first contact.
    pub faces: [Option<u8>; 4],
    /// Memory of the model's effects.
    pub memory: [[R; MEMORY]; MAX_EFFECTS],
    /// The last step; `None` before the first.
    pub last: Option<LastStep<R>>,
}

impl<R: Real, const NC: usize> State<R, NC> {
    /// An object at rest relative to a carrier that moves as `drive` says, already gripped:
    /// the finger and support springs carry grip and weight.
    pub fn held(
        scene: &Scene<R>,
        model: &Model<R>,
        drive: &Drive<R>,
        position_m: Vec3<R>,
        rotation: Rotation<R>,
    ) -> Self {
        let zero = R::zero();
        let half = scene.object.shape.reach(&rotation.inverse_transform_vector(&Vec3::y()));
        let mut state = Self {
            time_s: zero,
            position_m,
            rotation,
            velocity: [zero; DOF],
            absolute_m_s: drive.carrier_m_s + drive.carrier_rad_s.cross(&position_m),
            absolute_rad_s: drive.carrier_rad_s,
            jaw_half_m: half,
            jaw_m: zero,
            slots: [Slot::default(); NC],
            faces: [None; 4],
            memory: [[zero; MEMORY]; MAX_EFFECTS],
            last: None,
        };
        let stiffness = match model.base {
            Base::Hard => R::of(RIGID_N_M),
            Base::Soft { normal_n_m, .. } => normal_n_m,
        };
        state.jaw_m = -drive.grip_n / stiffness;
        state
    }
}
