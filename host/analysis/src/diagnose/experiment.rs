//! The experiment that would tell candidates apart.
//!
//! Candidates are fitted to the data; each condition of a grid within (and a little beyond)
//! the data's ranges is played with a recorded trial of the nearest condition whose grip is
//! changed; where the predictions differ most in standard deviations of one run is where to
//! measure. The number of runs follows from the difference: `n = (z_alpha + z_beta)^2 / d^2`.

use schemars::JsonSchema;
use serde::Serialize;
use stickslip_shared::model::Model;

use crate::channels::channel_words;
use crate::compare::verdict::readable;
use crate::fit::features::{FEATURES, channel_name, quantity};
use crate::fit::phases::{BINS, Phase};
use crate::fit::problem::Problem;

/// Quantiles for 1 % false and 95 % right decisions.
const QUANTILES: f64 = 2.326 + 1.645;
/// Grips tried, as multiples of the recorded one.
const GRIPS: [f64; 3] = [0.6, 1.0, 1.5];

/// A condition and what the candidates predict there.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Experiment {
    /// In words.
    pub summary: String,
    /// Recorded trial whose motion is to be repeated.
    pub like_trial: String,
    /// Grip force, N.
    pub grip_n: Option<f64>,
    /// Speed, m/s or rad/s.
    pub speed: Option<f64>,
    /// Slope, rad.
    pub slope_rad: Option<f64>,
    /// Offset of the pusher, m.
    pub pusher_offset_m: Option<f64>,
    /// Channel that differs most.
    pub channel: String,
    /// Phase in which it does.
    pub phase: &'static str,
    /// Difference of the predictions, in the channel's unit.
    pub difference: f64,
    /// Unit of the difference.
    pub unit: &'static str,
    /// Difference in standard deviations of one run.
    pub standard_deviations: f64,
    /// Runs that settle it with 1 % false and 95 % right decisions.
    pub runs: u64,
}

/// The conditions at which `a` and `b` differ most, best first.
pub fn experiments(problem: &Problem, a: &Model<f64>, b: &Model<f64>, most: usize) -> Vec<Experiment> {
    use rayon::prelude::*;
    let campaign = problem.campaign;
    let mut seen = std::collections::BTreeSet::new();
    let groups: Vec<usize> =
        problem.groups.iter().copied().filter(|g| seen.insert(campaign.groups[*g].condition)).collect();
    let mut out: Vec<Experiment> = groups
        .par_iter()
        .flat_map_iter(|g| {
            let run = problem.run_of(*g);
            GRIPS.iter().filter_map(move |factor| {
                if run.info.grip_n.is_none() && *factor != 1.0 {
                    return None;
                }
                let prepared = run.prepared.with_grip(*factor);
                let x = run.bins.modelled(&prepared.simulate_every(a, run.stride));
                let y = run.bins.modelled(&prepared.simulate_every(b, run.stride));
                let (f, d) = (0..FEATURES)
                    .map(|f| (f, (x[f] - y[f]) / problem.single_run[*g][f]))
                    .filter(|d| d.1.is_finite())
                    .max_by(|p, q| p.1.abs().total_cmp(&q.1.abs()))?;
                let (channel, phase) = (channel_name(f / BINS), Phase::of(f % BINS).name());
                let grip_n = run.info.grip_n.map(|n| n * factor);
                let unit = quantity(f).unit();
                let runs = ((QUANTILES / d).powi(2).ceil() as u64).max(1);
                let difference = (x[f] - y[f]).abs();
                let at = grip_n.map_or(String::new(), |n| format!(" with a grip of {n:.1} N"));
                let summary = format!(
                    "repeat trial {}{at}: {} ({phase}) differs by {}, {:.1} standard deviations; {runs} run(s) of it decide",
                    run.info.trial,
                    channel_words(&channel),
                    readable(difference, unit),
                    d.abs()
                );
                let speed = run.info.speed_m_s.or(run.info.speed_rad_s);
                Some(Experiment {
                    summary,
                    like_trial: run.info.trial.clone(),
                    grip_n,
                    speed,
                    slope_rad: run.info.slope_rad,
                    pusher_offset_m: run.info.pusher_offset_m,
                    channel,
                    phase,
                    difference,
                    unit,
                    standard_deviations: d.abs(),
                    runs,
                })
            })
        })
        .collect();
    out.sort_by(|p, q| q.standard_deviations.total_cmp(&p.standard_deviations));
    out.truncate(most);
    out
}
