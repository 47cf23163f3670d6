//! The phases of a trial as bins of its samples: what a feature averages over, in `diagnose`, `add`, `refit` and
//! `suggest`. Onset is the first 1.8 mm of the path in contact here, and sliding the rest of it; `compare` splits a trial
//! by the object's motion, and its phases of these names are other samples ([`crate::evidence::phases`]).
//!
//! Bins follow the contact and the path, not the clock, so that trials of different speed
//! and length compare: rest before the contact, its first tenths of a millimetre, the
//! sliding path in equal parts, a pause, the start after it, and the rest at the end.

use crate::run::simulate::{Prepared, Simulated};

/// Number of bins.
pub const BINS: usize = 16;
/// The bin of the onset's peak: not a mean, but the largest departure from the first part of the
/// sliding path.
pub const PEAK: usize = 15;
/// The bin of the last part of the sliding path.
pub const LAST: usize = 10;
/// That of a pause.
pub const PAUSE: usize = 11;
/// That of the start after a pause.
pub const RESTART: usize = 12;
/// Path after the onset at which the fine bins end, m.
const ONSET_EDGES_M: [f64; 4] = [1.5e-4, 4e-4, 9e-4, 1.8e-3];
/// Parts of the path after that.
const PARTS: usize = 6;
/// Path of the bin after a pause, m.
pub const RESTART_M: f64 = 9e-4;
/// Samples closer to a change of phase belong to no bin, s.
const GUARD_S: f64 = 0.016;

/// Phase of a bin.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, schemars::JsonSchema, serde::Serialize,
)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// At rest before the motion.
    Before,
    /// The first 1.8 mm (at most 30 %) of the path in contact.
    Onset,
    /// The largest force in it, beyond what follows.
    Peak,
    /// The rest of the path.
    Sliding,
    /// At rest in the midst of the motion.
    Pause,
    /// The first 0.9 mm after a pause.
    Restart,
    /// At rest after the motion.
    After,
}

impl Phase {
    /// All, in time order.
    pub const ALL: [Phase; 7] = [
        Phase::Before,
        Phase::Onset,
        Phase::Peak,
        Phase::Sliding,
        Phase::Pause,
        Phase::Restart,
        Phase::After,
    ];

    /// The phase of a bin.
    pub fn of(bin: usize) -> Phase {
        match bin {
            0 => Phase::Before,
            1..=4 => Phase::Onset,
            PEAK => Phase::Peak,
            5..=LAST => Phase::Sliding,
            PAUSE => Phase::Pause,
            RESTART => Phase::Restart,
            _ => Phase::After,
        }
    }

    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Phase::Before => "rest before",
            Phase::Onset => "onset",
            Phase::Peak => "peak of the onset",
            Phase::Sliding => "sliding",
            Phase::Pause => "pause",
            Phase::Restart => "restart",
            Phase::After => "rest after",
        }
    }
}

/// Factor on the onset's edges: it is at most 30 % of the path.
fn onset_scale(path_m: f64) -> f64 {
    (0.3 * path_m / ONSET_EDGES_M[3]).min(1.0)
}

/// Lengths of the onset's bins along the path of a trial, m.
pub fn onset_lengths(prepared: &Prepared) -> [f64; 4] {
    let scale = onset_scale(prepared.drive_path()).max(1e-3);
    std::array::from_fn(|k| scale * (ONSET_EDGES_M[k] - if k > 0 { ONSET_EDGES_M[k - 1] } else { 0.0 }))
}

/// Bin of each sample (`None` for samples at the seams), and the samples among which the
/// onset's peak is looked for. `simulated` says when the contact with the pusher begins.
pub fn bins(prepared: &Prepared, simulated: &Simulated) -> (Vec<Option<u8>>, std::ops::Range<usize>) {
    let t = &prepared.t_s;
    let n = t.len();
    let speed = prepared.drive_speed();
    let fastest = speed.iter().copied().fold(0.0, f64::max);
    let moving: Vec<bool> = speed.iter().map(|v| *v > 0.1 * fastest && *v > 1e-5).collect();
    let (Some(start), Some(end)) = (moving.iter().position(|m| *m), moving.iter().rposition(|m| *m)) else {
        // Nothing moves: equal parts of the time.
        return ((0..n).map(|i| Some((5 + i * PARTS / n.max(1)) as u8)).collect(), 0..0);
    };
    let mut path = vec![0.0; n];
    for i in 1..n {
        path[i] = path[i - 1] + if moving[i - 1] { speed[i - 1] * (t[i] - t[i - 1]) } else { 0.0 };
    }
    let touches = |i: usize| simulated.normal_n.get(i).is_some_and(|f| f[2] > 0.05);
    let free = prepared.scene.pusher.is_some() && start > 0 && !touches(start - 1);
    let onset = if free { (start..=end).find(|i| touches(*i)).unwrap_or(start) } else { start };
    let length = path[n - 1] - path[onset];
    let scale = onset_scale(length);
    let rest = (length - scale * ONSET_EDGES_M[3]).max(1e-9);
    let mut last_pause: Option<usize> = None;
    let of: Vec<Option<u8>> = (0..n)
        .map(|i| {
            if i < onset {
                // The approach belongs to no phase: the true contact may come before the model's.
                return (i < start && t[start] - t[i] > GUARD_S).then_some(0);
            }
            if i > end {
                if t[i] - t[end] < GUARD_S {
                    return None;
                }
                let late = t[i] - t[end] > 0.5 * (t[n - 1] - t[end]);
                return Some(if late { 14 } else { 13 });
            }
            if !moving[i] {
                last_pause = Some(i);
                return Some(PAUSE as u8);
            }
            let s = path[i] - path[onset];
            if last_pause.is_some_and(|p| path[i] - path[p] < RESTART_M) {
                return Some(RESTART as u8);
            }
            let fine = ONSET_EDGES_M.iter().position(|e| s < scale * e);
            Some(match fine {
                Some(k) => 1 + k as u8,
                None => {
                    5 + (((s - scale * ONSET_EDGES_M[3]) / rest * PARTS as f64) as u8).min(PARTS as u8 - 1)
                }
            })
        })
        .collect();
    // The true contact may come a little before the model's.
    let from = (0..onset).rev().find(|i| t[onset] - t[*i] > 0.05).unwrap_or(0);
    let until = of.iter().rposition(|b| b.is_some_and(|b| (1..=4).contains(&b))).map_or(onset, |i| i + 1);
    (of, from..until.max(from))
}
