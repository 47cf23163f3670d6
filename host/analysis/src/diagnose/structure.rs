//! What structure a model leaves: which channel in which phase, and on which named
//! quantity it depends. The beginning of a new effect.

use schemars::JsonSchema;
use serde::Serialize;

use crate::diagnose::select::Held;
use crate::diagnose::verdict::RELEVANT;
use crate::fit::campaign::{Campaign, Run};
use crate::fit::features::channel_name;
use crate::fit::phases::{BINS, Phase};
use crate::fit::problem::Problem;

/// Structure left in one channel and phase.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Structure {
    /// Channel.
    pub channel: String,
    /// Phase.
    pub phase: &'static str,
    /// Root mean square systematic misfit, in run spreads (of a swing, in those of one sample).
    pub size: f64,
    /// Quantities it depends on, strongest first, with the share of its variance that each adds.
    pub depends_on: Vec<(&'static str, f64)>,
}

/// Named quantities of a run in a phase bin.
const QUANTITIES: [&str; 8] =
    ["grip_n", "speed", "slope_rad", "pusher_offset_m", "mass_kg", "trial order", "path", "path squared"];
/// Least share of variance that a quantity must add.
const ADDS: f64 = 0.1;
/// Most places described.
const PLACES: usize = 6;

/// Describes what `held` leaves, worst places first.
pub fn describe(problem: &Problem, held: &Held) -> Vec<Structure> {
    held.misfit
        .places
        .iter()
        .filter(|p| p.exceeds(RELEVANT))
        .take(PLACES)
        .map(|p| Structure {
            channel: channel_name(p.channel),
            phase: p.phase.name(),
            size: p.size,
            depends_on: depends_on(problem, held, p.channel, p.phase),
        })
        .collect()
}

/// On which quantities the residual of one channel in one phase depends.
fn depends_on(problem: &Problem, held: &Held, channel: usize, phase: Phase) -> Vec<(&'static str, f64)> {
    let mut y = Vec::new();
    let mut x: Vec<Vec<f64>> = vec![Vec::new(); QUANTITIES.len()];
    for (g, r) in problem.groups.iter().zip(&held.residual) {
        let run = problem.run_of(*g);
        for bin in (0..BINS).filter(|b| Phase::of(*b) == phase) {
            let f = channel * BINS + bin;
            if !r[f].is_finite() {
                continue;
            }
            y.push(r[f] / problem.single_run[*g][f]);
            for (column, v) in x.iter_mut().zip(quantities(run, bin as f64)) {
                column.push(v);
            }
        }
    }
    forward(&y, x)
}

/// Values of [`QUANTITIES`] for a run, so far `along` its path.
fn quantities(run: &Run, along: f64) -> [f64; QUANTITIES.len()] {
    let i = &run.info;
    [
        i.grip_n.unwrap_or(0.0),
        i.speed_m_s.or(i.speed_rad_s).unwrap_or(0.0),
        i.slope_rad.unwrap_or(0.0),
        i.pusher_offset_m.unwrap_or(0.0),
        run.prepared.scene.object.mass_kg,
        run.prepared.ordinal,
        along,
        (along - 7.5) * (along - 7.5),
    ]
}

/// On which quantities `y`, a value of each run, depends.
pub fn of_runs(campaign: &Campaign, y: &[f64]) -> Vec<(&'static str, f64)> {
    let mut x: Vec<Vec<f64>> = vec![Vec::new(); QUANTITIES.len()];
    for run in &campaign.runs {
        for (column, v) in x.iter_mut().zip(quantities(run, 0.0)) {
            column.push(v);
        }
    }
    forward(y, x)
}

/// Forward selection among the columns of `x` for `y`: the share of its squares that each adds.
fn forward(y: &[f64], mut x: Vec<Vec<f64>>) -> Vec<(&'static str, f64)> {
    let total: f64 = y.iter().map(|v| v * v).sum();
    if total <= 0.0 || y.len() < 6 {
        return Vec::new();
    }
    let mut out = Vec::new();
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    let mut left: Vec<f64> = y.iter().map(|v| v - mean).collect();
    let share = mean * mean * y.len() as f64 / total;
    if share > ADDS {
        out.push(("constant", share));
    }
    for column in &mut x {
        orthogonal(column, None);
    }
    for _ in 0..3 {
        let best = (0..x.len())
            .map(|k| {
                let c = &x[k];
                let n: f64 = c.iter().map(|v| v * v).sum();
                let d: f64 = c.iter().zip(&left).map(|(a, b)| a * b).sum();
                (if n > 1e-12 { d * d / n / total } else { 0.0 }, k)
            })
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((adds, k)) = best.filter(|b| b.0 > ADDS) else { break };
        out.push((QUANTITIES[k], adds));
        let direction = x[k].clone();
        orthogonal(&mut left, Some(&direction));
        for column in &mut x {
            orthogonal(column, Some(&direction));
        }
    }
    out
}

/// Takes the mean, or the part along `direction`, out of `column`.
fn orthogonal(column: &mut [f64], direction: Option<&[f64]>) {
    match direction {
        None => {
            let mean = column.iter().sum::<f64>() / column.len().max(1) as f64;
            let size = column.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            column.iter_mut().for_each(|v| *v -= mean);
            // What is constant but for rounding says nothing.
            if column.iter().all(|v| v.abs() <= 1e-9 * size) {
                column.fill(0.0);
            }
        }
        Some(d) => {
            let n: f64 = d.iter().map(|v| v * v).sum();
            let a: f64 =
                if n > 0.0 { d.iter().zip(column.iter()).map(|(a, b)| a * b).sum::<f64>() / n } else { 0.0 };
            column.iter_mut().zip(d).for_each(|(v, d)| *v -= a * d);
        }
    }
}
