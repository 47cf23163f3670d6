//! What the measurement says of a grasp: share of the friction limit used, a proven trend
//! towards the limit, the friction coefficient itself, and motion seen in the pose.
//!
//! The ratio `r = |(F_x, F_z, tau_y / a)| / N` of both fingers together, with the arm `a` of
//! the patch's torsion, is the friction coefficient that the grasp needs (limit surface of
//! Howe and Cutkosky 1996). Being near the limit is a state, shown as utilisation. A slip
//! ahead needs a cause: `r` rises on a line whose slope is proven ([`trend`]), or the grip
//! command falls steadily, `r(t) = r N / (N + N' t)`, and either reaches the least
//! coefficient there may be ([`friction`]). A slip now is motion beyond noise ([`motion`]);
//! where the pose is not measured, it is a ratio that is clipped at the coefficient
//! ([`plateau`]), or fingers that no longer bear the weight they bore.
//!
//! Constant errors of the sensors are taken off by what they show beyond the model's
//! wrenches while the rig is at rest at the start, within bounds.

pub mod bearing;
pub mod friction;
pub mod motion;
pub mod plateau;
pub mod shear;
pub mod trend;

use crate::real::{Real, Vec3, clamp, max, min, norm, sqrt};
use bearing::Bearing;
use friction::{Friction, Use};
use motion::{Forces, Motion, Moved};
use plateau::{Bars, Plateau};
use shear::Load;
use trend::Trend;

/// Samples of the tare: 0.13 s at 250 Hz.
const TARE_SAMPLES: u8 = 32;
/// Largest constant error that is taken off.
const TARE_N: f64 = 0.4;
const TARE_NM: f64 = 0.005;
/// Smoothing of the ratio that is shown.
const SMOOTHING: f64 = 0.3;
/// Share of the estimated limit that counts as slip there.
const SLIPPING_SHARE: f64 = 0.98;
/// Share of the least limit from which less motion is slip.
const AT_LIMIT_SHARE: f64 = 0.9;
/// Samples in which a falling grip command becomes a trend.
const FALLING_SAMPLES: u8 = 15;
/// Below this share of the limit a trend is no threat yet, and mostly that of a lift-off.
const THREAT_SHARE: f64 = 0.5;
/// A trend that reaches the limit within this is a threat, s; it has ended where the ratio is below
/// this share of what it was then.
const THREAT_S: f64 = 0.25;
const ENDED_SHARE: f64 = 0.97;
/// The slowest jaw has followed a step of its command after this, s.
const SETTLED_S: f64 = 1.0;
/// A commanded fall shorter than this is a re-grasp, s: it is judged by its level, not by its slope.
const REGRASP_S: f64 = 0.12;
/// A grip command that falls is extrapolated by this share of the time for which it has fallen.
const GOES_ON: f64 = 1.0;
/// First guess of the ratio's noise, standard deviation.
const NOISE: f64 = 0.005;

/// State of the observer.
#[derive(Clone, Debug)]
pub struct Observer<R: Real> {
    bias: [[R; 6]; 2],
    tared: u8,
    friction: Friction<R>,
    motion: Motion<R>,
    trend: Trend<R>,
    ratio: Option<R>,
    plateau: Plateau<R>,
    /// The object slipped at the last sample, by its pose.
    slid: bool,
    /// Of slow ramps.
    ramp: Trend<R>,
    /// Ratio at which a trend's warning was raised that has not ended.
    threat: Option<R>,
    grip: Grip<R>,
    bearing: Bearing<R>,
}

/// What one sample is.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a, R: Real> {
    /// Wrenches without constant errors; `None`: not usable.
    pub wrenches: &'a [Option<[R; 6]>; 2],
    /// Grip command.
    pub grip_n: R,
    /// Material points of the object under the fingers: X, turn at the arm, Z, m.
    pub points_m: Option<[Vec3<R>; 2]>,
    /// Velocity of the gripper, its axes, m/s.
    pub gripper_m_s: Vec3<R>,
    /// Arm of torsion; 0: none.
    pub arm_m: R,
    /// Force that bears the object against gravity: measured, and by the model, N.
    pub bearing_n: Option<[R; 2]>,
    /// The planned motion is changing, and the load with it.
    pub steered: bool,
    /// The gripper gains or loses speed by the plan.
    pub accelerates: bool,
    /// What the model's effects make of the base coefficient, as a factor.
    pub effects: R,
    /// Friction while sliding over that at rest, by the model's effects.
    pub sliding: R,
    /// Since the last sample.
    pub dt_s: R,
}

