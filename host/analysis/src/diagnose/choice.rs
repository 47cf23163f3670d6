//! Choice: effects taken one after the other, and those that do as well in their place.
//!
//! The rules are those of 9 and 10 in `docs/diagnose.md`.

use stickslip_shared::effects::{Info, Parameter};
use stickslip_shared::model::Model;

use crate::diagnose::beforehand;
use crate::diagnose::misfit::{Misfit, Place};
use crate::diagnose::ordinary::is_ordinary_in;
use crate::diagnose::posterior::{LEAST, posterior};
use crate::diagnose::search::Search;
use crate::diagnose::select::{
    Candidate, FALSE_ALARM, Fitted, Held, candidates, explained, halves, hold_out, level, paired,
    search_again, total,
};
use crate::diagnose::verdict::{
    self, CERTAIN, EXPLAINS, EXPLAINS_RELEVANT, Left, RELEVANT, UNEXPLAINED, Verdict,
};
use crate::fit::problem::Problem;
use crate::fit::{self, Free, Solution};
use crate::model::candidate::{self, CandidateEffect};

/// A further effect must explain this share of what the others leave.
const EXPLAINS_FURTHER: f64 = 0.5;
/// Candidates whose held-out losses differ by less than this many standard errors are equal.
pub const EQUAL: f64 = 2.0;
/// A candidate that explains this much less than the best is no equal.
const EQUAL_SHARE: f64 = 0.1;
/// One effect is preferred to several that explain no more than this above it.
const SIMPLER: f64 = 0.05;
/// Candidates whose explained shares differ by less are equal whatever the test says.
const SAME_SHARE: f64 = 0.02;
/// ... unless its held-out loss is larger by this factor.
pub const SAME_LOSS: f64 = 1.1;
/// Most effects in an ambiguous set, the one chosen included.
const LARGEST_SET: usize = 3;
/// What any rig has ([`crate::diagnose::ordinary`]) is likely beforehand and needs less evidence.
const LIKELY: f64 = 0.05;
/// A model that explains this share of the excess is worth building the problem anew around.
const NEAR: f64 = 0.5;
/// Strengths of two effects that are correlated more than this are not two findings.
const ENTANGLED: f64 = 0.98;
/// ... where both depart from neutral by this share of their typical size.
const DEPARTS: f64 = 0.1;
/// Share of the excess below which a first effect is not even tried.
const WORTH_TRYING: f64 = 0.25;
/// Candidates that are searched again before `unexplained` is said.
pub const SEARCHED_AGAIN: usize = 4;
/// Candidates for a further effect that are searched on a grid.
pub const SEARCHED_FURTHER: usize = 3;
/// Most effects named.
pub const MOST_EFFECTS: usize = 3;
/// Effects that are fitted where no channel misses by enough to be worth a name.
pub const WEAKER: usize = 4;
/// Beside effects that were chosen, where they must take half of the loss: those of which the first order promises half of that.
const CLEAR: Fitted = Fitted { most: WEAKER, promised: 0.25 };
/// Effects refitted at each stage.
pub const SURVIVORS: usize = 8;
/// A step of the diagnosis was done; for progress bars.
pub type Tick<'a> = &'a (dyn Fn() + Sync);

/// How often the data were gone through.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Pass {
    /// Around the base model.
    First,
    /// Around the best model of the first pass, which did not explain the data.
    Second,
}

/// What is taken from the candidates.
pub struct Choice {
    /// Effects in the order in which they were chosen.
    pub chosen: Vec<Candidate>,
    /// For each of them: those that do as well in its place.
    pub equal: Vec<Vec<&'static str>>,
    /// Where nothing explains the data: the best model met, if it explains much of them.
    pub near: Option<Model<f64>>,
    /// Where nothing explains the data: effects that explain what they act on.
    pub part: Option<Part>,
    /// What is left where no more was found than any rig has.
    pub left: Option<Misfit>,
    /// Verdict of the search.
    pub verdict: Verdict,
}

/// Effects that explain all that they act on, while something else is missing.
pub struct Part {
    /// In the order in which they were chosen.
    pub chosen: Vec<Candidate>,
    /// For each of them: those that do as well in its place.
    pub equal: Vec<Vec<&'static str>>,
    /// The worst of what is missing beside them.
    pub beside: Place,
}

