//! How early and how rightly slip and drop are predicted, against the measured motion.
//!
//! Each trial goes through the predictor tick by tick in `f32`, as on the board. The plan
//! gives the gripper's motion and the grip set-point at the start; that a grip decays is
//! not in it. Baselines see the same wrenches.

pub mod alarms;
pub mod calibration;
pub mod cause;
pub mod document;
pub mod figures;
pub mod judge;
pub mod rate;
pub mod traces;
pub mod truth;
pub mod warnings;

pub use alarms::UNTRUSTED;
pub use judge::{Alarms, Judged, Method, ObjectPose, ScoreError, Scored, judge};
pub use truth::{DROP_AHEAD_S, SLIP_AHEAD_S, SUDDEN_WITHIN_S};
