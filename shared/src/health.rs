//! Which sensors can be believed: missing, not finite, stuck, saturated, biased.
//!
//! Each fault shows within three samples: a real sensor's noise never repeats all six
//! components, so the third equal reading is a stuck one (only for sensors that were seen
//! to vary; a noiseless simulation is not accused); a component at its range is saturated;
//! while nothing else touches the object sideways, the two fingers' normal forces cancel.

use crate::predictor::types::{Limits, Sample, validity};
use crate::real::Real;

/// Equal readings in a row that make a sensor stuck.
const STUCK: u8 = 3;
/// Changes in a row after which repetition is a fault.
const LIVELY: u8 = 16;
/// Samples in a row with unequal normal forces.
const BIASED: u8 = 3;

/// Memory of the checks.
#[derive(Clone, Debug)]
pub struct Health<R: Real> {
    last: [[R; 6]; 2],
    equal: [u8; 2],
    lively: [u8; 2],
    unequal: u8,
    unequal_by_n: R,
}

impl<R: Real> Default for Health<R> {
    fn default() -> Self {
        let zero = R::zero();
        Self { last: [[zero; 6]; 2], equal: [0; 2], lively: [0; 2], unequal: 0, unequal_by_n: zero }
    }
}

impl<R: Real> Health<R> {
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
        let memory = self.last.iter_mut().zip(&mut self.equal).zip(&mut self.lively);
        for ((wrench, used), ((last, equal), lively)) in sample.finger.iter().zip(&mut usable).zip(memory) {
            let Some(w) = wrench else { continue };
            if !w.iter().all(|x| x.finite()) {
                bits |= validity::WRENCH;
                continue;
            }
            if w == last {
                *equal = equal.saturating_add(1).min(STUCK);
            } else {
                *lively = if *equal == 0 { lively.saturating_add(1).min(LIVELY) } else { *lively };
                *equal = 0;
            }
            *last = *w;
            let stuck = *equal + 1 >= STUCK && *lively >= LIVELY;
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

    /// Whether normal forces that must cancel do not, beyond `allowed_n`; `sum_n` is what is left of them.
    pub fn biased(&mut self, sum_n: R, allowed_n: R) -> bool {
        let beyond = sum_n.abs() > allowed_n;
        self.unequal = if beyond { self.unequal.saturating_add(1).min(BIASED) } else { 0 };
        self.unequal_by_n = sum_n;
        self.unequal >= BIASED
    }
}
