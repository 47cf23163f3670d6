//! The result of a diagnosis as it is printed and written: the JSON document of
//! `stickslip diagnose --json`.

use std::collections::BTreeMap;
use std::time::Duration;

use schemars::JsonSchema;
use serde::Serialize;
use stickslip_shared::effects::{Info, Role, find as find_effect};

use crate::diagnose::detection::UpperLimit;
use crate::diagnose::doubts::{doubtful, off_by};
use crate::diagnose::experiment::Experiment;
use crate::diagnose::findings::Findings;
use crate::diagnose::limits::limits;
use crate::diagnose::misfit::Misfit;
use crate::diagnose::ordinary;
use crate::diagnose::posterior::{self, Weighed};
use crate::diagnose::select::{Candidate, Held, explained, halves};
use crate::diagnose::signature::{Mark, signature};
use crate::diagnose::structure::{self, Structure};
use crate::diagnose::swing::Swing;
use crate::diagnose::verdict::{self, Doubt, RELEVANT};
use crate::evidence::balance::StageBalance;
use crate::fit::features::channel_name;
use crate::fit::problem::Problem;
use crate::fit::{self, Free, Options};
use crate::left_out::LeftOut;
use crate::model::candidate::Described;

pub use crate::diagnose::verdict::Verdict;

/// A fitted parameter with its 95 % interval.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Value {
    /// Best value.
    pub value: f64,
    /// Lower end; `null` where the data do not bound it.
    #[schemars(with = "Option<f64>")]
    pub low: f64,
    /// Upper end; `null` where the data do not bound it.
    #[schemars(with = "Option<f64>")]
    pub high: f64,
    /// Unit.
    pub unit: &'static str,
}

/// One effect that was tried.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct CandidateReport {
    /// Identifier.
    pub id: &'static str,
    /// Root mean square error on held-out conditions, in run spreads.
    pub held_out_error: f64,
    /// Probability that it is missing, alone or beside others.
    pub probability: f64,
    /// Probability of its gain by chance.
    pub p_value: f64,
    /// Share of the base model's excess misfit that the model with it (and with the effects chosen
    /// before it) explains.
    pub explained: f64,
    /// Effects that stand in its fit beside it: pads and drift that were found beforehand, effects chosen before it.
    pub beside: Vec<&'static str>,
    /// Share of what these leave of the excess misfit that it explains; null where there are none.
    pub explained_beyond: Option<f64>,
    /// Where it still misses most: channel, phase, and by how many run spreads.
    pub worst: Option<(String, &'static str, f64)>,
    /// Its parameters.
    pub parameters: BTreeMap<&'static str, Value>,
    /// What it is, in words.
    #[serde(skip)]
    pub info: &'static Info,
    /// What it changes, beside what the data show; for the page.
    #[serde(skip)]
    pub signature: Vec<Mark>,
}

/// Error before and after, in run spreads (see [`crate::diagnose::misfit`]).
#[derive(Clone, Copy, Debug, JsonSchema, Serialize)]
pub struct ErrorReport {
    /// Of the model as given, with its friction refitted, on held-out conditions.
    pub before: f64,
    /// With the chosen effects.
    pub after: f64,
    /// What a perfect model would show: repetitions about their mean, and the tolerance.
    pub perfect_model: f64,
    /// Worst systematic misfit of a channel in a phase before, in run spreads.
    pub worst_before: f64,
    /// Worst systematic misfit of a channel in a phase after, in run spreads.
    pub worst_after: f64,
}

/// What none of the fitted sets of effects explains.
#[derive(Clone, Copy, Debug, JsonSchema, Serialize)]
pub struct Discrepancy {
    /// Probability that it is none of them.
    pub probability: f64,
    /// Probability that something which is not listed is missing beside one of them.
    pub beside: f64,
    /// Largest systematic misfit that is left, in run spreads.
    pub run_spreads: f64,
    /// As many independent conditions the data count for.
    pub effective_conditions: f64,
}

/// Where a model misses most.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Place {
    /// Channel.
    pub channel: String,
    /// Phase.
    pub phase: &'static str,
    /// Root mean square systematic misfit before, in run spreads.
    pub before: f64,
    /// After.
    pub after: f64,
}

