//! The noise floor of measurements: what differs between runs of equal conditions, for each
//! channel and phase, whatever its cause (pure error), beside the sensors' white noise.
//!
//! Runs are aligned at contact onset and compared sample by sample on the first run's times:
//! pooled variance `sum (x - mean)^2 / sum (n - 1)`. Without repetitions there is no floor:
//! `None`, never zero.

use crate::channels::{COUNT, Signals};
use crate::dataset::TrialInfo;

/// One run, as the noise floor sees it.
#[derive(Clone, Copy, Debug)]
pub struct Run<'r> {
    /// Time stamps.
    pub t_s: &'r [f64],
    /// Time of contact: the zero of alignment.
    pub onset_s: f64,
    /// One for each time stamp.
    pub signals: &'r [Signals],
    /// Phase of each sample, below `P`.
    pub phase: &'r [usize],
}

/// Pooled sum of squares.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Pool {
    squares: f64,
    degrees: f64,
    groups: usize,
}

/// Pure error of each channel in each of `P` phases.
#[derive(Clone, Debug, PartialEq)]
pub struct PureError<const P: usize> {
    pools: Vec<[Pool; P]>,
}

impl<const P: usize> Default for PureError<P> {
    fn default() -> Self {
        PureError { pools: vec![[Pool::default(); P]; COUNT] }
    }
}

