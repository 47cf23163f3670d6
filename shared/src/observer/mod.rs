//! What the measurement says of a grasp: share of the friction limit used, a proven trend
//! towards the limit, the friction coefficient itself, and motion seen in the pose.
//!
//! The ratio `r = |(F_x, F_z, tau_y / a)| / N` of both fingers together, with the arm `a` of
//! the patch's torsion, is the friction coefficient that the grasp needs (limit surface of
//! Howe and Cutkosky 1996). Being near the limit is a state, shown as utilisation. A slip
//! ahead needs a cause: `r` rises on a line whose slope is proven ([`trend`]), or the grip
//! command falls steadily, `r(t) = r N / (N + N' t)`, and either reaches the least
//! coefficient there may be ([`friction`]). A slip now is motion beyond noise ([`motion`]);
//! where the pose is not measured, a ratio above the coefficient for three samples, or fingers
//! that no longer bear the weight they bore.
//!
//! Constant errors of the sensors are taken off by what they show beyond the model's
//! wrenches while the rig is at rest at the start, within bounds.

pub mod friction;
pub mod motion;
pub mod trend;

use crate::real::{Length, Real, Vec3, clamp, least, most};
use friction::{Friction, Use};
use motion::{Motion, Moved};
use trend::Trend;

/// Samples of the tare: 0.13 s at 250 Hz.
const TARE_SAMPLES: u8 = 32;
/// Largest constant error that is taken off.
const TARE_N: f64 = 0.4;
const TARE_NM: f64 = 0.005;
/// Smoothing of the ratio that is shown.
const SMOOTHING: f64 = 0.3;
/// Samples over the limit in a row that are slip where no pose is measured.
const OVER_SAMPLES: u8 = 3;
/// Share of the estimated limit that counts as slip there.
const SLIPPING_SHARE: f64 = 0.98;
/// Samples in which a falling grip command becomes a trend.
const FALLING_SAMPLES: u8 = 15;
/// Below this share of the limit a trend is no threat yet, and mostly that of a lift-off.
const THREAT_SHARE: f64 = 0.5;
/// Samples in a row that show an object borne by less than its weight.
const FALLING_LOAD_SAMPLES: u8 = 3;
/// After so many it does not fall but rests elsewhere, or has been dropped.
const FALLEN_SAMPLES: u8 = 100;
/// What it is borne by then, as a share of what bore it; noise is taken off.
const BORNE_SHARE: f64 = 0.95;
/// The told weight is right if it is borne for a while within this share.
const WEIGHT_SHARE: f64 = 0.15;
/// Time constant of the mean force that bears the object.
const BORNE_S: f64 = 0.3;
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
    over: u8,
    grip_n: R,
    grip_trend_n_s: R,
    falling: u8,
    /// Mean of the force that bears the object, over the model's.
    borne: R,
    unborne: u8,
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
    /// Arm of torsion; 0: none.
    pub arm_m: R,
    /// Force that bears the object against gravity: measured, and by the model, N.
    pub bearing_n: Option<[R; 2]>,
    /// The planned motion is changing, and the load with it.
    pub steered: bool,
    /// What the model's effects make of the base coefficient, as a factor.
    pub effects: R,
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
            trend: Trend::new(R::of(NOISE * NOISE)),
            ratio: None,
            over: 0,
            grip_n: zero,
            grip_trend_n_s: zero,
            falling: 0,
            borne: zero,
            unborne: 0,
        }
    }

    /// Friction coefficient of the fingers, estimated, without the model's effects.
    pub fn friction(&self) -> R {
        self.friction.estimate()
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
        self.follow_grip(s.grip_n, s.dt_s);
        for (r, w) in seen.finger.iter_mut().zip(s.wrenches) {
            *r = w.as_ref().and_then(|w| ratio(&[w], s.arm_m));
        }
        let both = match s.wrenches {
            [Some(a), Some(b)] => ratio(&[a, b], s.arm_m),
            [Some(w), None] | [None, Some(w)] => ratio(&[w], s.arm_m),
            [None, None] => None,
        };
        // Before the tare a constant error may look like any load.
        let now = both.filter(|_| self.tared >= TARE_SAMPLES);
        let falling = now.is_some() && self.falls(s);
        seen.moved = match &s.points_m {
            Some(points) => Some(self.motion.follow(points, falling, s.dt_s)),
            None => {
                self.motion.forget();
                None
            }
        };
        let Some(now) = now else { return seen };
        let smooth = self.ratio.map_or(now, |r| r + (now - r) * R::of(SMOOTHING));
        self.ratio = Some(smooth);
        if s.steered {
            self.trend.forget();
        } else {
            self.trend.push(now, s.dt_s);
        }
        // What was held is no limit: only more than that is slip.
        let noise = self.trend.noise();
        let held = self.friction.proven() * effects + noise * R::of(3.0);
        let bound = most(seen.limit * R::of(SLIPPING_SHARE) - noise, held);
        let beyond = now > bound;
        self.over = if beyond { self.over.saturating_add(1) } else { 0 };
        let fastest = |m: Moved<R>| most(m.velocity_m_s[0].length(), m.velocity_m_s[1].length());
        let usage = Use {
            needed: smooth / effects,
            // The smoothed ratio's is 0.42 of a sample's.
            noise: self.trend.noise() * R::of(0.42),
            slip_s: seen.moved.map(|m| m.slip_s),
            speed_m_s: seen.moved.map_or_else(R::zero, fastest),
            grip_holds: self.falling == 0,
        };
        self.friction.learn(&usage, s.dt_s);
        seen.limit = self.friction.estimate() * effects;
        seen.least_limit = self.friction.least() * effects;
        seen.ratio = Some(smooth);
        let over = most(R::of(f64::from(self.over)), R::of(f64::from(self.unborne)));
        seen.over_s = if self.over >= OVER_SAMPLES || falling { over * s.dt_s } else { R::zero() };
        seen.limit_in_s = self.time_left(smooth, seen.least_limit);
        seen
    }

    /// The fingers bear less than the weight that they bore: the object falls (Newton). Only
    /// where the told weight has proven right, and what the model expects is borne no more.
    fn falls(&mut self, s: &Seen<R>) -> bool {
        let Some([measured, model]) = s.bearing_n else {
            self.unborne = 0;
            return false;
        };
        if !(model > R::of(0.2)) {
            (self.borne, self.unborne) = (R::zero(), 0);
            return false;
        }
        let share = measured / model;
        let noise = self.trend.noise() * s.grip_n.abs() * R::of(2.0) / model;
        let less = least(self.borne, R::one()) * R::of(BORNE_SHARE) - noise * R::of(3.0);
        let right = (self.borne - R::one()).abs() < R::of(WEIGHT_SHARE);
        if right && share < less && !s.steered && self.unborne < FALLEN_SAMPLES {
            self.unborne += 1;
        } else {
            self.unborne = 0;
            self.borne += (share - self.borne) * least(s.dt_s / R::of(BORNE_S), R::one());
        }
        self.unborne >= FALLING_LOAD_SAMPLES
    }

    fn follow_grip(&mut self, grip_n: R, dt_s: R) {
        if self.grip_n > R::zero() {
            let rate = (grip_n - self.grip_n) / dt_s;
            self.grip_trend_n_s += (rate - self.grip_trend_n_s) * R::of(0.15);
            let falls = rate < R::of(-0.05);
            self.falling = if falls { self.falling.saturating_add(1).min(FALLING_SAMPLES) } else { 0 };
        }
        self.grip_n = grip_n;
    }

    /// Time until the ratio reaches `limit` by a proven trend.
    fn time_left(&self, ratio: R, limit: R) -> Option<R> {
        if !(ratio > limit * R::of(THREAT_SHARE)) {
            return None;
        }
        let mut left: Option<R> = None;
        let mut sooner = |t: R| left = Some(left.map_or(t, |l| least(l, t)));
        if let Some(line) = self.trend.proven()
            && line.slope_s > R::zero()
        {
            sooner(most((limit - line.value) / line.slope_s, R::zero()));
        }
        if self.falling >= FALLING_SAMPLES && self.grip_trend_n_s < R::zero() {
            let lasts = self.grip_n / -self.grip_trend_n_s;
            sooner(most(lasts * (R::one() - ratio / limit), R::zero()));
        }
        left
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
    let needed = (x * x + z * z + torsion * torsion).root() / normal;
    needed.finite().then_some(least(needed, R::of(100.0)))
}
