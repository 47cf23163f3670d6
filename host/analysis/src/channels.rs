//! The signals that model and measurement share, as named channels.
//!
//! One sample is an array of [`COUNT`] numbers, NaN where not measured:
//! the object in the grasp (position in the carrier frame, and rotation vector since the
//! start, carrier axes), the wrench of each finger (carrier axes) and that of the pusher
//! (world axes, about its first origin). The carrier is the gripper, or, where nothing is
//! grasped, the frame in which the object lay at the start.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use stickslip_data::columns::COLUMNS;
use stickslip_shared::track::Pose;

/// Number of channels.
pub const COUNT: usize = 24;
/// One sample of all channels, SI units.
pub type Signals = [f64; COUNT];

/// What a channel measures.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, schemars::JsonSchema, serde::Serialize,
)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// m
    Position,
    /// rad
    Rotation,
    /// N
    Force,
    /// N m
    Torque,
}

impl Quantity {
    /// SI unit.
    pub fn unit(self) -> &'static str {
        match self {
            Quantity::Position => "m",
            Quantity::Rotation => "rad",
            Quantity::Force => "N",
            Quantity::Torque => "N m",
        }
    }
}

/// Names in the order of [`Signals`]: the object in the grasp, then the wrenches as the columns of the
/// format name them.
pub const NAMES: [&str; COUNT] = {
    let mut names = [""; COUNT];
    let object =
        ["object_x_m", "object_y_m", "object_z_m", "object_rx_rad", "object_ry_rad", "object_rz_rad"];
    let first = COLUMNS.len() - (COUNT - object.len());
    let mut k = 0;
    while k < COUNT {
        names[k] = if k < object.len() { object[k] } else { COLUMNS[first + k - object.len()] };
        k += 1;
    }
    names
};

/// First of the fingers' forces and torques, which the pusher's follow: what comes before are poses.
pub const FINGER_FORCE: usize = 6;
/// First channel of the pusher's force.
pub const PUSHER_FORCE: usize = 18;

/// What channel `index` measures.
pub fn quantity(index: usize) -> Quantity {
    match (index / 6, (index % 6) / 3) {
        (0, 0) => Quantity::Position,
        (0, _) => Quantity::Rotation,
        (_, 0) => Quantity::Force,
        _ => Quantity::Torque,
    }
}

/// 'finger 1 force x', from a channel's name; also of the fingers' sum and difference, as
/// [`crate::fit::features`] names them. A name that is no channel's stays as it is.
pub fn channel_words(channel: &str) -> String {
    let (plain, body) = if channel.starts_with("finger_sum") {
        (channel.replace("finger_sum", "finger1"), Some("fingers together,"))
    } else if channel.starts_with("finger_difference") {
        (channel.replace("finger_difference", "finger2"), Some("finger 1 less finger 2,"))
    } else {
        (channel.to_owned(), None)
    };
    let Some(index) = NAMES.iter().position(|n| *n == plain) else { return channel.to_owned() };
    let axis = ["x", "y", "z"][index % 3];
    let body = body.unwrap_or(["object", "finger 1", "finger 2", "pusher"][index / 6]);
    let what = match quantity(index) {
        Quantity::Position => "position",
        Quantity::Rotation => "rotation",
        Quantity::Force => "force",
        Quantity::Torque => "torque",
    };
    format!("{body} {what} {axis}")
}

/// A data set's pose as the model's type. The reader has checked it.
pub fn pose(p: &stickslip_data::Pose) -> Pose<f64> {
    let [w, x, y, z] = p.quaternion;
    Pose {
        position_m: Vector3::from(p.position_m),
        rotation: UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)),
    }
}

/// Mean pose; `None` of nothing. The rotation is the mean of rotation vectors about the first.
pub fn mean_pose(poses: impl Iterator<Item = Pose<f64>>) -> Option<Pose<f64>> {
    let (mut position_m, mut turn, mut count, mut first) = (Vector3::zeros(), Vector3::zeros(), 0.0, None);
    for p in poses {
        let first = first.get_or_insert(p.rotation);
        position_m += p.position_m;
        turn += (p.rotation * first.inverse()).scaled_axis();
        count += 1.0;
    }
    first.map(|f| Pose {
        position_m: position_m / count,
        rotation: UnitQuaternion::from_scaled_axis(turn / count) * f,
    })
}

/// Object channels from its pose in the carrier frame and its rotation at the start.
pub fn object_channels(local: &Pose<f64>, start: &UnitQuaternion<f64>) -> [f64; 6] {
    let turn = (local.rotation * start.inverse()).scaled_axis();
    let p = local.position_m;
    [p.x, p.y, p.z, turn.x, turn.y, turn.z]
}

/// Measured channels of one sample; `carrier` is the carrier's pose at it.
pub fn measured(
    sample: &stickslip_data::Sample,
    carrier: &Pose<f64>,
    start: &UnitQuaternion<f64>,
) -> Signals {
    let mut out = [f64::NAN; COUNT];
    if let Some(object) = &sample.object {
        let local = carrier.to_local(&pose(object));
        out[..6].copy_from_slice(&object_channels(&local, start));
    }
    let wrenches = [sample.finger[0], sample.finger[1], sample.pusher_wrench];
    for (k, wrench) in wrenches.iter().enumerate() {
        if let Some(w) = wrench {
            let at = 6 * (k + 1);
            out[at..at + 3].copy_from_slice(&w.force_n);
            out[at + 3..at + 6].copy_from_slice(&w.torque_nm);
        }
    }
    out
}
