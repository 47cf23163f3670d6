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
//! Noise makes `r` larger than it is; [`load`] takes that off.
//!
//! Constant errors of the sensors are taken off by what they show beyond the model's
//! wrenches while the rig is at rest at the start, within bounds.

pub mod bearing;
pub mod friction;
pub mod grip;
pub mod load;
pub mod motion;
pub mod params;
pub mod plateau;
pub mod shear;
pub mod trend;

pub use params::Params;

use crate::real::{Real, Vec3, clamp, max, min, norm};
use bearing::Bearing;
use friction::{Friction, Use};
use grip::Grip;
use load::LoadNoise;
use motion::{Forces, Motion, Moved};
use plateau::{Bars, Plateau};
use shear::Load;
use trend::Trend;

/// State of the observer.
#[derive(Clone, Debug)]
pub struct Observer<R: Real> {
    params: Params<R>,
    bias: [[R; 6]; 2],
    tared: u8,
    friction: Friction<R>,
    motion: Motion<R>,
    trend: Trend<R>,
    ratio: Option<R>,
    load_noise: LoadNoise<R>,
    plateau: Plateau<R>,
    /// The object slipped at the last sample, by its pose.
    slid: bool,
    /// Of slow ramps.
    ramp: Trend<R>,
    /// Ratio at which a trend's warning was raised that has not ended.
    threat: Option<R>,
    grip: Grip<R>,
    bearing: Bearing<R>,
    /// Samples in a row in which the fingers let the object fall and the pose does not show it.
    unseen: u8,
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
    /// It is the falling grip command that reaches it.
    pub by_grip: bool,
    /// What threatened to reach it has ended: the load has come down, or the grip to a commanded level that holds.
    pub eased: bool,
    /// For how long the load has been over the limit, or the fingers have no longer borne the
    /// object; zero in the first samples. Without a pose, that is slip.
    pub over_s: R,
    /// Motion by the pose.
    pub moved: Option<Moved<R>>,
    /// The fingers have let the object fall for a while, and the pose does not show it: one of the two is wrong, or late.
    pub unseen: bool,
}

impl<R: Real> Observer<R> {
    /// Knows what the model says: the fingers' friction coefficient.
    pub fn new(friction: R) -> Self {
        Self::with(friction, Params::default())
    }

    /// The same with other tuning than the default.
    pub fn with(friction: R, params: Params<R>) -> Self {
        Self::of(Friction::with(friction, params.friction), params)
    }

    fn of(friction: Friction<R>, params: Params<R>) -> Self {
        let zero = R::zero();
        let variance = params.noise * params.noise;
        Self {
            params,
            bias: [[zero; 6]; 2],
            tared: 0,
            friction,
            motion: Motion::new(params.motion, params.shear),
            trend: Trend::new(variance, params.trend),
            ramp: Trend::new(variance, params.ramp),
            threat: None,
            grip: Grip::new(params.grip),
            ratio: None,
            load_noise: LoadNoise::new(params.load),
            plateau: Plateau::new(params.plateau),
            slid: false,
            bearing: Bearing::new(params.bearing),
            unseen: 0,
        }
    }

    /// Friction coefficient of the fingers, estimated, without the model's effects.
    pub fn friction(&self) -> R {
        self.friction.estimate()
    }

    /// The least that it may be, in the same terms.
    pub fn least_friction(&self) -> R {
        self.friction.least()
    }

    /// The estimate as the model is to reckon with: more where more is held.
    pub fn assumed_friction(&self) -> R {
        self.friction.assumed()
    }

    /// Probability that there is a coefficient of `needed`, in terms of the model's (its effects taken off).
    pub fn probability_of(&self, needed: R) -> R {
        self.friction.probability_of(needed)
    }

    /// Probability that the friction suffices for `ahead_s`, by the load, its proven trend and the grip command; `effects`: see
    /// [`Seen::effects`]. `None`: no wrench was usable yet.
    pub fn holds(&self, effects: R, ahead_s: R) -> Option<R> {
        let ratio = self.ratio?;
        let enough = |needed: R| self.friction.probability_of(needed / factor(effects));
        if let Some(level) = self.grip.comes_to(ratio) {
            return Some(enough(level));
        }
        let mut least = enough(ratio);
        if let Some(falls_s) = self.grip.has_fallen_s() {
            least = min(least, if_it_goes_on(falls_s, ahead_s, |t| enough(self.grip.ratio_in(ratio, t))));
        }
        for trend in [&self.trend, &self.ramp] {
            if let Some(line) = trend.proven().filter(|l| l.slope_s > R::zero()) {
                let later = |t: R| enough(max(line.value + line.fitted_s * t, ratio));
                least = min(least, if_it_goes_on(trend.lasts_s(), ahead_s, later));
            }
        }
        Some(least)
    }

