//! Everything of one trial together, stepped through time.

use nalgebra::Vector3;

use super::body::{Body, Frame};
use super::jaw::{Jaw, JawSpec};
use super::motion::{Knock, Motion, Schedule};
use super::patch::{Load, Patch};
use super::record::{Record, Sample, Wrench};
use super::slip::Watch;
use super::surface::{Geometry, Relative, Surface};

/// Both fingers and their jaw.
#[derive(Clone, Debug)]
pub struct Grasp {
    /// Finger 1 at +Y, finger 2 at -Y.
    pub pads: [Patch; 2],
    /// Properties of the jaw.
    pub jaw: JawSpec,
    /// Commanded force of each finger, N.
    pub command: Schedule,
    /// Factor on friction of each finger.
    pub wetness: [Schedule; 2],
}

/// A tool that touches the object: a pusher or a table.
#[derive(Clone, Debug)]
pub struct Tool {
    /// Contact.
    pub patch: Patch,
    /// Its true motion.
    pub motion: Motion,
}

/// Forces that are nobody's contact.
#[derive(Clone, Debug, Default)]
pub struct Others {
    /// Half sines.
    pub knocks: Vec<Knock>,
    /// Spring from the object's origin to the gripper: stiffness along gripper axes, N/m.
    pub spring_n_m: Vector3<f64>,
    /// Where that spring is at rest: object's origin in the gripper's frame, m.
    pub spring_rest: Vector3<f64>,
    /// Cable on the object's end at +X.
    pub cable: Option<Cable>,
    /// Magnet at a world point: pull at 20 mm, N; falls with the square of the distance.
    pub magnet: Option<(Vector3<f64>, f64)>,
}

/// A cable from a point of the object to an anchor in the room. It pulls, it does not push.
#[derive(Clone, Copy, Debug)]
pub struct Cable {
    /// World axes, m.
    pub anchor: Vector3<f64>,
    /// On the object, object axes, m.
    pub at: Vector3<f64>,
    /// Pull at the length `length_m`, N.
    pub pull_n: f64,
    /// N/m.
    pub stiffness: f64,
    /// m.
    pub length_m: f64,
}

/// One trial, ready to run.
#[derive(Clone, Debug)]
pub struct World {
    /// True gravity, m/s2.
    pub gravity: Vector3<f64>,
    /// The object at its start.
    pub body: Body,
    /// Added mass against time, kg; it sits at the centre of mass.
    pub added_kg: Schedule,
    /// Its surface.
    pub surface: Surface,
    /// Motion of the gripper; given also where nothing is grasped.
    pub gripper: Motion,
    /// Fingers.
    pub grasp: Option<Grasp>,
    /// Pusher.
    pub pusher: Option<Tool>,
    /// Table.
    pub support: Option<Tool>,
    /// Free forces.
    pub others: Others,
    /// Time before the first sample in which the grasp settles under growing weight, s.
    pub settle_s: f64,
    /// Length of the record, s.
    pub duration_s: f64,
    /// Samples a second.
    pub rate_hz: f64,
    /// Window of the force sensors, s.
    pub window_s: f64,
    /// Time step, s; [`World::suitable_step_s`] where `None`.
    pub step_s: Option<f64>,
    /// The record ends this long after the object was lost, s.
    pub after_drop_s: f64,
}

/// An object that moved this far in the grasp is lost, m.
const LOST_M: f64 = 0.02;

impl World {
    /// A step that resolves the fastest oscillation: at most 50 us, at least 8 us.
    pub fn suitable_step_s(&self) -> f64 {
        let stiffness =
            |p: &Patch, load: f64| p.foundation.stiffness + p.foundation.relaxing + p.shear_n_m(load);
        let mut jaw = 0.0_f64;
        let mut sum = 0.0;
        if let Some(g) = &self.grasp {
            let load = g.command.0.iter().map(|c| c.1).fold(1.0, f64::max);
            sum += g.pads.iter().map(|p| stiffness(p, load)).sum::<f64>();
            jaw = g.pads[0].foundation.stiffness * 2.0 / g.jaw.finger_kg;
        }
        for tool in [&self.pusher, &self.support].into_iter().flatten() {
            sum += stiffness(&tool.patch, self.body.mass_kg * 10.0);
        }
        // A box turned by a force at its end moves there four times as easily as its centre.
        let fastest = (4.0 * sum / self.body.mass_kg).max(jaw).sqrt();
        (0.4 / fastest).clamp(8e-6, 5e-5)
    }

