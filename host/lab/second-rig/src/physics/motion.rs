//! Given motions: sums of strokes with ramps, of sines and of turns; and schedules of numbers.

use nalgebra::{UnitQuaternion, Vector3};
use serde::Serialize;
use std::f64::consts::{PI, TAU};

use super::body::Frame;

/// Speed against time of one stroke.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Stroke {
    /// Start, s.
    pub start_s: f64,
    /// Distance (m or rad), may be negative.
    pub distance: f64,
    /// Plateau speed (m/s or rad/s), positive.
    pub speed: f64,
    /// Time of each ramp, s.
    pub ramp_s: f64,
    /// Ramps as half a cosine in place of constant acceleration.
    pub smooth: bool,
}

impl Stroke {
    /// Time from start to end, s. Short strokes do not reach the plateau's speed.
    pub fn duration_s(&self) -> f64 {
        let flat = self.distance.abs() / self.speed - self.ramp_s;
        self.ramp_s + flat.max(self.ramp_s)
    }

    /// Travel and speed at `t`.
    pub fn at(&self, t: f64) -> (f64, f64) {
        let t = t - self.start_s;
        let total = self.duration_s();
        if t <= 0.0 || self.distance == 0.0 {
            return (0.0, 0.0);
        }
        if t >= total {
            return (self.distance, 0.0);
        }
        let r = self.ramp_s.max(1e-6);
        let peak = self.distance / (total - self.ramp_s);
        let ramp = |u: f64| {
            if self.smooth {
                (peak * 0.5 * (u - r / PI * (PI * u / r).sin()), peak * 0.5 * (1.0 - (PI * u / r).cos()))
            } else {
                (peak * u * u / (2.0 * r), peak * u / r)
            }
        };
        if t < r {
            ramp(t)
        } else if t > total - r {
            let (s, v) = ramp(total - t);
            (self.distance - s, v)
        } else {
            (peak * (t - 0.5 * r), peak)
        }
    }
}

/// An oscillation that fades in and out.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Sine {
    /// m.
    pub amplitude: f64,
    /// Hz.
    pub hz: f64,
    /// rad.
    pub phase: f64,
    /// s.
    pub from_s: f64,
    /// s.
    pub to_s: f64,
    /// Time of fading, s.
    pub fade_s: f64,
}

impl Sine {
    fn at(&self, t: f64) -> (f64, f64) {
        if t <= self.from_s || t >= self.to_s {
            return (0.0, 0.0);
        }
        let u = ((t - self.from_s).min(self.to_s - t) / self.fade_s).clamp(0.0, 1.0);
        let sign = if t - self.from_s < self.to_s - t { 1.0 } else { -1.0 };
        let (w, dw) = (u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u) * sign / self.fade_s);
        let angle = TAU * self.hz * t + self.phase;
        let (s, c) = angle.sin_cos();
        (self.amplitude * w * s, self.amplitude * (dw * s + w * TAU * self.hz * c))
    }
}

/// One part of a motion.
#[derive(Clone, Copy, Debug, Serialize)]
pub enum Part {
    /// Along a unit vector.
    Along(Vector3<f64>, Stroke),
    /// Oscillation along a unit vector.
    Shake(Vector3<f64>, Sine),
    /// About an axis through the tool's origin (one axis for a motion).
    Turn(Vector3<f64>, Stroke),
}

/// Motion of a tool.
#[derive(Clone, Debug, Serialize)]
pub struct Motion {
    /// Origin at the start, m.
    pub start: Vector3<f64>,
    /// Axes at the start.
    pub rotation: UnitQuaternion<f64>,
    /// All parts add up.
    pub parts: Vec<Part>,
    /// Error of the drive along its strokes: amplitude (m) and pitch (m).
    pub ripple: Option<[f64; 2]>,
}

impl Motion {
    /// Does not move.
    pub fn fixed(start: Vector3<f64>, rotation: UnitQuaternion<f64>) -> Self {
        Self { start, rotation, parts: Vec::new(), ripple: None }
    }

    /// Frame at time `t`.
    pub fn at(&self, t: f64) -> Frame {
        let mut out = Frame::fixed(self.start, self.rotation);
        for part in &self.parts {
            match part {
                Part::Along(axis, stroke) => {
                    let (mut s, mut v) = stroke.at(t);
                    if let Some([amplitude, pitch]) = self.ripple {
                        let (sin, cos) = (TAU * s / pitch).sin_cos();
                        s += amplitude * sin;
                        v *= 1.0 + amplitude * TAU / pitch * cos;
                    }
                    out.position += axis * s;
                    out.velocity += axis * v;
                }
                Part::Shake(axis, sine) => {
                    let (s, v) = sine.at(t);
                    out.position += axis * s;
                    out.velocity += axis * v;
                }
                Part::Turn(axis, stroke) => {
                    let (s, v) = stroke.at(t);
                    if s != 0.0 {
                        out.rotation = UnitQuaternion::new(axis * s) * out.rotation;
                    }
                    out.spin += axis * v;
                }
            }
        }
        out
    }

    /// When the last part ends, s.
    pub fn end_s(&self) -> f64 {
        let end = |part: &Part| match part {
            Part::Along(_, s) | Part::Turn(_, s) => s.start_s + s.duration_s(),
            Part::Shake(_, s) => s.to_s,
        };
        self.parts.iter().map(end).fold(0.0, f64::max)
    }
}

/// A number against time: straight lines between (time, value) pairs, constant outside.
#[derive(Clone, Debug, Serialize)]
pub struct Schedule(pub Vec<(f64, f64)>);

impl Schedule {
    /// The same at all times.
    pub fn constant(value: f64) -> Self {
        Self(vec![(0.0, value)])
    }

    /// Value at `t`; zero where the schedule is empty.
    pub fn at(&self, t: f64) -> f64 {
        let Some(first) = self.0.first() else { return 0.0 };
        if t <= first.0 {
            return first.1;
        }
        for pair in self.0.windows(2) {
            if t < pair[1].0 {
                let u = (t - pair[0].0) / (pair[1].0 - pair[0].0);
                return pair[0].1 + u * (pair[1].1 - pair[0].1);
            }
        }
        self.0.last().map_or(0.0, |last| last.1)
    }
}

/// A half sine of force on the object, world axes.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Knock {
    /// Start, s.
    pub start_s: f64,
    /// s.
    pub duration_s: f64,
    /// Peak, N.
    pub force: Vector3<f64>,
    /// Where it acts, object axes about the object's origin, m.
    pub at: Vector3<f64>,
}

impl Knock {
    /// Force at `t`, N.
    pub fn force_at(&self, t: f64) -> Vector3<f64> {
        let u = (t - self.start_s) / self.duration_s;
        if u <= 0.0 || u >= 1.0 { Vector3::zeros() } else { self.force * (PI * u).sin() }
    }
}
