//! How far the contact forces of a rigid grasp are determined.
//!
//! With several hard contacts the motion and the net wrench do not determine each contact's
//! force. For one step of a simulation this module finds, for every force and torque
//! channel, the least and the greatest value over all solutions with the same motion:
//!
//! - points that slide bear `mu n` against their slip velocity (Coulomb),
//! - points that stick bear anything inside their friction cone,
//! - points that are apart bear nothing,
//! - the net wrench on the object and the jaw's grip are those of the step.
//!
//! This is a linear programme (solved by the crate `microlp`). A sticking point's cone is
//! circumscribed by a pyramid of 16 faces, which widens its bound by at most 2 %. Its forces are
//! what the pyramid's edges span with weights that are not negative, so that the only rows of the
//! programme are those of the balance. The solution
//! that the simulation returns, the one of least elastic energy, lies inside. A measured
//! force inside the band is no error of the model.
//!
//! The points are those of the patch (`stickslip_shared::contact`): a band says what pressure
//! distributions over these points can do, not what a finer patch could.

use microlp::{ComparisonOp, OptimizationDirection, Problem, Variable};
use nalgebra::Vector3;
use stickslip_shared::contact::{Body, SLOTS};
use stickslip_shared::model::Model;
use stickslip_shared::step::{Drive, State, StepOutput};

use crate::channels::{COUNT, Quantity, Signals, quantity};
use crate::run::simulate::Prepared;

/// Least and greatest value of each channel; for the object's channels both are the value
/// of the simulation. NaN where the model has no such channel.
pub type Band = [(f64, f64); COUNT];

/// Faces of the pyramid around a sticking point's cone.
const FACETS: usize = 16;
/// Slip speed below which a point sticks, m/s.
const STICKS_M_S: f64 = 2e-5;
/// Gap above which a point is apart, m.
const APART_M: f64 = 1e-5;
/// Radius that weighs torques against forces in the balance, m.
const LEVER_M: f64 = 0.02;

/// One contact point of the programme.
struct Point {
    body: Body,
    /// Forces on the object that span those it may exert, each for 1 N of normal force, carrier axes:
    /// a sliding point has one, a sticking one the edges of its pyramid.
    edges: Vec<Vector3<f64>>,
    lever_m: Vector3<f64>,
    /// From the point about which its body's wrench is reported.
    arm_m: Vector3<f64>,
}

/// The bands at the samples `at` (rising), from a simulation of `model`. A sample whose
/// programme has no solution (the step's own balance was not solved) gets the values of the
/// simulation.
pub fn bands(prepared: &Prepared, model: &Model<f64>, at: &[usize]) -> Vec<(usize, Band)> {
    let mut out = Vec::new();
    prepared.observe(model, 1, |sample, state, step, drive| {
        if at.binary_search(&sample).is_ok() {
            out.push((sample, band(state, &step.output(), drive)));
        }
    });
    out
}

/// As [`bands`], of the forces alone (torques: both ends the value of the simulation).
pub fn bands_of_forces(prepared: &Prepared, model: &Model<f64>, at: &[usize]) -> Vec<(usize, Band)> {
    let mut out = Vec::new();
    prepared.observe(model, 1, |sample, state, step, drive| {
        if at.binary_search(&sample).is_ok() {
            let sides = |channel: usize, _| [quantity(channel) == Quantity::Force; 2];
            out.push((sample, sides_of(state, &step.output(), drive, &sides)));
        }
    });
    out
}

/// As [`bands`], but only as much of them as is needed to judge the measured forces
/// `wanted(sample)`: where one is within `tolerance` of the simulation's or not finite, and on
/// the side away from it, the band ends at the value of the simulation. Many times faster.
pub fn bands_towards(
    prepared: &Prepared,
    model: &Model<f64>,
    at: &[usize],
    wanted: &dyn Fn(usize) -> Signals,
    tolerance: &Signals,
) -> Vec<(usize, Band)> {
    let mut out = Vec::new();
    prepared.observe(model, 1, |sample, state, step, drive| {
        if at.binary_search(&sample).is_ok() {
            let wanted = wanted(sample);
            let sides = |channel: usize, value: f64| {
                let away = wanted[channel] - value;
                [away < -tolerance[channel], away > tolerance[channel]]
            };
            out.push((sample, sides_of(state, &step.output(), drive, &sides)));
        }
    });
    out
}

/// The band of one step; `state` is that after it.
pub fn band(state: &State<f64, SLOTS>, step: &StepOutput<f64, SLOTS>, drive: &Drive<f64>) -> Band {
    sides_of(state, step, drive, &|_, _| [true; 2])
}

/// The band of one step; `sides` tells for channel and value whether its lower and its upper
/// end are needed.
fn sides_of(
    state: &State<f64, SLOTS>,
    step: &StepOutput<f64, SLOTS>,
    drive: &Drive<f64>,
    sides: &dyn Fn(usize, f64) -> [bool; 2],
) -> Band {
    let points = points(state, step, drive);
    let mut band = [(f64::NAN, f64::NAN); COUNT];
    let r = &step.reading;
    let values = r.finger[0].iter().chain(&r.finger[1]).chain(&r.pusher);
    for (c, v) in values.enumerate() {
        band[6 + c] = (*v, *v);
    }
    for body in [Body::Finger1, Body::Finger2, Body::Pusher] {
        if !points.iter().any(|p| p.body == body) {
            continue;
        }
        for k in 0..6 {
            let channel = 6 + 6 * body.index() + k;
            let value = band[channel].0;
            let [lower, upper] = sides(channel, value);
            // Fingers report in carrier axes, the pusher in the world's.
            let axis = Vector3::ith(k % 3, 1.0);
            let axis =
                if body == Body::Pusher { drive.carrier.inverse_transform_vector(&axis) } else { axis };
            let weigh = |p: &Point, force: &Vector3<f64>| {
                let value = if k < 3 { *force } else { p.arm_m.cross(force) };
                if p.body == body { axis.dot(&value) } else { 0.0 }
            };
            let end = |direction| extreme(&points, step, direction, &weigh).unwrap_or(value);
            if lower {
                band[channel].0 = end(OptimizationDirection::Minimize).min(value);
            }
            if upper {
                band[channel].1 = end(OptimizationDirection::Maximize).max(value);
            }
        }
    }
    band
}

