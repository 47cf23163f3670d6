//! Fingers that bear less than the weight that they bore let the object fall (Newton).
//!
//! The force that bears the object, over what the model expects, is held against its own
//! slow mean by a cumulative sum (Page 1954): `S = max(0, S + (mean - share) / sigma - k)`,
//! an alarm at `S > h`. Noise that is not white sums to more than its samples show: `sigma` is that of block
//! means, times the root of a block's length (the long-run standard deviation), where that is more; by the
//! differences of consecutive blocks, in which a deficit that grows hardly shows. Deficits below a twentieth of the weight
//! never add up. An alarm is raised only where the model's weight has proven right, and while the planned motion stays.

use crate::real::{Real, clamp, max, min, sqrt};
use crate::tuning::tuned;

/// Samples in a block: 32 ms at 250 Hz, longer than the correlation of filtered noise.
const BLOCK: u8 = 8;

tuned! {
    /// What was chosen in it.
    pub struct BearingParams<R> {
        /// Deficit that is none, as a share of the weight: pads that settle and poses that turn. Doubled: falls that
        /// lose less than a tenth of the weight are not detected.
        allowed_share: R = R::of(0.05), 0.0 to 1.0;
        /// The same in standard deviations: half of the least deficit to be found soonest. Doubled: small deficits
        /// are detected later.
        allowed_sigmas: R = R::of(0.9), 0.01 to 100.0;
        /// By chance once in a hundred hours, `exp(2 k h) / (2 k^2)` samples apart (Siegmund 1985): `2 k h`.
        /// Doubled: falls are detected twice as late, by chance never.
        chance: R = R::of(19.0), 0.1 to 1000.0;
        /// After so many samples it does not fall but rests elsewhere, or has been dropped: 0.4 s, in which it falls
        /// by 0.8 m. Doubled: the alarm stands that much longer.
        fallen_samples: u8 = 100, 1.0 to 250.0;
        /// The model's weight is right if it is borne for a while within this share. Doubled: objects that rest on
        /// something pass for held.
        weight_share: R = R::of(0.15), 0.0 to 10.0;
        /// Time constant of the mean, s. Doubled: a new load is known that much later.
        borne_s: R = R::of(0.3), 0.004 to 100.0;
        /// Time constant of the noise, s, over `noise_share`. Doubled: a change of noise is known later.
        noise_s: R = R::of(0.2), 0.004 to 100.0;
        /// A sample's share in the noise, of that of its time constant. Doubled: as half of `noise_s`.
        noise_share: R = R::of(0.1), 0.001 to 1.0;
        /// First guess of the noise, share of the weight. Doubled: falls in the first second are detected later.
        noise: R = R::of(0.03), 1e-4 to 10.0;
        /// Time constant of noise that has just begun, s. Doubled: a knock of 40 ms passes for a fall.
        sudden_s: R = R::of(0.04), 0.004 to 10.0;
        /// How much more than it one difference counts, in squares. Doubled: a fall counts as noise for a sample longer.
        sudden_most: R = R::of(4.0), 1.0 to 1000.0;
        /// A sample counts up to so many standard deviations in mean and noise: a knock is neither. Doubled: it is both.
        counted_sigmas: R = R::of(2.5), 0.1 to 100.0;
        /// A sample counts up to so many in the deficit: three of them are a fall. Doubled: two are.
        sample_share: R = R::of(0.4), 0.01 to 10.0;
        /// A fall lacks this share of the weight at least, summed over the samples. Doubled: falls of light objects
        /// are detected twice as late.
        lost_share: R = R::of(0.15), 0.0 to 10.0;
        /// Less than this bears nothing, N: ten times the noise of a sensor. Doubled: objects of 20 to 40 g are not followed.
        least_n: R = R::of(0.2), 0.001 to 100.0;
        /// Share with which a block enters the long-run variance: 0.6 s at 250 Hz. Doubled: known, and forgotten, in half of it.
        block_share: R = R::of(0.05), 0.001 to 1.0;
        /// Share of the alarm's bar from which the object may be falling. Doubled: the pose is believed later.
        suspect_share: R = R::of(0.4), 0.0 to 2.0;
    }
}

/// State.
#[derive(Clone, Debug)]
pub struct Bearing<R: Real> {
    params: BearingParams<R>,
    /// Mean of the force that bears the object, over the model's; variance of a sample.
    mean: R,
    variance: R,
    /// Of the last differences, and the last share: noise that has just begun counts at once.
    sudden: R,
    last: R,
    deficit: R,
    suspect: bool,
    /// Sum of the present block, samples in it, blocks so far, and the variance of a block's mean times its length.
    block: R,
    count: u8,
    blocks: u8,
    last_block: R,
    long_run: R,
    fallen: u8,
    /// Samples so far: the first count more.
    age: u8,
    /// They are of the rest before the tare.
    rested: bool,
}

