//! Hidden effects: each changes the physics, the plan or the sensors of a reality, with a strength
//! that is drawn. Names are those of the diagnosis; names with `x_` are in nobody's list.

mod contact;
mod grip;
mod outside;
mod scale;
mod sensing;

use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use serde_json::{Map, Value};

use crate::plan::bench::Primitive::{self, Lift, LinearPush, Pivot, PlanarPush, Roll};
use crate::reality::Reality;

pub use scale::Scale;

type Apply = fn(&mut Reality, Scale, &mut ChaCha8Rng) -> Map<String, Value>;

/// One hidden effect.
#[derive(Clone, Copy)]
pub struct Effect {
    /// Name.
    pub id: &'static str,
    /// What happens, physically.
    pub what: &'static str,
    /// In which primitives it can show.
    pub shows_in: &'static [Primitive],
    apply: Apply,
}

/// An effect as applied: for the key.
#[derive(Clone, Debug, Serialize)]
pub struct Applied {
    /// Name.
    pub id: &'static str,
    /// Is it in the diagnosis' list?
    pub listed: bool,
    /// Strength over the typical one.
    pub level: f64,
    /// Physical values; the unit is the end of the name.
    pub parameters: Map<String, Value>,
}

const SLIDES: &[Primitive] = &[LinearPush, Pivot, PlanarPush];
const PUSHES: &[Primitive] = &[LinearPush, Pivot];
const ALL: &[Primitive] = &[LinearPush, Pivot, Roll, Lift, PlanarPush];

macro_rules! catalogue {
    ($($id:literal, $shows:expr, $apply:path, $what:literal;)*) => {
        /// All effects.
        pub static CATALOGUE: &[Effect] =
            &[$(Effect { id: $id, what: $what, shows_in: $shows, apply: $apply }),*];
    };
}

catalogue! {
    "finger_friction_mismatch", PUSHES, contact::mismatch, "finger 1 and finger 2 have different friction";
    "pressure_offset", PUSHES, contact::pressure_offset, "stiffness of both pads grows to one side";
    "face_tilt", &[LinearPush], grip::face_tilt, "gripped faces form a wedge that opens a jaw with a stiff gear";
    "face_waviness", &[LinearPush], contact::waviness, "finger friction varies periodically along the object";
    "grip_force_loss", PUSHES, grip::loss, "the jaw loses a share of the commanded force";
    "grip_force_lag", PUSHES, grip::lag, "the jaw loses force for each metre of slip and wins it back with a lag";
    "plate_tilt", PUSHES, contact::plate_tilt, "plate or edge is turned against its stated pose";
    "contact_compliance", PUSHES, contact::compliance, "soft pads";
    "wear_drift", SLIDES, contact::wear, "finger friction changes from the first trial to the last";
    "load_dependent_friction", PUSHES, contact::load_exponent, "coefficient goes with a power of the load";
    "viscous_friction", SLIDES, contact::viscous, "coefficient rises with slip speed";
    "static_friction", SLIDES, contact::static_friction, "bristles hold more before they slide";
    "dwell_strengthening", SLIDES, contact::dwell, "the limit grows with the age of the contact";
    "adhesion", SLIDES, contact::adhesion, "contacts pull: friction without load";
    "anisotropic_friction", PUSHES, contact::anisotropic, "limit along the object's grain differs from that across";
    "torsional_friction", &[Pivot], contact::torsional, "pads of another radius than stated";
    "rolling_resistance", &[Roll], contact::rolling, "the platform's reaction runs ahead of the axis";
    "mass_error", &[LinearPush, Pivot, Lift], outside::mass, "true mass and its centre differ from those stated";
    "gravity_tilt", &[LinearPush, Pivot, Lift], outside::gravity, "gravity is not along -Z";
    "support_pressure", &[PlanarPush], outside::support, "three feet or a heavy side in place of an even face";
    "support_anisotropy", &[PlanarPush], contact::grained, "table or face has a grain, along which friction differs";
    "sensor_gain", ALL, sensing::gain, "force sensors read too much or too little";
    "sensor_misalignment", PUSHES, sensing::misalignment, "a force sensor is turned";
    "sensor_crosstalk", PUSHES, sensing::crosstalk, "each force channel shows a share of others";
    "sensor_bias", PUSHES, sensing::bias, "constant errors beyond what is stated";
    "mocap_latency", ALL, sensing::latency, "the object's pose is late";
    "x_object_spring", PUSHES, outside::spring, "a spring between object and gripper";
    "x_drive_ripple", SLIDES, outside::ripple, "the drive's travel has a periodic error that its own report hides";
    "x_cable_force", ALL, outside::cable, "a cable pulls at the object's end";
    "x_magnet_pull", &[LinearPush, Pivot, PlanarPush], outside::magnet, "a magnet in the room attracts the object";
    "x_pad_flow", PUSHES, contact::flow, "bristles relax at rest: the grasp creeps under any load";
}

impl Effect {
    /// The effect of this name.
    pub fn named(id: &str) -> Option<&'static Effect> {
        CATALOGUE.iter().find(|e| e.id == id)
    }

    /// Is it one that the diagnosis lists?
    pub fn listed(&self) -> bool {
        !self.id.starts_with("x_")
    }

    /// Changes the reality.
    pub fn apply(&self, reality: &mut Reality, scale: Scale, rng: &mut ChaCha8Rng) -> Applied {
        let parameters = (self.apply)(reality, scale, rng);
        Applied { id: self.id, listed: self.listed(), level: scale.level, parameters }
    }
}
