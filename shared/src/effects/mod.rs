//! Physical effects that a model may have on top of its base contact law.
//!
//! An effect is one file in this folder: a unit struct that implements [`Law`], whose
//! hooks change loads, grip, contacts, friction or what the sensors show. It plugs in at
//! one place: the list in `registry`.

use crate::real::Real;

pub mod adhesion;
pub mod anisotropic_friction;
pub mod contact_compliance;
pub mod dwell_strengthening;
pub mod external_force;
pub mod face_tilt;
pub mod face_waviness;
pub mod finger_friction_mismatch;
pub mod formula;
pub mod gravity_tilt;
pub mod grip_force_lag;
pub mod grip_force_loss;
pub mod law;
pub mod load_dependent_friction;
pub mod mass_error;
pub mod mocap_latency;
pub mod plate_tilt;
pub mod pressure_offset;
mod registry;
pub mod rolling_resistance;
pub mod sensor_bias;
pub mod sensor_crosstalk;
pub mod sensor_gain;
pub mod sensor_misalignment;
pub mod static_friction;
pub mod support_anisotropy;
pub mod support_pressure;
pub mod torsional_friction;
pub mod viscous_friction;
pub mod wear_drift;
pub use crate::effect::{Effect, Expected, Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
pub use law::{Environment, FrictionLaw, Law, Loads, Reading, Slip, StepContext};
pub use registry::{REGISTRY, bounds, law};

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
