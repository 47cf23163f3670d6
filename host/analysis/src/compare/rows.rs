//! Errors gathered over the trials: one row for each primitive, channel and phase.

use std::collections::{BTreeMap, BTreeSet};

use super::document::{Change, ErrorRow, Fate, Place, Size, Tally, Test, TrialRow};
use super::inputs::SIGNIFICANCE;
use super::noise::{Floor, Source, floor, repeated};
use super::tare::{Tare, stated_bound};
use super::trial::{Cell, TrialErrors};
use crate::channels::{COUNT, NAMES, Quantity, Signals, quantity};
use crate::evidence::conditions;
use crate::evidence::phases::{PHASES, Phase};
use crate::evidence::statistics::{holm, lack_of_fit};
use stickslip_data::{Sensors, TrialInfo};

/// Primitive, channel number, phase.
pub type Key = (String, usize, Phase);

/// Shorter phases say nothing about a sustained error, s.
pub const SUSTAINED_S: f64 = 0.1;
/// A tenth more or less is seen in a plot; within that it is the same failure.
const SAME: f64 = 0.1;

/// What is tested for lack of fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// What is beyond the tolerance.
    Error,
    /// All of it.
    Residual,
}

impl Part {
    fn cell(self, errors: &TrialErrors, channel: usize, phase: Phase) -> &Cell {
        match self {
            Part::Error => errors.error(channel, phase),
            Part::Residual => errors.residual(channel, phase),
        }
    }

