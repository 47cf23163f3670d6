//! Recordings as a faulty rig would have made them, to see what the predictor makes of bad input.

use serde::Serialize;
use stickslip_shared::model::Model;
use stickslip_shared::wire::Sample;

/// What is wrong with the samples, or with the model that is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// The object's pose is missing from 0.8 s on
    PoseGone,
    /// The object's pose stays what it was at 0.8 s
    PoseFrozen,
    /// The object's pose jumps by 20 mm at 0.8 s and stays there
    PoseJumps,
    /// The object's pose is 48 ms late
    PoseLate,
    /// The poses of object and gripper are 48 ms late
    PosesLate,
    /// The object's pose comes at 31 Hz
    PoseRare,
    /// The object's pose comes at 31 Hz and is held between
    PoseHeld,
    /// Finger 2 gives no wrench
    FingerMissing,
    /// The grip command stays at its first value, whatever the grip does
    CommandHeld,
    /// The samples come at 100 Hz
    Rate100,
    /// The stated friction is twice as large
    FrictionDouble,
    /// The stated friction is half as large
    FrictionHalf,
}

/// When a pose goes wrong, us.
const BEGIN_US: u32 = 800_000;
/// Samples of 4 ms that a late pose is late, and from one rare pose to the next.
const LATE: usize = 12;
const RARE: usize = 8;

impl Fault {
    /// Makes it.
    pub fn apply(self, samples: &mut Vec<Sample>, model: &mut Model<f64>) {
        let good = samples.clone();
        let last_good = good.iter().rposition(|s| s.t_us <= BEGIN_US).unwrap_or(0);
        for (i, sample) in samples.iter_mut().enumerate() {
            let begun = i > last_good;
            let late = &good[i.saturating_sub(LATE)];
            match self {
                Fault::PoseGone if begun => sample.object = None,
                Fault::PoseFrozen if begun => sample.object = good[last_good].object,
                Fault::PoseJumps if begun => {
                    if let Some(object) = &mut sample.object {
                        object.position_m[2] += 0.02;
                    }
                }
                Fault::PoseLate => sample.object = late.object,
                Fault::PosesLate => (sample.object, sample.gripper) = (late.object, late.gripper),
                Fault::PoseRare if !i.is_multiple_of(RARE) => sample.object = None,
                Fault::PoseHeld => sample.object = good[i - i % RARE].object,
                Fault::FingerMissing => sample.finger[1] = None,
                Fault::CommandHeld => sample.grip_cmd_n = good[0].grip_cmd_n,
                _ => {}
            }
        }
        match self {
            // Two samples of five, 8 and 12 ms apart.
            Fault::Rate100 => {
                let mut kept = (0..good.len()).map(|i| i * 2 % 5 < 2);
                samples.retain(|_| kept.next().unwrap_or(false));
            }
            Fault::FrictionDouble => model.friction.finger *= 2.0,
            Fault::FrictionHalf => model.friction.finger *= 0.5,
            _ => {}
        }
    }
}
