//! What was measured and predicted about the events that were missed or late, and about false alarms: to be drawn.
//!
//! A trial may last minutes: of each only the time about its cases is kept. The predictor runs once more along the
//! trials that are drawn, which are few.

use std::collections::BTreeSet;

use stickslip_data::{Index, Sample, TrialInfo};
use stickslip_shared::model::Model;
use stickslip_shared::predictor::{Checked, Limits, Prediction};

use super::document::Document;
use super::figures::{Case, Class, Outcome};
use super::judge::{fed, predict, times};
use super::truth::{self, Event};
use crate::run::replay::at_board_rate;
use crate::run::scene::scene;

/// Time before a case that is drawn, s.
const BEFORE_S: f64 = 1.5;
/// Time after its beginning, or after its end where that comes sooner than [`LONGEST_S`], s.
const AFTER_S: f64 = 0.5;
/// Of a case that lasts, s: what follows is another matter, of a drop the empty grasp.
const LONGEST_S: f64 = 0.7;
/// Cases of a trial that lie near are drawn together up to this time, s.
const TOGETHER_S: f64 = 6.0;
/// Without this many cases that fail, events that were warned of in time are drawn too, one of each class.
const FEWEST: usize = 3;

/// An event of a class, or an alarm without one.
#[derive(Clone, Debug)]
pub struct Shown {
    /// Of the event; of a false alarm the first class of its kind.
    pub class: Class,
    /// What happened.
    pub case: Case,
    /// Place in [`Drawn::traces`]; `None`: not drawn.
    pub trace: Option<usize>,
}

/// Some time of a trial.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Its trial.
    pub info: TrialInfo,
    /// Times from the trial's first sample on, s.
    pub t_s: Vec<f64>,
    /// What was measured.
    pub samples: Vec<Sample>,
    /// What was predicted.
    pub predictions: Vec<Prediction>,
    /// What happened, all of the trial.
    pub events: Vec<Event>,
}

/// What a page of a score draws.
#[derive(Clone, Debug, Default)]
pub struct Drawn {
    /// What was missed, late or in vain; then examples of what was warned of in time.
    pub shown: Vec<Shown>,
    /// In the order in which `shown` names them.
    pub traces: Vec<Trace>,
}

/// The predictor's cases that a page shows: those that fail, class by class; where they are few, an example of each class
/// that was warned of in time.
pub fn cases(document: &Document) -> Vec<(Class, Case)> {
    let rows = || document.rows.iter().filter(|r| document.is_own(r));
    let mut out: Vec<(Class, Case)> = Vec::new();
    let mut add = |class: Class, case: &Case| {
        // An alarm without an event is one of all classes of its kind.
        let known = |(other, known): &(Class, Case)| {
            other.kind() == class.kind() && known == case && case.outcome == Outcome::FalseAlarm
        };
        if !out.iter().any(known) {
            out.push((class, case.clone()));
        }
        out.len()
    };
    let mut count = 0;
    for (row, case) in rows().flat_map(|r| r.cases.iter().map(move |c| (r, c))).filter(|(_, c)| c.fails()) {
        count = add(row.class, case);
    }
    if count < FEWEST {
        for row in rows() {
            row.cases.iter().find(|c| !c.fails()).map(|case| add(row.class, case));
        }
    }
    out
}

/// What a page shows of a score: the [`cases`], and what was measured and predicted about them, in `most` pieces of trials
/// at most, of every class some.
pub fn traces(
    index: &Index,
    model: &Model<f64>,
    tuning: &Checked<f32>,
    document: &Document,
    most: usize,
) -> Drawn {
    let shown = cases(document).into_iter().map(|(class, case)| Shown { class, case, trace: None });
    let mut drawn = Drawn { shown: shown.collect(), traces: Vec::new() };
    let mut pieces: Vec<(String, f64, f64)> = Vec::new();
    for k in turns(&drawn.shown) {
        let case = &drawn.shown[k].case;
        let from = case.at_s - BEFORE_S;
        let to = case.until_s.clamp(case.at_s, case.at_s + LONGEST_S) + AFTER_S;
        let near = |(trial, a, b): &(String, f64, f64)| {
            *trial == case.trial && from <= *b && *a <= to && b.max(to) - a.min(from) <= TOGETHER_S
        };
        let place = pieces.iter().position(near);
        let place = match place {
            Some(place) => place,
            None if pieces.len() < most => {
                pieces.push((case.trial.clone(), from, to));
                pieces.len() - 1
            }
            None => continue,
        };
        let (_, a, b) = &mut pieces[place];
        (*a, *b) = (a.min(from), b.max(to));
        drawn.shown[k].trace = Some(place);
    }
    let mut made: Vec<Option<Trace>> = vec![None; pieces.len()];
    // The predictor runs once along a trial, however many pieces of it are drawn.
    let trials: BTreeSet<&str> = pieces.iter().map(|(trial, ..)| trial.as_str()).collect();
    for trial in trials {
        let Some(whole) = whole(index, model, tuning, document, trial) else { continue };
        for (made, (_, from_s, to_s)) in made.iter_mut().zip(&pieces).filter(|(_, piece)| piece.0 == trial) {
            *made = Some(whole.between(*from_s, *to_s));
        }
    }
    // What could be scored can be read again, unless somebody took the file away.
    let mut places = Vec::new();
    for trace in made {
        places.push(trace.is_some().then_some(drawn.traces.len()));
        drawn.traces.extend(trace);
    }
    for one in &mut drawn.shown {
        one.trace = one.trace.and_then(|k| places.get(k).copied().flatten());
    }
    drawn
}

/// Places of what is shown, one of each class and outcome in turn.
fn turns(shown: &[Shown]) -> Vec<usize> {
    let sort = |s: &Shown| (s.class, std::mem::discriminant(&s.case.outcome));
    let mut order: Vec<(usize, usize)> = Vec::new();
    for (k, one) in shown.iter().enumerate() {
        let before = shown[..k].iter().filter(|other| sort(other) == sort(one)).count();
        order.push((before, k));
    }
    order.sort_unstable();
    order.into_iter().map(|(_, k)| k).collect()
}

/// All of a trial; none where its file can no longer be read.
fn whole(
    index: &Index,
    model: &Model<f64>,
    tuning: &Checked<f32>,
    document: &Document,
    name: &str,
) -> Option<Trace> {
    let (ordinal, info) = index.find(Some(name)).ok()?;
    let trial = at_board_rate(index.read_trial_lenient(info).trial?).0;
    let limits = Limits::default();
    let rig = scene(&index.description, &trial).ok()?;
    let feed = fed(&index.description, &trial).ok()?;
    let events = truth::find(&rig, &trial, &limits).events;
    let predictions = predict(&feed, model, (limits, tuning), ordinal, document.object_pose, name).ok()?;
    let t_s = times(&trial);
    Some(Trace { info: info.clone(), t_s, samples: trial.samples, predictions, events })
}

impl Trace {
    /// From one time of it to another.
    fn between(&self, from_s: f64, to_s: f64) -> Self {
        let from = self.t_s.partition_point(|t| *t < from_s);
        let to = self.t_s.partition_point(|t| *t <= to_s).max(from);
        Self {
            info: self.info.clone(),
            t_s: self.t_s[from..to].to_vec(),
            samples: self.samples[from..to].to_vec(),
            predictions: self.predictions[from..to].to_vec(),
            events: self.events.clone(),
        }
    }
}
