//! The jaw: both fingers move symmetrically, their opening follows the balance of forces,
//!
//! ```text
//! m/2 w'' = (N1 + N2)/2 - F - b w' - s
//! ```
//!
//! F is the actuator's force, which lags its command; s is a Dahl bristle in the drive (stiction);
//! a jaw with a stiff gear adds k (w - w0) to F. While a pad slides, a jaw may lose force (the
//! drive creeps back under vibration) and win it back afterwards.

use serde::Serialize;

/// Properties of a jaw.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct JawSpec {
    /// Mass of one finger, kg.
    pub finger_kg: f64,
    /// Damping of the opening, N s/m.
    pub damping: f64,
    /// Lag of the actuator, s.
    pub lag_s: f64,
    /// Stiction of the drive, N.
    pub stiction_n: f64,
    /// Stiffness of the gear, N/m; 0 for a jaw that is controlled by force alone.
    pub gear_n_m: f64,
    /// Share of the force that acts less, at all times.
    pub loss: f64,
    /// Constant loss, N.
    pub loss_n: f64,
    /// Share of the force lost for each metre of slip, 1/m.
    pub slip_loss_1_m: f64,
    /// Greatest share lost by slip.
    pub slip_loss_most: f64,
    /// Time in which what was lost by slip comes back, s.
    pub slip_recovery_s: f64,
}

impl JawSpec {
    /// Force control without any defect.
    pub fn ideal() -> Self {
        Self {
            finger_kg: 0.05,
            damping: 20.0,
            lag_s: 0.002,
            stiction_n: 0.0,
            gear_n_m: 0.0,
            loss: 0.0,
            loss_n: 0.0,
            slip_loss_1_m: 0.0,
            slip_loss_most: 0.0,
            slip_recovery_s: 0.1,
        }
    }
}

/// State of a jaw.
#[derive(Clone, Copy, Debug)]
pub struct Jaw {
    /// Opening between the pads, m.
    pub opening_m: f64,
    /// m/s.
    pub rate_m_s: f64,
    actuator_n: f64,
    lost: f64,
    stuck_m: f64,
    reference_m: Option<f64>,
}

/// Deflection at which the drive's stiction is reached, m.
const DRIVE_BRISTLE_M: f64 = 2e-6;

impl Jaw {
    /// Closed on an object with the actuator at `force_n`.
    pub fn closed(opening_m: f64, force_n: f64) -> Self {
        Self { opening_m, rate_m_s: 0.0, actuator_n: force_n, lost: 0.0, stuck_m: 0.0, reference_m: None }
    }

    /// The gear's spring counts from here.
    pub fn lock(&mut self) {
        self.reference_m = Some(self.opening_m);
    }

    /// One step under the normal forces' sum and the pads' mean slip speed.
    pub fn step(&mut self, spec: &JawSpec, command_n: f64, normals_n: f64, slip_m_s: f64, dt: f64) {
        self.lost += dt * (spec.slip_loss_1_m * slip_m_s * (1.0 - self.lost / spec.slip_loss_most.max(1e-9)));
        self.lost /= 1.0 + dt / spec.slip_recovery_s;
        let wanted = (command_n * (1.0 - spec.loss) - spec.loss_n) * (1.0 - self.lost);
        self.actuator_n += (wanted.max(0.0) - self.actuator_n) * (dt / (spec.lag_s + dt));
        let gear = self.reference_m.map_or(0.0, |w0| spec.gear_n_m * (self.opening_m - w0));
        let mut stick = 0.0;
        if spec.stiction_n > 0.0 {
            let z = self.stuck_m + self.rate_m_s * dt;
            self.stuck_m = z / (1.0 + self.rate_m_s.abs() * dt / DRIVE_BRISTLE_M);
            stick = spec.stiction_n * self.stuck_m / DRIVE_BRISTLE_M;
        }
        let force = 0.5 * normals_n - (self.actuator_n + gear).max(0.0) - stick;
        let mass = 0.5 * spec.finger_kg;
        self.rate_m_s = (self.rate_m_s + force * dt / mass) / (1.0 + spec.damping * dt / mass);
        self.opening_m = (self.opening_m + self.rate_m_s * dt).max(1e-4);
    }
}
