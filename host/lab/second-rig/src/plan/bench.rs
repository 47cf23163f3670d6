//! Benches like the paper's: linear pushes, pivots, rolls, lifts and planar pushes over a grid of
//! conditions with repetitions. Speeds, ramps, pauses and distances differ from the first rig's,
//! and in a part of the plans it is the pusher that moves.

use nalgebra::{UnitQuaternion, Vector3};
use rand::Rng;
use serde::Serialize;

use super::blank;
use crate::physics::motion::{Motion, Part, Schedule, Stroke};
use crate::random::{chance, log_uniform, pick, uniform};
use crate::reality::ObjectSpec;
use crate::trial::{PusherKind, TrialSpec, upwards};

/// A primitive of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Primitive {
    /// Grip, speed, slope.
    LinearPush,
    /// Grip, turning speed, place of the edge.
    Pivot,
    /// Grip, speed.
    Roll,
    /// Grip, speed.
    Lift,
    /// Side, offset, direction.
    PlanarPush,
}

/// Length of the pivot's edge, m.
pub const EDGE_M: f64 = 0.028;
/// Radius of the rod that pushes over a table, m.
pub const ROD_M: f64 = 0.005;

/// Levels and movements, drawn once for a data set.
#[derive(Clone, Debug, Serialize)]
pub struct BenchPlan {
    /// What is done.
    pub primitives: Vec<Primitive>,
    /// N; at least what holds every object safely.
    pub grips_n: Vec<f64>,
    /// m/s.
    pub speeds_m_s: Vec<f64>,
    /// rad.
    pub slopes_rad: Vec<f64>,
    /// rad/s.
    pub turns_rad_s: Vec<f64>,
    /// Places of the edge from the object's centre, m.
    pub edges_m: Vec<f64>,
    /// Distance of the grasp from the object's centre in pivots, m.
    pub lever_m: f64,
    /// Offsets of the rod from the middle of the side, m.
    pub offsets_m: Vec<f64>,
    /// Directions of the rod against the normal of the side, rad.
    pub directions_rad: Vec<f64>,
    /// Repetitions.
    pub runs: usize,
    /// Sliding distance, m.
    pub distance_m: f64,
    /// Turning angle, rad.
    pub angle_rad: f64,
    /// Ramp of speeds, s.
    pub ramp_s: f64,
    /// Smooth ramps.
    pub smooth: bool,
    /// Rest before motion, s.
    pub before_s: f64,
    /// Rest after motion, s.
    pub after_s: f64,
    /// Gap before contact, m.
    pub gap_m: f64,
    /// The plate moves, the gripper stands.
    pub plate_moves: bool,
    /// Most trials.
    pub most: usize,
}

impl BenchPlan {
    /// Levels for the objects, held with friction `mu` by pads of radius `radius_m`.
    pub fn draw(
        rng: &mut impl Rng,
        primitives: &[Primitive],
        objects: &[ObjectSpec],
        mu: f64,
        most: usize,
    ) -> Self {
        let heaviest = objects.iter().map(|o| o.mass_kg).fold(0.0, f64::max);
        let shortest = objects.iter().map(|o| o.length_m).fold(1.0, f64::min);
        let safe = heaviest * 9.81 / (2.0 * mu) * 1.8;
        let round = primitives.contains(&Primitive::Roll);
        let low = if round { uniform(rng, 3.0, 4.0).max(safe) } else { uniform(rng, 8.0, 20.0).max(safe) };
        let span = if round { uniform(rng, 1.6, 2.6) } else { uniform(rng, 1.5, 2.6) };
        let grips = if chance(rng, 0.5) { 3 } else { 2 };
        let tenth = |x: f64| (x * 10.0).round() / 10.0;
        let grips_n =
            (0..grips).map(|i| tenth(low * f64::powf(span, i as f64 / (grips - 1) as f64))).collect();
        let slow = log_uniform(rng, 0.006, 0.015);
        let speeds_m_s = vec![slow, slow * uniform(rng, 1.8, 3.0)];
        let slope = uniform(rng, 0.12, 0.4);
        let slopes_rad = pick(rng, &[vec![-slope, 0.0, slope], vec![0.0, slope], vec![-slope, slope]]);
        let turn = log_uniform(rng, 0.06, 0.18);
        let turns_rad_s = vec![turn, turn * uniform(rng, 1.8, 3.0)];
        let lever_m = uniform(rng, 0.2, 0.3) * shortest;
        let edge = uniform(rng, 0.08, 0.22) * shortest;
        let wide = uniform(rng, 0.1, 0.3) * shortest;
        let swing = uniform(rng, 0.1, 0.35);
        Self {
            primitives: primitives.to_vec(),
            grips_n,
            speeds_m_s,
            slopes_rad,
            turns_rad_s,
            edges_m: vec![0.0, edge],
            lever_m,
            offsets_m: vec![-wide, 0.0, wide],
            directions_rad: vec![-swing, 0.0, swing],
            runs: pick(rng, &[2, 2, 3]),
            distance_m: uniform(rng, 0.007, 0.013),
            angle_rad: uniform(rng, 0.1, 0.25),
            ramp_s: log_uniform(rng, 0.01, 0.15),
            smooth: chance(rng, 0.5),
            before_s: uniform(rng, 0.15, 0.4),
            after_s: uniform(rng, 0.1, 0.4),
            gap_m: uniform(rng, 2e-4, 6e-4),
            plate_moves: chance(rng, 0.25),
            most,
        }
    }

