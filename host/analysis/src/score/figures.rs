//! The figures of a score: one row for each kind of event and method.

use schemars::JsonSchema;
use serde::Serialize;

use super::alarms::{leads, unmet};
use super::judge::Judged;
use super::rate::Rate;
use super::truth::{Cause, DROP_AHEAD_S, Event, Kind, SLIP_AHEAD_S, SUDDEN_WITHIN_S};
use crate::evidence::statistics::quantiles;

/// Which events a row is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    /// Not meant by the plan; the forces showed it coming.
    SlipBuildsUp,
    /// Not meant by the plan; sudden, or unseen in the forces.
    SlipSudden,
    /// Meant by the plan.
    SlipIntended,
    /// Sag or rotation beyond the limit.
    Moved,
    /// Grasp lost.
    Drop,
    /// Grasp lost, and foreseeable 360 ms ahead.
    DropForeseeable,
}

impl Class {
    /// In the order shown.
    pub const ALL: [Class; 6] = [
        Class::SlipBuildsUp,
        Class::SlipSudden,
        Class::SlipIntended,
        Class::Moved,
        Class::Drop,
        Class::DropForeseeable,
    ];

    /// As the table shows it.
    pub fn name(self) -> &'static str {
        match self {
            Class::SlipBuildsUp => "unexpected slip, builds up",
            Class::SlipSudden => "unexpected slip, sudden",
            Class::SlipIntended => "intended slip",
            Class::Moved => "sag or rotation beyond limit",
            Class::Drop => "drop, all",
            Class::DropForeseeable => "drop, foreseeable",
        }
    }

    /// The kind of event that its alarms are about.
    pub fn kind(self) -> Kind {
        match self {
            Class::SlipBuildsUp | Class::SlipSudden | Class::SlipIntended => Kind::Slip,
            Class::Moved => Kind::Moved,
            Class::Drop | Class::DropForeseeable => Kind::Drop,
        }
    }

    fn holds(self, e: &Event) -> bool {
        e.kind == self.kind()
            && match self {
                Class::SlipBuildsUp => !e.intended && e.cause == Cause::BuildsUp,
                Class::SlipSudden => !e.intended && e.cause == Cause::Sudden,
                Class::SlipIntended => e.intended,
                Class::DropForeseeable => e.cause == Cause::BuildsUp,
                Class::Moved | Class::Drop => true,
            }
    }

    /// Lead that counts as in time, s; negative: after onset.
    pub fn in_time_s(self) -> f64 {
        match self {
            Class::SlipBuildsUp => SLIP_AHEAD_S,
            Class::DropForeseeable => DROP_AHEAD_S,
            Class::SlipSudden | Class::SlipIntended => -SUDDEN_WITHIN_S,
            Class::Moved | Class::Drop => 0.0,
        }
    }
}

/// One row.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Row {
    /// Which events.
    pub class: Class,
    /// Which method.
    pub method: String,
    /// Events there were.
    pub events: usize,
    /// Events with an alarm, at most 0.1 s late.
    pub found: usize,
    /// Events warned in time, by the time that the class asks for.
    pub in_time: usize,
    /// 5, 50 and 95 % of the lead over those found, s; negative: late.
    pub lead_s: Option<[f64; 3]>,
    /// Alarms without an event, for the whole kind (slip: only in trials that mean none).
    pub false_alarm_rate: Option<Rate>,
    /// Alarms at something less only: slip, a motion short of a slip; sag and rotation, a
    /// slip; drop, a slip that ended in time.
    pub near_alarm_rate: Option<Rate>,
    /// Median of 'slips now' minus the measured onset, over fingers, s.
    pub onset_error_s: Option<[f64; 3]>,
    /// Leads of the events found, s, sorted.
    #[serde(skip)]
    pub leads: Vec<f64>,
    /// Where an event was missed or late: trial and time.
    pub not_in_time: Vec<String>,
    /// Where the false alarms are.
    pub false_alarms: Vec<String>,
    /// Its events, and the false alarms of its kind.
    #[serde(skip)]
    pub cases: Vec<Case>,
}

/// What became of an event, or of an alarm without one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// Warned of in time; the lead, s.
    InTime(f64),
    /// Warned of too late; the lead, s.
    Late(f64),
    /// Not warned of.
    Missed,
    /// An alarm without an event.
    FalseAlarm,
}

