//! What was chosen, not derived, in the predictor: each with its unit, why it has this value, and
//! what happens if it is doubled. Those under 'sensors and rate' are for users whose sensors or
//! sampling differ from the rig's (250 Hz, poses within 30 micrometres, forces within 0.02 N).

use super::ahead;
use crate::tuning::tuned;

tuned! {
    /// The table `predictor` of a [`Tuning`](super::Tuning).
    pub struct Params {
        // Sensors and rate.
        /// Longest time between two samples that the model bridges, s; after a longer gap it starts anew.
        /// The model's steps stay below 20 ms in at most three parts. Doubled: bridges are coarser.
        longest_gap_s: f32 = 0.1, 0.004 to 1.0;
        /// No gripper or pusher is faster than this, m/s: a pose that says so is none. Robots carry at up to 5, and one that a
        /// camera of 31 Hz holds moves by eight of its samples at once. Doubled: wild poses up to 16 cm off are followed.
        fastest_m_s: f32 = 20.0, 0.1 to 1000.0;
        /// The same of turning, rad/s. Doubled: wild rotations up to 1.6 rad are followed.
        fastest_rad_s: f32 = 200.0, 1.0 to 10000.0;
        /// Samples in a row that must show the object elsewhere before the model starts anew there: a
        /// wild pose comes alone or in pairs. Doubled: a true jump is followed 12 ms later.
        strayed_samples: u8 = 3, 1.0 to 250.0;
        /// Share of the way to the measured pose by which the model's object is drawn there in a sample:
        /// a time constant of a second at 250 Hz keeps the pose's noise below 0.1 micrometres. Doubled:
        /// half the time constant, 1.4 times the noise.
        pose_gain: f32 = 0.004, 0.0 to 1.0;
        /// A slip ahead is at least so long ahead, s: one sample at 250 Hz. Doubled: a slip that is due is said to come in 8 ms.
        least_ahead_s: f32 = 0.004, 0.0 to 0.1;
        /// A slip shorter than this says nothing of the next one, m: four times the noise of a pose in
        /// the grasp. Doubled: drops after short repeated slips are warned of later.
        edge_noise_m: f32 = 2.0e-4, 0.0 to 0.01;
        /// Model and measured object farther apart than this disagree, m: half of the divergence at which
        /// the model starts anew. Doubled: never seen before the restart.
        pose_apart_m: f32 = 0.0015, 1e-5 to 0.1;
        /// Model and measured load disagree beyond this share of the load, ...
        load_apart_share: f32 = 0.3, 0.0 to 10.0;
        /// ... and this force, N: two sensors' constant errors after the tare. Doubled: a wrong mass of up
        /// to 60 % passes for agreement, and slip by the model alone is flagged under it.
        load_apart_n: f32 = 0.5, 0.0 to 1000.0;
        /// Model and measured share of the friction limit agree within this. Doubled: slip that the model
        /// alone foresees is believed more often.
        share_apart: f32 = 0.1, 0.0 to 10.0;
        /// The same where nobody sees the object: only the model can predict its slip before it slides. Doubled: any
        /// load passes for the model's.
        unseen_apart: f32 = 0.3, 0.0 to 10.0;
        /// The fingers' normal forces may differ by so much, N, ...
        unbalanced_n: f32 = 1.0, 0.0 to 10000.0;
        /// ... and this share of the grip: what a lateral load or a misaligned sensor makes of it.
        /// Doubled: half of all biased sensors pass.
        unbalanced_share: f32 = 0.15, 0.0 to 10.0;

        /// Samples in a row without forces after which the model starts anew where it was last good: the step spans
        /// all of them by then. Doubled: 12 ms more without a prediction.
        unsolved_samples: u8 = 3, 1.0 to 250.0;
        /// A restart keeps the jaw and the memory of contacts where the jaw is within this of holding the object, m.
        /// Doubled: fingers that were forced apart by more are believed.
        jaw_kept_m: f32 = 1.0e-4, 0.0 to 0.01;

        // Plans and motion.
        /// A planned motion that differs by this on an axis is another one, m/s, ... Doubled: slow lift-offs do not
        /// count as a change of the load.
        other_motion_m_s: f32 = 0.01, 1e-5 to 1.0;
        /// ... or by this, rad/s. At rest is half of both.
        other_motion_rad_s: f32 = 0.1, 1e-4 to 10.0;
        /// A change of the planned motion moves the load for so long, s, and what was meant to slide
        /// comes to rest within it. Doubled: trends and unexpected slip are seen that much later.
        settling_s: f32 = 0.1, 0.0 to 2.0;
        /// A plan may be late by so much, s: ten samples. Doubled: a lift-off's load is not watched
        /// for 40 ms more.
        plan_late_s: f32 = 0.04, 0.0 to 1.0;
        /// Of `settling_s`, the time in which the gripper may still gain or lose speed, s. Doubled: a load that is
        /// clipped while the gripper starts is slip without a pose 40 ms later.
        gaining_s: f32 = 0.04, 0.0 to 2.0;
        /// The gripper's measured acceleration explains changes of the load for so long, s: three blocks of
        /// poses, and a jaw's ringing. Doubled: trends are seen 60 ms later after each move.
        inertia_s: f32 = 0.06, 0.0 to 2.0;

        // Warnings.
        /// A warning stays up for so long after its cause was last seen, s: one episode, one alarm.
        /// Doubled: alarms merge that have two causes.
        held_s: f32 = 0.15, 0.0 to 5.0;
        /// What the pads bore under a warning of the model, that the pose shows no slip after, is remembered for so long, s: a few
        /// periods of a shaking. Doubled: a grasp that has lost friction since is warned of by what is seen for 3 s more.
        remembered_s: f32 = 3.0, 0.0 to 600.0;
        /// More than was borne by this factor is new: noise of the forces. Doubled: loads 8 % higher are not foreseen.
        more_share: f32 = 1.04, 1.0 to 10.0;
        /// Without a pose, a slip that lasts longer is taken for the loss of the grasp, s: most knocks are
        /// shorter. Doubled: 30 ms less warning of a drop.
        lasting_s: f32 = 0.03, 0.0 to 1.0;
        /// A slip is extrapolated no further than this multiple of the time for which it has been seen, ...
        extrapolated: f32 = 4.0, 0.0 to 100.0;
        /// ... and this time, s: most slips that a knock causes end by themselves. Doubled: more of those
        /// are taken for drops.
        at_once_s: f32 = 0.03, 0.0 to 1.0;
        /// An object that leaves the grasp moves at least this fast, m/s. Doubled: slow departures are
        /// warned of later.
        leaving_m_s: f32 = 0.01, 0.0 to 1.0;
        /// The next slip may be longer than the last by this factor. Doubled: warnings of drops after
        /// slips of half the length.
        next_slip: f32 = 1.25, 0.0 to 10.0;
        /// Slip and sag that the model alone foresees must be foreseen in so many samples in a row: a
        /// look-ahead may be older than a change of the motion. Doubled: 20 ms less lead.
        foreseen_samples: u8 = 5, 1.0 to 100.0;
        /// The same of slip where nobody sees the object. Doubled: 12 ms less lead.
        unseen_samples: u8 = 3, 1.0 to 100.0;
        /// The look-ahead.
        ahead: ahead::Params = ahead::Params::default();
    }
}
