//! The fitting problem of a data set: group means, their covariance, and the model's
//! predictions for them.
//!
//! Predictions are cheap ones with a correction: `f(theta) = fine(theta0) + coarse(theta) -
//! coarse(theta0)`, coarse in time and for one run of each group.

use std::sync::Arc;

use rayon::prelude::*;
use stickslip_shared::model::{Model, Scene};

use crate::channels::Quantity;
use crate::evidence::pads::SD_OF_RANGE;
use crate::evidence::tolerance::{RIGID, lies_free, push_channel};
use crate::fit::campaign::{Campaign, Group, Run};
use crate::fit::features::{self, FEATURES, Features};
use crate::fit::free::Free;
use crate::fit::gls::{self, Beside, Columns, FIXED, Gram, Prior, Whitener};
use crate::fit::loading;
use crate::fit::noise::{self, Noise};
use crate::fit::phases::{BINS, Phase};
use crate::fit::{
    alignment, carried, closing, common_floor, constants, edges, placing, points, sharing, uneven, unrepeated,
};
use crate::left_out::LeftOut;

/// See the module.
#[derive(Clone, Debug)]
pub struct Problem<'a> {
    /// The data.
    pub campaign: &'a Campaign,
    /// What chance does.
    pub noise: Noise,
    /// For each group: features that the coarse model should show.
    pub targets: Vec<Features>,
    /// For each group.
    pub whiteners: Arc<Vec<Whitener>>,
    /// For each group: what the rig's constants add to its features ([`constants::columns`]).
    pub constants: Arc<Vec<Vec<Features>>>,
    /// These, whitened.
    pub offsets: Vec<Columns>,
    /// Prior of the constants.
    pub of_offsets: Prior,
    /// For each group: standard deviation of one run of each feature, floor included.
    pub single_run: Vec<Features>,
    /// For each group: standard deviation of the floor of each feature.
    pub floors: Vec<Features>,
    /// Residual of each run against the model it was built with.
    pub residuals: Vec<Features>,
    /// Groups in use.
    pub groups: Vec<usize>,
    /// Runs left out because the model fails in them altogether.
    pub failed: Vec<usize>,
    /// For each group: the run along which it is simulated.
    pub stands: Vec<usize>,
}

/// Runs whose error is far beyond that of all others (the model drops or jams the object
/// there); their residuals are struck out.
fn failed(campaign: &Campaign, residuals: &mut [Features]) -> Vec<usize> {
    let channels = noise::channel_noise(&campaign.description.sensors);
    let score = |r: &Features| -> f64 {
        let (mut sum, mut n) = (0.0, 0.0);
        for (f, e) in r.iter().enumerate().filter(|(_, e)| e.is_finite()) {
            let (noise, uncertainty) = channels[f / BINS];
            sum += (e / (5.0 * noise + uncertainty)).powi(2);
            n += 1.0;
        }
        (sum / f64::max(n, 1.0)).sqrt()
    };
    let scores: Vec<f64> = residuals.iter().map(score).collect();
    let mut sorted = scores.clone();
    sorted.sort_by(f64::total_cmp);
    let median = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
    let out: Vec<usize> = (0..scores.len()).filter(|r| scores[*r] > f64::max(20.0, 15.0 * median)).collect();
    for r in &out {
        residuals[*r].fill(f64::NAN);
    }
    out
}

/// For each group: its first run that is used; where none is, that of another group of the condition.
fn stands(campaign: &Campaign, residuals: &[Features]) -> Vec<usize> {
    let used = |group: &Group| group.runs.iter().copied().find(|r| noise::is_used(&residuals[*r]));
    let beside = |group: &Group| {
        let same = campaign.groups.iter().filter(|other| other.condition == group.condition);
        same.filter_map(used).next()
    };
    let stands = |group: &Group| used(group).or_else(|| beside(group)).unwrap_or(group.runs[0]);
    campaign.groups.iter().map(stands).collect()
}

/// Floor of what fingers and pusher bear together at rest, all but the push itself, and of how two
/// fingers share torsion before anything has slid ([`sharing`] has their forces). `touches`: the pusher does at the start, as an
/// edge under an object that sank into its pads.
fn shared_weight(scene: &Scene<f64>, (push, touches): (Option<usize>, bool), feature: usize) -> f64 {
    let channel = feature / BINS;
    let with_pusher = scene.pusher.is_some() && matches!(channel, 7..=11 | 18..=23) && push != Some(channel);
    let shared = match Phase::of(feature % BINS) {
        Phase::Pause | Phase::After => with_pusher,
        Phase::Before => channel == 16 || touches && with_pusher,
        _ => false,
    };
    if scene.fingers.is_none() || !shared {
        return 0.0;
    }
    RIGID.shared_weight(scene, features::quantity(feature))
}

