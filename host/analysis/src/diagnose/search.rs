//! Where the fit of an effect ends: least squares from many starts, on few conditions first.
//!
//! Which start leads where, twelve conditions tell as well as a hundred. All that is judged afterwards
//! (loss, held-out conditions, probability) is of all conditions, from where the search ended. So the time of
//! a search does not grow with the data.

use std::collections::BTreeMap;

use stickslip_shared::effects::Info;
use stickslip_shared::model::Model;

use crate::fit::gls;
use crate::fit::problem::Problem;
use crate::fit::screen::{Screened, Start, screen};
use crate::fit::{self, Descent, Free, Place, Solution};
use crate::model::candidate::CandidateEffect;

/// Work of a candidate's fit, in full Gauss-Newton steps.
const STEPS: usize = 6;
/// Factors on a parameter of the best fit from which a thorough search starts again.
const BESIDE: [f64; 2] = [0.6, 1.6];
/// The same of a fit that only shows whether a start is worth more.
const FEW_STEPS: usize = 2;
/// Ways back to the best fit that a thorough search tries at most.
const MOST_BESIDE: usize = 12;
/// Places of the grid that are worth a few steps.
const WORTH_STEPS: usize = 6;
/// Conditions that a search uses, about.
const FEW: usize = 12;
/// ... and of each primitive at least.
const FEW_EACH: usize = 4;
/// A search on so many times fewer conditions is worth the fit on all of them after it.
const WORTH: f64 = 1.5;

/// How much is tried to fit a candidate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Search {
    /// One step from the best starts, and the best two of these to their end.
    Quick,
    /// Also the best on a grid of friction and of the effect's strength.
    Grid,
    /// As that, and from beside where it ended.
    Thorough,
}

/// How far the search for a fit went, as shares of the loss that the base leaves on the conditions it uses.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// Left to first order.
    pub promised: f64,
    /// Left by the best fit.
    pub left: f64,
}

impl Reach {
    /// What may be left: a fit that falls short of what the first order promises may have ended in a side valley.
    #[must_use]
    pub fn hope(&self) -> f64 {
        self.promised.min(self.left)
    }
}

/// What an effect is fitted on top of.
pub struct Ground<'a> {
    /// All conditions.
    problem: &'a Problem<'a>,
    /// Parameters that are free without the effect.
    free: &'a [Free],
    /// Where the effect may start: the base, and other ways of contact.
    bases: Vec<&'a Solution>,
    /// The same on few conditions, where there are many.
    few: Option<(Problem<'a>, Vec<Solution>)>,
}

impl<'a> Ground<'a> {
    /// On `base`, whose parameters `free` are, and on `others` beside it.
    pub fn new(
        problem: &'a Problem<'a>,
        (base, free): (&'a Solution, &'a [Free]),
        others: &'a [Solution],
    ) -> Self {
        let bases: Vec<&Solution> = std::iter::once(base).chain(others).collect();
        let few = few(problem).map(|places| {
            let bases = bases.iter().map(|b| b.restricted(&places)).collect();
            (problem.restricted(&places), bases)
        });
        Self { problem, free, bases, few }
    }

    /// Where it is searched: on few conditions where there are many.
    fn site(&self) -> (&Problem<'a>, Vec<&Solution>) {
        match &self.few {
            Some((problem, bases)) => (problem, bases.iter().collect()),
            None => (self.problem, self.bases.clone()),
        }
    }

    /// Screens an effect; what few conditions do not show, all of them may.
    pub fn screen(&self, trial: &CandidateEffect) -> Screened {
        let (problem, bases) = self.site();
        let screened = screen(problem, &bases, self.free, trial);
        match self.few {
            Some(_) if screened.invisible => screen(self.problem, &self.bases, self.free, trial),
            _ => screened,
        }
    }

    /// Screens an effect on all that it may start from but the base.
    pub fn screen_beside(&self, trial: &CandidateEffect) -> Screened {
        let (problem, bases) = self.site();
        let mut screened = screen(problem, &bases[1..], self.free, trial);
        screened.starts.iter_mut().for_each(|s| s.on += 1);
        screened.gain = screened.starts.first().map_or(0.0, |s| self.before() - s.loss);
        screened
    }

    /// Loss of the base where it is searched.
    pub fn before(&self) -> f64 {
        let (problem, bases) = self.site();
        bases.first().map_or(0.0, |base| gls::least(&base.grams, &problem.priors(self.free, 0)).0)
    }

