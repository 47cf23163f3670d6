//! Naming the physical effect that a contact model lacks.
//!
//! Trials become features (`features`, `phases`), repetitions give the noise (`noise`), a
//! generalised least squares problem is built around the model (`problem`, `gls`), effects
//! are screened and refitted (`screen`, `select`), and the verdict follows from held-out
//! conditions (`choice`, `verdict`). `docs/diagnose.md` has the statistics.

pub mod choice;
pub mod detection;
pub mod experiment;
pub mod findings;
pub mod misfit;
pub mod posterior;
pub mod report;
pub mod rivals;
pub mod select;
pub mod signature;
pub mod structure;
pub mod swing;
pub mod verdict;

use std::time::Instant;

use rayon::prelude::*;
use stickslip_shared::effects::{MAX_PARAMETERS, REGISTRY, Role};
use stickslip_shared::model::Model;

use crate::evidence::balance::{StageBalance, balance};
use crate::evidence::stages::stages;
use crate::fit::campaign::Campaign;
use crate::fit::problem::Problem;
use crate::fit::{self, FitError, Free, Solution};
use crate::model::candidate::{CandidateEffect, Described};
use crate::progress::Progress;
use choice::{
    Choice, FALSE_ALARM, MOST_EFFECTS, Pass, SEARCHED_AGAIN, SEARCHED_FURTHER, SURVIVORS, Stages, Tick,
    choose, poor, sets, small_compliance, small_compliance_in,
};
use findings::Findings;
use misfit::Misfit;
use posterior::{Posterior, posterior};
use report::Report;
use select::{Candidate, Held, Search, candidates, explained, hold_out, search_again};
use statrs::distribution::{ContinuousCDF, StudentsT};
use stickslip_data::{Dataset, Description};
use verdict::{Doubt, Signs, Verdict};

pub use verdict::{FEWEST_CONDITIONS, RELEVANT};

/// Smaller changes of friction over a data set are no drift, in units of [`RELEVANT`].
const LEAST_DRIFT: f64 = 0.01;

/// Steps that [`diagnose`] reports to its `tick` at most.
pub fn steps() -> u64 {
    let stage = REGISTRY.len() + SURVIVORS;
    let quick = 2 * MOST_EFFECTS * (stage + SEARCHED_FURTHER);
    let thorough = MOST_EFFECTS * SEARCHED_AGAIN + (MOST_EFFECTS - 1) * stage;
    (quick + thorough + 4) as u64
}

/// Diagnoses `model` on `dataset`; the user's `own` effects are ranked beside the listed ones.
///
/// # Errors
/// Where no trial can be simulated.
pub fn diagnose(
    dataset: &Dataset,
    model: impl Into<Described>,
    own: &[CandidateEffect],
    progress: &dyn Progress,
) -> Result<Report, FitError> {
    progress.begin("diagnosing", steps() as usize);
    let tick: Tick = &|| progress.step(1);
    let begun = Instant::now();
    let model = model.into();
    let campaign = campaign_of(dataset, &model.model)?;
    tick();
    let (mut problem, mut base, mut others) = fitted_base(&campaign, &model);
    tick();
    let mut drift = None;
    if let Some((around, without, with)) = drifting(&problem, &base) {
        (problem, base, drift) = (around, without, Some(with));
        others.clear();
    }
    others.push(given(&campaign, &base));
    let mut trials = CandidateEffect::listed();
    trials.extend(own.iter().cloned());
    let mut findings = if problem.noise.of_misfit.is_some() {
        let (around, findings) = rivals::find(&campaign, &base, &trials, tick);
        problem = around;
        findings
    } else {
        find(&problem, base, &others, drift, &trials, Pass::First, tick)
    };
    if let Some(near) = findings.again.take() {
        let (around, base) = around(&campaign, &near, &findings.base);
        findings = find(&around, base, &others, None, &trials, Pass::Second, tick);
        problem = around;
    }
    let pair = match &findings.doubt {
        // What would tell the best candidate from its absence.
        Some(_) => findings.first.first().map(|c| [&findings.base.solution.model, &c.held.solution.model]),
        None => findings.equal.first().and_then(|set| {
            let chosen = |id: &str| findings.chosen.iter().any(|c| c.info.id == id);
            let other = findings.first.iter().find(|c| set.contains(&c.info.id) && !chosen(c.info.id))?;
            Some([&findings.last.as_ref()?.solution.model, &other.held.solution.model])
        }),
    };
    let experiment = pair.and_then(|[a, b]| experiment::experiments(&problem, a, b, 1).into_iter().next());
    let named = matches!(findings.verdict, Verdict::Effect | Verdict::Ambiguous);
    let last = findings.last.as_ref().filter(|_| named).unwrap_or(&findings.base);
    let mut detection = detection::detection(&problem, last, &findings.invisible);
    if findings.verdict == Verdict::Unexplained {
        // What is missing may hide anything.
        detection.limits.clear();
    }
    let mut report = report::report(&problem, findings, &model, begun.elapsed());
    (report.limits_on_effects, report.classes) = (detection.limits, detection.classes);
    report.weigh(unbalanced(dataset, &campaign.description));
    report.suggested_experiment = experiment;
    Ok(report)
}