/// Floor of the turn of a body that nothing grasps and that lies on its face, in a run with these `features`.
fn turn(scene: &Scene<f64>, features: &Features, feature: usize) -> f64 {
    if !lies_free(scene)
        || features::quantity(feature) != Quantity::Rotation
        || !features[feature].is_finite()
    {
        return 0.0;
    }
    RIGID.of_turn * features[feature]
}

/// Relative step with which friction is varied.
const STEP: f64 = 0.02;

impl<'a> Problem<'a> {
    /// Around `model`.
    pub fn new(campaign: &'a Campaign, model: &Model<f64>) -> Self {
        let mut groups: Vec<usize> = (0..campaign.groups.len()).collect();
        let fine = campaign.simulate_all(model);
        let mut residuals: Vec<Features> = campaign
            .runs
            .iter()
            .zip(&fine)
            .map(|(r, f)| r.measured.iter().zip(f).map(|(y, f)| y - f).collect())
            .collect();
        let failed = failed(campaign, &mut residuals);
        let stands = stands(campaign, &residuals);
        let coarse = campaign.simulate_runs(model, &stands);
        let base = [Free::FingerFriction, Free::PusherFriction, Free::SupportFriction];
        let sensitivity: Vec<Vec<Features>> = base
            .iter()
            .map(|free| {
                let mut changed = model.clone();
                free.set(&mut changed, free.get(model) * (1.0 + STEP));
                let with = campaign.simulate_runs(&changed, &stands);
                with.iter().zip(&coarse).map(|(w, c)| difference(w, c, STEP)).collect()
            })
            .collect();
        let mut of_run = vec![0; campaign.runs.len()];
        for (g, group) in campaign.groups.iter().enumerate() {
            group.runs.iter().for_each(|r| of_run[*r] = g);
        }
        let friction: Vec<[Features; 3]> = of_run
            .iter()
            .map(|g| [sensitivity[0][*g].clone(), sensitivity[1][*g].clone(), sensitivity[2][*g].clone()])
            .collect();
        let scatter_m = placing::scatter_m(&campaign.runs);
        let stated = noise::estimate(campaign, &residuals, &friction);
        let unrepeated = stated.freedom == 0;
        // Of the run that stands for each group: directions, and what its signals change within a bin.
        let (at_start, ranges): (Vec<Vec<Features>>, Vec<Features>) = stands
            .par_iter()
            .zip(&coarse)
            .map(|(run, coarse)| {
                let run = &campaign.runs[*run];
                let mut directions = placing::directions(run, model, coarse, scatter_m);
                // Not `coarse`: one run may stand there for others.
                let simulated = run.prepared.simulate_every(model, run.stride);
                let here = run.bins.modelled(&simulated);
                directions.extend(carried::directions(run, model, &here, &campaign.description.sensors));
                directions.extend(alignment::directions(run, model));
                directions.extend(points::directions(run, model, &here));
                directions.extend(uneven::directions(run, model, &simulated, &here));
                directions.extend(edges::directions(run, &simulated, &here));
                directions.extend(sharing::directions(run));
                if unrepeated {
                    directions.extend(closing::directions(run));
                }
                (directions, run.bins.ranges(&simulated))
            })
            .unzip();
        let mut noise = stated.clone();
        if noise.freedom == 0 && campaign.sparse() && campaign.runs.len() >= unrepeated::FEWEST {
            let of_runs: Vec<Vec<Features>> = of_run.iter().map(|g| at_start[*g].clone()).collect();
            noise = unrepeated::estimate(&residuals, &friction, &of_runs, &noise.floor);
        }
        let mut whiteners = Vec::with_capacity(groups.len());
        let mut targets = Vec::with_capacity(groups.len());
        let mut single_run = Vec::with_capacity(groups.len());
        let mut floors = Vec::with_capacity(groups.len());
        let mut of_rig = Vec::with_capacity(groups.len());
        for (g, group) in campaign.groups.iter().enumerate() {
            let runs = group.runs.iter().filter(|r| noise::is_used(&residuals[**r])).count().max(1) as f64;
            let mean = noise::mean(group.runs.iter().map(|r| &residuals[*r]));
            let first = &campaign.runs[stands[g]];
            let push = (push_channel(&first.prepared), first.prepared.pusher_touches(2.0 * RIGID.position_m));
            let path = RIGID.of_path * first.prepared.drive_path();
            let floor2: Vec<f64> = (0..FEATURES)
                .map(|f| {
                    let place = if f < 3 * BINS { path } else { 0.0 };
                    let shared = shared_weight(&first.prepared.scene, push, f);
                    let turn = turn(&first.prepared.scene, &coarse[g], f);
                    noise.floor[f].powi(2)
                        + (noise::floor_of_range(f) * ranges[g][f]).powi(2)
                        + place * place
                        + turn * turn
                        + shared * shared
                })
                .collect();
            // What the model leaves holds the floor already.
            let floor_beside = |f: usize| {
                if noise.of_misfit.is_some() { 0.0 } else { common_floor::own_share(f) * floor2[f] }
            };
            let variance: Vec<f64> =
                (0..FEATURES).map(|f| noise.spread[f].powi(2) / runs + floor_beside(f)).collect();
            let mut common: Vec<Features> =
                noise.directions.iter().map(|d| d.iter().map(|x| x / runs.sqrt()).collect()).collect();
            for k in 0..3 {
                let sd = (noise.friction[k].powi(2) / runs + noise::CONDITION_FRICTION.powi(2)).sqrt();
                common.push(sensitivity[k][g].iter().map(|x| x * sd).collect());
            }
            let measured = noise::mean(group.runs.iter().map(|r| &campaign.runs[*r].measured));
            of_rig.push(constants::columns(&measured));
            let mut lags = loading::lags(first, &measured);
            lags.push(loading::late(first));
            let at_start = &at_start[g];
            let one: Features = (0..FEATURES)
                .map(|f| {
                    let mut v = floor2[f] + stated.spread[f].powi(2);
                    v += noise.directions.iter().chain(&lags).map(|d| d[f] * d[f]).sum::<f64>();
                    let placed = at_start.iter().map(|d| d[f]).filter(|x| x.is_finite());
                    v += placed.map(|x| x * x).sum::<f64>();
                    for k in 0..3 {
                        let x = sensitivity[k][g][f] * stated.friction[k];
                        v += if x.is_finite() { x * x } else { 0.0 };
                    }
                    v.sqrt()
                })
                .collect();
            common.extend(lags);
            common.extend(at_start.iter().cloned());
            if noise.of_misfit.is_none() {
                common.extend(common_floor::directions(&floor2));
            }
            let active: Vec<usize> = (0..FEATURES).filter(|f| mean[*f].is_finite()).collect();
            let weight = noise.of_misfit.as_ref().map_or(1.0, |of| of[stands[g]]);
            whiteners.push(Whitener::new(active, &variance, &common).weighed(weight));
            targets.push(mean.iter().zip(&coarse[g]).map(|(m, c)| m + c).collect());
            single_run.push(one);
            floors.push(floor2.iter().map(|x| x.sqrt()).collect());
        }
        groups.retain(|g| !whiteners[*g].active.is_empty());
        let of_offsets = constants::prior(campaign, model);
        let whitened = |(w, columns): (&Whitener, &Vec<Features>)| {
            Columns::new(w.apply_all(&columns.iter().map(Vec::as_slice).collect::<Vec<_>>()))
        };
        let offsets = whiteners.iter().zip(&of_rig).map(whitened).collect();
        Self {
            campaign,
            noise,
            targets,
            whiteners: Arc::new(whiteners),
            constants: Arc::new(of_rig),
            offsets,
            of_offsets,
            single_run,
            floors,
            residuals,
            groups,
            failed,
            stands,
        }
    }

