//! Elastic shear of the pads: how far the load moves the object in the grasp, to come back with it.
//!
//! `d = C f + tau v`, of departures of place, load (what the object exerts on the pads) and gripper velocity
//! from means with the same time constant: pads shear by `C f`, and two poses that are measured `tau` apart
//! part by `tau v` in every move. Both are learnt on-line by Bayesian least squares from what lies far below
//! the friction limit; priors are soft fingertips and a quarter of a sample. A compliance is never negative,
//! so what may be elastic is a line from the anchor along the load: slip is the distance from it
//! (`Shear::beyond`). An object that slides while its load falls moves the other way and is seen at once.
//! Where a load has been borne and the object has moved less, the pads are no softer. Pads that stiffen with
//! their normal force give way when it falls under the same load.

use crate::real::{Real, Vec3, clamp, max, min, norm, sqrt};
use crate::tuning::tuned;
use crate::window::shift_in;

/// Samples that are kept.
pub(super) const KEPT: usize = 8;

tuned! {
    /// What was chosen in it.
    pub struct ShearParams<R> {
        /// Compliance of both pads together that may be, m/N: of two pads of 5 N/mm.
        /// Doubled: slips in the first lift are seen some 10 ms later.
        softest_m_n: R = R::of(1e-4), 1e-9 to 0.1;
        /// Time by which the poses of gripper and object may be apart, standard deviation, s: a quarter of a sample.
        /// Doubled: sudden slips in the first move are seen some 5 ms later.
        apart_s: R = R::of(1.0e-3), 1e-6 to 0.1;
        /// Doubt that counts, in standard deviations of the posterior. Doubled: as twice both priors.
        doubt_sigmas: R = R::of(1.5), 0.0 to 20.0;
        /// Share by which a pad's shear is not linear: partial slip of the rim below two thirds of the limit.
        /// Doubled: slips are distinguished from softening that much later.
        nonlinear: R = R::of(0.3), 0.0 to 10.0;
        /// The load and the pose may be measured so far apart in time, s: half the longest mean of a force sensor, and
        /// a third of a sample. Doubled: a tenth fewer false alarms in knocks, 1 % fewer sudden slips within 20 ms.
        skew_s: R = R::of(0.003), 0.0 to 0.1;
        /// Loads below so many standard deviations of the noise teach nothing. Doubled: light objects teach little.
        taught_sigmas: R = R::of(5.0), 0.0 to 100.0;
        /// Velocities below this teach nothing, m/s: the noise of the gripper's. Doubled: slow moves do not determine the time apart.
        taught_m_s: R = R::of(0.02), 0.0 to 10.0;
        /// Share by which the time apart is not constant. Doubled: sudden slips in fast moves of late poses are seen later.
        late_share: R = R::of(0.15), 0.0 to 10.0;
        /// What was learnt fades by this share with each sample that teaches: 2 s. Doubled: pads that warm up are followed in 1 s.
        fade: R = R::of(0.002), 1e-6 to 1.0;
        /// Samples of a move whose errors are alike: so much less they say of the time apart. Doubled: two moves are needed.
        alike: R = R::of(25.0), 1.0 to 10000.0;
        /// Of the mean of four samples, to bound the compliance. Doubled: the bound is wider by the noise.
        bound_sigmas: R = R::of(1.5), 0.0 to 100.0;
        /// By how much of itself the bound widens in a sample: by half in 20 s. Doubled: in 10 s.
        bound_fade: R = R::of(1e-4), 0.0 to 1.0;
        /// Noise of a pose in the grasp, m, against which the priors weigh. Doubled: pads are learnt from four times the samples.
        noise_m: R = R::of(5e-5), 1e-7 to 0.01;
        /// Share with which a difference of loads enters their noise: 0.4 s. Doubled: a change of it is followed in half of the time.
        load_noise_share: R = R::of(0.01), 1e-4 to 1.0;
        /// How much more than the noise so far one difference counts, in squares. Doubled: knocks count as noise.
        load_noise_most: R = R::of(9.0), 1.0 to 1000.0;
        /// Smoothing of the load that shears the pads, as of the position. Doubled: 1.8 times the noise of its rate.
        smoothing: R = R::of(0.4), 0.01 to 1.0;
    }
}

