//! Selection: which effects the data demand.
//!
//! The survivors of the screening are refitted together with friction and compared by
//! their loss on held-out conditions. An effect is taken when it predicts held-out
//! conditions better by more than chance (Student's t over conditions, corrected for the
//! number of effects tried) and by more than the run spread (it explains most of the
//! excess misfit that is left). Effects whose held-out losses do not differ from the
//! best one's are equally good.

use crate::model::candidate::CandidateEffect;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, FisherSnedecor, StudentsT};
use stickslip_shared::effects::{Info, REGISTRY};
use stickslip_shared::model::{MAX_EFFECTS, Model};

use crate::diagnose::misfit::{self, Misfit};
use crate::diagnose::search::{Ground, Reach, Search};
use crate::fit::features::Features;
use crate::fit::gls::FIXED;
use crate::fit::gls::{self, Prior};
use crate::fit::problem::{Problem, take_off};
use crate::fit::screen::{Screened, Start};
use crate::fit::{self, FOLDS, Free, Solution};

/// Family-wise probability of naming an effect where there is none; what explains enough on conditions that
/// it was not fitted to needs no correction for the number of effects (few conditions give no smaller
/// probabilities).
pub const FALSE_ALARM: f64 = 0.01;
/// The parameter of an effect that is a wave.
pub const WAVE: &str = "wavelength_m";
/// Longest wave that counts as one where it shows in friction and in force, in paths.
const LONGEST_WAVE: f64 = 3.0;
/// A candidate is fitted to all conditions where the search on few found, or promises, this share of what the best one
/// does: what is chosen, or is equal to that, explains nearly as much.
const WORTH_FITTING: f64 = 0.3;
/// ... and so many in any case: what is best is compared with the next.
const FEWEST: usize = 2;
/// Where the best takes more than this share of the loss, the others are tried from where it ended ...
const FROM_THERE: f64 = 0.2;
/// ... which promise there at least as much less this share of it, and more by as much than they were found to take;
const SAME_VALLEY: f64 = 0.3;
/// ... no more than so many.
const MOST_FROM_THERE: usize = 3;
/// A fit whose loss is beyond this many times what its linear model promises did not converge.
const CONVERGED: f64 = 1.2;
/// A model that leaves less than this share of the held-out loss of another is clearly better, however small the misfit of each channel.
const HALF: f64 = 0.5;
/// What a linear model leaves of a condition that was held out is relied on up to so many times what the fit leaves of it.
const LINEAR: f64 = 4.0;

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

impl Held {
    /// What it misses beyond the form of the laws that explain the rest of what `base` does
    /// ([`Misfit::beyond_form`]).
    pub fn beyond(&self, base: &Self) -> Misfit {
        self.misfit.beyond_form(&base.misfit)
    }

    /// Misfit of the fit to all conditions, none held out.
    pub fn fitted(&self, problem: &Problem) -> Misfit {
        misfit::of(problem, &problem.without_offsets(&self.solution.residual, &self.solution.offsets))
    }
}

/// Probability below which a gain is beyond chance, whichever effect has it.
pub fn level() -> f64 {
    FALSE_ALARM / REGISTRY.len() as f64
}

/// Whether `after` leaves less than half of the held-out loss of `before`, beyond chance over all effects: losses are whitened,
/// and show a misfit across the directions in which runs scatter, which hides in the run spread of each channel alone.
pub fn halves(before: &[f64], after: &[f64]) -> bool {
    after.iter().sum::<f64>() < HALF * before.iter().sum::<f64>() && of_gain(before, after, None) < level()
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
    /// Where its fit may have started.
    pub starts: Vec<Start>,
    /// How much was tried to fit it.
    pub searched: Search,
    /// How far that went.
    pub reach: Reach,
}

