//! Where a fit starts: friction far from the truth lets an object drop, and past the edge at which a
//! contact lets go least squares sees nothing.

use stickslip_shared::effects::MAX_PARAMETERS;
use stickslip_shared::model::Model;

use crate::fit::campaign::Campaign;
use crate::fit::engine::{Place, Solution, descend, solve};
use crate::fit::free::{Free, base_parameters};
use crate::fit::noise;
use crate::fit::phases::BINS;
use crate::fit::problem::Problem;
use crate::fit::screen::{Start, screen};
use crate::model::candidate::CandidateEffect;

/// Friction that differs by this factor may be another way of contact.
const FAR: f64 = 1.2;
/// Friction coefficients tried before a fit: fingers, then pusher (rubber platforms grip hard).
const TRIED: [&[f64]; 3] = [&[0.15, 0.4, 0.8], &[0.1, 0.25, 0.7, 2.5], &[0.15, 0.3, 0.6, 2.5]];

/// Friction tried from where a fit ended: each by this factor from the one before, within this range, as long as the loss
/// is not more than so many times what the fit left.
const NEXT: f64 = 1.12;
const FARTHEST: [f64; 2] = [0.1, 2.5];
const HOPELESS: f64 = 5.0;
/// A valley whose floor is not above this many times what the fit left is worth a few steps.
const WORTH_STEPS: f64 = 2.0;
/// A step to one side of an edge raises the loss by so many times what one to the other side does.
const EDGE: f64 = 4.0;
/// So often at most the fit goes on from beside an edge.
const EDGES: usize = 3;
/// Steps that show whether it is worth the rest, and what it must leave of the loss.
const FEW_STEPS: usize = 2;
const BETTER: f64 = 0.98;

/// Groups on which places of a grid are ranked first, and how many are ranked again on more: one of [`LIKELY_SHARE`], and
/// not less than [`FEWEST_LIKELY`].
const VERY_FEW: usize = 3;
const LIKELY_SHARE: usize = 8;
const FEWEST_LIKELY: usize = 12;
/// Groups that friction is ranked on before a fit.
pub const MANY: usize = 24;

/// Cost of a model in which single failures of the simulation or of the model weigh little:
/// the sum of `e^2 / (1 + e^2 / 100)` over features of `most` groups.
pub fn robust_cost(campaign: &Campaign, model: &Model<f64>, most: usize) -> f64 {
    let step = campaign.groups.len().div_ceil(most.max(1)).max(1);
    let groups: Vec<usize> = (0..campaign.groups.len()).step_by(step).collect();
    let channels = noise::channel_noise(&campaign.description.sensors);
    let firsts: Vec<usize> = groups.iter().map(|g| campaign.groups[*g].runs[0]).collect();
    let predicted = campaign.simulate_runs(model, &firsts);
    let mut total = 0.0;
    for (run, p) in firsts.iter().zip(&predicted) {
        let measured = &campaign.runs[*run].measured;
        for (f, (y, x)) in measured.iter().zip(p).enumerate() {
            let (noise, uncertainty) = channels[f / BINS];
            let e = (y - x) / (10.0 * noise + uncertainty);
            if e.is_finite() {
                total += e * e / (1.0 + e * e / 100.0);
            }
        }
    }
    total
}

/// `model` with `free` friction fitted, from the values given and from a rough start: what fits
/// best by `robust_cost`.
pub fn first_fit(campaign: &Campaign, model: &Model<f64>, free: &[Free], iterations: usize) -> Model<f64> {
    basins(campaign, model, free, iterations).swap_remove(0)
}

/// As [`first_fit`], and after it the other models met on the way whose friction is far from
/// it: where contacts stick there that slip here, an effect acts otherwise, and what a model
/// without it fits best need not be near what one with it does.
pub fn basins(campaign: &Campaign, model: &Model<f64>, free: &[Free], iterations: usize) -> Vec<Model<f64>> {
    let from = |start: &Model<f64>| {
        let problem = Problem::new(campaign, start);
        descend(&problem, Place::of(&problem, start.clone(), free), free, iterations, &[]).place.model
    };
    let rough = rough_start(campaign, model, free);
    let mut tries = vec![model.clone(), from(model)];
    if rough != *model {
        tries.extend([from(&rough), rough]);
    }
    let mut ranked: Vec<(f64, Model<f64>)> =
        tries.into_iter().map(|m| (robust_cost(campaign, &m, MANY), m)).collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut out: Vec<Model<f64>> = Vec::new();
    for (_, m) in ranked {
        if out.iter().all(|other| apart(campaign, &m, other)) {
            out.push(m);
        }
    }
    out
}

