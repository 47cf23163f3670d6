//! What a reader wants to know of a run: the newest prediction, its recent course, alarms and how much they came
//! ahead, the health of the line. Events in, state out; no clock is read here.

use std::collections::VecDeque;

use schemars::JsonSchema;
use serde::Serialize;
use stickslip_analysis::run::replay::FLAGS;
use stickslip_shared::model::Scene;
use stickslip_shared::predictor::{FingerPrediction, Prediction, Slip, flags, validity};
use stickslip_shared::wire::sequence::{Order, Sequence};
use stickslip_shared::wire::{Mode, Sample, Statistics, TICK_US, TelemetryReport};
use stickslip_unit::bus::State as BusState;

use crate::event::{Event, Happened};

/// Of the course that is kept, s.
pub const TRACE_S: f64 = 10.0;
/// Over which rates are counted, s.
const RATE_S: f64 = 1.0;
/// Alarms that are kept; older ones are counted.
const ALARMS: usize = 200;
/// Flags that call for something to be done, by their bits.
const CALLING: [u32; 8] = [
    flags::SLIP_1,
    flags::SLIP_2,
    flags::SLIP_AHEAD_1,
    flags::SLIP_AHEAD_2,
    flags::UNEXPECTED,
    flags::SAG,
    flags::ROTATION,
    flags::DROP,
];
/// Flags that foretell another one.
const FORETELLS: [(u32, u32); 2] =
    [(flags::SLIP_AHEAD_1, flags::SLIP_1), (flags::SLIP_AHEAD_2, flags::SLIP_2)];

/// A flag that rose.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Alarm {
    /// When it rose, s since the view began.
    pub at_s: f64,
    /// Name of the flag.
    pub what: &'static str,
    /// Bit of the flag.
    pub flag: u32,
    /// How far ahead what it warns of was said to be, s; none for a flag about the present.
    pub foreseen_in_s: Option<f32>,
    /// How long after the warning slip was flagged, s; none: not yet, or not at all.
    pub came_after_s: Option<f64>,
    /// When it fell, s; none: it is up.
    pub over_s: Option<f64>,
    /// The prediction said itself that its flags cannot be relied on.
    pub unsure: bool,
}

/// One instant of the recent course.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// s.
    pub at_s: f64,
    /// Share of the friction limit used by each finger.
    pub used: [f32; 2],
    /// Sag, m.
    pub sag_m: f32,
}

/// Health of the line and of the board's tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, JsonSchema, Serialize)]
pub struct Line {
    /// Samples that the board took in the last second; of a replay's log and of the bus, predictions.
    pub samples_per_s: f64,
    /// Reports that came in the last second.
    pub reports_per_s: f64,
    /// Reports that were sent and never came.
    pub reports_lost: u64,
    /// Frames that came damaged.
    pub frames_damaged: u64,
    /// Samples that the board counts as lost since its reset.
    pub samples_lost: Option<u32>,
    /// Periods that its ticks began late by, since its reset.
    pub ticks_missed: Option<u32>,
    /// Duration of the newest tick, ms; none where the board's timer is not known.
    pub work_ms: Option<f64>,
    /// The longest so far, ms.
    pub work_worst_ms: Option<f64>,
}

/// What is known of a run.
#[derive(Clone, Debug, Default)]
pub struct State {
    /// Time of the newest event, s.
    pub now_s: f64,
    /// What is watched.
    pub title: String,
    /// Remarks, the newest last.
    pub notes: Vec<String>,
    /// Object, fingers, pusher.
    pub scene: Option<Scene<f32>>,
    /// Of the newest report.
    pub mode: Option<Mode>,
    /// Newest.
    pub prediction: Option<Prediction>,
    /// The one that `prediction` is about, where it is known.
    pub sample: Option<Sample>,
    /// Grip that the board advises, N.
    pub advised_grip_n: Option<f32>,
    /// The last [`TRACE_S`].
    pub trace: VecDeque<Point>,
    /// The last ones, the newest last.
    pub alarms: VecDeque<Alarm>,
    /// How many there were.
    pub alarms_counted: usize,
    /// Predictions so far.
    pub predictions: u64,
    line: Line,
    timer_hz: Option<u32>,
    /// Samples that went out and are not reported on yet.
    sent: VecDeque<Sample>,
    reports: Option<Sequence>,
    /// Sample of the newest report.
    reported: Option<u32>,
    /// Wrench of each finger on the bus.
    wrench: [Option<[f32; 6]>; 2],
    /// Of the bus: its newest state, and states so far that were predicted from a sample.
    heard: Option<(BusState, u64)>,
    /// When each report came, and the samples taken until then.
    recent: VecDeque<(f64, u64)>,
}

