//! Screening: how much of the misfit each effect could explain, to first order.
//!
//! Each effect is switched on at a few settings (its typical strength, several values of
//! what only shapes it), and the change of all features is an added variable beside the
//! friction coefficients and the sensor offsets. The settings that explain most are where
//! the joint refit starts.

use std::collections::BTreeSet;

use crate::model::candidate::CandidateEffect;
use stickslip_shared::effects::{Info, MAX_PARAMETERS};
use stickslip_shared::model::Model;

use crate::fit::constants;
use crate::fit::engine::Solution;
use crate::fit::features::Features;
use crate::fit::free::Free;
use crate::fit::gls;
use crate::fit::problem::{Problem, difference};
use crate::fit::sensing;

/// An effect to try, with where its fit may start.
#[derive(Clone, Debug)]
pub struct Screened {
    /// Which.
    pub trial: CandidateEffect,
    /// Decrease of the loss to first order.
    pub gain: f64,
    /// Where to start from, best first.
    pub starts: Vec<Start>,
    /// Places of its parameters that are fitted ([`constants::open`]).
    pub open: Vec<usize>,
    /// No setting changes any feature by more than a hundredth of its noise.
    pub invisible: bool,
}

/// Where the fit of an effect may start.
#[derive(Clone, Debug)]
pub struct Start {
    /// Loss to be expected from there, to first order.
    pub loss: f64,
    /// Which of the solutions it stands on.
    pub on: usize,
    /// That solution's model with the effect, and with the other parameters moved along.
    pub model: Model<f64>,
}

/// Values that a parameter which only shapes an effect is tried at.
fn shapes(p: &stickslip_shared::effects::Parameter) -> Vec<f64> {
    let tries = if !p.tries.is_empty() {
        p.tries.to_vec()
    } else if p.typical == 0.0 {
        vec![0.0, 0.5 * p.high]
    } else {
        vec![p.typical, 0.25 * p.typical, 4.0 * p.typical]
    };
    tries.into_iter().filter(|x| *x >= p.low && *x <= p.high).collect()
}

/// All combinations of the shaping parameters' values, the typical ones first.
fn settings(info: &Info, shaping: &[usize]) -> Vec<[f64; MAX_PARAMETERS]> {
    let mut typical = [0.0; MAX_PARAMETERS];
    for (k, p) in info.parameters.iter().enumerate() {
        typical[k] = if shaping.contains(&k) { p.typical } else { p.neutral };
    }
    let mut out = vec![typical];
    for k in shaping {
        for before in out.clone() {
            for value in shapes(&info.parameters[*k]) {
                let mut s = before;
                s[*k] = value;
                if !out.contains(&s) {
                    out.push(s);
                }
            }
        }
    }
    out
}

/// Most starts kept of each solution.
const STARTS: usize = 3;

/// Screens one effect on top of each of `bases`; the gain counts from the first of them.
pub fn screen(
    problem: &Problem,
    bases: &[&Solution],
    base_free: &[Free],
    trial: &CandidateEffect,
) -> Screened {
    let mut starts = Vec::new();
    let mut invisible = true;
    let open = bases
        .first()
        .map_or(Vec::new(), |base| constants::open(trial.info, &base.offsets, &problem.of_offsets));
    if bases.iter().all(|base| changes_nothing(problem, base, trial)) {
        return Screened { trial: trial.clone(), gain: 0.0, starts, open, invisible };
    }
    for (on, base) in bases.iter().enumerate() {
        if open.is_empty() {
            invisible = false;
            break;
        }
        let (here, largest) = screen_on(problem, (on, base), base_free, (trial, &open));
        starts.extend(here);
        invisible &= largest < 1e-2;
    }
    starts.sort_by(|a: &Start, b| a.loss.total_cmp(&b.loss));
    let before = bases.first().map_or(0.0, |base| {
        gls::least(&base.grams, &problem.priors(base_free, base.columns.len() - base_free.len())).0
    });
    let gain = starts.first().map_or(0.0, |s| before - s.loss);
    Screened { trial: trial.clone(), gain, starts, open, invisible }
}

/// Whether the effect, with all of its strengths at their typical size, changes no bit of any feature: it acts on a
/// contact that is not there.
fn changes_nothing(problem: &Problem, base: &Solution, trial: &CandidateEffect) -> bool {
    let mut typical = [0.0; MAX_PARAMETERS];
    for (to, p) in typical.iter_mut().zip(trial.info.parameters) {
        *to = p.typical;
    }
    let with = trial.on(&base.model, typical);
    // The first group of a condition stands for it in predictions of all groups.
    let mut conditions = BTreeSet::new();
    problem.groups.iter().zip(&base.predicted).all(|(group, predicted)| {
        if !conditions.insert(problem.campaign.groups[*group].condition) {
            return true;
        }
        let with = problem.predict_of(&with, &[*group]).pop().unwrap_or_default();
        with.iter().zip(predicted).all(|(a, b)| a == b || (a.is_nan() && b.is_nan()))
    })
}

/// What each of `models`, which have one effect more than the model that `predicted`, changes of the features. What sensors alone do
/// needs no simulation; all else is simulated side by side.
pub fn changes(problem: &Problem, predicted: &[Features], models: &[Model<f64>]) -> Vec<Vec<Features>> {
    let last = |m: &Model<f64>| m.effects.last().copied();
    let sensed = |m: &Model<f64>| last(m).filter(|e| e.info().is_some_and(|info| info.role.is_sensing()));
    let others: Vec<Model<f64>> = models.iter().filter(|m| sensed(m).is_none()).cloned().collect();
    let mut simulated = problem.predict_each(&others).into_iter();
    let change = |m: &Model<f64>| match sensed(m) {
        Some(effect) => predicted.iter().map(|p| sensing::shown(&effect, p)).collect(),
        None => {
            let with = simulated.next().unwrap_or_default();
            with.iter().zip(predicted).map(|(w, p)| difference(w, p, 1.0)).collect()
        }
    };
    models.iter().map(change).collect()
}

