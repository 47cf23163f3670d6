//! Calibration as the paper did it: sensor offsets from the rest before each motion (tare),
//! friction by least squares over the model from a small share of the trials, the rest of
//! them as validation.
//!
//! What the data cannot determine is said instead of numbered: a coefficient whose contact
//! never slides has only a lower bound, and force data hold friction and grip only as a
//! product.

mod determined;
mod friction;
mod intervals;
mod problem;
mod share;
mod tare;
mod windows;

use std::borrow::Borrow;
use std::collections::BTreeMap;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use stickslip_shared::effects::{Expected, REGISTRY, contact_compliance};
use stickslip_shared::model::{Base, MAX_EFFECTS, Model};
use thiserror::Error;

use crate::channels::{COUNT, Quantity, Signals, quantity};
use crate::evidence::conditions::condition_of;
use crate::evidence::offsets;
use crate::evidence::pads::{self, Pads, SD_OF_RANGE, Slope};
use crate::evidence::pose_clock::Delay;
use crate::left_out::LeftOut;
use crate::model::file::{EffectEntry, ModelFile};
use crate::progress::Progress;
use crate::run::scene::SceneError;
use crate::run::simulate::prepare;
use stickslip_data::{Dataset, Description, Trial, TrialInfo};

pub use determined::{Remark, Slid, name};
use problem::{Assumed, Found, Nuisance, Unknown};
pub use problem::{Coefficient, Estimate};
pub use share::{FEWEST_TRIALS, MOST_TRIALS, Share, pick};
pub use windows::Windowed;

/// Least share of an expected compliance: a plate that does not deform at all bears with its corners, another contact.
const LEAST_SHARE: f64 = 0.02;

/// Tangential stiffness of one whole pad.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct PadStiffness {
    /// N/m: in the model, found beside friction; else read off, and null where chance, and clocks that are a sample apart,
    /// would show as much compliance of rigid pads.
    pub tangential_n_m: Option<f64>,
    /// Lower end of its interval, N/m: of 95 % where it is in the model; else twice the compliance that was read off, two
    /// standard deviations, and a sample between the clocks.
    pub low_n_m: f64,
    /// Upper end, N/m; read off, half the compliance; null where the pads may be rigid.
    pub high_n_m: Option<f64>,
    /// Grip at which it is, N.
    pub grip_n: f64,
    /// What was read off the loadings, N/m; null where that shows no more than of rigid pads.
    pub read_off_n_m: Option<f64>,
    /// How far the largest load moves the object in the grasp before it slides, m.
    pub moves_m: f64,
    /// Whether the model has it: pads that move the object by more than the tolerance of rigid contact.
    pub in_model: bool,
    /// Loadings that it was found from.
    pub loadings: usize,
}

impl PadStiffness {
    fn read_off(pads: &Pads) -> Self {
        let (c, sd) = (pads.tangential_m_n, pads.sd_m_n);
        let stiffness = |c: f64| (c > 0.0).then(|| 1.0 / c);
        let told = pads.give_way();
        let read_off_n_m = stiffness(c).filter(|_| told);
        Self {
            tangential_n_m: read_off_n_m,
            low_n_m: 1.0 / (pads::SPRINGS * c + 2.0 * sd + pads.clock_m_n).max(1e-9),
            high_n_m: stiffness(c / pads::SPRINGS - 2.0 * sd).filter(|_| told),
            grip_n: pads.grip_n,
            read_off_n_m,
            moves_m: pads.moves_m().max(0.0),
            in_model: false,
            loadings: pads.loadings,
        }
    }

    /// The same of the pads that `calibration` found; as read off where it found none.
    fn found(self, calibration: &Calibration) -> Self {
        let model = &calibration.model;
        let read_off = |f: &&Found| f.nuisance.of.expected == Some(Expected::ReadOff);
        let Some(Found { nuisance, interval }) = calibration.found.iter().find(read_off) else { return self };
        let Some(effect) = model.effects.get(nuisance.slot) else { return self };
        let base_m_n = match model.base {
            Base::Hard => 0.0,
            Base::Soft { tangential_n_m, .. } => 1.0 / tangential_n_m,
        };
        let stiffness = |value: f64| {
            let mut parameters = effect.parameters;
            parameters[nuisance.parameter] = value;
            1.0 / (base_m_n + contact_compliance::tangential_m_n(&parameters, self.grip_n))
                .max(f64::MIN_POSITIVE)
        };
        Self {
            tangential_n_m: Some(stiffness(effect.parameters[nuisance.parameter])),
            low_n_m: stiffness(interval[1]),
            high_n_m: Some(stiffness(interval[0])),
            ..self
        }
    }
}

