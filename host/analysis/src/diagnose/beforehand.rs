//! What is known before the search: read off the data without a model of everything else.
//!
//! The fingers' pads give way by a measured compliance ([`crate::evidence::pads`]), the motion before contact shows whether
//! the object is seen late ([`crate::evidence::pose_clock`]), the time before contact whether the pusher's sensor is off
//! ([`crate::evidence::pusher_bias`]), and repetitions whether friction drifts with the order of trials ([`crate::fit::noise`]). All of it stands in the model before any other effect is tried: least squares without it
//! ends in side valleys. Ordinary pads are a property of every fingertip and are not named; soft ones are.

use statrs::distribution::{ContinuousCDF, StudentsT};
use stickslip_shared::effects::{MAX_PARAMETERS, Role};
use stickslip_shared::model::{MAX_EFFECTS, Model};

use crate::diagnose::search::{Reach, Search};
use crate::diagnose::select::{Candidate, Held, explained, hold_out, level, p_value, total};
use crate::diagnose::verdict::RELEVANT;
use crate::evidence::pose_clock::Delay;
use crate::fit::campaign::Campaign;
use crate::fit::problem::Problem;
use crate::fit::{self, Free, Place};
use crate::model::candidate::{self, CandidateEffect, Described};

/// Smaller changes of friction over a data set are no drift, in units of [`RELEVANT`].
const LEAST_DRIFT: f64 = 0.01;
/// The first of the pusher's among the constants of the sensors: after twelve of the fingers.
const PUSHER_BIAS: usize = 12;
/// Gauss-Newton steps.
const STEPS: usize = 8;
/// A parameter beyond this share of its upper bound was pulled as far as it goes.
const AT_BOUND: f64 = 0.98;

/// Where a diagnosis begins.
pub struct Start<'a> {
    /// Built around the model that fits best.
    pub problem: Problem<'a>,
    /// The model as given, its friction fitted.
    pub base: Held,
    /// What stands in the model before the search, each on top of the one before.
    pub found: Vec<Candidate>,
    /// Other models from which an effect may start.
    pub others: Vec<Model<f64>>,
}

impl Start<'_> {
    /// With all that was found.
    pub fn held(&self) -> &Held {
        last(&self.base, &self.found)
    }
}

/// The last of `found`, each on top of the one before; `base` where there is none.
pub fn last<'a>(base: &'a Held, found: &'a [Candidate]) -> &'a Held {
    found.last().map_or(base, |c| &c.held)
}

/// Friction of `model` fitted, and the pads where they are measured to deform; else stiff contacts, where the base is
/// hard and predicts worse without them.
pub fn start<'a>(campaign: &'a Campaign, model: &Described) -> Start<'a> {
    padded_start(campaign, model).unwrap_or_else(|| {
        let free = free_of(campaign, model);
        let others = fit::basins(campaign, &model.model, &free, STEPS + 1);
        let problem = Problem::new(campaign, &others[0]);
        let base = hold_out(&problem, fit::solve_across(&problem, &others[0], &free, STEPS), free);
        Start { problem, base, found: Vec::new(), others }
    })
}

/// The same with pads, or stiff contacts; `None` where `model` has them, none are expected, or it does better without.
fn padded_start<'a>(campaign: &'a Campaign, model: &Described) -> Option<Start<'a>> {
    loop {
        let (trial, padded) = padded(campaign, &model.model)?;
        match start_with(campaign, model, &trial, &padded) {
            Some(start) => return Some(start),
            None if campaign.give_up_pads() => {}
            None => return None,
        }
    }
}