/// Trials whose measured forces do not sum to zero, and in how many that can be told. `description` says what
/// the sensors may be off by.
fn unbalanced(dataset: &Dataset, description: &Description) -> (Vec<StageBalance>, usize) {
    let worst: Vec<Option<StageBalance>> = dataset
        .trials
        .par_iter()
        .filter_map(|t| balance(description, t, &stages(t)).ok())
        .map(|stages| {
            let size = |s: &StageBalance| s.sum_n.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            stages.into_iter().filter(StageBalance::fails).max_by(|a, b| size(a).total_cmp(&size(b)))
        })
        .collect();
    let checked = worst.len();
    (worst.into_iter().flatten().collect(), checked)
}

fn campaign_of(dataset: &Dataset, model: &Model<f64>) -> Result<Campaign, FitError> {
    let campaign = Campaign::new(dataset, model);
    if campaign.runs.is_empty() {
        let why = campaign.refused.first().map_or("the data set has no trials".into(), ToString::to_string);
        return Err(FitError::NoTrials(why));
    }
    Ok(campaign)
}

/// The fitting problem around `model` with its friction fitted, that model held out, and other models
/// from which an effect may start.
fn fitted_base<'a>(campaign: &'a Campaign, model: &Described) -> (Problem<'a>, Held, Vec<Model<f64>>) {
    let free = free_of(campaign, model);
    let ways = fit::basins(campaign, &model.model, &free, 6);
    let problem = Problem::new(campaign, &ways[0]);
    let base = hold_out(&problem, fit::solve(&problem, &ways[0], &free, 5), free);
    (problem, base, ways)
}

/// How much `model`, its friction fitted, misses of `dataset` on held-out conditions.
///
/// # Errors
/// Where no trial can be simulated.
pub fn base_misfit(dataset: &Dataset, model: impl Into<Described>) -> Result<Misfit, FitError> {
    let model = model.into();
    Ok(fitted_base(&campaign_of(dataset, &model.model)?, &model).1.misfit)
}

