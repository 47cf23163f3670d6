//! Which effects predict trials best that they were not fitted to, where no trial was repeated.
//!
//! What chance does is then known only as what a model leaves ([`crate::fit::unrepeated`]), so that no model
//! can be called complete, but two can be compared: each, with the noise that it leaves itself, gives the
//! features of held-out trials a density, and the one whose densities are higher is the better (the logarithm
//! as score: Good 1952). Gains are compared over trials by Student's t; an effect is named where chance
//! would give its gain in less than a hundredth of data sets, whichever of the effects it is, and those beside
//! it that are behind by less than two standard errors are as good.

use statrs::distribution::{ContinuousCDF, StudentsT};
use stickslip_shared::model::Model;

use crate::diagnose::choice::{EQUAL, MOST_EFFECTS, Tick};
use crate::diagnose::findings::Findings;
use crate::diagnose::posterior::Posterior;
use crate::diagnose::select::{Candidate, Fitted, Held, candidates, explained, hold_out, level, paired};
use crate::diagnose::verdict::{Doubt, Verdict};
use crate::fit::campaign::Campaign;
use crate::fit::problem::Problem;
use crate::fit::{self, Free, unrepeated};
use crate::model::candidate::CandidateEffect;

/// Candidates that are judged with noise of their own.
const JUDGED: usize = 4;
/// The best of effects that are not named is mentioned where chance would do as much more seldom than this.
const WORTH_A_WORD: f64 = 0.05;
/// Largest number of others that an ambiguous answer lists.
const MOST_EQUAL: usize = 3;
/// Gauss-Newton steps around the new noise.
const STEPS: usize = 4;

/// A model with the noise that it leaves, and how it does on held-out conditions.
struct Judged<'a> {
    problem: Problem<'a>,
    held: Held,
    /// Logarithm of the density of each condition; NaN where the model fails altogether.
    density: Vec<f64>,
}

impl<'a> Judged<'a> {
    fn new(campaign: &'a Campaign, model: &Model<f64>, free: &[Free]) -> Self {
        let problem = Problem::new(campaign, model);
        let held = hold_out(&problem, fit::solve_across(&problem, model, free, STEPS), free.to_vec());
        let mut density = vec![f64::NAN; campaign.conditions];
        for (g, residual) in problem.groups.iter().zip(&held.residual) {
            let group = &campaign.groups[*g];
            let whitener = &problem.whiteners[*g];
            let weights = problem.noise.of_misfit.as_ref();
            let weight = weights.and_then(|w| w.get(problem.stands[*g])).copied().unwrap_or(1.0);
            density[group.condition] = unrepeated::log_density(
                whitener.square(residual),
                whitener.active.len(),
                weight,
                whitener.log_determinant(),
            );
        }
        Self { problem, held, density }
    }

    /// By how much it gives more density than `other`: sum over conditions, and Student's t with its freedom.
    fn gain(&self, other: &Self) -> (f64, Option<(f64, f64)>) {
        let both = self.density.iter().zip(&other.density).filter(|(a, b)| a.is_finite() && b.is_finite());
        let (a, b): (Vec<f64>, Vec<f64>) = both.unzip();
        (a.iter().zip(&b).map(|(a, b)| a - b).sum(), paired(&a, &b))
    }

    /// Probability that it gains as much over `other` by chance.
    fn chance(&self, other: &Self) -> f64 {
        let Some((t, freedom)) = self.gain(other).1 else { return 1.0 };
        StudentsT::new(0.0, 1.0, freedom).map_or(1.0, |d| d.sf(t))
    }

    /// Whether it is no worse than `best` beyond chance.
    fn equals(&self, best: &Self) -> bool {
        best.gain(self).1.is_none_or(|(t, _)| t < EQUAL)
    }
}

/// Candidates on top of `start`, each with its own noise, the most density first; and what cannot be seen.
fn judge<'a>(
    campaign: &'a Campaign,
    start: &Judged<'a>,
    trials: &[CandidateEffect],
    tick: Tick,
) -> (Vec<(Candidate, Judged<'a>)>, Vec<&'static str>) {
    let (found, invisible) = candidates(&start.problem, &start.held, &[], trials, Fitted::most(JUDGED), tick);
    let mut out: Vec<(Candidate, Judged<'a>)> = found
        .into_iter()
        .map(|mut c| {
            let judged = Judged::new(campaign, &c.held.solution.model, &c.held.free);
            c.p_value = judged.chance(start);
            c.explained = explained(&start.held.misfit, &judged.held.misfit);
            c.held = judged.held.clone();
            tick();
            (c, judged)
        })
        .collect();
    let gain = |j: &Judged| j.gain(start).0;
    out.sort_by(|a, b| gain(&b.1).total_cmp(&gain(&a.1)));
    (out, invisible)
}

/// How contacts give way before they slide belongs to the fit, and is no finding.
fn is_finding(candidate: &Candidate) -> bool {
    !candidate.info.role.is_compliance()
}

/// Chooses among `trials` what predicts held-out trials better than the model of `base` does, one effect after
/// the other until chance could do as much or several do as well; with the problem around what was chosen.
pub fn find<'a>(
    campaign: &'a Campaign,
    base: &Held,
    trials: &[CandidateEffect],
    tick: Tick,
) -> (Problem<'a>, Findings) {
    let mut at = Judged::new(campaign, &base.solution.model, &base.free);
    let base = at.held.clone();
    let (mut first, mut unseen) = (Vec::new(), Vec::new());
    let (mut chosen, mut equal): (Vec<Candidate>, Vec<Vec<&'static str>>) = (Vec::new(), Vec::new());
    while chosen.len() < MOST_EFFECTS && equal.is_empty() {
        let (judged, invisible) = judge(campaign, &at, trials, tick);
        if chosen.is_empty() {
            first = judged.iter().map(|(c, _)| c.clone()).collect();
            unseen = invisible;
        }
        let mut beyond_chance = judged.into_iter().filter(|(c, _)| c.p_value < level());
        let Some((candidate, best)) = beyond_chance.next() else { break };
        let ids: Vec<&'static str> = chosen.iter().filter(|c| is_finding(c)).map(|c| c.info.id).collect();
        equal = beyond_chance
            .filter(|(other, judged)| is_finding(other) && judged.equals(&best))
            .map(|(other, _)| ids.iter().copied().chain([other.info.id]).collect())
            .take(MOST_EQUAL)
            .collect();
        chosen.push(candidate);
        at = best;
    }
    let last = chosen.last().map(|c| c.held.clone());
    chosen.retain(is_finding);
    let verdict = match (chosen.is_empty(), equal.is_empty()) {
        (true, _) => Verdict::Inconclusive,
        (_, true) => Verdict::Effect,
        (_, false) => Verdict::Ambiguous,
    };
    let best = first.first().map(|c: &Candidate| (c.info.id, c.p_value)).filter(|(_, p)| *p < WORTH_A_WORD);
    let doubt = chosen.is_empty().then_some(Doubt::Unrepeated(best));
    let model = at.held.solution.model.clone();
    let findings = Findings {
        start: base.clone(),
        weaker: Vec::new(),
        base,
        found: Vec::new(),
        first,
        chosen,
        last,
        equal,
        // Without repetitions the noise is each model's own: no common scale to weigh sets by.
        posterior: Posterior::default(),
        invisible: unseen,
        swing: None,
        again: None,
        verdict,
        beside: None,
        doubt,
        model,
    };
    (at.problem, findings)
}