/// An event, or an alarm without one.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Trial's name.
    pub trial: String,
    /// When it began, s after the trial's first sample.
    pub at_s: f64,
    /// When it was over, s.
    pub until_s: f64,
    /// What became of it.
    pub outcome: Outcome,
}

impl Case {
    /// As the document has it.
    fn place(&self) -> String {
        format!("{} at {:.3} s", self.trial, self.at_s)
    }

    /// Whether there is something to look at: all but what was warned of in time.
    pub fn fails(&self) -> bool {
        !matches!(self.outcome, Outcome::InTime(_))
    }
}

/// A sample's time stamp may lie this far off the grid of samples.
const STAMP_S: f64 = 5e-4;

/// All rows, class by class.
pub fn rows(judged: &[Judged], methods: &[String]) -> Vec<Row> {
    Class::ALL
        .iter()
        .flat_map(|class| methods.iter().enumerate().map(|(m, name)| row(judged, *class, m, name)))
        .collect()
}

fn row(judged: &[Judged], class: Class, m: usize, method: &str) -> Row {
    let kind = class.kind();
    let mut row = Row {
        class,
        method: method.to_owned(),
        events: 0,
        found: 0,
        in_time: 0,
        lead_s: None,
        false_alarm_rate: None,
        near_alarm_rate: None,
        onset_error_s: None,
        leads: Vec::new(),
        not_in_time: Vec::new(),
        false_alarms: Vec::new(),
        cases: Vec::new(),
    };
    let (mut nearly, mut watched_s, mut errors) = (0, 0.0, Vec::new());
    for j in judged {
        let alarms = &j.alarms[m];
        let episodes = alarms.of(kind);
        let events: Vec<&Event> = j.truth.events.iter().filter(|e| class.holds(e)).collect();
        for (event, lead) in events.iter().zip(leads(&events, episodes)) {
            row.events += 1;
            row.found += usize::from(lead.is_some());
            let good = lead.is_some_and(|l| l >= class.in_time_s() - STAMP_S);
            row.in_time += usize::from(good);
            let outcome = match lead {
                Some(lead) if good => Outcome::InTime(lead),
                Some(lead) => Outcome::Late(lead),
                None => Outcome::Missed,
            };
            let (trial, at_s, until_s) = (j.trial.clone(), event.onset_s, event.end_s);
            let case = Case { trial, at_s, until_s, outcome };
            if !good {
                row.not_in_time.push(case.place());
            }
            row.cases.push(case);
            row.leads.extend(lead);
            for (onset, slipping) in event.finger_s.iter().zip(&alarms.slipping) {
                let near = onset.and_then(|onset| {
                    slipping.iter().map(|a| a.from_s - onset).find(|d| (-0.5..0.5).contains(d))
                });
                errors.extend(near);
            }
        }
        if kind != Kind::Slip || j.holds {
            let own: Vec<&Event> = j.truth.events.iter().filter(|e| e.kind == kind).collect();
            let slips = j.truth.events.iter().filter(|e| e.kind == Kind::Slip).map(|e| (e.onset_s, e.end_s));
            let lesser: Vec<(f64, f64)> = match kind {
                Kind::Slip => j.truth.near.clone(),
                Kind::Moved => slips.chain(j.truth.near.iter().copied()).collect(),
                Kind::Drop => slips.collect(),
            };
            let (near, wrong) = unmet(&own, &lesser, episodes);
            nearly += near.len();
            for alarm in wrong {
                let (trial, at_s, until_s) = (j.trial.clone(), alarm.from_s, alarm.to_s);
                let case = Case { trial, at_s, until_s, outcome: Outcome::FalseAlarm };
                row.false_alarms.push(case.place());
                row.cases.push(case);
            }
            watched_s += j.truth.until_s;
        }
    }
    row.leads.sort_by(f64::total_cmp);
    row.lead_s = quantiles(&row.leads);
    errors.sort_by(f64::total_cmp);
    row.onset_error_s = quantiles(&errors);
    if class != Class::SlipIntended {
        row.false_alarm_rate = Rate::of(row.false_alarms.len(), watched_s);
        row.near_alarm_rate = Rate::of(nearly, watched_s);
    }
    row
}
