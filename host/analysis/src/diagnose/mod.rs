//! Naming the physical effect that a contact model lacks.
//!
//! Trials become features (`features`, `phases`), repetitions give the noise (`noise`), a
//! generalised least squares problem is built around the model (`problem`, `gls`), effects
//! are screened and refitted (`screen`, `select`), and the verdict follows from held-out
//! conditions (`choice`, `verdict`). `docs/diagnose.md` has the statistics.

pub mod beforehand;
pub mod choice;
pub mod detection;
mod doubts;
pub mod experiment;
pub mod findings;
pub mod limits;
pub mod misfit;
pub mod ordinary;
pub mod posterior;
pub mod report;
pub mod rivals;
pub mod search;
pub mod select;
pub mod signature;
mod slow;
pub mod structure;
pub mod swing;
pub mod verdict;

use std::time::Instant;

use rayon::prelude::*;
use stickslip_shared::effects::{REGISTRY, Role};
use stickslip_shared::model::Model;

use crate::evidence::balance::{StageBalance, balance};
use crate::evidence::stages::stages;
use crate::fit::campaign::Campaign;
use crate::fit::problem::Problem;
use crate::fit::{self, FitError, Solution};
use crate::left_out::LeftOut;
use crate::model::candidate::{CandidateEffect, Described};
use crate::progress::Progress;
use beforehand::Start;
use choice::{
    Choice, MOST_EFFECTS, Part, Pass, SEARCHED_AGAIN, SEARCHED_FURTHER, SURVIVORS, Stages, Tick, WEAKER,
    choose, is_clear, other_ways, sets,
};
use experiment::{Experiment, Grid, Hypothesis, Plan};
use findings::Findings;
use misfit::Misfit;
use ordinary::is_ordinary_in;
use posterior::{Posterior, Weighed, posterior};
use report::Report;
use search::Search;
use select::{Candidate, Fitted, Held, candidates, explained, halves, hold_out, level, search_again};
use stickslip_data::{Dataset, Description};
use verdict::{Doubt, Left, Signs, UNEXPLAINED, Verdict};

pub use verdict::{FEWEST_CONDITIONS, RELEVANT};

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
    let start = beforehand::start(&campaign, &model);
    let start = beforehand::delayed(&start).unwrap_or(start);
    let start = beforehand::biased(&start).unwrap_or(start);
    let start = beforehand::drifting(&start).unwrap_or(start);
    tick();
    let given = given(&campaign, start.held());
    let Start { mut problem, base, found, mut others } = start;
    others.push(given);
    let mut trials = CandidateEffect::listed();
    trials.extend(own.iter().cloned());
    let mut findings = if problem.noise.of_misfit.is_some() {
        let (around, findings) = rivals::find(&campaign, &base, &trials, tick);
        problem = around;
        findings
    } else {
        find(&problem, (base, found), &others, &trials, Pass::First, tick)
    };
    if let Some(near) = findings.again.take() {
        let (around, base) = around(&campaign, &near, &findings.base, &findings.first);
        let found = beforehand::again(&around, &base, &findings.found);
        findings = find(&around, (base, found), &others, &trials, Pass::Second, tick);
        problem = around;
    }
    let pair = match &findings.doubt {
        // What would tell the best candidate from its absence.
        Some(_) => findings.first.first().map(|c| [&findings.start.solution.model, &c.held.solution.model]),
        None => findings.equal.first().and_then(|set| {
            let chosen = |id: &str| findings.chosen.iter().any(|c| c.info.id == id);
            let exchanged = findings.first.iter().find(|c| set.contains(&c.info.id) && !chosen(c.info.id));
            // Fewer of them: each was fitted on top of those before.
            let first =
                || findings.chosen.get(..set.len()).filter(|c| c.iter().all(|c| set.contains(&c.info.id)));
            let other = exchanged.or_else(|| first()?.last())?;
            Some([&findings.last.as_ref()?.solution.model, &other.held.solution.model])
        }),
    };
    let experiment = pair.and_then(|pair| {
        let pair = pair.map(|model| Hypothesis { model, probability: 0.5 });
        Grid::new(&problem, &findings.start.solution.model, &pair).experiments(1).into_iter().next()
    });
    let named = matches!(findings.verdict, Verdict::Effect | Verdict::Ambiguous);
    let last = findings.last.as_ref().filter(|_| named).unwrap_or(&findings.start);
    let mut detection = detection::detection(&problem, last, &findings.invisible);
    let leaves_much = named && last.misfit.exceeds(UNEXPLAINED);
    if findings.verdict == Verdict::Unexplained || findings.beside.is_some() || leaves_much {
        // What is missing may hide anything.
        detection.limits.clear();
    }
    let mut report = report::report(&problem, findings, &model, (experiment, begun.elapsed()));
    report.not_excluded = detection.not_excluded();
    (report.limits_on_effects, report.classes) = (detection.limits, detection.classes);
    report.weigh(unbalanced(dataset, &campaign.description));
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

