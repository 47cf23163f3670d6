//! Limits of commands, checked before anything is touched: on the host to spare the
//! user a round trip, on the board because a host may be wrong.

use super::SAMPLE_QUEUE;
use super::messages::{Calibration, Field, Refusal, StartRequest};
use crate::predictor::plan::{Plan, Segment};

/// Largest grip force, N.
pub const MAX_GRIP_N: f32 = 500.0;
/// Largest speed of the gripper, m/s.
pub const MAX_SPEED_M_S: f32 = 5.0;
/// Largest angular speed of the gripper, rad/s.
pub const MAX_ANGULAR_RAD_S: f32 = 20.0;
/// Longest segment of a plan, s.
pub const MAX_DURATION_S: f32 = 3600.0;
/// Largest entry of a calibration matrix, N or N m a count.
pub const MAX_CALIBRATION: f32 = 1.0e3;

/// # Errors
/// `OutOfRange` where `value` is not a number within `[low, high]`.
pub fn range(field: Field, value: f32, low: f32, high: f32) -> Result<(), Refusal> {
    // NaN fails both comparisons.
    if value >= low && value <= high { Ok(()) } else { Err(Refusal::OutOfRange { field, value, low, high }) }
}

/// # Errors
/// A grip force that no gripper has.
pub fn grip(force_n: f32) -> Result<(), Refusal> {
    range(Field::Grip, force_n, 0.0, MAX_GRIP_N)
}

/// # Errors
/// The first number of the first segment that is out of range.
pub fn plan(plan: &Plan) -> Result<(), Refusal> {
    range(Field::PlanStart, plan.start_s, -MAX_DURATION_S, MAX_DURATION_S)?;
    plan.segments.iter().try_for_each(segment)
}

fn segment(segment: &Segment) -> Result<(), Refusal> {
    range(Field::Duration, segment.duration_s, 0.0, MAX_DURATION_S)?;
    for speed in segment.velocity_m_s {
        range(Field::Velocity, speed, -MAX_SPEED_M_S, MAX_SPEED_M_S)?;
    }
    for speed in segment.angular_rad_s {
        range(Field::AngularVelocity, speed, -MAX_ANGULAR_RAD_S, MAX_ANGULAR_RAD_S)?;
    }
    grip(segment.grip_n)
}

/// # Errors
/// A third finger, or an entry that is not finite or absurd.
pub fn calibration(calibration: &Calibration) -> Result<(), Refusal> {
    range(Field::Finger, f32::from(calibration.finger), 0.0, 1.0)?;
    for entry in calibration.matrix.iter().flatten() {
        range(Field::Calibration, *entry, -MAX_CALIBRATION, MAX_CALIBRATION)?;
    }
    Ok(())
}

/// # Errors
/// A prefill that the queue cannot hold, a trial number that is not one.
pub fn start(request: &StartRequest) -> Result<(), Refusal> {
    range(Field::Trial, request.trial, 0.0, 1.0e6)?;
    range(Field::Prefill, f32::from(request.prefill), 0.0, SAMPLE_QUEUE as f32)
}