/// Held-out performance of a solution.
pub fn hold_out(problem: &Problem, solution: Solution, free: Vec<Free>) -> Held {
    let n = free.len();
    let prior = solution.priors(problem, &free, 0);
    let mut folds = gls::fold_solutions(&solution.grams, &prior, FOLDS);
    // Where the fit could not follow the linear model any further, folds must not either.
    let mut fixed = prior.clone();
    fixed.precision[..n].fill(FIXED);
    let least = |prior: &Prior| gls::least(&solution.grams, prior).0;
    if least(&fixed) > CONVERGED * least(&prior) + n as f64 {
        folds = gls::fold_solutions(&solution.grams, &fixed, FOLDS);
    }
    let residual: Vec<Features> = (0..problem.groups.len())
        .into_par_iter()
        .map(|place| {
            let condition = problem.campaign.groups[problem.groups[place]].condition;
            held_out_residual(problem, &solution, &free, place, &folds[gls::fold(condition, FOLDS)])
        })
        .collect();
    let mut loss = vec![0.0; problem.campaign.conditions];
    for (g, r) in problem.groups.iter().zip(&residual) {
        loss[problem.campaign.groups[*g].condition] += problem.whiteners[*g].square(r);
    }
    let misfit = misfit::of(problem, &residual);
    Held { solution, free, loss, residual, misfit }
}

/// What the coefficients `x`, fitted without the condition of the group at `place`, leave of it. Near an edge at which a contact
/// begins to slide a small step of friction does not what the sensitivities of both sides say: where the linear model leaves many
/// times what the fit does, it is simulated.
fn held_out_residual(
    problem: &Problem,
    solution: &Solution,
    free: &[Free],
    place: usize,
    x: &DVector<f64>,
) -> Features {
    let (steps, offsets) = x.as_slice().split_at(free.len());
    let mut linear = problem.without_offsets_at(place, &solution.residual[place], offsets);
    take_off(&mut linear, &solution.columns, place, steps);
    let fitted =
        DVector::from_iterator(x.len(), free.iter().map(|_| 0.0).chain(solution.offsets.iter().copied()));
    let left = |x: &DVector<f64>| gls::loss(&solution.grams[place], x);
    if left(x) <= LINEAR * left(&fitted) {
        return linear;
    }
    let mut model = solution.model.clone();
    for (f, step) in free.iter().zip(steps) {
        f.set(&mut model, f.get(&solution.model) + step);
    }
    let group = problem.groups[place];
    let Some(predicted) = problem.predict_of(&model, &[group]).pop() else { return linear };
    let residual = problem.targets[group].iter().zip(&predicted).map(|(t, p)| t - p).collect();
    problem.without_offsets_at(place, &residual, offsets)
}

/// By how much the loss of each condition falls from `before` to `after`, over the sum of both: a condition in which the
/// effect is ten times as strong weighs no more than others, and one in which it does not show weighs little. Between -1
/// and 1, and symmetrical: the other way round it only changes its sign.
fn relative(before: &[f64], after: &[f64]) -> Vec<f64> {
    let fall = |(b, a): (&f64, &f64)| if b + a > 0.0 { (b - a) / (b + a) } else { 0.0 };
    before.iter().zip(after).map(fall).collect()
}

/// One-sided probability that held-out losses `a` exceed `b` by this much by chance, over
/// conditions. Large values are drawn in to the tenth largest, so that no single condition decides.
pub fn p_value(a: &[f64], b: &[f64]) -> f64 {
    let Some((t, freedom)) = paired(a, b) else { return 1.0 };
    match StudentsT::new(0.0, 1.0, freedom) {
        Ok(d) => d.sf(t),
        Err(_) => 1.0,
    }
}

/// Probability that held-out losses of conditions fall from `before` to `after` by chance: three tests of the same question,
/// of the differences, of their shares and of the effect's `parameters`, where there are enough conditions for that one.
pub fn of_gain(before: &[f64], after: &[f64], parameters: Option<f64>) -> f64 {
    let fall = relative(before, after);
    let tests = [Some(p_value(before, after)), Some(p_value(&fall, &vec![0.0; fall.len()])), parameters];
    combined(&tests.into_iter().flatten().collect::<Vec<f64>>())
}

