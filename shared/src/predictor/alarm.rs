//! The slip warning of a held grasp: a state machine that remembers what raised it. A pure function of what a tick
//! shows and of the state before.
//!
//! A warning stays while its cause does, and [`Params::held_s`] longer. It ends at once where its cause has ended: the
//! grip has come to a commanded level that holds, the load has come down, the plan has passed its acceleration. What the
//! model foresaw and the pads have borne, as the pose shows, is foreseen again only by more than they bore then.

use super::params::Params;

/// What announces slip, or shows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The grip command falls.
    Grip,
    /// The load rises over the grip by a proven trend.
    Load,
    /// The model foresees slip while the gripper gains or loses speed.
    Inertia,
    /// The model foresees slip in a steady motion.
    Foresight,
    /// The pose moves in the grasp.
    Motion,
    /// Nobody sees the object: its load is clipped, or its weight not borne.
    Clipped,
}

impl Cause {
    fn is_foreseen(self) -> bool {
        matches!(self, Self::Inertia | Self::Foresight)
    }
}

/// Where a warning stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum State {
    /// Nothing announces slip.
    #[default]
    Clear,
    /// The model foresees slip, for too few samples yet.
    Watching,
    /// Slip is announced.
    Warned(Cause),
    /// It slips.
    Sliding(Cause),
    /// What announced slip has ended without it.
    Ended(Cause),
}

/// What one tick shows of slip.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Signs {
    /// It slips now.
    pub slides: Option<Cause>,
    /// What announces slip, and in how long, s.
    pub ahead: Option<(Cause, f32)>,
    /// The model foresees slip, for too few samples yet.
    pub suspects: bool,
    /// The cause has ended by proof: of a trend or a grip, the load or the command; of an acceleration, the plan.
    pub over: bool,
    /// The object is seen: where nothing is seen to slip, nothing does.
    pub seen: bool,
    /// Share of the friction limit that is used.
    pub used: f32,
    /// Since the last sample, s.
    pub dt_s: f32,
}

/// A warning and its memory.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Alarm {
    /// Where it stands.
    pub state: State,
    /// Time to slip as last announced, s.
    pub in_s: f32,
    /// For how long it stays without its cause, s.
    left_s: f32,
    /// Largest share of the limit that was borne under a warning of the model, and how long that is remembered, s.
    borne: f32,
    remembered_s: f32,
}

impl Alarm {
    /// The time in which slip is announced, s.
    pub fn ahead_s(&self) -> Option<f32> {
        (self.left_s > 0.0).then_some(self.in_s)
    }

    /// What this sign announces is new: no slip came of the like of it when the pads bore as much.
    pub fn is_new(&self, cause: Cause, used: f32, params: &Params) -> bool {
        !cause.is_foreseen() || !(self.remembered_s > 0.0) || used > self.borne * params.more_share
    }

    /// The alarm after a tick.
    #[must_use]
    pub fn next(&self, s: &Signs, params: &Params) -> Self {
        let mut a = Self { remembered_s: (self.remembered_s - s.dt_s).max(0.0), ..*self };
        let ahead = s.ahead.filter(|(cause, _)| self.is_new(*cause, s.used, params));
        match ahead {
            Some((_, in_s)) => (a.in_s, a.left_s) = (in_s, params.held_s),
            None => a.left_s = (a.left_s - s.dt_s).max(0.0),
        }
        if ahead.is_none() && s.over {
            a.left_s = 0.0;
        }
        a.state = match (self.state, ahead) {
            _ if s.slides.is_some() => {
                // What was announced has come.
                (a.borne, a.remembered_s) = (0.0, 0.0);
                s.slides.map_or(State::Clear, State::Sliding)
            }
            (_, Some((cause, _))) => State::Warned(cause),
            (State::Warned(cause) | State::Sliding(cause), None) if a.left_s > 0.0 => State::Warned(cause),
            (State::Warned(cause), None) => {
                if cause.is_foreseen() && s.seen {
                    a.remembered_s = params.remembered_s;
                }
                State::Ended(cause)
            }
            (State::Sliding(cause), None) => State::Ended(cause),
            _ if s.suspects => State::Watching,
            (State::Ended(cause), None) if a.remembered_s > 0.0 => State::Ended(cause),
            _ => State::Clear,
        };
        a.borne = match a.state {
            State::Warned(cause) if cause.is_foreseen() => {
                let begins = !matches!(self.state, State::Warned(before) if before.is_foreseen());
                let before = if begins && !(self.remembered_s > 0.0) { 0.0 } else { self.borne };
                s.used.max(before)
            }
            _ => a.borne,
        };
        a
    }
}