/// How much `model`, its friction fitted, misses of `dataset` on held-out conditions.
///
/// # Errors
/// Where no trial can be simulated.
pub fn base_misfit(dataset: &Dataset, model: impl Into<Described>) -> Result<Misfit, FitError> {
    let model = model.into();
    let campaign = campaign_of(dataset, &model.model)?;
    let start = beforehand::start(&campaign, &model);
    // What is assumed of any hard contact is no effect that the model lacks.
    let assumed = campaign.pads().is_some_and(|pads| pads.assumed());
    Ok(if assumed { start.held() } else { &start.base }.misfit.clone())
}

/// Sets of effects that the data cannot tell apart, and the experiments that would.
pub struct Telling {
    /// Ids of the two that come first.
    pub between: [&'static str; 2],
    /// All that are weighed, and how probable each is.
    pub sets: Vec<Weighed>,
    /// Best first.
    pub experiments: Vec<Experiment>,
    /// The best trials together, where they were asked for.
    pub plan: Option<Plan>,
    /// Trials that were used.
    pub trials: usize,
    /// Trials that were not, and why.
    pub left_out: Vec<LeftOut>,
}

/// Least probability with which one of two sets goes into a plan: what hardly differs from certainty would
/// rank no experiment.
const OPEN: f64 = 0.05;

/// The best experiments between the two effects of `between`, each as likely as the other, or between the credible
/// sets of one effect of the list and of the user's `own`, and a plan of `runs` trials. `None` where there are no two.
///
/// # Errors
/// Where no trial can be simulated.
pub fn suggest(
    dataset: &Dataset,
    model: impl Into<Described>,
    (between, own): (&[CandidateEffect], &[CandidateEffect]),
    (most, runs): (usize, Option<usize>),
    tick: Tick,
) -> Result<Option<Telling>, FitError> {
    let model = model.into();
    let campaign = campaign_of(dataset, &model.model)?;
    let start = beforehand::start(&campaign, &model);
    let (problem, base) = (&start.problem, start.held());
    let others = other_ways(problem, base, &start.others);
    let mut trials = between.to_vec();
    if between.is_empty() {
        trials = CandidateEffect::listed();
        trials.extend(own.iter().cloned());
    }
    let found = candidates(problem, base, &others, &trials, Fitted::most(SURVIVORS), tick).0;
    let [a, b, ..] = found.as_slice() else { return Ok(None) };
    let weighed = match between {
        [] => weighed(problem, base, &found),
        _ => vec![(a, 0.5), (b, 0.5)],
    };
    let [(first, _), (second, _), ..] = weighed[..] else { return Ok(None) };
    let of: Vec<Hypothesis> = weighed
        .iter()
        .map(|(c, probability)| Hypothesis { model: &c.held.solution.model, probability: *probability })
        .collect();
    let grid = Grid::new(problem, &base.solution.model, &of);
    let set = |(c, probability): &(&Candidate, f64)| Weighed {
        effects: vec![c.info.id],
        probability: *probability,
    };
    Ok(Some(Telling {
        between: [first.info.id, second.info.id],
        sets: weighed.iter().map(set).collect(),
        experiments: grid.experiments(most),
        plan: runs.map(|runs| grid.plan(runs)),
        trials: problem.trials(),
        left_out: problem.left_out(),
    }))
}

/// The candidates that have 95 % of the probability of all of them together, most probable first, and at least two.
fn weighed<'a>(problem: &Problem, base: &Held, found: &'a [Candidate]) -> Vec<(&'a Candidate, f64)> {
    let given = base.solution.model.effects.len();
    let fits: Vec<&Held> = std::iter::once(base).chain(found.iter().map(|c| &c.held)).collect();
    // The compliance of any pad is a candidate here as well: it is what its rival is told apart from.
    let posterior = posterior(problem, given, &fits, |_, _| false);
    let mut out: Vec<(&Candidate, f64)> = found.iter().map(|c| (c, posterior.of(c.info.id))).collect();
    // Equal ones stay in the order of their loss.
    out.sort_by(|a, b| b.1.total_cmp(&a.1));
    let all: f64 = out.iter().map(|(_, p)| p).sum();
    let mut sum = 0.0;
    let credible = out.iter().take_while(|(_, p)| {
        let open = sum < posterior::CREDIBLE * all;
        sum += p;
        open
    });
    let kept = credible.count().max(2);
    out.truncate(kept);
    for (_, p) in &mut out {
        *p = if all > 0.0 { (*p / all).max(OPEN) } else { 1.0 };
    }
    let all: f64 = out.iter().map(|(_, p)| p).sum();
    out.iter_mut().for_each(|(_, p)| *p /= all);
    out
}