/// As [`solve`], and [`across_edges`] from there: what is only added to a model later must not have the credit for a valley
/// that the model could have been in.
pub fn solve_across(problem: &Problem, model: &Model<f64>, free: &[Free], steps: usize) -> Solution {
    across_edges(problem, solve(problem, model, free, steps), free, steps)
}

/// `best`, or what is better in another valley of a friction coefficient or beyond an edge, fitted with so many `steps`. Past the
/// edge at which a contact lets go or holds, all of the loss lies on a plateau, down which least squares moves away from the edge
/// for ever: each coefficient is followed on its own, all else as it is, to where the loss falls again. And at an edge itself
/// sensitivities are those of both of its sides, by which no step leads on either: the fit goes on from the flatter side.
pub fn across_edges(problem: &Problem, mut best: Solution, free: &[Free], steps: usize) -> Solution {
    let better = |start: Place, best: &Solution| {
        let found = descend(problem, start, free, FEW_STEPS, &[]).place;
        (found.loss < BETTER * best.loss.1).then(|| {
            let found = descend(problem, found, free, steps, &[]).end(problem, free);
            Solution { loss: (best.loss.0, found.loss.1), ..found }
        })
    };
    for f in free.iter().filter(|f| f.coefficient().is_some()) {
        for _ in 0..EDGES {
            let mut beside = Vec::new();
            for factor in [NEXT, 1.0 / NEXT] {
                let way = along(problem, &best, free, (f, factor));
                beside.extend(way.first);
                if let Some(found) = way.valley.and_then(|start| better(start, &best)) {
                    (best, beside) = (found, Vec::new());
                }
            }
            match flatter(beside, best.loss.1).and_then(|start| better(start, &best)) {
                Some(found) => best = found,
                None => break,
            }
        }
    }
    best
}

/// Of two places to either side of a fit that left so much `loss` the one that is worse by far less than the other: between them
/// is an edge.
fn flatter(beside: Vec<Place>, loss: f64) -> Option<Place> {
    let [one, other]: [Place; 2] = beside.try_into().ok()?;
    let (flat, steep) = if one.loss < other.loss { (one, other) } else { (other, one) };
    let is_edge = steep.loss - loss > EDGE * (flat.loss - loss).max(0.0);
    (is_edge && flat.loss < WORTH_STEPS * loss).then_some(flat)
}

/// What a friction coefficient does to the loss, all else as it is.
struct Way {
    /// A step away.
    first: Option<Place>,
    /// The lowest place beyond a rise.
    valley: Option<Place>,
}

/// Along one coefficient from `best` on in steps of `factor`.
fn along(problem: &Problem, best: &Solution, free: &[Free], (f, factor): (&Free, f64)) -> Way {
    let mut model = best.model.clone();
    let (mut before, mut falls) = (best.loss.1, false);
    let mut way = Way { first: None, valley: None };
    loop {
        let value = factor * f.get(&model);
        f.set(&mut model, value);
        let beyond = if factor > 1.0 { value > FARTHEST[1] } else { value < FARTHEST[0] };
        if beyond {
            break;
        }
        let place = Place::of(problem, model.clone(), free);
        let loss = place.loss;
        way.first.get_or_insert_with(|| place.clone());
        if !(loss < HOPELESS * best.loss.1) {
            break;
        }
        falls = falls || loss < before;
        let floor = way.valley.as_ref().map_or(WORTH_STEPS * best.loss.1, |found| found.loss);
        if falls && loss < floor {
            way.valley = Some(place);
        }
        before = loss;
    }
    way
}

/// Whether the friction of two models differs so much that contacts may stick in one and slip in
/// the other.
pub fn apart(campaign: &Campaign, a: &Model<f64>, b: &Model<f64>) -> bool {
    base_parameters(campaign).iter().any(|f| (f.get(a) / f.get(b)).ln().abs() > FAR.ln())
}

/// `model` with all combinations of friction coefficients that are tried before a fit.
pub fn friction_grid(campaign: &Campaign, model: &Model<f64>) -> Vec<Model<f64>> {
    grid(base_parameters(campaign).iter(), model)
}

