//! Grasps for warnings: lift-offs, decaying grip, accelerations and shaking, knocks, friction that
//! falls, pouring, quiet holds with and without disturbance, and steps of the grip that are safe.
//! A part of the ramps stops short of slip.

use nalgebra::Vector3;
use rand::Rng;
use serde_json::{Map, Value, json};
use std::f64::consts::{PI, TAU};

use super::blank;
use crate::physics::motion::{Knock, Part, Schedule, Sine, Stroke};
use crate::random::{chance, log_uniform, pick, sign, uniform};
use crate::reality::{ObjectSpec, Reality};
use crate::trial::{Pickup, TrialSpec};

const G: f64 = 9.81;

/// A scenario and the share of trials that it gets.
pub type Weight = (&'static str, f64);

/// All scenarios evenly.
pub const ALL: &[Weight] = &[
    ("a-enough", 2.0),
    ("a-just", 2.0),
    ("a-little", 2.0),
    ("b-slip", 4.0),
    ("b-short", 2.0),
    ("c-up", 2.0),
    ("c-down", 2.0),
    ("c-side", 2.0),
    ("c-shake", 3.0),
    ("d-held", 2.0),
    ("d-slip", 2.0),
    ("d-drop", 2.0),
    ("e-sudden", 3.0),
    ("e-ramp", 3.0),
    ("e-short", 1.5),
    ("f-slip", 3.0),
    ("f-short", 2.0),
    ("g-still", 1.0),
    ("g-pickup", 1.0),
    ("g-shaken", 1.0),
    ("g-broad", 1.0),
    ("h-steps", 2.5),
];

/// Mostly friction that falls and mass that grows.
pub const WET: &[Weight] = &[
    ("b-slip", 2.0),
    ("b-short", 1.0),
    ("e-sudden", 4.0),
    ("e-ramp", 5.0),
    ("e-short", 3.0),
    ("f-slip", 4.0),
    ("f-short", 3.0),
    ("g-still", 1.0),
];

/// Mostly motion and disturbed holds.
pub const SHAKEN: &[Weight] = &[
    ("a-enough", 2.0),
    ("c-up", 3.0),
    ("c-down", 3.0),
    ("c-side", 3.0),
    ("c-shake", 5.0),
    ("d-held", 3.0),
    ("d-slip", 2.0),
    ("g-pickup", 2.0),
    ("g-shaken", 2.0),
    ("g-broad", 2.0),
    ("h-steps", 3.0),
];

/// `count` trials in proportion to the weights.
pub fn trials(r: &Reality, weights: &[Weight], count: usize, rng: &mut impl Rng) -> Vec<TrialSpec> {
    let total: f64 = weights.iter().map(|w| w.1).sum();
    let mut out = Vec::new();
    let mut due = 0.0;
    for (scenario, weight) in weights {
        due += weight / total * count as f64;
        while (out.len() as f64) < due.round() {
            let object = rng.random_range(0..r.objects.len());
            out.push(trial(r, scenario, object, rng));
        }
    }
    let last = (out.len().max(2) - 1) as f64;
    for (i, t) in out.iter_mut().enumerate() {
        t.id = format!("t{i:04}");
        t.run = i;
        t.progress = i as f64 / last;
    }
    out
}

/// One trial of a scenario `letter-sub`.
fn trial(r: &Reality, name: &str, object: usize, rng: &mut impl Rng) -> TrialSpec {
    let (letter, sub) = name.split_once('-').unwrap_or((name, ""));
    let o = &r.objects[object];
    let mut h = Hold::new(r, o, object, rng);
    match letter {
        "a" => h.lift_off(sub, rng),
        "b" => h.grip_decays(sub, rng),
        "c" if sub == "shake" => h.shakes(rng),
        "c" => h.accelerates(sub, rng),
        "d" => h.is_knocked(sub, rng),
        "e" => h.gets_wet(sub, rng),
        "f" => h.is_filled(sub, rng),
        "g" => h.is_quiet(sub, rng),
        _ => h.changes_grip(rng),
    }
    let cause = match (letter, sub) {
        ("b" | "f", _) => "builds_up",
        ("e", "ramp" | "short") => "friction_falls",
        ("g" | "h", _) => "quiet",
        _ => "sudden",
    };
    let mut t = h.finish(o);
    t.note.insert("scenario".into(), json!(letter));
    t.note.insert("sub".into(), json!(sub));
    t.note.insert("cls".into(), json!(cause));
    t
}

struct Hold {
    trial: TrialSpec,
    /// Both fingers can just hold the weight at rest with this force each, N.
    needed_n: f64,
    weight_n: f64,
    /// Share of the friction limit that the weight takes.
    util: f64,
    note: Map<String, Value>,
}

impl Hold {
    fn new(r: &Reality, o: &ObjectSpec, object: usize, rng: &mut impl Rng) -> Self {
        let weight_n = o.mass_kg * r.mass_factor * G;
        let needed_n = weight_n / (2.0 * r.break_away_mu());
        let start = Vector3::new(0.0, 0.0, 0.3);
        let trial = blank(pick(rng, &["hold", "carry"]), object, start);
        Self { trial, needed_n, weight_n, util: uniform(rng, 0.35, 0.8), note: Map::new() }
    }

    fn say(&mut self, key: &str, value: impl Into<Value>) {
        self.note.insert(key.into(), value.into());
    }

    fn end(&mut self, seconds: f64) {
        self.trial.duration_s = seconds;
    }

    fn grip(&self) -> f64 {
        self.needed_n / self.util
    }

    fn lift_off(&mut self, sub: &str, rng: &mut impl Rng) {
        self.util = match sub {
            "enough" => uniform(rng, 0.4, 0.75),
            "just" => uniform(rng, 0.88, 1.0),
            _ => uniform(rng, 1.1, 1.7),
        };
        let speed = log_uniform(rng, 0.012, 0.12);
        let ramp_s = uniform(rng, 0.03, 0.15);
        let distance = uniform(rng, 0.025, 0.06);
        let start_s = uniform(rng, 0.5, 1.1);
        let up = Stroke { start_s, distance, speed, ramp_s, smooth: chance(rng, 0.5) };
        self.trial.primitive = "lift".into();
        self.trial.table = true;
        self.trial.gripper.parts.push(Part::Along(Vector3::z(), up));
        self.trial.speed_m_s = Some(speed);
        self.end(start_s + up.duration_s() + 1.2);
    }

    fn grip_decays(&mut self, sub: &str, rng: &mut impl Rng) {
        let end_util = if sub == "slip" { uniform(rng, 1.06, 1.4) } else { uniform(rng, 0.82, 0.92) };
        self.util = uniform(rng, 0.4, 0.75);
        let (g0, g1) = (self.grip(), self.needed_n / end_util);
        let start = uniform(rng, 0.8, 1.4);
        let time = log_uniform(rng, 0.4, 6.0);
        let linear = chance(rng, 0.5);
        let shape = |u: f64| if linear { u } else { (1.0 - (-2.5 * u).exp()) / (1.0 - (-2.5_f64).exp()) };
        let mut points = vec![(0.0, g0)];
        for i in 0..=20 {
            let u = f64::from(i) / 20.0;
            points.push((start + time * u, g0 + (g1 - g0) * shape(u)));
        }
        self.trial.grip = Schedule(points);
        let commanded = chance(rng, 0.5);
        if !commanded {
            self.trial.grip_told = Some(Schedule::constant(g0));
        }
        self.say("linear", linear);
        self.say("commanded", commanded);
        self.say("end_util", end_util);
        self.end(start + time + uniform(rng, 0.5, 1.5));
    }

    fn accelerates(&mut self, sub: &str, rng: &mut impl Rng) {
        let peak = if chance(rng, 0.4) { uniform(rng, 0.65, 0.9) } else { uniform(rng, 1.2, 1.7) };
        let way = match sub {
            "up" => Vector3::z(),
            "down" => -Vector3::z(),
            _ => Vector3::x() * sign(rng),
        };
        // What the pads must carry at the peak, over the weight.
        let a_over_g = |util: f64| match sub {
            "side" => ((peak / util).powi(2) - 1.0).max(0.0).sqrt(),
            _ => (peak / util - 1.0).max(0.0),
        };
        self.util = self.util.min(peak * 0.9);
        let a = (G * a_over_g(self.util)).clamp(0.5, 16.0);
        let speed = uniform(rng, 0.15, 0.5);
        // The peak of a smooth ramp is pi/2 of its mean; strokes down brake at their end.
        let smooth = chance(rng, 0.5);
        let ramp_s = (speed / a) * if smooth { 0.5 * PI } else { 1.0 };
        let distance = speed * (ramp_s + uniform(rng, 0.05, 0.3));
        let start_s = uniform(rng, 0.8, 1.4);
        let stroke = Stroke { start_s, distance, speed, ramp_s, smooth };
        self.trial.gripper.parts.push(Part::Along(way, stroke));
        self.say("a", a);
        self.say("peak_util", peak);
        self.end(start_s + stroke.duration_s() + uniform(rng, 0.6, 2.0));
    }

    fn shakes(&mut self, rng: &mut impl Rng) {
        let peak = if chance(rng, 0.6) { uniform(rng, 0.5, 0.88) } else { uniform(rng, 1.2, 1.6) };
        self.util = self.util.min(peak * 0.9);
        let level = chance(rng, 0.5);
        let ratio = peak / self.util;
        let a = (G * if level { (ratio * ratio - 1.0).sqrt() } else { ratio - 1.0 }).clamp(0.2, 18.0);
        let hz = log_uniform(rng, 1.0, 8.0);
        let amplitude = (a / (TAU * hz).powi(2)).min(0.15);
        let from_s = uniform(rng, 0.6, 1.2);
        let to_s = from_s + uniform(rng, 2.0, 5.0);
        let sine = Sine { amplitude, hz, phase: uniform(rng, 0.0, TAU), from_s, to_s, fade_s: 0.5 };
        let way = if level { Vector3::x() } else { Vector3::z() };
        self.trial.gripper.parts.push(Part::Shake(way, sine));
        self.say("f", hz);
        self.say("level", level);
        self.say("a", amplitude * (TAU * hz).powi(2));
        self.say("peak_util", peak);
        self.end(to_s + 0.8);
    }

    fn is_knocked(&mut self, sub: &str, rng: &mut impl Rng) {
        let limit = self.weight_n / self.util;
        let (peak, duration_s) = match sub {
            "held" => (uniform(rng, 0.7, 0.92), uniform(rng, 0.01, 0.06)),
            "slip" => (uniform(rng, 1.5, 3.5), uniform(rng, 0.01, 0.05)),
            _ => (uniform(rng, 1.8, 3.0), uniform(rng, 0.12, 0.2)),
        };
        let angle = uniform(rng, -PI, PI);
        let way = Vector3::new(angle.cos(), 0.0, angle.sin());
        // |weight + force| is the peak's share of the limit.
        let down = -self.weight_n * way.z;
        let target = (peak.max(self.util * 1.05) * limit).powi(2);
        let force = -down + (down * down - self.weight_n.powi(2) + target).max(0.0).sqrt();
        let at = Vector3::new(uniform(rng, -0.01, 0.01), 0.0, uniform(rng, -0.01, 0.01));
        let start_s = uniform(rng, 0.9, 2.2);
        self.trial.knocks.push(Knock { start_s, duration_s, force: way * force, at });
        self.say("t", start_s);
        self.say("duration", duration_s);
        self.say("force", force);
        self.say("peak_util", peak);
        self.end(start_s + uniform(rng, 1.2, 2.0));
    }

    fn gets_wet(&mut self, sub: &str, rng: &mut impl Rng) {
        self.util = uniform(rng, 0.35, 0.65);
        let end_util = if sub == "short" { uniform(rng, 0.78, 0.92) } else { uniform(rng, 1.08, 1.6) };
        let one = chance(rng, 0.4) && 2.0 * self.util / end_util > 1.05;
        let share = self.util / end_util;
        let time = if sub == "sudden" { uniform(rng, 0.01, 0.03) } else { log_uniform(rng, 0.6, 5.0) };
        let start = uniform(rng, 0.9, 1.8);
        // One finger alone has to lose twice as much.
        let falls = |to: f64| Schedule(vec![(0.0, 1.0), (start, 1.0), (start + time, to)]);
        self.trial.wetness = if one {
            let k = rng.random_range(0..2);
            std::array::from_fn(|i| if i == k { falls(2.0 * share - 1.0) } else { Schedule::constant(1.0) })
        } else {
            [falls(share), falls(share)]
        };
        self.say("t", start);
        self.say("ramp_s", time);
        self.say("end_util", end_util);
        self.say("one_finger", one);
        self.end(start + time + uniform(rng, 1.0, 2.0));
    }

    fn is_filled(&mut self, sub: &str, rng: &mut impl Rng) {
        self.util = uniform(rng, 0.4, 0.7);
        let end_util = if sub == "slip" { uniform(rng, 1.06, 1.35) } else { uniform(rng, 0.78, 0.92) };
        let start = uniform(rng, 0.9, 1.8);
        let time = log_uniform(rng, 1.0, 6.0);
        let added = self.weight_n / G * (end_util / self.util - 1.0);
        self.trial.added_kg = Schedule(vec![(0.0, 0.0), (start, 0.0), (start + time, added)]);
        self.say("end_util", end_util);
        self.say("added_kg", added);
        self.say("ramp_s", time);
        self.end(start + time + uniform(rng, 0.5, 1.5));
    }

    fn is_quiet(&mut self, sub: &str, rng: &mut impl Rng) {
        let margin = self.weight_n * (1.0 / self.util - 1.0);
        let seconds = uniform(rng, 8.0, 16.0);
        match sub {
            "pickup" => {
                let sine_n = uniform(rng, 0.05, 0.5);
                let hz = pick(rng, &[50.0, 50.0, 60.0]) + uniform(rng, -0.3, 0.3);
                self.trial.pickup = Pickup { sine_n, hz, broad_n: 0.0 };
                self.say("sine_n", sine_n);
                self.say("hz", hz);
            }
            "broad" => {
                let broad_n = uniform(rng, 0.05, 0.5);
                self.trial.pickup = Pickup { broad_n, ..Pickup::default() };
                self.say("broad_n", broad_n);
            }
            "shaken" => {
                // Five sines that together take at most a third of the margin.
                let a = margin / self.weight_n * G * uniform(rng, 0.05, 0.3);
                for way in [Vector3::x(), Vector3::z()] {
                    for _ in 0..5 {
                        let hz = log_uniform(rng, 5.0, 45.0);
                        let amplitude = a / 10.0 / (TAU * hz).powi(2);
                        let phase = uniform(rng, 0.0, TAU);
                        let sine = Sine { amplitude, hz, phase, from_s: 0.1, to_s: seconds, fade_s: 0.3 };
                        self.trial.gripper.parts.push(Part::Shake(way, sine));
                    }
                }
                self.say("a", a);
            }
            _ => {}
        }
        self.end(seconds);
    }

    fn changes_grip(&mut self, rng: &mut impl Rng) {
        self.util = uniform(rng, 0.4, 0.8);
        let mut level = self.grip();
        let mut points = vec![(0.0, level)];
        let mut t = 0.0;
        let mut steps = Vec::new();
        while t < 6.0 {
            t += uniform(rng, 0.8, 1.8);
            let next = self.needed_n / uniform(rng, 0.35, 0.85);
            let time = log_uniform(rng, 0.008, 0.15);
            points.push((t, level));
            points.push((t + time, next));
            steps.push(json!([t, next]));
            t += time;
            level = next;
        }
        self.trial.grip = Schedule(points);
        self.say("steps", steps);
        self.end(t + 1.0);
    }

    fn finish(mut self, o: &ObjectSpec) -> TrialSpec {
        let grip = self.grip();
        if self.trial.grip.0.len() < 2 {
            self.trial.grip = Schedule::constant(grip);
        }
        self.trial.grip_n = (grip * 1e3).round() / 1e3;
        let util = self.util;
        if self.trial.table {
            self.trial.start.z = 0.5 * o.side_m;
            self.trial.gripper.start.z = 0.5 * o.side_m;
        }
        self.trial.note.insert("util0".into(), json!(util));
        self.trial.note.insert("note".into(), Value::Object(self.note));
        self.trial
    }
}
