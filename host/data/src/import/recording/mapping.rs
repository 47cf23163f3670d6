//! The mapping file: which columns of which files are which signals, in which units, axes and clocks.
//! `docs/import-recordings.md` lists its keys.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use serde::Deserialize;

use super::condition_columns::recorded_in_columns;
use super::error::RecordingError;
use super::frames::{Axes, PoseFrame, WrenchFrame};
use super::units::Quantity;
use crate::{Description, description, spelling};

/// The one format that this reader knows.
pub const FORMAT: &str = "stickslip-mapping/1";

/// A mapping as its file has it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(rename = "format")]
    _format: String,
    rate_hz: Option<f64>,
    dataset: toml::Table,
    #[serde(default)]
    trials: Trials,
    streams: Vec<Stream>,
    #[serde(default)]
    fixed: Fixed,
}

/// Which trials there are, and their conditions.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trials {
    /// A table with the columns of `trials.csv`, and, to cut one recording by time, `start_s` and `end_s`.
    pub table: Option<PathBuf>,
    /// Regular expression over a trial's name; its named groups are columns of `trials.csv`.
    pub pattern: Option<String>,
    /// Units of numbers in the names.
    #[serde(default)]
    pub units: BTreeMap<String, String>,
    /// Columns that are the same in every trial.
    #[serde(default)]
    pub constants: BTreeMap<String, toml::Value>,
    /// Columns of trials.csv that are columns of the recording, of one value in a trial.
    #[serde(default)]
    pub columns: BTreeMap<String, Recorded>,
    /// Where one recording holds all trials: column of the first stream whose value numbers the trials; empty or zero: between trials.
    pub cut_by: Option<String>,
    /// Where one recording holds all trials: what moves cuts it.
    pub cut_by_motion: Option<CutByMotion>,
}

/// A column of a recording.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub enum Recorded {
    /// Of the first stream.
    First(String),
    /// Of any stream.
    Of {
        /// Its name.
        stream: String,
        /// Column.
        column: String,
    },
}

/// How one recording is cut by what moves: the gripper, or the object where no stream has the gripper's pose.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CutByMotion {
    /// Shortest rest between two trials, s.
    pub rest_s: f64,
    /// It moves where it is faster, m/s; turns count at 50 mm.
    pub speed_m_s: f64,
}

impl Default for CutByMotion {
    fn default() -> Self {
        Self { rest_s: 0.5, speed_m_s: 0.002 }
    }
}

/// One recording device: its file, its clock, its signals.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stream {
    /// Its name in messages.
    pub name: String,
    /// Path relative to the mapping; `{trial}` stands for the trial's name.
    pub file: String,
    /// Topic of an MCAP file.
    pub topic: Option<String>,
    /// Of a topic with transforms of several frames: the child frame.
    pub child_frame: Option<String>,
    /// Time stamps.
    pub time: Time,
    /// Signals by what they measure.
    pub finger1: Option<WrenchColumns>,
    /// As `finger1`.
    pub finger2: Option<WrenchColumns>,
    /// As `finger1`.
    pub pusher: Option<WrenchColumns>,
    /// Pose of the object.
    pub object: Option<PoseColumns>,
    /// Pose of the gripper.
    pub gripper: Option<PoseColumns>,
    /// Pose of a pusher that moves.
    pub pusher_pose: Option<PoseColumns>,
    /// Commanded normal force of each finger.
    pub grip: Option<Scalar>,
}

/// Time stamps of a stream.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Time {
    /// Column.
    pub column: String,
    /// Unit.
    #[serde(default = "second")]
    pub unit: String,
    /// How its clock relates to that of the first stream.
    #[serde(default)]
    pub clock: Clock,
    /// Added to its time stamps, s.
    #[serde(default)]
    pub offset_s: f64,
}

/// How a stream's clock relates to the first stream's.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Clock {
    /// One clock.
    #[default]
    Shared,
    /// Its own; both recordings of a trial begin at the same moment.
    StartsTogether,
    /// Its own; its offset is found from the data (`offset.rs`).
    Estimated,
}