    /// Of a row.
    pub fn of(self, row: &ErrorRow) -> Size {
        match self {
            Part::Error => row.error,
            Part::Residual => row.residual,
        }
    }
}

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
    /// Stated sensor uncertainty.
    pub sensors: &'a Sensors,
    /// Whether forces are tared.
    pub tare: Tare,
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
    pub fn floors(&self, errors: &[TrialErrors]) -> BTreeMap<Key, Floor> {
        let mut out = BTreeMap::new();
        for primitive in self.primitives() {
            let ks: Vec<usize> = (0..self.places.len()).filter(|k| self.primitive(*k) == primitive).collect();
            let groups = self.repetitions(&ks);
            for channel in 0..COUNT {
                for phase in PHASES {
                    let f = floor(&groups, errors, (channel, phase), self.tare, self.noise[channel]);
                    out.insert((primitive.to_owned(), channel, phase), f);
                }
            }
        }
        out
    }

    /// Residuals and errors by primitive, channel and phase, failures first, then by size of the
    /// error. All `errors` have their tares taken out; `part` is tested for lack of fit.
    pub fn rows(
        &self,
        errors: &[TrialErrors],
        tares: &[Signals],
        floors: &BTreeMap<Key, Floor>,
        part: Part,
    ) -> Vec<ErrorRow> {
        let mut rows = Vec::new();
        for primitive in self.primitives() {
            let ks = self.of(primitive);
            for channel in 0..COUNT {
                for phase in PHASES {
                    let key = (primitive.to_owned(), channel, phase);
                    let known: Vec<usize> =
                        ks.iter().copied().filter(|k| errors[*k].error(channel, phase).is_known()).collect();
                    if !known.is_empty() {
                        rows.push(self.row(errors, tares, (floors.get(&key), key), &known, part));
                    }
                }
            }
        }
        let p: Vec<f64> = rows.iter().map(|r| r.lack_of_fit.map_or(f64::NAN, |t| t.p)).collect();
        for (row, corrected) in rows.iter_mut().zip(holm(&p)) {
            if let Some(test) = &mut row.lack_of_fit {
                test.p_corrected = corrected;
                // What a perfect model would show too is no failure, however sure its sign is.
                row.fails = corrected < SIGNIFICANCE && part.of(row).multiples.is_none_or(|m| m > 1.0);
            }
        }
        rows.sort_by(|a, b| {
            let size = |r: &ErrorRow| part.of(r).multiples.unwrap_or(0.0);
            b.fails.cmp(&a.fails).then(size(b).total_cmp(&size(a)))
        });
        rows
    }

    fn row(
        &self,
        errors: &[TrialErrors],
        tares: &[Signals],
        (floor, (primitive, channel, phase)): (Option<&Floor>, Key),
        known: &[usize],
        part: Part,
    ) -> ErrorRow {
        let noise_floor = floor.filter(|f| f.rms > 0.0).map(|f| f.rms);
        let size = |cell: &dyn Fn(usize) -> Cell| {
            let (mut samples, mut square, mut sum, mut largest) = (0.0, 0.0, 0.0, 0.0f64);
            for k in known {
                let cell = cell(*k);
                let n = f64::from(cell.samples);
                samples += n;
                square += n * cell.mean_square();
                sum += n * cell.bias();
                largest = largest.max(cell.largest());
            }
            let rms = f64::sqrt(square / samples);
            Size { rms, mean: sum / samples, largest, multiples: noise_floor.map(|f| rms / f) }
        };
        let residual = size(&|k| *errors[k].residual(channel, phase));
        let error = size(&|k| *errors[k].error(channel, phase));
        let raw = size(&|k| errors[k].residual(channel, phase).shifted(-tares[k][channel]));
        let conditions = self.repetitions(known);
        let bias = |k: &usize| part.cell(&errors[*k], channel, phase).bias();
        let groups: Vec<Vec<f64>> = conditions.iter().map(|g| g.iter().map(bias).collect()).collect();
        ErrorRow {
            place: Place { primitive, channel: NAMES[channel], phase },
            unit: quantity(channel).unit(),
            trials: known.len(),
            duration_s: Self::duration_s(errors, phase, known),
            sustained: self.sustained(errors, (channel, phase), known, &error),
            residual,
            error,
            rms_with_offset: raw.rms,
            bias_with_offset: raw.mean,
            noise_floor,
            noise_source: floor.map_or(Source::Unknown, |f| f.source),
            // Tared before contact: what is left there is zero by construction.
            lack_of_fit: lack_of_fit(&groups, &repeated(&conditions, errors, (channel, phase), self.tare))
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

    /// Mean length of the phase.
    fn duration_s(errors: &[TrialErrors], phase: Phase, known: &[usize]) -> f64 {
        let length = |k: &usize| {
            let (from, to) = errors[*k].phase_s[phase as usize];
            to - from
        };
        known.iter().map(length).sum::<f64>() / known.len() as f64
    }

    /// Whether the mean error stays beyond what the sensor may be off by; see
    /// [`ErrorRow::sustained`]. Poses have no stated uncertainty: three standard deviations of
    /// their noise.
    fn sustained(
        &self,
        errors: &[TrialErrors],
        (channel, phase): (usize, Phase),
        known: &[usize],
        error: &Size,
    ) -> Option<bool> {
        let bound = match quantity(channel) {
            Quantity::Position | Quantity::Rotation => 3.0 * self.noise[channel],
            Quantity::Force | Quantity::Torque => stated_bound(self.sensors, channel),
        };
        (Self::duration_s(errors, phase, known) >= SUSTAINED_S && bound > 0.0)
            .then_some(error.mean.abs() > bound)
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
                        let cell = e.error(channel, phase);
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

/// Rows of the first model against those of the last: failures that are gone first, then by the
/// larger error. `part` says by what they fail.
pub fn changes(first: &[ErrorRow], last: &[ErrorRow], part: Part) -> Vec<Change> {
    let after: BTreeMap<&Place, &ErrorRow> = last.iter().map(|r| (&r.place, r)).collect();
    let mut out: Vec<Change> = first
        .iter()
        .filter_map(|before| {
            let after = after.get(&before.place)?;
            let (from, to) = (part.of(before), part.of(after));
            let (smaller, larger) = (to.rms < (1.0 - SAME) * from.rms, to.rms > (1.0 + SAME) * from.rms);
            let fate = match (before.fails, after.fails) {
                (true, false) if smaller => Fate::Gone,
                (false, true) if larger => Fate::New,
                (true, false) | (false, true) => Fate::Unclear,
                (true, true) if smaller => Fate::Smaller,
                (true, true) if larger => Fate::Larger,
                (true, true) => Fate::Remains,
                (false, false) => Fate::Fits,
            };
            Some(Change {
                place: before.place.clone(),
                unit: before.unit,
                before: before.error,
                after: after.error,
                residual_before: before.residual,
                residual_after: after.residual,
                fate,
                failed: before.fails,
            })
        })
        .collect();
    out.sort_by(|a, b| {
        let size = |c: &Change| c.before.multiples.unwrap_or(0.0).max(c.after.multiples.unwrap_or(0.0));
        let order = |c: &Change| match c.fate {
            Fate::New => 0,
            Fate::Gone => 1,
            Fate::Remains | Fate::Smaller | Fate::Larger | Fate::Unclear => 2,
            Fate::Fits => 3,
        };
        order(a).cmp(&order(b)).then(size(b).total_cmp(&size(a)))
    });
    out
}

/// Counts `changes`.
pub fn tally(changes: &[Change], part: Part) -> Tally {
    let count = |fate| changes.iter().filter(|c| c.fate == fate).count();
    // Where both agree with the measurement there is nothing to tell them apart.
    let failing: Vec<&Change> = changes.iter().filter(|c| c.fate != Fate::Fits).collect();
    let some = if failing.is_empty() { changes.iter().collect() } else { failing };
    let overall = |side: fn(&Change, Part) -> Option<f64>| {
        let known: Vec<f64> = some.iter().filter_map(|c| side(c, part)).collect();
        (known.iter().map(|m| m * m).sum::<f64>() / known.len().max(1) as f64).sqrt()
    };
    Tally {
        within_tolerance: part == Part::Error,
        before: overall(|c, part| c.sizes(part).0.multiples),
        after: overall(|c, part| c.sizes(part).1.multiples),
        failures: changes.iter().filter(|c| c.failed).count(),
        removed: count(Fate::Gone),
        smaller: count(Fate::Smaller),
        larger: count(Fate::Larger),
        new: count(Fate::New),
    }
}

impl Change {
    fn sizes(&self, part: Part) -> (Size, Size) {
        match part {
            Part::Error => (self.before, self.after),
            Part::Residual => (self.residual_before, self.residual_after),
        }
    }
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
