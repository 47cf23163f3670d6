//! Limits of commands, checked before anything is touched: on the host to spare the
//! user a round trip, on the board because a host may be wrong.

use super::SAMPLE_QUEUE;
use super::messages::{Calibration, Field, Grasp, GripLimits, HostClock, MAX_REACH_M, Refusal, StartRequest};
use crate::predictor::plan::{Plan, Segment};

/// Largest grip force, N.
pub const MAX_GRIP_N: f32 = 500.0;
/// Fastest change of a grip force, N/s: a stiff jaw's whole range in 5 ms.
pub const MAX_GRIP_RATE_N_S: f32 = 1.0e5;
/// Largest speed of the gripper, m/s.
pub const MAX_SPEED_M_S: f32 = 5.0;
/// Largest angular speed of the gripper, rad/s.
pub const MAX_ANGULAR_RAD_S: f32 = 20.0;
/// Longest segment of a plan, s.
pub const MAX_DURATION_S: f32 = 3600.0;
/// Fastest that one clock may gain on another: crystals differ by 1e-4, a chip's oscillator is off by some hundredths.
pub const MAX_DRIFT: f32 = 0.05;
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
/// Limits that are none: crossed, or a rate that does not move.
pub fn grip_limits(limits: &GripLimits) -> Result<(), Refusal> {
    grip(limits.least_n)?;
    range(Field::GripMost, limits.most_n, limits.least_n, MAX_GRIP_N)?;
    for rate in [limits.rise_n_s, limits.fall_n_s] {
        range(Field::GripRate, rate, 1.0e-3, MAX_GRIP_RATE_N_S)?;
    }
    Ok(())
}

/// # Errors
/// A pose that is not finite, or whose quaternion is not one.
pub fn grasp(grasp: &Grasp) -> Result<(), Refusal> {
    for pose in [&grasp.gripper, &grasp.object] {
        for x in pose.position_m {
            range(Field::Position, x, -MAX_REACH_M, MAX_REACH_M)?;
        }
        let size: f32 = pose.quaternion.iter().map(|q| q * q).sum();
        range(Field::Quaternion, size, 0.99, 1.01)?;
    }
    Ok(())
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
/// A third finger.
pub fn finger(number: u8) -> Result<(), Refusal> {
    range(Field::Finger, f32::from(number), 0.0, 1.0)
}

/// # Errors
/// A base identifier of more than seven bits.
pub fn ati_base(base: u8) -> Result<(), Refusal> {
    range(Field::SensorBase, f32::from(base), 0.0, 127.0)
}

/// # Errors
/// A drift that no two clocks have.
pub fn clock(clock: &HostClock) -> Result<(), Refusal> {
    range(Field::Drift, clock.drift, -MAX_DRIFT, MAX_DRIFT)
}

/// # Errors
/// A third finger, an entry that is not finite or absurd, or a singular matrix.
pub fn calibration(calibration: &Calibration) -> Result<(), Refusal> {
    finger(calibration.finger)?;
    for entry in calibration.matrix.iter().flatten() {
        range(Field::Calibration, *entry, -MAX_CALIBRATION, MAX_CALIBRATION)?;
    }
    if singular(calibration.matrix) {
        return Err(Refusal::Singular { finger: calibration.finger });
    }
    Ok(())
}

/// Whether elimination with row pivots meets a pivot of nothing but rounding: below 6 times `f32`'s
/// precision of what the column held.
fn singular(mut m: [[f32; 6]; 6]) -> bool {
    // Newtons and newton metres differ in scale: each row by its own largest entry.
    for row in &mut m {
        let largest = row.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
        if largest == 0.0 {
            return true;
        }
        row.iter_mut().for_each(|x| *x /= largest);
    }
    for k in 0..6 {
        let column = |row: &[f32; 6]| row.get(k).map_or(0.0, |x| x.abs());
        let best = (k..6).fold(k, |best, r| if column(&m[r]) > column(&m[best]) { r } else { best });
        m.swap(k, best);
        let pivot = m[k];
        if !(column(&pivot) > 6.0 * f32::EPSILON) {
            return true;
        }
        for row in m.iter_mut().skip(k + 1) {
            let factor = row[k] / pivot[k];
            row.iter_mut().zip(pivot).for_each(|(x, p)| *x -= factor * p);
        }
    }
    false
}

/// # Errors
/// A prefill that the queue cannot hold, a trial number that is not one.
pub fn start(request: &StartRequest) -> Result<(), Refusal> {
    range(Field::Trial, request.trial, 0.0, 1.0e6)?;
    range(Field::Prefill, f32::from(request.prefill), 0.0, SAMPLE_QUEUE as f32)
}
