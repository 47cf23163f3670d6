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

use super::shear::{Load, Shear, ShearParams};
use crate::real::{Real, Vec3, clamp, max, min, norm, sqrt};
use crate::tuning::tuned;
use crate::window::shift_in;

/// Gains of the filter: its noise is 0.57 of the samples', as that of a mean of three.
const ALPHA: f64 = 0.4;
const BETA: f64 = 0.08;
const FILTERED: f64 = 0.57;
const FILTERED_SAMPLES: u8 = 3;
/// Most samples in a mean.
const WINDOW: usize = 8;
/// Samples after which gains are what they are; before, each sample counts the same.
const WARM: u8 = 50;

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

tuned! {
    /// Departure that is slip.
    pub struct Bar<R> {
        /// Standard deviations of a mean. Doubled: sudden slips are seen later, slow ones much later.
        sigmas: R = R::of(5.5), 0.5 to 50.0;
        /// What the anchor may lag behind a creep besides, along the face and of the turn, m. Doubled: slow slips are seen later.
        lag_m: [R; 2] = [R::of(2e-5), R::of(3e-5)], 0.0 to 0.01;
    }
}

tuned! {
    /// What was chosen in it.
    pub struct MotionParams<R> {
        /// Gain of the anchor, 1/s. Doubled: slow slides are lost in it twice as soon, slow shear of pads twice as well.
        follow_s: R = R::of(5.0), 0.0 to 250.0;
        /// Gain of its drift, 1/s^2. Doubled: a creep is taken along sooner, and slow slides too.
        creep_s2: R = R::of(5.0), 0.0 to 1000.0;
        /// Fastest creep that is taken along, m/s. Doubled: slides of 2 mm/s are none.
        creep_m_s: R = R::of(1e-3), 0.0 to 1.0;
        /// A sample counts up to this share of what two must sum to: one alone proves nothing. Above 1, one wild sample is slip.
        counted_share: R = R::of(0.6), 0.05 to 2.0;
        /// First guess of the noise of the pose in the grasp on an axis, m. Doubled: slips in the first tenth of a second are seen later.
        noise_m: R = R::of(5e-5), 1e-7 to 0.01;
        /// Share with which a sample enters that noise: 0.8 s. Doubled: a change of it is followed in half of the time.
        noise_share: R = R::of(0.005), 1e-4 to 1.0;
        /// How much more than the noise so far one sample counts, in squares. Doubled: starts and stops count as noise.
        noise_most: R = R::of(9.0), 1.0 to 1000.0;
        /// Most departure that winds the creep up, in standard deviations: a move is none. Doubled: moves wind it up.
        creep_sigmas: R = R::of(3.0), 0.0 to 100.0;
        /// Share with which a block's mean enters their variance: 0.6 s at 250 Hz. Doubled: vibration is learnt, and forgotten, in half of it.
        block_share: R = R::of(0.05), 0.001 to 1.0;
        /// How much more than the variance so far one block counts. Doubled: a slip that begins counts as vibration.
        block_most: R = R::of(9.0), 1.0 to 1000.0;
        /// Slower than this for some samples is rest, m/s: the noise of the filtered velocity. Doubled: slides of 5 mm/s are detected in pieces.
        rest_m_s: R = R::of(3e-3), 0.0 to 1.0;
        /// Slower than so many standard deviations of the filtered pose in a sample is rest too. Doubled: the same with bad cameras.
        rest_sigmas: R = R::of(0.7), 0.0 to 100.0;
        /// For so many samples: 32 ms. Doubled: a slip is said to end that much later.
        rest_samples: u8 = 8, 1.0 to 250.0;
        /// Share with which a gain of speed enters the acceleration of a slip: three samples. Doubled: its noise is 1.6 times as large.
        acceleration_share: R = R::of(0.3), 0.01 to 1.0;
        /// Poses that are farther apart than this are none, s: a camera slower than 33 Hz shows less of slip than the forces do. Doubled: an object that is no longer seen passes for held for 60 ms, and with poses at 31 Hz a quarter fewer sudden slips are seen within 40 ms.
        blind_s: R = R::of(0.03), 0.0 to 1.0;
        /// Far below the limit: by chance once in two hours, exp(h^2 / 2) means, of which two in a sample are independent. Sigmas
        /// doubled: sudden slips are seen twice as late.
        hold: Bar<R> = Bar { sigmas: R::of(5.5), lag_m: [R::of(2e-5), R::of(3e-5)] };
        /// The same, but for what the anchor lags: at the limit, where a grasp rarely is.
        at_limit: Bar<R> = Bar { sigmas: R::of(4.7), lag_m: [R::of(5e-6), R::of(1.5e-5)] };
        /// The forces have shown slip already: by chance once in a second of it.
        fall: Bar<R> = Bar { sigmas: R::of(3.5), lag_m: [R::of(0.0), R::of(0.0)] };
    }
}

impl<R: Real> MotionParams<R> {
    fn bar(&self, forces: Forces) -> &Bar<R> {
        match forces {
            Forces::Hold => &self.hold,
            Forces::AtLimit => &self.at_limit,
            Forces::Fall => &self.fall,
        }
    }
}