/// What it says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observed<R: Real> {
    /// Coefficient that each finger alone needs, where its wrench is usable.
    pub finger: [Option<R>; 2],
    /// Coefficient that the grasp needs, smoothed; `None`: no usable wrench.
    pub ratio: Option<R>,
    /// Coefficient there is, and the least it may be, effects included.
    pub limit: R,
    /// See `limit`.
    pub least_limit: R,
    /// Time until the limit is reached by a proven trend; `None`: there is none.
    pub limit_in_s: Option<R>,
    /// For how long the load has been over the limit, or the fingers have no longer borne the
    /// object; zero in the first samples. Without a pose, that is slip.
    pub over_s: R,
    /// Motion by the pose.
    pub moved: Option<Moved<R>>,
}

impl<R: Real> Observer<R> {
    /// Knows what the model says: the fingers' friction coefficient.
    pub fn new(friction: R) -> Self {
        Self::with(Friction::new(friction))
    }

    fn with(friction: Friction<R>) -> Self {
        let zero = R::zero();
        Self {
            bias: [[zero; 6]; 2],
            tared: 0,
            friction,
            motion: Motion::default(),
            trend: Trend::new(R::of(NOISE * NOISE), trend::SHORT),
            ramp: Trend::new(R::of(NOISE * NOISE), trend::LONG),
            threat: None,
            grip: Grip::default(),
            ratio: None,
            plateau: Plateau::default(),
            slid: false,
            bearing: Bearing::default(),
        }
    }

    /// Friction coefficient of the fingers, estimated, without the model's effects.
    pub fn friction(&self) -> R {
        self.friction.estimate()
    }

    /// The same as the model is to reckon with: more where more is held.
    pub fn assumed_friction(&self) -> R {
        self.friction.assumed()
    }

    /// Forgets what was learnt about friction.
    pub fn reset_friction(&mut self) {
        self.friction.reset();
    }

    /// Keeps the friction learnt, forgets the grasp.
    pub fn restarted(&self) -> Self {
        Self::with(self.friction.regrasped())
    }

    /// Learns the constant error of the sensors while the rig rests: what `measured` shows
    /// beyond the model's `expected`. `true`: more than a constant error may be.
    pub fn tare(&mut self, measured: &[Option<[R; 6]>; 2], expected: &[[R; 6]; 2], at_rest: bool) -> bool {
        if self.tared >= TARE_SAMPLES || !at_rest {
            self.tared = TARE_SAMPLES;
            return false;
        }
        self.tared += 1;
        let share = R::one() / R::of(f64::from(self.tared));
        let mut beyond = false;
        for ((bias, w), e) in self.bias.iter_mut().zip(measured).zip(expected) {
            let Some(w) = w else { continue };
            for (i, ((b, x), e)) in bias.iter_mut().zip(w).zip(e).enumerate() {
                let bound = R::of(if i < 3 { TARE_N } else { TARE_NM });
                let error = *x - *e;
                // Noise may exceed the bound; three times the bound is no constant error.
                beyond |= error.abs() > bound * R::of(3.0);
                *b = clamp(*b + (error - *b) * share, -bound, bound);
            }
        }
        beyond
    }

    /// Takes the constant error off.
    pub fn corrected(&self, measured: &[Option<[R; 6]>; 2]) -> [Option<[R; 6]>; 2] {
        let mut out = *measured;
        for (w, bias) in out.iter_mut().zip(&self.bias) {
            if let Some(w) = w {
                w.iter_mut().zip(bias).for_each(|(x, b)| *x -= *b);
            }
        }
        out
    }

