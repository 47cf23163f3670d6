//! Conditions of trials: which runs repeat each other, what varies, what is held out. Every command
//! takes them from here.

use std::borrow::Borrow;
use std::collections::{BTreeMap, BTreeSet};

use schemars::JsonSchema;
use serde::Serialize;

use stickslip_data::TrialInfo;

/// A quantity that the experimenter sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Variable {
    /// Object id.
    Object,
    /// N
    Grip,
    /// m/s
    Speed,
    /// rad/s
    TurnSpeed,
    /// rad
    Slope,
    /// m
    PusherOffset,
    /// Position of the trial in the data set: drift and wear go with it.
    Order,
}

/// All that can be set.
pub const VARIABLES: [Variable; 6] = [
    Variable::Object,
    Variable::Grip,
    Variable::Speed,
    Variable::TurnSpeed,
    Variable::Slope,
    Variable::PusherOffset,
];

impl Variable {
    /// As people read it, with the unit that [`Variable::shown`] uses.
    pub fn label(self) -> &'static str {
        match self {
            Variable::Object => "object",
            Variable::Grip => "grip, N",
            Variable::Speed => "speed, mm/s",
            Variable::TurnSpeed => "turning speed, deg/s",
            Variable::Slope => "slope, deg",
            Variable::PusherOffset => "pusher offset, mm",
            Variable::Order => "order in the data set",
        }
    }

    /// Unit of [`Variable::value`].
    pub fn unit(self) -> &'static str {
        match self {
            Variable::Object | Variable::Order => "1",
            Variable::Grip => "N",
            Variable::Speed => "m/s",
            Variable::TurnSpeed => "rad/s",
            Variable::Slope => "rad",
            Variable::PusherOffset => "m",
        }
    }

    /// SI value; `None` for the object and where not applicable.
    pub fn value(self, info: &TrialInfo) -> Option<f64> {
        match self {
            Variable::Object | Variable::Order => None,
            Variable::Grip => info.grip_n,
            Variable::Speed => info.speed_m_s,
            Variable::TurnSpeed => info.speed_rad_s,
            Variable::Slope => info.slope_rad,
            Variable::PusherOffset => info.pusher_offset_m,
        }
    }

    /// From SI to the unit of the label.
    pub fn shown(self, value: f64) -> f64 {
        match self {
            Variable::Speed | Variable::PusherOffset => value * 1e3,
            Variable::TurnSpeed | Variable::Slope => value.to_degrees(),
            _ => value,
        }
    }

    /// The level as text, for axes.
    pub fn level(self, info: &TrialInfo) -> Option<String> {
        match self {
            Variable::Object => Some(info.object.clone()),
            _ => self.value(info).map(|v| trimmed(self.shown(v), 4)),
        }
    }
}

/// So many significant digits, without trailing zeros.
pub fn trimmed(x: f64, significant: i32) -> String {
    if x == 0.0 || !x.is_finite() {
        return if x == 0.0 { "0".into() } else { "-".into() };
    }
    let digits = (significant - 1 - x.abs().log10().floor() as i32).max(0) as usize;
    let text = format!("{x:.digits$}");
    if !text.contains('.') {
        return text;
    }
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.to_owned() }
}

/// A trial's primitive and conditions: 'linear push, grip 20 N'.
pub fn in_words(info: &TrialInfo) -> String {
    let level = |v: Variable| {
        let (name, unit) = v.label().split_once(", ").unwrap_or((v.label(), ""));
        v.level(info).map(|l| format!("{name} {l} {unit}").trim_end().to_owned())
    };
    let levels = VARIABLES.into_iter().filter_map(level);
    std::iter::once(info.primitive.replace('_', " ")).chain(levels).collect::<Vec<_>>().join(", ")
}

/// The settings of a run that the format names, and those of the columns `extra`: not the run, the
/// file and the placing of the pusher.
fn key(info: &TrialInfo, extra: &[&String]) -> String {
    let number = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x:.6e}"));
    let mut parts = vec![
        info.primitive.clone(),
        info.object.clone(),
        number(info.grip_n),
        number(info.speed_m_s),
        number(info.speed_rad_s),
        number(info.slope_rad),
        number(info.pusher_offset_m),
    ];
    parts.extend(extra.iter().map(|name| info.extra.get(*name).cloned().unwrap_or_default()));
    parts.join("|")
}