impl<R: Real> Default for Bearing<R> {
    fn default() -> Self {
        Self::new(BearingParams::default())
    }
}

impl<R: Real> Bearing<R> {
    /// Nothing was borne yet.
    pub fn new(params: BearingParams<R>) -> Self {
        let variance = params.noise * params.noise;
        Self {
            params,
            mean: R::zero(),
            variance,
            sudden: variance,
            last: R::zero(),
            deficit: R::zero(),
            suspect: false,
            block: R::zero(),
            count: 0,
            blocks: 0,
            last_block: R::zero(),
            long_run: R::zero(),
            fallen: 0,
            age: 0,
            rested: false,
        }
    }

    /// Nothing borne yet, the noise known.
    fn noise_alone(&self) -> Self {
        Self {
            variance: self.variance,
            long_run: self.long_run,
            blocks: self.blocks,
            ..Self::new(self.params)
        }
    }

    /// The object may be falling.
    pub fn suspect(&self) -> bool {
        self.suspect
    }

    /// One sample: the force that bears the object, measured and by the model, N; `resting`: before the tare, where nothing
    /// is flagged yet. For how many samples it has been falling; zero where it is borne.
    pub fn falls(&mut self, bearing_n: Option<[R; 2]>, resting: bool, steered: bool, dt_s: R) -> u8 {
        let weighed = bearing_n.filter(|[_, model]| *model > self.params.least_n);
        if weighed.is_none() || self.fallen >= self.params.fallen_samples || self.rested && !resting {
            *self = self.noise_alone();
        }
        let Some([measured, model]) = weighed else { return 0 };
        let share = measured / model;
        let change = share - self.last;
        self.last = share;
        if resting {
            self.rest(share);
            return 0;
        }
        // A fall is a few large differences, noise many.
        let square = min(change * change * R::of(0.5), self.sudden * self.params.sudden_most);
        self.sudden += (square - self.sudden) * min(dt_s / self.params.sudden_s, R::one());
        let sigma = max(sqrt(max(max(self.variance, self.sudden), self.long_run)), R::of(1e-3));
        let allowed = max(self.params.allowed_share / sigma, self.params.allowed_sigmas);
        let enough = max(self.params.chance * R::of(0.5) / allowed, self.params.lost_share / sigma);
        let right = (self.mean - R::one()).abs() < self.params.weight_share;
        if right && !steered {
            let most = enough * self.params.sample_share;
            let gain = clamp((min(self.mean, R::one()) - share) / sigma - allowed, -most, most);
            self.deficit = clamp(self.deficit + gain, R::zero(), enough * R::of(2.0));
        } else {
            self.deficit = R::zero();
        }
        self.suspect = self.deficit > enough * self.params.suspect_share;
        if self.deficit > enough {
            self.fallen = self.fallen.saturating_add(1);
            return self.fallen;
        }
        self.fallen = 0;
        self.age = self.age.saturating_add(1);
        let first = R::one() / R::of(f64::from(self.age));
        let counted = if self.age < u8::MAX && !right {
            share - self.mean
        } else {
            clamp(share - self.mean, -sigma * self.params.counted_sigmas, sigma * self.params.counted_sigmas)
        };
        self.mean += counted * max(min(dt_s / self.params.borne_s, R::one()), first);
        if right {
            let slow = min(dt_s / self.params.noise_s, R::one()) * self.params.noise_share;
            self.variance += (counted * counted - self.variance) * slow;
            self.note_block(counted);
        }
        0
    }

    /// One sample of the rest before the tare, in which constant errors are in it yet: noise is all that it tells.
    fn rest(&mut self, share: R) {
        self.rested = true;
        self.age = self.age.saturating_add(1);
        let part = R::one() / R::of(f64::from(self.age));
        self.mean += (share - self.mean) * part;
        let away = share - self.mean;
        if self.age > 1 {
            self.variance += (away * away - self.variance) * part;
            self.note_block(away);
        }
    }

    /// The long-run variance, by the differences of blocks.
    fn note_block(&mut self, away: R) {
        self.block += away;
        self.count += 1;
        if self.count < BLOCK {
            return;
        }
        self.blocks = self.blocks.saturating_add(1);
        // The first count the same.
        let share = max(self.params.block_share, R::one() / R::of(f64::from(self.blocks)));
        let change = self.block - self.last_block;
        let square = change * change * R::of(0.5 / f64::from(BLOCK));
        self.long_run += (square - self.long_run) * share;
        (self.last_block, self.block, self.count) = (self.block, R::zero(), 0);
    }
}