    /// The effect fitted together with what the base has from its starts, where it is searched.
    pub fn search(
        &self,
        (info, starts): (&'static Info, &[Start]),
        free: &[Free],
        search: Search,
    ) -> Option<Solution> {
        let (problem, bases) = self.site();
        best_of_starts(problem, self.free.len(), &bases, (info, starts), free, search)
    }

    /// What was `found`, fitted to all conditions.
    pub fn on_all(&self, found: &Solution, free: &[Free]) -> Solution {
        match self.few {
            Some(_) => fit::solve(self.problem, &found.model, free, STEPS),
            None => found.clone(),
        }
    }

    /// The best that is found from beside `best`, if it is better.
    pub fn beside(&self, best: Solution, free: &[Free]) -> Solution {
        let problem = self.site().0;
        let from = match self.few {
            Some(_) => fit::solve(problem, &best.model, free, FEW_STEPS),
            None => best.clone(),
        };
        let before = from.loss.1;
        let found = beside(problem, from, free);
        if found.loss.1 >= before {
            return best;
        }
        let found = self.on_all(&found, free);
        if found.loss.1 < best.loss.1 { found } else { best }
    }
}

/// Places of the groups of few conditions that stand for all of them: of each primitive as many as its share,
/// evenly over the order of conditions. `None` where that is hardly fewer, or where noise is what a model leaves.
fn few(problem: &Problem) -> Option<Vec<usize>> {
    let campaign = problem.campaign;
    let mut by_primitive: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for g in &problem.groups {
        let group = &campaign.groups[*g];
        let of_it = by_primitive.entry(&campaign.runs[group.runs[0]].info.primitive).or_default();
        if !of_it.contains(&group.condition) {
            of_it.push(group.condition);
        }
    }
    let all: usize = by_primitive.values().map(Vec::len).sum();
    let mut kept: Vec<usize> = Vec::new();
    for conditions in by_primitive.values() {
        let n = conditions.len();
        let wanted = (FEW * n / all).max(FEW_EACH).min(n);
        kept.extend((0..wanted).map(|k| conditions[k * (n - 1) / (wanted - 1).max(1)]));
    }
    if problem.noise.of_misfit.is_some() || (all as f64) < WORTH * kept.len() as f64 {
        return None;
    }
    let place = |i: &usize| kept.contains(&campaign.groups[problem.groups[*i]].condition);
    Some((0..problem.groups.len()).filter(place).collect())
}

/// The effect fitted from its `starts` and, unless the search is quick, from the best places of a grid; `known` of
/// the `free` parameters the bases have already.
fn best_of_starts(
    problem: &Problem,
    known: usize,
    bases: &[&Solution],
    (info, starts): (&'static Info, &[Start]),
    free: &[Free],
    search: Search,
) -> Option<Solution> {
    let slot = bases.first()?.model.effects.len();
    let begin = |start: &Start| {
        let on = bases.get(start.on)?;
        let from = fit::within_reach(problem, on, start, free, slot);
        Some(fit::descend(problem, from, free, 1, &on.columns))
    };
    // A few steps from each start show which are worth the rest.
    let mut begun: Vec<Descent> = starts.iter().take(1 + bases.len()).filter_map(begin).collect();
    if search != Search::Quick {
        let few = |m: Model<f64>| fit::descend(problem, Place::of(problem, m, free), free, FEW_STEPS, &[]);
        begun.extend(on_grid(problem, starts, (info, free), slot).into_iter().map(few));
    }
    begun.sort_by(|a, b| a.place.loss.total_cmp(&b.place.loss));
    let ends =
        begun.into_iter().take(2).map(|b| fit::go_on(problem, b.end(problem, free), free, STEPS, known));
    let best = ends.min_by(|a, b| a.place.loss.total_cmp(&b.place.loss))?.end(problem, free);
    Some(fit::across_edges(problem, best, free, STEPS))
}

/// The best places of a grid: friction from little to much, the effect as in `starts` and at its typical
/// strength either way.
fn on_grid(
    problem: &Problem,
    starts: &[Start],
    (info, free): (&Info, &[Free]),
    slot: usize,
) -> Vec<Model<f64>> {
    let mut models: Vec<Model<f64>> = starts.iter().map(|s| s.model.clone()).collect();
    if let Some(start) = starts.first() {
        let strength = |f: &Free| match *f {
            Free::Effect { slot: of, parameter, of: p, .. } if of == slot && p.typical != p.neutral => {
                Some((parameter, p))
            }
            _ => None,
        };
        for (k, p) in free.iter().filter_map(strength) {
            for sign in [1.0, -1.0] {
                let mut m = start.model.clone();
                if let Some(e) = m.effects.get_mut(slot) {
                    for (x, p) in e.parameters.iter_mut().zip(info.parameters) {
                        *x = if p.typical == p.neutral { *x } else { p.neutral };
                    }
                    e.parameters[k] = (p.neutral + sign * (p.typical - p.neutral)).clamp(p.low, p.high);
                }
                if !models.contains(&m) {
                    models.push(m);
                }
            }
        }
    }
    let grid: Vec<Model<f64>> = models.iter().flat_map(|m| fit::friction_grid(problem.campaign, m)).collect();
    fit::likely(problem.campaign, grid, FEW, WORTH_STEPS)
}

/// The best that is found from `best` with one parameter after the other moved away, as long as that
/// gains anything.
fn beside(problem: &Problem, mut best: Solution, free: &[Free]) -> Solution {
    let ways: Vec<(&Free, f64)> = free.iter().flat_map(|f| BESIDE.map(|factor| (f, factor))).collect();
    let mut since = 0;
    for (f, factor) in ways.iter().cycle().take(MOST_BESIDE) {
        if since == ways.len() {
            break;
        }
        since += 1;
        let mut model = best.model.clone();
        f.set(&mut model, f.get(&best.model) * factor);
        let from = Place::of(problem, model, free);
        let found = fit::descend(problem, from, free, FEW_STEPS, &best.columns).place;
        if found.loss < 0.98 * best.loss.1 {
            best = fit::descend(problem, found, free, STEPS, &[]).end(problem, free);
            since = 0;
        }
    }
    best
}
