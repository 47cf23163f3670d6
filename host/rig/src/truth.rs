//! What is really so in one trial: every number the simulated reality runs on. The
//! predictor never sees it; `stickslip rig --key FILE` writes it down for whoever checks.

use serde::Serialize;

use super::law::{FrictionLaw, Stiffness};

/// Pads and contact surfaces: stiffness of one whole contact, N/m. Hard rubber of about a
/// millimetre under a 20 mm disc: some ten micrometres under 20 N.
pub const CONTACT_STIFFNESS_N_M: f64 = 1e6;
/// Damping time of the contacts (damping over stiffness), s.
pub const CONTACT_DAMPING_S: f64 = 2e-4;
/// How fast the grip force of a non-ideal jaw rises when geometry forces it open, N/m on each finger.
pub const JAW_STIFFNESS_N_M: f64 = 2e4;
/// Wave length of a wavy face, m.
pub const WAVE_LENGTH_M: f64 = 0.025;
/// Time constant with which grip is lost while sliding, s.
pub const GRIP_LAG_S: f64 = 0.3;

/// Object X of the stripe with other friction, m.
pub const STRIPE_M: [f64; 2] = [-0.022, -0.014];

/// The way in which a cable pulls, world axes.
pub const CABLE_WAY: [f64; 3] = [2.0 / 3.0, 1.0 / 3.0, -2.0 / 3.0];
/// Where, in object axes, m.
pub const CABLE_AT_M: [f64; 3] = [0.03, 0.0, 0.0];

/// The contacts' true properties.
#[derive(Clone, Debug, Serialize)]
pub struct Truth {
    /// Friction of fingers 1 and 2.
    #[serde(skip)]
    pub finger: [FrictionLaw; 2],
    /// Friction of the pusher.
    #[serde(skip)]
    pub pusher: FrictionLaw,
    /// Friction of the table.
    #[serde(skip)]
    pub support: FrictionLaw,
    /// Coulomb coefficients of finger 1, finger 2, pusher and table in this trial.
    pub mu: [f64; 4],
    /// One finger.
    #[serde(skip)]
    pub finger_stiffness: Stiffness,
    /// Pusher and table.
    #[serde(skip)]
    pub hard_stiffness: Stiffness,
    /// True over told size of the finger patches.
    pub patch_scale: f64,
    /// Centre of pressure of each finger off the patch centre, gripper X and Z, m.
    pub pressure_offset_m: [[f64; 2]; 2],
    /// Angle between the gripped faces, rad.
    pub wedge_rad: f64,
    /// Amplitude of the gripped faces' waves, m.
    pub waviness_m: f64,
    /// Phase of the waves, rad.
    pub wave_phase_rad: f64,
    /// Turn of the fingertips under grip, rad/N.
    pub finger_bend_rad_n: f64,
    /// Play of the fingers along gripper X, m.
    pub backlash_m: f64,
    /// Velocity with which the fingers give way to tangential load, m/(N s).
    pub creep_m_n_s: f64,
    /// Pusher plate turned about world Y and Z from what is told, rad.
    pub plate_tilt_rad: [f64; 2],
    /// Lever of the platform's reaction ahead of a rolling object, m.
    pub rolling_resistance_m: f64,
    /// Share of the commanded grip that is missing.
    pub grip_loss: f64,
    /// Share of the grip lost in sustained sliding.
    pub grip_lag: f64,
    /// True mass, kg.
    pub mass_kg: f64,
    /// True centre of mass in object axes, m.
    pub com_offset_m: [f64; 3],
    /// True gravity in (told) world axes, m/s².
    pub gravity_m_s2: [f64; 3],
    /// Pull of a cable along [`CABLE_WAY`], at [`CABLE_AT_M`] in object axes, N.
    pub external_force_n: f64,
    /// Lateral force for each metre of object displacement along X, N/m.
    pub lateral_pull_n_m: f64,
    /// How the sensors err.
    pub sensors: SensorErrors,
}

/// Errors of the sensors.
#[derive(Clone, Debug, Default, Serialize)]
pub struct SensorErrors {
    /// Constant error of fingers 1, 2 and pusher: force (N) and torque (N m).
    pub bias: [[f64; 6]; 3],
    /// How fast that changes from the trial's start on: N/s, N m/s.
    pub drift: [[f64; 6]; 3],
    /// Standard deviation of force and torque noise: fingers, pusher.
    pub noise: [[f64; 2]; 2],
    /// Standard deviation of position and rotation noise.
    pub pose_noise: [f64; 2],
    /// Relative gain error of the finger sensors (the pusher's where there are no fingers).
    pub gain: f64,
    /// Finger sensors turned about gripper Y (the pusher's about world Z), rad.
    pub misalignment_rad: f64,
    /// Share of a finger's normal force that leaks into its X reading.
    pub crosstalk: f64,
    /// Delay of the object's pose, s.
    pub mocap_latency_s: f64,
}