    /// All trials, in order: the whole grid, then again.
    pub fn trials(&self, objects: &[ObjectSpec], rng: &mut impl Rng) -> Vec<TrialSpec> {
        let mut conditions = Vec::new();
        for primitive in &self.primitives {
            for object in 0..objects.len() {
                self.conditions(*primitive, object, objects, &mut conditions);
            }
        }
        // Too many: leave out some, the same in every repetition.
        let most = (self.most / self.runs).max(1);
        while conditions.len() > most {
            let i = rng.random_range(0..conditions.len());
            conditions.remove(i);
        }
        let mut out = Vec::new();
        for run in 0..self.runs {
            for condition in &conditions {
                out.push(TrialSpec { run, ..condition.clone() });
            }
        }
        let last = (out.len().max(2) - 1) as f64;
        for (i, trial) in out.iter_mut().enumerate() {
            trial.id = format!("t{i:04}");
            trial.progress = i as f64 / last;
        }
        out
    }

    fn conditions(&self, p: Primitive, k: usize, objects: &[ObjectSpec], out: &mut Vec<TrialSpec>) {
        let object = &objects[k];
        if object.round != (p == Primitive::Roll) {
            return;
        }
        match p {
            Primitive::LinearPush => {
                for &grip in &self.grips_n {
                    for &speed in &self.speeds_m_s {
                        for &slope in &self.slopes_rad {
                            out.push(self.linear_push(object, k, grip, speed, slope));
                        }
                    }
                }
            }
            Primitive::Pivot => {
                for &grip in &self.grips_n {
                    for &turn in &self.turns_rad_s {
                        for &edge in &self.edges_m {
                            out.push(self.pivot(object, k, grip, turn, edge));
                        }
                    }
                }
            }
            Primitive::Roll | Primitive::Lift => {
                for &grip in &self.grips_n {
                    for &speed in &self.speeds_m_s {
                        let roll = p == Primitive::Roll;
                        out.push(if roll {
                            self.roll(object, k, grip, speed)
                        } else {
                            self.lift(object, k, grip, speed)
                        });
                    }
                }
            }
            Primitive::PlanarPush => {
                for side in 0..3 {
                    for &offset in &self.offsets_m {
                        for &direction in &self.directions_rad {
                            out.push(self.planar_push(object, k, side, offset, direction));
                        }
                    }
                }
            }
        }
    }

    fn stroke(&self, start_s: f64, distance: f64, speed: f64) -> Stroke {
        Stroke { start_s, distance, speed, ramp_s: self.ramp_s, smooth: self.smooth }
    }

    fn gripped(&self, primitive: &str, k: usize, start: Vector3<f64>, grip: f64) -> TrialSpec {
        let trial = blank(primitive, k, start);
        TrialSpec { grip_n: grip, grip: Schedule::constant(grip), ..trial }
    }

    fn linear_push(&self, object: &ObjectSpec, k: usize, grip: f64, speed: f64, slope: f64) -> TrialSpec {
        let mut t = self.gripped("linear_push", k, Vector3::zeros(), grip);
        let along = Vector3::new(-slope.cos(), 0.0, slope.sin());
        let stroke = self.stroke(self.before_s, self.distance_m + self.gap_m, speed);
        let place = Vector3::new(-0.5 * object.length_m - self.gap_m, 0.0, 0.0);
        let mut plate = Motion::fixed(place, UnitQuaternion::identity());
        if self.plate_moves {
            plate.parts.push(Part::Along(-along, stroke));
        } else {
            t.gripper.parts.push(Part::Along(along, stroke));
        }
        t.pusher = Some((PusherKind::Plate, plate));
        t.speed_m_s = Some(speed);
        t.slope_rad = Some(slope);
        t.duration_s = stroke.start_s + stroke.duration_s() + self.after_s;
        t
    }

