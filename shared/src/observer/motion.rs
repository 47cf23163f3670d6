//! Onset of relative motion in the grasp, from the object's measured pose.
//!
//! Each finger's material point of the object (X, Z, and the turn at the arm of torsion) is
//! followed by an alpha-beta filter. While it sticks, an anchor follows slowly, with a
//! drift of its own: a pad that creeps steadily does not slip. Slip is a departure of the
//! last `n` raw samples' mean from the anchor beyond the noise, `|mean| > h sigma / sqrt(n) + b`
//! for any `n` from two to eight (a likelihood ratio test against a step of unknown age and
//! size), each sample counted up to a bound, so that one wild sample proves nothing. How
//! sure it must be depends on what the forces say ([`Forces`]): pads that carry a load near
//! the limit may slip, those far below it hardly do. Slip ends when the point has come to
//! rest; the anchor is then set anew, from few samples: its own variance is added to that of the mean, and it
//! follows as a mean of all samples since would, until its gain is the slow one. What the load shears elastically out of the pads ([`shear`](super::shear))
//! is no departure. Slow noise and vibration show in the means of eight samples: their variance beyond that of
//! white noise is added. Poses may come more rarely than samples.

use super::shear::{Load, Shear};
use crate::real::{Real, Vec3, clamp, max, min, norm, sqrt};

/// Gains of the filter: its noise is 0.57 of the samples', as that of a mean of three.
const ALPHA: f64 = 0.4;
const BETA: f64 = 0.08;
const FILTERED: f64 = 0.57;
const FILTERED_SAMPLES: u8 = 3;
/// Gains of the anchor (1/s, 1/s²) and the fastest creep that it takes along.
const FOLLOW_S: f64 = 5.0;
const CREEP_S2: f64 = 5.0;
const CREEP_M_S: f64 = 1e-3;
/// Most samples in a mean.
const WINDOW: usize = 8;
/// A sample counts up to this share of what two must sum to: one alone proves nothing.
const COUNTED_SHARE: f64 = 0.6;
/// First guess of the noise of the pose in the grasp, one axis.
const NOISE_M: f64 = 5e-5;
/// Samples after which gains are what they are; before, each sample counts the same.
const WARM: u8 = 50;
/// Most departure that winds the creep up, in standard deviations: a move is none.
const CREEP_SIGMAS: f64 = 3.0;
/// Share with which a block's mean enters their variance, and how much more than that it may be.
const BLOCK_SHARE: f64 = 0.05;
const BLOCK_MOST: f64 = 9.0;
/// Slower than this for some samples is rest.
const REST_M_S: f64 = 3e-3;
const REST_SAMPLES: u8 = 8;

/// Poses that are farther apart than this are none: a camera of 25 Hz.
const BLIND_S: f64 = 0.045;

/// What the forces say of slip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Forces {
    /// Far below the friction limit, or not measured.
    Hold,
    /// About the limit, or they may bear less than the weight.
    AtLimit,
    /// They no longer bear the object.
    Fall,
}

impl Forces {
    /// Departure that is slip: standard deviations of a mean, and what the anchor may lag behind
    /// a creep besides, along the face and of the turn, m.
    fn bar(self) -> (f64, [f64; 2]) {
        match self {
            // By chance once in two hours: exp(h^2 / 2) means, of which two in a sample are independent.
            Forces::Hold => (5.5, [2e-5, 3e-5]),
            // The same, but for what the anchor lags: at the limit, where a grasp rarely is.
            Forces::AtLimit => (4.7, [5e-6, 1.5e-5]),
            Forces::Fall => (3.5, [0.0, 0.0]),
        }
    }
}

/// State.
#[derive(Clone, Debug)]
pub struct Motion<R: Real> {
    points: Option<[Point<R>; 2]>,
    /// Noise of a sample, along X and Z, and of the turn at the arm.
    variance: [R; 2],
    slip_s: R,
    still: u8,
    age: u8,
    /// Samples that the anchor is the mean of, up to [`WARM`], and its variance over that of a sample.
    anchored: u8,
    anchor_share: R,
    acceleration_m_s2: R,
    speed_m_s: R,
    shear: Shear<R>,
    /// Variance of a block's mean beyond that of white noise, along the face and of the turn.
    excess: [R; 2],
    block: Vec3<R>,
    count: u8,
    blocks: u8,
    /// Since the last pose, s.
    blind_s: R,
}

#[derive(Clone, Copy, Debug)]
struct Point<R: Real> {
    /// Samples, the newest first.
    raw: [Vec3<R>; WINDOW],
    at: Vec3<R>,
    velocity: Vec3<R>,
    anchor: Vec3<R>,
    creep: Vec3<R>,
}

impl<R: Real> Point<R> {
    fn resting(at: Vec3<R>) -> Self {
        let still = Vec3::zeros();
        Self { raw: [at; WINDOW], at, velocity: still, anchor: at, creep: still }
    }