impl Choice {
    /// Nothing was chosen, nothing is wrong.
    pub fn nothing() -> Self {
        let verdict = Verdict::NothingMissing;
        Self { chosen: Vec::new(), equal: Vec::new(), near: None, part: None, left: None, verdict }
    }
}

/// Candidates for a further effect beside those of a model.
pub type Stages = Vec<(Model<f64>, Vec<Candidate>)>;

/// Whether `candidate`, which stands on `before`, is clear in all channels together, and more than any rig has.
pub fn is_clear(problem: &Problem, before: &Held, candidate: &Candidate) -> bool {
    halves(&before.loss, &candidate.held.loss) && !is_ordinary_in(problem, &candidate.held, candidate.info.id)
}

/// What effects are chosen from.
struct Choosing<'a> {
    problem: &'a Problem<'a>,
    start: &'a Held,
    /// Candidates for the first place.
    first: &'a [Candidate],
    trials: &'a [CandidateEffect],
    pass: Pass,
    search: Search,
    given: Option<&'a Model<f64>>,
    tick: Tick<'a>,
}

impl Choosing<'_> {
    /// Effects in the order in which they are chosen, for each those that do as well, and the candidates beside the last.
    fn one_after_the_other(
        &self,
        stages: &mut Stages,
    ) -> (Vec<Candidate>, Vec<Vec<&'static str>>, Vec<Candidate>) {
        let mut chosen: Vec<Candidate> = Vec::new();
        let mut equal: Vec<Vec<&'static str>> = Vec::new();
        let mut stage = self.first.to_vec();
        let mut settled = !self.start.misfit.misses(RELEVANT);
        while chosen.len() < MOST_EFFECTS {
            let Some(best) = stage.iter().position(|c| self.takes(&chosen, c, settled)) else {
                break;
            };
            let winner = stage[best].clone();
            equal.push(equals(beforehand::last(self.start, &chosen), &winner, &stage));
            let last = winner.held.clone();
            chosen.push(winner);
            settled = !last.beyond(self.start).misses(RELEVANT);
            if chosen.len() < MOST_EFFECTS {
                stage = self.further(&last, settled, stages);
            }
        }
        (chosen, equal, stage)
    }

    /// Whether `c` is taken beside those `chosen`, which leave nothing that is worth a name in any channel where `settled`.
    fn takes(&self, chosen: &[Candidate], c: &Candidate, settled: bool) -> bool {
        let before = beforehand::last(self.start, chosen);
        let named = findings(self.problem, chosen).count();
        let share = explained(&before.misfit, &c.held.misfit);
        let ordinary = is_ordinary_in(self.problem, &c.held, c.info.id);
        let worth = if named == 0 || ordinary { WORTH_TRYING } else { EXPLAINS_FURTHER };
        let chance = match share {
            _ if ordinary => LIKELY,
            // The problem is built around one of the candidates: that favours it.
            _ if self.pass == Pass::Second => level(),
            _ if share > CERTAIN => LIKELY,
            _ if share > EXPLAINS => FALSE_ALARM,
            _ if share > EXPLAINS_RELEVANT && !c.held.beyond(self.start).exceeds(RELEVANT) => FALSE_ALARM,
            _ => level(),
        };
        let by_share = !settled && share > worth && c.p_value < chance;
        (by_share || is_clear(self.problem, before, c))
            && (chosen.is_empty() || !entangled(self.problem, &c.held))
    }

    /// Candidates beside the effects of `last`. Where those leave nothing that is worth a name in any channel (`settled`), a
    /// further one must be clear in all of them together.
    fn further(&self, last: &Held, settled: bool, stages: &mut Stages) -> Vec<Candidate> {
        let Self { problem, trials, tick, .. } = *self;
        let on = &last.solution.model;
        // What is missing pulls friction away, and the effects chosen so far with it.
        let others = if settled { Vec::new() } else { other_ways(problem, last, self.given) };
        let at = stages.iter().position(|(model, _)| model == on).unwrap_or_else(|| {
            let fitted = if settled { CLEAR } else { Fitted::most(SURVIVORS) };
            stages.push((on.clone(), candidates(problem, last, &others, trials, fitted, tick).0));
            stages.len() - 1
        });
        if !settled {
            // Beside another effect least squares often ends in a side valley.
            let (most, search) = match self.search {
                Search::Quick => (SEARCHED_FURTHER, Search::Grid),
                other => (SEARCHED_AGAIN, other),
            };
            search_again(problem, last, &others, &mut stages[at].1, (most, search), tick);
        }
        stages[at].1.clone()
    }

    /// One effect that does what several `chosen` ones do together: the better answer.
    fn alone(&self, chosen: &[Candidate]) -> Option<&Candidate> {
        let (start, last) = (self.start, &chosen.last()?.held);
        let together = explained(&start.misfit, &last.misfit);
        // One of these effects itself is no simpler answer where it leaves a clear misfit that it does not act on.
        let is_one = |c: &Candidate| chosen.iter().any(|of| of.info.id == c.info.id);
        // Nor one that leaves more than tolerances make, where the others leave no more than these.
        let within = !last.misfit.is_beyond_perfect();
        let leaves_more = |c: &Candidate| {
            within && c.held.misfit.is_beyond_perfect() && c.held.beyond(start).exceeds(RELEVANT)
        };
        let leaves = |c: &Candidate| {
            poor(&c.held.beyond(start))
                || halves(&c.held.loss, &last.loss)
                || is_one(c) && (verdict::untouched(&start.misfit, &c.held.misfit) || leaves_more(c))
        };
        self.first.iter().find(|c| c.p_value < level() && c.explained > together - SIMPLER && !leaves(c))
    }
}