/// Share of the friction limit that a finger uses: by its sensor, otherwise by the model.
#[must_use]
pub fn used(finger: &FingerPrediction) -> f32 {
    finger.measured_utilisation.unwrap_or(finger.model_utilisation)
}

impl State {
    /// Takes in what happened; the alarms that rose with it.
    pub fn take(&mut self, event: &Event) -> Vec<Alarm> {
        self.now_s = event.at_s;
        match &event.what {
            Happened::Board(info) => {
                self.timer_hz = Some(info.timer_hz);
                self.title = format!("{} firmware {}", info.board, info.firmware);
            }
            Happened::Timer(hz) => self.timer_hz = Some(*hz),
            Happened::Scene(scene, trial) => {
                self.scene = Some((**scene).clone());
                let title = std::mem::take(&mut self.title);
                self.title = if title.is_empty() { trial.clone() } else { format!("{title}, {trial}") };
            }
            Happened::Note(text) => self.notes.push(text.clone()),
            Happened::Counts(counts, damaged) => self.count(counts, *damaged),
            Happened::Sample(sample) => {
                self.sent.push_back(*sample);
                // A board that falls silent must not fill the memory.
                if self.sent.len() > 1000 {
                    self.sent.pop_front();
                }
            }
            Happened::Prediction(prediction) => {
                self.sample = self.sent.pop_front().or(self.sample);
                let taken = self.predictions + 1;
                self.pass(event.at_s, taken);
                return self.predict(event.at_s, prediction);
            }
            Happened::Report(report) => return self.report(event.at_s, report),
            Happened::Heard(state) => return self.hear(event.at_s, state),
            Happened::Damaged(frames) => self.line.frames_damaged = *frames,
            Happened::Wrench(finger, wrench) => {
                if let Some(newest) = self.wrench.get_mut(*finger) {
                    *newest = *wrench;
                }
            }
        }
        Vec::new()
    }

    /// Measured wrench on the object at a finger, gripper axes, N and N m, where it is known.
    #[must_use]
    pub fn wrench(&self, finger: usize) -> Option<[f32; 6]> {
        self.sample.as_ref().and_then(|sample| sample.finger[finger]).or(self.wrench[finger])
    }

    /// Health of the line.
    #[must_use]
    pub fn line(&self) -> Line {
        let Some(((first_s, taken), (last_s, newest))) = self.recent.front().zip(self.recent.back()) else {
            return self.line;
        };
        let span_s = last_s - first_s;
        let a_second = |count: f64| if span_s > 0.0 { count / span_s } else { 0.0 };
        Line {
            samples_per_s: a_second(newest.saturating_sub(*taken) as f64),
            reports_per_s: a_second((self.recent.len() - 1) as f64),
            ..self.line
        }
    }

    fn count(&mut self, counts: &Statistics, damaged: u64) {
        self.line.frames_damaged = damaged + u64::from(counts.frames_damaged);
        self.line.samples_lost = Some(counts.samples_lost);
        self.line.ticks_missed = Some(counts.ticks_missed);
    }

    fn pass(&mut self, at_s: f64, taken: u64) {
        self.recent.push_back((at_s, taken));
        while self.recent.front().is_some_and(|(then, _)| at_s - then > RATE_S) {
            self.recent.pop_front();
        }
    }

    fn report(&mut self, at_s: f64, report: &TelemetryReport) -> Vec<Alarm> {
        let sequence = self.reports.get_or_insert_with(|| Sequence::starting_at(report.seq));
        match sequence.judge(report.seq) {
            Order::Next { lost } => self.line.reports_lost += u64::from(lost),
            Order::Repeated => return Vec::new(),
            // The board began anew: its numbers do too.
            Order::Late => {
                self.reports = Some(Sequence::starting_at(report.seq.wrapping_add(1)));
                self.recent.clear();
                self.reported = None;
            }
        }
        self.mode = Some(report.mode);
        self.advised_grip_n = report.advised_grip_n;
        if let Some(hz) = self.timer_hz.filter(|hz| *hz > 0) {
            let ms = f64::from(report.cost) / f64::from(hz) * 1e3;
            self.line.work_ms = Some(ms);
            self.line.work_worst_ms = Some(self.line.work_worst_ms.map_or(ms, |worst| worst.max(ms)));
        }
        self.pass(at_s, u64::from(report.taken));
        let Some(seq) = report.sample_seq else { return Vec::new() };
        // The last sample of a run is reported when the run is over.
        let newer = self.reported.replace(seq).is_some_and(|before| before != seq);
        if report.mode != Mode::Running && !newer {
            return Vec::new();
        }
        while self.sent.front().is_some_and(|sample| sample.seq <= seq) {
            self.sample = self.sent.pop_front();
        }
        self.predict(at_s, &report.prediction)
    }