/// `model` first, and with all combinations of values that are tried for these coefficients.
fn grid<'a>(coefficients: impl Iterator<Item = &'a Free>, model: &Model<f64>) -> Vec<Model<f64>> {
    let mut out = vec![model.clone()];
    for free in coefficients {
        let varied = |m: &Model<f64>| -> Vec<Model<f64>> {
            let with = |value: &f64| {
                let mut m = m.clone();
                free.set(&mut m, *value);
                m
            };
            std::iter::once(m.clone()).chain(tried(free).iter().map(with)).collect()
        };
        out = out.iter().flat_map(varied).collect();
    }
    out
}

fn tried(free: &Free) -> &'static [f64] {
    match free {
        Free::FingerFriction => TRIED[0],
        Free::PusherFriction => TRIED[1],
        _ => TRIED[2],
    }
}

/// `model` with those of the `free` friction coefficients that fit best on a coarse grid, by a
/// robust cost: far from the truth an object may be dropped, and least squares would look nowhere
/// else. All combinations: an object that rolls between two faces needs the friction of both. A coefficient that is not
/// free stays exactly where it is: moved here it would never come back, and take up what else the model lacks.
pub fn rough_start(campaign: &Campaign, model: &Model<f64>, free: &[Free]) -> Model<f64> {
    let coefficients = free.iter().filter(|f| f.coefficient().is_some());
    let cost = |model: &Model<f64>| robust_cost(campaign, model, MANY);
    let found = likely(campaign, grid(coefficients, model), MANY, 1).into_iter().next();
    found.filter(|found| cost(found) < cost(model)).unwrap_or_else(|| model.clone())
}

/// The `most` of `models` that fit best by [`robust_cost`] on `groups` groups: very few of them show what drops the object
/// or jams it, as most of a grid does.
pub fn likely(campaign: &Campaign, models: Vec<Model<f64>>, groups: usize, most: usize) -> Vec<Model<f64>> {
    let best = |models: Vec<Model<f64>>, groups: usize, most: usize| -> Vec<Model<f64>> {
        let cost = |m: Model<f64>| (robust_cost(campaign, &m, groups), m);
        let mut ranked: Vec<(f64, Model<f64>)> = models.into_iter().map(cost).collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        ranked.into_iter().take(most).map(|(_, m)| m).collect()
    };
    let first = (models.len() / LIKELY_SHARE).max(FEWEST_LIKELY).max(most);
    best(best(models, VERY_FEW, first), groups, most)
}

/// Models from which the fit of `model` with one more effect may start: the best two by
/// screening on `model` and on other ways of contact, or the effect with the parameters given
/// where no setting of it shows.
pub fn starts(
    campaign: &Campaign,
    model: &Model<f64>,
    free: &[Free],
    (candidate, given): (&CandidateEffect, [f64; MAX_PARAMETERS]),
) -> Vec<Model<f64>> {
    let info = candidate.info;
    let problem = Problem::new(campaign, model);
    let mut ways = basins(campaign, model, free, 0);
    ways.retain(|m| apart(campaign, m, model));
    let bases: Vec<Solution> =
        std::iter::once(model).chain(&ways).map(|m| solve(&problem, m, free, 0)).collect();
    let screened = screen(&problem, &bases.iter().collect::<Vec<_>>(), free, candidate).starts;
    let of_first = screened.iter().find(|s| s.on == 0);
    let mut out: Vec<_> = screened.iter().take(2).collect();
    out.extend(of_first.filter(|s| !out.iter().any(|o| o.on == s.on)));
    let slot = model.effects.len();
    let mut all = free.to_vec();
    all.extend(Free::of_effect(info, slot));
    let reached = |s: &Start| within_reach(&problem, &bases[s.on], s, &all, slot).model;
    match out.is_empty() {
        true => vec![candidate.on(model, given)],
        false => out.into_iter().map(reached).collect(),
    }
}

/// `start`, or as much of the way there from `on` as does not make matters worse: past the edge at
/// which a contact lets go, first order says nothing.
pub fn within_reach(problem: &Problem, on: &Solution, start: &Start, free: &[Free], slot: usize) -> Place {
    let mut model = start.model.clone();
    for share in [1.0, 0.7, 0.4, 0.15] {
        for f in free {
            let from = match f {
                Free::Effect { slot: s, of, .. } if *s == slot && of.typical == of.neutral => continue,
                Free::Effect { slot: s, of, .. } if *s == slot => of.neutral,
                _ => f.get(&on.model),
            };
            f.set(&mut model, from + share * (f.get(&start.model) - from));
        }
        let place = Place::of(problem, model.clone(), free);
        if place.loss < on.loss.1 {
            return place;
        }
    }
    Place::of(problem, start.model.clone(), free)
}