    /// Forgets what was learnt about friction.
    pub fn reset_friction(&mut self) {
        self.friction.reset();
    }

    /// Keeps the friction learnt, forgets the grasp.
    pub fn restarted(&self) -> Self {
        Self::of(self.friction.regrasped(), self.params)
    }

    /// The object's way so far says nothing of how it moves from now on.
    pub fn forget_motion(&mut self) {
        self.motion.forget();
    }

    /// Learns the constant error of the sensors while the rig rests: what `measured` shows
    /// beyond the model's `expected`. `true`: more than a constant error may be.
    pub fn tare(&mut self, measured: &[Option<[R; 6]>; 2], expected: &[[R; 6]; 2], at_rest: bool) -> bool {
        if self.tared >= self.params.tare_samples || !at_rest {
            self.tared = self.params.tare_samples;
            return false;
        }
        self.tared += 1;
        let share = R::one() / R::of(f64::from(self.tared));
        let mut beyond = false;
        for ((bias, w), e) in self.bias.iter_mut().zip(measured).zip(expected) {
            let Some(w) = w else { continue };
            for (i, ((b, x), e)) in bias.iter_mut().zip(w).zip(e).enumerate() {
                let bound = if i < 3 { self.params.tare_n } else { self.params.tare_nm };
                let error = *x - *e;
                beyond |= error.abs() > bound * self.params.tare_beyond;
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
        let effects = factor(s.effects);
        let mut seen = Observed {
            limit: self.friction.estimate() * effects,
            least_limit: self.friction.least() * effects,
            ..Observed::default()
        };
        let mut sum = [R::zero(); 4];
        for (r, w) in seen.finger.iter_mut().zip(s.wrenches) {
            let Some(w) = w else { continue };
            let parts = parts(w, s.arm_m);
            sum.iter_mut().zip(parts).for_each(|(sum, x)| *sum += x);
            *r = needed(&parts).map(|q| norm(&q));
        }
        let both = needed(&sum);
        let load = s.wrenches.iter().all(Option::is_some).then(|| {
            let [x, torsion, z, normal_n] = sum;
            // What the object exerts on the pads: it moves along with it.
            Load { force_n: -Vec3::new(x, torsion, z), normal_n, gripper_m_s: s.gripper_m_s }
        });
        self.grip.follow(s.grip_n, load.map(|l| l.normal_n), s.dt_s);
        // Before the tare a constant error may look like any load.
        let tared = self.tared >= self.params.tare_samples;
        let both = both.map(|q| self.load_noise.needed(&q, !tared)).filter(|_| tared);
        let now = both.map(|b| b.ratio);
        let fallen = self.bearing.falls(s.bearing_n, !tared, s.steered, s.dt_s);
        let falling = fallen > 0;
        // What was held is no limit: only more than that is slip.
        let noise = max(self.trend.noise(), both.map_or(R::zero(), |b| b.noise));
        let (proven, likely) = (self.friction.proven() * effects, self.friction.likely() * effects);
        let held = proven + noise * self.params.held_sigmas;
        let clipped = now.map_or(0, |now| {
            let risen = max(seen.limit * self.params.slipping_share - noise, held);
            // A grip that was commanded down lifts the ratio of any load: such a jump clips nothing.
            let by_grip = self.grip.comes_to(now).is_some();
            self.plateau.clipped(&Bars {
                now,
                level: self.friction.level() * effects,
                noise,
                held: proven,
                steered: s.steered,
                accelerates: s.accelerates,
                risen,
                jumped: if by_grip { risen } else { max(likely * min(s.sliding, R::one()), held) },
                sliding: s.sliding,
            })
        });
        seen.moved = match &s.points_m {
            Some(points) => {
                // A load that has been held is none that it slips under.
                let bar = max(likely * self.params.at_limit_share, proven + noise * self.params.borne_sigmas);
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
        let rests = seen.moved.is_some_and(|m| !(m.slip_s > R::zero()));
        self.unseen = if falling && rests { self.unseen.saturating_add(1) } else { 0 };
        seen.unseen = self.unseen >= self.params.unseen_samples;
        let Some(now) = now else { return seen };
        let smooth = self.ratio.map_or(now, |r| r + (now - r) * self.params.smoothing);
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
            noise: noise * self.params.smoothed_noise,
            slip_s: seen.moved.map(|m| m.slip_s),
            speed_m_s: seen.moved.map_or_else(R::zero, fastest),
            grip_holds: self.grip.holds(),
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
        let likely = self.friction.likely() * effects;
        self.foresee(&mut seen, smooth, likely);
        seen
    }

    /// Time until the ratio reaches the least limit by a proven trend, by what, and whether that has ended.
    fn foresee(&mut self, seen: &mut Observed<R>, ratio: R, likely: R) {
        let limit = seen.least_limit;
        let threat = self.threat;
        let by_load = self.time_left(ratio, limit, likely);
        seen.limit_in_s = by_load;
        // The level of a command is known the moment it is given.
        let held = self.level_holds(ratio, limit, likely);
        let near = ratio > limit * self.params.threat_share;
        if near
            && !held
            && let Some(t) = self.grip.runs_out(ratio, limit)
        {
            seen.by_grip = !by_load.is_some_and(|load| load < t);
            seen.limit_in_s = Some(by_load.map_or(t, |load| min(load, t)));
        }
        let came_down = threat.is_some_and(|at| !(ratio > at * self.params.ended_share));
        seen.eased = held || came_down && seen.limit_in_s.is_none();
    }

    /// The grip is on its way down to a commanded level that holds.
    fn level_holds(&self, ratio: R, limit: R, likely: R) -> bool {
        self.grip.comes_to(ratio).is_some_and(|end| end < max(limit, likely))
    }

    /// Time until the ratio reaches `limit` by the trend of the load.
    fn time_left(&mut self, ratio: R, limit: R, likely: R) -> Option<R> {
        if !(ratio > limit * self.params.threat_share) {
            self.threat = None;
            return None;
        }
        // No trend leads past the level of a command.
        if self.level_holds(ratio, limit, likely) {
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
            if t < self.params.threat_s && self.threat.is_none() {
                self.threat = Some(ratio);
            }
        } else if let Some(at) = self.threat {
            // What was announced and goes on, however slowly, is not withdrawn.
            if self.ramp.persists() && ratio > at * self.params.ended_share {
                left = Some(self.params.threat_s);
            } else {
                self.threat = None;
            }
        }
        left
    }
}

/// A factor on friction by which can be divided.
fn factor<R: Real>(effects: R) -> R {
    if effects > R::of(0.01) { effects } else { R::one() }
}

/// Parts into which the time ahead is divided.
const STOPS: u8 = 4;

/// Probability of something that ends well with `well(t)` if a course that has lasted for `lasted_s` stops `t` from now: it
/// lasts `t` longer with the probability `T / (T + t)` (Gott, Nature 363, 1993), and is looked at for `ahead_s`.
fn if_it_goes_on<R: Real>(lasted_s: R, ahead_s: R, well: impl Fn(R) -> R) -> R {
    let lasts = |t: R| lasted_s / (lasted_s + t);
    let part_s = ahead_s / R::of(f64::from(STOPS));
    let (mut sum, mut t) = (lasts(ahead_s) * well(ahead_s), R::zero());
    for _ in 0..STOPS {
        sum += (lasts(t) - lasts(t + part_s)) * well(t + part_s * R::of(0.5));
        t += part_s;
    }
    sum
}

/// What of a wrench loads the pad: force along X, torsion at its arm, force along Z, and the normal force, N.
fn parts<R: Real>([fx, fy, fz, _, ty, _]: &[R; 6], arm_m: R) -> [R; 4] {
    let torsion = if arm_m > R::zero() { *ty / arm_m } else { R::zero() };
    [*fx, torsion, *fz, fy.abs()]
}

/// Friction coefficient that such a load needs, with its direction; `None` without normal force.
// Once in the program, not once for each finger.
#[inline(never)]
fn needed<R: Real>([x, torsion, z, normal]: &[R; 4]) -> Option<Vec3<R>> {
    if !(*normal > R::of(0.02)) {
        return None;
    }
    let needed = Vec3::new(*x, *torsion, *z) / *normal;
    let size = norm(&needed);
    size.finite().then(|| needed * min(R::one(), R::of(100.0) / max(size, R::of(1e-3))))
}