/// Two effects that the data cannot tell apart, and the experiments that would.
pub type Telling = ([&'static str; 2], Vec<experiment::Experiment>);

/// The best experiments between the two effects of `between` (or the two best candidates of the
/// list and of the user's `own`): which two, and where they differ most. `None` where there are no two.
///
/// # Errors
/// Where no trial can be simulated.
pub fn suggest(
    dataset: &Dataset,
    model: impl Into<Described>,
    (between, own): (&[CandidateEffect], &[CandidateEffect]),
    most: usize,
    tick: Tick,
) -> Result<Option<Telling>, FitError> {
    let model = model.into();
    let campaign = campaign_of(dataset, &model.model)?;
    let (problem, base, ways) = fitted_base(&campaign, &model);
    let others = other_ways(&problem, &base, &ways);
    let mut trials = between.to_vec();
    if between.is_empty() {
        trials = CandidateEffect::listed();
        trials.extend(own.iter().cloned());
    }
    let found = candidates(&problem, &base, &others, &trials, SURVIVORS, tick).0;
    let [a, b, ..] = found.as_slice() else { return Ok(None) };
    let (x, y) = (&a.held.solution.model, &b.held.solution.model);
    Ok(Some(([a.info.id, b.info.id], experiment::experiments(&problem, x, y, most))))
}

/// The problem built anew around a model `near` the data, and the base model in it: corrections of coarse
/// steps and noise are those of the model that it is built around, and far from there they mislead.
fn around<'a>(campaign: &'a Campaign, near: &Model<f64>, base: &Held) -> (Problem<'a>, Held) {
    let problem = Problem::new(campaign, near);
    let solution = fit::solve(&problem, &base.solution.model, &base.free, 5);
    let base = hold_out(&problem, solution, base.free.clone());
    (problem, base)
}

/// The base model with the friction that was given: a strong effect pulls friction away, and where
/// it ended the effect need not point to the truth.
fn given(campaign: &Campaign, base: &Held) -> Model<f64> {
    Model { friction: campaign.given, ..base.solution.model.clone() }
}

/// `ways` of contact that are far from `start`, each at its place, with the effects of `start`.
fn other_ways(problem: &Problem, start: &Held, ways: &[Model<f64>]) -> Vec<Solution> {
    let model = &start.solution.model;
    let on = |m: &Model<f64>| match m.effects.len() == model.effects.len() {
        true => m.clone(),
        // The drift was found since.
        false => Model { friction: m.friction, ..model.clone() },
    };
    ways.iter()
        .filter(|m| fit::apart(problem.campaign, m, model))
        .map(|m| fit::solve(problem, &on(m), &start.free, 0))
        .collect()
}

/// Friction, and the parameters of the effects that the model has already.
fn free_of(campaign: &Campaign, model: &Described) -> Vec<Free> {
    let effects = model.infos.iter().enumerate().flat_map(|(slot, info)| Free::of_effect(info, slot));
    fit::base_parameters(campaign).into_iter().chain(effects).collect()
}

/// Where repetitions show that friction drifts with the order of trials: the problem built
/// anew around a model that has the drift (its noise is smaller), without and with it. Means of
/// repetitions made at different times would hide it from all that follows.
fn drifting<'a>(problem: &Problem<'a>, base: &Held) -> Option<(Problem<'a>, Held, Candidate)> {
    let crate::fit::noise::Drift { change, per_trial, t } = problem.noise.drift;
    let level = FALSE_ALARM / REGISTRY.len() as f64;
    let freedom = problem.noise.freedom.checked_sub(1).filter(|f| *f > 0)? as f64;
    let chance = 2.0 * StudentsT::new(0.0, 1.0, freedom).ok()?.sf(t.abs());
    if chance > level || change.abs() < RELEVANT * problem.noise.friction[0].max(LEAST_DRIFT) {
        return None;
    }
    let wear = CandidateEffect::listed().into_iter().find(|t| t.info.role == Role::Order)?;
    if base.solution.model.effects.iter().any(|e| e.code == wear.info.code) {
        return None;
    }
    let mut parameters = [0.0; MAX_PARAMETERS];
    parameters[0] = per_trial;
    let drifted = wear.on(&base.solution.model, parameters);
    let mut free = base.free.clone();
    free.extend(Free::of_effect(wear.info, base.solution.model.effects.len()));
    let found = fit::solve_with(problem, &drifted, &free, 5, &base.solution.columns);
    let around = Problem::new(problem.campaign, &found.model);
    let fitted = |model: &Model<f64>, free: &[Free]| {
        hold_out(&around, fit::solve(&around, model, free, 5), free.to_vec())
    };
    let (without, with) = (fitted(&base.solution.model, &base.free), fitted(&found.model, &free));
    let explained = explained(&without.misfit, &with.misfit);
    let searched = Search::Thorough;
    let candidate =
        Candidate { info: wear.info, held: with, p_value: chance, explained, starts: Vec::new(), searched };
    Some((around, without, candidate))
}