/// Columns of a wrench.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WrenchColumns {
    /// x, y, z of the sensor; an empty name was not measured.
    pub force: [String; 3],
    /// x, y, z of the sensor about its origin.
    pub torque: Option<[String; 3]>,
    /// Unit.
    #[serde(default = "newton")]
    pub force_unit: String,
    /// Unit.
    #[serde(default = "newton_metre")]
    pub torque_unit: String,
    /// Sensor's axes.
    pub axes: Option<Axes>,
    /// The sensor's origin from the reference point, our axes, m.
    #[serde(default, deserialize_with = "crate::exact::numbers")]
    pub origin_m: [f64; 3],
    /// What the sensor's reading acts on.
    pub acts_on: ActsOn,
    /// From, to, s after the trial's start: the mean over it is subtracted.
    pub tare_s: Option<[f64; 2]>,
}

/// What a wrench acts on. It has no default: a wrong sign is the commonest mistake.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum ActsOn {
    /// The format's sign.
    Object,
    /// The reaction: on the finger, or on the pusher.
    Finger,
    /// The reaction.
    Pusher,
}

/// Columns of a pose.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PoseColumns {
    /// x, y, z.
    pub position: [String; 3],
    /// Unit.
    #[serde(default = "metre")]
    pub unit: String,
    /// Columns of w, x, y, z, whatever their order in the file.
    pub quaternion_wxyz: Option<[String; 4]>,
    /// Columns of roll, pitch, yaw: rotations about the fixed axes x, then y, then z.
    pub roll_pitch_yaw: Option<[String; 3]>,
    /// Unit.
    #[serde(default = "radian")]
    pub angle_unit: String,
    /// The recording's world axes.
    pub world_axes: Option<Axes>,
    /// Our origin in the recording's world is at minus this, our axes, m.
    #[serde(default, deserialize_with = "crate::exact::numbers")]
    pub world_shift_m: [f64; 3],
    /// Our body axes x, y, z in the tracked body's axes.
    pub body_axes: Option<Axes>,
    /// Our body's origin in the tracked body's axes, m.
    #[serde(default, deserialize_with = "crate::exact::numbers")]
    pub body_origin_m: [f64; 3],
}

/// A column that is a number.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scalar {
    /// Column.
    pub column: String,
    /// Unit.
    #[serde(default = "newton")]
    pub unit: String,
}

/// Poses that do not change.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fixed {
    /// World pose of a gripper that stands still.
    pub gripper: Option<FixedPose>,
    /// World pose of a pusher that stands still.
    pub pusher: Option<FixedPose>,
}

/// A pose as numbers.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FixedPose {
    /// World, m.
    #[serde(deserialize_with = "crate::exact::numbers")]
    pub position_m: [f64; 3],
    /// The body's x, y, z in our world, by names, or the quaternion `w, x, y, z` that turns them into it.
    pub axes: Option<Axes>,
}

fn second() -> String {
    Quantity::Time.si().to_owned()
}
fn newton() -> String {
    Quantity::Force.si().to_owned()
}
fn newton_metre() -> String {
    Quantity::Torque.si().to_owned()
}
fn metre() -> String {
    Quantity::Length.si().to_owned()
}
fn radian() -> String {
    Quantity::Angle.si().to_owned()
}

/// A mapping, checked.
#[derive(Clone, Debug)]
pub struct Mapping {
    /// Its file.
    pub path: PathBuf,
    /// dataset.toml of the data set.
    pub description: Description,
    /// Rate of the data set.
    pub rate_hz: f64,
    /// Which trials.
    pub trials: Trials,
    /// At least one.
    pub streams: Vec<Stream>,
    /// Poses that do not change.
    pub fixed: Fixed,
}