/// Probability that the effect's strengths differ from neutral by chance: Wald's test with the
/// covariance clustered by condition, against F. `None` where there are too few conditions for that.
fn parameter_p_value(problem: &Problem, solution: &Solution, free: &[Free], from: usize) -> Option<f64> {
    let covariance = fit::clustered_covariance(&solution.grams, &problem.priors(free, 0), free.len());
    let strengths: Vec<(usize, f64)> = free
        .iter()
        .enumerate()
        .skip(from)
        .filter(|(_, f)| matches!(f, Free::Effect { of, .. } if of.typical != of.neutral))
        .map(|(k, f)| (k, f.departure(&solution.model)))
        .filter(|(k, _)| covariance[(*k, *k)] > 0.0)
        .collect();
    let q = strengths.len();
    let conditions = problem.campaign.conditions as f64;
    let freedom = conditions - q as f64 - from as f64;
    if freedom < 1.0 {
        return None;
    }
    if q == 0 {
        return Some(1.0);
    }
    let sd: Vec<f64> = strengths.iter().map(|(k, _)| covariance[(*k, *k)].sqrt()).collect();
    let correlation = DMatrix::from_fn(q, q, |i, j| {
        let c = covariance[(strengths[i].0, strengths[j].0)] / (sd[i] * sd[j]);
        // Nearly equal directions count once.
        if i == j { 1.0 + 1e-6 } else { c * (1.0 - 1e-6) }
    });
    let z = DVector::from_fn(q, |i, _| strengths[i].1 / sd[i]);
    let Some(c) = correlation.cholesky() else { return Some(1.0) };
    let wald = z.dot(&c.solve(&z));
    // Hotelling's correction for few conditions.
    let f = wald / q as f64 * freedom / (conditions - from as f64).max(1.0);
    Some(match FisherSnedecor::new(q as f64, freedom) {
        Ok(d) if f.is_finite() && f > 0.0 => d.sf(f),
        _ => 1.0,
    })
}