/// Load of both fingers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load<R: Real> {
    /// X, torsion over its arm, Z, N.
    pub force_n: Vec3<R>,
    /// Normal force of both, N.
    pub normal_n: R,
    /// Velocity of the gripper, its axes, m/s.
    pub gripper_m_s: Vec3<R>,
}

/// A load and the gripper's velocity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cause<R: Real> {
    force_n: Vec3<R>,
    velocity_m_s: Vec3<R>,
}

impl<R: Real> Cause<R> {
    fn none() -> Self {
        Self { force_n: Vec3::zeros(), velocity_m_s: Vec3::zeros() }
    }

    fn towards(&mut self, other: &Self, share: R) {
        self.force_n += (other.force_n - self.force_n) * share;
        self.velocity_m_s += (other.velocity_m_s - self.velocity_m_s) * share;
    }

    fn from(&self, mean: &Self) -> Self {
        Self { force_n: self.force_n - mean.force_n, velocity_m_s: self.velocity_m_s - mean.velocity_m_s }
    }
}

/// Sums of the least squares along the face: load, load times velocity, velocity; with the place.
#[derive(Clone, Copy, Debug)]
struct Sums<R: Real> {
    square: [R; 3],
    product: [R; 2],
    /// Of the turn.
    turn: [R; 2],
}

/// State.
#[derive(Clone, Debug)]
pub struct Shear<R: Real> {
    params: ShearParams<R>,
    /// Pose noise against the priors: what the sums must outweigh, N^2 and (m/s)^2.
    ridge: [R; 2],
    /// The newest first.
    pub(super) recent: [Cause<R>; KEPT],
    /// Slow means.
    mean: Cause<R>,
    normal_n: [R; 2],
    sums: Sums<R>,
    /// What they make of it: compliance along the face, of the turn, time apart.
    answer: [R; 3],
    variance: R,
    rate_n_s: R,
    smooth: Cause<R>,
    /// No softer than this along the face, and in the turn, m/N: a larger load has moved the object less.
    bound_m_n: [R; 2],
}

impl<R: Real> Default for Shear<R> {
    fn default() -> Self {
        Self::new(ShearParams::default())
    }
}

impl<R: Real> Shear<R> {
    /// Of pads and a clock of which nothing is known but the priors.
    pub fn new(params: ShearParams<R>) -> Self {
        let zero = R::zero();
        let of_prior = |prior: R| {
            let ratio = params.noise_m / prior;
            ratio * ratio
        };
        Self {
            params,
            ridge: [of_prior(params.softest_m_n), params.alike * of_prior(params.apart_s)],
            recent: [Cause::none(); KEPT],
            mean: Cause::none(),
            normal_n: [zero; 2],
            sums: Sums { square: [zero; 3], product: [zero; 2], turn: [zero; 2] },
            answer: [zero; 3],
            variance: R::of(1e-3),
            rate_n_s: zero,
            smooth: Cause::none(),
            bound_m_n: [params.softest_m_n * params.doubt_sigmas; 2],
        }
    }

    /// The pads stay, the grasp is another.
    pub fn kept(&self) -> Self {
        Self {
            sums: self.sums,
            answer: self.answer,
            variance: self.variance,
            bound_m_n: self.bound_m_n,
            ..Self::new(self.params)
        }
    }

    /// The first load.
    pub fn begin(&mut self, load: Option<&Load<R>>) {
        if let Some(load) = load {
            let now = Cause { force_n: load.force_n, velocity_m_s: load.gripper_m_s };
            (self.recent, self.mean, self.smooth) = ([now; KEPT], now, now);
            self.normal_n = [load.normal_n; 2];
        }
    }

    /// One sample; a load that is not measured stays what it was.
    pub fn push(&mut self, load: Option<&Load<R>>, dt_s: R) {
        let [last, ..] = self.recent;
        let now = load.map_or(last, |l| Cause { force_n: l.force_n, velocity_m_s: l.gripper_m_s });
        let change = now.force_n - last.force_n;
        let square = (change.x * change.x + change.z * change.z) * R::of(0.25);
        let most = self.variance * self.params.load_noise_most;
        self.variance += (min(square, most) - self.variance) * self.params.load_noise_share;
        shift_in(&mut self.recent, now);
        let was = self.smooth.force_n;
        self.smooth.towards(&now, self.params.smoothing);
        self.rate_n_s = norm(&(self.smooth.force_n - was)) / dt_s;
        if let Some(load) = load {
            self.normal_n[0] += (load.normal_n - self.normal_n[0]) * self.params.smoothing;
        }
    }