/// The best starts on one solution, and the largest change that any setting makes.
fn screen_on(
    problem: &Problem,
    (on, base): (usize, &Solution),
    base_free: &[Free],
    (trial, open): (&CandidateEffect, &[usize]),
) -> (Vec<Start>, f64) {
    let info = trial.info;
    let predicted = &base.predicted;
    let changed = |all: &[[f64; MAX_PARAMETERS]]| -> Vec<Vec<Features>> {
        let models: Vec<Model<f64>> = all.iter().map(|p| trial.on(&base.model, *p)).collect();
        changes(problem, predicted, &models)
    };
    let size = |d: &[Features]| -> f64 {
        d.iter()
            .zip(&problem.groups)
            .flat_map(|(d, g)| {
                problem.whiteners[*g].active.iter().map(move |f| (d[*f] / problem.single_run[*g][*f]).abs())
            })
            .filter(|x| x.is_finite())
            .fold(0.0, f64::max)
    };
    // A parameter is a strength if it alone makes a difference; otherwise it shapes.
    let mut strengths = Vec::new();
    let mut shaping = Vec::new();
    for (k, p) in info.parameters.iter().enumerate() {
        if p.typical == p.neutral {
            shaping.push(k);
        } else if open.contains(&k) {
            strengths.push(k);
        }
    }
    let mut starts: Vec<Start> = Vec::new();
    let mut start = |loss: f64, parameters: [f64; MAX_PARAMETERS], x: &[f64]| {
        let mut model = trial.on(&base.model, parameters);
        for (f, x) in base_free.iter().zip(x) {
            f.set(&mut model, f.get(&base.model) + f.limited(&base.model, *x));
        }
        starts.push(Start { loss, on, model });
    };
    let mut largest: f64 = 0.0;
    // Contacts have edges: what an effect does one way tells little of the other. Around the best fit without
    // it the other way was tried by its fit.
    let ways: &[f64] = if on == 0 { &[1.0] } else { &[1.0, -1.0] };
    let each = settings(info, &shaping).into_iter().flat_map(|s| ways.iter().map(move |way| (s, *way)));
    let each: Vec<([f64; MAX_PARAMETERS], f64)> = each.collect();
    let strong = |k: usize, way: f64| {
        let p = &info.parameters[k];
        let there = p.neutral + way * (p.typical - p.neutral);
        (there >= p.low && there <= p.high).then_some(there)
    };
    let alone = |setting: &[f64; MAX_PARAMETERS], way: f64, k: usize| {
        let mut s = *setting;
        s[k] = strong(k, way)?;
        Some(s)
    };
    let first: Vec<[f64; MAX_PARAMETERS]> = each
        .iter()
        .flat_map(|(setting, way)| strengths.iter().filter_map(move |k| alone(setting, *way, *k)))
        .collect();
    let mut first = first.iter().copied().zip(changed(&first));
    for (setting, way) in each {
        let mut columns = Vec::new();
        let mut varied = Vec::new();
        let size_of = |k: usize| strong(k, way);
        let mut together: Option<Vec<Features>> = None;
        for k in strengths.iter().filter(|k| size_of(**k).is_some()) {
            let Some((mut s, mut d)) = first.next() else { break };
            let mut dead = size(&d) < 1e-2;
            if dead && strengths.len() > 1 {
                // It may need the others to act: `s` is then the same for each of them.
                for j in &strengths {
                    s[*j] = size_of(*j).unwrap_or(s[*j]);
                }
                if columns.is_empty() {
                    let with_all = together.get_or_insert_with(|| changed(&[s]).pop().unwrap_or_default());
                    if size(with_all) >= 1e-2 {
                        d.clone_from(with_all);
                        dead = false;
                    }
                }
            }
            largest = largest.max(size(&d));
            if !dead {
                columns.push(d);
                varied.push((*k, s));
            }
        }
        if columns.is_empty() {
            continue;
        }
        let (known, added) = (base_free.len(), columns.len());
        let beside = problem.beside(&base.residual, &base.columns[..known], columns);
        let with_those = |kept: &[usize]| {
            let (loss, mut x) = gls::least(&beside.with(kept), &problem.priors(base_free, kept.len()));
            x.truncate(known + kept.len());
            (loss, x)
        };
        let single: Vec<(f64, Vec<f64>)> = (0..added).map(|k| with_those(&[k])).collect();
        let (together, x) = with_those(&(0..added).collect::<Vec<_>>());
        let mut joint = setting;
        let strength = |k: usize, s: &[f64; MAX_PARAMETERS], a: f64| {
            let p = &info.parameters[k];
            (p.neutral + a * (s[k] - p.neutral)).clamp(p.low, p.high)
        };
        for ((k, s), a) in varied.iter().zip(&x[known..]) {
            for j in &strengths {
                if j != k && !varied.iter().any(|(v, _)| v == j) {
                    joint[*j] = s[*j];
                }
            }
            joint[*k] = strength(*k, s, *a);
        }
        start(together, joint, &x);
        for ((k, s), (l, x)) in varied.iter().zip(&single) {
            if varied.len() > 1 {
                let mut one = *s;
                one[*k] = strength(*k, s, x[known]);
                start(*l, one, x);
            }
        }
    }
    starts.sort_by(|a, b| a.loss.total_cmp(&b.loss));
    starts.truncate(STARTS);
    (starts, largest)
}