    fn pivot(&self, object: &ObjectSpec, k: usize, grip: f64, turn: f64, edge: f64) -> TrialSpec {
        let mut t = self.gripped("pivot", k, Vector3::zeros(), grip);
        t.gripper = Motion::fixed(-Vector3::x() * self.lever_m, UnitQuaternion::identity());
        let press = Stroke {
            start_s: self.before_s,
            distance: self.gap_m + 3e-4,
            speed: 2e-3,
            ramp_s: 0.05,
            smooth: true,
        };
        let start = press.start_s + press.duration_s() + 0.15;
        let swing = self.stroke(start, self.angle_rad, turn);
        t.gripper.parts = vec![Part::Along(-Vector3::z(), press), Part::Turn(Vector3::y(), swing)];
        let place = Vector3::new(edge, 0.0, -0.5 * object.side_m - self.gap_m);
        t.pusher = Some((PusherKind::Edge(EDGE_M), Motion::fixed(place, upwards())));
        t.speed_rad_s = Some(turn);
        t.offset_m = Some(edge);
        t.duration_s = start + swing.duration_s() + self.after_s;
        t
    }

    fn roll(&self, object: &ObjectSpec, k: usize, grip: f64, speed: f64) -> TrialSpec {
        let mut t = self.gripped("roll", k, Vector3::zeros(), grip);
        let stroke = self.stroke(self.before_s, self.distance_m, speed);
        t.gripper.parts.push(Part::Along(Vector3::y(), stroke));
        let place = Vector3::new(0.0, 0.0, -0.5 * object.side_m);
        t.pusher = Some((PusherKind::Platform, Motion::fixed(place, upwards())));
        t.speed_m_s = Some(speed);
        t.duration_s = stroke.start_s + stroke.duration_s() + self.after_s;
        t
    }

    fn lift(&self, object: &ObjectSpec, k: usize, grip: f64, speed: f64) -> TrialSpec {
        let start = Vector3::new(0.0, 0.0, 0.5 * object.side_m);
        let mut t = self.gripped("lift", k, start, grip);
        // A bench lifts faster than it pushes.
        let up = self.stroke(self.before_s, 2.0 * self.distance_m, 2.0 * speed);
        let aside_s = up.start_s + up.duration_s() + 0.2;
        let aside = self.stroke(aside_s, self.distance_m, 2.0 * speed);
        t.gripper.parts = vec![Part::Along(Vector3::z(), up), Part::Along(Vector3::x(), aside)];
        t.table = true;
        t.speed_m_s = Some(2.0 * speed);
        t.duration_s = aside_s + aside.duration_s() + self.after_s;
        t
    }

    fn planar_push(&self, o: &ObjectSpec, k: usize, side: usize, offset: f64, direction: f64) -> TrialSpec {
        let mut t = blank("planar_push", k, Vector3::new(0.0, 0.0, 0.5 * o.side_m));
        t.grasped = false;
        t.table = true;
        let half = [0.5 * o.length_m, 0.5 * o.side_m];
        let place = offset / half[0];
        // Pushed side, its outward normal, and the way along it.
        let (out, along) = match side {
            0 => (-Vector3::y(), Vector3::x()),
            1 => (Vector3::y(), -Vector3::x()),
            _ => (-Vector3::x(), Vector3::y()),
        };
        let (reach, wide) = if side < 2 { (half[1], half[0]) } else { (half[0], half[1]) };
        let from = out * (reach + ROD_M + self.gap_m) + along * (place * wide);
        let turn = UnitQuaternion::new(Vector3::z() * direction);
        let way = turn * -out;
        let yaw = way.y.atan2(way.x);
        // Low, so that blocks on narrow feet do not tip.
        let start = Vector3::new(from.x, from.y, 0.4 * t.start.z);
        let mut rod = Motion::fixed(start, UnitQuaternion::new(Vector3::z() * yaw));
        let speed = self.speeds_m_s[1];
        let stroke = self.stroke(self.before_s, 3.0 * self.distance_m, speed);
        rod.parts.push(Part::Along(way, stroke));
        t.pusher = Some((PusherKind::Rod(ROD_M), rod));
        t.speed_m_s = Some(speed);
        t.slope_rad = Some(direction);
        t.offset_m = Some(place * wide);
        t.duration_s = stroke.start_s + stroke.duration_s() + self.after_s;
        t
    }
}
