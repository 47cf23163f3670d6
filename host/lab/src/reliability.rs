//! Whether the probabilities that the predictor states come true on simulated grasps.
//!
//! A grasp that is said to hold with `p` shall hold in a share `p` of the cases: no gross slip begins within
//! [`SOON_S`]. Neighbouring ticks say the same, so each trial counts once in each bin: at its first tick there. And in a share
//! of the trials as great as stated the coefficient at which the object truly lets go (the key's) shall lie above the
//! stated quantiles of friction, 20 ms before the first slip, or at the end.

use serde::Serialize;
use stickslip_analysis::score::warnings::{Share, TrialKey};
use stickslip_shared::predictor::{Prediction, validity};

use crate::grasps::Grasp;

/// A grasp that is said to hold does for so long, s: the predictor's horizon.
pub const SOON_S: f64 = 0.1;
/// Sensors are tared, and the noise is learnt, by then, s.
const BEGIN_S: f64 = 0.3;
/// Before a slip by this nothing tells of it but its cause, s.
const BEFORE_S: f64 = 0.02;
/// Ends of the bins.
pub const EDGES: [f64; 10] = [0.0, 0.25, 0.5, 0.75, 0.9, 0.95, 0.98, 0.99, 0.999, 1.0];

/// What is stated in a bin, and what came of it.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Bin {
    /// Sum of what the trials' first ticks in it state.
    pub stated: f64,
    /// Trials that held, of those with a tick in it.
    pub trials: Share,
    /// The same of ticks.
    pub ticks: Share,
}

impl Bin {
    fn join(&mut self, other: &Self) {
        self.stated += other.stated;
        self.trials.join(&other.trials);
        self.ticks.join(&other.ticks);
    }

    /// Mean of what is stated; `None` of nothing.
    #[must_use]
    pub fn mean(&self) -> Option<f64> {
        (self.trials.of > 0).then(|| self.stated / self.trials.of as f64)
    }
}

/// Statements of some trials, and what came true.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Stated {
    /// Of holding, by the probability: those between two neighbouring [`EDGES`].
    pub holds: [Bin; EDGES.len() - 1],
    /// Trials whose friction lies above the median stated, ...
    pub above_median: Share,
    /// ... and above the least.
    pub above_least: Share,
}

impl Stated {
    /// Of one trial.
    #[must_use]
    pub fn of(truth: &TrialKey, t_s: &[f64], predictions: &[Prediction], until_s: f64) -> Self {
        let mut out = Self::default();
        let slip_s = truth.episodes.iter().map(|[from, ..]| *from).reduce(f64::min);
        let end_s = slip_s.unwrap_or(until_s).min(until_s);
        let ticks = || t_s.iter().zip(predictions).take_while(|(t, _)| **t < end_s);
        let usable = |p: &Prediction| p.validity & validity::UNRELIABLE == 0;
        for (t, p) in ticks().filter(|(t, p)| **t >= BEGIN_S && usable(p)) {
            let Some(stated) = p.hold_probability.map(f64::from) else { continue };
            let place = EDGES.iter().rposition(|e| stated >= *e).unwrap_or(0).min(EDGES.len() - 2);
            let Some(bin) = out.holds.get_mut(place) else { continue };
            let held = slip_s.is_none_or(|s| s > t + SOON_S);
            if bin.trials.of == 0 {
                bin.stated = stated;
                bin.trials.count(held);
            }
            bin.ticks.count(held);
        }
        let known = ticks().take_while(|(t, _)| **t < end_s - BEFORE_S).last();
        if let (Some(mu), Some((_, p))) = (truth.mu, known) {
            out.above_median.count(mu > f64::from(p.friction));
            out.above_least.count(mu > f64::from(p.friction_least));
        }
        out
    }

    /// The same of a grasp.
    #[must_use]
    pub fn of_grasp(grasp: &Grasp<'_>, predictions: &[Prediction]) -> Self {
        Self::of(grasp.truth, &grasp.t_s, predictions, grasp.until_s)
    }

    /// Those of more trials.
    pub fn join(&mut self, other: &Self) {
        self.holds.iter_mut().zip(&other.holds).for_each(|(sum, bin)| sum.join(bin));
        self.above_median.join(&other.above_median);
        self.above_least.join(&other.above_least);
    }
}
