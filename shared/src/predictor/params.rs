//! What was chosen, not derived, in the predictor: each with its unit, why it has this value, and
//! what happens if it is doubled. Those under 'sensors and rate' are for users whose sensors or
//! sampling differ from the rig's (250 Hz, poses within 30 micrometres, forces within 0.02 N).

use super::ahead;

/// Set with [`super::Predictor::with_params`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params {
    // Sensors and rate.
    /// Longest time between two samples that the model bridges, s; after a longer gap it starts anew.
    /// The model's steps stay below 20 ms in at most three parts. Doubled: bridges are coarser.
    pub longest_gap_s: f32,
    /// No gripper or pusher is faster than this, m/s: a pose that says so is none. Robots carry at up to 5, and one that a
    /// camera of 31 Hz holds moves by eight of its samples at once. Doubled: wild poses up to 16 cm off are followed.
    pub fastest_m_s: f32,
    /// The same of turning, rad/s. Doubled: wild rotations up to 1.6 rad are followed.
    pub fastest_rad_s: f32,
    /// Samples in a row that must show the object elsewhere before the model starts anew there: a
    /// wild pose comes alone or in pairs. Doubled: a true jump is followed 12 ms later.
    pub strayed_samples: u8,
    /// Share of the way to the measured pose by which the model's object is drawn there in a sample:
    /// a time constant of a second at 250 Hz keeps the pose's noise below 0.1 micrometres. Doubled:
    /// half the time constant, 1.4 times the noise.
    pub pose_gain: f32,
    /// A slip ahead is at least so long ahead, s: one sample at 250 Hz.
    pub least_ahead_s: f32,
    /// A slip shorter than this says nothing of the next one, m: four times the noise of a pose in
    /// the grasp. Doubled: drops after short repeated slips are warned of later.
    pub edge_noise_m: f32,
    /// Model and measured object farther apart than this disagree, m: half of the divergence at which
    /// the model starts anew. Doubled: never seen before the restart.
    pub pose_apart_m: f32,
    /// Model and measured load disagree beyond this share of the load, ...
    pub load_apart_share: f32,
    /// ... and this force, N: two sensors' constant errors after the tare. Doubled: a wrong mass of up
    /// to 60 % passes for agreement, and slip by the model alone is flagged under it.
    pub load_apart_n: f32,
    /// Model and measured share of the friction limit agree within this. Doubled: slip that the model
    /// alone foresees is believed more often.
    pub share_apart: f32,
    /// The same where nobody sees the object: only the model can tell of its slip before it slides. Doubled: any
    /// load passes for the model's.
    pub unseen_apart: f32,
    /// The fingers' normal forces may differ by so much, N, ...
    pub unbalanced_n: f32,
    /// ... and this share of the grip: what a lateral load or a misaligned sensor makes of it.
    /// Doubled: half of all biased sensors pass.
    pub unbalanced_share: f32,

    /// Samples in a row without forces after which the model starts anew where it was last good: the step spans
    /// all of them by then. Doubled: 12 ms more without a prediction.
    pub unsolved_samples: u8,
    /// A restart keeps the jaw and the memory of contacts where the jaw is within this of holding the object, m.
    /// Doubled: fingers that were forced apart by more are believed.
    pub jaw_kept_m: f32,

    // Plans and motion.
    /// A planned motion that differs by this on an axis is another one, m/s, ... Doubled: slow lift-offs do not
    /// count as a change of the load.
    pub other_motion_m_s: f32,
    /// ... or by this, rad/s. At rest is half of both.
    pub other_motion_rad_s: f32,
    /// A change of the planned motion moves the load for so long, s, and what was meant to slide
    /// comes to rest within it. Doubled: trends and unexpected slip are seen that much later.
    pub settling_s: f32,
    /// A plan may be late by so much, s: ten samples. Doubled: a lift-off's load is not watched
    /// for 40 ms more.
    pub plan_late_s: f32,
    /// Of `settling_s`, the time in which the gripper may still gain or lose speed, s.
    pub gaining_s: f32,
    /// The gripper's measured acceleration explains changes of the load for so long, s: three blocks of
    /// poses, and a jaw's ringing. Doubled: trends are seen 60 ms later after each move.
    pub inertia_s: f32,

    // Warnings.
    /// A warning stays up for so long after its cause was last seen, s: one episode, one alarm.
    /// Doubled: alarms merge that have two causes.
    pub held_s: f32,
    /// What the pads bore under a warning of the model, that the pose shows no slip after, is remembered for so long, s: a few
    /// periods of a shaking. Doubled: a grasp that has lost friction since is warned of by what is seen for 3 s more.
    pub remembered_s: f32,
    /// More than was borne by this factor is new: noise of the forces. Doubled: loads 8 % higher are not foreseen.
    pub more_share: f32,
    /// Without a pose, a slip that lasts longer is taken for the loss of the grasp, s: most knocks are
    /// shorter. Doubled: 30 ms less warning of a drop.
    pub lasting_s: f32,
    /// A slip is extrapolated no further than this multiple of the time for which it has been seen, ...
    pub extrapolated: f32,
    /// ... and this time, s: most slips that a knock causes end by themselves. Doubled: more of those
    /// are taken for drops.
    pub at_once_s: f32,
    /// An object that leaves the grasp moves at least this fast, m/s. Doubled: slow departures are
    /// warned of later.
    pub leaving_m_s: f32,
    /// The next slip may be longer than the last by this factor. Doubled: warnings of drops after
    /// slips of half the length.
    pub next_slip: f32,
    /// Slip and sag that the model alone foresees must be foreseen in so many samples in a row: a
    /// look-ahead may be older than a change of the motion. Doubled: 20 ms less lead.
    pub foreseen_samples: u8,
    /// The same of slip where nobody sees the object. Doubled: 12 ms less lead.
    pub unseen_samples: u8,
    /// The look-ahead.
    pub ahead: ahead::Params,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            longest_gap_s: 0.1,
            fastest_m_s: 20.0,
            fastest_rad_s: 200.0,
            strayed_samples: 3,
            pose_gain: 0.004,
            least_ahead_s: 0.004,
            edge_noise_m: 2.0e-4,
            pose_apart_m: 0.0015,
            load_apart_share: 0.3,
            load_apart_n: 0.5,
            share_apart: 0.1,
            unseen_apart: 0.3,
            unbalanced_n: 1.0,
            unbalanced_share: 0.15,
            unsolved_samples: 3,
            jaw_kept_m: 1.0e-4,
            other_motion_m_s: 0.01,
            other_motion_rad_s: 0.1,
            settling_s: 0.1,
            plan_late_s: 0.04,
            gaining_s: 0.04,
            inertia_s: 0.06,
            held_s: 0.15,
            remembered_s: 3.0,
            more_share: 1.04,
            lasting_s: 0.03,
            extrapolated: 4.0,
            at_once_s: 0.03,
            leaving_m_s: 0.01,
            next_slip: 1.25,
            foreseen_samples: 5,
            unseen_samples: 3,
            ahead: ahead::Params::default(),
        }
    }
}
