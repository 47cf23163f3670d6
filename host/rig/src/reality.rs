//! The reality behind a data set: friction, hidden effects and how much runs differ; and
//! the truth of one trial drawn from it.

use nalgebra::Vector3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde::Serialize;

use stickslip_data::{Description, ObjectSpec, WrenchSensor};

use super::condition::{Condition, Primitive, Scenario};
use super::hidden::HiddenEffect;
use super::law::{FrictionLaw, Stiffness};
use super::truth::{CONTACT_DAMPING_S, CONTACT_STIFFNESS_N_M, SensorErrors, Truth};

/// How much runs of one condition differ, and how much is constantly wrong.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Nuisance {
    /// Relative standard deviation of each friction coefficient from run to run.
    pub friction_run: f64,
    /// Relative standard deviation of each friction coefficient from condition to condition.
    pub friction_condition: f64,
    /// Largest offset of the object in the gripper at the start, m.
    pub placing_m: f64,
    /// Largest turn of the object in the gripper about Y at the start, rad.
    pub placing_rad: f64,
    /// Standard deviation of the centre of pressure of each finger, m.
    pub pressure_m: f64,
    /// Constant sensor errors as a share of the stated uncertainty.
    pub bias: f64,
    /// How far sensor errors drift in a minute of a trial, as a share of the stated uncertainty.
    pub drift: f64,
    /// Sensor noise as a multiple of what the data set states.
    pub noise: f64,
}

impl Nuisance {
    /// As in the paper's experiments.
    pub const PAPER: Self = Self {
        friction_run: 0.02,
        friction_condition: 0.0,
        placing_m: 2e-4,
        placing_rad: 2e-3,
        pressure_m: 2e-4,
        bias: 0.6,
        drift: 0.0,
        noise: 1.0,
    };
    /// Nothing varies, nothing errs.
    pub const NONE: Self = Self {
        friction_run: 0.0,
        friction_condition: 0.0,
        placing_m: 0.0,
        placing_rad: 0.0,
        pressure_m: 0.0,
        bias: 0.0,
        drift: 0.0,
        noise: 0.0,
    };
}

/// Everything true about a data set that its reader is not told.
#[derive(Clone, Debug, Serialize)]
pub struct Reality {
    /// Fingertips on the object.
    pub mu_finger: f64,
    /// Plate, edge or rod on the object.
    pub mu_pusher: f64,
    /// Platform of the rolling experiment.
    pub mu_platform: f64,
    /// Table.
    pub mu_support: f64,
    /// Stiffness of each whole contact, N/m.
    pub stiffness_n_m: f64,
    /// Physics that the base model lacks.
    pub effects: Vec<HiddenEffect>,
    /// Variation and errors.
    pub nuisance: Nuisance,
    /// Constant error of fingers 1, 2 and the pusher: force (N), torque (N m).
    pub bias: [[f64; 6]; 3],
    /// How fast these change during a trial: N/s, N m/s.
    pub drift: [[f64; 6]; 3],
    /// Phase of the waves of wavy faces, rad.
    pub wave_phase_rad: f64,
}

impl Reality {
    /// Coulomb friction and nothing else: no variation, no sensor errors.
    pub fn ideal(mu_finger: f64, mu_pusher: f64) -> Self {
        Self {
            mu_finger,
            mu_pusher,
            mu_platform: 2.5,
            mu_support: 0.3,
            stiffness_n_m: CONTACT_STIFFNESS_N_M,
            effects: Vec::new(),
            nuisance: Nuisance::NONE,
            bias: [[0.0; 6]; 3],
            drift: [[0.0; 6]; 3],
            wave_phase_rad: 0.0,
        }
    }

    /// Friction from the paper's ranges (fingers 0.35 to 0.5, pusher 0.2 to 0.3) and
    /// constant sensor errors within what `description` states.
    pub fn draw(description: &Description, nuisance: Nuisance, seed: u64) -> Self {
        let mut rng = stream(seed, "reality");
        let mut reality = Self::ideal(rng.random_range(0.35..0.5), rng.random_range(0.2..0.3));
        reality.mu_support = rng.random_range(0.2..0.35);
        reality.mu_platform = rng.random_range(2.4..2.6);
        reality.wave_phase_rad = rng.random_range(0.0..std::f64::consts::TAU);
        reality.nuisance = nuisance;
        let sensors = &description.sensors;
        for (bias, sensor) in reality.bias.iter_mut().zip([sensors.finger, sensors.finger, sensors.pusher]) {
            *bias = constant_error(&sensor, nuisance.bias, &mut rng);
        }
        // A stream of its own: data without drift stay as they are.
        let mut rng = stream(seed, "drift");
        for (drift, sensor) in reality.drift.iter_mut().zip([sensors.finger, sensors.finger, sensors.pusher])
        {
            *drift = constant_error(&sensor, nuisance.drift / MINUTE_S, &mut rng);
        }
        reality
    }