impl Mapping {
    /// Parses and checks the text of the file at `path`.
    ///
    /// # Errors
    /// Where, what, and what to do.
    pub fn parse(text: &str, path: &Path) -> Result<Self, RecordingError> {
        let refuse = |advice: String| RecordingError::Mapping { file: path.to_owned(), advice };
        let format = text.parse::<toml::Table>().ok().and_then(|table| table.get("format").cloned());
        if let Some(format) = format
            && format.as_str() != Some(FORMAT)
        {
            return Err(refuse(format!("format = {format}: this reader knows \"{FORMAT}\" only")));
        }
        let file: File = toml::from_str(text).map_err(|error| refuse(advice(&error)))?;
        let description = dataset(file.dataset, path).map_err(refuse)?;
        let rate_hz = file.rate_hz.unwrap_or(description.sample_rate_hz);
        if !(rate_hz > 0.0 && rate_hz.is_finite()) {
            return Err(refuse(format!("rate_hz = {rate_hz}: a rate must be positive")));
        }
        let mapping = Mapping {
            path: path.to_owned(),
            description: Description { sample_rate_hz: rate_hz, ..description },
            rate_hz,
            trials: file.trials,
            streams: file.streams,
            fixed: file.fixed,
        };
        mapping.check().map_err(refuse)?;
        Ok(mapping)
    }

    fn check(&self) -> Result<(), String> {
        let first = self.streams.first().ok_or("no [[streams]]: name at least one file of signals")?;
        if first.time.clock == Clock::Estimated {
            return Err(format!(
                "streams.{}.time.clock: the first stream's clock is the one that others are brought to; put \
                 \"estimated\" into another stream",
                first.name
            ));
        }
        let mut owners: BTreeMap<&str, &str> = BTreeMap::new();
        for (index, stream) in self.streams.iter().enumerate() {
            let name = &stream.name;
            if self.streams.iter().take(index).any(|other| other.name == *name) {
                return Err(format!("two streams are named {name:?}"));
            }
            if stream.file.ends_with(".mcap") != stream.topic.is_some() {
                return Err(format!("streams.{name}: a file of type .mcap needs a topic, another has none"));
            }
            if stream.file.matches("{trial}").count() > 1 {
                return Err(format!("streams.{name}.file: `{{trial}}` may occur once"));
            }
            if !stream.time.offset_s.is_finite() {
                return Err(format!("streams.{name}.time.offset_s is not a finite number"));
            }
            let of_stream = |what: &str, error| format!("streams.{name}.{what}: {error}");
            Quantity::Time.factor(&stream.time.unit).map_err(|error| of_stream("time.unit", error))?;
            let signals = stream.signals();
            let else_used = self.trials.cut_by.is_some() || self.condition_columns(index).next().is_some();
            if signals.is_empty() && !else_used {
                return Err(format!(
                    "streams.{name} has no signal; add finger1, finger2, pusher, object, gripper, pusher_pose or grip"
                ));
            }
            for signal in signals {
                if let Some(other) = owners.insert(signal, name) {
                    return Err(format!("{signal} comes from two streams, {other:?} and {name:?}"));
                }
            }
            for (what, wrench) in stream.wrenches() {
                wrench.scales().map_err(|error| of_stream(what, error))?;
                wrench.frame().map_err(|error| of_stream(what, error))?;
                let reaction = if what == "pusher" { ActsOn::Pusher } else { ActsOn::Finger };
                if wrench.acts_on != ActsOn::Object && wrench.acts_on != reaction {
                    let body = if what == "pusher" { "pusher" } else { "finger" };
                    return Err(of_stream(what, format!("acts_on is \"object\" or \"{body}\"")));
                }
                if wrench.tare_s.is_some_and(|[from, to]| !(from >= 0.0 && to > from)) {
                    return Err(of_stream(what, "tare_s = [from, to] must rise from 0 s on".to_owned()));
                }
            }
            for (what, pose) in stream.poses() {
                pose.scales().map_err(|error| of_stream(what, error))?;
                pose.frame().map_err(|error| of_stream(what, error))?;
                if pose.quaternion_wxyz.is_some() == pose.roll_pitch_yaw.is_some() {
                    return Err(of_stream(
                        what,
                        "give quaternion_wxyz or roll_pitch_yaw, one of them".to_owned(),
                    ));
                }
            }
            if let Some(grip) = &stream.grip {
                Quantity::Force.factor(&grip.unit).map_err(|error| of_stream("grip", error))?;
            }
        }
        for (what, pose) in [("gripper", &self.fixed.gripper), ("pusher", &self.fixed.pusher)] {
            if let Some(pose) = pose {
                pose.isometry().map_err(|error| format!("fixed.{what}: {error}"))?;
            }
        }
        if self.fixed.gripper.is_some() && owners.contains_key("gripper") {
            return Err("the gripper is fixed and in a stream; leave one out".to_owned());
        }
        let per_trial = first.file.contains("{trial}");
        if let Some(other) = self.streams.iter().find(|other| other.file.contains("{trial}") != per_trial) {
            return Err(format!(
                "streams.{} and streams.{}: either every file has `{{trial}}` in its name or none",
                first.name, other.name
            ));
        }
        let Trials { cut_by, cut_by_motion, columns, .. } = &self.trials;
        for (condition, recorded) in columns {
            recorded_in_columns(condition, &self.trials.constants, &self.trials.units)?;
            if let Recorded::Of { stream, .. } = recorded
                && !self.streams.iter().any(|other| other.name == *stream)
            {
                let names: Vec<&str> = self.streams.iter().map(|other| other.name.as_str()).collect();
                return Err(format!(
                    "trials.columns.{condition}: no stream {}; there is {}",
                    spelling::with_hint(stream, &names),
                    names.join(", ")
                ));
            }
        }
        if per_trial && (cut_by.is_some() || cut_by_motion.is_some()) {
            return Err(
                "trials.cut_by and cut_by_motion are for one recording of many trials; the files have `{trial}`"
                    .to_owned(),
            );
        }
        if cut_by.is_some() && cut_by_motion.is_some() {
            return Err("trials: give cut_by or cut_by_motion, one of them".to_owned());
        }
        if cut_by_motion.is_some_and(|cut| !(cut.rest_s > 0.0 && cut.speed_m_s > 0.0)) {
            return Err("trials.cut_by_motion: rest_s and speed_m_s must be above 0".to_owned());
        }
        Ok(())
    }
}

