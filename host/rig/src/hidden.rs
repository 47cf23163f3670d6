//! Hidden effects: physics that the rig has and a base model does not. Each has one
//! strength with a unit; at strength zero nothing changes.
//!
//! The names without the prefix `u_` are those that the diagnosis knows; the others stand
//! outside its list on purpose.

use std::fmt;
use std::str::FromStr;

use serde::Serialize;

use super::truth::Truth;

/// One hidden effect.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HiddenEffect {
    /// Which.
    pub kind: Kind,
    /// How much, in the kind's unit.
    pub strength: f64,
}

macro_rules! kinds {
    ($($variant:ident $name:literal $unit:literal $typical:literal $what:literal;)*) => {
        /// The effects by name.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
        pub enum Kind {
            $(#[doc = $what] #[serde(rename = $name)] $variant,)*
        }

        impl Kind {
            /// All effects.
            pub const ALL: &[Kind] = &[$(Kind::$variant,)*];

            /// Identifier used on the command line.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// Unit of the strength.
            pub fn unit(self) -> &'static str {
                match self { $(Self::$variant => $unit,)* }
            }

            /// A strength at which the effect shows clearly beside the paper's noise.
            pub fn typical_strength(self) -> f64 {
                match self { $(Self::$variant => $typical,)* }
            }

            /// What the rig does.
            pub fn what(self) -> &'static str {
                match self { $(Self::$variant => $what,)* }
            }
        }
    };
}

kinds! {
    StaticFriction "static_friction" "-" 0.3 "break-away over sliding friction less one; decays with slip speed (2 mm/s) within 3 ms";
    ViscousFriction "viscous_friction" "N s/m" 40.0 "resistance of each finger in proportion to its sliding speed, beyond the cone";
    DwellStrengthening "dwell_strengthening" "-" 0.08 "gain of friction for each e-fold of contact age (rate and state; renewed by 50 um of slip, onset 0.1 s)";
    LoadDependentFriction "load_dependent_friction" "-" 0.333 "mu falls with the finger's load to this power (nominal at 20 N)";
    AnisotropicFriction "anisotropic_friction" "-" 0.4 "difference of friction along and across the object's X over the mean";
    FingerFrictionMismatch "finger_friction_mismatch" "-" 0.2 "half the difference of the fingers' friction over the mean, finger 1 above";
    WearDrift "wear_drift" "-" -0.3 "relative change of finger friction from the first to the last trial, in proportion to planned sliding distance";
    ContactCompliance "contact_compliance" "m/N" 5e-5 "additional compliance of each finger pad, tangential and normal";
    TorsionalFriction "torsional_friction" "-" -1.0 "true over stated patch size less one; -1 is a point contact";
    PressureOffset "pressure_offset" "m" 3e-3 "centre of pressure of both fingers off the patch centre along gripper X";
    FaceTilt "face_tilt" "rad" 0.02 "angle between the gripped faces, opening towards +X; opens the jaw (20 N/mm) and turns the normals";
    FaceWaviness "face_waviness" "m" 5e-5 "amplitude of waves (25 mm) on both gripped faces, symmetric";
    PlateTilt "plate_tilt" "rad" 0.02 "pusher plate turned about world Y, edge contact";
    Adhesion "adhesion" "N" 5.0 "load that adhesion adds to each finger's normal force";
    GripForceLoss "grip_force_loss" "-" 0.15 "share of the commanded grip that is missing";
    GripForceLag "grip_force_lag" "-" 0.2 "share of the grip that is lost in sustained sliding (0.3 s) and recovers at rest";
    MassError "mass_error" "-" 0.3 "true over stated mass less one";
    GravityTilt "gravity_tilt" "rad" 0.1 "gravity turned about the horizontal diagonal";
    ExternalForce "external_force" "N" 0.8 "constant pull along world (2, 1, -2), on object X 30 mm from the centre (a taut cable)";
    RollingResistance "rolling_resistance" "m" 1e-3 "lever of the platform's reaction ahead of the rolling object";
    SensorBias "sensor_bias" "N" 0.6 "constant error of finger 1 along X, beyond what the data set states (the pusher's where there are no fingers)";
    SensorGain "sensor_gain" "-" 0.1 "relative gain error of the finger sensors (the pusher's where there are no fingers)";
    SensorMisalignment "sensor_misalignment" "rad" 0.1 "finger sensors turned about gripper Y (the pusher's about Z where there are no fingers)";
    SensorCrosstalk "sensor_crosstalk" "-" 0.03 "share of a finger's Y force read as X force (pusher: of X force read as Y force)";
    MocapLatency "mocap_latency" "s" 0.03 "delay of the object's pose";
    SlipPeriodic "u_slip_periodic" "-" 0.15 "finger friction repeats with slip distance (2.5 mm), relative amplitude";
    ThermalFade "u_thermal_fade" "-" 0.4 "share of finger friction lost as frictional work is done (0.03 J)";
    PusherHeight "u_pusher_height" "1/m" 60.0 "pusher friction grows with height on the plate";
    LateralPull "u_lateral_pull" "N/m" 150.0 "lateral force on the object, in proportion to its displacement along X (a magnet beside the path)";
    FingerBending "u_finger_bending" "rad/N" 1e-3 "fingertips turn outwards under grip, so that squeezing pushes the object along gripper -X";
    Backlash "u_backlash" "m" 8e-4 "play of the fingers along gripper X";
    FaceStripe "u_face_stripe" "-" -0.5 "relative change of finger friction in the stripe -22 mm <= x <= -14 mm of the object's faces";
    MicroCreep "u_micro_creep" "m/(N s)" 3e-5 "pads creep under tangential load: displacement for each newton and second";
}

