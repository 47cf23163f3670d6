//! The weight of a trial's object, and directions against it and across.

use nalgebra::Vector3;

use super::simulate::Prepared;

impl Prepared {
    /// Weight of the object, N.
    #[must_use]
    pub fn weight_n(&self) -> f64 {
        self.scene.object.mass_kg * Vector3::from(self.scene.gravity_m_s2).norm()
    }

    /// Direction against gravity, carrier axes at the start; `None` without gravity.
    #[must_use]
    pub fn up(&self) -> Option<Vector3<f64>> {
        let gravity = Vector3::from(self.scene.gravity_m_s2);
        (gravity.norm() > 0.0).then(|| -(self.carrier.rotation.inverse() * gravity.normalize()))
    }

    /// Direction across [`Prepared::up`] and the grip's axis, carrier axes at the start; `None` where these are one, to 6 degrees.
    #[must_use]
    pub fn side(&self) -> Option<Vector3<f64>> {
        self.up()?.cross(&Vector3::y()).try_normalize(0.1)
    }
}
