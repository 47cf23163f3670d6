//! Onset of relative motion in the grasp, from the object's measured pose.
//!
//! Each finger's material point of the object (X, Z, and the turn at the arm of torsion) is
//! followed by an alpha-beta filter. While it sticks, an anchor follows slowly, with a
//! drift of its own: a pad that creeps steadily does not slip. Slip is a departure of the
//! filtered point from the anchor beyond the noise, borne out by two raw samples in a row.
//! It ends when the point has come to rest; the anchor is then set anew.

use crate::real::{Length, Real, Vec3, clamp, least, most};

/// Gains of the filter: its noise is 0.57 of the samples'.
const ALPHA: f64 = 0.4;
const BETA: f64 = 0.08;
const FILTERED: f64 = 0.57;
/// Gains of the anchor (1/s, 1/s²) and the fastest creep that it takes along.
const FOLLOW_S: f64 = 5.0;
const CREEP_S2: f64 = 5.0;
const CREEP_M_S: f64 = 1e-3;
/// Departure that is slip, m and standard deviations of the filtered point: by chance once
/// in a hundred hours. Where the forces show that the object falls, less will do.
const SLIPPED_M: f64 = 1e-4;
const TURNED_M: f64 = 5e-5;
const SIGMAS: f64 = 6.0;
const SIGMAS_FALLING: f64 = 3.5;
/// First guess of the noise of the pose in the grasp, one axis.
const NOISE_M: f64 = 5e-5;
/// Samples after which gains are what they are; before, each sample counts the same.
const WARM: u8 = 50;
/// Slower than this for some samples is rest.
const REST_M_S: f64 = 3e-3;
const REST_SAMPLES: u8 = 8;

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
    raw: Vec3<R>,
    at: Vec3<R>,
    velocity: Vec3<R>,
    anchor: Vec3<R>,
    creep: Vec3<R>,
    /// Raw samples in a row that lie away from the anchor.
    away: u8,
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

    /// The points at one sample; `falling` where the forces no longer bear the object.
    pub fn follow(&mut self, raw: &[Vec3<R>; 2], falling: bool, dt_s: R) -> Moved<R> {
        let Some(mut points) = self.points else {
            let still = Vec3::zeros();
            self.points =
                Some(raw.map(|p| Point { raw: p, at: p, velocity: still, anchor: p, creep: still, away: 0 }));
            return self.moved([still; 2]);
        };
        let noise = self.variance.map(|v| v.root() * R::of(FILTERED));
        let sigmas = R::of(if falling { SIGMAS_FALLING } else { SIGMAS });
        let least_m = [SLIPPED_M, TURNED_M].map(|x| R::of(if falling { 0.0 } else { x }));
        let limit = [most(least_m[0], noise[0] * sigmas), most(least_m[1], noise[1] * sigmas)];
        self.age = self.age.saturating_add(1).min(WARM);
        let first = R::one() / (R::of(f64::from(self.age)) + R::one());
        let slipping = self.slip_s > R::zero();
        let mut begins = false;
        let mut fastest = R::zero();
        for (p, raw) in points.iter_mut().zip(raw) {
            let change = raw - p.raw;
            p.raw = *raw;
            if !slipping {
                // Each the difference of two samples; X and Z together are two.
                let squares = [
                    (change.x * change.x + change.z * change.z) * R::of(0.25),
                    change.y * change.y * R::of(0.5),
                ];
                let gain = most(R::of(0.005), first * R::of(0.1));
                for (v, square) in self.variance.iter_mut().zip(squares) {
                    *v += (least(square, *v * R::of(9.0)) - *v) * gain;
                }
            }
            let ahead = p.at + p.velocity * dt_s;
            let miss = raw - ahead;
            p.at = ahead + miss * R::of(ALPHA);
            p.velocity += miss * (R::of(BETA) / dt_s);
            let away = p.at - p.anchor;
            let beyond = |d: &Vec3<R>, share: f64| {
                let limit = limit.map(|l| l * R::of(share));
                d.x * d.x + d.z * d.z > limit[0] * limit[0] || d.y.abs() > limit[1]
            };
            p.away = if beyond(&(raw - p.anchor), 0.7) { (p.away + 1).min(2) } else { 0 };
            begins |= self.age > 8 && p.away == 2 && beyond(&away, 1.0);
            fastest = most(fastest, p.velocity.length());
            if !slipping {
                let follow = most(least(R::of(FOLLOW_S) * dt_s, R::one()), first);
                p.anchor += away * follow + p.creep * dt_s;
                let most = R::of(CREEP_M_S);
                let creeping = if self.age == WARM { away } else { Vec3::zeros() };
                p.creep = (p.creep + creeping * (R::of(CREEP_S2) * dt_s)).map(|v| clamp(v, -most, most));
            }
        }
        let gain = (fastest - self.speed_m_s) / dt_s;
        self.speed_m_s = fastest;
        self.acceleration_m_s2 += (gain - self.acceleration_m_s2) * R::of(0.3);
        let resting = fastest < most(R::of(REST_M_S), noise[0] * R::of(0.7) / dt_s);
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
