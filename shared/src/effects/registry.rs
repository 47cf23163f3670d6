//! The one place where effects are listed. To add one: write its file beside this one and
//! append a line here, with a number that was never used (it goes over the wire). Number 0 is
//! the user's own formula.

use super::law::Law;
use super::{
    adhesion, anisotropic_friction, contact_compliance, dwell_strengthening, external_force, face_tilt,
    face_waviness, finger_friction_mismatch, formula, gravity_tilt, grip_force_lag, grip_force_loss,
    load_dependent_friction, mass_error, mocap_latency, plate_tilt, pressure_offset, rolling_resistance,
    sensor_bias, sensor_crosstalk, sensor_gain, sensor_misalignment, static_friction, support_anisotropy,
    support_pressure, torsional_friction, viscous_friction, wear_drift,
};
use crate::effect::{Info, Parameter};
use crate::real::Real;

macro_rules! bounds_of {
    ($module:ident) => {
        const { &bounds_of::<{ $module::INFO.parameters.len() }>($module::INFO.parameters) }
    };
}

const fn bounds_of<const N: usize>(parameters: &[Parameter]) -> [[f32; 2]; N] {
    let mut bounds = [[0.0; 2]; N];
    let mut k = 0;
    while k < N {
        bounds[k] = [parameters[k].low as f32, parameters[k].high as f32];
        k += 1;
    }
    bounds
}

macro_rules! registry {
    ($($code:literal => $module:ident :: $law:ident),* $(,)?) => {
        // The number stands here and in the description: they must agree.
        $(const _: () = assert!(
            $module::INFO.code == $code,
            concat!("`code` in effects/", stringify!($module), ".rs is not the number in registry.rs")
        );)*

        /// Descriptions of all effects.
        pub static REGISTRY: &[&Info] = &[$(&$module::INFO),*];

        /// Least and largest values of the parameters of the effect with this code, to the precision of a board and without
        /// the words of its description, for which one has no room; `None` where there is none.
        pub fn bounds(code: u8) -> Option<&'static [[f32; 2]]> {
            match code {
                formula::CODE => Some(bounds_of!(formula)),
                $($code => Some(bounds_of!($module)),)*
                _ => None,
            }
        }

        /// The law with this code; `None` where there is none.
        pub fn law<R: Real>(code: u8) -> Option<&'static dyn Law<R>> {
            match code {
                $($code => Some(&$module::$law),)*
                _ => None,
            }
        }
    };
}

registry! {
    1 => static_friction::StaticFriction,
    2 => viscous_friction::ViscousFriction,
    3 => dwell_strengthening::DwellStrengthening,
    4 => load_dependent_friction::LoadDependentFriction,
    5 => anisotropic_friction::AnisotropicFriction,
    6 => finger_friction_mismatch::FingerFrictionMismatch,
    7 => wear_drift::WearDrift,
    8 => contact_compliance::ContactCompliance,
    9 => torsional_friction::TorsionalFriction,
    10 => pressure_offset::PressureOffset,
    11 => face_tilt::FaceTilt,
    12 => face_waviness::FaceWaviness,
    13 => plate_tilt::PlateTilt,
    14 => adhesion::Adhesion,
    15 => grip_force_loss::GripForceLoss,
    16 => grip_force_lag::GripForceLag,
    17 => mass_error::MassError,
    18 => gravity_tilt::GravityTilt,
    19 => rolling_resistance::RollingResistance,
    20 => sensor_bias::SensorBias,
    21 => sensor_gain::SensorGain,
    22 => sensor_misalignment::SensorMisalignment,
    23 => sensor_crosstalk::SensorCrosstalk,
    24 => mocap_latency::MocapLatency,
    25 => support_pressure::SupportPressure,
    26 => support_anisotropy::SupportAnisotropy,
    27 => external_force::ExternalForce,
}