/// The whole result.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Report {
    /// What came out.
    pub verdict: Verdict,
    /// One sentence for people.
    pub summary: String,
    /// Where nothing can be concluded: why.
    pub reason: Option<String>,
    /// Where nothing can be concluded: what to measure so that it can.
    pub would_tell: Option<String>,
    /// Where effects are named and something that no set of them explains is missing too, or is left: where that shows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub also_missing: Option<String>,
    /// Chosen effects, strongest first.
    pub effects: Vec<&'static str>,
    /// Sets that explain the data as well; where nothing can be concluded, sets that would explain what is missed, the most
    /// probable first.
    pub ambiguous_with: Vec<Vec<&'static str>>,
    /// All effects that were refitted, best first.
    pub candidates: Vec<CandidateReport>,
    /// Where no channel misses by enough to be worth a name: effects that lower the error of held-out conditions by a tenth or
    /// more all the same, beyond chance, best first. The form of a contact may be off by as much: they are not named.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub weaker: Vec<CandidateReport>,
    /// The most probable sets, which have 95 % together of what all sets that were fitted have. Empty where
    /// nothing had to be explained.
    pub credible_sets: Vec<Weighed>,
    /// What no set explains; none where nothing had to be explained.
    pub discrepancy: Option<Discrepancy>,
    /// Errors before and after, in run spreads.
    pub error: ErrorReport,
    /// What structure is left.
    pub unexplained: Vec<Structure>,
    /// What to measure next; see `stickslip suggest`.
    pub suggested_experiment: Option<Experiment>,
    /// Fitted friction of the base model, and all parameters with the chosen effects.
    pub parameters: BTreeMap<String, Value>,
    /// Systematic misfit of each channel in each phase, worst first.
    pub places: Vec<Place>,
    /// Trials that were left out, and why.
    pub left_out: Vec<LeftOut>,
    /// What of the data was refused; the rest was diagnosed. Whoever reads the data fills it in.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub refused: Vec<String>,
    /// What cannot be concluded, and why.
    pub limits: Vec<String>,
    /// For each effect that is not named: how strong it may be all the same. Empty where something is
    /// missing that nothing explains.
    pub limits_on_effects: BTreeMap<&'static str, BTreeMap<&'static str, UpperLimit>>,
    /// Of these the effects that may be there at a typical strength: one of their strengths has a larger limit, or none.
    pub not_excluded: Vec<&'static str>,
    /// Effects that these trials cannot distinguish, whatever they show.
    pub classes: Vec<Vec<&'static str>>,
    /// Trials that were used.
    pub trials: usize,
    /// Different conditions.
    pub conditions: usize,
    /// Run-to-run friction: finger, pusher, support (relative standard deviation).
    pub friction_variation: [f64; 3],
    /// Time that the diagnosis took, s.
    pub seconds: f64,
    /// What is no finding and stands in the fit before and in that after; for the page.
    #[serde(skip)]
    pub ordinary: [ordinary::Ordinary; 2],
    /// Model with the chosen effects.
    #[serde(skip)]
    pub model: stickslip_shared::model::Model<f64>,
}