/// Chooses effects one after the other, `first` being the candidates for the first place and `stages`
/// those for further ones met so far, and judges what they explain. Further ones may also start from friction as in `given`.
pub fn choose(
    problem: &Problem,
    start: &Held,
    first: &[Candidate],
    trials: &[CandidateEffect],
    stages: &mut Stages,
    (pass, search, given): (Pass, Search, Option<&Model<f64>>),
    tick: Tick,
) -> Choice {
    let choosing = Choosing { problem, start, first, trials, pass, search, given, tick };
    let named = |chosen: &[Candidate]| findings(problem, chosen).count();
    let (mut chosen, mut equal, stage) = choosing.one_after_the_other(stages);
    let met = chosen.iter().chain(stage.first()).min_by(|a, b| total(&a.held).total_cmp(&total(&b.held)));
    let held_out = met.filter(|c| explained(&start.misfit, &c.held.misfit) > NEAR);
    // Around a model that is far off, corrections and folds mislead: what fits much better may do worse held out.
    let fitted = first.iter().min_by(|a, b| loss(a).total_cmp(&loss(b)));
    let fitted = fitted.filter(|c| loss(c) < (1.0 - NEAR) * start.solution.loss.1);
    let near = held_out.or(fitted).map(|c| c.held.solution.model.clone());
    drop_needless(problem, start, &mut chosen, &mut equal);
    let single = |c: &Candidate| (vec![c.clone()], vec![equals(start, c, first)]);
    if named(&chosen) > 1
        && let Some(alone) = choosing.alone(&chosen)
    {
        (chosen, equal) = single(alone);
    }
    if let [only] = chosen.as_slice()
        && let Some(simpler) = simpler(start, only, first)
        && is_possible(problem, start, simpler, only)
    {
        (chosen, equal) = single(simpler);
    }
    if let ([only], [others]) = (chosen.as_slice(), equal.as_slice())
        && let Some(probable) =
            more_probable(problem, start, only, first.iter().filter(|c| others.contains(&c.info.id)))
    {
        let beside = only.info.id;
        (chosen, equal) = single(probable);
        equal.iter_mut().filter(|of| !of.contains(&beside)).for_each(|of| of.push(beside));
    }
    simplify(problem, start, (&mut chosen, &mut equal), first, trials);
    let share = chosen.last().map_or(0.0, |c| explained(&start.misfit, &c.held.misfit));
    let clear = chosen.last().is_some_and(|c| halves(&start.loss, &c.held.loss));
    let explains = chosen.last().is_some_and(|c| {
        let left = Left::of(&c.held.beyond(start));
        verdict::explains(share, &left) || clear && left.settled()
    });
    // What any rig has is no missing effect: what counts is what it leaves.
    let judged = chosen.last().filter(|_| named(&chosen) == 0).map_or(start, |c| &c.held);
    let only_ordinary = !chosen.is_empty() && named(&chosen) == 0;
    let nothing = Choice { left: only_ordinary.then(|| judged.misfit.clone()), ..Choice::nothing() };
    match verdict::of_search(explains, named(&chosen), &Left::of(&judged.misfit)) {
        verdict @ Verdict::Effect => Choice { chosen, equal, verdict, ..Choice::nothing() },
        verdict @ Verdict::Unexplained => {
            let apart = chosen.last().filter(|c| named(&chosen) > 0 && !entangled(problem, &c.held));
            let apart = apart.and_then(|c| verdict::apart(&start.misfit, &c.held.beyond(start)));
            let part = apart.map(|beside| Part { chosen, equal, beside });
            Choice { verdict, near, part, ..Choice::nothing() }
        }
        _ => nothing,
    }
}

