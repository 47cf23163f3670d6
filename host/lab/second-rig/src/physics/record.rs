//! What a perfect observer would have written down.

use nalgebra::Vector3;

use super::body::Frame;
use super::slip::Truth;

/// Force and torque on the object.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wrench {
    /// N.
    pub force: Vector3<f64>,
    /// N m.
    pub torque: Vector3<f64>,
}

impl Wrench {
    /// Adds `other` times `weight`.
    pub fn add(&mut self, other: &Wrench, weight: f64) {
        self.force += other.force * weight;
        self.torque += other.torque * weight;
    }
}

/// One sample. Wrenches are means over the sensors' window that ends here.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// s.
    pub t_s: f64,
    /// N.
    pub grip_cmd_n: f64,
    /// Gripper.
    pub gripper: Frame,
    /// Object frame as the user knows it.
    pub object: Frame,
    /// Pusher.
    pub pusher: Option<Frame>,
    /// Finger 1 and 2: gripper axes, about each patch's centre.
    pub fingers: [Wrench; 2],
    /// Pusher: world axes, about its origin at the first sample.
    pub pusher_wrench: Wrench,
    /// Table under the object: world axes, about the world's origin. Not written.
    pub support_wrench: Wrench,
    /// Other forces on the object (knocks, cables), world axes, N. Not written.
    pub other_force: Vector3<f64>,
    /// Mean acceleration of the true centre of mass over the window, m/s2. Not written.
    pub acceleration: Vector3<f64>,
    /// True mass, kg. Not written.
    pub mass_kg: f64,
}

/// A whole trial.
#[derive(Clone, Debug)]
pub struct Record {
    /// At the nominal rate.
    pub samples: Vec<Sample>,
    /// What happened.
    pub truth: Truth,
    /// Time step, s.
    pub step_s: f64,
}