/// One probability from tests of the same question on the same data: Cauchy's combination (Liu
/// and Xie 2020), which holds however the tests depend on each other where it is small. What
/// speaks against the effect in one test is bounded, so that it cannot silence the others.
pub fn combined(p: &[f64]) -> f64 {
    let lift = |p: &f64| (std::f64::consts::PI * (0.5 - p.clamp(1e-15, 0.9))).tan();
    let mean = p.iter().map(lift).sum::<f64>() / p.len() as f64;
    0.5 - mean.atan() / std::f64::consts::PI
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

/// Which effects are fitted after their screening.
#[derive(Clone, Copy, Debug)]
pub struct Fitted {
    /// No more than so many, the best first.
    pub most: usize,
    /// Of which the first order promises this share of the loss.
    pub promised: f64,
}

impl Fitted {
    /// The best, whatever they promise.
    pub fn most(most: usize) -> Self {
        Self { most, promised: 0.0 }
    }
}

/// Screens all of `trials` that `base` does not have, and refits the best, from `base` or from one
/// of `others`. Returns candidates with the best held-out loss first, and the effects that
/// cannot be seen.
pub fn candidates(
    problem: &Problem,
    base: &Held,
    others: &[Solution],
    trials: &[CandidateEffect],
    fitted: Fitted,
    tick: &(dyn Fn() + Sync),
) -> (Vec<Candidate>, Vec<&'static str>) {
    let model = &base.solution.model;
    if model.effects.len() >= MAX_EFFECTS {
        return (Vec::new(), Vec::new());
    }
    let ground = Ground::new(problem, (&base.solution, &base.free), others);
    let mut screened: Vec<Screened> = trials
        .iter()
        .filter(|t| !t.is_excluded_by(model))
        .map(|t| {
            let s = ground.screen(t);
            tick();
            s
        })
        .collect();
    let invisible = screened.iter().filter(|s| s.invisible).map(|s| s.trial.info.id).collect();
    let promised = fitted.promised * ground.before();
    screened.retain(|s| s.gain >= promised);
    screened.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let most = screened.first().map_or(0.0, |s| s.gain);
    // Of the best two it is said how they do, however little that is.
    let told = |rank: usize, s: &Screened| {
        if rank < FEWEST { s.gain > 0.0 && !s.invisible } else { s.gain > 1.0 && s.gain > 0.02 * most }
    };
    let ranked = screened.into_iter().enumerate().filter(|(rank, s)| told(*rank, s));
    let kept = ranked.map(|(_, s)| s).take(fitted.most);
    let mut begun: Vec<Begun> = kept
        .filter_map(|s| {
            let begun = Begun::on(&ground, base, s);
            tick();
            begun
        })
        .collect();
    begun.sort_by(|a, b| a.reach.hope().total_cmp(&b.reach.hope()));
    if fitted.most > 0 {
        from_the_best((problem, base, &ground), trials, &mut begun);
    }
    let best = begun.first().map_or(0.0, Begun::takes);
    let worth = begun.iter().filter(|b| b.takes() > WORTH_FITTING * best).count();
    let mut out: Vec<Candidate> = begun
        .into_iter()
        .take(worth.max(FEWEST))
        .filter_map(|Begun { screened, free, found, reach }| {
            let fit = ground.on_all(&found, &free);
            judged(
                (problem, base),
                (screened.trial.info, screened.starts),
                (fit, free),
                (Search::Quick, reach),
            )
        })
        .collect();
    out.sort_by(|a, b| total(&a.held).total_cmp(&total(&b.held)));
    (out, invisible)
}

/// An effect whose fit was begun where it is searched.
struct Begun {
    screened: Screened,
    free: Vec<Free>,
    found: Solution,
    reach: Reach,
}

impl Begun {
    /// From the starts of its screening on `ground`.
    fn on(ground: &Ground, base: &Held, screened: Screened) -> Option<Self> {
        let free = with(base, &screened);
        let found = ground.search((screened.trial.info, &screened.starts), &free, Search::Quick)?;
        let reach = reach(ground, &screened.starts, &found);
        Some(Self { screened, free, found, reach })
    }

    /// Share of the loss that it takes, or may take.
    fn takes(&self) -> f64 {
        1.0 - self.reach.hope()
    }
}

/// The base fitted without what is missing may lie in a valley where only what came out best shows what it can do: the others
/// are screened again with the friction, and the pads, of its fit, and those fitted from there that may take as much.
fn from_the_best(
    (problem, base, ground): (&Problem, &Held, &Ground),
    trials: &[CandidateEffect],
    begun: &mut Vec<Begun>,
) {
    let Some(best) = begun.first().filter(|b| b.takes() > FROM_THERE) else { return };
    let mut there = Model { friction: best.found.model.friction, ..base.solution.model.clone() };
    there.effects.iter_mut().zip(&best.found.model.effects).for_each(|(to, from)| *to = *from);
    let (id, takes) = (best.screened.trial.info.id, best.takes());
    let there = [fit::solve(problem, &there, &base.free, 0)];
    let beside = Ground::new(problem, (&base.solution, &base.free), &there);
    let others = trials.iter().filter(|t| t.info.id != id && !t.is_excluded_by(&base.solution.model));
    let before = ground.before();
    // How much an effect takes already.
    let known = |begun: &[Begun], id: &str| {
        begun.iter().find(|b| b.screened.trial.info.id == id).map_or(0.0, |b| 1.0 - b.reach.left)
    };
    let mut screened: Vec<Screened> = others
        .map(|t| beside.screen_beside(t))
        .filter(|s| s.gain / before > (1.0 - SAME_VALLEY) * takes)
        .filter(|s| s.gain / before > known(begun, s.trial.info.id) + SAME_VALLEY * takes)
        .collect();
    screened.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    for mut again in screened.into_iter().take(MOST_FROM_THERE).filter_map(|s| Begun::on(&beside, base, s)) {
        // On other ground, where they may be searched again, they stand on the base.
        again.screened.starts.iter_mut().for_each(|s| s.on = 0);
        let same = |b: &Begun| b.screened.trial.info.id == again.screened.trial.info.id;
        match begun.iter().position(same) {
            Some(at) if begun[at].reach.left <= again.reach.left => {}
            Some(at) => begun[at] = again,
            None => begun.push(again),
        }
    }
    begun.sort_by(|a, b| a.reach.hope().total_cmp(&b.reach.hope()));
}

/// Free parameters of `base` with the effect that was `screened`.
fn with(base: &Held, screened: &Screened) -> Vec<Free> {
    let all = Free::of_effect(screened.trial.info, base.solution.model.effects.len());
    let open = all.into_iter().enumerate().filter(|(k, _)| screened.open.contains(k));
    base.free.iter().copied().chain(open.map(|(_, free)| free)).collect()
}

/// How far `found` went from its `starts`.
fn reach(ground: &Ground, starts: &[Start], found: &Solution) -> Reach {
    let before = ground.before();
    let promised = starts.first().map_or(1.0, |s| s.loss / before);
    Reach { promised, left: found.loss.1 / before }
}

/// Summed held-out loss.
pub fn total(held: &Held) -> f64 {
    held.loss.iter().sum()
}

/// Part of a wave is no wave: it could be any slow change along the path. Where both friction and the
/// jaw's force show it, less of it is enough. `from` is where the effect's parameters begin.
fn part_of_a_wave(problem: &Problem, best: &Solution, free: &[Free], from: usize, info: &Info) -> bool {
    let at = |name: &str| Some(from + info.parameters.iter().position(|p| p.name == name)?);
    let (Some(wave), Some(force)) = (at(WAVE), at("grip_n")) else { return false };
    let covariance = fit::clustered_covariance(&best.grams, &problem.priors(free, 0), free.len());
    let twice = free[force].get(&best.model).abs() > 3.0 * covariance[(force, force)].sqrt();
    let longest = if twice { LONGEST_WAVE } else { 1.0 } * longest_path(problem);
    free[wave].get(&best.model) > longest
}

/// Longest prescribed path of the trials, m.
fn longest_path(problem: &Problem) -> f64 {
    problem.campaign.runs.iter().map(|r| r.prepared.drive_path()).fold(0.0, f64::max)
}

/// The `most` of `candidates` that may come out best, fitted again from more starts, where least squares may have ended
/// in a side valley; those that come out better take the place of what was there.
pub fn search_again(
    problem: &Problem,
    base: &Held,
    others: &[Solution],
    candidates: &mut [Candidate],
    (most, search): (usize, Search),
    tick: &(dyn Fn() + Sync),
) {
    let ground = Ground::new(problem, (&base.solution, &base.free), others);
    candidates.sort_by(|a, b| a.reach.hope().total_cmp(&b.reach.hope()));
    for c in candidates.iter_mut().take(most).filter(|c| c.searched < search) {
        if let Some(again) = fitted_again((problem, base, &ground), c, search) {
            *c = again;
        }
        c.searched = search;
        tick();
    }
    candidates.sort_by(|a, b| total(&a.held).total_cmp(&total(&b.held)));
}

/// `candidate` after a wider `search`, if it is better held out.
fn fitted_again(
    (problem, base, ground): (&Problem, &Held, &Ground),
    candidate: &Candidate,
    search: Search,
) -> Option<Candidate> {
    let Candidate { info, held, starts, searched, mut reach, .. } = candidate.clone();
    let mut best = held.solution;
    if searched < Search::Grid {
        let found = ground.search((info, &starts), &held.free, search)?;
        let left = found.loss.1 / ground.before();
        if left < reach.left {
            (reach.left, best) = (left, ground.on_all(&found, &held.free));
        }
    }
    if search == Search::Thorough {
        best = ground.beside(best, &held.free);
    }
    if best.model == candidate.held.solution.model {
        return None;
    }
    let again = judged((problem, base), (info, starts), (best, held.free), (search, reach))?;
    Some(again).filter(|again| total(&again.held) < total(&candidate.held))
}

/// The candidate that a fit on top of `base` makes; `None` where it does not apply.
fn judged(
    (problem, base): (&Problem, &Held),
    (info, starts): (&'static Info, Vec<Start>),
    (fit, free): (Solution, Vec<Free>),
    (searched, reach): (Search, Reach),
) -> Option<Candidate> {
    if part_of_a_wave(problem, &fit, &free, base.free.len(), info) {
        return None;
    }
    let parameters = parameter_p_value(problem, &fit, &free, base.free.len());
    let held = hold_out(problem, fit, free);
    let p_value = of_gain(&base.loss, &held.loss, parameters);
    let explained = explained(&base.misfit, &held.misfit);
    Some(Candidate { info, held, p_value, explained, starts, searched, reach })
}