impl<const P: usize> PureError<P> {
    /// Adds one group of runs of equal conditions; fewer than two add nothing.
    pub fn add(&mut self, runs: &[Run<'_>]) {
        let Some((first, others)) = runs.split_first() else { return };
        let mut fresh = vec![[Pool::default(); P]; COUNT];
        let mut cursors = vec![0; others.len()];
        for ((t_s, signals), phase) in first.t_s.iter().zip(first.signals).zip(first.phase) {
            let since_s = t_s - first.onset_s;
            let rows: Vec<Signals> = others
                .iter()
                .zip(&mut cursors)
                .filter_map(|(run, cursor)| at(run, since_s + run.onset_s, cursor))
                .collect();
            for (channel, pools) in fresh.iter_mut().enumerate() {
                let Some(pool) = pools.get_mut(*phase) else { continue };
                let values = std::iter::once(signals)
                    .chain(&rows)
                    .filter_map(|row| row.get(channel).copied())
                    .filter(|value| !value.is_nan());
                let (count, sum) = values.clone().fold((0.0, 0.0), |(n, s), x| (n + 1.0, s + x));
                if count >= 2.0 {
                    let mean: f64 = sum / count;
                    pool.squares += values.map(|x| (x - mean).powi(2)).sum::<f64>();
                    pool.degrees += count - 1.0;
                    pool.groups = 1;
                }
            }
        }
        self.merge(&PureError { pools: fresh });
    }

    /// Adds what another holds.
    pub fn merge(&mut self, other: &Self) {
        for (mine, others) in self.pools.iter_mut().flatten().zip(other.pools.iter().flatten()) {
            mine.squares += others.squares;
            mine.degrees += others.degrees;
            mine.groups += others.groups;
        }
    }

    /// Standard deviation between runs; `None` where nothing was repeated.
    #[must_use]
    pub fn sigma(&self, channel: usize, phase: usize) -> Option<f64> {
        let pool = self.pools.get(channel)?.get(phase)?;
        (pool.degrees > 0.0).then(|| (pool.squares / pool.degrees).sqrt())
    }

    /// Groups of runs behind [`PureError::sigma`].
    #[must_use]
    pub fn groups(&self, channel: usize, phase: usize) -> usize {
        self.pools.get(channel).and_then(|pools| pools.get(phase)).map_or(0, |pool| pool.groups)
    }
}

/// A run's channels at a time, linear between samples; `None` outside its samples.
fn at(run: &Run<'_>, t_s: f64, cursor: &mut usize) -> Option<Signals> {
    while run.t_s.get(*cursor + 1).is_some_and(|next| *next <= t_s) {
        *cursor += 1;
    }
    let (from_s, from) = (*run.t_s.get(*cursor)?, run.signals.get(*cursor)?);
    if t_s < from_s {
        return None;
    }
    let Some((to_s, to)) = run.t_s.get(*cursor + 1).copied().zip(run.signals.get(*cursor + 1)) else {
        return (t_s == from_s).then_some(*from);
    };
    let share = (t_s - from_s) / (to_s - from_s);
    let mut row = *from;
    if share > 0.0 {
        for (value, next) in row.iter_mut().zip(to) {
            *value += share * (next - *value);
        }
    }
    Some(row)
}

/// Trials that share every condition, as places in `infos`, in order of first appearance; a
/// group of one is no repetition.
#[must_use]
pub fn repetitions(infos: &[TrialInfo]) -> Vec<Vec<usize>> {
    let same = |a: &TrialInfo, b: &TrialInfo| {
        // Everything but the name, the file and the run; free columns are conditions too only
        // where the format says so, which it does not.
        a.object == b.object
            && a.primitive == b.primitive
            && a.grip_n == b.grip_n
            && a.speed_m_s == b.speed_m_s
            && a.speed_rad_s == b.speed_rad_s
            && a.slope_rad == b.slope_rad
            && a.pusher_offset_m == b.pusher_offset_m
            && a.run.is_some()
            && b.run.is_some()
            && a.run != b.run
    };
    let key = |info: &TrialInfo| {
        let bits = |number: Option<f64>| number.map(f64::to_bits);
        (
            info.object.clone(),
            info.primitive.clone(),
            [info.grip_n, info.speed_m_s, info.speed_rad_s, info.slope_rad, info.pusher_offset_m].map(bits),
        )
    };
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut by_key = std::collections::BTreeMap::new();
    for (place, info) in infos.iter().enumerate() {
        let group = *by_key.entry(key(info)).or_insert_with(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        let Some(members) = groups.get_mut(group) else { continue };
        if members.iter().all(|member| infos.get(*member).is_some_and(|other| same(other, info))) {
            members.push(place);
        } else {
            // Equal conditions without a run, or a run number twice: no repetition.
            groups.push(vec![place]);
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pure_error_is_the_pooled_standard_deviation_after_alignment() {
        // Two runs of one ramp, the second starting 0.1 s later and 2 units higher.
        let t_s: Vec<f64> = (0..50).map(|k| f64::from(k) * 0.01).collect();
        let ramp = |late_s: f64, up: f64| -> Vec<Signals> {
            t_s.iter()
                .map(|t| {
                    let mut row = [f64::NAN; COUNT];
                    row[6] = t - late_s + up;
                    row
                })
                .collect()
        };
        let (a, b) = (ramp(0.0, 0.0), ramp(0.1, 2.0));
        let phase = vec![1; t_s.len()];
        let run = |signals, onset_s| Run { t_s: &t_s, onset_s, signals, phase: &phase };
        let mut floor = PureError::<2>::default();
        floor.add(&[run(&a, 0.1), run(&b, 0.2)]);
        // Two values 2 apart: standard deviation sqrt(2).
        let sigma = floor.sigma(6, 1).expect("repeated");
        assert!((sigma - 2f64.sqrt()).abs() < 1e-9, "{sigma}");
        assert_eq!(floor.sigma(6, 0), None, "no sample in that phase");
        assert_eq!(floor.sigma(0, 1), None, "not measured");
        assert_eq!(floor.groups(6, 1), 1);
    }

    #[test]
    fn without_repetition_there_is_no_floor() {
        let info = |name: &str, run, grip_n| TrialInfo {
            trial: name.to_owned(),
            run,
            grip_n,
            ..TrialInfo::default()
        };
        let infos = [
            info("a", Some(1), Some(20.0)),
            info("b", Some(2), Some(20.0)),
            info("c", Some(1), Some(22.0)),
            info("d", None, None),
            info("e", None, None),
        ];
        assert_eq!(repetitions(&infos), [vec![0, 1], vec![2], vec![3], vec![4]]);
        let mut floor = PureError::<1>::default();
        let row = [0.0; COUNT];
        floor.add(&[Run { t_s: &[0.0], onset_s: 0.0, signals: &[row], phase: &[0] }]);
        assert_eq!(floor.sigma(0, 0), None);
    }
}
