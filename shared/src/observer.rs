//! What the measurement says of friction: share of the limit used, its trend, the time left,
//! the friction coefficient itself, and slip seen in the object's pose.
//!
//! The ratio `r = |(F_x, F_z, tau_y / a)| / N` of both fingers together, with the arm `a` of
//! the patch's torsion, is the friction coefficient that the grasp needs (limit surface of
//! Howe and Cutkosky 1996). An alpha-beta tracker follows it; what leaves the tracker's
//! noise is a step, taken over at once without bending the trend. The grasp lasts as long
//! as `r` stays below the coefficient there is: `r` is extrapolated by its own trend and by
//! that of the grip command, `r(t) = r N / (N + N' t)`.
//!
//! The coefficient is the model's until the rig tells more: what is held for a while
//! without slip is there (a near slip raises the estimate), what is used while the object
//! slides is all there is (a slip sets it). Both slowly, within bounds, and it fades back.
//!
//! Constant errors of the sensors are taken off by what they show beyond the model's
//! wrenches while the rig is at rest at the start, within bounds.

use crate::real::{Real, Vec3, clamp, least, most};

/// Samples of the tare: 0.13 s at 250 Hz.
const TARE_SAMPLES: u8 = 32;
/// Largest constant error that is taken off.
const TARE_N: f64 = 0.4;
const TARE_NM: f64 = 0.005;
/// Gains of the tracker of the ratio.
const ALPHA: f64 = 0.15;
const BETA: f64 = 0.006;
/// A departure beyond this many standard deviations is a step.
const STEP_SIGMAS: f64 = 5.0;
/// Relative uncertainty of the model's friction, and of one learnt from a slip.
const SPREAD_TOLD: f64 = 0.15;
const SPREAD_LEARNT: f64 = 0.06;
/// Bounds of the estimate relative to the model's coefficient.
const LEAST_SHARE: f64 = 0.2;
const MOST_SHARE: f64 = 2.0;
/// What was learnt fades with this time constant.
const FADE_S: f64 = 60.0;
/// Anchor of the pose: slip is a departure from its slow mean.
const ANCHOR_S: f64 = 0.2;
const SLIPPED_M: f64 = 1.5e-4;
/// Samples in which a step settles.
const SETTLING: u8 = 4;
/// Slow mean of the ratio, and how near it the ratio of a steady load stays.
const LEVEL_S: f64 = 0.5;
const LEVEL_SHARE: f64 = 0.02;
/// Load that lasts, for the loss of the grasp: knocks of some 40 ms do not count.
const LASTING_S: f64 = 0.08;
/// A slip this old and this fast ends in a drop unless something is done.
const RUNNING_S: f64 = 0.03;
const RUNNING_M_S: f64 = 0.015;
/// Friction is learnt from slip faster than this.
const MOVING_M_S: f64 = 0.005;

/// State of the observer.
#[derive(Clone, Debug)]
pub struct Observer<R: Real> {
    bias: [[R; 6]; 2],
    tared: u8,
    ratio: R,
    trend_s: R,
    variance: R,
    lasting: R,
    started: bool,
    grip_n: R,
    grip_trend_n_s: R,
    told: R,
    friction: R,
    learnt: bool,
    steady_s: R,
    /// Samples after a step that are still taken over quickly.
    settling: u8,
    /// Ratio that was held without slip: that much friction there is.
    proven: R,
    /// Slow mean of the ratio; where the ratio stays with it, the load is steady.
    level: R,
    /// Highest ratio of the present knock.
    peak: R,
    path: Option<[Vec3<R>; 2]>,
    anchor: [Vec3<R>; 2],
    slip_s: R,
    /// Smoothed velocity of the faster finger's point.
    speed_m_s: Vec3<R>,
}

/// What one sample says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observed<R: Real> {
    /// Ratio of each finger alone, where its wrench is usable.
    pub finger: [Option<R>; 2],
    /// Tracked ratio of the grasp; `None`: no usable wrench.
    pub ratio: Option<R>,
    /// Time until the ratio reaches the least friction there may be; `None`: not in sight.
    pub limit_in_s: Option<R>,
    /// The same for the load that lasts.
    pub lasting_limit_in_s: Option<R>,
    /// Slip velocity of each finger by the pose, X and Z (m/s) and the turn at its arm.
    pub slip_m_s: Option<[Vec3<R>; 2]>,
    /// The object has been slipping for a while, is not slow and does not slow down by itself.
    pub running: bool,
}

