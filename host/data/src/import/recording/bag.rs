//! A topic of an MCAP file as a table: ROS 2 messages in CDR, one row a message.
//!
//! Columns are the message's own fields (`force.x`, `orientation.w`), without the wrapping `wrench`, `pose` or
//! `transform`; time stamps in s: `header.stamp`, `log_time`, `publish_time`. The file is read chunk by chunk.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use byteorder::{BigEndian, LittleEndian};
use cdr_encoding::from_bytes;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::error::RecordingError;
use crate::spelling;
use crate::stamp;

/// `builtin_interfaces/Time`.
#[derive(Deserialize)]
struct Stamp {
    sec: i32,
    nanosec: u32,
}

/// `std_msgs/Header`.
#[derive(Deserialize)]
struct Header {
    stamp: Stamp,
    _frame_id: String,
}

/// `geometry_msgs/Vector3`, `Point`.
type Xyz = [f64; 3];
/// `geometry_msgs/Quaternion`: x, y, z, w.
type Xyzw = [f64; 4];

#[derive(Deserialize)]
struct Transform {
    header: Header,
    child_frame_id: String,
    translation: Xyz,
    rotation: Xyzw,
}

#[derive(Deserialize)]
struct Joints {
    header: Header,
    name: Vec<String>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    effort: Vec<f64>,
}

/// Rows of a topic.
#[derive(Debug, Default)]
pub struct Table {
    /// Of the columns; time stamps first.
    pub names: Vec<String>,
    /// One for each message.
    pub rows: Vec<Vec<f64>>,
    /// The first three columns of each row, exact: s.
    pub stamps: Vec<[Option<stamp::Stamp>; 3]>,
    /// Messages of the topic.
    pub messages: usize,
    /// Why the file could not be read to its end.
    pub cut: Option<String>,
}

/// The messages on `topic` in `file`; of transforms those to `child_frame`, where it is given.
///
/// # Errors
/// A file that is no MCAP file, without the topic, of a message type that is not known, a message that
/// is not of its type.
pub fn read(file: &Path, topic: &str, child_frame: Option<&str>) -> Result<Table, RecordingError> {
    let io = |error: String| RecordingError::Io { file: file.to_owned(), error };
    let mut table = Table::default();
    let mut topics: Vec<String> = Vec::new();
    let mut frames: Vec<String> = Vec::new();
    table.cut = messages(file, |message| {
        if !topics.contains(&message.channel.topic) {
            topics.push(message.channel.topic.clone());
        }
        if message.channel.topic != topic {
            return Ok(());
        }
        table.messages += 1;
        for row in rows(message).map_err(|error| io(format!("topic {topic}: {error}")))? {
            let other = child_frame.is_some() && row.frame.is_some() && row.frame.as_deref() != child_frame;
            frames.extend(row.frame.clone());
            if !other && !table.push(message, row) {
                return Err(io(format!("topic {topic}: the fields of its messages change within the file")));
            }
        }
        Ok(())
    })?;
    if table.messages == 0 {
        let known: Vec<&str> = topics.iter().map(String::as_str).collect();
        let hint = spelling::did_you_mean(topic, &known).map_or_else(
            || format!("it has {}", known.join(", ")),
            |meant| format!("did you mean {meant:?}?"),
        );
        let cut = table.cut.map_or_else(String::new, |cut| format!(" ({cut})"));
        return Err(io(format!("no message on topic {topic:?}; {hint}{cut}")));
    }
    frames.sort();
    frames.dedup();
    if table.rows.is_empty() {
        return Err(io(format!(
            "topic {topic} has no transform to {child_frame:?}; it has {}",
            frames.join(", ")
        )));
    }
    if child_frame.is_none() && frames.len() > 1 {
        return Err(io(format!(
            "topic {topic} has transforms to {}; choose one with child_frame",
            frames.join(", ")
        )));
    }
    Ok(table)
}

/// The first `rows_kept` rows of each topic of `file` whose messages can be read; transforms once for each
/// child frame.
///
/// # Errors
/// A file that is no MCAP file.
pub fn beginnings(
    file: &Path,
    rows_kept: usize,
) -> Result<Vec<(String, Option<String>, Table)>, RecordingError> {
    let mut found: Vec<(String, Option<String>, Table)> = Vec::new();
    let cut = messages(file, |message| {
        for row in rows(message).unwrap_or_default() {
            let topic = &message.channel.topic;
            let at = found.iter().position(|(t, f, _)| t == topic && *f == row.frame).unwrap_or_else(|| {
                found.push((topic.clone(), row.frame.clone(), Table::default()));
                found.len() - 1
            });
            let table = &mut found[at].2;
            table.messages += 1;
            if table.rows.len() < rows_kept {
                table.push(message, row);
            }
        }
        Ok(())
    })?;
    match cut {
        Some(error) if found.is_empty() => Err(RecordingError::Io { file: file.to_owned(), error }),
        _ => Ok(found),
    }
}

/// Shows `each` the messages of `file` in its order. Returns why the file could not be read to its end;
/// whole chunks before a cut are good.
fn messages(
    file: &Path,
    mut each: impl FnMut(&mcap::Message) -> Result<(), RecordingError>,
) -> Result<Option<String>, RecordingError> {
    let stream = File::open(file)
        .map_err(|error| RecordingError::Io { file: file.to_owned(), error: error.to_string() })?;
    for message in mcap::io::MessageReader::new(BufReader::new(stream)) {
        match message {
            Ok(message) => each(&message)?,
            Err(error) => return Ok(Some(format!("the file cannot be read further: {error}"))),
        }
    }
    Ok(None)
}