/// Makes the report.
pub fn report(
    problem: &Problem,
    findings: Findings,
    given: &Described,
    (experiment, took): (Option<Experiment>, Duration),
) -> Report {
    let Findings {
        base,
        start,
        first,
        chosen,
        last,
        equal,
        invisible,
        swing,
        verdict,
        beside,
        doubt,
        model,
        posterior,
        found,
        weaker,
        ..
    } = &findings;
    let named = matches!(verdict, Verdict::Effect | Verdict::Ambiguous);
    let last = last.as_ref().filter(|_| named).unwrap_or(start);
    let effects: Vec<&'static str> = if named { by_strength(start, chosen) } else { Vec::new() };
    let met: Vec<&Held> = std::iter::once(start).chain(found.iter().chain(chosen).map(|c| &c.held)).collect();
    let candidate = |c: &Candidate| candidate(problem, &met, c);
    let mut candidates: Vec<CandidateReport> = first.iter().map(candidate).collect();
    for c in chosen.iter().filter(|_| named) {
        if !first.iter().any(|f| f.info.id == c.info.id && f.held.free == c.held.free) {
            candidates.retain(|r| r.id != c.info.id);
            candidates.push(candidate(c));
        }
    }
    for c in &mut candidates {
        c.probability = posterior.of(c.id);
    }
    let weighed = !posterior.sets.is_empty();
    let discrepancy = weighed.then(|| Discrepancy {
        probability: posterior.unlisted,
        beside: posterior.beside,
        run_spreads: last.misfit.worst(),
        effective_conditions: posterior.conditions,
    });
    let perfect_model = start.misfit.perfect_model;
    let error = ErrorReport {
        before: start.misfit.error,
        after: last.misfit.error,
        perfect_model,
        worst_before: start.misfit.worst(),
        worst_after: last.misfit.worst(),
    };
    let places = start
        .misfit
        .places
        .iter()
        .map(|p| Place {
            channel: channel_name(p.channel),
            phase: p.phase.name(),
            before: p.size,
            after: last.misfit.at(p.channel, p.phase).map_or(0.0, |q| q.size),
        })
        .collect();
    let mut unexplained = match verdict {
        Verdict::NothingMissing => Vec::new(),
        Verdict::Inconclusive if *doubt == Some(Doubt::FewConditions) => Vec::new(),
        _ => structure::describe(problem, last),
    };
    unexplained.extend(swing.as_ref().map(Swing::structure));
    let options = Options::default();
    let summary_fit = fit::summary(problem, last.solution.clone(), 0.0, &last.free, &options);
    let parameters = summary_fit
        .estimates
        .iter()
        .map(|e| (e.name.clone(), Value { value: e.value, low: e.low, high: e.high, unit: e.unit }))
        .collect();
    let given_effects = base.solution.model.effects.len();
    let is_pads = |id: &str| find_effect(id).is_some_and(|info| info.role.is_compliance());
    let ordinary = [start, last].map(|held| {
        let added = posterior::effects(held, given_effects, |_, _| false);
        let pads = added.into_iter().any(|id| is_pads(id) && !effects.contains(&id));
        ordinary::Ordinary { pads, mounting: !ordinary::mounted(problem, held).is_empty() }
    });
    let left_out = problem.left_out();
    let mut limits = limits(problem, invisible);
    for info in &given.infos {
        limits.push(format!("the model already has {}: its parameters were refitted", info.id));
    }
    limits.extend(ordinary::mounted(problem, last));
    limits.extend(summary_fit.notes);
    let met: Vec<&'static str> = chosen.iter().map(|c| c.info.id).collect();
    // The most probable first.
    let likely = |set: &[&'static str]| {
        posterior.sets.iter().find(|s| s.effects == set).map_or(0.0, |s| s.probability)
    };
    let mut ambiguous_with = equal.clone();
    if matches!(doubt, Some(Doubt::Weak(_))) && !met.is_empty() {
        ambiguous_with.insert(0, met);
        ambiguous_with.sort_by(|a, b| likely(b).total_cmp(&likely(a)));
    }
    let doubt = doubt.as_ref().map(|d| doubtful(d, problem, &ambiguous_with, experiment.is_some()));
    // No channel does alone, and all of them together show what is named.
    let clear = !start.misfit.misses(RELEVANT) && halves(&start.loss, &last.loss);
    let mut summary = match &doubt {
        Some((reason, _)) => format!("Nothing can be concluded: {reason}."),
        None if named && problem.noise.of_misfit.is_some() => better_predicted(&effects, equal, &candidates),
        None => sentence(*verdict, &effects, equal, &candidates, [&start.misfit, &last.misfit], clear),
    };
    let (reason, would_tell) = doubt.unzip();
    let missing = beside.as_ref().map(|place| {
        format!("Something else is missing: {}, and no set of known effects explains that.", off_by(place))
    });
    // Noise that holds what the model misses says nothing of what is left.
    let judged = named && problem.noise.of_misfit.is_none();
    let left = verdict::left_over(&start.misfit, &last.misfit).filter(|_| judged);
    let left = left.map(|place| {
        let off = off_by(&place);
        format!("No set of known effects explains what is left: {off}, more than a law that is wrong by a tenth leaves.")
    });
    let also_missing = missing.or(left);
    if let Some(text) = &also_missing {
        if weighed {
            limits.push("probabilities weigh what is missing as one thing: where something else is missing beside what is named, they are too low".into());
        }
        summary += &format!(" {text}");
    }
    if let Some(swing) = swing {
        summary += &format!(" {}.", swing.text());
    }
    Report {
        verdict: *verdict,
        summary,
        reason,
        would_tell,
        also_missing,
        effects,
        ambiguous_with,
        candidates,
        weaker: weaker.iter().map(candidate).collect(),
        credible_sets: posterior.credible(),
        discrepancy,
        error,
        unexplained,
        suggested_experiment: experiment,
        parameters,
        places,
        left_out,
        refused: Vec::new(),
        limits,
        limits_on_effects: BTreeMap::new(),
        not_excluded: Vec::new(),
        classes: Vec::new(),
        trials: problem.trials(),
        conditions: problem.campaign.conditions,
        friction_variation: problem.noise.friction,
        seconds: took.as_secs_f64(),
        ordinary,
        model: model.clone(),
    }
}

