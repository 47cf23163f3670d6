//! From what a tick shows to its flags: a pure function of evidence and alarm state.
//!
//! Slip now is what the pose shows; slip ahead needs a proven trend, or a model that agrees with the
//! measured load and foresees slip from the plan. To be near the limit is neither.

use super::alarm::{Alarm, Cause, Signs, State};
use super::params::Params;
use super::plan::Intent;
use super::types::{Limits, Slip, flags};

/// What one tick shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Evidence {
    /// Of the plan, now.
    pub intent: Intent,
    /// The plan means the object to move in the grasp, now or within the time that a plan may be late.
    pub moves: bool,
    /// The plan will mean so within the horizon.
    pub moves_ahead: bool,
    /// Since the last sample, s.
    pub dt_s: f32,
    /// No finger's wrench is usable.
    pub blind: bool,
    /// The model carries the load that is measured.
    pub agrees: bool,
    /// The object touches the pusher.
    pub pushing: bool,
    /// Of each finger, by the model.
    pub slip: [Slip; 2],
    /// By the model, s.
    pub drop_in_s: Option<f32>,
    /// The pose shows slip; `None`: nobody sees the object.
    pub slips: Option<bool>,
    /// For how long the load has been over the limit, s.
    pub over_s: f32,
    /// Time until the load reaches the limit by a proven trend, s.
    pub limit_in_s: Option<f32>,
    /// It is the grip command that falls.
    pub by_grip: bool,
    /// The load has come down, or the grip to a commanded level that holds.
    pub eased: bool,
    /// The gripper gains or loses speed.
    pub steered: bool,
    /// Share of the friction limit that is used.
    pub used: f32,
    /// Time until the pads are off the object, at the slip that is seen, s.
    pub leaves_in_s: Option<f32>,
    /// One more slip as long as the last takes the pads off the object.
    pub next_is_last: bool,
    /// m.
    pub sag_m: f32,
    /// At the end of the horizon, m.
    pub sag_ahead_m: f32,
    /// rad.
    pub rotation_rad: f32,
}

/// A warning stays up for a while after its cause was last seen: one episode, one alarm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Warning {
    in_s: f32,
    left_s: f32,
}

impl Warning {
    /// Time left by what is seen now, or what is left of the last warning.
    fn hold(&mut self, seen: Option<f32>, dt_s: f32, held_s: f32) -> Option<f32> {
        match seen {
            Some(in_s) => *self = Self { in_s, left_s: held_s },
            None => self.left_s -= dt_s,
        }
        (self.left_s > 0.0).then_some(self.in_s)
    }
}

/// What the next tick must know of this one's alarms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Alarms {
    /// Samples in a row in which the model of a held grasp foresees slip and the measurement is with it.
    pub foreseen: u8,
    /// Samples in a row in which the look-ahead sees sag beyond its limit.
    pub sagging: u8,
    /// Slip of a held grasp.
    pub slip: Alarm,
    /// Its loss.
    pub drop: Warning,
    /// For how long slip still counts as intended after the plan has come to hold, s.
    pub meant_s: f32,
    /// For how long the pusher still counts as touched: pose noise opens a rigid contact for moments, s.
    pub touched_s: f32,
}

/// What is said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// Without [`flags::UNSURE`].
    pub flags: u32,
    /// Of each finger.
    pub slip: [Slip; 2],
    /// s.
    pub drop_in_s: Option<f32>,
}