/// The problem built anew around a model `near` the data, and the base model in it: corrections of coarse
/// steps and noise are those of the model that it is built around, and far from there they mislead. The base is fitted
/// from where it was, and from the friction (and pads) of the one of `tried` that fits best without its effect: that may
/// have done no more than open the way to a valley that the base's own fit did not find.
fn around<'a>(
    campaign: &'a Campaign,
    near: &Model<f64>,
    base: &Held,
    tried: &[Candidate],
) -> (Problem<'a>, Held) {
    let problem = Problem::new(campaign, near);
    let without = |model: &Model<f64>| {
        let mut out = Model { friction: model.friction, ..base.solution.model.clone() };
        out.effects.iter_mut().zip(&model.effects).for_each(|(to, from)| *to = *from);
        fit::Place::of(&problem, out, &base.free)
    };
    let places = tried.iter().map(|c| without(&c.held.solution.model));
    let best = places.min_by(|a, b| a.loss.total_cmp(&b.loss));
    let from = |model: &Model<f64>| fit::solve_across(&problem, model, &base.free, 5);
    let before = from(&base.solution.model);
    let other = best.filter(|place| place.loss < before.loss.1).map(|place| from(&place.model));
    let solution = other.filter(|other| other.loss.1 < before.loss.1).unwrap_or(before);
    let base = hold_out(&problem, solution, base.free.clone());
    (problem, base)
}

/// The model of `start` with the friction that was given and the pads as they were read off: a strong effect pulls
/// both away, and where they ended the effect need not point to the truth.
pub fn given(campaign: &Campaign, start: &Held) -> Model<f64> {
    let mut model = Model { friction: campaign.given, ..start.solution.model.clone() };
    for f in &start.free {
        if let Some((value, _)) = f.expected(campaign) {
            f.set(&mut model, value);
        }
    }
    model
}

