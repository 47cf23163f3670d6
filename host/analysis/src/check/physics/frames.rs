//! Quaternion order and axes: what a wrong order breaks, and whether the other order mends it.
//!
//! A quaternion written x, y, z, w is a unit quaternion too, so only physics can tell: the
//! fingers' forces, turned to world axes by the gripper's rotation, balance the pusher and the
//! weight; the pusher's +X points to the object's centre of mass (of a convex object every inward
//! normal does, at least partly); what lies on a table lies level.

use nalgebra::{UnitQuaternion, Vector3};
use stickslip_data::{Description, Pose, Sample, Trial};

use super::breach::{Breach, Cause, short};
use crate::channels;
use crate::evidence::balance::balance;
use crate::evidence::stages::Stages;
use crate::evidence::statistics::quantile;

/// A body within this angle of a half turn about Z would not be turned at all in the other order.
const HALF_TURN_RAD: f64 = 0.1;

/// See the module.
#[derive(Default)]
pub struct Frames {
    /// What is impossible.
    pub breaches: Vec<Breach>,
    /// What is only suspicious.
    pub remarks: Vec<String>,
}

/// The pose with its four numbers taken as x, y, z, w.
fn other_order(pose: Pose) -> Pose {
    let [x, y, z, w] = pose.quaternion;
    Pose { quaternion: [w, x, y, z], ..pose }
}

/// All checks of quaternions.
pub fn quaternions(description: &Description, trial: &Trial, stages: &Stages) -> Frames {
    let mut found = Frames::default();
    let swapped = "x,y,z,w in the columns qw,qx,qy,qz? write w first";
    let mut refuse = |cause: Cause, columns: &str, text: String| {
        found.breaches.push(Breach { cause, columns: columns.to_owned(), text });
    };
    let gripper = gripper_order(description, trial, stages);
    if let Order::Other([given, other]) = gripper {
        let text = format!(
            "with the gripper's rotation as recorded, forces and weight sum to {} N; in the other order to {} N; \
             {swapped}",
            short(given),
            short(other)
        );
        refuse(Cause::QuaternionOrder, "columns gripper_q{w,x,y,z}", text);
    }
    match pusher_order(trial) {
        Order::Other([given, other]) => {
            let text = format!(
                "the pusher's +X does not point into the object (cosine to its centre, or to the force, {}), in the other \
                 order it does ({}); {swapped}",
                short(given),
                short(other)
            );
            refuse(Cause::QuaternionOrder, "columns pusher_q{w,x,y,z} (table or trials.csv)", text);
        }
        Order::Neither([given, _]) => {
            let text = format!(
                "the pusher's +X points away from the object (cosine to its centre {}), but must point into it; \
                 turn the pusher's axes, or check its position",
                short(given)
            );
            refuse(Cause::Frame, "columns pusher_{x,y,z}_m, pusher_q{w,x,y,z} (table or trials.csv)", text);
        }
        Order::AsWritten | Order::Unknown => {}
    }
    if let Order::Other([given, other]) = object_on_table(description, trial) {
        let text = format!(
            "the object lies on a table tilted by {} rad, in the other order by {}; {swapped}",
            short(given),
            short(other)
        );
        refuse(Cause::QuaternionOrder, "columns object_q{w,x,y,z}", text);
    }
    // A half turn about Z that nothing else confirms or refutes.
    if found.breaches.is_empty() && matches!(gripper, Order::Unknown) {
        let turned = |of: fn(&Sample) -> Option<Pose>| {
            let first = trial.samples.iter().find_map(of)?;
            let angle = channels::pose(&other_order(first)).rotation.angle();
            (angle < HALF_TURN_RAD && first.quaternion[0].abs() < HALF_TURN_RAD).then_some(())
        };
        let bodies: Vec<&str> = [("gripper", turned(|s| s.gripper)), ("object", turned(|s| s.object))]
            .into_iter()
            .filter_map(|(name, turned)| turned.map(|()| name))
            .collect();
        if !bodies.is_empty() {
            found.remarks.push(format!(
                "the {} starts turned by half a turn about Z, and would not be turned if the quaternion were written \
                 x,y,z,w; make sure that qw comes first",
                bodies.join(" and the ")
            ));
        }
    }
    found
}

/// What a test says: the value as written, and that in the other order.
enum Order {
    AsWritten,
    Other([f64; 2]),
    Neither([f64; 2]),
    Unknown,
}