    /// The means follow by this share, as those of the places do.
    pub fn follow(&mut self, share: R) {
        let [now, ..] = self.recent;
        self.mean.towards(&now, share);
        self.normal_n[1] += (self.normal_n[0] - self.normal_n[1]) * share;
    }

    /// The places' means have been set to what is now.
    pub fn rest(&mut self) {
        self.mean = self.smooth;
        self.normal_n[1] = self.normal_n[0];
    }

    /// A load that has been borne for all of the last samples moves the object at least by what is elastic:
    /// where it has moved less, slip or not, the pads are no softer. `away`: mean of the last four samples' departures;
    /// `sigma_m` of one, along the face and of the turn.
    pub fn bound(&mut self, away: &Vec3<R>, sigma_m: &[R; 2]) {
        let Cause { force_n: f, velocity_m_s: v } = self.smooth.from(&self.mean);
        let size = sqrt(f.x * f.x + f.z * f.z);
        let late = self.params.apart_s * sqrt(v.x * v.x + v.z * v.z);
        let (mut least, mut turn) = (size, f.y.abs());
        for cause in &self.recent {
            let g = cause.from(&self.mean).force_n;
            least = min(least, (g.x * f.x + g.z * f.z) / max(size, R::of(1e-6)));
            turn = min(turn, if f.y < R::zero() { -g.y } else { g.y });
        }
        let noise = sqrt(self.variance);
        let moved = [
            (away.x * f.x + away.z * f.z) / max(size, R::of(1e-6)),
            if f.y < R::zero() { -away.y } else { away.y },
        ];
        for ((bound, load), (moved, sigma)) in
            self.bound_m_n.iter_mut().zip([least, turn]).zip(moved.into_iter().zip(sigma_m))
        {
            *bound = min(
                *bound + *bound * self.params.bound_fade,
                self.params.softest_m_n * self.params.doubt_sigmas,
            );
            if load > noise * self.params.taught_sigmas {
                let most = max(moved, R::zero()) + *sigma * self.params.bound_sigmas + late;
                *bound = min(*bound, most / load * (R::one() + self.params.nonlinear));
            }
        }
    }

    /// Learns from a departure of place while nothing slips, m.
    pub fn learn(&mut self, away: &Vec3<R>) {
        let [now, ..] = self.recent;
        let Cause { force_n: f, velocity_m_s: v } = now.from(&self.mean);
        let along = |a: &Vec3<R>, b: &Vec3<R>| a.x * b.x + a.z * b.z;
        let loaded = along(&f, &f) > self.variance * self.params.taught_sigmas * self.params.taught_sigmas;
        if !loaded && !(along(&v, &v) > self.params.taught_m_s * self.params.taught_m_s) {
            return;
        }
        let new = Sums {
            square: [along(&f, &f), along(&f, &v), along(&v, &v)],
            product: [along(&f, away), along(&v, away)],
            turn: [f.y * f.y, f.y * away.y],
        };
        let add = |sum: &mut R, x: R| *sum += x - *sum * self.params.fade;
        let s = &mut self.sums;
        s.square.iter_mut().zip(new.square).for_each(|(sum, x)| add(sum, x));
        s.product.iter_mut().zip(new.product).for_each(|(sum, x)| add(sum, x));
        s.turn.iter_mut().zip(new.turn).for_each(|(sum, x)| add(sum, x));
        let (a, b, c) = self.normal_equations();
        let [fp, vp] = self.sums.product;
        let determinant = a * c - b * b;
        let most = self.params.doubt_sigmas;
        let compliance = (c * fp - b * vp) / determinant;
        let apart_s = (a * vp - b * fp) / determinant;
        let turn = self.sums.turn[1] / (self.sums.turn[0] + self.ridge[0]);
        let softest = self.params.softest_m_n * most;
        let late = self.params.apart_s * most;
        self.answer = [
            clamp(compliance, R::zero(), softest),
            clamp(turn, R::zero(), softest),
            clamp(apart_s, -late, late),
        ];
    }

