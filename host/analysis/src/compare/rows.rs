//! Errors gathered over the trials: one row for each primitive, channel and phase.

use std::collections::{BTreeMap, BTreeSet};

use super::SIGNIFICANCE;
use super::document::{Change, ErrorRow, Fate, ModelReport, Place, Test, TrialRow};
use super::noise::{Floor, Source, floor, repeated};
use super::trial::TrialErrors;
use crate::channels::{COUNT, NAMES, Signals, quantity};
use crate::evidence::conditions;
use crate::evidence::phases::{PHASES, Phase};
use crate::evidence::statistics::{holm, lack_of_fit};
use stickslip_data::TrialInfo;

/// Primitive, channel number, phase.
pub type Key = (String, usize, Phase);

/// The compared trials and their conditions. Slices of errors go with `places`.
#[derive(Clone, Copy)]
pub struct Trials<'a> {
    /// trials.csv.
    pub infos: &'a [TrialInfo],
    /// Places of the compared trials in `infos`.
    pub places: &'a [usize],
    /// Condition of each of `infos`.
    pub condition_of: &'a [usize],
    /// Whether each of `places` enters the errors; the others only serve the noise floor.
    pub reported: &'a [bool],
    /// Stated sensor noise.
    pub noise: &'a Signals,
}

impl<'a> Trials<'a> {
    /// trials.csv's row of compared trial `k`.
    pub fn info(&self, k: usize) -> &'a TrialInfo {
        &self.infos[self.places[k]]
    }

    /// Primitive of compared trial `k`.
    pub fn primitive(&self, k: usize) -> &'a str {
        &self.info(k).primitive
    }

    fn primitives(&self) -> BTreeSet<&'a str> {
        (0..self.places.len()).map(|k| self.primitive(k)).collect()
    }

    /// Reported trials of `primitive`.
    pub fn of(&self, primitive: &str) -> Vec<usize> {
        (0..self.places.len()).filter(|k| self.reported[*k] && self.primitive(*k) == primitive).collect()
    }

    /// Groups of trials (out of `ks`) that repeat each other.
    pub fn repetitions(&self, ks: &[usize]) -> Vec<Vec<usize>> {
        let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for k in ks {
            groups.entry(self.condition_of[self.places[*k]]).or_default().push(*k);
        }
        groups.into_values().collect()
    }

    /// Noise floor of every primitive, channel and phase.
    pub fn floors(&self, models: &[Vec<TrialErrors>]) -> BTreeMap<Key, Floor> {
        let mut out = BTreeMap::new();
        for primitive in self.primitives() {
            let ks: Vec<usize> = (0..self.places.len()).filter(|k| self.primitive(*k) == primitive).collect();
            let groups = self.repetitions(&ks);
            for channel in 0..COUNT {
                for phase in PHASES {
                    let f = floor(&groups, models, channel, phase, self.noise[channel]);
                    out.insert((primitive.to_owned(), channel, phase), f);
                }
            }
        }
        out
    }

    /// Errors of one of `models` by primitive, channel and phase, failures first, then by size.
    /// All errors have their tares taken out.
    pub fn rows(
        &self,
        models: &[Vec<TrialErrors>],
        model: usize,
        tares: &[Signals],
        floors: &BTreeMap<Key, Floor>,
    ) -> Vec<ErrorRow> {
        let errors = &models[model];
        let mut rows = Vec::new();
        for primitive in self.primitives() {
            let ks = self.of(primitive);
            for channel in 0..COUNT {
                for phase in PHASES {
                    let floor = floors.get(&(primitive.to_owned(), channel, phase));
                    let known: Vec<usize> =
                        ks.iter().copied().filter(|k| errors[*k].raw(channel, phase).is_known()).collect();
                    if !known.is_empty() {
                        rows.push(self.row(models, model, tares, floor, primitive, channel, phase, &known));
                    }
                }
            }
        }
        let p: Vec<f64> = rows.iter().map(|r| r.lack_of_fit.map_or(f64::NAN, |t| t.p)).collect();
        for (row, corrected) in rows.iter_mut().zip(holm(&p)) {
            if let Some(test) = &mut row.lack_of_fit {
                test.p_corrected = corrected;
                // What a perfect model would show too is no failure, however sure its sign is.
                row.fails = corrected < SIGNIFICANCE && row.multiples.is_none_or(|m| m > 1.0);
            }
        }
        rows.sort_by(|a, b| {
            let size = |r: &ErrorRow| r.multiples.unwrap_or(0.0);
            b.fails.cmp(&a.fails).then(size(b).total_cmp(&size(a)))
        });
        rows
    }

    #[allow(clippy::too_many_arguments)]
    fn row(
        &self,
        models: &[Vec<TrialErrors>],
        model: usize,
        tares: &[Signals],
        floor: Option<&Floor>,
        primitive: &str,
        channel: usize,
        phase: Phase,
        known: &[usize],
    ) -> ErrorRow {
        let errors = &models[model];
        let mut samples = 0.0;
        let (mut square, mut sum, mut max) = (0.0, 0.0, 0.0f64);
        let (mut square_raw, mut sum_raw) = (0.0, 0.0);
        for k in known {
            let cell = errors[*k].raw(channel, phase);
            let raw = cell.shifted(-tares[*k][channel]);
            let n = f64::from(cell.samples);
            samples += n;
            square += n * cell.mean_square();
            sum += n * cell.bias();
            max = max.max(cell.largest());
            square_raw += n * raw.mean_square();
            sum_raw += n * raw.bias();
        }
        let conditions = self.repetitions(known);
        let bias = |k: &usize| errors[*k].raw(channel, phase).bias();
        let groups: Vec<Vec<f64>> = conditions.iter().map(|g| g.iter().map(bias).collect()).collect();
        let rms = (square / samples).sqrt();
        let noise_floor = floor.filter(|f| f.rms > 0.0).map(|f| f.rms);
        ErrorRow {
            place: Place { primitive: primitive.to_owned(), channel: NAMES[channel], phase },
            unit: quantity(channel).unit(),
            trials: known.len(),
            rms,
            bias: sum / samples,
            max,
            rms_with_offset: (square_raw / samples).sqrt(),
            bias_with_offset: sum_raw / samples,
            noise_floor,
            noise_source: floor.map_or(Source::Unknown, |f| f.source),
            multiples: noise_floor.map(|f| rms / f),
            // Tared before contact: what is left there is zero by construction.
            lack_of_fit: lack_of_fit(&groups, &repeated(&conditions, models, channel, phase))
                .filter(|_| !(phase == Phase::BeforeContact && tares.iter().any(|t| t[channel] != 0.0)))
                .map(|l| Test {
                    f: l.f,
                    df_fit: l.of_fit,
                    df_error: l.of_error,
                    p: l.p,
                    p_corrected: f64::NAN,
                    pure_error: l.pure_error,
                }),
            fails: false,
            index: channel,
        }
    }

    /// One row for each reported trial.
    pub fn trial_rows(&self, errors: &[TrialErrors], floors: &BTreeMap<Key, Floor>) -> Vec<TrialRow> {
        (0..self.places.len())
            .filter(|k| self.reported[*k])
            .map(|k| {
                let e = &errors[k];
                let mut worst: Option<(f64, Place)> = None;
                let (mut square, mut count) = (0.0, 0.0);
                for channel in 0..COUNT {
                    for phase in PHASES {
                        let cell = e.raw(channel, phase);
                        let floor = floors
                            .get(&(self.primitive(k).to_owned(), channel, phase))
                            .filter(|f| f.rms > 0.0);
                        let (true, Some(floor)) = (cell.is_known(), floor) else { continue };
                        let m = cell.mean_square().sqrt() / floor.rms;
                        square += m * m;
                        count += 1.0;
                        if worst.as_ref().is_none_or(|w| m > w.0) {
                            let primitive = self.primitive(k).to_owned();
                            worst = Some((m, Place { primitive, channel: NAMES[channel], phase }));
                        }
                    }
                }
                TrialRow {
                    trial: self.info(k).trial.clone(),
                    condition: self.condition_of[self.places[k]],
                    multiples: (count > 0.0).then(|| f64::sqrt(square / count)),
                    worst: worst.map(|w| w.1),
                    phases: PHASES
                        .into_iter()
                        .map(|p| {
                            let (from, to) = e.phase_s[p as usize];
                            (phase_key(p), [from, to])
                        })
                        .collect(),
                    contact_from: e.phases.contact,
                    motion_from: e.phases.motion,
                    unsolved_steps: e.unsolved,
                }
            })
            .collect()
    }
}