impl Kind {
    /// Whether the diagnosis has this effect in its list.
    pub fn is_listed(self) -> bool {
        !self.name().starts_with("u_")
    }
}

impl fmt::Display for HiddenEffect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.kind.name(), self.strength)
    }
}

impl FromStr for HiddenEffect {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, strength) = match text.split_once('=') {
            Some((name, number)) => {
                let strength = number.trim().parse::<f64>().ok().filter(|s| s.is_finite());
                (
                    name.trim(),
                    Some(strength.ok_or_else(|| format!("'{text}': '{number}' is not a finite number"))?),
                )
            }
            None => (text.trim(), None),
        };
        let kind = Kind::ALL.iter().copied().find(|k| k.name() == name).ok_or_else(|| {
            let names: Vec<_> = Kind::ALL.iter().map(|k| k.name()).collect();
            format!("unknown effect '{name}'; the rig has {}", names.join(", "))
        })?;
        Ok(Self { kind, strength: strength.unwrap_or(kind.typical_strength()) })
    }
}

impl HiddenEffect {
    /// Builds the effect into a trial's truth. `worn` is the share of the data set's
    /// planned sliding distance that lies before this trial; `grasped` whether there are fingers.
    pub fn apply(&self, truth: &mut Truth, worn: f64, grasped: bool) {
        let s = self.strength;
        // Friction effects sit on the fingers, and on the table where nothing is grasped.
        let laws: &mut [_] = match grasped {
            true => &mut truth.finger,
            false => std::slice::from_mut(&mut truth.support),
        };
        let each = |laws: &mut [super::law::FrictionLaw], f: &dyn Fn(&mut super::law::FrictionLaw)| {
            laws.iter_mut().for_each(f);
        };
        match self.kind {
            Kind::StaticFriction => each(laws, &|l| l.break_away += s),
            Kind::ViscousFriction => each(laws, &|l| l.viscous_n_s_m += s),
            Kind::DwellStrengthening => each(laws, &|l| l.ageing += s),
            Kind::LoadDependentFriction => each(laws, &|l| l.load_exponent += s),
            Kind::AnisotropicFriction => each(laws, &|l| l.anisotropy += s),
            Kind::WearDrift => each(laws, &|l| l.mu *= (1.0 + s * worn).max(0.0)),
            Kind::Adhesion => each(laws, &|l| l.adhesion_n += s),
            Kind::SlipPeriodic => each(laws, &|l| l.periodic += s),
            Kind::ThermalFade => each(laws, &|l| l.fade += s),
            Kind::FaceStripe => each(laws, &|l| l.stripe += s),
            Kind::FingerFrictionMismatch => {
                truth.finger[0].mu *= (1.0 + s).max(0.0);
                truth.finger[1].mu *= (1.0 - s).max(0.0);
            }
            Kind::ContactCompliance => {
                let k = &mut truth.finger_stiffness;
                let soft = |n_m: f64| 1.0 / (1.0 / n_m + s.max(0.0));
                *k = super::law::Stiffness::new(
                    soft(k.normal),
                    soft(k.tangential),
                    k.normal_damping / k.normal,
                );
            }
            Kind::TorsionalFriction => truth.patch_scale *= (1.0 + s).max(0.0),
            Kind::PressureOffset => truth.pressure_offset_m.iter_mut().for_each(|o| o[0] += s),
            Kind::FaceTilt => truth.wedge_rad += s,
            Kind::FaceWaviness => truth.waviness_m += s,
            Kind::PlateTilt => truth.plate_tilt_rad[0] += s,
            Kind::GripForceLoss => truth.grip_loss += s,
            Kind::GripForceLag => truth.grip_lag += s,
            Kind::MassError => truth.mass_kg *= (1.0 + s).max(1e-3),
            Kind::GravityTilt => {
                let axis = nalgebra::Unit::new_normalize(nalgebra::Vector3::new(1.0, 1.0, 0.0));
                let turn = nalgebra::UnitQuaternion::from_axis_angle(&axis, s);
                truth.gravity_m_s2 = (turn * nalgebra::Vector3::from(truth.gravity_m_s2)).into();
            }
            Kind::ExternalForce => truth.external_force_n += s,
            Kind::RollingResistance => truth.rolling_resistance_m += s,
            Kind::SensorBias => truth.sensors.bias[if grasped { 0 } else { 2 }][0] += s,
            Kind::SensorGain => truth.sensors.gain += s,
            Kind::SensorMisalignment => truth.sensors.misalignment_rad += s,
            Kind::SensorCrosstalk => truth.sensors.crosstalk += s,
            Kind::MocapLatency => truth.sensors.mocap_latency_s += s.max(0.0),
            Kind::PusherHeight => truth.pusher.gradient_b_per_m += s,
            Kind::LateralPull => truth.lateral_pull_n_m += s,
            Kind::FingerBending => truth.finger_bend_rad_n += s,
            Kind::Backlash => truth.backlash_m += s.max(0.0),
            Kind::MicroCreep => truth.creep_m_n_s += s.max(0.0),
        }
    }
}