/// Flags and figures of a tick, and the alarm state after it.
pub fn decide(e: &Evidence, before: &Alarms, limits: &Limits, params: &Params) -> (Verdict, Alarms) {
    let mut alarms = *before;
    alarms.meant_s = if e.moves { params.settling_s } else { before.meant_s - e.dt_s };
    if e.intent != Intent::Hold {
        // A warning of the hold before says nothing of the hold after.
        (alarms.slip, alarms.drop, alarms.foreseen) = (Alarm::default(), Warning::default(), 0);
    }
    alarms.touched_s = if e.pushing { params.settling_s } else { before.touched_s - e.dt_s };
    let (slip, drop_in_s) = match e.intent {
        Intent::Hold => held(e, &mut alarms, limits, params),
        // What is meant to move does where the pose shows it.
        _ if e.slips == Some(true) => ([Slip::Now; 2], e.drop_in_s),
        _ => (e.slip, e.drop_in_s),
    };
    let ahead = e.sag_ahead_m > limits.sag_m;
    alarms.sagging = counted(before.sagging, ahead);
    // There is, comes with a slip under way, or was foreseen for some samples in a row (a single
    // look-ahead may be older than a change of the motion).
    let sags = e.sag_m > limits.sag_m
        || ahead && (e.slips == Some(true) || alarms.sagging >= params.foreseen_samples);
    let turned = e.rotation_rad > limits.rotation_rad;
    // Slip is meant while the plan means motion, and foreseen slip where it will.
    let meant = alarms.meant_s > 0.0;
    let unmeant = slip.iter().any(|s| match s {
        Slip::None => false,
        Slip::In(_) => !meant && !e.moves_ahead,
        Slip::Now => !meant,
    });
    let unexpected = match e.intent {
        Intent::Hold => unmeant,
        Intent::Slide => sags || turned,
        Intent::Pivot => sags,
        Intent::Free => false,
    };
    let mut set = 0;
    let mut raise = |flag: u32, up: bool| set |= if up { flag } else { 0 };
    for (s, now, ahead) in
        [(slip[0], flags::SLIP_1, flags::SLIP_AHEAD_1), (slip[1], flags::SLIP_2, flags::SLIP_AHEAD_2)]
    {
        raise(now, s == Slip::Now);
        raise(ahead, matches!(s, Slip::In(_)));
    }
    raise(flags::SAG, sags && e.intent != Intent::Free);
    raise(flags::ROTATION, turned && matches!(e.intent, Intent::Hold | Intent::Slide));
    raise(flags::UNEXPECTED, unexpected);
    raise(flags::DROP, drop_in_s.is_some());
    raise(flags::PUSHING, e.pushing);
    (Verdict { flags: set, slip, drop_in_s }, alarms)
}

/// Slip and loss of a grasp that the plan means to hold.
fn held(e: &Evidence, alarms: &mut Alarms, limits: &Limits, params: &Params) -> ([Slip; 2], Option<f32>) {
    // Against a pusher at rest the rigid model's forces are statically undetermined (a push that
    // has ended leaves them at the limit): what it foresees there proves nothing.
    let believed = e.blind || e.agrees && !(alarms.touched_s > 0.0);
    let foresees = believed && e.slip.iter().any(|s| *s != Slip::None);
    alarms.foreseen = counted(alarms.foreseen, foresees);
    let within = |most_s: f32| e.limit_in_s.filter(|t| *t <= most_s);
    let by_forces = if e.by_grip { Cause::Grip } else { Cause::Load };
    let mut ahead = within(limits.slip_warning_s).map(|in_s| (by_forces, in_s));
    let mut drop = within(limits.drop_warning_s);
    let enough = if e.slips.is_some() { params.foreseen_samples } else { params.unseen_samples };
    let by_model = if e.steered { Cause::Inertia } else { Cause::Foresight };
    if alarms.foreseen >= enough && alarms.slip.is_new(by_model, e.used, params) {
        let in_s = e.slip.iter().filter_map(|s| s.in_s()).reduce(f32::min);
        if let Some(in_s) = in_s.filter(|t| !ahead.is_some_and(|(_, trend_s)| trend_s <= *t)) {
            ahead = Some((by_model, in_s));
        }
        drop = sooner(drop, e.drop_in_s);
    }
    let slips = match e.slips {
        Some(slips) => slips,
        None if e.blind => foresees,
        None => e.over_s > 0.0,
    };
    drop = sooner(drop, e.leaves_in_s);
    if e.next_is_last {
        drop = sooner(drop, Some(limits.drop_warning_s));
    }
    if e.slips.is_none() && slips && (e.blind || e.over_s > params.lasting_s) {
        // Nobody sees how fast it goes.
        drop = sooner(drop, Some(limits.horizon_s));
    }
    let over = match alarms.slip.state {
        State::Warned(Cause::Grip | Cause::Load) => e.eased,
        State::Warned(Cause::Inertia) => !e.steered && !foresees,
        _ => false,
    };
    alarms.slip = alarms.slip.next(
        &Signs {
            slides: slips.then_some(if e.slips.is_some() { Cause::Motion } else { Cause::Clipped }),
            ahead,
            suspects: foresees,
            over,
            seen: e.slips.is_some(),
            used: e.used,
            dt_s: e.dt_s,
        },
        params,
    );
    let drop = alarms.drop.hold(drop, e.dt_s, params.held_s);
    let slip = match alarms.slip.ahead_s() {
        _ if slips => Slip::Now,
        Some(t_s) => Slip::In(t_s.max(params.least_ahead_s)),
        None => Slip::None,
    };
    ([slip; 2], drop)
}

fn counted(before: u8, again: bool) -> u8 {
    if again { before.saturating_add(1) } else { 0 }
}

/// The earlier of two times, where there are any.
pub fn sooner(a: Option<f32>, b: Option<f32>) -> Option<f32> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.min(b)),
        _ => a.or(b),
    }
}
