//! Physical effects that a model may have on top of its base contact law.
//!
//! An effect is one file in this folder: a unit struct that implements [`Law`], whose
//! hooks change loads, grip, contacts, friction or what the sensors show. It plugs in at
//! one place: the list in `registry`.

use crate::contact::{Body, Contact};
use crate::model::PusherContact;
use crate::real::{Real, Rotation, Vec3};
use serde::{Deserialize, Serialize};

pub mod adhesion;
pub mod anisotropic_friction;
pub mod contact_compliance;
pub mod dwell_strengthening;
pub mod face_tilt;
pub mod face_waviness;
pub mod finger_friction_mismatch;
pub mod formula;
pub mod gravity_tilt;
pub mod grip_force_lag;
pub mod grip_force_loss;
pub mod load_dependent_friction;
pub mod mass_error;
pub mod mocap_latency;
pub mod plate_tilt;
pub mod pressure_offset;
pub mod program;
mod registry;
pub mod rolling_resistance;
pub mod sensor_bias;
pub mod sensor_crosstalk;
pub mod sensor_gain;
pub mod sensor_misalignment;
pub mod static_friction;
pub mod torsional_friction;
pub mod viscous_friction;
pub mod wear_drift;
pub use registry::{REGISTRY, law};

/// Most parameters of one effect.
pub const MAX_PARAMETERS: usize = 6;
/// Numbers that an effect may remember from step to step.
pub const MEMORY: usize = 3;

/// An effect in a model: which, and its parameters (SI units, see its [`Info`]).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "R: Real")]
pub struct Effect<R: Real> {
    /// Stable number of the effect, see [`Info::code`].
    pub code: u8,
    /// Parameters in the order of its [`Info`]; the rest zero.
    pub parameters: [R; MAX_PARAMETERS],
}

/// Description of one parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name with its unit as suffix.
    pub name: &'static str,
    /// Unit as people write it.
    pub unit: &'static str,
    /// A typical strength: where a fit starts and what a sensitivity is scaled by.
    pub typical: f64,
    /// The value at which the effect is absent (or any value, if another parameter switches it off).
    pub neutral: f64,
    /// Smallest value that makes sense.
    pub low: f64,
    /// Largest value that makes sense.
    pub high: f64,
    /// What it is.
    pub what: &'static str,
    /// Where it only shapes the effect: values at which a fit starts; empty: about the typical one.
    pub tries: &'static [f64],
}

impl Parameter {
    /// In the order of the fields; `bounds` are the smallest and the largest value.
    pub const fn new(
        name: &'static str,
        unit: &'static str,
        typical: f64,
        neutral: f64,
        bounds: [f64; 2],
        what: &'static str,
    ) -> Self {
        let [low, high] = bounds;
        Self { name, unit, typical, neutral, low, high, what, tries: &[] }
    }

    /// The same with the values at which a fit starts.
    pub const fn tried_at(self, tries: &'static [f64]) -> Self {
        Self { tries, ..self }
    }
}

/// What a diagnosis has to know of an effect beside its law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Role {
    /// It is missing or it is not.
    Plain,
    /// How pads give way: at the largest grip real ones do by this much, and that is no missing effect.
    Compliance {
        /// m
        normal_m: f64,
    },
    /// A later trial of the same condition differs; its first parameter is the change from trial to trial.
    Order,
}

/// Description of an effect.
#[derive(Clone, Copy, Debug)]
pub struct Info {
    /// Identifier used in model files and reports; the board knows effects by their code.
    pub id: &'static str,
    /// Stable number on the wire.
    pub code: u8,
    /// One line for people.
    pub summary: &'static str,
    /// What it looks like in data.
    pub signature: &'static str,
    /// Where the law comes from.
    pub source: &'static str,
    /// How a diagnosis treats it.
    pub role: Role,
    /// At most [`MAX_PARAMETERS`].
    pub parameters: &'static [Parameter],
}

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
    /// Contact feature of the pusher.
    pub pusher: Option<PusherContact<R>>,
    /// Absolute velocity of the centre of mass, carrier axes.
    pub velocity_m_s: Vec3<R>,
    /// Absolute angular velocity, carrier axes.
    pub angular_rad_s: Vec3<R>,
}

/// A body that the object leans on.
#[derive(Clone, Copy, Debug)]
pub struct Environment<R: Real> {
    /// Its contact normal, into the object, carrier axes.
    pub normal: Vec3<R>,
    /// Angular velocity of the object relative to it, carrier axes.
    pub turning_rad_s: Vec3<R>,
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
    /// Description; constant.
    fn info(&self) -> &'static Info;
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
    /// Changes a contact's geometry or compliance.
    fn contact(&self, _p: &[R; MAX_PARAMETERS], _c: &StepContext<R>, _contact: &mut Contact<R>) {}
    /// Changes a contact's friction; `memory` is what [`Law::loads`] and [`Law::grip`] left in this step.
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
    /// Changes what the sensors show.
    fn sense(&self, _p: &[R; MAX_PARAMETERS], _c: &StepContext<R>, _reading: &mut Reading<R>) {}
}

/// The description of effect `id`, for example `"static_friction"`.
pub fn find(id: &str) -> Option<&'static Info> {
    REGISTRY.iter().copied().find(|i| i.id == id)
}

impl<R: Real> Effect<R> {
    /// Effect `id` with its typical parameters; `None` where there is no such effect.
    pub fn typical(id: &str) -> Option<Self> {
        Some(Self::with(find(id)?, |p| p.typical))
    }

    /// Effect `id` with the parameters at which it is absent; `None` where there is no such effect.
    pub fn neutral(id: &str) -> Option<Self> {
        Some(Self::with(find(id)?, |p| p.neutral))
    }

    fn with(info: &Info, value: impl Fn(&Parameter) -> f64) -> Self {
        let mut parameters = [R::zero(); MAX_PARAMETERS];
        for (p, i) in parameters.iter_mut().zip(info.parameters) {
            *p = R::of(value(i));
        }
        Self { code: info.code, parameters }
    }

    /// Description; `None` where the code is not known to this build.
    pub fn info(&self) -> Option<&'static Info> {
        match self.code {
            formula::CODE => Some(&formula::INFO),
            code => REGISTRY.iter().copied().find(|info| info.code == code),
        }
    }
}