fn phase_key(phase: Phase) -> &'static str {
    match phase {
        Phase::BeforeContact => "before_contact",
        Phase::Sticking => "sticking",
        Phase::Onset => "onset",
        Phase::Sliding => "sliding",
        Phase::End => "end",
    }
}

/// First model against last: failures that are gone first, then by the first model's error.
pub fn changes(reports: &[ModelReport]) -> Vec<Change> {
    let (Some(first), Some(last)) = (reports.first(), reports.last()) else {
        return Vec::new();
    };
    let after: BTreeMap<&Place, &ErrorRow> = last.errors.iter().map(|r| (&r.place, r)).collect();
    let mut out: Vec<Change> = first
        .errors
        .iter()
        .filter_map(|before| {
            let after = after.get(&before.place)?;
            let fate = match (before.fails, after.fails) {
                (true, false) => Fate::Gone,
                // A tenth less is seen in a plot; below that it is the same failure.
                (true, true) if after.rms < 0.9 * before.rms => Fate::Smaller,
                (true, true) => Fate::Remains,
                (false, true) => Fate::New,
                (false, false) => Fate::Fits,
            };
            Some(Change {
                place: before.place.clone(),
                unit: before.unit,
                rms_before: before.rms,
                rms_after: after.rms,
                multiples_before: before.multiples,
                multiples_after: after.multiples,
                fate,
            })
        })
        .collect();
    out.sort_by(|a, b| {
        let size = |c: &Change| c.multiples_before.unwrap_or(0.0).max(c.multiples_after.unwrap_or(0.0));
        let order = |c: &Change| match c.fate {
            Fate::New => 0,
            Fate::Gone => 1,
            Fate::Remains | Fate::Smaller => 2,
            Fate::Fits => 3,
        };
        order(a).cmp(&order(b)).then(size(b).total_cmp(&size(a)))
    });
    out
}

/// Whether the data set holds more than one primitive, so that places must name it.
pub fn many_primitives(rows: &[ErrorRow]) -> bool {
    rows.iter().any(|r| r.place.primitive != rows[0].place.primitive)
}

/// The variables that take at least two values among `infos`.
pub fn varied<'a>(infos: impl Iterator<Item = &'a TrialInfo> + Clone) -> Vec<conditions::Variable> {
    conditions::VARIABLES
        .into_iter()
        .filter(|v| infos.clone().filter_map(|i| v.level(i)).collect::<BTreeSet<_>>().len() > 1)
        .collect()
}
