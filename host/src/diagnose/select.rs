//! Selection: which effects the data demand.
//!
//! The survivors of the screening are refitted together with friction and compared by
//! their loss on held-out conditions. An effect is taken when it predicts held-out
//! conditions better by more than chance (Student's t over conditions, corrected for the
//! number of effects tried) and by more than the noise floor (it explains most of the
//! excess misfit that is left). Effects whose held-out losses do not differ from the
//! best one's are equally good.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor, StudentsT};
use stickslip_shared::effects::Info;
use stickslip_shared::model::MAX_EFFECTS;

use crate::diagnose::features::Features;
use crate::diagnose::gls;
use crate::diagnose::misfit::{self, Misfit};
use crate::diagnose::problem::Problem;
use crate::diagnose::screen::{Screened, Trial, screen};
use crate::fit::{self, FOLDS, Free, Solution};

/// Longest wave that counts as one, in paths.
const LONGEST_WAVE: f64 = 1.5;
/// Gauss-Newton steps of a candidate.
const STEPS: usize = 8;

/// A fitted model and how it does on held-out conditions.
#[derive(Clone, Debug)]
pub struct Held {
    /// The fit.
    pub solution: Solution,
    /// Its free parameters.
    pub free: Vec<Free>,
    /// Loss of each condition when held out.
    pub loss: Vec<f64>,
    /// Residual of each group when held out, sensor offsets taken out.
    pub residual: Vec<Features>,
    /// Misfit of that.
    pub misfit: Misfit,
}

/// An effect that was refitted.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Description.
    pub info: &'static Info,
    /// Its fit on top of what was chosen before.
    pub held: Held,
    /// Probability of its gain on held-out conditions by chance.
    pub p_value: f64,
    /// Share of the excess misfit that it explains.
    pub explained: f64,
}

/// Held-out performance of a solution.
pub fn hold_out(problem: &Problem, solution: Solution, free: Vec<Free>) -> Held {
    let n = free.len();
    let precision = problem.precision(&free, 0);
    let folds = gls::fold_solutions(&solution.grams, &precision, FOLDS);
    let residual: Vec<Features> = solution
        .residual
        .iter()
        .enumerate()
        .map(|(i, r)| {
            let condition = problem.campaign.groups[problem.groups[i]].condition;
            let x = &folds[gls::fold(condition, FOLDS)];
            let mut r = problem.without_offsets(std::slice::from_ref(r), &x.as_slice()[n..]).remove(0);
            for k in 0..n {
                for (r, c) in r.iter_mut().zip(&solution.columns[k][i]) {
                    if c.is_finite() {
                        *r -= c * x[k];
                    }
                }
            }
            r
        })
        .collect();
    // Of the residual whose sensor offsets are within what is stated: what they cannot take
    // is misfit.
    let mut loss = vec![0.0; problem.campaign.conditions];
    for (g, r) in problem.groups.iter().zip(&residual) {
        loss[problem.campaign.groups[*g].condition] += problem.whiteners[*g].apply(r).norm_squared();
    }
    let misfit = misfit::of(problem, &residual);
    Held { solution, free, loss, residual, misfit }
}

/// Logarithm of the loss of each condition, with what chance alone makes of it (one for each
/// feature) added: a condition in which the effect is ten times as strong weighs no more than
/// others, and one in which it does not show weighs little.
fn log_loss(problem: &Problem, loss: &[f64]) -> Vec<f64> {
    let mut chance = vec![0.0; loss.len()];
    for g in &problem.groups {
        chance[problem.campaign.groups[*g].condition] += problem.whiteners[*g].active.len() as f64;
    }
    loss.iter().zip(chance).map(|(l, c)| (l + f64::max(c, 1.0)).ln()).collect()
}

/// One-sided probability that held-out losses `a` exceed `b` by this much by chance, over
/// conditions. Large values are drawn in to the tenth largest, so that no single condition decides.
pub fn p_value(a: &[f64], b: &[f64]) -> f64 {
    let Some((t, freedom)) = paired(a, b) else { return 1.0 };
    match StudentsT::new(0.0, 1.0, freedom) {
        Ok(d) => 1.0 - d.cdf(t),
        Err(_) => 1.0,
    }
}

/// Probability that the effect's strengths differ from neutral by chance: Wald's test with the
/// covariance clustered by condition, against F.
fn parameter_p_value(problem: &Problem, solution: &Solution, free: &[Free], from: usize, info: &Info) -> f64 {
    let covariance = fit::clustered_covariance(&solution.grams, &problem.precision(free, 0), free.len());
    let strengths: Vec<(usize, f64)> = free
        .iter()
        .enumerate()
        .skip(from)
        .zip(info.parameters)
        .filter(|(_, p)| p.typical != p.neutral)
        .map(|((k, f), p)| (k, f.get(&solution.model) - p.neutral))
        .filter(|(k, _)| covariance[(*k, *k)] > 0.0)
        .collect();
    let q = strengths.len();
    let conditions = problem.campaign.conditions as f64;
    let freedom = conditions - q as f64 - from as f64;
    if q == 0 || freedom < 1.0 {
        return 1.0;
    }
    let sd: Vec<f64> = strengths.iter().map(|(k, _)| covariance[(*k, *k)].sqrt()).collect();
    let correlation = DMatrix::from_fn(q, q, |i, j| {
        let c = covariance[(strengths[i].0, strengths[j].0)] / (sd[i] * sd[j]);
        // Nearly equal directions count once.
        if i == j { 1.0 + 1e-6 } else { c * (1.0 - 1e-6) }
    });
    let z = DVector::from_fn(q, |i, _| strengths[i].1 / sd[i]);
    let Some(c) = correlation.cholesky() else { return 1.0 };
    let wald = z.dot(&c.solve(&z));
    // Hotelling's correction for few conditions.
    let f = wald / q as f64 * freedom / (conditions - from as f64).max(1.0);
    match FisherSnedecor::new(q as f64, freedom) {
        Ok(d) if f.is_finite() && f > 0.0 => 1.0 - d.cdf(f),
        _ => 1.0,
    }
}