impl<R: Real> Observer<R> {
    /// Knows what the model says: the fingers' friction coefficient.
    pub fn new(friction: R) -> Self {
        let zero = R::zero();
        Self {
            bias: [[zero; 6]; 2],
            tared: 0,
            ratio: zero,
            trend_s: zero,
            variance: R::of(1e-4),
            lasting: zero,
            started: false,
            grip_n: zero,
            grip_trend_n_s: zero,
            told: friction,
            friction,
            learnt: false,
            steady_s: zero,
            settling: 0,
            proven: zero,
            level: zero,
            peak: zero,
            path: None,
            anchor: [Vec3::zeros(); 2],
            slip_s: zero,
            speed_m_s: Vec3::zeros(),
        }
    }

    /// Friction coefficient of the fingers, estimated.
    pub fn friction(&self) -> R {
        self.friction
    }

    /// The least that it may be.
    pub fn least_friction(&self) -> R {
        let spread = if self.learnt { SPREAD_LEARNT } else { SPREAD_TOLD };
        most(self.friction * R::of(1.0 - spread), self.proven)
    }

    /// Forgets what was learnt about friction.
    pub fn reset_friction(&mut self) {
        self.friction = self.told;
        self.learnt = false;
    }

    /// Keeps the friction learnt, forgets the grasp.
    pub fn restarted(&self) -> Self {
        Self { friction: self.friction, learnt: self.learnt, ..Self::new(self.told) }
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

    /// One sample: corrected wrenches, grip command, pose of the material points under the
    /// fingers (see [`Observed::slip_m_s`]), arm of torsion (0: none), all over `dt_s`.
    pub fn observe(
        &mut self,
        wrenches: &[Option<[R; 6]>; 2],
        grip_n: R,
        points_m: Option<[Vec3<R>; 2]>,
        arm_m: R,
        dt_s: R,
    ) -> Observed<R> {
        let mut seen = Observed { slip_m_s: self.slip(points_m, dt_s), ..Observed::default() };
        seen.running = self.slip_s > R::of(RUNNING_S)
            && self.speed_m_s.norm_squared() > R::of(RUNNING_M_S * RUNNING_M_S);
        self.follow_grip(grip_n, dt_s);
        for (r, w) in seen.finger.iter_mut().zip(wrenches) {
            *r = w.as_ref().and_then(|w| ratio(&[w], arm_m)).map(|[needed, _]| needed);
        }
        let both = match wrenches {
            [Some(a), Some(b)] => ratio(&[a, b], arm_m),
            [Some(w), None] | [None, Some(w)] => ratio(&[w], arm_m),
            [None, None] => None,
        };
        // Before the tare a constant error may look like any load.
        if let Some([r, force]) = both.filter(|_| self.tared >= TARE_SAMPLES) {
            self.track(r, dt_s);
            // An object is dropped by force; torsion turns it.
            self.lasting +=
                (least(force, self.ratio) - self.lasting) * least(dt_s / R::of(LASTING_S), R::one());
            self.learn(dt_s, points_m.is_some());
            seen.ratio = Some(self.ratio);
            seen.limit_in_s = self.time_left(self.ratio);
            seen.lasting_limit_in_s = self.time_left(self.lasting);
        }
        seen
    }

    fn follow_grip(&mut self, grip_n: R, dt_s: R) {
        if self.grip_n > R::zero() {
            let rate = (grip_n - self.grip_n) / dt_s;
            self.grip_trend_n_s += (rate - self.grip_trend_n_s) * R::of(0.15);
        }
        self.grip_n = grip_n;
    }

    fn track(&mut self, r: R, dt_s: R) {
        if !self.started {
            self.started = true;
            self.ratio = r;
            self.lasting = r;
            return;
        }
        let ahead = self.ratio + self.trend_s * dt_s;
        let miss = r - ahead;
        let gate = most(self.variance.root() * R::of(STEP_SIGMAS), R::of(0.015));
        if miss.abs() > gate {
            self.ratio = ahead + miss * R::of(0.9);
            self.trend_s *= R::of(0.7);
            self.steady_s = R::zero();
            self.settling = SETTLING;
        } else if self.settling > 0 {
            self.settling -= 1;
            self.ratio = ahead + miss * R::of(0.4);
        } else {
            self.ratio = ahead + miss * R::of(ALPHA);
            self.trend_s += miss * R::of(BETA) / dt_s;
            self.variance += (miss * miss - self.variance) * R::of(0.02);
            self.steady_s += dt_s;
        }
    }

    /// Time until `from` reaches the least friction by either trend.
    fn time_left(&self, from: R) -> Option<R> {
        let limit = self.least_friction();
        if from >= limit {
            return Some(R::zero());
        }
        let mut left: Option<R> = None;
        let mut sooner = |t: R| left = Some(left.map_or(t, |l| least(l, t)));
        // Below half the limit a trend is no threat yet, and mostly that of a lift-off.
        if from > limit * R::of(0.5) {
            // The tracker's trend errs by about its noise times beta over dt (4 ms).
            let noise = self.variance.root() * R::of(2.0 * BETA / 0.004);
            let sure = self.trend_s - noise;
            if sure > R::of(1e-3) && self.steady_s > R::of(0.06) {
                sooner((limit - from) / sure);
            }
            if self.grip_trend_n_s < R::of(-0.05) && self.grip_n > R::zero() {
                let lasts = self.grip_n / -self.grip_trend_n_s;
                sooner(lasts * (R::one() - from / limit));
            }
        }
        left
    }

    fn learn(&mut self, dt_s: R, pose_seen: bool) {
        let told = self.told;
        let bounded = |x: R| clamp(x, told * R::of(LEAST_SHARE), told * R::of(MOST_SHARE));
        // A slip that is over still is a departure from the slow mean, and uses less.
        let moving = self.speed_m_s.norm_squared() > R::of(MOVING_M_S * MOVING_M_S);
        if self.slip_s > R::of(0.012) && moving {
            // Sliding uses all the friction there is.
            let gain = R::of(if self.learnt { 0.05 } else { 0.2 });
            self.friction = bounded(self.friction + (self.ratio - self.friction) * gain);
            self.learnt = self.slip_s > R::of(0.04) || self.learnt;
            self.proven = R::zero();
            self.peak = R::zero();
            return;
        }
        self.friction += (told - self.friction) * (dt_s / R::of(FADE_S));
        self.proven -= self.proven * (dt_s / R::of(FADE_S));
        self.level += (self.ratio - self.level) * least(dt_s / R::of(LEVEL_S), R::one());
        let steady = (self.ratio - self.level).abs() < self.level * R::of(LEVEL_SHARE)
            && self.steady_s > R::of(0.3)
            && self.grip_trend_n_s > R::of(-0.05);
        // Even a knock that was withstood counts, where the pose shows that nothing slipped.
        self.peak = most(self.peak, self.ratio);
        let withstood = pose_seen && self.slip_s == R::zero() && self.ratio < self.peak * R::of(0.8);
        if withstood || self.ratio < self.level * R::of(0.5) {
            let shown = self.peak * R::of(0.97);
            self.proven = if withstood { most(self.proven, bounded(shown)) } else { self.proven };
            self.peak = self.ratio;
        } else if steady && self.slip_s == R::zero() {
            self.proven = most(
                self.proven,
                bounded(self.ratio * R::of(1.0 + LEVEL_SHARE) + self.variance.root() * R::of(1.2)),
            );
            self.peak = self.ratio;
        }
        self.friction = most(self.friction, self.proven);
    }

    /// Departure of the points from their slow mean: slip velocity, zero while sticking.
    fn slip(&mut self, points_m: Option<[Vec3<R>; 2]>, dt_s: R) -> Option<[Vec3<R>; 2]> {
        let Some(points) = points_m else {
            self.path = None;
            self.slip_s = R::zero();
            return None;
        };
        let Some(mut path) = self.path else {
            self.path = Some(points);
            self.anchor = points;
            return Some([Vec3::zeros(); 2]);
        };
        let mut speed = [Vec3::zeros(); 2];
        let mut any = false;
        let mut fastest = Vec3::zeros();
        let share = least(dt_s / R::of(ANCHOR_S), R::one());
        for (((q, a), p), v) in path.iter_mut().zip(&mut self.anchor).zip(&points).zip(&mut speed) {
            let step = (p - *q) * R::of(0.5);
            *q += step;
            fastest = if step.norm_squared() > fastest.norm_squared() { step } else { fastest };
            let away = *q - *a;
            // The mean of a steady motion lags by its speed times the time constant.
            if away.norm_squared() > R::of(SLIPPED_M * SLIPPED_M) {
                *v = away / R::of(ANCHOR_S);
                any = true;
            }
            *a += away * share;
        }
        self.path = Some(path);
        self.speed_m_s += (fastest / dt_s - self.speed_m_s) * R::of(0.15);
        self.slip_s = if any { self.slip_s + dt_s } else { R::zero() };
        Some(speed)
    }
}

/// Needed friction coefficient of some fingers' wrenches together, and that of the force
/// without torsion; `None` without normal force.
fn ratio<R: Real>(wrenches: &[&[R; 6]], arm_m: R) -> Option<[R; 2]> {
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
    let force = (x * x + z * z).root() / normal;
    let torsion = if arm_m > R::zero() { turn / arm_m } else { R::zero() };
    let needed = (x * x + z * z + torsion * torsion).root() / normal;
    needed.finite().then_some([needed, force].map(|r| least(r, R::of(100.0))))
}