    /// Runs the trial.
    pub fn run(mut self) -> Record {
        let wanted = self.step_s.unwrap_or_else(|| self.suitable_step_s());
        let per_sample = (1.0 / (self.rate_hz * wanted)).ceil().max(1.0) as usize;
        let dt = 1.0 / (self.rate_hz * per_sample as f64);
        let window = ((self.window_s / dt).round() as usize).clamp(1, per_sample);
        let settle = (self.settle_s * self.rate_hz).round() as i64;
        let count = (self.duration_s * self.rate_hz).round() as i64;
        let mut jaw = self.grasp.as_ref().map(|g| start_jaw(g, &self.surface));
        let mut samples = Vec::with_capacity(count as usize + 1);
        let mut watch = Watch::default();
        let pusher_origin = self.pusher.as_ref().map_or(Vector3::zeros(), |p| p.motion.at(0.0).position);
        let grasp_start = self.relative_start();
        let empty_kg = self.body.mass_kg;
        let empty_inertia = self.body.inertia;
        let mut normals = 2.0 * self.grasp.as_ref().map_or(0.0, |g| g.command.at(0.0));
        let mut slip = 0.0;
        for k in -settle..=count {
            // The sample at time k / rate ends the interval before it.
            let end = k as f64 / self.rate_hz;
            let mut sums = ([Wrench::default(); 2], Wrench::default(), Wrench::default(), Vector3::zeros());
            let mut velocity = self.body.state.velocity;
            for i in 0..per_sample {
                let t = end - (per_sample - i) as f64 * dt;
                let first = i == per_sample - window;
                if first {
                    velocity = self.body.state.velocity;
                }
                let added = self.added_kg.at(t);
                self.body.mass_kg = empty_kg + added;
                self.body.inertia = empty_inertia * (1.0 + added / empty_kg);
                let frame = self.body.frame();
                let gripper = self.gripper.at(t);
                let mut force = Vector3::zeros();
                let mut torque = Vector3::zeros();
                let mut seen = ([Wrench::default(); 2], Wrench::default(), Wrench::default());
                let centre = self.body.state.position;
                let mut act = |tool: &Frame, load: &Load| {
                    let f = tool.rotation * load.force;
                    let about_tool = tool.rotation * load.torque;
                    force += f;
                    torque += about_tool + (tool.position - centre).cross(&f);
                    Wrench { force: f, torque: about_tool + tool.position.cross(&f) }
                };
                if let (Some(grasp), Some(jaw)) = (&mut self.grasp, &mut jaw) {
                    let relative = Relative::between(&gripper, &frame);
                    let command = grasp.command.at(t);
                    jaw.step(&grasp.jaw, command, normals, slip, dt);
                    let mut loads = [Load::default(); 2];
                    for (f, pad) in grasp.pads.iter_mut().enumerate() {
                        let side = if f == 0 { 1.0 } else { -1.0 };
                        let mut shift = Vector3::y() * (0.5 * side * jaw.opening_m);
                        let shift_rate = Vector3::y() * (0.5 * side * jaw.rate_m_s);
                        if let Geometry::CylinderOnPlane { distance, .. } = &mut pad.geometry {
                            *distance = -0.5 * jaw.opening_m;
                            // Its elements ride on the object.
                            shift = Vector3::zeros();
                        }
                        let wet = grasp.wetness[f].at(t);
                        loads[f] = pad.step(&self.surface, &relative, &shift, &shift_rate, wet, dt);
                        act(&gripper, &loads[f]);
                        let patch = patch_centre(&self.surface, &relative, side);
                        seen.0[f] = Wrench {
                            force: loads[f].force,
                            torque: loads[f].torque - patch.cross(&loads[f].force),
                        };
                    }
                    normals = loads[0].normal_n + loads[1].normal_n;
                    slip = 0.5 * (loads[0].slip_m_s + loads[1].slip_m_s);
                    if k > 0 {
                        watch.step(
                            t,
                            loads.map(|l| l.sliding),
                            loads.map(|l| l.slip_m_s),
                            loads.map(|l| l.plastic_m),
                            dt,
                        );
                        let moved = (relative.position - grasp_start).norm_squared().sqrt();
                        if moved > LOST_M || normals < 0.02 * command {
                            watch.lost(t);
                        }
                    }
                }
                if let Some(pusher) = &mut self.pusher {
                    let tool = pusher.motion.at(t);
                    let relative = Relative::between(&tool, &frame);
                    let zero = Vector3::zeros();
                    let load = pusher.patch.step(&self.surface, &relative, &zero, &zero, 1.0, dt);
                    let world = act(&tool, &load);
                    seen.1 = Wrench {
                        force: world.force,
                        torque: world.torque - pusher_origin.cross(&world.force),
                    };
                }
                if let Some(support) = &mut self.support {
                    let tool = support.motion.at(t);
                    let relative = Relative::between(&tool, &frame);
                    let zero = Vector3::zeros();
                    let load = support.patch.step(&self.surface, &relative, &zero, &zero, 1.0, dt);
                    seen.2 = act(&tool, &load);
                }
                let (free, about) = self.others.act(t, &frame, &gripper);
                let arm = frame.position - self.body.state.position;
                torque += about + arm.cross(&free);
                force += free;
                // The weight grows while the grasp settles.
                let share = ((t + self.settle_s) / (0.5 * self.settle_s).max(1e-9)).clamp(0.0, 1.0);
                force += self.gravity * (self.body.mass_kg * share);
                self.body.step(&force, &torque, dt);
                if i + window >= per_sample {
                    let w = 1.0 / window as f64;
                    for f in 0..2 {
                        sums.0[f].add(&seen.0[f], w);
                    }
                    sums.1.add(&seen.1, w);
                    sums.2.add(&seen.2, w);
                    sums.3 += free * w;
                }
            }
            if k == -1
                && let Some(jaw) = &mut jaw
            {
                jaw.lock();
            }
            if k < 0 {
                continue;
            }
            let acceleration = (self.body.state.velocity - velocity) / (window as f64 * dt);
            samples.push(Sample {
                t_s: end,
                grip_cmd_n: self.grasp.as_ref().map_or(0.0, |g| g.command.at(end)),
                gripper: self.gripper.at(end),
                object: self.body.frame(),
                pusher: self.pusher.as_ref().map(|p| p.motion.at(end)),
                fingers: sums.0,
                pusher_wrench: sums.1,
                support_wrench: sums.2,
                other_force: sums.3,
                acceleration,
                mass_kg: self.body.mass_kg,
            });
            if watch.drop_s().is_some_and(|d| end > d + self.after_drop_s) {
                break;
            }
        }
        Record { samples, truth: watch.finish(), step_s: dt }
    }

