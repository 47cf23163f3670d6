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
//! rest; the anchor is then set anew.

use crate::real::{Real, Vec3, clamp, max, min, norm, sqrt};

/// Gains of the filter: its noise is 0.57 of the samples'.
const ALPHA: f64 = 0.4;
const BETA: f64 = 0.08;
const FILTERED: f64 = 0.57;
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
/// Slower than this for some samples is rest.
const REST_M_S: f64 = 3e-3;
const REST_SAMPLES: u8 = 8;

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
            // By chance once in some hundred hours.
            Forces::Hold => (5.5, [4e-5, 4e-5]),
            // By chance once in some minutes at the limit, where a grasp rarely is.
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
    acceleration_m_s2: R,
    speed_m_s: R,
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
    fn departed(&self, sigma_m: [R; 2], forces: Forces) -> bool {
        let (sigmas, lag_m) = forces.bar();
        let (mut sum, mut count) = (Vec3::zeros(), R::zero());
        let bar = |sigma: R, lag: f64, n: R| sigma * R::of(sigmas) * sqrt(n) + R::of(lag) * n;
        let bars = |n: R| [bar(sigma_m[0], lag_m[0], n), bar(sigma_m[1], lag_m[1], n)];
        let counted = bars(R::of(2.0)).map(|b| b * R::of(COUNTED_SHARE));
        self.raw.iter().any(|raw| {
            let d: Vec3<R> = raw - self.anchor;
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
            acceleration_m_s2: R::zero(),
            speed_m_s: R::zero(),
        }
    }
}

impl<R: Real> Motion<R> {
    /// Nothing is known of the points any more.
    pub fn forget(&mut self) {
        *self = Self { variance: self.variance, ..Self::default() };
    }

    /// The points at one sample.
    pub fn follow(&mut self, raw: &[Vec3<R>; 2], forces: Forces, dt_s: R) -> Moved<R> {
        let Some(mut points) = self.points else {
            self.points = Some(raw.map(Point::resting));
            return self.moved([Vec3::zeros(); 2]);
        };
        let noise = self.variance.map(|v| sqrt(v) * R::of(FILTERED));
        let sigma_m = self.variance.map(|v| sqrt(v));
        self.age = self.age.saturating_add(1).min(WARM);
        let first = R::one() / (R::of(f64::from(self.age)) + R::one());
        let slipping = self.slip_s > R::zero();
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
            begins |= self.age > 8 && !slipping && p.departed(sigma_m, forces);
            fastest = max(fastest, norm(&p.velocity));
            if !slipping {
                let follow = max(min(R::of(FOLLOW_S) * dt_s, R::one()), first);
                p.anchor += away * follow + p.creep * dt_s;
                let most = R::of(CREEP_M_S);
                let creeping = if self.age == WARM { away } else { Vec3::zeros() };
                p.creep = (p.creep + creeping * (R::of(CREEP_S2) * dt_s)).map(|v| clamp(v, -most, most));
            }
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
        } else if slipping || begins {
            if !slipping {
                self.still = 0;
            }
            self.slip_s += dt_s;
        }
        self.points = Some(points);
        self.moved(points.map(|p| p.velocity))
    }

    fn moved(&self, velocity_m_s: [Vec3<R>; 2]) -> Moved<R> {
        Moved { velocity_m_s, slip_s: self.slip_s, acceleration_m_s2: self.acceleration_m_s2 }
    }
}
