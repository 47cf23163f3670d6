//! Which sensors can be believed: missing, not finite, stuck, saturated, biased.
//!
//! Each fault shows within a few samples. A real sensor's noise seldom repeats all six components: how
//! often is a matter of its noise over its resolution, and is counted. A run of equal readings that
//! chance makes once in a million is a stuck sensor: the third equal reading of one that never
//! repeated itself, the twentieth of a converter so quiet that every other reading is the same
//! (only for sensors that were seen to vary; a noiseless simulation is not accused); a component at its range is saturated;
//! while nothing else touches the object sideways, the two fingers' normal forces cancel. The object's pose is
//! judged by its repetitions in the same way: a tracker that has lost its markers often goes on with the last pose.
//! One whose frames are each given for as many samples is held between the frames of a slower camera: it is late.
//! Motion alone shows no noise: only a pose that was seen to go to and fro from one sample to the next is accused.

use crate::predictor::types::{Limits, Sample, validity};
use crate::real::{Real, Vec3, norm};
use crate::track::Pose;
use crate::tuning::tuned;

tuned! {
    /// What was chosen, not derived: value, unit, why, and what happens if it is doubled. For sensors and rates
    /// that differ from 250 Hz.
    pub struct Params {
        /// Equal readings in a row that at least make a sensor stuck: two are common. Doubled: a dead sensor
        /// is believed for 12 ms more.
        stuck: u16 = 3, 2.0 to 1000.0;
        /// Equal readings in a row that make any sensor stuck: a second. Doubled: two.
        surely_stuck: u16 = 250, 2.0 to 10000.0;
        /// Equal poses in a row that make any camera frozen, as `surely_stuck`: 4 s, since a coarse one repeats
        /// itself for as long as the object rests. Doubled: 8 s.
        surely_frozen: u16 = 1000, 2.0 to 10000.0;
        /// Steps of a pose from sample to sample below this length are rounding, m. Doubled: nothing, poses are not
        /// measured to a micrometre.
        rounding_m: f32 = 1e-6, 0.0 to 0.001;
        /// One step in so many goes back where the last came from, at least, in a pose with noise: three in four at
        /// rest, few in quick motion. Doubled: a pose that freezes after 8 s of quick motion is found, and a
        /// noiseless one that was shaken at 10 Hz is accused.
        turns: u16 = 10, 1.0 to 1000.0;
        /// Runs of equal poses, each as long as the one before within a sample, that show a slower camera whose frames are held: by
        /// chance, of runs of three, one in 65,000. Doubled: a camera of 31 Hz is found out after a second.
        held: u8 = 16, 1.0 to 200.0;
        /// Chance of a run of equal readings below which it is none: one false alarm in an hour at 250 Hz.
        /// Doubled: two.
        chance: f32 = 1e-6, 1e-30 to 0.5;
        /// Changes after which repetition may be a fault: a sensor that was seen to live. Doubled: a sensor
        /// that dies within its first 128 ms is not found.
        lively: u16 = 16, 1.0 to 10000.0;
        /// Readings after which the older ones count half: 4 s. Doubled: a change of noise is followed
        /// later.
        remembered: u16 = 1024, 16.0 to 30000.0;
        /// Samples in a row with unequal normal forces that make a bias: a wild reading comes alone or in
        /// pairs. Doubled: a bias is seen 12 ms later.
        biased: u8 = 3, 1.0 to 100.0;
    }
}

/// Memory of the checks.
#[derive(Clone, Debug)]
pub struct Health<R: Real> {
    params: Params,
    last: [[R; 6]; 2],
    repetition: [Repetition; 2],
    object: Option<Pose<R>>,
    object_repetition: Repetition,
    object_hold: Hold,
    object_jitter: Jitter<R>,
    unequal: u8,
    unequal_by_n: R,
}

impl<R: Real> Default for Health<R> {
    fn default() -> Self {
        Self::new(Params::default())
    }
}

impl<R: Real> Health<R> {
    /// Of sensors of which nothing was seen yet.
    pub fn new(params: Params) -> Self {
        let zero = R::zero();
        Self {
            params,
            last: [[zero; 6]; 2],
            repetition: [Repetition::default(); 2],
            object: None,
            object_repetition: Repetition::default(),
            object_hold: Hold::default(),
            object_jitter: Jitter { step_m: Vec3::zeros(), steps: 0, turns: 0 },
            unequal: 0,
            unequal_by_n: zero,
        }
    }

    /// Wrenches that can be used (finger 1, 2), and the bits of [`validity`] for the others.
    pub fn check(&mut self, sample: &Sample<R>, limits: &Limits) -> ([Option<[R; 6]>; 2], u32) {
        let mut bits = 0;
        let mut usable = [None; 2];
        let missing = sample.finger.iter().filter(|f| f.is_none()).count();
        if missing > 0 {
            bits |= validity::NO_WRENCH;
        }
        if missing == 1 {
            bits |= validity::ONE_FINGER;
        }
        let range = [limits.force_range_n, limits.torque_range_nm].map(|x| R::of(f64::from(x)));
        let memory = self.last.iter_mut().zip(&mut self.repetition);
        for ((wrench, used), (last, repetition)) in sample.finger.iter().zip(&mut usable).zip(memory) {
            let Some(w) = wrench else { continue };
            if !w.iter().all(|x| x.finite()) {
                bits |= validity::WRENCH;
                continue;
            }
            let stuck = repetition.note(w == last, &self.params);
            *last = *w;
            let saturated = w.iter().enumerate().any(|(i, x)| {
                let most = if i < 3 { range[0] } else { range[1] };
                x.abs() >= most
            });
            if stuck {
                bits |= validity::STUCK;
            }
            if saturated {
                bits |= validity::SATURATED;
            }
            if !stuck && !saturated {
                *used = Some(*w);
            }
        }
        (usable, bits)
    }