    /// One sample.
    pub fn observe(&mut self, s: &Seen<R>) -> Observed<R> {
        let effects = if s.effects > R::of(0.01) { s.effects } else { R::one() };
        let mut seen = Observed {
            limit: self.friction.estimate() * effects,
            least_limit: self.friction.least() * effects,
            ..Observed::default()
        };
        for (r, w) in seen.finger.iter_mut().zip(s.wrenches) {
            *r = w.as_ref().and_then(|w| ratio(&[w], s.arm_m));
        }
        let both = match s.wrenches {
            [Some(a), Some(b)] => ratio(&[a, b], s.arm_m),
            [Some(w), None] | [None, Some(w)] => ratio(&[w], s.arm_m),
            [None, None] => None,
        };
        let load = match s.wrenches {
            [Some(a), Some(b)] => Some(load(a, b, s.arm_m, s.gripper_m_s)),
            _ => None,
        };
        self.grip.follow(s.grip_n, load.map(|l| l.normal_n), s.dt_s);
        // Before the tare a constant error may look like any load.
        let now = both.filter(|_| self.tared >= TARE_SAMPLES);
        let bears = s.bearing_n.filter(|_| now.is_some());
        let fallen = self.bearing.falls(bears, s.steered, s.dt_s);
        let falling = fallen > 0;
        // What was held is no limit: only more than that is slip.
        let noise = self.trend.noise();
        let (proven, likely) = (self.friction.proven() * effects, self.friction.likely() * effects);
        let held = proven + noise * R::of(3.0);
        let clipped = now.map_or(0, |now| {
            self.plateau.clipped(&Bars {
                now,
                level: self.friction.level() * effects,
                noise,
                held: proven,
                steered: s.steered,
                accelerates: s.accelerates,
                risen: max(seen.limit * R::of(SLIPPING_SHARE) - noise, held),
                jumped: max(likely * min(s.sliding, R::one()), held),
                sliding: s.sliding,
            })
        });
        seen.moved = match &s.points_m {
            Some(points) => {
                // A load that has been held is none that it slips under.
                let bar = max(likely * R::of(AT_LIMIT_SHARE), proven + noise * R::of(2.0));
                let forces = if falling || clipped > 0 {
                    Forces::Fall
                } else if now.is_some_and(|r| r > bar) || self.bearing.suspect() {
                    Forces::AtLimit
                } else {
                    Forces::Hold
                };
                Some(self.motion.follow(points, load.as_ref(), forces, s.dt_s))
            }
            None => self.motion.wait(s.dt_s),
        };
        let Some(now) = now else { return seen };
        let smooth = self.ratio.map_or(now, |r| r + (now - r) * R::of(SMOOTHING));
        self.ratio = Some(smooth);
        if s.steered {
            self.trend.forget();
            self.ramp.forget();
            self.threat = None;
        } else {
            self.trend.push(now, s.dt_s);
            self.ramp.push(now, s.dt_s);
        }
        // Only where nobody sees what the object does.
        if let (Some(ceiling), true) = (self.plateau.ceiling(), seen.moved.is_none()) {
            self.friction.cap(ceiling / effects);
        }
        let fastest = |m: Moved<R>| max(norm(&m.velocity_m_s[0]), norm(&m.velocity_m_s[1]));
        let usage = Use {
            needed: smooth / effects,
            // The smoothed ratio's is 0.42 of a sample's.
            noise: self.trend.noise() * R::of(0.42),
            slip_s: seen.moved.map(|m| m.slip_s),
            speed_m_s: seen.moved.map_or_else(R::zero, fastest),
            grip_holds: self.grip.falling == 0,
            steered: s.steered,
        };
        self.friction.learn(&usage, s.dt_s);
        // Pads on which it has come to rest bear what they bear now, however near the limit.
        let slides = seen.moved.is_some_and(|m| m.slip_s > R::zero());
        if slides {
            self.plateau.slides();
        } else if self.slid && seen.moved.is_some() {
            self.plateau.bears(smooth);
        }
        self.slid = slides;
        seen.limit = self.friction.estimate() * effects;
        seen.least_limit = self.friction.least() * effects;
        seen.ratio = Some(smooth);
        let over = clipped.max(fallen);
        seen.over_s = R::of(f64::from(over)) * s.dt_s;
        seen.limit_in_s = self.time_left(smooth, seen.least_limit, self.friction.likely() * effects);
        seen
    }

    /// Time until the ratio reaches `limit` by a proven trend.
    fn time_left(&mut self, ratio: R, limit: R, likely: R) -> Option<R> {
        if !(ratio > limit * R::of(THREAT_SHARE)) {
            self.threat = None;
            return None;
        }
        // The level of a command is known the moment it is given: no trend leads past it.
        if self.grip.comes_to(ratio).is_some_and(|end| end < max(limit, likely)) {
            self.threat = None;
            return None;
        }
        let mut left: Option<R> = None;
        let earlier = |left: Option<R>, t: R| Some(left.map_or(t, |l| min(l, t)));
        for line in [self.trend.proven(), self.ramp.proven()].into_iter().flatten() {
            if line.slope_s > R::zero() {
                left = earlier(left, max((limit - line.value) / line.slope_s, R::zero()));
            }
        }
        if let Some(t) = left {
            if t < R::of(THREAT_S) && self.threat.is_none() {
                self.threat = Some(ratio);
            }
        } else if let Some(at) = self.threat {
            // What was announced and goes on, however slowly, is not withdrawn.
            if self.ramp.persists() && ratio > at * R::of(ENDED_SHARE) {
                left = Some(R::of(THREAT_S));
            } else {
                self.threat = None;
            }
        }
        if let Some(t) = self.grip.runs_out(ratio, limit) {
            left = earlier(left, t);
        }
        left
    }
}