/// Screening, choice and verdict; see `docs/diagnose.md` for the rules.
fn find(
    problem: &Problem,
    base: Held,
    others: &[Model<f64>],
    drift: Option<Candidate>,
    trials: &[CandidateEffect],
    pass: Pass,
    tick: Tick,
) -> Findings {
    let start = drift.as_ref().map_or(&base, |c| &c.held);
    let relevant = start.misfit.exceeds(RELEVANT) && start.misfit.excess > 0.0;
    let worth_a_name = relevant && problem.campaign.conditions >= FEWEST_CONDITIONS;
    // Where nothing is worth a name, the screening only tells what these data could not show.
    let survivors = if worth_a_name { SURVIVORS } else { 0 };
    let others: Vec<Solution> = match survivors {
        0 => Vec::new(),
        _ => other_ways(problem, start, others),
    };
    let (mut first, invisible) = candidates(problem, start, &others, trials, survivors, tick);
    let mut choice = Choice::nothing();
    let mut stages = Stages::new();
    let mut again = None;
    if worth_a_name {
        if first.first().is_some_and(|c| poor(&c.held.misfit)) {
            search_again(problem, start, &others, &mut first, (SEARCHED_FURTHER, Search::Grid), tick);
        }
        choice = choose(problem, start, &first, trials, &mut stages, (pass, Search::Quick), tick);
        again = choice.near.take().filter(|_| pass == Pass::First && drift.is_none());
        if choice.verdict == Verdict::Unexplained && again.is_none() {
            // Before that is said, the likely ones are looked at more closely.
            search_again(problem, start, &others, &mut first, (SEARCHED_AGAIN, Search::Thorough), tick);
            choice = choose(problem, start, &first, trials, &mut stages, (pass, Search::Thorough), tick);
        }
    }
    let Choice { chosen, equal, left, verdict, .. } = choice;
    let equal = sets(drift.as_ref(), &chosen, &equal, |c| small_compliance(problem, c));
    let only_drift = drift.is_some() && chosen.is_empty();
    let mut chosen: Vec<Candidate> = drift.into_iter().chain(chosen).collect();
    let model = chosen.last().map_or(&base, |c| &c.held).solution.model.clone();
    let last = chosen.last().map(|c| c.held.clone());
    let swing = swing::missed(problem.campaign, &model);
    let signs = Signs {
        equal: !equal.is_empty(),
        only_drift,
        swings: swing.is_some(),
        conditions: problem.campaign.conditions,
    };
    let (verdict, doubt) = verdict::verdict(verdict, &signs, left.as_ref().unwrap_or(&base.misfit));
    let posterior = match worth_a_name {
        true => {
            let met = chosen.iter().chain(&first).chain(stages.iter().flat_map(|(_, of)| of));
            let fits: Vec<&Held> = std::iter::once(&base).chain(met.map(|c| &c.held)).collect();
            let given = base.solution.model.effects.len();
            posterior(problem, given, &fits, |held, id| small_compliance_in(problem, held, id))
        }
        false => Posterior::default(),
    };
    chosen.retain(|c| !small_compliance(problem, c));
    let model = match doubt {
        Some(Doubt::Weak(_)) => base.solution.model.clone(),
        _ => model,
    };
    Findings { base, first, chosen, last, equal, posterior, invisible, swing, again, verdict, doubt, model }
}
