//! The data set format `stickslip-dataset/1` in memory (see `docs/dataset.md`).
//!
//! SI units throughout. Poses are world poses; wrenches are what that body exerts on the
//! object: fingers in gripper axes about their patch centre, pusher in world axes about
//! its origin at the first sample.

pub mod columns;
mod csv_table;
mod csv_text;
mod description;
pub mod error;
pub mod exact;
pub mod import;
pub mod memory;
#[cfg(feature = "parquet")]
mod parquet_table;
mod read;
pub mod schema;
pub mod series;
pub mod signal;
pub mod spelling;
mod stage;
pub mod stamp;
mod table;
mod trials;
mod write;

pub use description::FORMAT;
pub use error::{DatasetError, Line, Place, Problem, Warning};
pub use read::{Index, Reading, TrialReading, read, read_lenient};
pub use stage::{Stage, write_file};
pub use write::{TableFormat, Writer, write, write_as};

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// Position (m) and unit quaternion `w, x, y, z`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// `x, y, z`.
    pub position_m: [f64; 3],
    /// `w, x, y, z`, rotating local axes into world axes.
    pub quaternion: [f64; 4],
}

impl Pose {
    /// From a position (m) and a rotation.
    #[must_use]
    pub fn of(position_m: &nalgebra::Vector3<f64>, rotation: &nalgebra::UnitQuaternion<f64>) -> Self {
        let q = rotation.quaternion();
        Pose { position_m: (*position_m).into(), quaternion: [q.w, q.i, q.j, q.k] }
    }

    /// The same with its quaternion normalised.
    ///
    /// # Errors
    /// The norm of a quaternion that is off by more than 1 %, or not finite.
    pub fn normalised(self) -> Result<Self, f64> {
        let norm = self.quaternion.iter().map(|q| q * q).sum::<f64>().sqrt();
        if !((norm - 1.0).abs() <= 0.01) {
            return Err(norm);
        }
        // A unit quaternion stays as it was written, to the last bit.
        let scale = if (norm - 1.0).abs() < 1e-12 { 1.0 } else { norm };
        Ok(Pose { quaternion: self.quaternion.map(|q| q / scale), ..self })
    }
}

/// Force (N) and torque (N m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrench {
    /// `x, y, z`.
    pub force_n: [f64; 3],
    /// `x, y, z`.
    pub torque_nm: [f64; 3],
}

/// Static description of a data set: `dataset.toml`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Description {
    /// Always `stickslip-dataset/1`.
    pub format: String,
    /// Free text.
    pub name: String,
    /// Nominal; time stamps rule.
    pub sample_rate_hz: f64,
    /// World axes.
    #[serde(deserialize_with = "exact::numbers")]
    pub gravity_m_s2: [f64; 3],
    /// All objects.
    pub objects: Vec<ObjectSpec>,
    /// Absent where nothing is grasped.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fingers: Option<ContactSpec>,
    /// By primitive.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub pushers: BTreeMap<String, ContactSpec>,
    /// By primitive.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub supports: BTreeMap<String, ContactSpec>,
    /// Noise and uncertainty.
    #[serde(default)]
    pub sensors: Sensors,
}

/// One object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectSpec {
    /// Name used in trials.csv.
    pub id: String,
    /// `prism`, `cylinder` or `polygon`.
    pub shape: String,
    /// Along X.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_m: Option<f64>,
    /// Side of the prism or diameter of the cylinder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub side_m: Option<f64>,
    /// Our optional key: distance between the flats of a cylinder with flat faces at ±Y.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub across_flats_m: Option<f64>,
    /// Polygon corners about the centre of mass.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "exact::rows")]
    pub vertices_m: Option<Vec<[f64; 2]>>,
    /// Polygon extrusion along Z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height_m: Option<f64>,
    /// Mass.
    pub mass_kg: f64,
    /// Optional; computed from shape and mass where absent.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "exact::matrix")]
    pub inertia_kg_m2: Option<[[f64; 3]; 3]>,
}

/// Contact feature of fingers, a pusher or a support.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct ContactSpec {
    /// Fingers: disc, line, point. Pushers: plane, line, point. Supports: patch, points.
    pub contact: String,
    /// Disc.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diameter_m: Option<f64>,
    /// Line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_m: Option<f64>,
    /// Point pusher.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tip_radius_m: Option<f64>,
    /// Point supports, object axes.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "exact::rows")]
    pub points_m: Option<Vec<[f64; 2]>>,
}

/// Sensor noise (standard deviation) and uncertainty (bound on a constant error).
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Sensors {
    /// Each fingertip's force/torque sensor.
    #[serde(default)]
    pub finger: WrenchSensor,
    /// The pusher's.
    #[serde(default)]
    pub pusher: WrenchSensor,
    /// Motion capture.
    #[serde(default)]
    pub pose: PoseSensor,
}

/// Force/torque sensor.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct WrenchSensor {
    /// Standard deviation.
    #[serde(default)]
    pub force_noise_n: f64,
    /// Bound on a constant error.
    #[serde(default)]
    pub force_uncertainty_n: f64,
    /// Standard deviation.
    #[serde(default)]
    pub torque_noise_nm: f64,
    /// Bound on a constant error.
    #[serde(default)]
    pub torque_uncertainty_nm: f64,
}

/// Pose sensor.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct PoseSensor {
    /// Standard deviation.
    #[serde(default)]
    pub position_noise_m: f64,
    /// Standard deviation.
    #[serde(default)]
    pub rotation_noise_rad: f64,
}

/// One row of trials.csv.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct TrialInfo {
    /// Unique name.
    pub trial: String,
    /// Path of the table, relative to the data set's folder.
    pub file: String,
    /// An id of `Description::objects`.
    pub object: String,
    /// `linear_push`, `pivot`, `roll`, `planar_push`, `lift` or the user's own.
    pub primitive: String,
    /// Normal force of each finger.
    pub grip_n: Option<f64>,
    /// Condition.
    pub speed_m_s: Option<f64>,
    /// Condition.
    pub speed_rad_s: Option<f64>,
    /// Condition.
    pub slope_rad: Option<f64>,
    /// Condition.
    pub pusher_offset_m: Option<f64>,
    /// Repetition.
    pub run: Option<i64>,
    /// World pose of a fixed pusher.
    pub pusher: Option<Pose>,
    /// Columns that the format does not name, kept as text.
    pub extra: BTreeMap<String, String>,
}

/// One row of a trial's table. `None`: not measured.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Sample {
    /// Rises strictly.
    pub t_s: f64,
    /// Commanded normal force of each finger.
    pub grip_cmd_n: Option<f64>,
    /// World.
    pub gripper: Option<Pose>,
    /// World.
    pub object: Option<Pose>,
    /// World; only where the pusher moves.
    pub pusher: Option<Pose>,
    /// Finger 1 (+Y side), finger 2: gripper axes, about the patch centre. Components not measured are NaN.
    pub finger: [Option<Wrench>; 2],
    /// World axes, about the pusher's origin at the first sample. Components not measured are NaN.
    pub pusher_wrench: Option<Wrench>,
}

/// A trial with its samples.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Trial {
    /// Conditions.
    pub info: TrialInfo,
    /// In time order.
    pub samples: Vec<Sample>,
}

/// A whole data set.
#[derive(Clone, Debug, PartialEq)]
pub struct Dataset {
    /// Folder it was read from or will be written to.
    pub folder: PathBuf,
    /// dataset.toml.
    pub description: Description,
    /// In the order of trials.csv.
    pub trials: Vec<Trial>,
}