/// Student's t of the mean of `a - b`, with its degrees of freedom.
pub fn paired(a: &[f64], b: &[f64]) -> Option<(f64, f64)> {
    let mut d: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    let n = d.len();
    if n < 3 {
        return None;
    }
    let mut sizes: Vec<f64> = d.iter().map(|x| x.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let most = sizes[n - 1 - n / 10];
    d.iter_mut().for_each(|x| *x = x.clamp(-most, most));
    let n = n as f64;
    let mean = d.iter().sum::<f64>() / n;
    let variance = d.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    if variance <= 0.0 {
        return Some((if mean > 0.0 { 1e3 } else { 0.0 }, n - 1.0));
    }
    Some((mean / (variance / n).sqrt(), n - 1.0))
}

/// Share of the excess of `before` that `after` explains.
pub fn explained(before: &Misfit, after: &Misfit) -> f64 {
    if before.excess > 0.0 { 1.0 - after.excess / before.excess } else { 0.0 }
}

/// Screens all of `trials` that `base` does not have, and refits the best. Returns candidates with the
/// best held-out loss first, and the effects that cannot be seen.
pub fn candidates(
    problem: &Problem,
    base: &Held,
    trials: &[Trial],
    survivors: usize,
    tick: &(dyn Fn() + Sync),
) -> (Vec<Candidate>, Vec<&'static str>) {
    let model = &base.solution.model;
    if model.effects.len() >= MAX_EFFECTS {
        return (Vec::new(), Vec::new());
    }
    let has = |t: &Trial| {
        let mut with = model.effects.iter().filter(|e| e.code == t.info.code);
        match &t.program {
            None => with.next().is_some(),
            Some(program) => model.formulas.contains(program),
        }
    };
    let mut screened: Vec<Screened> = trials
        .iter()
        .filter(|t| !has(t))
        .map(|t| {
            let s = screen(problem, &base.solution, &base.free, t);
            tick();
            s
        })
        .collect();
    let invisible = screened.iter().filter(|s| s.invisible).map(|s| s.trial.info.id).collect();
    screened.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let most = screened.first().map_or(0.0, |s| s.gain);
    let kept = screened.into_iter().filter(|s| s.gain > 0.02 * most && s.gain > 1.0).take(survivors);
    let mut out: Vec<Candidate> = kept
        .filter_map(|s| {
            let c = refit(problem, base, &s);
            tick();
            c
        })
        .collect();
    out.sort_by(|a, b| total(&a.held).total_cmp(&total(&b.held)));
    (out, invisible)
}

/// Summed held-out loss.
pub fn total(held: &Held) -> f64 {
    held.loss.iter().sum()
}

/// Longest prescribed path of the trials, m.
fn longest_path(problem: &Problem) -> f64 {
    problem.campaign.runs.iter().map(|r| r.prepared.drive_path()).fold(0.0, f64::max)
}

/// `screened` fitted together with what `base` has; `None` where it does not apply.
fn refit(problem: &Problem, base: &Held, screened: &Screened) -> Option<Candidate> {
    let slot = base.solution.model.effects.len();
    let mut free = base.free.clone();
    free.extend(Free::of_effect(screened.trial.info, slot));
    // One step from each start shows which is worth the rest.
    let begun = screened
        .starts
        .iter()
        .take(2)
        .map(|start| {
            let model = screened.trial.on(&base.solution.model, *start);
            fit::solve_with(problem, &model, &free, 1, &base.solution.columns)
        })
        .min_by(|a, b| a.loss.1.total_cmp(&b.loss.1))?;
    let best = fit::solve_with(problem, &begun.model, &free, STEPS, &begun.columns[..base.free.len()]);
    // Part of a wave is no wave: it could be any slow change along the path.
    let wave = screened.trial.info.parameters.iter().position(|p| p.name == "wavelength_m");
    let longest = LONGEST_WAVE * longest_path(problem);
    if wave.is_some_and(|k| best.model.effects[slot].parameters[k] > longest) {
        return None;
    }
    let parameters = parameter_p_value(problem, &best, &free, base.free.len(), screened.trial.info);
    let held = hold_out(problem, best, free);
    // Three tests of the same question: the best one counts, at three times its probability.
    let differences = p_value(&base.loss, &held.loss);
    let ratios = p_value(&log_loss(problem, &base.loss), &log_loss(problem, &held.loss));
    let p_value = (3.0 * differences.min(ratios).min(parameters)).min(1.0);
    let explained = explained(&base.misfit, &held.misfit);
    Some(Candidate { info: screened.trial.info, held, p_value, explained })
}