    /// The run that stands for a group.
    pub fn run_of(&self, group: usize) -> &Run {
        &self.campaign.runs[self.stands[group]]
    }

    /// Trials that could not be prepared, those that the model does not describe, and those of which nothing is
    /// measured.
    pub fn left_out(&self) -> Vec<LeftOut> {
        let reason = |run: usize| match (self.failed.contains(&run), noise::is_used(&self.residuals[run])) {
            (true, _) => Some("the model does not describe it at all (grip lost, or dropped?)"),
            (_, false) => Some("nothing of it is measured"),
            _ => None,
        };
        let runs = self.campaign.runs.iter().enumerate();
        let runs = runs.filter_map(|(at, run)| {
            let trial = run.info.trial.clone();
            reason(at).map(|reason| LeftOut { trial, reason: reason.into() })
        });
        self.campaign.refused.iter().map(LeftOut::from).chain(runs).collect()
    }

    /// How many trials are not left out.
    pub fn trials(&self) -> usize {
        self.residuals.iter().filter(|residual| noise::is_used(residual)).count()
    }

    /// The same with the groups at `places` of those in use only.
    #[must_use]
    pub fn restricted(&self, places: &[usize]) -> Self {
        Self { groups: places.iter().map(|p| self.groups[*p]).collect(), ..self.clone() }
    }

    /// Standard deviation of the floor of a feature.
    pub fn floor(&self, group: usize, feature: usize) -> f64 {
        self.floors[group][feature]
    }

    /// Coarse predictions of all groups in use.
    pub fn predict(&self, model: &Model<f64>) -> Vec<Features> {
        self.predict_of(model, &self.groups)
    }

    /// Coarse predictions of some groups.
    pub fn predict_of(&self, model: &Model<f64>, groups: &[usize]) -> Vec<Features> {
        self.campaign.simulate_runs(model, &self.stand_for(groups))
    }