    fn relative_start(&self) -> Vector3<f64> {
        Relative::between(&self.gripper.at(0.0), &self.body.frame()).position
    }
}

/// Closed so far that the pads' springs carry the commanded force.
fn start_jaw(grasp: &Grasp, surface: &Surface) -> Jaw {
    let force = (grasp.command.at(0.0) * (1.0 - grasp.jaw.loss) - grasp.jaw.loss_n).max(0.0);
    let depth = force / grasp.pads[0].foundation.stiffness;
    Jaw::closed(2.0 * (surface.half.y - depth), force)
}

/// The gripper's origin projected along gripper Y onto the object's side, gripper axes.
fn patch_centre(surface: &Surface, object: &Relative, side: f64) -> Vector3<f64> {
    if surface.round {
        return Vector3::new(0.0, object.position.y + side * surface.half.y, 0.0);
    }
    let normal: Vector3<f64> = object.rotation.column(1) * side;
    let on_face = object.position + normal * surface.half.y;
    let slope = normal.y * side;
    if slope < 0.1 {
        return Vector3::new(0.0, side * surface.half.y, 0.0);
    }
    Vector3::new(0.0, normal.dot(&on_face) / normal.y, 0.0)
}

impl Others {
    /// Force (world axes, N) and torque about the object's origin (N m).
    fn act(&self, t: f64, object: &Frame, gripper: &Frame) -> (Vector3<f64>, Vector3<f64>) {
        let mut force = Vector3::zeros();
        let mut torque = Vector3::zeros();
        for knock in &self.knocks {
            let f = knock.force_at(t);
            force += f;
            torque += (object.rotation * knock.at).cross(&f);
        }
        if self.spring_n_m != Vector3::zeros() {
            let apart = gripper.rotation.inverse() * (object.position - gripper.position);
            let stretch = apart - self.spring_rest;
            force -= gripper.rotation * stretch.component_mul(&self.spring_n_m);
        }
        if let Some(cable) = &self.cable {
            let end = object.rotation * cable.at;
            let apart = cable.anchor - object.position - end;
            let length = apart.norm().max(1e-6);
            let pull = (cable.pull_n + cable.stiffness * (length - cable.length_m)).max(0.0);
            let f = apart * (pull / length);
            force += f;
            torque += end.cross(&f);
        }
        if let Some((place, pull)) = &self.magnet {
            let apart = place - object.position;
            let d = apart.norm().max(5e-3);
            force += apart * (pull / d * (0.02 / d).powi(2));
        }
        (force, torque)
    }
}