/// Root mean square error of one quantity over windows of the motion.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct QuantityError {
    /// Which.
    pub quantity: Quantity,
    /// SI unit.
    pub unit: &'static str,
    /// Of the base model on the held-out trials; none where no trial is held out.
    pub before: Option<f64>,
    /// Of the calibrated model on the calibration trials; none where they do not measure it.
    pub calibration: Option<f64>,
    /// Of the calibrated model on the held-out trials; none where there are none.
    pub held_out: Option<f64>,
    /// Root mean square of the measured signal itself on the held-out trials; none where there are none.
    pub signal: Option<f64>,
}

/// What is calibrated from.
#[derive(Clone, Debug)]
pub struct Options {
    /// Trials that friction is found from; the rest validate.
    pub share: Share,
    /// Only trials of this primitive.
    pub primitive: Option<String>,
    /// Whether pads are read off, and enter the model where they give way and it has none.
    pub pads: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { share: Share::of(0.1), primitive: None, pads: true }
    }
}

/// Why nothing can be calibrated.
#[derive(Debug, Error)]
pub enum CalibrateError {
    /// Nothing is listed.
    #[error("the data set has no trials")]
    Empty,
    /// No trial of the wanted primitive.
    #[error("no trial of primitive {0}")]
    NoSuchPrimitive(String),
    /// The first trial's reason.
    #[error("primitive {0}: no trial can be simulated: {1}")]
    Scene(String, SceneError),
    /// Nothing to learn from.
    #[error("primitive {0}: no trial has any prescribed motion to learn from")]
    NothingMoves(String),
}

/// Result of a calibration.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Calibration {
    /// Primitive whose trials were used.
    pub primitive: String,
    /// Trials that friction was found from.
    pub calibration_trials: Vec<String>,
    /// Trials that validate it.
    pub held_out_trials: usize,
    /// Trials that are in neither, and why.
    pub left_out: Vec<LeftOut>,
    /// What the sensors show at rest beyond the model: channels in the order of `compare`'s, N, N m, m, rad;
    /// zero where no rest was recorded.
    pub offsets: [f64; COUNT],
    /// Coefficients with their intervals or bounds.
    pub estimates: Vec<Estimate>,
    /// Stiffness of the fingers' pads before they slide, estimated from the loading of all trials of the primitive;
    /// null where it cannot be estimated or was not asked for.
    pub pads: Option<PadStiffness>,
    /// Errors by quantity.
    pub errors: Vec<QuantityError>,
    /// What to know about the numbers.
    pub remarks: Vec<Remark>,
    /// The calibrated model.
    #[serde(skip)]
    pub model: Model<f64>,
    /// What was found beside friction.
    #[serde(skip)]
    found: Vec<Found>,
}

/// Calibrations of a data set.
#[derive(Clone, Debug, JsonSchema, Serialize)]
#[serde(transparent)]
pub struct Report {
    /// One for each primitive, in the order of their names.
    pub primitives: Vec<Calibration>,
    /// The model with the best determined friction of all.
    #[serde(skip)]
    pub model: ModelFile,
}

