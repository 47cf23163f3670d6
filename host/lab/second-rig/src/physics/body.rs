//! One free rigid body: Newton and Euler in world axes about the true centre of mass, by
//! semi-implicit Euler (velocity first, then pose with the new velocity).

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Pose and velocity of a rigid frame, world axes.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Origin, m.
    pub position: Vector3<f64>,
    /// Local axes into world axes.
    pub rotation: UnitQuaternion<f64>,
    /// Velocity of the origin, m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity, rad/s.
    pub spin: Vector3<f64>,
}

impl Frame {
    /// At rest.
    pub fn fixed(position: Vector3<f64>, rotation: UnitQuaternion<f64>) -> Self {
        Self { position, rotation, velocity: Vector3::zeros(), spin: Vector3::zeros() }
    }
}

/// The object. Its frame is where the user is told that the centre of mass is; the true centre
/// may lie elsewhere.
#[derive(Clone, Debug)]
pub struct Body {
    /// kg.
    pub mass_kg: f64,
    /// About the true centre of mass, along object axes, kg m2.
    pub inertia: Vector3<f64>,
    /// True centre of mass in the object frame, m.
    pub centre: Vector3<f64>,
    /// State of the centre of mass; axes are those of the object.
    pub state: Frame,
}

impl Body {
    /// A body at rest whose object frame is at `origin`.
    pub fn at_rest(
        mass_kg: f64,
        inertia: Vector3<f64>,
        centre: Vector3<f64>,
        origin: Vector3<f64>,
        rotation: UnitQuaternion<f64>,
    ) -> Self {
        Self { mass_kg, inertia, centre, state: Frame::fixed(origin + rotation * centre, rotation) }
    }

    /// The object frame, with the velocity of its origin.
    pub fn frame(&self) -> Frame {
        let arm = self.state.rotation * self.centre;
        Frame {
            position: self.state.position - arm,
            velocity: self.state.velocity - self.state.spin.cross(&arm),
            ..self.state
        }
    }

    /// One step under force (N) and torque about the centre of mass (N m), world axes.
    pub fn step(&mut self, force: &Vector3<f64>, torque: &Vector3<f64>, dt_s: f64) {
        let s = &mut self.state;
        s.velocity += force * (dt_s / self.mass_kg);
        s.position += s.velocity * dt_s;
        let r: Matrix3<f64> = s.rotation.to_rotation_matrix().into_inner();
        let spin = r.tr_mul(&s.spin);
        let local = r.tr_mul(torque) - spin.cross(&self.inertia.component_mul(&spin));
        s.spin = r * (spin + local.component_div(&self.inertia) * dt_s);
        s.rotation = UnitQuaternion::new(s.spin * dt_s) * s.rotation;
        s.rotation.renormalize_fast();
    }
}

/// Moment of inertia of a solid box of full sizes `size` (m), kg m2.
pub fn box_inertia(mass_kg: f64, size: &Vector3<f64>) -> Vector3<f64> {
    let s = size.component_mul(size);
    Vector3::new(s.y + s.z, s.x + s.z, s.x + s.y) * (mass_kg / 12.0)
}

/// Moment of inertia of a solid cylinder along X, kg m2.
pub fn cylinder_inertia(mass_kg: f64, length_m: f64, diameter_m: f64) -> Vector3<f64> {
    let r2 = 0.25 * diameter_m * diameter_m;
    let across = mass_kg * (3.0 * r2 + length_m * length_m) / 12.0;
    Vector3::new(0.5 * mass_kg * r2, across, across)
}
