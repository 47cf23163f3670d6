//! All trials of a data set made ready for fitting: prepared, reduced to features, sorted
//! into conditions, with a noise model taken from the repetitions.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicUsize, Ordering};

use nalgebra::Vector3;
use rayon::prelude::*;
use stickslip_shared::effects::Role;
use stickslip_shared::effects::formula::{Program, Variable};
use stickslip_shared::model::{Base, Friction, Model};

use crate::channels::{self, Quantity};
use crate::evidence::carried;
use crate::evidence::conditions::condition_of;
use crate::evidence::overhang;
use crate::evidence::pads::{self, Pads};
use crate::evidence::pose_clock::Delay;
use crate::evidence::pusher_bias::Bias;
use crate::evidence::sensors::sensors_or_estimated;
use crate::fit::features::{Bins, Features};
use crate::fit::phases;
use crate::run::scene::SceneError;
use crate::run::simulate::{Prepared, Simulated, prepare};
use stickslip_data::{Dataset, Description, TrialInfo};

/// Repetitions farther apart than this share of the data set are treated as two groups:
/// what depends on the order of trials differs between them.
const NEAR_IN_ORDER: f64 = 0.1;
/// A trial is stepped in about this many steps where sensitivities are computed.
const COARSE_STEPS: usize = 100;
/// A coarse step is no longer than this, s.
const COARSE_S: f64 = 0.0125;
/// The same where nothing is gripped, s: no pad and no jaw has to settle, and a push is quasi-static.
const COARSE_PUSH_S: f64 = 0.0201;
/// No lever of a contact is longer, m.
const LONGEST_LEVER_M: f64 = 0.1;

/// One trial.
#[derive(Debug)]
pub struct Run {
    /// Ready to simulate.
    pub prepared: Prepared,
    /// Its row in trials.csv.
    pub info: TrialInfo,
    /// Which samples enter which feature.
    pub bins: Bins,
    /// Measured features.
    pub measured: Features,
    /// Index of its condition.
    pub condition: usize,
    /// Stride of coarse simulations, samples.
    pub stride: usize,
    /// Where pads reach over an edge: how far the pressure on what lies on the face is off their middle, for each sample and
    /// finger ([`overhang::shifts_m`]).
    pub over_edges_m: Option<Vec<[Vector3<f64>; 2]>>,
}

/// Repetitions of one condition that were made near each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Index of the condition.
    pub condition: usize,
    /// Indices of its runs; one of them stands for all where sensitivities are computed.
    pub runs: Vec<usize>,
}

/// A data set ready for fitting.
#[derive(Debug)]
pub struct Campaign {
    /// `dataset.toml`, its sensors completed where nothing is stated.
    pub description: Description,
    /// Friction of the model as given: where a fit stays that the data do not move.
    pub given: Friction<f64>,
    /// In the order of trials.csv, without those that could not be prepared.
    pub runs: Vec<Run>,
    /// Groups of repetitions.
    pub groups: Vec<Group>,
    /// Number of different conditions.
    pub conditions: usize,
    /// How late the object's poses are behind the gripper's, where the motion before contact shows it.
    pub delay: Option<Delay>,
    /// Constant error of the pusher's sensor beyond what is stated, where the time before contact shows it.
    pub bias: Option<Bias>,
    /// As [`Self::pads`] says: what is assumed later takes its turn where what was before does not hold.
    pads: Vec<Pads>,
    /// How many of them do not hold.
    given_up: AtomicUsize,
    /// What was taken for sensors about which nothing is stated, in words; empty where all is.
    pub assumed: Vec<String>,
    /// Trials that could not be prepared, and why.
    pub refused: Vec<SceneError>,
}