/// Calibrates the friction of `model` on each primitive of `data`; a step of `progress` is one.
///
/// # Errors
/// Where there is no trial, or none of a primitive can be simulated; the first reason is given.
pub fn calibrate(
    data: &Dataset,
    model: &ModelFile,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Report, CalibrateError> {
    let mut all: BTreeMap<&str, Vec<(usize, &Trial)>> = BTreeMap::new();
    for (at, trial) in data.trials.iter().enumerate() {
        all.entry(&trial.info.primitive).or_default().push((at, trial));
    }
    let wanted = |p: &&str| options.primitive.as_ref().is_none_or(|wanted| wanted == p);
    let primitives: BTreeMap<&str, Vec<(usize, &Trial)>> =
        all.iter().filter(|(p, _)| wanted(p)).map(|(p, trials)| (*p, trials.clone())).collect();
    if primitives.is_empty() {
        return Err(options.primitive.clone().map_or(CalibrateError::Empty, CalibrateError::NoSuchPrimitive));
    }
    progress.begin("calibrating", primitives.len());
    let slopes: BTreeMap<&str, Vec<Slope>> = match options.pads {
        true => primitives.iter().map(|(p, trials)| (*p, slopes(&data.description, trials))).collect(),
        false => BTreeMap::new(),
    };
    let read_off = pads::measured(&slopes.values().flatten().copied().collect::<Vec<_>>());
    let (model, nuisances, assumed) =
        read_off.map_or_else(|| (model.clone(), Vec::new(), Vec::new()), |pads| with_pads(model, &pads));
    let (model, in_model) = (&model, gives_way(&model));
    let base = model.to_model();
    let unknown = Unknown { nuisances: &nuisances, assumed: &assumed };
    let mut found = Vec::new();
    for (primitive, trials) in &primitives {
        let others = || {
            let of_each = all.iter().filter(|(p, _)| *p != primitive);
            let of_each = of_each.map(|(_, trials)| tare::of_others(&data.description, trials, &base));
            offsets::over_trials(&of_each.collect::<Vec<_>>())
        };
        let share = (options.share, others);
        let mut of_it = of_primitive_where(&data.description, primitive, trials, (&base, unknown), share)?;
        let pads = slopes.get(*primitive).and_then(|s| pads::measured(s));
        of_it.pads = pads.map(|p| PadStiffness { in_model, ..PadStiffness::read_off(&p).found(&of_it) });
        found.push(of_it);
        progress.step(1);
    }
    let best = best_of(&found);
    // With the pads that were found beside the best, of the first where none is determined.
    let of_best =
        |c: &&Calibration| best.first().is_some_and(|b| c.estimates.iter().any(|e| std::ptr::eq(e, *b)));
    let (mut with_best, beside) = match found.iter().find(of_best).or(found.first()) {
        Some(c) => (c.model.clone(), &c.found[..]),
        None => (base.clone(), &[][..]),
    };
    if best.is_empty() {
        with_best.friction = base.friction;
    }
    for e in &best {
        *e.coefficient.of(&mut with_best) = e.value;
    }
    let model = with_found(model, &with_best, &best, beside);
    Ok(Report { primitives: found, model })
}

/// The loadings of the pads in `trials`.
fn slopes(description: &Description, trials: &[(usize, &Trial)]) -> Vec<Slope> {
    let ready = trials.par_iter().filter_map(|(at, trial)| prepare(description, trial, *at).ok());
    let of: Vec<&Trial> = trials.iter().map(|(_, trial)| *trial).collect();
    let late_s = Delay::found_s(Delay::measured(&of));
    ready.flat_map_iter(|prepared| pads::loadings(&prepared.seen_earlier(late_s))).collect()
}

/// Whether `model` has pads that give way beside those of its base.
fn gives_way(model: &ModelFile) -> bool {
    model.effects.iter().any(EffectEntry::is_compliance)
}

/// `model` with `pads` that give way by more than the tolerance of rigid contact, where it has none: it loads
/// before it slides. The second are their parameters, to be found beside friction; the third is what is assumed of contacts that
/// stay rigid: that they give way by less than those of hard bodies usually do.
fn with_pads(model: &ModelFile, pads: &Pads) -> (ModelFile, Vec<Nuisance>, Vec<Assumed>) {
    let without = || (model.clone(), Vec::new(), Vec::new());
    let slot = model.effects.len();
    let compliance = REGISTRY.iter().find(|i| i.role.is_compliance());
    let (Some(info), true) = (compliance, slot < MAX_EFFECTS && !gives_way(model)) else { return without() };
    let beyond = Some(*pads).filter(Pads::matter).and_then(|p| p.beyond(model.base));
    let pads = beyond.unwrap_or_else(|| pads.ordinary());
    let mut entry = EffectEntry::typical(info);
    let mut nuisances = Vec::new();
    for (parameter, (value, of)) in entry.values.iter_mut().zip(info.parameters).enumerate() {
        let Some((expected, [low, high])) = pads.expected(of) else { continue };
        let bounds = [low.max(of.low), high.min(of.high)];
        *value = expected;
        let sd = SD_OF_RANGE * (bounds[1] - bounds[0]);
        let logarithm = of.unit == "m/N";
        let (sd, bounds) = match logarithm {
            true => ((sd / expected).ln_1p(), [bounds[0].max(LEAST_SHARE * expected), bounds[1]]),
            false => (sd, bounds),
        };
        nuisances.push(Nuisance { slot, parameter, of, expected, sd, logarithm, bounds });
    }
    let mut with = model.clone();
    with.effects.push(entry);
    if beyond.is_some() {
        return (with, nuisances, Vec::new());
    }
    let effect = with.to_model().effects.get(slot).copied();
    let hard = matches!(model.base, Base::Hard);
    let assumed = effect.filter(|_| hard).map(|effect| Assumed { slot, effect });
    (model.clone(), Vec::new(), assumed.into_iter().collect())
}

/// The narrowest estimate of each coefficient that any of them determines.
fn best_of(found: &[Calibration]) -> Vec<&Estimate> {
    let width = |e: &Estimate| match (e.low, e.high) {
        (Some(low), Some(high)) => high - low,
        _ => f64::INFINITY,
    };
    let best = |coefficient| {
        let all = found.iter().flat_map(|c| &c.estimates);
        let of_it = all.filter(|e| e.coefficient == coefficient && e.determined);
        of_it.min_by(|a, b| width(a).total_cmp(&width(b)))
    };
    [Coefficient::Finger, Coefficient::Pusher, Coefficient::Support].into_iter().filter_map(best).collect()
}

impl Report {
    /// The narrowest estimate of each coefficient that any primitive determines.
    pub fn best(&self) -> Vec<&Estimate> {
        best_of(&self.primitives)
    }

    /// The model that `primitive` was calibrated with, the pads that entered it included, with its friction and intervals.
    pub fn model_of(&self, primitive: &Calibration) -> ModelFile {
        let estimates: Vec<&Estimate> = primitive.estimates.iter().collect();
        with_found(&self.model, &primitive.model, &estimates, &primitive.found)
    }
}

/// `file` with the values of `model` and the intervals of `estimates` and of what was `found` beside them.
fn with_found(file: &ModelFile, model: &Model<f64>, estimates: &[&Estimate], found: &[Found]) -> ModelFile {
    let mut file = file.clone();
    file.friction_intervals.clear();
    for e in estimates {
        if let (Some(low), Some(high)) = (e.low, e.high) {
            file.friction_intervals.insert(name(e.coefficient).into(), [low, high]);
        }
    }
    for Found { nuisance, interval } in found {
        if let Some(entry) = file.effects.get_mut(nuisance.slot) {
            entry.intervals.insert(nuisance.of.name.into(), *interval);
        }
    }
    file.set_values(model);
    file
}

/// Calibrates `base` on the `share` of `trials` (all of one primitive; with their places in
/// the data set) and validates on the rest.
///
/// # Errors
/// Where no trial can be simulated; the first reason is given.
pub fn of_primitive<T: Borrow<Trial> + Sync>(
    description: &Description,
    primitive: &str,
    trials: &[(usize, T)],
    base: &Model<f64>,
    share: Share,
) -> Result<Calibration, CalibrateError> {
    let nothing = || [f64::NAN; COUNT];
    of_primitive_where(description, primitive, trials, (base, Unknown::NOTHING), (share, nothing))
}

/// The same where some of `base` is `unknown`; `elsewhere`: constant errors of the sensors in the trials of other primitives.
fn of_primitive_where<T: Borrow<Trial> + Sync>(
    description: &Description,
    primitive: &str,
    trials: &[(usize, T)],
    (base, unknown): (&Model<f64>, Unknown<'_>),
    (share, elsewhere): (Share, impl Fn() -> Signals),
) -> Result<Calibration, CalibrateError> {
    let infos: Vec<&TrialInfo> = trials.iter().map(|(_, trial)| &trial.borrow().info).collect();
    let ready: Vec<Result<Windowed, SceneError>> = trials
        .par_iter()
        .zip(condition_of(&infos))
        .map(|((at, trial), condition)| Windowed::new(description, trial.borrow(), *at, condition))
        .collect();
    let (mut remarks, mut left_out) = (Vec::new(), Vec::new());
    let mut good = Vec::new();
    let mut first_error = None;
    for (windowed, (_, trial)) in ready.into_iter().zip(trials) {
        match windowed {
            Ok(windowed) if windowed.measured.is_empty() => {
                let trial = trial.borrow().info.trial.clone();
                left_out.push(LeftOut { trial, reason: "nothing moves in it".into() });
            }
            Ok(windowed) => good.push(windowed),
            Err(error) => {
                left_out.push(LeftOut::from(&error));
                first_error.get_or_insert(error);
            }
        }
    }
    if good.is_empty() {
        return Err(match first_error {
            Some(error) => CalibrateError::Scene(primitive.to_owned(), error),
            None => CalibrateError::NothingMoves(primitive.to_owned()),
        });
    }
    let conditions: Vec<usize> = good.iter().map(|w| w.condition).collect();
    let chosen = pick(&conditions, share);
    let calibrating: Vec<&Windowed> = chosen.iter().map(|i| &good[*i]).collect();
    let (offsets, rested) = tare::tare(&calibrating, base, &description.sensors, elsewhere);
    if !rested {
        remarks.push(Remark::NoRest);
    }
    good.iter_mut().for_each(|w| w.tare_carried(&offsets));
    let (mut calibration, mut held_out) = (Vec::new(), Vec::new());
    for (i, w) in good.iter().enumerate() {
        if chosen.contains(&i) { calibration.push(w) } else { held_out.push(w) }
    }
    let mut fit = friction::fit(&calibration, &offsets, (base, unknown));
    determined::keep_base(&mut fit, base);
    friction::last(&calibration, &offsets, (&mut fit, unknown), determined::open);
    remarks.extend(fit.missed.iter().map(|i| Remark::Missed(calibration[*i].trial.clone())));
    determined::withdraw(&calibration, &mut fit, base);
    remarks.extend(determined::remarks(&calibration, &held_out, &fit));
    let before = squares(&held_out, &offsets, base);
    let inside = squares(&calibration, &offsets, &fit.model);
    let after = squares(&held_out, &offsets, &fit.model);
    let errors = [Quantity::Position, Quantity::Rotation, Quantity::Force, Quantity::Torque]
        .into_iter()
        .filter(|q| after.count(*q) + inside.count(*q) > 0.0)
        .map(|q| QuantityError {
            quantity: q,
            unit: q.unit(),
            before: before.error(q),
            calibration: inside.error(q),
            held_out: after.error(q),
            signal: after.signal(q),
        })
        .collect();
    let found = unknown.nuisances.iter().zip(fit.nuisances);
    let found = found.map(|(nuisance, interval)| Found { nuisance: *nuisance, interval });
    Ok(Calibration {
        primitive: primitive.into(),
        calibration_trials: calibration.iter().map(|w| w.trial.clone()).collect(),
        held_out_trials: held_out.len(),
        left_out,
        offsets,
        estimates: fit.estimates,
        pads: None,
        errors,
        remarks,
        model: fit.model,
        found: found.collect(),
    })
}

/// Sums of squares by quantity: error, signal, count.
struct Squares([[f64; 3]; 4]);

impl Squares {
    fn error(&self, q: Quantity) -> Option<f64> {
        self.mean(q, 0)
    }
    fn signal(&self, q: Quantity) -> Option<f64> {
        self.mean(q, 1)
    }
    fn mean(&self, q: Quantity, k: usize) -> Option<f64> {
        (self.count(q) > 0.0).then(|| (self.0[q as usize][k] / self.count(q)).sqrt())
    }
    fn count(&self, q: Quantity) -> f64 {
        self.0[q as usize][2]
    }
}

fn squares(trials: &[&Windowed], offsets: &[f64; COUNT], model: &Model<f64>) -> Squares {
    let each: Vec<[[f64; 3]; 4]> = trials
        .par_iter()
        .map(|w| {
            let mut sums = [[0.0; 3]; 4];
            for (modelled, measured) in w.model(model).iter().zip(&w.measured) {
                for c in 0..COUNT {
                    let seen = measured[c] - offsets[c];
                    let error = modelled[c] - seen;
                    if error.is_finite() {
                        let sum = &mut sums[quantity(c) as usize];
                        sum[0] += error * error;
                        sum[1] += seen * seen;
                        sum[2] += 1.0;
                    }
                }
            }
            sums
        })
        .collect();
    let mut total = [[0.0; 3]; 4];
    for (t, x) in each.iter().flat_map(|e| e.iter().flatten().copied().enumerate()) {
        total[t / 3][t % 3] += x;
    }
    Squares(total)
}