    fn hear(&mut self, at_s: f64, state: &BusState) -> Vec<Alarm> {
        // Two ticks may have the same reading of a slow sensor: its time does not tell.
        let mut taken = u64::from(state.validity & (validity::SAMPLE | validity::WAITING) == 0);
        if let Some((before, samples)) = &self.heard {
            let passed = state.counter.wrapping_sub(before.counter);
            if passed == 0 {
                return Vec::new();
            }
            self.line.reports_lost += u64::from(passed - 1);
            taken += samples;
        }
        self.heard = Some((*state, taken));
        self.mode = Some(state.mode);
        self.advised_grip_n = state.advised_n;
        self.pass(at_s, taken);
        if state.mode == Mode::Running { self.predict(at_s, &heard(state)) } else { Vec::new() }
    }

    fn predict(&mut self, at_s: f64, prediction: &Prediction) -> Vec<Alarm> {
        let before = self.prediction.as_ref().map_or(0, |p| p.flags);
        let (rose, fell) = (prediction.flags & !before, before & !prediction.flags);
        self.prediction = Some(*prediction);
        self.predictions += 1;
        self.trace.push_back(Point {
            at_s,
            used: [used(&prediction.finger[0]), used(&prediction.finger[1])],
            sag_m: prediction.sag_m,
        });
        while self.trace.front().is_some_and(|point| at_s - point.at_s > TRACE_S) {
            self.trace.pop_front();
        }
        for alarm in self.alarms.iter_mut().filter(|alarm| alarm.over_s.is_none()) {
            let told = FORETELLS.iter().find(|(ahead, _)| *ahead == alarm.flag);
            if told.is_some_and(|(_, now)| rose & now != 0) {
                alarm.came_after_s = alarm.came_after_s.or(Some(at_s - alarm.at_s));
            }
            if fell & alarm.flag != 0 {
                alarm.over_s = Some(at_s);
            }
        }
        let raised: Vec<Alarm> = CALLING
            .iter()
            .filter(|flag| rose & *flag != 0)
            .map(|flag| Alarm {
                at_s,
                what: FLAGS[flag.trailing_zeros() as usize],
                flag: *flag,
                foreseen_in_s: foreseen_in_s(*flag, prediction),
                came_after_s: None,
                over_s: None,
                unsure: prediction.flags & flags::UNSURE != 0,
            })
            .collect();
        self.alarms_counted += raised.len();
        self.alarms.extend(raised.iter().cloned());
        while self.alarms.len() > ALARMS {
            self.alarms.pop_front();
        }
        raised
    }
}

/// How far ahead what a flag warns of is.
fn foreseen_in_s(flag: u32, prediction: &Prediction) -> Option<f32> {
    match flag {
        flags::SLIP_AHEAD_1 => prediction.finger[0].slip.in_s(),
        flags::SLIP_AHEAD_2 => prediction.finger[1].slip.in_s(),
        flags::DROP => prediction.drop_in_s,
        _ => None,
    }
    // The bus does not say when.
    .filter(|s| s.is_finite())
}

/// Share of its period that a tick of `work_ms` takes.
#[must_use]
pub fn of_period(work_ms: f64) -> f64 {
    work_ms / (f64::from(TICK_US) * 1e-3)
}

/// What a state on the bus tells of a prediction. The bus carries what a controller needs and no more: all else is not a
/// number, and shown as not known.
fn heard(state: &BusState) -> Prediction {
    const UNKNOWN: f32 = f32::NAN;
    let slip = |now: u32, ahead: u32| match state.flags {
        up if up & now != 0 => Slip::Now,
        // The bus does not say when.
        up if up & ahead != 0 => Slip::In(UNKNOWN),
        _ => Slip::None,
    };
    let finger = |number: usize, slip: Slip| FingerPrediction {
        slip,
        measured_utilisation: state.used[number],
        model_utilisation: UNKNOWN,
        peak_utilisation: UNKNOWN,
        ..FingerPrediction::default()
    };
    Prediction {
        flags: state.flags,
        validity: state.validity,
        finger: [
            finger(0, slip(flags::SLIP_1, flags::SLIP_AHEAD_1)),
            finger(1, slip(flags::SLIP_2, flags::SLIP_AHEAD_2)),
        ],
        sag_m: UNKNOWN,
        sag_ahead_m: UNKNOWN,
        rotation_rad: UNKNOWN,
        drop_in_s: state.drop_in_s,
        holding_grip_n: state.holding_n,
        friction: UNKNOWN,
        friction_least: UNKNOWN,
        hold_probability: None,
        position_m: [UNKNOWN; 3],
        quaternion: [UNKNOWN; 4],
        finger_wrench: [[UNKNOWN; 6]; 2],
        pusher_force_n: [UNKNOWN; 3],
        ..Prediction::default()
    }
}