    /// The last samples lie away from the anchor; `sigma_m` of one sample along the face, and
    /// of the turn.
    fn departed(&self, noise: &[[R; 2]; 2], shear: &Shear<R>, forces: Forces) -> bool {
        let (sigmas, lag_m) = forces.bar();
        let (mut sum, mut count) = (Vec3::zeros(), R::zero());
        // About the limit slip is as likely as what pads and clock may be besides what was learnt.
        let (mut unknown, mut skew_m) = ([R::zero(); 3], [R::zero(); 2]);
        if forces == Forces::Hold {
            unknown = shear.unknown();
            skew_m = shear.skew_m(&unknown);
        }
        let bar = |k: usize, n: R| {
            let spread = sqrt(noise[0][k] * n + noise[1][k] * n * n);
            spread * R::of(sigmas) + (R::of(lag_m[k]) + skew_m[k]) * n
        };
        let bars = |n: R| [bar(0, n), bar(1, n)];
        let counted = bars(R::of(2.0)).map(|b| b * R::of(COUNTED_SHARE));
        self.raw.iter().zip(&shear.recent).any(|(raw, load)| {
            let d: Vec3<R> = raw - self.anchor;
            let d = shear.beyond(&d, load, &unknown);
            let size = sqrt(d.x * d.x + d.z * d.z);
            let share = if size > counted[0] { counted[0] / size } else { R::one() };
            sum += Vec3::new(d.x * share, clamp(d.y, -counted[1], counted[1]), d.z * share);
            count += R::one();
            let [along, turn] = bars(count);
            let beyond = sum.x * sum.x + sum.z * sum.z > along * along || sum.y.abs() > turn;
            beyond && count > R::one()
        })
    }
}

/// What the pose shows at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved<R: Real> {
    /// Velocity of each finger's point: X, turn at the arm, Z, m/s.
    pub velocity_m_s: [Vec3<R>; 2],
    /// For how long the object has been slipping; zero while it sticks.
    pub slip_s: R,
    /// Gain of speed, smoothed, m/s².
    pub acceleration_m_s2: R,
}

impl<R: Real> Default for Motion<R> {
    fn default() -> Self {
        Self {
            points: None,
            variance: [R::of(NOISE_M * NOISE_M); 2],
            slip_s: R::zero(),
            still: 0,
            age: 0,
            anchored: 0,
            anchor_share: R::one(),
            acceleration_m_s2: R::zero(),
            speed_m_s: R::zero(),
            shear: Shear::default(),
            excess: [R::zero(); 2],
            block: Vec3::zeros(),
            count: 0,
            blocks: 0,
            blind_s: R::zero(),
        }
    }
}

impl<R: Real> Motion<R> {
    /// Nothing is known of the points any more.
    pub fn forget(&mut self) {
        *self = Self { variance: self.variance, shear: self.shear.kept(), ..Self::default() };
    }

    /// A sample without a pose, as cameras slower than the sampling leave them: what was seen last holds for a
    /// while; then nothing is known any more.
    pub fn wait(&mut self, dt_s: R) -> Option<Moved<R>> {
        let points = self.points?;
        self.blind_s += dt_s;
        if self.blind_s > R::of(BLIND_S) {
            self.forget();
            return None;
        }
        if self.slip_s > R::zero() {
            self.slip_s += dt_s;
        }
        Some(self.moved(points.map(|p| p.velocity)))
    }

