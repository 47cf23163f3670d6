//! Which of the trials a calibration is found from; the rest validate it.

/// Most calibration trials: more of them only cost time.
pub const MOST_TRIALS: usize = 60;
/// Fewest that a calibration should have: its intervals come from their scatter.
pub const FEWEST_TRIALS: usize = 8;

/// How many of the trials friction is found from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// Share of them.
    pub share: f64,
    /// At least so many, where there are as many.
    pub fewest: usize,
}

impl Share {
    /// A share of the trials, at least [`FEWEST_TRIALS`].
    pub fn of(share: f64) -> Self {
        Self { share, fewest: FEWEST_TRIALS }
    }
}

/// Places of the calibration trials in a list of `conditions`, one for each trial: a `share`
/// of them, of as many conditions as
/// possible and spread evenly over the list, so that whatever changes along it is touched.
pub fn pick<C: PartialEq>(conditions: &[C], share: Share) -> Vec<usize> {
    let count = conditions.len();
    let wanted = ((count as f64 * share.share).round() as usize)
        .clamp(share.fewest.min(count), MOST_TRIALS.max(share.fewest).min(count));
    // Multiples of the golden ratio fill the range evenly and never fall in step with a
    // regular plan.
    let mut taken: Vec<usize> = Vec::with_capacity(wanted);
    let mut k = 0u32;
    while taken.len() < wanted {
        let at = (f64::from(k) * 0.618_033_988_749_895 + 0.3).fract();
        k += 1;
        let i = ((at * count as f64) as usize).min(count - 1);
        let after = || (0..count).map(|d| (i + d) % count).filter(|i| !taken.contains(i));
        let new = |i: &usize| taken.iter().all(|t| conditions[*t] != conditions[*i]);
        let next = after().find(new).or_else(|| after().next());
        taken.extend(next);
    }
    taken.sort_unstable();
    taken
}