/// The start with the pads that `padded` has; `None` where they do not hold.
fn start_with<'a>(
    campaign: &'a Campaign,
    model: &Described,
    trial: &CandidateEffect,
    padded: &Model<f64>,
) -> Option<Start<'a>> {
    let free = free_of(campaign, model);
    let ways = fit::basins(campaign, padded, &free, STEPS + 1);
    let as_read = Problem::new(campaign, &ways[0]);
    let mut free_with_pads = free.clone();
    free_with_pads.extend(of_pads(&as_read, trial, &ways[0]));
    // What tolerances do to the features depends on how stiff the pads are: they are taken at the pads that are fitted.
    let fitted = fit::solve_across(&as_read, &ways[0], &free_with_pads, STEPS).model;
    let problem = Problem::new(campaign, &fitted);
    let mut without = fitted.clone();
    let slot = without.effects.len() - 1;
    candidate::remove(&mut without, slot);
    let base = hold_out(&problem, fit::solve_across(&problem, &without, &free, STEPS), free);
    let mut pads = with_pads(&problem, &base, trial, &fitted);
    if let Some(effect) = fitted.effects.last().filter(|_| !(total(&pads.held) < total(&base))) {
        // Pads more cannot do worse unless the fit ended in a side valley: from where the model without them is.
        let beside = with_pads(&problem, &base, trial, &trial.on(&base.solution.model, effect.parameters));
        if total(&beside.held) < total(&pads.held) {
            pads = beside;
        }
    }
    // Where the model does better without, what was measured is no spring; and contacts that are as soft as what is assumed
    // may be at most are none of these.
    let softer = campaign.pads().is_some_and(|p| p.assumed()) && at_most(&problem, &pads.held);
    if softer || !(total(&pads.held) < total(&base)) {
        return None;
    }
    let others = ways.into_iter().map(|m| Model { effects: without.effects.clone(), ..m }).collect();
    Some(Start { problem, base, found: vec![pads], others })
}

/// Friction, and the parameters of the effects that the model has already.
fn free_of(campaign: &Campaign, model: &Described) -> Vec<Free> {
    let effects = model.infos.iter().enumerate().flat_map(|(slot, info)| Free::of_effect(info, slot));
    fit::base_parameters(campaign).into_iter().chain(effects).collect()
}

/// `model` with the pads of the campaign, measured or assumed, where it has none.
fn padded(campaign: &Campaign, model: &Model<f64>) -> Option<(CandidateEffect, Model<f64>)> {
    let pads = campaign.pads()?;
    let trial = compliance()?;
    let has = model.effects.iter().any(|e| e.code == trial.info.code) || model.effects.len() >= MAX_EFFECTS;
    let mut parameters = [0.0; MAX_PARAMETERS];
    for (to, of) in parameters.iter_mut().zip(trial.info.parameters) {
        *to = pads.expected(of)?.0;
    }
    (!has).then(|| (trial.clone(), trial.on(model, parameters)))
}

/// Whether the pads of `held` are as compliant along the face as they may be.
fn at_most(problem: &Problem, held: &Held) -> bool {
    let mut along = held.free.iter().filter(|f| f.is_read_off());
    along.any(|f| f.get(&held.solution.model) > AT_BOUND * problem.bounds(f).1)
}

fn compliance() -> Option<CandidateEffect> {
    CandidateEffect::listed().into_iter().find(|t| t.info.role.is_compliance())
}

/// The pads of `start`, which has them as its last effect, fitted on top of `base`.
fn with_pads(problem: &Problem, base: &Held, trial: &CandidateEffect, start: &Model<f64>) -> Candidate {
    let mut free = base.free.clone();
    free.extend(of_pads(problem, trial, start));
    let held = hold_out(problem, fit::solve_across(problem, start, &free, STEPS), free);
    let explained = explained(&base.misfit, &held.misfit);
    let p_value = p_value(&base.loss, &held.loss);
    known(trial, held, p_value, explained)
}

/// The parameters of the pads, which `model` has as its last effect, that are not certain.
fn of_pads(problem: &Problem, pads: &CandidateEffect, model: &Model<f64>) -> Vec<Free> {
    let certain = |f: &Free| f.expected(problem.campaign).is_some_and(|(_, [low, high])| low >= high);
    Free::of_effect(pads.info, model.effects.len() - 1).into_iter().filter(|f| !certain(f)).collect()
}

/// What needs no search.
fn known(trial: &CandidateEffect, held: Held, p_value: f64, explained: f64) -> Candidate {
    let (info, searched, reach) = (trial.info, Search::Thorough, Reach { promised: 1.0, left: 1.0 });
    Candidate { info, held, p_value, explained, starts: Vec::new(), searched, reach }
}

/// What was `found` around another model, each fitted anew in `problem` on top of the one before, the first on `base`.
pub fn again(problem: &Problem, base: &Held, found: &[Candidate]) -> Vec<Candidate> {
    let mut out: Vec<Candidate> = Vec::new();
    for c in found {
        let on = last(base, &out);
        let listed = CandidateEffect::listed().into_iter().find(|t| t.info.id == c.info.id);
        let effect = c.held.solution.model.effects.last().copied();
        let Some((trial, effect)) = listed.zip(effect) else { continue };
        let from = trial.on(&on.solution.model, effect.parameters);
        let fitted = match c.info.role {
            Role::Compliance { .. } => with_pads(problem, on, &trial, &from),
            _ => beside(problem, on, &trial, (&from, c.p_value)),
        };
        out.push(fitted);
    }
    out
}