/// Trials of each condition (places in `infos`), in the order of their first run. Equal
/// conditions without a run, or with a run number twice, are no repetitions and stand alone.
///
/// Columns of trials.csv that the format does not name are conditions too, unless they would
/// leave less than two thirds of the repetitions that there are without them: those are times,
/// remarks, the weather.
pub fn conditions<I: Borrow<TrialInfo>>(infos: &[I]) -> Vec<Vec<usize>> {
    let plain = classes(infos, &[]);
    let repeats = |groups: &[Vec<usize>]| infos.len() - groups.len();
    let names: BTreeSet<&String> = infos.iter().flat_map(|i| i.borrow().extra.keys()).collect();
    let mut kept: Vec<&String> = Vec::new();
    let mut out = plain.clone();
    for name in names {
        let mut trial = kept.clone();
        trial.push(name);
        let with = classes(infos, &trial);
        if 3 * repeats(&with) >= 2 * repeats(&plain) {
            (kept, out) = (trial, with);
        }
    }
    out
}

fn classes<I: Borrow<TrialInfo>>(infos: &[I], extra: &[&String]) -> Vec<Vec<usize>> {
    let mut places: BTreeMap<String, usize> = BTreeMap::new();
    let mut out: Vec<Vec<usize>> = Vec::new();
    for (i, info) in infos.iter().map(Borrow::borrow).enumerate() {
        let next = out.len();
        let place = *places.entry(key(info, extra)).or_insert(next);
        let run = |j: usize| infos[j].borrow().run;
        let repeats = |j: &usize| run(*j).is_some() && run(*j) != info.run;
        match out.get_mut(place) {
            Some(members) if info.run.is_some() && members.iter().all(repeats) => members.push(i),
            _ => out.push(vec![i]),
        }
    }
    out
}

/// The condition of each trial, by the place of [`conditions`].
pub fn condition_of<I: Borrow<TrialInfo>>(infos: &[I]) -> Vec<usize> {
    let mut out = vec![0; infos.len()];
    for (c, group) in conditions(infos).iter().enumerate() {
        for i in group {
            out[*i] = c;
        }
    }
    out
}

/// Trials that no parameter may be fitted to.
#[derive(Clone, Debug, PartialEq, Default)]
pub enum HeldOut {
    /// All trials are compared.
    #[default]
    Nothing,
    /// These ids.
    Trials(Vec<String>),
    /// This share of the conditions, evenly spread over the data set.
    Share(f64),
}

impl std::str::FromStr for HeldOut {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse::<f64>() {
            Ok(share) if share > 0.0 && share < 1.0 => Ok(HeldOut::Share(share)),
            Ok(share) => Err(format!(
                "a share of {share} cannot be held out; give one between 0 and 1, or ids of trials"
            )),
            Err(_) => Ok(HeldOut::Trials(text.split(',').map(|id| id.trim().to_owned()).collect())),
        }
    }
}

impl HeldOut {
    /// Whether each trial is held out.
    ///
    /// # Errors
    /// An id that no trial has; a share that leaves nothing on one side.
    pub fn mask(&self, infos: &[TrialInfo]) -> Result<Vec<bool>, String> {
        let mut mask = vec![false; infos.len()];
        match self {
            HeldOut::Nothing => {}
            HeldOut::Trials(ids) => {
                for id in ids {
                    let at = infos
                        .iter()
                        .position(|i| i.trial == *id)
                        .ok_or_else(|| format!("to hold out: no trial is named `{id}`"))?;
                    mask[at] = true;
                }
            }
            HeldOut::Share(share) => {
                let groups = conditions(infos);
                let wanted = (share * groups.len() as f64).round().max(1.0);
                if wanted as usize >= groups.len() {
                    return Err(format!(
                        "{} condition(s) are too few to hold a share of {share} of them out",
                        groups.len()
                    ));
                }
                for (place, group) in groups.iter().enumerate() {
                    // Every time the running share passes a whole number.
                    let step = |k: usize| (k as f64 * wanted / groups.len() as f64 + 0.5).floor();
                    if step(place + 1) > step(place) {
                        for i in group {
                            mask[*i] = true;
                        }
                    }
                }
            }
        }
        Ok(mask)
    }
}