impl Mapping {
    /// Columns of the stream at `index` that conditions are read from, with the condition.
    pub fn condition_columns(&self, index: usize) -> impl Iterator<Item = (&str, &str)> {
        let name = self.streams.get(index).map_or("", |stream| stream.name.as_str());
        self.trials.columns.iter().filter_map(move |(condition, recorded)| match recorded {
            Recorded::First(column) if index == 0 => Some((condition.as_str(), column.as_str())),
            Recorded::Of { stream, column } if stream == name => Some((condition.as_str(), column.as_str())),
            _ => None,
        })
    }

    /// Do the files hold all trials, cut by a column or by the times in the table? Otherwise each trial has
    /// its own files; those without `{trial}` in their name are one trial.
    #[must_use]
    pub fn one_recording(&self) -> bool {
        let per_trial = self.streams.iter().any(|stream| stream.file.contains("{trial}"));
        let Trials { table, cut_by, cut_by_motion, .. } = &self.trials;
        !per_trial && (cut_by.is_some() || cut_by_motion.is_some() || table.is_some())
    }
}

impl Stream {
    /// Wrenches with their names.
    pub fn wrenches(&self) -> impl Iterator<Item = (&'static str, &WrenchColumns)> {
        [("finger1", &self.finger1), ("finger2", &self.finger2), ("pusher", &self.pusher)]
            .into_iter()
            .filter_map(|(name, columns)| Some((name, columns.as_ref()?)))
    }

    /// Poses with their names.
    pub fn poses(&self) -> impl Iterator<Item = (&'static str, &PoseColumns)> {
        [("object", &self.object), ("gripper", &self.gripper), ("pusher_pose", &self.pusher_pose)]
            .into_iter()
            .filter_map(|(name, columns)| Some((name, columns.as_ref()?)))
    }

    /// Names of its signals.
    #[must_use]
    pub fn signals(&self) -> Vec<&'static str> {
        let mut names: Vec<&'static str> = self.wrenches().map(|(name, _)| name).collect();
        names.extend(self.poses().map(|(name, _)| name));
        names.extend(self.grip.as_ref().map(|_| "grip"));
        names
    }
}

impl WrenchColumns {
    /// Factors to N and N m.
    ///
    /// # Errors
    /// An unknown unit.
    pub fn scales(&self) -> Result<[f64; 2], String> {
        Ok([Quantity::Force.factor(&self.force_unit)?, Quantity::Torque.factor(&self.torque_unit)?])
    }