    /// What is really so in one run.
    pub fn truth(
        &self,
        description: &Description,
        object: &ObjectSpec,
        condition: &Condition,
        rng: &mut ChaCha8Rng,
        of_condition: &mut ChaCha8Rng,
    ) -> Truth {
        let n = &self.nuisance;
        let grasped = condition.primitive != Primitive::PlanarPush;
        let mut vary = |mu: f64| {
            let z: f64 = rng.sample(StandardNormal);
            let c: f64 = of_condition.sample(StandardNormal);
            mu * (1.0 + n.friction_run * z.clamp(-3.0, 3.0))
                * (1.0 + n.friction_condition * c.clamp(-3.0, 3.0))
        };
        let plate = match condition.primitive {
            Primitive::Roll => self.mu_platform,
            _ => self.mu_pusher,
        };
        let finger = FrictionLaw::coulomb(vary(self.mu_finger));
        let pusher = FrictionLaw::coulomb(vary(plate));
        let support = FrictionLaw::coulomb(vary(self.mu_support));
        let stiffness = Stiffness::new(self.stiffness_n_m, self.stiffness_n_m, CONTACT_DAMPING_S);
        let sensors = &description.sensors;
        let mut bias = self.bias;
        for (bias, sensor) in bias.iter_mut().zip([sensors.finger, sensors.finger, sensors.pusher]) {
            // A little of the constant error comes anew with each run.
            let anew = constant_error(&sensor, 0.05 * n.bias, rng);
            bias.iter_mut().zip(anew).for_each(|(b, a)| *b += a);
        }
        let mut jitter = || n.pressure_m * rng.sample::<f64, _>(StandardNormal);
        let pressure_offset_m = [[jitter(), jitter()], [jitter(), jitter()]];
        let mut truth = Truth {
            finger: [finger; 2],
            pusher,
            support,
            mu: [0.0; 4],
            finger_stiffness: stiffness,
            hard_stiffness: stiffness,
            patch_scale: 1.0,
            pressure_offset_m,
            wedge_rad: 0.0,
            waviness_m: 0.0,
            wave_phase_rad: self.wave_phase_rad,
            finger_bend_rad_n: 0.0,
            backlash_m: 0.0,
            creep_m_n_s: 0.0,
            plate_tilt_rad: [0.0; 2],
            rolling_resistance_m: 0.0,
            grip_loss: 0.0,
            grip_lag: 0.0,
            mass_kg: object.mass_kg,
            com_offset_m: [0.0; 3],
            gravity_m_s2: description.gravity_m_s2,
            external_force_n: 0.0,
            lateral_pull_n_m: 0.0,
            sensors: SensorErrors {
                bias,
                drift: self.drift,
                noise: [sensors.finger, sensors.pusher]
                    .map(|s| [s.force_noise_n * n.noise, s.torque_noise_nm * n.noise]),
                pose_noise: [
                    sensors.pose.position_noise_m * n.noise,
                    sensors.pose.rotation_noise_rad * n.noise,
                ],
                ..SensorErrors::default()
            },
        };
        match condition.scenario {
            Scenario::SoftCreep { rate_m_n_s } => truth.creep_m_n_s += rate_m_n_s,
            Scenario::HeavierThanTold { factor } => truth.mass_kg *= factor,
            Scenario::OffCentre { offset_m } => truth.com_offset_m[0] += offset_m,
            Scenario::Jam { mu_pusher } => truth.pusher.mu = mu_pusher,
            Scenario::Steady
            | Scenario::DecayingGrip { .. }
            | Scenario::SuddenLoad { .. }
            | Scenario::Bumps { .. }
            | Scenario::FrictionDrop { .. } => {}
        }
        for effect in &self.effects {
            effect.apply(&mut truth, condition.worn, grasped);
        }
        truth.mu = [truth.finger[0].mu, truth.finger[1].mu, truth.pusher.mu, truth.support.mu];
        truth
    }

    /// Where the object lies in the gripper at the start: along X and Z (m), turn about Y (rad).
    pub fn placing(&self, rng: &mut ChaCha8Rng) -> (Vector3<f64>, f64) {
        let mut within = |most: f64| most * rng.random_range(-1.0..=1.0);
        let n = &self.nuisance;
        (Vector3::new(within(n.placing_m), 0.0, within(n.placing_m)), within(n.placing_rad))
    }
}

/// Seconds in a minute.
const MINUTE_S: f64 = 60.0;

fn constant_error(sensor: &WrenchSensor, share: f64, rng: &mut ChaCha8Rng) -> [f64; 6] {
    std::array::from_fn(|k| {
        let bound = if k < 3 { sensor.force_uncertainty_n } else { sensor.torque_uncertainty_nm };
        share * bound * rng.random_range(-1.0..=1.0)
    })
}

/// An independent stream of random numbers for each `name` under one seed.
pub fn stream(seed: u64, name: &str) -> ChaCha8Rng {
    // FNV-1a: a hash that never changes with the compiler or the library.
    let hash = name
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |h, byte| (h ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3));
    ChaCha8Rng::seed_from_u64(seed ^ hash)
}