    fn normal_equations(&self) -> (R, R, R) {
        let [ff, fv, vv] = self.sums.square;
        (ff + self.ridge[0], fv, vv + self.ridge[1])
    }

    /// Departure that a load and a velocity explain, m.
    pub(super) fn explains(&self, cause: &Cause<R>) -> Vec3<R> {
        let [along, turn, apart_s] = self.answer;
        let away = cause.from(&self.mean);
        let (f, v) = (away.force_n, away.velocity_m_s);
        Vec3::new(f.x * along + v.x * apart_s, f.y * turn, f.z * along + v.z * apart_s)
    }

    /// Of the smoothed load.
    pub fn explained(&self) -> Vec3<R> {
        self.explains(&self.smooth)
    }

    /// Of the last sample's load.
    pub fn explained_now(&self) -> Vec3<R> {
        self.explains(&self.recent[0])
    }

    /// What of a departure no elastic pad and no late pose explains, m: its distance from all places that
    /// `C f + tau v` may be, with a compliance between none and the softest that the loads so far leave.
    /// `unknown`: what of [`Shear::unknown`] counts.
    pub(super) fn beyond(&self, departure: &Vec3<R>, cause: &Cause<R>, unknown: &[R; 3]) -> Vec3<R> {
        let away = cause.from(&self.mean);
        let [along, turn, _] = self.answer;
        let [along_unknown, turn_unknown, apart_unknown_s] = *unknown;
        let mut left = departure - self.explains(cause);
        let [most, most_turn] = self.bound_m_n;
        let soft = clamp(most - along, R::zero(), along * self.params.nonlinear + along_unknown);
        inside(&mut left, &away.force_n, min(along, soft), soft);
        inside(&mut left, &away.velocity_m_s, apart_unknown_s, apart_unknown_s);
        let [now, mean] = self.normal_n;
        let eased =
            if now > R::of(0.02) { min(max(mean - now, R::zero()) / now, R::one()) } else { R::zero() };
        inside(&mut left, &cause.force_n, R::zero(), along * eased);
        let soft = clamp(most_turn - turn, R::zero(), turn * self.params.nonlinear + turn_unknown);
        let f = away.force_n.y;
        let (a, b) = (-f * min(turn, soft), f * soft + cause.force_n.y * turn * eased);
        let y = left.y;
        left.y = y - clamp(y, min(a, b), max(a, b));
        left
    }

    /// Standard deviations of the posterior that count: compliance along the face, of the turn, time apart.
    pub(super) fn unknown(&self) -> [R; 3] {
        let (a, b, c) = self.normal_equations();
        let determinant = a * c - b * b;
        let many = self.params.noise_m * self.params.doubt_sigmas;
        let root = |x: R| sqrt(max(x, R::zero()));
        [
            many * root(c / determinant),
            many / root(self.sums.turn[0] + self.ridge[0]),
            many * root(self.params.alike * a / determinant) + self.answer[2].abs() * self.params.late_share,
        ]
    }

    /// Departure by a load that is measured at another moment than the pose, along the face and of the turn, m.
    pub(super) fn skew_m(&self, unknown: &[R; 3]) -> [R; 2] {
        let [along, turn, _] = self.answer;
        let [along_unknown, turn_unknown, _] = *unknown;
        let skew = self.rate_n_s * self.params.skew_s;
        let [most, most_turn] = self.bound_m_n;
        [min(along + along_unknown, most) * skew, min(turn + turn_unknown, most_turn) * skew]
    }
}

/// Takes from a departure along the face what lies between `-less` and `more` times `way`.
fn inside<R: Real>(left: &mut Vec3<R>, way: &Vec3<R>, less: R, more: R) {
    let square = way.x * way.x + way.z * way.z;
    if !(square > R::of(1e-12)) {
        return;
    }
    let share = clamp((left.x * way.x + left.z * way.z) / square, -less, more);
    left.x -= way.x * share;
    left.z -= way.z * share;
}