/// The grip command, and the normal force that it leads to.
#[derive(Clone, Debug)]
struct Grip<R: Real> {
    command_n: R,
    trend_n_s: R,
    falling: u8,
    falls_s: R,
    /// Since the command last fell, and since it last changed, s.
    fell_s: R,
    changed_s: R,
    /// Normal force now, and over the command where that has settled.
    normal_n: R,
    gain: R,
}

impl<R: Real> Default for Grip<R> {
    fn default() -> Self {
        let (zero, long) = (R::zero(), R::of(10.0));
        Self {
            command_n: zero,
            trend_n_s: zero,
            falling: 0,
            falls_s: zero,
            fell_s: long,
            changed_s: long,
            normal_n: zero,
            // Two fingers.
            gain: R::of(2.0),
        }
    }
}

impl<R: Real> Grip<R> {
    fn follow(&mut self, command_n: R, normal_n: Option<R>, dt_s: R) {
        self.fell_s += dt_s;
        self.changed_s += dt_s;
        if self.command_n > R::zero() {
            let rate = (command_n - self.command_n) / dt_s;
            self.trend_n_s += (rate - self.trend_n_s) * R::of(0.15);
            let falls = rate < R::of(-0.05);
            self.falling = if falls { self.falling.saturating_add(1).min(FALLING_SAMPLES) } else { 0 };
            self.falls_s = if falls { self.falls_s + dt_s } else { R::zero() };
            if falls {
                self.fell_s = R::zero();
            }
            if rate.abs() > R::of(0.05) {
                self.changed_s = R::zero();
            }
        }
        self.command_n = command_n;
        let Some(normal_n) = normal_n else { return };
        self.normal_n += (normal_n - self.normal_n) * R::of(SMOOTHING);
        if self.changed_s > R::of(SETTLED_S) && command_n > R::of(0.05) {
            let gain = self.normal_n / command_n;
            let share = min(dt_s / R::of(SETTLED_S), R::one());
            self.gain += (gain - self.gain) * share;
        }
    }

    /// The ratio that the command leads to, while the normal force is still on its way down to it.
    fn comes_to(&self, ratio: R) -> Option<R> {
        let on_its_way = self.falls_s < R::of(REGRASP_S) && self.fell_s < R::of(SETTLED_S);
        let settled_n = self.gain * self.command_n;
        (on_its_way && settled_n > R::of(0.02)).then(|| ratio * max(self.normal_n / settled_n, R::one()))
    }

    /// Time until a grip command that falls steadily is too little.
    fn runs_out(&self, ratio: R, limit: R) -> Option<R> {
        let falls = self.falls_s >= R::of(REGRASP_S) && self.trend_n_s < R::zero();
        let lasts = self.command_n / -min(self.trend_n_s, R::of(-1e-6));
        let left_s = max(lasts * (R::one() - ratio / limit), R::zero());
        // A fall that has lasted for so long may last as long again: a re-grasp ends sooner.
        (falls && left_s < self.falls_s * R::of(GOES_ON)).then_some(left_s)
    }
}

/// Needed friction coefficient of some fingers' wrenches together; `None` without normal force.
fn ratio<R: Real>(wrenches: &[&[R; 6]], arm_m: R) -> Option<R> {
    let (mut x, mut z, mut turn, mut normal) = (R::zero(), R::zero(), R::zero(), R::zero());
    for [fx, fy, fz, _, ty, _] in wrenches.iter().copied() {
        x += *fx;
        z += *fz;
        turn += *ty;
        normal += fy.abs();
    }
    if !(normal > R::of(0.02)) {
        return None;
    }
    let torsion = if arm_m > R::zero() { turn / arm_m } else { R::zero() };
    let needed = sqrt(x * x + z * z + torsion * torsion) / normal;
    needed.finite().then_some(min(needed, R::of(100.0)))
}

/// Load of both fingers.
fn load<R: Real>(a: &[R; 6], b: &[R; 6], arm_m: R, gripper_m_s: Vec3<R>) -> Load<R> {
    let torsion = if arm_m > R::zero() { (a[4] + b[4]) / arm_m } else { R::zero() };
    Load {
        // What the object exerts on the pads: it moves along with it.
        force_n: -Vec3::new(a[0] + b[0], torsion, a[2] + b[2]),
        normal_n: a[1].abs() + b[1].abs(),
        gripper_m_s,
    }
}

/// Puts `newest` first and drops the last.
// By swaps: `rotate_right` alone would bring 1.5 KB of `memmove`.
fn shift_in<T>(list: &mut [T], mut newest: T) {
    list.iter_mut().for_each(|item| core::mem::swap(item, &mut newest));
}