    /// Coarse predictions of all groups in use by each of `models`.
    pub fn predict_each(&self, models: &[Model<f64>]) -> Vec<Vec<Features>> {
        self.campaign.simulate_each(models, &self.stand_for(&self.groups))
    }

    fn stand_for(&self, groups: &[usize]) -> Vec<usize> {
        groups.iter().map(|g| self.stands[*g]).collect()
    }

    /// Residual features of all groups in use for coarse predictions.
    pub fn residual(&self, predicted: &[Features]) -> Vec<Features> {
        self.groups
            .iter()
            .zip(predicted)
            .map(|(g, p)| self.targets[*g].iter().zip(p).map(|(t, p)| t - p).collect())
            .collect()
    }

    /// Gram matrices for a residual and parameter columns (each a list over groups in use).
    pub fn grams(&self, residual: &[Features], columns: &[Vec<Features>]) -> Vec<Gram> {
        let of_group = |(i, g): (usize, &usize)| {
            let of_it = columns.iter().map(|c| &c[i][..]).chain(std::iter::once(&residual[i][..]));
            let seen = self.whiteners[*g].apply_all(&of_it.collect::<Vec<_>>());
            gls::gram(self.campaign.groups[*g].condition, &seen, &self.offsets[*g])
        };
        self.groups.par_iter().enumerate().map(of_group).collect()
    }

    /// The same of `known` columns and of `others` that may stand beside them.
    pub fn beside(
        &self,
        residual: &[Features],
        known: &[Vec<Features>],
        others: Vec<Vec<Features>>,
    ) -> Beside {
        let added = others.len();
        let all: Vec<Vec<Features>> = known.iter().cloned().chain(others).collect();
        Beside::new(self.grams(residual, &all), known.len(), added)
    }

    /// Where a fit may take a parameter: the bounds of its description, and of pads what is expected.
    pub fn bounds(&self, free: &Free) -> (f64, f64) {
        let (low, high) = free.bounds();
        match free.expected(self.campaign) {
            Some((_, [least, most])) => (low.max(least), high.min(most)),
            None => (low, high),
        }
    }

    /// Mean and precision of the prior of a parameter that has one: friction, about the value given, and the
    /// pads, about what is read off.
    pub fn prior(&self, free: &Free) -> Option<(f64, f64)> {
        let k = match free {
            Free::FingerFriction => 0,
            Free::PusherFriction => 1,
            Free::SupportFriction => 2,
            Free::Effect { .. } => {
                let (mean, [low, high]) = free.expected(self.campaign)?;
                return Some((mean, (1.0 / (SD_OF_RANGE * (high - low)).powi(2)).min(FIXED)));
            }
        };
        let given = self.campaign.given;
        let mean = [given.finger, given.pusher, given.support][k];
        let sd = (noise::FRICTION_PRIOR * mean).max(0.1);
        Some((mean, 1.0 / (sd * sd)))
    }

    /// Prior of the changes of the `free` coefficients, of `more` of which nothing is known, and of the offsets.
    pub fn priors(&self, free: &[Free], more: usize) -> Prior {
        let mut out = Prior::none(free.len() + more);
        for (p, f) in out.precision.iter_mut().zip(free) {
            *p = self.prior(f).map_or(0.0, |(_, p)| p);
        }
        out.precision.extend(&self.of_offsets.precision);
        out.bound.extend(&self.of_offsets.bound);
        out
    }

    /// Residual of all groups in use with what the rig's constants make up taken out.
    pub fn without_offsets(&self, residual: &[Features], offsets: &[f64]) -> Vec<Features> {
        residual.iter().enumerate().map(|(place, r)| self.without_offsets_at(place, r, offsets)).collect()
    }

    /// The same of the group at a place of those in use.
    pub fn without_offsets_at(&self, place: usize, residual: &Features, offsets: &[f64]) -> Features {
        let mut out = residual.clone();
        for (column, x) in self.constants[self.groups[place]].iter().zip(offsets) {
            subtract(&mut out, column, *x);
        }
        out
    }
}

/// Takes what `columns` make of the coefficients `x` off the features of the group at a place of those in use.
pub fn take_off(features: &mut Features, columns: &[Vec<Features>], place: usize, x: &[f64]) {
    for (column, x) in columns.iter().zip(x) {
        subtract(features, &column[place], *x);
    }
}

/// `features - x column`, where the column is known.
fn subtract(features: &mut Features, column: &Features, x: f64) {
    for (r, c) in features.iter_mut().zip(column).filter(|(_, c)| c.is_finite()) {
        *r -= c * x;
    }
}

/// `(with - without) / step`.
pub fn difference(with: &Features, without: &Features, step: f64) -> Features {
    with.iter().zip(without).map(|(a, b)| (a - b) / step).collect()
}