impl Campaign {
    /// Prepares all trials that can be simulated. `start` is the model whose contact with the
    /// pusher tells where the onset is; only its friction and base enter.
    pub fn new(dataset: &Dataset, start: &Model<f64>) -> Self {
        let total = dataset.trials.len();
        let ready: Vec<Result<Run, SceneError>> = dataset
            .trials
            .par_iter()
            .enumerate()
            .map(|(i, trial)| {
                let mut prepared = prepare(&dataset.description, trial, i)?;
                prepared.carried = carried::measured(&prepared);
                let stride = stride(&prepared);
                let base = Model::base(start.base, start.friction);
                let bare = Model { formulation: start.formulation, ..base };
                let first = prepared.simulate_every(&bare, stride.min(2));
                let bins = Bins::new(&prepared, phases::bins(&prepared, &first));
                let measured = bins.measured(&prepared);
                let over_edges_m = overhang::shifts_m(&prepared);
                let info = trial.info.clone();
                Ok(Run { prepared, info, bins, measured, condition: 0, stride, over_edges_m })
            })
            .collect();
        let mut runs = Vec::with_capacity(total);
        let mut refused = Vec::new();
        for r in ready {
            match r {
                Ok(run) => runs.push(run),
                Err(e) => refused.push(e),
            }
        }
        let infos: Vec<&TrialInfo> = runs.iter().map(|r| &r.info).collect();
        let of = condition_of(&infos);
        let count = of.iter().max().map_or(0, |m| m + 1);
        let mut groups: Vec<Group> = Vec::new();
        for c in 0..count {
            let mut block: Vec<usize> = Vec::new();
            for i in (0..runs.len()).filter(|i| of[*i] == c) {
                let ordinal = |i: usize| runs[i].prepared.ordinal;
                let apart =
                    block.first().is_some_and(|b| ordinal(i) - ordinal(*b) > NEAR_IN_ORDER * total as f64);
                if apart {
                    groups.push(Group { condition: c, runs: std::mem::take(&mut block) });
                }
                block.push(i);
            }
            groups.push(Group { condition: c, runs: block });
        }
        for (run, c) in runs.iter_mut().zip(of) {
            run.condition = c;
        }
        let delay = Delay::measured(&dataset.trials.iter().collect::<Vec<_>>());
        let late_s = Delay::found_s(delay);
        let loadings: Vec<_> =
            runs.iter().flat_map(|r| pads::loadings(&r.prepared.seen_earlier(late_s))).collect();
        let measured = pads::measured(&loadings);
        let read_off = measured.filter(Pads::matter).and_then(|p| p.beyond(start.base));
        let pads = match read_off {
            Some(pads) => vec![pads],
            None => {
                let hard = measured.into_iter().filter(|_| start.base == Base::Hard);
                hard.flat_map(|p| [Some(p.ordinary()), p.unseen()]).flatten().collect()
            }
        };
        let used = sensors_or_estimated(&dataset.description, dataset.trials.iter());
        Self {
            bias: Bias::measured(dataset, &used.sensors.pusher),
            description: Description { sensors: used.sensors, ..dataset.description.clone() },
            assumed: used.taken,
            given: start.friction,
            delay,
            pads,
            given_up: AtomicUsize::new(0),
            runs,
            groups,
            conditions: count,
            refused,
        }
    }

    /// Compliance of the pads beyond the springs of the model's base: read off where it moves the object by more than a
    /// rigid model may be off; else what is assumed: hard bodies, and where these do not hold and the loadings could not have
    /// shown soft pads, those.
    pub fn pads(&self) -> Option<Pads> {
        self.pads.get(self.given_up.load(Ordering::Relaxed)).copied()
    }

    /// What is assumed of the pads does not hold: from now on the next is, or nothing. What was read off stays. Whether there
    /// is something new to assume.
    pub fn give_up_pads(&self) -> bool {
        if self.pads().is_some_and(|pads| pads.assumed()) {
            self.given_up.fetch_add(1, Ordering::Relaxed);
            return self.pads().is_some();
        }
        false
    }

    /// Features of the model at full resolution, for every run.
    pub fn simulate_all(&self, model: &Model<f64>) -> Vec<Features> {
        self.runs
            .par_iter()
            .map(|r| r.bins.modelled(&tame(&r.prepared, model, r.stride.div_ceil(2))))
            .collect()
    }

    /// Coarse features of the model for the runs that stand for their groups.
    pub fn simulate_runs(&self, model: &Model<f64>, runs: &[usize]) -> Vec<Features> {
        self.simulate_each(std::slice::from_ref(model), runs).pop().unwrap_or_default()
    }