    /// How the object's pose repeats itself beyond what its noise makes of it.
    pub fn repeats(&mut self, object: &Pose<R>) -> Repeats {
        let equal = self.object.as_ref() == Some(object);
        if let Some(last) = self.object.filter(|_| !equal) {
            self.object_jitter.note(object.position_m - last.position_m, &self.params);
        }
        self.object = Some(*object);
        let params = Params { surely_stuck: self.params.surely_frozen, ..self.params };
        let frozen = self.object_repetition.note(equal, &params);
        let held = self.object_hold.note(equal, &params);
        match (self.object_jitter.is_seen(&params), frozen, held) {
            (true, true, _) => Repeats::Frozen,
            (true, false, true) => Repeats::Held,
            _ => Repeats::No,
        }
    }

    /// Whether normal forces that must cancel do not, beyond `allowed_n`; `sum_n` is what is left of them.
    pub fn biased(&mut self, sum_n: R, allowed_n: R) -> bool {
        let beyond = sum_n.abs() > allowed_n;
        self.unequal = if beyond { self.unequal.saturating_add(1).min(self.params.biased) } else { 0 };
        self.unequal_by_n = sum_n;
        self.unequal >= self.params.biased
    }
}

/// How a pose repeats itself beyond what its noise makes of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repeats {
    /// It does not.
    No,
    /// It is measured no more.
    Frozen,
    /// Each frame of a slower camera is given for several samples: it is late by half of them on the mean.
    Held,
}

/// Runs of equal poses that are all as long: a camera that is slower than the samples holds its frames.
#[derive(Clone, Copy, Debug, Default)]
struct Hold {
    /// Equal ones in the present run, and in the last.
    run: u8,
    length: u8,
    /// Runs in a row as long as the one before.
    regular: u8,
}

impl Hold {
    fn note(&mut self, equal: bool, params: &Params) -> bool {
        if equal {
            self.run = self.run.saturating_add(1);
        } else {
            let alike = self.run > 1 && self.run.abs_diff(self.length) <= 1;
            self.regular = if alike { self.regular.saturating_add(1).min(params.held) } else { 0 };
            (self.length, self.run) = (self.run, 0);
        }
        self.regular >= params.held
    }
}

/// Whether a position goes to and fro from one sample to the next, as noise does and motion does not.
#[derive(Clone, Copy, Debug)]
struct Jitter<R: Real> {
    step_m: Vec3<R>,
    steps: u16,
    /// Steps back where the last came from.
    turns: u16,
}

impl<R: Real> Jitter<R> {
    fn note(&mut self, step_m: Vec3<R>, params: &Params) {
        if norm(&step_m) < R::of(f64::from(params.rounding_m)) {
            return;
        }
        let turns = step_m.dot(&self.step_m) < R::zero();
        self.step_m = step_m;
        self.steps = self.steps.saturating_add(1);
        self.turns = self.turns.saturating_add(u16::from(turns));
        if self.steps >= params.remembered {
            (self.steps, self.turns) = (self.steps / 2, self.turns / 2);
        }
    }

    fn is_seen(&self, params: &Params) -> bool {
        self.turns >= params.lively && self.turns >= self.steps / params.turns.max(1)
    }
}

/// How a sensor's readings repeat themselves.
#[derive(Clone, Copy, Debug, Default)]
struct Repetition {
    /// In a row, now.
    equal: u16,
    /// Readings that changed.
    changes: u16,
    /// Runs of equal readings between them, and repetitions in all of these.
    runs: u16,
    repeats: u16,
}

impl Repetition {
    /// Books a reading; `true` where it is one too many of equal ones.
    fn note(&mut self, equal: bool, params: &Params) -> bool {
        if equal {
            self.equal = self.equal.saturating_add(1);
            return self.changes >= params.lively && self.equal >= self.most(params);
        }
        // A run that was a fault tells nothing of the noise.
        if self.equal > 0 && (self.changes < params.lively || self.equal < self.most(params)) {
            self.runs = self.runs.saturating_add(1);
            self.repeats = self.repeats.saturating_add(self.equal);
        }
        self.changes = self.changes.saturating_add(1);
        self.equal = 0;
        if self.changes.saturating_add(self.repeats) >= params.remembered {
            let Self { changes, runs, repeats, .. } = *self;
            *self =
                Self { equal: 0, changes: changes / 2, runs: runs.div_ceil(2), repeats: repeats.div_ceil(2) };
        }
        false
    }

    /// Repetitions in a row that chance hardly makes: the least `n` with `p q^(n-1)` below [`Params::chance`], `p`
    /// the share of runs among changes, `q` that of repetitions that another one followed. (A quiet converter
    /// repeats its commonest reading more often than others: `q` is above `p`.)
    fn most(&self, params: &Params) -> u16 {
        let share = |of: u16, all: u16| f32::from(of) / f32::from(all.max(1));
        let mut chance = share(self.runs, self.changes.saturating_add(self.runs));
        let again = (self.repeats - self.runs.min(self.repeats)).saturating_add(u16::from(self.runs > 0));
        let again = share(again, self.repeats.saturating_add(1));
        let mut count = 1;
        while chance > params.chance && count < params.surely_stuck {
            chance *= again;
            count += 1;
        }
        count.max(params.stuck.saturating_sub(1))
    }
}