/// `ways` of contact that are far from `start`, each at its place, with the effects of `start`.
pub fn other_ways<'m>(
    problem: &Problem,
    start: &Held,
    ways: impl IntoIterator<Item = &'m Model<f64>>,
) -> Vec<Solution> {
    let model = &start.solution.model;
    let on = |m: &Model<f64>| match m.effects.len() == model.effects.len() {
        true => m.clone(),
        // More was found since.
        false => Model { friction: m.friction, ..model.clone() },
    };
    ways.into_iter()
        .filter(|m| fit::apart(problem.campaign, m, model))
        .map(|m| fit::solve(problem, &on(m), &start.free, 0))
        .collect()
}

/// What the fit of a candidate leaves.
fn loss(candidate: &Candidate) -> f64 {
    candidate.held.solution.loss.1
}

/// Whether a fit of several effects plays one against another, or pulls one as far as it goes: what they
/// explain together is then neither's.
fn entangled(problem: &Problem, held: &Held) -> bool {
    let Held { solution, free, .. } = held;
    let covariance = fit::clustered_covariance(&solution.grams, &problem.priors(free, 0), free.len());
    let strength = |f: &Free| match f {
        Free::Effect { slot, of, .. } if of.typical != of.neutral => Some((*slot, *of)),
        _ => None,
    };
    // What hardly departs from its absence is not played against anything, whatever it is correlated with.
    let departs = |k: usize| {
        let far = |of: &Parameter| {
            (free[k].get(&solution.model) - of.neutral).abs() > DEPARTS * (of.typical - of.neutral).abs()
        };
        let at_edge = solution.at_edge.get(k).copied().unwrap_or(false);
        strength(&free[k]).is_some_and(|(_, of)| far(of)) && !at_edge
    };
    let at_bound = |f: &Free| {
        let x = f.get(&solution.model);
        !f.is_usual() && strength(f).is_some_and(|(_, of)| x != of.neutral && (x <= of.low || x >= of.high))
    };
    let correlated = |k: usize, l: usize| {
        let r = covariance[(k, l)] / (covariance[(k, k)] * covariance[(l, l)]).sqrt();
        let (a, b) = (strength(&free[k]), strength(&free[l]));
        matches!((a, b), (Some(a), Some(b)) if a.0 != b.0) && r.abs() > ENTANGLED && departs(k) && departs(l)
    };
    free.iter().any(at_bound) || (0..free.len()).any(|k| (0..k).any(|l| correlated(k, l)))
}

/// Whether something else stands behind what a fit leaves, however much it explains.
fn poor(misfit: &Misfit) -> bool {
    Left::of(misfit).poor()
}

/// `held` fitted without the effect at `slot`, from where it ended.
pub fn without(problem: &Problem, held: &Held, slot: usize) -> Held {
    let mut model = held.solution.model.clone();
    candidate::remove(&mut model, slot);
    refitted(problem, &model, held.free.iter().filter_map(|f| f.without_slot(slot)).collect())
}

