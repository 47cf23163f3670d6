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
    let stream = BufReader::new(File::open(file).map_err(|error| io(error.to_string()))?);
    let mut table = Table::default();
    let mut topics: Vec<String> = Vec::new();
    let mut frames: Vec<String> = Vec::new();
    for message in mcap::io::MessageReader::new(stream) {
        let message = match message {
            Ok(message) => message,
            // Whole chunks before a cut are good.
            Err(error) => {
                table.cut = Some(format!("the file cannot be read further: {error}"));
                break;
            }
        };
        let channel = &message.channel;
        if !topics.contains(&channel.topic) {
            topics.push(channel.topic.clone());
        }
        if channel.topic != topic {
            continue;
        }
        let kind = channel.schema.as_ref().map_or("", |schema| schema.name.as_str());
        if channel.message_encoding != "cdr" {
            return Err(io(format!(
                "topic {topic} is encoded as {:?}; only ROS 2 messages in \"cdr\" can be read",
                channel.message_encoding
            )));
        }
        table.messages += 1;
        let times = [message.log_time, message.publish_time].map(|nanoseconds| nanoseconds as f64 * 1e-9);
        for row in rows(kind, &message.data).map_err(|error| io(format!("topic {topic}: {error}")))? {
            if let Some(frame) = row.frame {
                if child_frame.is_some_and(|wanted| wanted != frame) {
                    frames.push(frame);
                    continue;
                }
                frames.push(frame);
            }
            let names = ["header.stamp", "log_time", "publish_time"].map(str::to_owned).into_iter();
            let names: Vec<String> = names.chain(row.names).collect();
            if table.names.is_empty() {
                table.names = names;
            } else if table.names != names {
                return Err(io(format!("topic {topic}: the fields of its messages change within the file")));
            }
            let mut cells = vec![row.stamp_s, times[0], times[1]];
            cells.extend(row.cells);
            table.rows.push(cells);
        }
    }
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

/// Topics of `file` whose messages can be read; transforms once for each child frame.
///
/// # Errors
/// A file that is no MCAP file.
pub fn topics(file: &Path) -> Result<Vec<(String, Option<String>)>, RecordingError> {
    let io = |error: String| RecordingError::Io { file: file.to_owned(), error };
    let stream = BufReader::new(File::open(file).map_err(|error| io(error.to_string()))?);
    let mut found: Vec<(String, Option<String>)> = Vec::new();
    for message in mcap::io::MessageReader::new(stream) {
        let message = match message {
            Ok(message) => message,
            Err(error) if found.is_empty() => return Err(io(error.to_string())),
            Err(_) => break,
        };
        let kind = message.channel.schema.as_ref().map_or("", |schema| schema.name.as_str());
        for row in rows(kind, &message.data).unwrap_or_default() {
            let entry = (message.channel.topic.clone(), row.frame);
            if !found.contains(&entry) {
                found.push(entry);
            }
        }
    }
    Ok(found)
}

/// One row of a message.
struct Row {
    stamp_s: f64,
    frame: Option<String>,
    names: Vec<String>,
    cells: Vec<f64>,
}

fn rows(kind: &str, data: &[u8]) -> Result<Vec<Row>, String> {
    // ROS 2 writes `package/msg/Type`.
    let kind = kind.replace("/msg/", "/");
    let one = |stamp: Option<Stamp>, fields: &[(&str, &str)], cells: Vec<f64>| {
        let names = fields
            .iter()
            .flat_map(|(field, axes)| axes.chars().map(move |axis| format!("{field}.{axis}")))
            .collect();
        Row { stamp_s: seconds(stamp), frame: None, names, cells }
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
            vec![Row {
                stamp_s: f64::NAN,
                frame: None,
                names: vec!["data".to_owned()],
                cells: vec![decode(data)?],
            }]
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
        stamp_s: seconds(Some(transform.header.stamp)),
        frame: Some(transform.child_frame_id),
        names: names.map(str::to_owned).to_vec(),
        cells: transform.translation.into_iter().chain(transform.rotation).collect(),
    }
}

fn joints(joints: Joints) -> Row {
    let mut row = Row {
        stamp_s: seconds(Some(joints.header.stamp)),
        frame: None,
        names: Vec::new(),
        cells: Vec::new(),
    };
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

fn seconds(stamp: Option<Stamp>) -> f64 {
    stamp.map_or(f64::NAN, |stamp| f64::from(stamp.sec) + f64::from(stamp.nanosec) * 1e-9)
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
