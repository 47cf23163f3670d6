//! Normal force of one element of a patch: spring with a damper (Kelvin-Voigt), and beside them,
//! optionally, a spring in series with a damper (Zener's standard linear solid), which creeps and
//! relaxes:
//!
//! ```text
//! N = w (K d + C d' + q),   q' = K1 d' - q / tau,   N >= -w A
//! ```

use serde::Serialize;

/// Normal stiffness of a whole patch; an element takes the share w of it.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Foundation {
    /// K, N/m.
    pub stiffness: f64,
    /// C, N s/m.
    pub damping: f64,
    /// K1 of the relaxing branch, N/m; 0 for Kelvin-Voigt.
    pub relaxing: f64,
    /// tau of the relaxing branch, s.
    pub relaxation_s: f64,
    /// Greatest tension A of the whole patch, N.
    pub tension_n: f64,
}

impl Foundation {
    /// Force of an element of share `w` at depth `depth` (m, into the pad) that grows with `rate`
    /// (m/s). `memory` is q, N for w = 1.
    #[inline]
    pub fn step(&self, memory: &mut f64, depth: f64, rate: f64, w: f64, dt: f64) -> f64 {
        if self.relaxing > 0.0 {
            *memory = (*memory + self.relaxing * rate * dt) / (1.0 + dt / self.relaxation_s);
        }
        let full = self.stiffness * depth + self.damping * rate + *memory;
        w * full.max(-self.tension_n)
    }

    /// Gap at which adhesion lets go, m.
    pub fn reach_m(&self) -> f64 {
        self.tension_n / self.stiffness
    }
}
