//! One free rigid body: pose and velocity of its centre of mass, integrated by the
//! semi-implicit Euler rule (velocity first, then position), which keeps stiff damped
//! contact springs stable at the rig's step of some ten microseconds.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// Rigid body state and inertia. All vectors in world axes unless the name says otherwise.
#[derive(Clone, Debug)]
pub struct Body {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Inertia about the centre of mass in body axes, kg m².
    inertia: Matrix3<f64>,
    inverse_inertia: Matrix3<f64>,
    /// Centre of mass seen from the origin of the object frame, body axes, m.
    pub com_offset_m: Vector3<f64>,
    /// Centre of mass, m.
    pub com_m: Vector3<f64>,
    /// Body axes into world axes.
    pub attitude: UnitQuaternion<f64>,
    /// Velocity of the centre of mass, m/s.
    pub velocity_m_s: Vector3<f64>,
    /// Angular velocity, rad/s.
    pub spin_rad_s: Vector3<f64>,
}

impl Body {
    /// A body at rest whose object frame is at `origin_m` with `attitude`.
    ///
    /// Returns `None` where mass or inertia is not that of a body (zero, negative, singular).
    pub fn at_rest(
        mass_kg: f64,
        inertia: Matrix3<f64>,
        com_offset_m: Vector3<f64>,
        origin_m: Vector3<f64>,
        attitude: UnitQuaternion<f64>,
    ) -> Option<Self> {
        let inverse_inertia = inertia.try_inverse()?;
        let sound = mass_kg > 0.0 && mass_kg.is_finite();
        sound.then(|| Self {
            mass_kg,
            inertia,
            inverse_inertia,
            com_offset_m,
            com_m: origin_m + attitude * com_offset_m,
            attitude,
            velocity_m_s: Vector3::zeros(),
            spin_rad_s: Vector3::zeros(),
        })
    }

    /// Origin of the object frame in the world, m.
    pub fn origin_m(&self) -> Vector3<f64> {
        self.com_m - self.attitude * self.com_offset_m
    }

    /// Kinetic energy, J.
    pub fn kinetic_energy_j(&self) -> f64 {
        let local = self.attitude.inverse() * self.spin_rad_s;
        0.5 * self.mass_kg * self.velocity_m_s.norm_squared() + 0.5 * local.dot(&(self.inertia * local))
    }

    /// Moves on by `dt_s` under a force and a torque about the centre of mass.
    pub fn advance(&mut self, force_n: &Vector3<f64>, torque_nm: &Vector3<f64>, dt_s: f64) {
        self.velocity_m_s += force_n * (dt_s / self.mass_kg);
        // Euler's equation in body axes, where the inertia is constant.
        let rotation = self.attitude.to_rotation_matrix();
        let spin = rotation.inverse_transform_vector(&self.spin_rad_s);
        let torque = rotation.inverse_transform_vector(torque_nm);
        let gyroscopic = spin.cross(&(self.inertia * spin));
        let spin = spin + self.inverse_inertia * (torque - gyroscopic) * dt_s;
        self.spin_rad_s = rotation * spin;
        self.com_m += self.velocity_m_s * dt_s;
        let half = self.spin_rad_s * (0.5 * dt_s);
        let turn = Quaternion::from_parts(1.0, half);
        self.attitude = UnitQuaternion::new_normalize(turn * self.attitude.into_inner());
    }
}
