//! What an effect may change, and what it sees: the trait that every effect implements.

use crate::contact::{Body, Contact, is_finger};
use crate::effect::{MAX_PARAMETERS, MEMORY, Parameter};
use crate::model::{FingerContact, PusherContact};
use crate::real::{Real, Rotation, Vec3, clamp};

/// What every hook may look at: the step as it begins.
#[derive(Clone, Copy, Debug)]
pub struct StepContext<R: Real> {
    /// Since the start of the trial.
    pub time_s: R,
    /// Step.
    pub dt_s: R,
    /// Place of the trial in its data set, 0 for the first (wear goes with it).
    pub trial: R,
    /// Grip force commanded, each finger.
    pub grip_cmd_n: R,
    /// Its change since the last step, N/s; zero in the first.
    pub grip_rate_n_s: R,
    /// Object in the carrier frame.
    pub position_m: Vec3<R>,
    /// Object axes to carrier axes.
    pub rotation: Rotation<R>,
    /// Carrier axes to world axes.
    pub carrier: Rotation<R>,
    /// Distance slipped so far, mean over the points of finger 1, finger 2, pusher, support.
    pub slip_m: [R; 4],
    /// Slip speed of the last step, the same means.
    pub slip_speed_m_s: [R; 4],
    /// Normal force of the last step, the same bodies.
    pub load_n: [R; 4],
    /// Its change over that step, N/s; zero in the first two.
    pub load_rate_n_s: [R; 4],
    /// Pusher and support; zeros where there is none.
    pub environment: [Environment<R>; 2],
    /// Stretch of the tangential springs of each fingertip, mean over its points, along their tangents: the object has moved
    /// by it before it slips.
    pub stretch_m: [[R; 2]; 2],
    /// Fingertips.
    pub fingers: Option<FingerContact<R>>,
    /// Contact feature of the pusher.
    pub pusher: Option<PusherContact<R>>,
    /// Whether the support bears the object's whole face, not feet that are told.
    pub whole_face: bool,
    /// Absolute velocity of the centre of mass, carrier axes.
    pub velocity_m_s: Vec3<R>,
    /// Absolute angular velocity, carrier axes.
    pub angular_rad_s: Vec3<R>,
}

impl<R: Real> StepContext<R> {
    /// Whether `body` is what friction is about: a fingertip, or the support where nothing is gripped.
    pub fn rubs(&self, body: Body) -> bool {
        let gripped = self.fingers.is_some() && self.grip_cmd_n > R::zero();
        is_finger(body) || (body == Body::Support && !gripped)
    }

    /// Share of a law of friction that acts between the object and `body`: all of it on what [`Self::rubs`],
    /// `elsewhere` (0 to 1) on the others.
    pub fn scope(&self, body: Body, elsewhere: R) -> R {
        if self.rubs(body) { R::one() } else { clamp(elsewhere, R::zero(), R::one()) }
    }
}

/// Which contacts a law of friction is about: pads and pusher are other materials and need not share it
/// ([`StepContext::scope`]).
pub const ELSEWHERE: Parameter = Parameter::new(
    "elsewhere",
    "1",
    0.0,
    0.0,
    [0.0, 1.0],
    "share of it at the other contacts: pusher, and support beside fingertips",
)
.tried_at(&[0.0, 1.0])
.added(1.0);

/// A body that the object leans on.
#[derive(Clone, Copy, Debug)]
pub struct Environment<R: Real> {
    /// Its contact normal, into the object, carrier axes.
    pub normal: Vec3<R>,
    /// Its Y axis, carrier axes.
    pub along_y: Vec3<R>,
    /// Angular velocity of the object relative to it, carrier axes.
    pub turning_rad_s: Vec3<R>,
    /// Its own, carrier axes.
    pub angular_rad_s: Vec3<R>,
}

