//! Friction of one bristle: a deflection z (m) that follows the relative motion and relaxes as it
//! slides,
//!
//! ```text
//! dz/dt = v - a(z, v) k |v| z / (g(v) N),   F = k z + c dz/dt,   |F| <= g_max N
//! ```
//!
//! with a = 1 for Dahl (1968; constant g) and LuGre (Canudas de Wit et al. 1995), and the
//! elasto-plastic a of Dupont et al. (2002), which is zero below break-away, so that no drift
//! comes of small oscillations. g is the Stribeck curve in the rational form of Hess and Soom
//! (1990) with a viscous share. The step is implicit in z, so that steady sliding gives exactly
//! g(v) N whatever the step. Nothing here can create energy: the deflection is cut back to what
//! the limit carries, and the damper sees only the elastic share of the motion. Where the limit is an
//! ellipse, z relaxes along its normal (Velenis, Tsiotras and Canudas-de-Wit 2005), so that steady
//! sliding dissipates most.

use nalgebra::{Matrix3, Vector3};
use serde::Serialize;

/// Which differential equation the bristle obeys.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// No Stribeck curve.
    Dahl,
    /// With Stribeck curve; creeps under small oscillations.
    LuGre,
    /// Purely elastic below seven tenths of the limit.
    ElastoPlastic,
}

/// Friction law of a contact.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Law {
    /// Which equation.
    pub kind: Kind,
    /// Kinetic coefficient at low speed and reference load.
    pub mu: f64,
    /// Static over kinetic coefficient, 1 or more.
    pub static_ratio: f64,
    /// Speed at which half of the static excess is left, m/s.
    pub stribeck_m_s: f64,
    /// Relative rise of friction with speed, s/m.
    pub viscous_s_m: f64,
    /// Friction falls with the patch's load to this power.
    pub load_exponent: f64,
    /// Load at which mu holds, N.
    pub load_reference_n: f64,
    /// Load of adhesion of the whole patch, N.
    pub adhesion_n: f64,
    /// Limit along the grain over limit across it; 1 is isotropic.
    pub anisotropy: f64,
    /// Where the grain runs.
    pub grain: Grain,
    /// Relative rise of the limit for each e-fold of contact age.
    pub dwell: f64,
    /// Contact age at which that sets in, s.
    pub dwell_cutoff_s: f64,
    /// Rate at which bristles relax at rest (the pad flows), 1/s.
    pub creep_1_s: f64,
}

/// Direction of the grain: its angle from X to Y of the object or of the world, rad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Grain {
    /// Turns with the object.
    OfObject(f64),
    /// Stays in the table.
    OfTable(f64),
}

impl Grain {
    /// Unit vector along it in tool axes; `rotation` takes object axes there.
    pub fn along(self, rotation: &Matrix3<f64>) -> Vector3<f64> {
        match self {
            Self::OfObject(angle) => rotation * Vector3::new(angle.cos(), angle.sin(), 0.0),
            // The X of a table's frame points up and its Z along the world's -X.
            Self::OfTable(angle) => Vector3::new(0.0, angle.sin(), -angle.cos()),
        }
    }
}

impl Law {
    /// Coulomb's law on a Dahl bristle.
    pub fn coulomb(mu: f64) -> Self {
        Self {
            kind: Kind::Dahl,
            mu,
            static_ratio: 1.0,
            stribeck_m_s: 1e-3,
            viscous_s_m: 0.0,
            load_exponent: 0.0,
            load_reference_n: 10.0,
            adhesion_n: 0.0,
            anisotropy: 1.0,
            grain: Grain::OfObject(0.0),
            dwell: 0.0,
            dwell_cutoff_s: 0.1,
            creep_1_s: 0.0,
        }
    }

    /// Coefficient at a slip speed (m/s), over that at low speed.
    #[inline]
    pub fn speed_factor(&self, speed: f64) -> f64 {
        if self.static_ratio == 1.0 {
            return 1.0 + self.viscous_s_m * speed;
        }
        let ratio = speed / self.stribeck_m_s;
        1.0 + (self.static_ratio - 1.0) / (1.0 + ratio * ratio) + self.viscous_s_m * speed
    }