    /// The same of each of `models`, all of them side by side: no core waits for the longest run of one.
    pub fn simulate_each(&self, models: &[Model<f64>], runs: &[usize]) -> Vec<Vec<Features>> {
        // One run of a condition stands for the others, unless the model tells them apart.
        let mut first: BTreeMap<usize, usize> = BTreeMap::new();
        for r in runs {
            first.entry(self.runs[*r].condition).or_insert(*r);
        }
        let ordered: Vec<bool> = models.iter().map(depends_on_order).collect();
        let stands = |k: usize, r: usize| if ordered[k] { r } else { first[&self.runs[r].condition] };
        let wanted: BTreeSet<(usize, usize)> =
            (0..models.len()).flat_map(|k| runs.iter().map(move |r| (k, stands(k, *r)))).collect();
        let one = |(k, r): (usize, usize)| {
            let run = &self.runs[r];
            ((k, r), run.bins.modelled(&tame(&run.prepared, &models[k], run.stride)))
        };
        let wanted: Vec<(usize, usize)> = wanted.into_iter().collect();
        let done: BTreeMap<(usize, usize), Features> = wanted.into_par_iter().map(one).collect();
        let of_model = |k: usize| runs.iter().map(|r| done[&(k, stands(k, *r))].clone()).collect();
        (0..models.len()).map(of_model).collect()
    }

    /// Mean time between samples, s.
    pub fn period_s(&self) -> f64 {
        self.runs.iter().map(|r| r.prepared.period_s()).sum::<f64>() / self.runs.len().max(1) as f64
    }

    /// Smallest diameter of the fingers' pads, m; none where the fingers have no discs.
    pub fn pad_diameter_m(&self) -> Option<f64> {
        self.runs.iter().filter_map(|r| r.prepared.pad_diameter_m()).reduce(f64::min)
    }

    /// Runs of each condition.
    pub fn runs_of(&self) -> Vec<Vec<usize>> {
        let mut out = vec![Vec::new(); self.conditions];
        for (i, r) in self.runs.iter().enumerate() {
            out[r.condition].push(i);
        }
        out
    }

    /// Whether the object's pose is known at few samples only, in every run.
    pub fn sparse(&self) -> bool {
        !self.runs.is_empty() && self.runs.iter().all(|r| r.prepared.is_sparse())
    }

    /// Runs that have a repetition.
    pub fn repeated(&self) -> usize {
        let mut count = vec![0; self.conditions];
        for r in &self.runs {
            count[r.condition] += 1;
        }
        self.runs.iter().filter(|r| count[r.condition] > 1).count()
    }
}

/// Samples stepped over in one coarse step.
fn stride(prepared: &Prepared) -> usize {
    let t_s = &prepared.t_s;
    let period = prepared.period_s();
    let step_s = if prepared.scene.fingers.is_some() { COARSE_S } else { COARSE_PUSH_S };
    let longest = if period > 0.0 { (step_s / period) as usize } else { 1 };
    (t_s.len() / COARSE_STEPS).min(longest).clamp(1, 8)
}

/// The model along a trial; with finer steps where coarse ones leave all bounds (a jammed or
/// dropped object turns faster than they can follow).
fn tame(prepared: &Prepared, model: &Model<f64>, stride: usize) -> Simulated {
    let gravity = prepared.scene.gravity_m_s2.iter().map(|g| g * g).sum::<f64>().sqrt();
    let most_n = 20.0 * (prepared.grip_n() + prepared.scene.object.mass_kg * gravity + 1.0);
    let wild = |s: &Simulated| {
        s.signals.iter().any(|row| {
            row.iter().enumerate().skip(6).any(|(k, x)| match channels::quantity(k) {
                Quantity::Torque => x.abs() > most_n * LONGEST_LEVER_M,
                _ => x.abs() > most_n,
            })
        })
    };
    let mut stride = stride;
    let mut out = prepared.simulate_every(model, stride);
    while stride > 1 && wild(&out) {
        stride /= 2;
        out = prepared.simulate_every(model, stride);
    }
    out
}

/// Whether the model predicts otherwise for a later trial of the same condition.
fn depends_on_order(model: &Model<f64>) -> bool {
    let listed = model.effects.iter().any(|e| e.info().is_some_and(|i| i.role == Role::Order));
    let reads = |program: &Program<f64>| program.reads(Variable::Trial);
    listed || model.formulas.iter().any(|f| reads(&f.program) || reads(&f.state))
}
