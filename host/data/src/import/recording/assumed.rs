//! What a mapping assumes of signals and sensors, to be shown.

use nalgebra::{UnitQuaternion, Vector3};
use serde::Serialize;

use super::frames::Axes;
use super::mapping::{ActsOn, Mapping, Stream};

/// How a stream of one trial came to the base of time.
#[derive(Clone, Copy)]
pub(super) struct Facts {
    /// Median rate of its rows.
    pub rate_hz: f64,
    /// Share of the trial's rows that it fills.
    pub filled: f64,
    /// Lines were fitted through several of its rows.
    pub averaged: bool,
}

/// One signal, as it was understood.
#[derive(Clone, Debug, PartialEq, schemars::JsonSchema, Serialize)]
pub struct Signal {
    /// Stream of the mapping.
    pub stream: String,
    /// finger1, finger2, pusher, object, gripper, pusher_pose, grip.
    pub signal: String,
    /// Its columns.
    pub columns: Vec<String>,
    /// Units as recorded.
    pub units: String,
    /// Axes, lever, sign.
    pub frame: String,
    /// Median over trials, Hz.
    pub rate_hz: f64,
    /// How it came to the base of time.
    pub base: String,
    /// Share of the data set's rows that have it.
    pub filled: f64,
}

impl Signal {
    /// The columns that it has, in one line.
    #[must_use]
    pub fn named_columns(&self) -> String {
        self.columns.iter().filter(|name| !name.is_empty()).cloned().collect::<Vec<_>>().join(" ")
    }
}

/// Where a force sensor sits, and how it is turned.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorFrame {
    /// finger1, finger2, pusher.
    pub signal: &'static str,
    /// Its origin from the reference point, our axes, m.
    pub origin_m: Vector3<f64>,
    /// From its axes to ours.
    pub rotation: UnitQuaternion<f64>,
}

/// The force sensors of `mapping` whose origin or axes are not ours.
pub(super) fn sensors(mapping: &Mapping) -> Vec<SensorFrame> {
    let wrenches = mapping.streams.iter().flat_map(Stream::wrenches);
    let frames = wrenches.filter_map(|(signal, columns)| {
        let frame = columns.frame().ok()?;
        Some(SensorFrame { signal, origin_m: frame.origin_m, rotation: frame.rotation })
    });
    frames.filter(|sensor| sensor.origin_m.norm() > 0.0 || sensor.rotation.angle() > 1e-9).collect()
}

/// What was assumed of each signal of `mapping`; `facts` by trial and stream.
pub(super) fn signals(mapping: &Mapping, facts: &[Vec<Facts>]) -> Vec<Signal> {
    let mut list = Vec::new();
    for (index, stream) in mapping.streams.iter().enumerate() {
        let of: Vec<Facts> = facts.iter().filter_map(|trial| trial.get(index).copied()).collect();
        let rate_hz =
            crate::import::quantile(&crate::import::sorted(of.iter().map(|facts| facts.rate_hz)), 0.5);
        let filled = of.iter().map(|facts| facts.filled).sum::<f64>() / of.len().max(1) as f64;
        let base = if of.iter().any(|facts| facts.averaged) {
            format!("line through {:.1} ms", 1e3 / mapping.rate_hz)
        } else {
            "at the nearest tick".to_owned()
        };
        let mut add = |signal: &str, columns: Vec<&str>, units: String, frame: String| {
            list.push(Signal {
                stream: stream.name.clone(),
                signal: signal.to_owned(),
                columns: columns.into_iter().map(str::to_owned).collect(),
                units,
                frame,
                rate_hz,
                base: base.clone(),
                filled,
            });
        };
        for (name, wrench) in stream.wrenches() {
            let axes = wrench.axes.as_ref().map_or_else(|| "our axes".to_owned(), Axes::words);
            let acts = match wrench.acts_on {
                ActsOn::Object => "acts on the object",
                _ => "reaction: all signs turned",
            };
            let lever = match wrench.origin_m {
                [0.0, 0.0, 0.0] => String::new(),
                origin => format!(", origin at {origin:?} m"),
            };
            add(
                name,
                wrench.columns(),
                format!("{}, {}", wrench.force_unit, wrench.torque_unit),
                format!("{axes}; {acts}{lever}"),
            );
        }
        for (name, pose) in stream.poses() {
            let world = pose.world_axes.as_ref().map_or_else(|| "our axes".to_owned(), Axes::words);
            let body =
                pose.body_axes.as_ref().map_or_else(String::new, |axes| format!("; body: {}", axes.words()));
            let units = match pose.roll_pitch_yaw {
                Some(_) => format!("{}, {}", pose.unit, pose.angle_unit),
                None => pose.unit.clone(),
            };
            add(name, pose.columns(), units, format!("world: {world}{body}"));
        }
        if let Some(grip) = &stream.grip {
            add("grip", vec![&grip.column], grip.unit.clone(), String::new());
        }
    }
    list
}