impl CandidateReport {
    /// Share that it explains of what stands beside it leaves, and of what that is.
    #[must_use]
    pub fn own_share(&self) -> (f64, String) {
        match self.explained_beyond {
            Some(share) => (share, format!("of what {} leaves", self.beside.join(" and "))),
            None => (self.explained, "of the excess error".to_owned()),
        }
    }
}

impl Report {
    /// Adds what the balance of the measured forces says, which needs no model: `failing` of the `checked`
    /// trials. Where most fail, something is missing whatever the model shows.
    pub fn weigh(&mut self, (failing, checked): (Vec<StageBalance>, usize)) {
        let size = |s: &StageBalance| s.sum_n.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let Some(worst) = failing.iter().max_by(|a, b| size(a).total_cmp(&size(b))) else { return };
        if 2 * failing.len() < checked {
            return;
        }
        let text = format!(
            "the measured forces and the weight do not balance in {} of {checked} trials, by {:.2} N at worst ({}) where the sensors may be off by {:.2} N: a force that is not measured acts on the object, or its mass or a sensor is wrong (`stickslip check` has the details)",
            failing.len(),
            size(worst),
            worst.stage.label(),
            worst.bound_n
        );
        let verdict = verdict::unbalanced(self.verdict, self.conditions);
        if verdict != self.verdict {
            self.verdict = verdict;
            (self.reason, self.would_tell) = (None, None);
            self.summary = format!("Something is missing: {text}.");
        } else {
            self.limits.push(text);
        }
    }
}

/// Chosen effects by the share of the misfit that each took away.
fn by_strength(base: &Held, chosen: &[Candidate]) -> Vec<&'static str> {
    let mut before = base.misfit.excess;
    let mut shares: Vec<(f64, &'static str)> = Vec::new();
    for c in chosen {
        shares.push((before - c.held.misfit.excess, c.info.id));
        before = c.held.misfit.excess;
    }
    shares.sort_by(|a, b| b.0.total_cmp(&a.0));
    shares.into_iter().map(|s| s.1).collect()
}

/// `met` are the fits that others stand on, the base model's first.
fn candidate(problem: &Problem, met: &[&Held], c: &Candidate) -> CandidateReport {
    let base = met[0];
    let effects_of = |held: &Held| posterior::effects(held, base.solution.model.effects.len(), |_, _| false);
    let mut beside = effects_of(&c.held);
    beside.retain(|id| *id != c.info.id);
    let without = met.iter().filter(|_| !beside.is_empty()).find(|held| effects_of(held) == beside);
    let fit = fit::summary(problem, c.held.solution.clone(), 0.0, &c.held.free, &Options::default());
    let parameters = c
        .held
        .free
        .iter()
        .zip(&fit.estimates)
        .filter_map(|(free, e)| match free {
            Free::Effect { parameter, effect, .. } if *effect == c.info.id => c
                .info
                .parameters
                .get(*parameter)
                .map(|p| (p.name, Value { value: e.value, low: e.low, high: e.high, unit: p.unit })),
            _ => None,
        })
        .collect();
    CandidateReport {
        id: c.info.id,
        info: c.info,
        held_out_error: c.held.misfit.error,
        probability: 0.0,
        p_value: c.p_value,
        explained: explained(&base.misfit, &c.held.misfit),
        explained_beyond: without.map(|held| explained(&held.misfit, &c.held.misfit)),
        beside,
        worst: c.held.misfit.places.first().map(|p| (channel_name(p.channel), p.phase.name(), p.size)),
        parameters,
        signature: signature(problem, base, &c.held),
    }
}