/// Screening, choice and verdict; see `docs/diagnose.md` for the rules. `found` stands in the model beforehand.
fn find(
    problem: &Problem,
    (base, found): (Held, Vec<Candidate>),
    ways: &[Model<f64>],
    trials: &[CandidateEffect],
    pass: Pass,
    tick: Tick,
) -> Findings {
    let start = beforehand::last(&base, &found);
    let drifts = found.iter().any(|c| c.info.role == Role::Order);
    let measured = found.iter().any(|c| matches!(c.info.role, Role::Order | Role::Delay | Role::Constants));
    let relevant = start.misfit.misses(RELEVANT) && start.misfit.excess > 0.0;
    let mut worth_a_name = relevant && problem.campaign.conditions >= FEWEST_CONDITIONS;
    // Where nothing is worth a name, a few fits show what is there within the tolerances.
    let survivors = match worth_a_name {
        true => SURVIVORS,
        false if problem.campaign.conditions >= FEWEST_CONDITIONS => WEAKER,
        false => 0,
    };
    // The friction given comes last.
    let given = ways.last();
    let others: Vec<Solution> = match worth_a_name {
        true => other_ways(problem, start, ways),
        false => Vec::new(),
    };
    let (mut first, invisible) = candidates(problem, start, &others, trials, Fitted::most(survivors), tick);
    let mut weaker = Vec::new();
    if !worth_a_name {
        if let Some(better) = from_where_effects_led(problem, start, &first) {
            // The base had stayed in a side valley.
            let (mut base, mut found) = (base, found);
            *found.last_mut().map_or(&mut base, |last| &mut last.held) = better;
            return find(problem, (base, found), ways, trials, pass, tick);
        }
        // All channels together may show clearly what none of them does alone.
        worth_a_name = first.iter().any(|c| is_clear(problem, start, c));
        if !worth_a_name {
            weaker.append(&mut first);
            weaker.retain(|c| lowers(start, c));
        }
    }
    let mut choice = Choice::nothing();
    let mut stages = Stages::new();
    let mut again = None;
    if worth_a_name {
        if first.first().is_some_and(|c| c.held.beyond(start).misses(UNEXPLAINED)) {
            search_again(problem, start, &others, &mut first, (SEARCHED_FURTHER, Search::Grid), tick);
        }
        choice = choose(problem, start, &first, trials, &mut stages, (pass, Search::Quick, given), tick);
        again = choice.near.take().filter(|_| pass == Pass::First && !drifts);
        let nothing = choice.chosen.is_empty() && start.misfit.clear_conditions().is_some();
        if (choice.verdict == Verdict::Unexplained || nothing) && again.is_none() {
            // Before that is said, the likely ones are looked at more closely.
            search_again(problem, start, &others, &mut first, (SEARCHED_AGAIN, Search::Thorough), tick);
            choice =
                choose(problem, start, &first, trials, &mut stages, (pass, Search::Thorough, given), tick);
        }
    }
    let mut beside = None;
    if again.is_none()
        && let Some(Part { chosen, equal, beside: place }) = choice.part.take()
    {
        beside = Some(place);
        choice = Choice { chosen, equal, verdict: Verdict::Effect, ..Choice::nothing() };
    }
    let Choice { mut chosen, mut equal, left, verdict, .. } = choice;
    slow::with_waves(problem, (&chosen, start.solution.model.effects.len()), trials, &mut equal);
    let fitted = beforehand::last(start, &chosen).clone();
    let mut last = fitted.clone();
    let is_finding = |c: &&Candidate| !is_ordinary_in(problem, &fitted, c.info.id);
    let before: Vec<&'static str> = found.iter().filter(is_finding).map(|c| c.info.id).collect();
    let posterior = match worth_a_name {
        true => {
            let met = found.iter().chain(&chosen).chain(&first).chain(stages.iter().flat_map(|(_, of)| of));
            let fits: Vec<&Held> = std::iter::once(&base).chain(met.map(|c| &c.held)).collect();
            let given = base.solution.model.effects.len();
            posterior(problem, given, &fits, |held, id| is_ordinary_in(problem, held, id))
        }
        false => Posterior::default(),
    };
    let mut equal = sets(&before, &chosen, &equal, |c| !is_finding(&c));
    if !chosen.is_empty() {
        let named = chosen.iter().filter(is_finding).map(|c| c.info.id);
        for set in posterior.as_probable(&before.iter().copied().chain(named).collect::<Vec<_>>()) {
            if !equal.iter().any(|e| posterior::same(e, &set)) {
                equal.push(set);
            }
        }
    }
    let swing = swing::missed(problem.campaign, &last.solution.model);
    let explains = verdict::explains(explained(&base.misfit, &start.misfit), &Left::of(&start.beyond(&base)));
    let ordinary = found.iter().take_while(|c| !is_finding(c)).last();
    let without_effects = ordinary.map_or(&base, |c| &c.held);
    let misfit = left.as_ref().unwrap_or(&without_effects.misfit);
    let signs = Signs {
        equal: !equal.is_empty(),
        only_measured: measured && chosen.is_empty(),
        only_pads: chosen.is_empty() && !before.is_empty() && (verdict != Verdict::Unexplained || explains),
        swings: swing.is_some(),
        clear: halves(&without_effects.loss, &last.loss),
        fits: left.is_none() && without_effects.fitted(problem).worst() <= RELEVANT,
        conditions: problem.campaign.conditions,
    };
    let mut beside = beside.or_else(|| verdict::missing_beside(verdict, &signs, &last.misfit));
    let (mut verdict, mut doubt) = verdict::verdict(verdict, &signs, misfit);
    // Effects that were found and are not named.
    let mut taken_back = verdict == Verdict::Unexplained && !chosen.is_empty();
    if measured && matches!(verdict, Verdict::Inconclusive | Verdict::Unexplained) {
        // What was measured by itself stands, whatever is said of the rest.
        last = start.clone();
        beside = verdict::left_over(&without_effects.misfit, &last.misfit);
        (verdict, doubt, taken_back) = (Verdict::Effect, None, false);
        (chosen, equal) = (Vec::new(), Vec::new());
    }
    let model = match doubt {
        Some(Doubt::Weak(_)) => without_effects.solution.model.clone(),
        _ if taken_back => without_effects.solution.model.clone(),
        _ => last.solution.model.clone(),
    };
    let start = without_effects.clone();
    let (chosen, equal) = if taken_back { (Vec::new(), Vec::new()) } else { (chosen, equal) };
    let named = found.iter().filter(is_finding).cloned().chain(chosen.iter().filter(is_finding).cloned());
    let chosen = named.collect();
    let last = Some(last);
    Findings {
        base,
        start,
        found,
        first,
        chosen,
        weaker,
        last,
        equal,
        posterior,
        invisible,
        swing,
        again,
        verdict,
        beside,
        doubt,
        model,
    }
}

/// An effect is mentioned where it leaves this share of the held-out error, or less.
const MENTIONED: f64 = 0.9;

/// Whether `candidate` lowers the held-out error of `start` by enough to be mentioned, and beyond chance.
fn lowers(start: &Held, candidate: &Candidate) -> bool {
    candidate.p_value < level() && candidate.held.misfit.error < MENTIONED * start.misfit.error
}

/// A fit is clearly better than another where it leaves this share of its held-out loss.
const BETTER: f64 = 0.95;

/// What the best of the candidates `first` leaves without its effect, where that is clearly less than what `start` does: the
/// effect has done no more than open the way there.
fn from_where_effects_led(problem: &Problem, start: &Held, first: &[Candidate]) -> Option<Held> {
    let best = first.first().filter(|best| lowers(start, best))?;
    let without = choice::without(problem, &best.held, start.solution.model.effects.len());
    (select::total(&without) < BETTER * select::total(start)).then_some(without)
}