    /// Its frame.
    ///
    /// # Errors
    /// Axes that are none.
    pub fn frame(&self) -> Result<WrenchFrame, String> {
        Ok(WrenchFrame {
            rotation: rotation(self.axes.as_ref())?,
            origin_m: Vector3::from(finite(self.origin_m, "origin_m")?),
            sign: if self.acts_on == ActsOn::Object { 1.0 } else { -1.0 },
        })
    }

    /// Names of its six columns; empty where not measured.
    #[must_use]
    pub fn columns(&self) -> Vec<&str> {
        let torque = self.torque.as_ref().map_or([""; 3], |names| names.each_ref().map(String::as_str));
        self.force.iter().map(String::as_str).chain(torque).collect()
    }
}

impl PoseColumns {
    /// Factors to m and rad.
    ///
    /// # Errors
    /// An unknown unit.
    pub fn scales(&self) -> Result<[f64; 2], String> {
        Ok([Quantity::Length.factor(&self.unit)?, Quantity::Angle.factor(&self.angle_unit)?])
    }

    /// Its frame.
    ///
    /// # Errors
    /// Axes that are none.
    pub fn frame(&self) -> Result<PoseFrame, String> {
        // `body_axes` names our axes in the body's; the body's pose of ours is the inverse of that turn.
        let body = rotation(self.body_axes.as_ref())?.inverse();
        let origin = Translation3::from(Vector3::from(finite(self.body_origin_m, "body_origin_m")?));
        Ok(PoseFrame {
            world: rotation(self.world_axes.as_ref())?,
            world_shift_m: Vector3::from(finite(self.world_shift_m, "world_shift_m")?),
            body: Isometry3::from_parts(origin, body),
        })
    }

    /// Names of its columns: position, then rotation.
    #[must_use]
    pub fn columns(&self) -> Vec<&str> {
        let rotation = self.quaternion_wxyz.iter().flatten().chain(self.roll_pitch_yaw.iter().flatten());
        self.position.iter().chain(rotation).map(String::as_str).collect()
    }
}

impl FixedPose {
    /// As a transformation.
    ///
    /// # Errors
    /// Axes that are none.
    pub fn isometry(&self) -> Result<Isometry3<f64>, String> {
        let position = Translation3::from(Vector3::from(finite(self.position_m, "position_m")?));
        let axes = rotation(self.axes.as_ref())?;
        // Names are the body's axes in the world; a quaternion turns the body's into the world's.
        let named = matches!(self.axes, Some(Axes::Named(_)));
        Ok(Isometry3::from_parts(position, if named { axes.inverse() } else { axes }))
    }
}

fn rotation(axes: Option<&Axes>) -> Result<UnitQuaternion<f64>, String> {
    axes.map_or(Ok(UnitQuaternion::identity()), Axes::rotation)
}

fn finite(vector: [f64; 3], key: &str) -> Result<[f64; 3], String> {
    if vector.iter().all(|component| component.is_finite()) {
        Ok(vector)
    } else {
        Err(format!("{key} has a number that is not finite"))
    }
}

/// The `[dataset]` table through the reader of dataset.toml.
fn dataset(mut table: toml::Table, path: &Path) -> Result<Description, String> {
    table.insert("format".to_owned(), description::FORMAT.into());
    let text = toml::to_string(&table).map_err(|error| error.to_string())?;
    let (description, warnings) = description::parse(&text, path).map_err(|error| {
        // Its line is that of the text made above.
        let key = error.place.column.map_or_else(String::new, |key| format!(".{key}"));
        format!("[dataset]{key}: {}", error.problem)
    })?;
    match warnings.into_iter().next() {
        None => Ok(description),
        Some(warning) => Err(format!("[dataset]: {}", warning.text)),
    }
}

/// The parser's message with its line, and what an unknown key was meant to be.
fn advice(error: &toml::de::Error) -> String {
    let message = error.message();
    let names: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let hint = match names.split_first() {
        // Of a key, and of a value.
        Some((unknown, known)) if message.starts_with("unknown ") => spelling::did_you_mean(unknown, known)
            .map_or_else(String::new, |meant| format!("\ndid you mean `{meant}`?")),
        _ => String::new(),
    };
    format!("{}{hint}", error.to_string().trim_end())
}