/// The largest failing sum of the balance, as written and with the gripper's quaternions in the
/// other order. Unknown where both balance (a turn about gravity with no sideways force).
fn gripper_order(description: &Description, trial: &Trial, stages: &Stages) -> Order {
    let sum = |trial: &Trial| {
        let balances = balance(description, trial, stages).ok()?;
        let over = |b: &crate::evidence::balance::StageBalance| {
            let sum = Vector3::from(b.sum_n).norm();
            (sum, sum / (b.bound_n + 3.0 * b.standard_error_n).max(1e-9), b.fails())
        };
        balances.iter().map(over).max_by(|a, b| a.1.total_cmp(&b.1))
    };
    let Some(given) = sum(trial) else { return Order::Unknown };
    let mut other = trial.clone();
    for sample in &mut other.samples {
        sample.gripper = sample.gripper.map(other_order);
    }
    let Some(swapped) = sum(&other) else { return Order::Unknown };
    match (given.2, swapped.2) {
        (true, false) if swapped.0 < 0.5 * given.0 => Order::Other([given.0, swapped.0]),
        (true, _) => Order::Neither([given.0, swapped.0]),
        (false, true) => Order::AsWritten,
        (false, false) => Order::Unknown,
    }
}

/// Cosine between the pusher's +X and the way to the object's centre, at the first sample that
/// has both.
fn pusher_order(trial: &Trial) -> Order {
    let both = |s: &Sample| Some((s.pusher.or(trial.info.pusher)?, s.object?));
    let Some((pusher, object)) = trial.samples.iter().find_map(both) else { return Order::Unknown };
    let way = Vector3::from(object.position_m) - Vector3::from(pusher.position_m);
    let cosine =
        |pose: &Pose| (channels::pose(pose).rotation * Vector3::x()).dot(&way) / way.norm().max(1e-9);
    let (given, other) = (cosine(&pusher), cosine(&other_order(pusher)));
    // A contact near a corner may have its normal nearly across the way to the centre.
    if given < 0.1 && other > 0.3 {
        Order::Other([given, other])
    } else if given < -0.2 {
        Order::Neither([given, other])
    } else {
        pressing_order(trial)
    }
}

/// Cosine of the measured force to a pusher's +X.
fn cosine_of_force(pose: &Pose, force: Vector3<f64>) -> f64 {
    (channels::pose(pose).rotation * Vector3::x()).dot(&force) / force.norm().max(1e-9)
}

/// A push has its force within the friction cone about +X: with friction 2 the cosine is 0.45. Only
/// forces across +X are judged here; a force against it is a matter of signs.
fn pressing_order(trial: &Trial) -> Order {
    let force = |s: &Sample| {
        let force = Vector3::from(s.pusher_wrench?.force_n);
        force.iter().all(|f| f.is_finite()).then_some(force)
    };
    let sizes = trial.samples.iter().filter_map(|s| Some(force(s)?.norm())).collect();
    let Some(largest) = quantile(sizes, 0.95).filter(|largest| *largest > 0.5) else {
        return Order::AsWritten;
    };
    let median = |of: fn(Pose) -> Pose| {
        let cosines = trial.samples.iter().filter_map(|s| {
            let force = force(s).filter(|force| force.norm() > 0.5 * largest)?;
            Some(cosine_of_force(&of(s.pusher.or(trial.info.pusher)?), force))
        });
        quantile(cosines.collect(), 0.5)
    };
    match (median(|pose| pose), median(other_order)) {
        (Some(given), Some(other)) if (-0.5..0.44).contains(&given) && other > 0.6 => {
            Order::Other([given, other])
        }
        _ => Order::AsWritten,
    }
}

/// A polygon lies on one of its two flat faces: its Z is vertical, within a quarter radian.
fn object_on_table(description: &Description, trial: &Trial) -> Order {
    let known = description.objects.iter().find(|object| object.id == trial.info.object);
    let lies = description.supports.contains_key(&trial.info.primitive)
        && known.is_some_and(|object| object.shape == "polygon");
    if !lies {
        return Order::Unknown;
    }
    let up = -Vector3::from(description.gravity_m_s2).try_normalize(1e-9).unwrap_or_else(Vector3::z);
    let tilt = |turn: UnitQuaternion<f64>| (turn * Vector3::z()).dot(&up).abs().min(1.0).acos();
    let median = |of: fn(Pose) -> Pose| {
        let tilts = trial.samples.iter().filter_map(|s| s.object);
        quantile(tilts.map(|pose| tilt(channels::pose(&of(pose)).rotation)).collect(), 0.5)
    };
    match (median(|pose| pose), median(other_order)) {
        (Some(given), Some(other)) if given > 0.25 && other < 0.1 => Order::Other([given, other]),
        (Some(given), Some(other)) if given > 0.25 => Order::Neither([given, other]),
        (Some(_), Some(other)) if other > 0.25 => Order::AsWritten,
        _ => Order::Unknown,
    }
}