/// Loads and inertia of the object.
#[derive(Clone, Copy, Debug)]
pub struct Loads<R: Real> {
    /// World axes.
    pub gravity_m_s2: Vec3<R>,
    /// Mass; the inertia follows in proportion.
    pub mass_kg: R,
    /// Added force at the centre of mass, carrier axes.
    pub force_n: Vec3<R>,
    /// Added torque about the centre of mass, carrier axes.
    pub torque_nm: Vec3<R>,
}

/// What is known of the slip at one contact point, from the last step.
#[derive(Clone, Copy, Debug)]
pub struct Slip<R: Real> {
    /// Share of the whole contact (sum over a patch: 1).
    pub share: R,
    /// Other body.
    pub body: Body,
    /// Place within the patch, from its centre.
    pub patch_m: [R; 2],
    /// Place on the object, object axes.
    pub object_m: Vec3<R>,
    /// Normal force.
    pub load_n: R,
    /// Normal force of the whole patch.
    pub patch_load_n: R,
    /// Slip speed; zero while sticking.
    pub speed_m_s: R,
    /// Distance slipped so far.
    pub distance_m: R,
    /// Time since it last slipped.
    pub rest_s: R,
}

/// Friction of one contact point.
#[derive(Clone, Copy, Debug)]
pub struct FrictionLaw<R: Real> {
    /// Coefficient along both tangents (fingers: the object's X axis, and across it).
    pub mu: [R; 2],
    /// Greatest pull borne; adds to the friction bound as well.
    pub adhesion_n: R,
    /// Rise of both coefficients with the slip speed at the end of the step; not negative.
    pub viscosity_s_m: R,
}

/// What the sensors show.
#[derive(Clone, Copy, Debug)]
pub struct Reading<R: Real> {
    /// Object in the carrier frame.
    pub position_m: Vec3<R>,
    /// Object axes to carrier axes.
    pub rotation: Rotation<R>,
    /// Force (N) and torque (N m) of both fingers on the object, carrier axes, about the patch centre.
    pub finger: [[R; 6]; 2],
    /// Force and torque of the pusher on the object, world axes, about its first origin.
    pub pusher: [R; 6],
}

/// An effect. Every hook defaults to 'no change'; `p` are the effect's parameters.
pub trait Law<R: Real>: Sync {
    /// Changes mass, gravity or external loads.
    fn loads(
        &self,
        _p: &[R; MAX_PARAMETERS],
        _c: &StepContext<R>,
        _memory: &mut [R; MEMORY],
        _loads: &mut Loads<R>,
    ) {
    }
    /// Changes the grip force that really acts on both fingers, N.
    fn grip(
        &self,
        _p: &[R; MAX_PARAMETERS],
        _c: &StepContext<R>,
        _memory: &mut [R; MEMORY],
        _grip_n: &mut R,
    ) {
    }
    /// Changes a contact's geometry or compliance; `memory` is what [`Law::loads`] and [`Law::grip`] left in this step.
    fn contact(
        &self,
        _p: &[R; MAX_PARAMETERS],
        _c: &StepContext<R>,
        _memory: &[R; MEMORY],
        _contact: &mut Contact<R>,
    ) {
    }
    /// Changes a contact's friction; `memory` as above.
    fn friction(
        &self,
        _p: &[R; MAX_PARAMETERS],
        _c: &StepContext<R>,
        _memory: &[R; MEMORY],
        _slip: &Slip<R>,
        _law: &mut FrictionLaw<R>,
    ) {
    }
    /// Friction while sliding over that at rest.
    fn sliding_share(&self, _p: &[R; MAX_PARAMETERS]) -> R {
        R::one()
    }
    /// Arm of a finger's torsional friction, torsion limit over force limit, m.
    fn torsion_arm(&self, _p: &[R; MAX_PARAMETERS], arm_m: R) -> R {
        arm_m
    }
    /// By how much the object's pose is late, s.
    fn pose_late_s(&self, _p: &[R; MAX_PARAMETERS]) -> R {
        R::zero()
    }
    /// Changes what the sensors show.
    fn sense(&self, _p: &[R; MAX_PARAMETERS], _c: &StepContext<R>, _reading: &mut Reading<R>) {}
}