/// What was measured by itself, and is by `chance` none, on top of `base`: fitted from the model `from`, whose last effect it is.
fn beside(
    problem: &Problem,
    base: &Held,
    trial: &CandidateEffect,
    (from, chance): (&Model<f64>, f64),
) -> Candidate {
    let mut free = base.free.clone();
    free.extend(measured_of(trial, from));
    let held = hold_out(problem, fit::solve_across(problem, from, &free, STEPS), free);
    let explained = explained(&base.misfit, &held.misfit);
    known(trial, held, chance, explained)
}

/// The parameters of what was measured by itself, which is the last effect of `model`: of constants those that were.
fn measured_of(trial: &CandidateEffect, model: &Model<f64>) -> Vec<Free> {
    let all = Free::of_effect(trial.info, model.effects.len() - 1);
    let is_open = |f: &Free| trial.info.role != Role::Constants || f.departure(model) != 0.0;
    all.into_iter().filter(is_open).collect()
}

/// `start` with what was measured by itself, and is by `chance` none, with these `parameters`: built anew around a model that has
/// it. `None` where the model has it already.
fn measured<'a>(
    start: &Start<'a>,
    trial: &CandidateEffect,
    parameters: [f64; MAX_PARAMETERS],
    chance: f64,
) -> Option<Start<'a>> {
    let (problem, held) = (&start.problem, start.held());
    let model = &held.solution.model;
    if model.effects.iter().any(|e| e.code == trial.info.code) || model.effects.len() >= MAX_EFFECTS {
        return None;
    }
    let with = trial.on(model, parameters);
    let mut free = held.free.clone();
    free.extend(measured_of(trial, &with));
    let from = Place::of(problem, with, &free);
    let near = fit::descend(problem, from, &free, STEPS, &held.solution.columns).place.model;
    let around = Problem::new(problem.campaign, &near);
    let Held { solution, free, .. } = &start.base;
    let solution = fit::solve_across(&around, &solution.model, free, STEPS);
    let base = hold_out(&around, solution, free.clone());
    let mut found = again(&around, &base, &start.found);
    let with = beside(&around, last(&base, &found), trial, (&near, chance));
    found.push(with);
    Some(Start { problem: around, base, found, others: Vec::new() })
}

/// Where the motion before contact shows that the object is seen late: the start with that delay. `None` where it does not.
pub fn delayed<'a>(start: &Start<'a>) -> Option<Start<'a>> {
    let delay = start.problem.campaign.delay.filter(Delay::is_found)?;
    let trial = CandidateEffect::listed().into_iter().find(|t| t.info.role == Role::Delay)?;
    let mut parameters = [0.0; MAX_PARAMETERS];
    parameters[0] = delay.late_s;
    measured(start, &trial, parameters, delay.by_chance())
}

/// Where the time before contact shows that the pusher's sensor is off by more than is stated: the start with that. `None` where it
/// does not.
pub fn biased<'a>(start: &Start<'a>) -> Option<Start<'a>> {
    let bias = start.problem.campaign.bias.filter(|bias| bias.by_chance < level())?;
    let trial = CandidateEffect::listed().into_iter().find(|t| t.info.role == Role::Constants)?;
    let mut parameters = [0.0; MAX_PARAMETERS];
    parameters.iter_mut().skip(PUSHER_BIAS).zip(bias.of_channel).for_each(|(to, of)| *to = of);
    measured(start, &trial, parameters, bias.by_chance)
}

/// Where repetitions show that friction drifts with the order of trials: the start built
/// anew around a model that has the drift (its noise is smaller). Means of
/// repetitions made at different times would hide it from all that follows. `None` where they do not.
pub fn drifting<'a>(start: &Start<'a>) -> Option<Start<'a>> {
    let problem = &start.problem;
    let crate::fit::noise::Drift { change, per_trial, t } = problem.noise.drift;
    let freedom = problem.noise.freedom.checked_sub(1).filter(|f| *f > 0)? as f64;
    let chance = 2.0 * StudentsT::new(0.0, 1.0, freedom).ok()?.sf(t.abs());
    if chance > level() || change.abs() < RELEVANT * problem.noise.friction[0].max(LEAST_DRIFT) {
        return None;
    }
    let wear = CandidateEffect::listed().into_iter().find(|t| t.info.role == Role::Order)?;
    let mut parameters = [0.0; MAX_PARAMETERS];
    parameters[0] = per_trial;
    measured(start, &wear, parameters, chance)
}