/// The verdict in words where the noise is what the model leaves: what counts are held-out trials.
fn better_predicted(
    effects: &[&'static str],
    equal: &[Vec<&'static str>],
    candidates: &[CandidateReport],
) -> String {
    let named = candidates.iter().filter(|c| effects.contains(&c.id));
    let chance = named.map(|c| c.p_value).fold(1.0, f64::min);
    let others: Vec<String> = equal.iter().map(|e| e.join(" + ")).collect();
    let or =
        if others.is_empty() { String::new() } else { format!(", or equally well {}", others.join(" or ")) };
    format!(
        "The model lacks {}{or}: trials that it was not fitted to are predicted better with it than chance \
         could (p = {chance:.1e}).",
        effects.join(" and ")
    )
}

/// What shows an effect that is the only one and is measured by itself, without what the model misses.
fn measured(effects: &[&'static str]) -> Option<&'static str> {
    let [id] = effects else { return None };
    match find_effect(id)?.role {
        Role::Order => Some(
            "repetitions made later differ from those made before by more than chance, as friction that changes with the order of \
             trials makes them",
        ),
        Role::Delay => Some(
            "before anything touches it the object trails the gripper by the same time at each speed, by more than chance, as one \
             that is seen late does",
        ),
        Role::Constants => Some(
            "before anything touches the object the pusher's sensor shows a constant force or torque, more than is stated of it, \
             that the fingers do not bear",
        ),
        _ => None,
    }
}

/// `effects`, and the sets that do as well.
fn or_equally(effects: &[&'static str], equal: &[Vec<&'static str>]) -> String {
    let named = effects.join(" and ");
    let sets: Vec<String> = equal.iter().map(|e| e.join(" + ")).collect();
    if sets.is_empty() { named } else { format!("{named}, or equally well {}", sets.join(" or ")) }
}

/// A smaller share of the excess error is none.
const LEAST_SHARE: f64 = 0.005;

/// The verdict in words. Its shares are those of the table of `candidates`.
fn sentence(
    verdict: Verdict,
    effects: &[&'static str],
    equal: &[Vec<&'static str>],
    candidates: &[CandidateReport],
    [misfit, left]: [&Misfit; 2],
    clear: bool,
) -> String {
    let best = |of: &mut dyn Iterator<Item = &'_ CandidateReport>| {
        of.map(|c| (c.id, c.own_share())).max_by(|a, b| a.1.0.total_cmp(&b.1.0))
    };
    let percent = |share: f64| format!("{:.0} %", 100.0 * share.clamp(0.0, 1.0));
    let named = |c: &&CandidateReport| effects.contains(&c.id);
    let (share, of_what) = match effects {
        [_] => best(&mut candidates.iter().filter(named)).map_or_else(Default::default, |c| c.1),
        // The last of them stands on the others.
        _ => {
            let together = candidates.iter().filter(named).map(|c| c.explained).fold(0.0, f64::max);
            (together, "of the excess error".to_owned())
        }
    };
    let others = |c: &&CandidateReport| !named(c) && !equal.iter().flatten().any(|e| *e == c.id);
    let next = best(&mut candidates.iter().filter(others))
        .map_or(String::new(), |(id, (share, _))| format!("; next best {id} ({})", percent(share)));
    match verdict {
        Verdict::NothingMissing if misfit.worst() > RELEVANT => format!(
            "Nothing is missing: no channel misses by more than {RELEVANT:.1} run spreads beyond chance (the largest misfit, \
             {:.1}, is within it).",
            misfit.worst()
        ),
        Verdict::NothingMissing | Verdict::Inconclusive => format!(
            "Nothing is missing: no channel has a systematic misfit of more than {:.1} run spreads.",
            misfit.worst().max(0.1)
        ),
        // Of what the model misses it may explain nothing: means of repetitions hide a drift.
        Verdict::Effect if share < verdict::EXPLAINS && measured(effects).is_some() => format!(
            "The model lacks {}: {} (p = {:.1e}).",
            effects.join(" and "),
            measured(effects).unwrap_or_default(),
            candidates.iter().find(named).map_or(0.0, |c| c.p_value)
        ),
        // What is left of a small excess says little.
        Verdict::Effect | Verdict::Ambiguous if clear => format!(
            "The model lacks {}: no channel misses by more than {:.1} run spreads beyond chance, and all of them together show it \
             (held-out error {:.2} to {:.2}).",
            or_equally(effects, equal),
            misfit.worst(),
            misfit.error,
            left.error
        ),
        Verdict::Effect => format!(
            "The model lacks {}; {} {} {of_what}{next}.",
            effects.join(" and "),
            if effects.len() == 1 { "it explains" } else { "together they explain" },
            percent(share)
        ),
        Verdict::Ambiguous => format!(
            "The model lacks {}: these data do not separate them ({} {of_what} explained){next}.",
            or_equally(effects, equal),
            percent(share)
        ),
        Verdict::Unexplained => match best(&mut candidates.iter()) {
            Some((id, (share, of_what))) if share > LEAST_SHARE => format!(
                "An effect is missing, and none of the known ones explains it: the best, {id}, explains {} {of_what}.",
                percent(share)
            ),
            _ => "An effect is missing, and none of the known ones explains any of it.".into(),
        },
    }
}
