//! A contact patch: elements, their bristles and foundations, summed to one wrench on the object.

use nalgebra::Vector3;

use super::foundation::Foundation;
use super::friction::{Bristle, Law};
use super::layout::Element;
use super::surface::{Geometry, Relative, Surface};

/// Tangential stiffness of a whole patch.
#[derive(Clone, Copy, Debug, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Shear {
    /// Spread over the area whatever the load, N/m.
    Fixed(f64),
    /// In proportion to each element's load, 1/m.
    PerLoad(f64),
}

#[derive(Clone, Copy, Debug, Default)]
struct Memory {
    deflection: Vector3<f64>,
    relaxing: f64,
    load: f64,
}

/// One contact of the object with one tool.
#[derive(Clone, Debug)]
pub struct Patch {
    /// Friction.
    pub law: Law,
    /// Normal stiffness.
    pub foundation: Foundation,
    /// Tangential stiffness.
    pub shear: Shear,
    /// Damping of the bristles over their stiffness, s.
    pub shear_damping_s: f64,
    /// How elements meet the object.
    pub geometry: Geometry,
    /// Arm by which the normal force runs ahead of a rolling cylinder, m.
    pub rolling_arm_m: f64,
    elements: Vec<Element>,
    memory: Vec<Memory>,
    age_s: f64,
    load_n: f64,
}

/// Sum of a patch in one step, tool axes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Load {
    /// On the object, N.
    pub force: Vector3<f64>,
    /// On the object about the tool's origin, N m.
    pub torque: Vector3<f64>,
    /// Sum of normal forces, N.
    pub normal_n: f64,
    /// Share of the load whose bristles slide.
    pub sliding: f64,
    /// Slip speed, mean over the load, m/s.
    pub slip_m_s: f64,
    /// Irreversible displacement in this step, mean over the load, m.
    pub plastic_m: f64,
    /// Power that the tool's patch takes from the object, W.
    pub power_w: f64,
}

/// A bristle slides where it carries this share of its limit...
const SLIDING_SHARE: f64 = 0.9;
/// ...moves faster than this (m/s)...
const SLIDING_SPEED: f64 = 1e-5;
/// ...and this share of its motion is irreversible.
const SLIDING_PLASTIC: f64 = 0.5;
/// Contact age is renewed within this slip, m.
const AGE_SLIP_M: f64 = 5e-5;
/// Rolling speed at which the normal force is half way ahead, m/s.
const ROLLING_KNEE: f64 = 2e-4;

impl Patch {
    /// A patch whose bristles are unloaded.
    pub fn new(
        elements: Vec<Element>,
        law: Law,
        foundation: Foundation,
        shear: Shear,
        shear_damping_s: f64,
        geometry: Geometry,
    ) -> Self {
        let memory = vec![Memory::default(); elements.len()];
        let load_n = law.load_reference_n;
        Self {
            law,
            foundation,
            shear,
            shear_damping_s,
            geometry,
            rolling_arm_m: 0.0,
            elements,
            memory,
            age_s: 0.1,
            load_n,
        }
    }

    /// Tangential stiffness under a load, N/m.
    pub fn shear_n_m(&self, load_n: f64) -> f64 {
        match self.shear {
            Shear::Fixed(k) => k,
            Shear::PerLoad(k) => k * load_n,
        }
    }

    /// One step. `shift` and `shift_rate` move the elements in the tool's frame (a jaw's finger);
    /// `mu_factor` scales friction.
    pub fn step(
        &mut self,
        surface: &Surface,
        object: &Relative,
        shift: &Vector3<f64>,
        shift_rate: &Vector3<f64>,
        mu_factor: f64,
        dt: f64,
    ) -> Load {
        let mut out = Load::default();
        let mu = self.law.patch_mu(self.load_n, self.age_s) * mu_factor;
        let reach = self.foundation.reach_m();
        let grain = self.law.grain.along(&object.rotation);
        for (element, memory) in self.elements.iter().zip(&mut self.memory) {
            let place = element.position + shift;
            let Some(touch) = self.geometry.touch(&place, surface, object, reach) else {
                *memory = Memory::default();
                continue;
            };
            let v = object.velocity_at(&touch.point) - shift_rate;
            let vn = v.dot(&touch.normal);
            let vt = v - touch.normal * vn;
            let load = self.foundation.step(&mut memory.relaxing, touch.depth, -vn, element.load, dt);
            let stiffness = match self.shear {
                Shear::Fixed(k) => k * element.area,
                Shear::PerLoad(k) => {
                    // New contact forms unstressed: the force stays, no energy comes from nothing.
                    if load > memory.load && load > 0.0 {
                        memory.deflection *= memory.load / load;
                    }
                    memory.load = load.max(0.0);
                    k * load.max(1e-6)
                }
            };
            let mut factor = mu;
            if surface.wave[0] != 0.0 {
                let angle = std::f64::consts::TAU * touch.along_m / surface.wave[1] + surface.wave[2];
                factor *= 1.0 + surface.wave[0] * angle.sin();
            }
            let bristle = Bristle {
                stiffness,
                damping: stiffness * self.shear_damping_s,
                limit_n: factor * (load + self.law.adhesion_n * element.load).max(0.0),
                grain,
            };
            let z = &mut memory.deflection;
            *z -= touch.normal * touch.normal.dot(z);
            let pull = bristle.step(&self.law, z, &vt, dt);
            let force = touch.normal * load - pull.force;
            let mut point = touch.point;
            out.force += force;
            if self.rolling_arm_m != 0.0 {
                let ahead = object.velocity - touch.normal * object.velocity.dot(&touch.normal);
                let speed = ahead.norm_squared().sqrt();
                point += ahead * (self.rolling_arm_m / (speed + ROLLING_KNEE));
                out.torque += point.cross(&(touch.normal * load)) - touch.point.cross(&pull.force);
            } else {
                out.torque += point.cross(&force);
            }
            out.normal_n += load;
            out.power_w -= force.dot(&v);
            let weight = load.max(0.0);
            let speed = pull.speed;
            if pull.share >= SLIDING_SHARE
                && speed > SLIDING_SPEED
                && pull.plastic_m > SLIDING_PLASTIC * speed * dt
            {
                out.sliding += weight;
            }
            out.slip_m_s += weight * speed;
            out.plastic_m += weight * pull.plastic_m;
        }
        if out.normal_n > 0.0 {
            let scale = 1.0 / out.normal_n;
            out.sliding *= scale;
            out.slip_m_s *= scale;
            out.plastic_m *= scale;
            self.load_n = out.normal_n;
        } else {
            out.sliding = 1.0;
        }
        if self.law.dwell != 0.0 {
            let renewed = out.sliding * out.slip_m_s / AGE_SLIP_M;
            self.age_s = (self.age_s + dt) / (1.0 + renewed * dt);
        }
        out
    }
}
