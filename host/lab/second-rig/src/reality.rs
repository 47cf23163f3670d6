//! The true properties of one rig and its objects: what the user does not see. A plan is run in it.

use nalgebra::Vector3;
use serde::Serialize;

use crate::physics::friction::Law;
use crate::physics::jaw::JawSpec;
use crate::physics::layout::Profile;
use crate::sensors::Sensors;

/// An object as it is told to the user.
#[derive(Clone, Debug, Serialize)]
pub struct ObjectSpec {
    /// Name.
    pub id: String,
    /// A cylinder along X; otherwise a prism of square section.
    pub round: bool,
    /// m.
    pub length_m: f64,
    /// Side, or diameter, m.
    pub side_m: f64,
    /// kg.
    pub mass_kg: f64,
}

/// A finger's pad.
#[derive(Clone, Debug, Serialize)]
pub struct Pad {
    /// As told, m.
    pub radius_m: f64,
    /// True radius over that.
    pub radius_factor: f64,
    /// Tangential stiffness of one pad, N/m (at `reference_n` where it goes with the load).
    pub shear_n_m: f64,
    /// Does it go with the load?
    pub shear_per_load: bool,
    /// Load at which `shear_n_m` holds, N.
    pub reference_n: f64,
    /// Normal over tangential stiffness.
    pub normal_ratio: f64,
    /// Damping ratio of an object of 0.2 kg on two pads.
    pub damping_ratio: f64,
    /// Stiffness of the relaxing branch over the lasting one; 0 for Kelvin-Voigt.
    pub relaxing_ratio: f64,
    /// s.
    pub relaxation_s: f64,
    /// Pressure.
    pub profile: Profile,
    /// Centre of pressure of finger 1 and finger 2 along gripper X and Z, m.
    pub offset_m: [[f64; 2]; 2],
}

/// Pusher and table.
#[derive(Clone, Debug, Serialize)]
pub struct Counterpart {
    /// Friction.
    pub law: Law,
    /// Normal stiffness of the whole contact, N/m.
    pub normal_n_m: f64,
    /// Tangential stiffness, N/m.
    pub shear_n_m: f64,
    /// Damping ratio of an object of 0.2 kg on it.
    pub damping_ratio: f64,
}

/// Scatter between runs.
#[derive(Clone, Debug, Serialize)]
pub struct Scatter {
    /// Friction of the fingers, relative standard deviation.
    pub friction: f64,
    /// Friction of pusher and table.
    pub other_friction: f64,
    /// Place of the object in the grasp, standard deviation, m.
    pub place_m: f64,
    /// Its direction, rad.
    pub angle_rad: f64,
    /// Centre of pressure, m.
    pub pressure_m: f64,
}

impl Scatter {
    /// Every run is the same.
    pub fn none() -> Self {
        Self { friction: 0.0, other_friction: 0.0, place_m: 0.0, angle_rad: 0.0, pressure_m: 0.0 }
    }
}

/// The whole rig.
#[derive(Clone, Debug, Serialize)]
pub struct Reality {
    /// Objects as told.
    pub objects: Vec<ObjectSpec>,
    /// Pads.
    pub pad: Pad,
    /// Friction of the fingers.
    pub finger: Law,
    /// Finger 1 has (1 + m) of that, finger 2 has (1 - m).
    pub mismatch: f64,
    /// Pusher.
    pub pusher: Counterpart,
    /// Table.
    pub table: Counterpart,
    /// Jaw.
    pub jaw: JawSpec,
    /// True mass over the one told.
    pub mass_factor: f64,
    /// True centre of mass along object X and Y, m.
    pub centre_m: [f64; 2],
    /// Rise of the gripped faces towards +X.
    pub taper: f64,
    /// Friction along the object: relative amplitude, wave length (m), phase (rad).
    pub wave: [f64; 3],
    /// Plate: pitch about pusher Y, yaw about pusher Z. Edge: lean about X, skew about Z. rad.
    pub plate_tilt: [f64; 2],
    /// Turn of true gravity about world X and Y, rad.
    pub gravity_tilt: [f64; 2],
    /// Share of finger friction lost (or won) from the first to the last trial.
    pub wear: f64,
    /// Feet that truly carry a supported object, object axes, m; `None` for the whole face.
    pub feet_m: Option<Vec<[f64; 2]>>,
    /// Are they told to the user?
    pub feet_told: bool,
    /// Arm of rolling resistance, m.
    pub rolling_arm_m: f64,
    /// Spring between object and gripper along gripper X, Y, Z, N/m.
    pub spring_n_m: Vector3<f64>,
    /// Cable: pull (N), stiffness (N/m), direction (unit, world).
    pub cable: Option<(f64, f64, Vector3<f64>)>,
    /// Magnet: pull at 20 mm (N), its place from the object's start (m).
    pub magnet: Option<(f64, Vector3<f64>)>,
    /// Error of the drive: amplitude (m), pitch (m).
    pub ripple: Option<[f64; 2]>,
    /// Between runs.
    pub scatter: Scatter,
    /// Sensors.
    pub sensors: Sensors,
    /// Factor by which the friction that the user is told is off (grasps).
    pub told_factor: f64,
}

impl Reality {
    /// Coefficient at which the fingers let go from rest.
    pub fn break_away_mu(&self) -> f64 {
        self.finger.mu * self.finger.static_ratio
    }
}