fn points(state: &State<f64, SLOTS>, step: &StepOutput<f64, SLOTS>, drive: &Drive<f64>) -> Vec<Point> {
    let u = &state.velocity;
    let (v, w) = (Vector3::new(u[0], u[1], u[2]), Vector3::new(u[3], u[4], u[5]));
    let before = state.position_m - v * drive.dt_s;
    step.contacts
        .iter()
        .zip(step.friction.iter().zip(&step.force_n))
        .filter(|(c, (_, f))| f[0] > 0.0 || c.gap_m < APART_M)
        .map(|(c, (law, f))| {
            let at = before + c.lever_m;
            let slip = v + w.cross(&c.lever_m) - c.surface_m_s;
            let along = [c.axes[1].dot(&slip), c.axes[2].dot(&slip)];
            let speed = along[0].hypot(along[1]);
            let mu = 0.5 * (law.mu[0] + law.mu[1]);
            let bound = (f[0] + law.adhesion_n) * mu;
            let at_limit = f[0] <= 1e-9 || f[1].hypot(f[2]) > 0.999 * bound;
            let normal = c.axes[0];
            let edges = if speed > STICKS_M_S && at_limit {
                // A loaded point has its direction from the solution, an unloaded one from
                // its slip.
                let friction = match f[0] > 1e-6 {
                    true => (c.axes[1] * f[1] + c.axes[2] * f[2]) / f[0],
                    false => (c.axes[1] * along[0] + c.axes[2] * along[1]) * (-mu / speed),
                };
                vec![normal + friction]
            } else {
                // The corners of the polygon around the circle of radius mu.
                let part = std::f64::consts::TAU / FACETS as f64;
                let corner = |k: usize| {
                    let (sin, cos) = ((k as f64 + 0.5) * part).sin_cos();
                    normal + (c.axes[1] * cos + c.axes[2] * sin) * (mu / (0.5 * part).cos())
                };
                (0..FACETS).map(corner).collect()
            };
            let arm_m = match c.body {
                Body::Pusher => at - drive.pusher.map_or(at, |p| p.reference_m),
                Body::Finger1 | Body::Finger2 => Vector3::new(at.x, 0.0, at.z),
                Body::Support => Vector3::zeros(),
            };
            Point { body: c.body, edges, lever_m: c.lever_m, arm_m }
        })
        .collect()
}

/// Least or greatest value of a linear function of the forces.
fn extreme(
    points: &[Point],
    step: &StepOutput<f64, SLOTS>,
    direction: OptimizationDirection,
    weigh: &dyn Fn(&Point, &Vector3<f64>) -> f64,
) -> Option<f64> {
    let mut problem = Problem::new(direction);
    // Each unknown with the force that a unit of it exerts.
    let mut all: Vec<(Variable, &Vector3<f64>, &Point)> = Vec::new();
    for p in points {
        for edge in &p.edges {
            all.push((problem.add_var(weigh(p, edge), (0.0, f64::INFINITY)), edge, p));
        }
    }
    // The balance: net force, net moment, sum of the fingers' normal forces.
    let mut total = [0.0; 7];
    for (c, f) in step.contacts.iter().zip(&step.force_n) {
        let force = c.axes[0] * f[0] + c.axes[1] * f[1] + c.axes[2] * f[2];
        let moment = c.lever_m.cross(&force) / LEVER_M;
        for k in 0..3 {
            total[k] += force[k];
            total[3 + k] += moment[k];
        }
        if matches!(c.body, Body::Finger1 | Body::Finger2) {
            total[6] += f[0];
        }
    }
    let gripped = points.iter().any(|p| matches!(p.body, Body::Finger1 | Body::Finger2));
    for (row, total) in total.iter().enumerate().take(if gripped { 7 } else { 6 }) {
        let coefficient = |(_, force, p): &(Variable, &Vector3<f64>, &Point)| match row {
            0..=2 => force[row],
            3..=5 => p.lever_m.cross(force)[row - 3] / LEVER_M,
            _ => f64::from(u8::from(matches!(p.body, Body::Finger1 | Body::Finger2))),
        };
        let mut line: Vec<(Variable, f64)> =
            all.iter().map(|x| (x.0, coefficient(x))).filter(|(_, c)| c.abs() > 1e-12).collect();
        // A micronewton of slack: the step's own balance is no better.
        line.push((problem.add_var(0.0, (-1e-6, 1e-6)), 1.0));
        problem.add_constraint(line, ComparisonOp::Eq, *total);
    }
    let solution = problem.solve().ok()?.into_solution().ok()?;
    Some(solution.objective()).filter(|x| x.is_finite())
}