/// `held` without those parameters of effects that are `left_out`: they stand where they do nothing.
pub fn without_parameters(problem: &Problem, held: &Held, left_out: impl Fn(&Free) -> bool) -> Held {
    let mut model = held.solution.model.clone();
    for f in held.free.iter().filter(|f| left_out(f)) {
        if let Free::Effect { of, .. } = f {
            f.set(&mut model, of.neutral);
        }
    }
    refitted(problem, &model, held.free.iter().filter(|f| !left_out(f)).copied().collect())
}

/// Fitted from `model` on, and held out.
fn refitted(problem: &Problem, model: &Model<f64>, free: Vec<Free>) -> Held {
    hold_out(problem, fit::solve(problem, model, &free, 8), free)
}

/// Takes out effects that the others made needless: fitted without one from where all of them ended, they
/// explain as much. An effect may have done no more than open the way there.
fn drop_needless(
    problem: &Problem,
    start: &Held,
    chosen: &mut Vec<Candidate>,
    equal: &mut Vec<Vec<&'static str>>,
) {
    let mut k = 0;
    while chosen.len() > 1 && k < chosen.len() {
        let last = &chosen[chosen.len() - 1].held;
        let slot = start.solution.model.effects.len() + k;
        if slot >= last.solution.model.effects.len() {
            return;
        }
        let held = without(problem, last, slot);
        let share = |held: &Held| explained(&start.misfit, &held.misfit);
        let needless = match k + 1 == chosen.len() {
            // What it was taken for, counted anew.
            true => {
                explained(&held.misfit, &last.misfit) <= EXPLAINS_FURTHER && !halves(&held.loss, &last.loss)
            }
            false => {
                share(&held) > share(last) - SIMPLER
                    && !halves(&held.loss, &last.loss)
                    && (!poor(&held.beyond(start)) || poor(&last.beyond(start)))
            }
        };
        if needless {
            chosen.remove(k);
            equal.remove(k);
            if let Some(last) = chosen.last_mut() {
                last.held = held;
            }
            k = 0;
        } else {
            k += 1;
        }
    }
}