/// State.
#[derive(Clone, Debug)]
pub struct Motion<R: Real> {
    params: MotionParams<R>,
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
    fn departed(
        &self,
        noise: &[[R; 2]; 2],
        shear: &Shear<R>,
        forces: Forces,
        params: &MotionParams<R>,
    ) -> bool {
        let Bar { sigmas, lag_m } = *params.bar(forces);
        let (mut sum, mut count) = (Vec3::zeros(), R::zero());
        // About the limit slip is as likely as what pads and clock may be besides what was learnt.
        let (mut unknown, mut skew_m) = ([R::zero(); 3], [R::zero(); 2]);
        if forces == Forces::Hold {
            unknown = shear.unknown();
            skew_m = shear.skew_m(&unknown);
        }
        let bar = |k: usize, n: R| {
            let spread = sqrt(noise[0][k] * n + noise[1][k] * n * n);
            spread * sigmas + (lag_m[k] + skew_m[k]) * n
        };
        let bars = |n: R| [bar(0, n), bar(1, n)];
        let counted = bars(R::of(2.0)).map(|b| b * params.counted_share);
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
        Self::new(MotionParams::default(), ShearParams::default())
    }
}

impl<R: Real> Motion<R> {
    /// Nothing was seen yet.
    pub fn new(params: MotionParams<R>, shear: ShearParams<R>) -> Self {
        Self::of(params, Shear::new(shear))
    }

    fn of(params: MotionParams<R>, shear: Shear<R>) -> Self {
        Self {
            params,
            points: None,
            variance: [params.noise_m * params.noise_m; 2],
            slip_s: R::zero(),
            still: 0,
            age: 0,
            anchored: 0,
            anchor_share: R::one(),
            acceleration_m_s2: R::zero(),
            speed_m_s: R::zero(),
            shear,
            excess: [R::zero(); 2],
            block: Vec3::zeros(),
            count: 0,
            blocks: 0,
            blind_s: R::zero(),
        }
    }

    /// Nothing is known of the points any more.
    pub fn forget(&mut self) {
        let shear = self.shear.kept();
        *self = Self { variance: self.variance, ..Self::of(self.params, shear) };
    }

    /// A sample without a pose, as cameras slower than the sampling leave them: what was seen last holds for a
    /// while; then nothing is known any more.
    pub fn wait(&mut self, dt_s: R) -> Option<Moved<R>> {
        let points = self.points?;
        self.blind_s += dt_s;
        if self.blind_s > self.params.blind_s {
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
        let follow = max(min(self.params.follow_s * dt_s, R::one()), mean);
        let mut begins = false;
        let mut fastest = R::zero();
        for (p, raw) in points.iter_mut().zip(raw) {
            let change = raw - p.raw[0];
            shift_in(&mut p.raw, *raw);
            if !slipping {
                // Each the difference of two samples; X and Z together are two.
                let squares = [
                    (change.x * change.x + change.z * change.z) * R::of(0.25),
                    change.y * change.y * R::of(0.5),
                ];
                let gain = max(self.params.noise_share, first);
                for (v, square) in self.variance.iter_mut().zip(squares) {
                    *v += (min(square, *v * self.params.noise_most) - *v) * gain;
                }
            }
            let ahead = p.at + p.velocity * dt_s;
            let miss = raw - ahead;
            p.at = ahead + miss * R::of(ALPHA);
            p.velocity += miss * (R::of(BETA) / dt_s);
            let away = p.at - p.anchor;
            begins |= self.age > 8 && !slipping && p.departed(&spread, &self.shear, forces, &self.params);
            fastest = max(fastest, norm(&p.velocity));
            if !slipping {
                p.anchor += away * follow + p.creep * dt_s;
                let most = self.params.creep_m_s;
                let left = away - self.shear.explained();
                let bound = [sigma_m[0], sigma_m[1], sigma_m[0]].map(|s| s * self.params.creep_sigmas);
                let left = Vec3::new(
                    clamp(left.x, -bound[0], bound[0]),
                    clamp(left.y, -bound[1], bound[1]),
                    clamp(left.z, -bound[2], bound[2]),
                );
                let creeping = if self.anchored == WARM { left } else { Vec3::zeros() };
                p.creep = (p.creep + creeping * (self.params.creep_s2 * dt_s)).map(|v| clamp(v, -most, most));
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
        self.acceleration_m_s2 += (gain - self.acceleration_m_s2) * self.params.acceleration_share;
        let resting = fastest < max(self.params.rest_m_s, noise[0] * self.params.rest_sigmas / dt_s);
        self.still = if resting { self.still.saturating_add(1) } else { 0 };
        if slipping && self.still >= self.params.rest_samples {
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
        let share = max(self.params.block_share, R::one() / R::of(f64::from(self.blocks)));
        let squares = [(mean.x * mean.x + mean.z * mean.z) * R::of(0.5), mean.y * mean.y];
        for ((excess, white), square) in self.excess.iter_mut().zip(&self.variance).zip(squares) {
            // Of the mean and of the anchor that it is counted from.
            let white = *white / n + *white * self.anchor_share;
            let most = (*excess + white) * self.params.block_most;
            *excess = max(*excess + (min(square, most) - white - *excess) * share, R::zero());
        }
        (self.block, self.count) = (Vec3::zeros(), 0);
    }

    fn moved(&self, velocity_m_s: [Vec3<R>; 2]) -> Moved<R> {
        Moved { velocity_m_s, slip_s: self.slip_s, acceleration_m_s2: self.acceleration_m_s2 }
    }
}