    /// The points at one sample, and the load that they carry.
    pub fn follow(
        &mut self,
        raw: &[Vec3<R>; 2],
        load: Option<&Load<R>>,
        forces: Forces,
        dt_s: R,
    ) -> Moved<R> {
        // Since the last pose.
        let (sample_s, dt_s) = (dt_s, dt_s + self.blind_s);
        self.blind_s = R::zero();
        let Some(mut points) = self.points else {
            self.points = Some(raw.map(Point::resting));
            self.shear.begin(load);
            return self.moved([Vec3::zeros(); 2]);
        };
        let noise = self.variance.map(|v| sqrt(v) * R::of(FILTERED));
        let sigma_m = self.variance.map(|v| sqrt(v));
        self.shear.push(load, dt_s);
        let [along, turn] = self.variance.map(|v| v * self.anchor_share);
        let spread = [self.variance, [self.excess[0] + along, self.excess[1] + turn]];
        self.age = self.age.saturating_add(1).min(WARM);
        let first = R::one() / (R::of(f64::from(self.age)) + R::one());
        let slipping = self.slip_s > R::zero();
        self.anchored = self.anchored.saturating_add(1).min(WARM);
        let mean = R::one() / (R::of(f64::from(self.anchored)) + R::one());
        let follow = max(min(R::of(FOLLOW_S) * dt_s, R::one()), mean);
        let mut begins = false;
        let mut fastest = R::zero();
        for (p, raw) in points.iter_mut().zip(raw) {
            let change = raw - p.raw[0];
            super::shift_in(&mut p.raw, *raw);
            if !slipping {
                // Each the difference of two samples; X and Z together are two.
                let squares = [
                    (change.x * change.x + change.z * change.z) * R::of(0.25),
                    change.y * change.y * R::of(0.5),
                ];
                let gain = max(R::of(0.005), first);
                for (v, square) in self.variance.iter_mut().zip(squares) {
                    *v += (min(square, *v * R::of(9.0)) - *v) * gain;
                }
            }
            let ahead = p.at + p.velocity * dt_s;
            let miss = raw - ahead;
            p.at = ahead + miss * R::of(ALPHA);
            p.velocity += miss * (R::of(BETA) / dt_s);
            let away = p.at - p.anchor;
            begins |= self.age > 8 && !slipping && p.departed(&spread, &self.shear, forces);
            fastest = max(fastest, norm(&p.velocity));
            if !slipping {
                p.anchor += away * follow + p.creep * dt_s;
                let most = R::of(CREEP_M_S);
                let left = away - self.shear.explained();
                let bound = [sigma_m[0], sigma_m[1], sigma_m[0]].map(|s| s * R::of(CREEP_SIGMAS));
                let left = Vec3::new(
                    clamp(left.x, -bound[0], bound[0]),
                    clamp(left.y, -bound[1], bound[1]),
                    clamp(left.z, -bound[2], bound[2]),
                );
                let creeping = if self.anchored == WARM { left } else { Vec3::zeros() };
                p.creep = (p.creep + creeping * (R::of(CREEP_S2) * dt_s)).map(|v| clamp(v, -most, most));
            }
        }
        if !slipping {
            let four = |p: &Point<R>| (p.raw[0] + p.raw[1] + p.raw[2] + p.raw[3]) * R::of(0.25) - p.anchor;
            self.shear.bound(&((four(&points[0]) + four(&points[1])) * R::of(0.5)), &sigma_m);
            let away = (raw[0] - points[0].anchor + raw[1] - points[1].anchor) * R::of(0.5);
            if forces == Forces::Hold && !begins {
                self.shear.learn(&away);
            }
            self.note_block(&(away - self.shear.explained_now()));
            self.shear.follow(follow);
            let kept = R::one() - follow;
            self.anchor_share = kept * kept * self.anchor_share + follow * follow;
        }
        let gain = (fastest - self.speed_m_s) / dt_s;
        self.speed_m_s = fastest;
        self.acceleration_m_s2 += (gain - self.acceleration_m_s2) * R::of(0.3);
        let resting = fastest < max(R::of(REST_M_S), noise[0] * R::of(0.7) / dt_s);
        self.still = if resting { self.still.saturating_add(1) } else { 0 };
        if slipping && self.still >= REST_SAMPLES {
            self.slip_s = R::zero();
            for p in &mut points {
                p.anchor = p.at;
                p.creep = Vec3::zeros();
            }
            self.shear.rest();
            (self.anchored, self.anchor_share) = (FILTERED_SAMPLES, R::of(FILTERED * FILTERED));
            (self.block, self.count) = (Vec3::zeros(), 0);
        } else if slipping || begins {
            if !slipping {
                self.still = 0;
            }
            self.slip_s += sample_s;
        }
        self.points = Some(points);
        self.moved(points.map(|p| p.velocity))
    }

    /// What is left of the departure, for the variance of blocks.
    fn note_block(&mut self, left: &Vec3<R>) {
        self.block += left;
        self.count += 1;
        if (self.count as usize) < WINDOW {
            return;
        }
        let n = R::of(WINDOW as f64);
        let mean = self.block / n;
        self.blocks = self.blocks.saturating_add(1);
        // The first count the same.
        let share = max(R::of(BLOCK_SHARE), R::one() / R::of(f64::from(self.blocks)));
        let squares = [(mean.x * mean.x + mean.z * mean.z) * R::of(0.5), mean.y * mean.y];
        for ((excess, white), square) in self.excess.iter_mut().zip(&self.variance).zip(squares) {
            // Of the mean and of the anchor that it is counted from.
            let white = *white / n + *white * self.anchor_share;
            let most = (*excess + white) * R::of(BLOCK_MOST);
            *excess = max(*excess + (min(square, most) - white - *excess) * share, R::zero());
        }
        (self.block, self.count) = (Vec3::zeros(), 0);
    }

    fn moved(&self, velocity_m_s: [Vec3<R>; 2]) -> Moved<R> {
        Moved { velocity_m_s, slip_s: self.slip_s, acceleration_m_s2: self.acceleration_m_s2 }
    }
}