/// The sets that explain the data as well as `chosen` beside those found `before`: one effect exchanged for an
/// `equal` one.
pub fn sets(
    before: &[&'static str],
    chosen: &[Candidate],
    equal: &[Vec<&'static str>],
    unnamed: impl Fn(&Candidate) -> bool,
) -> Vec<Vec<&'static str>> {
    let ids: Vec<&'static str> = chosen.iter().filter(|c| !unnamed(c)).map(|c| c.info.id).collect();
    let named = |c: &&(&Candidate, &Vec<&'static str>)| !unnamed(c.0);
    let mut out = Vec::new();
    for (k, (_, others)) in chosen.iter().zip(equal).filter(|c| named(&c)).enumerate() {
        for other in others.iter().filter(|o| !ids.contains(o)) {
            let mut set = ids.clone();
            set[k] = other;
            out.push(before.iter().copied().chain(set).collect());
        }
    }
    out
}

/// Those of `chosen` that are more, in the fit of the last of them, than any rig has.
fn findings<'a>(problem: &'a Problem, chosen: &'a [Candidate]) -> impl Iterator<Item = &'a Candidate> {
    let last = chosen.last();
    chosen.iter().filter(move |c| last.is_some_and(|last| !is_ordinary_in(problem, &last.held, c.info.id)))
}

/// Exchanges effects for such as have fewer strengths, explained something beyond chance by themselves, and do as well or better
/// beside the others.
fn simplify(
    problem: &Problem,
    start: &Held,
    (chosen, equal): (&mut Vec<Candidate>, &mut Vec<Vec<&'static str>>),
    first: &[Candidate],
    trials: &[CandidateEffect],
) {
    let level = level();
    let ids: Vec<&'static str> = findings(problem, chosen).map(|c| c.info.id).collect();
    for id in ids.into_iter().filter(|_| first.len() > 1) {
        let Some((k, last)) = chosen.iter().position(|c| c.info.id == id).zip(chosen.last()) else { return };
        let slot = start.solution.model.effects.len() + k;
        if chosen.len() < 2 || slot >= last.held.solution.model.effects.len() {
            return;
        }
        let acts = |t: &&CandidateEffect| first.iter().any(|c| c.info.id == t.info.id && c.p_value < level);
        let fewer = |t: &&CandidateEffect| strengths(t.info) < strengths(chosen[k].info);
        let rivals: Vec<CandidateEffect> = trials.iter().filter(fewer).filter(acts).cloned().collect();
        if rivals.is_empty() {
            continue;
        }
        let others = without(problem, &last.held, slot);
        let as_it_is = Candidate {
            info: chosen[k].info,
            explained: explained(&others.misfit, &last.held.misfit),
            ..last.clone()
        };
        let mut stage = candidates(problem, &others, &[], &rivals, Fitted::most(rivals.len()), &|| ()).0;
        stage.push(as_it_is);
        let Some(as_it_is) = stage.last() else { return };
        let Some(simpler) = simpler(&others, as_it_is, &stage).cloned() else { continue };
        let as_good = equals(&others, &simpler, &stage);
        chosen.remove(k);
        equal.remove(k);
        chosen.push(simpler);
        equal.push(as_good);
    }
}

/// Of those of `first` that do as well as `only`, and explain as much, the one with the fewest strengths, if it has fewer: a
/// wrong mass comes before a force that does what its weight does.
fn simpler<'a>(start: &Held, only: &Candidate, first: &'a [Candidate]) -> Option<&'a Candidate> {
    let equal = equals(start, only, first);
    let as_good = |c: &&Candidate| {
        equal.contains(&c.info.id)
            && only.explained - c.explained < SAME_SHARE
            && (total(&c.held) <= total(&only.held) || equals(start, c, first).contains(&only.info.id))
    };
    let simplest = first.iter().filter(as_good).min_by_key(|c| strengths(c.info));
    simplest.filter(|c| strengths(c.info) < strengths(only.info))
}

/// Whether `simpler` has a probability worth speaking of beside `only`: shares of what a few conditions miss say little.
fn is_possible(problem: &Problem, start: &Held, simpler: &Candidate, only: &Candidate) -> bool {
    let given = start.solution.model.effects.len();
    let weighed = posterior(problem, given, &[start, &only.held, &simpler.held], |_, _| false);
    weighed.of(simpler.info.id) > LEAST * weighed.of(only.info.id)
}

/// Of `equals`, which do as well as `only`, the one beside which it has no probability worth speaking of: a sum of losses of few
/// conditions is decided by one that the others say little of.
fn more_probable<'a>(
    problem: &Problem,
    start: &Held,
    only: &Candidate,
    equals: impl Iterator<Item = &'a Candidate>,
) -> Option<&'a Candidate> {
    equals.fold(None, |best: Option<&Candidate>, c| {
        match is_possible(problem, start, best.unwrap_or(only), c) {
            true => best,
            false => Some(c),
        }
    })
}

/// How many strengths an effect has.
fn strengths(info: &Info) -> usize {
    info.parameters.iter().filter(|p| p.typical != p.neutral).count()
}

/// Candidates that do as well as the winner on held-out conditions.
fn equals(base: &Held, winner: &Candidate, stage: &[Candidate]) -> Vec<&'static str> {
    // Where little had to be explained, shares say little.
    let settled = |c: &Candidate| !c.held.beyond(base).exceeds(RELEVANT);
    stage
        .iter()
        .filter(|c| c.info.id != winner.info.id)
        .filter(|c| {
            let no_worse = paired(&c.held.loss, &winner.held.loss).is_none_or(|(t, _)| t < EQUAL);
            let behind = winner.explained - explained(&base.misfit, &c.held.misfit);
            // Significant or not: what differs by so little is below the run spread.
            // Where a clear misfit is left, something else is missing: losses do not tell then what it hides, and what
            // differs by less than the little that is left is as good.
            let clear = winner.held.beyond(base).exceeds(UNEXPLAINED);
            let left = if clear && winner.explained > EXPLAINS { 1.0 - winner.explained } else { 0.0 };
            let near = clear || total(&c.held) < SAME_LOSS * total(&winner.held);
            let both = settled(winner) && settled(c) && winner.explained < EXPLAINS;
            (no_worse && (behind < EQUAL_SHARE || both)) || (near && behind < SAME_SHARE.max(left))
        })
        .take(LARGEST_SET - 1)
        .map(|c| c.info.id)
        .collect()
}