    /// Coefficient of a whole patch under a load (N) and of a contact age (s), before speed.
    pub fn patch_mu(&self, load_n: f64, age_s: f64) -> f64 {
        let mut mu = self.mu;
        if self.load_exponent != 0.0 {
            mu *= (load_n.max(0.05) / self.load_reference_n).powf(-self.load_exponent);
        }
        if self.dwell != 0.0 {
            mu *= 1.0 + self.dwell * (1.0 + age_s / self.dwell_cutoff_s).ln();
        }
        mu
    }
}

/// What one bristle did in a step.
#[derive(Clone, Copy, Debug)]
pub struct Pull {
    /// Force against the motion that was given, N.
    pub force: Vector3<f64>,
    /// Irreversible displacement, m.
    pub plastic_m: f64,
    /// Of the motion that was given, m/s.
    pub speed: f64,
    /// Force over the limit.
    pub share: f64,
}

/// Stiffness and limit of a bristle in this step.
#[derive(Clone, Copy, Debug)]
pub struct Bristle {
    /// N/m.
    pub stiffness: f64,
    /// N s/m, acts on the elastic rate.
    pub damping: f64,
    /// mu N of the patch before speed, N.
    pub limit_n: f64,
    /// Direction of the grain, unit; used where the law is anisotropic.
    pub grain: Vector3<f64>,
}

impl Bristle {
    /// Advances the deflection `z` under the tangential velocity `v` (m/s) for `dt` seconds.
    #[inline]
    pub fn step(&self, law: &Law, z: &mut Vector3<f64>, v: &Vector3<f64>, dt: f64) -> Pull {
        let speed = v.norm_squared().sqrt();
        if !(self.limit_n > 1e-12) {
            *z = Vector3::zeros();
            return Pull { force: Vector3::zeros(), plastic_m: speed * dt, speed, share: 0.0 };
        }
        let now = self.limit_n * law.speed_factor(speed);
        let most = now.max(self.limit_n * law.static_ratio);
        let slide_speed = if law.anisotropy == 1.0 { speed } else { self.dissipating(law, v).sqrt() };
        let rate = match law.kind {
            Kind::Dahl | Kind::LuGre => 1.0,
            Kind::ElastoPlastic if z.dot(v) <= 0.0 => 0.0,
            Kind::ElastoPlastic => {
                let share = self.stiffness * self.squared(law, z).sqrt() / now;
                smooth(((share - 0.7) / 0.3).clamp(0.0, 1.0))
            }
        };
        let before = *z;
        let slides = rate * self.stiffness * slide_speed / now;
        let next = |z: Vector3<f64>, slides: f64| z / (1.0 + (slides + law.creep_1_s) * dt);
        *z += v * dt;
        *z = if law.anisotropy == 1.0 {
            next(*z, slides)
        } else {
            // Flow normal to the ellipse: steady sliding dissipates most (Velenis, Tsiotras and Canudas-de-Wit 2005).
            let along = self.grain * z.dot(&self.grain);
            next(along, slides / law.anisotropy) + next(*z - along, slides * law.anisotropy)
        };
        let reach = most / self.stiffness;
        let held = self.squared(law, z);
        if held > reach * reach {
            *z *= reach / held.sqrt();
        }
        let elastic = *z - before;
        let mut force = *z * self.stiffness + elastic * (self.damping / dt);
        let mut size = self.squared(law, &force).sqrt();
        if size > most {
            force *= most / size;
            size = most;
        }
        let plastic_m = (v * dt - elastic).norm_squared().sqrt();
        Pull { force, plastic_m, speed, share: size / now }
    }

    /// Square of the speed that dissipates as much against the circle `now` as `v` does against the ellipse.
    #[inline]
    fn dissipating(&self, law: &Law, v: &Vector3<f64>) -> f64 {
        let along = v.dot(&self.grain);
        let across = (v.norm_squared() - along * along).max(0.0);
        along * along * law.anisotropy + across / law.anisotropy
    }

    /// Squared length in the metric of the limit's ellipse.
    #[inline]
    fn squared(&self, law: &Law, x: &Vector3<f64>) -> f64 {
        let all = x.norm_squared();
        if law.anisotropy == 1.0 {
            return all;
        }
        let along = x.dot(&self.grain);
        let across = (all - along * along).max(0.0);
        along * along / law.anisotropy + across * law.anisotropy
    }
}

fn smooth(x: f64) -> f64 {
    x * x * (3.0 - 2.0 * x)
}
