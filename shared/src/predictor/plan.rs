//! The plan: how the gripper shall move, and what that means to do with the grasp.

use heapless::Vec;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Most segments of a plan.
pub const MAX_SEGMENTS: usize = 8;
/// What a plan segment means to do with the grasp.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, Schema)]
pub enum Intent {
    /// The object shall stay where it is in the grasp.
    #[default]
    Hold,
    /// The object shall slide through the grasp along the segment's velocity; sag across it is not
    /// intended. A segment slower than `Limits::slip_m_s` intends no slide: it counts as `Hold`.
    Slide,
    /// The object shall turn between the fingers about the gripper's Y axis.
    Pivot,
    /// Any motion in the grasp is intended.
    Free,
}

/// Planned motion of the gripper for some time.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize, Schema)]
pub struct Segment {
    /// For how long.
    pub duration_s: f32,
    /// Velocity of the gripper's origin, world axes.
    pub velocity_m_s: [f32; 3],
    /// Angular velocity of the gripper, world axes.
    pub angular_rad_s: [f32; 3],
    /// Grip force of each finger.
    pub grip_n: f32,
    /// What it means to do.
    pub intent: Intent,
}

/// Plan from `start_s` (time stamp of the samples) on; after its end the last segment goes on.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, Schema)]
pub struct Plan {
    /// Time stamp at which the first segment begins.
    pub start_s: f32,
    /// In order.
    pub segments: Vec<Segment, MAX_SEGMENTS>,
}

impl Plan {
    /// The segment in force at `t_s`; `None` for an empty plan or before its start.
    pub fn at(&self, t_s: f32) -> Option<&Segment> {
        if !(t_s >= self.start_s) {
            return None;
        }
        let mut end = self.start_s;
        for s in &self.segments {
            end += s.duration_s;
            if t_s < end {
                return Some(s);
            }
        }
        self.segments.last()
    }
}