impl Table {
    /// Is the row of the same fields as those before? Otherwise it is left out.
    fn push(&mut self, message: &mcap::Message, row: Row) -> bool {
        let stamps = ["header.stamp", "log_time", "publish_time"];
        if self.names.is_empty() {
            self.names = stamps.iter().map(|name| (*name).to_owned()).chain(row.names).collect();
        } else if !self.names[stamps.len()..].iter().eq(&row.names) {
            return false;
        }
        let exact = |nanoseconds: u64| stamp::Stamp::of_nanoseconds(i128::from(nanoseconds));
        let times = [message.log_time, message.publish_time].map(exact).map(Some);
        let stamps = [row.stamp, times[0], times[1]];
        let zero = stamp::Zero::default();
        let s =
            |stamp: Option<stamp::Stamp>| stamp.map_or(f64::NAN, |stamp| stamp.since_s(zero, 1_000_000_000));
        self.rows.push(stamps.map(s).into_iter().chain(row.cells).collect());
        self.stamps.push(stamps);
        true
    }
}

/// One row of a message.
struct Row {
    stamp: Option<stamp::Stamp>,
    frame: Option<String>,
    names: Vec<String>,
    cells: Vec<f64>,
}

fn rows(message: &mcap::Message) -> Result<Vec<Row>, String> {
    let encoding = &message.channel.message_encoding;
    if encoding != "cdr" {
        return Err(format!("its encoding is {encoding:?}; only ROS 2 messages in \"cdr\" can be read"));
    }
    let data = &message.data;
    // ROS 2 writes `package/msg/Type`.
    let kind =
        message.channel.schema.as_ref().map_or_else(String::new, |schema| schema.name.replace("/msg/", "/"));
    let one = |stamp: Option<Stamp>, fields: &[(&str, &str)], cells: Vec<f64>| {
        let names = fields
            .iter()
            .flat_map(|(field, axes)| axes.chars().map(move |axis| format!("{field}.{axis}")))
            .collect();
        Row { stamp: exact(stamp), frame: None, names, cells }
    };
    let wrench = [("force", "xyz"), ("torque", "xyz")];
    let pose = [("position", "xyz"), ("orientation", "xyzw")];
    let joined = |a: &[f64], b: &[f64]| [a, b].concat();
    Ok(match kind.as_str() {
        "geometry_msgs/WrenchStamped" => {
            let (header, force, torque): (Header, Xyz, Xyz) = decode(data)?;
            vec![one(Some(header.stamp), &wrench, joined(&force, &torque))]
        }
        "geometry_msgs/Wrench" => {
            let (force, torque): (Xyz, Xyz) = decode(data)?;
            vec![one(None, &wrench, joined(&force, &torque))]
        }
        "geometry_msgs/PoseStamped" => {
            let (header, position, orientation): (Header, Xyz, Xyzw) = decode(data)?;
            vec![one(Some(header.stamp), &pose, joined(&position, &orientation))]
        }
        "geometry_msgs/Pose" => {
            let (position, orientation): (Xyz, Xyzw) = decode(data)?;
            vec![one(None, &pose, joined(&position, &orientation))]
        }
        "geometry_msgs/TransformStamped" => vec![transform(decode(data)?)],
        "tf2_msgs/TFMessage" => decode::<Vec<Transform>>(data)?.into_iter().map(transform).collect(),
        "std_msgs/Float64" => {
            vec![Row { stamp: None, frame: None, names: vec!["data".to_owned()], cells: vec![decode(data)?] }]
        }
        "sensor_msgs/JointState" => vec![joints(decode(data)?)],
        _ => {
            return Err(format!(
                "messages of type {kind:?} are not known; WrenchStamped, Wrench, PoseStamped, Pose, \
                 TransformStamped, TFMessage, Float64, JointState are"
            ));
        }
    })
}

fn transform(transform: Transform) -> Row {
    let names = [
        "translation.x",
        "translation.y",
        "translation.z",
        "rotation.x",
        "rotation.y",
        "rotation.z",
        "rotation.w",
    ];
    Row {
        stamp: exact(Some(transform.header.stamp)),
        frame: Some(transform.child_frame_id),
        names: names.map(str::to_owned).to_vec(),
        cells: transform.translation.into_iter().chain(transform.rotation).collect(),
    }
}

fn joints(joints: Joints) -> Row {
    let mut row =
        Row { stamp: exact(Some(joints.header.stamp)), frame: None, names: Vec::new(), cells: Vec::new() };
    for (field, values) in
        [("position", joints.position), ("velocity", joints.velocity), ("effort", joints.effort)]
    {
        for (name, value) in joints.name.iter().zip(values) {
            row.names.push(format!("{field}.{name}"));
            row.cells.push(value);
        }
    }
    row
}

fn exact(stamp: Option<Stamp>) -> Option<stamp::Stamp> {
    let ns = |stamp: Stamp| i128::from(stamp.sec) * 1_000_000_000 + i128::from(stamp.nanosec);
    stamp.map(|stamp| stamp::Stamp::of_nanoseconds(ns(stamp)))
}

/// Plain CDR after its head of four bytes, whose second says which end comes first.
fn decode<T: DeserializeOwned>(data: &[u8]) -> Result<T, String> {
    let (head, body) = data.split_at_checked(4).ok_or("a message of less than four bytes")?;
    let decoded = match head {
        [0, 0, ..] => from_bytes::<T, BigEndian>(body),
        [0, 1, ..] => from_bytes::<T, LittleEndian>(body),
        _ => return Err(format!("messages in the encoding {head:?} cannot be read, only plain CDR")),
    };
    decoded.map(|(message, _)| message).map_err(|error| format!("a message is not of its type: {error}"))
}
