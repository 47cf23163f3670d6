//! A model to compare, and what it leaves open.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use stickslip_data::TrialInfo;
use stickslip_shared::model::{Base, Model};

use super::trial::Tolerance;
use crate::channels::{COUNT, Quantity, Signals, quantity};
use crate::evidence::force_bands::{Band, bands_of_forces, bands_towards};
use crate::evidence::phases::{Phase, Phases};
use crate::evidence::tolerance;
use crate::model::file::{ModelFile, ModelFileError};
use crate::run::simulate::{Prepared, Simulated};

/// Samples of a trial at which the intervals of undetermined forces are found.
const BANDS: usize = 12;
/// Samples at which their whole width is found: many times slower.
const WIDTHS: usize = 2;

/// So many samples spread evenly from contact to the end.
fn pushed(prepared: &Prepared, phases: Phases, count: usize) -> Vec<usize> {
    let n = prepared.t_s.len();
    let from = phases.range(Phase::BeforeContact).end.min(n);
    let count = count.min(n - from);
    (0..count).map(|k| from + (2 * k + 1) * (n - from) / (2 * count)).collect()
}

/// A model and where it comes from.
#[derive(Clone, Debug)]
pub struct NamedModel {
    /// Short name for tables.
    pub name: String,
    /// In words.
    pub origin: String,
    /// The model.
    pub model: Model<f64>,
    /// Instead of it, where each primitive has its own friction (other pushers).
    pub by_primitive: BTreeMap<String, Model<f64>>,
    /// Coefficients, named as in [`NamedModel::friction`], that the data it was calibrated on only bound.
    pub only_bounded: Vec<String>,
    /// Signals of another engine, by trial; the own model is not run then.
    pub recorded: Option<Arc<BTreeMap<String, Simulated>>>,
}

impl NamedModel {
    /// A model of the own engine.
    pub fn own(name: impl Into<String>, origin: impl Into<String>, model: Model<f64>) -> Self {
        let (name, origin) = (name.into(), origin.into());
        Self { name, origin, model, by_primitive: BTreeMap::new(), only_bounded: Vec::new(), recorded: None }
    }

    /// The model in a file, called by the file's name.
    ///
    /// # Errors
    /// Where the file cannot be read or is wrong.
    pub fn read(path: &Path) -> Result<Self, ModelFileError> {
        let model = ModelFile::read(path)?.to_model();
        let name = path.file_stem().map_or_else(|| "model".into(), |s| s.to_string_lossy().into_owned());
        Ok(Self::own(name, path.display().to_string(), model))
    }

    /// The model for trials of `primitive`.
    pub fn of(&self, primitive: &str) -> &Model<f64> {
        self.by_primitive.get(primitive).unwrap_or(&self.model)
    }

    /// Coefficients by contact; with the primitive's name before where they differ. `has`: which of them the
    /// trials of each primitive have ([`Prepared::frictions`]).
    pub fn friction(&self, has: &BTreeMap<String, [bool; 3]>) -> BTreeMap<String, f64> {
        let of = |prefix: &str, model: &Model<f64>, has: [bool; 3]| {
            let f = model.friction;
            let all =
                [("finger", f.finger), ("pusher", f.pusher), ("support", f.support)].into_iter().zip(has);
            let there = all.filter(|(_, has)| *has);
            there.map(|((name, value), _)| (format!("{prefix}{name}"), value)).collect::<Vec<_>>()
        };
        let any = has.values().fold([false; 3], |any, has| std::array::from_fn(|k| any[k] || has[k]));
        let own = |primitive: &str| has.get(primitive).copied().unwrap_or_default();
        match self.by_primitive.is_empty() {
            true => of("", &self.model, any).into_iter().collect(),
            false => self.by_primitive.iter().flat_map(|(p, m)| of(&format!("{p}."), m, own(p))).collect(),
        }
    }

    /// Whether rigid contact leaves forces of it open.
    pub fn is_rigid(&self) -> bool {
        self.recorded.is_none() && matches!(self.model.base, Base::Hard)
    }

    /// How far each channel may be from the model's value without being an error, at some samples
    /// after contact: all force distributions with the same motion, all paths that cannot be
    /// distinguished from the measured one, and the tolerance of any rigid model. Found as far as
    /// the values `wanted` ask for (within three standard deviations of `noise` nothing is asked).
    /// Empty for a model that leaves nothing open.
    pub fn tolerance(
        &self,
        primitive: &str,
        prepared: &Prepared,
        (simulated, phases): (&Simulated, Phases),
        wanted: &dyn Fn(usize) -> Signals,
        noise: &Signals,
    ) -> Tolerance {
        if !self.is_rigid() {
            return Vec::new();
        }
        let at = pushed(prepared, phases, BANDS);
        let model = self.of(primitive);
        let mut bands = bands_towards(prepared, model, &at, wanted, &noise.map(|s| 3.0 * s));
        for path in prepared.drifted() {
            let moved = path.simulate(model).signals;
            for (sample, band) in &mut bands {
                for (channel, (low, high)) in band.iter_mut().enumerate().skip(6) {
                    let value = moved.get(*sample).map_or(f64::NAN, |row| row[channel]);
                    // `min` and `max` pass over a NaN.
                    (*low, *high) = (low.min(value), high.max(value));
                }
            }
        }
        let rigid = tolerance::of_trial(prepared);
        let slack = |(sample, band): (usize, Band)| {
            let value = simulated.signals.get(sample).copied().unwrap_or([f64::NAN; COUNT]);
            let rest = phases.range(Phase::End).contains(&sample);
            let of = |channel: usize| {
                let by = rigid.of(channel, rest);
                let (low, high) = band[channel];
                if value[channel].is_nan() {
                    return (f64::NAN, f64::NAN);
                }
                // An interval that is narrower than that, or not known, is widened to it.
                ((value[channel] - low).max(by), (high - value[channel]).max(by))
            };
            (sample, std::array::from_fn(of))
        };
        bands.into_iter().map(slack).collect()
    }

    /// What the model leaves open of the forces while the object is pushed, N: sum and number of
    /// the widths of its intervals over all force distributions with the same motion.
    pub fn open_force_n(&self, primitive: &str, prepared: &Prepared, phases: Phases) -> (f64, f64) {
        if !self.is_rigid() {
            return (0.0, 0.0);
        }
        let bands = bands_of_forces(prepared, self.of(primitive), &pushed(prepared, phases, WIDTHS));
        let forces = (0..COUNT).filter(|c| quantity(*c) == Quantity::Force);
        bands
            .iter()
            .flat_map(|(_, band)| forces.clone().map(|c| band[c].1 - band[c].0))
            .filter(|w| w.is_finite())
            .fold((0.0, 0.0), |(sum, n), w| (sum + w, n + 1.0))
    }

    /// Its signals along a trial.
    ///
    /// # Errors
    /// Where it is a recorded one and lacks this trial.
    pub fn simulate(&self, info: &TrialInfo, prepared: &Prepared) -> Result<Simulated, String> {
        match &self.recorded {
            None => Ok(prepared.simulate(self.of(&info.primitive))),
            Some(all) => {
                all.get(&info.trial).cloned().ok_or_else(|| format!("{} was not run on it", self.name))
            }
        }
    }
}
