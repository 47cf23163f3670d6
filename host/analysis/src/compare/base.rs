//! What a comparison was not given: the base model (for each primitive, friction as
//! [`crate::calibrate`] finds it, from at most twelve trials spread over the conditions), and the
//! sensors' noise and uncertainty.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::inputs::load;
use super::models::NamedModel;
use crate::calibrate::{Share, name, of_primitive};
use crate::evidence::sensors::{sensors_or_estimated, unstated};
use crate::model::file::default_model;
use stickslip_data::{Description, Index, Trial};

/// Most trials of a primitive that serve it.
const TRIALS: usize = 12;

/// The description with what its `[sensors]` do not state taken from at most twelve trials, as
/// [`crate::evidence::sensors`] does it for every command; `notes` receives what was taken. No sensor
/// is perfect: with a floor of zero every model would fail.
pub fn with_sensors(data: &Index, notes: &mut Vec<String>) -> Description {
    if unstated(&data.description).is_empty() {
        return data.description.clone();
    }
    let count = data.trials.len().min(TRIALS);
    let trials: Vec<Trial> =
        (0..count).into_par_iter().filter_map(|k| load(data, k * data.trials.len() / count).0.ok()).collect();
    let used = sensors_or_estimated(&data.description, trials.iter());
    if !used.taken.is_empty() {
        notes.push(format!("[sensors] leaves open what was taken from the data: {}.", used.taken.join("; ")));
    }
    Description { sensors: used.sensors, ..data.description.clone() }
}

/// Calibrates it on trials that are not held out; `notes` receives what they do not determine.
pub fn calibrated(
    data: &Index,
    groups: &[Vec<usize>],
    held_out: &[bool],
    notes: &mut Vec<String>,
) -> NamedModel {
    let mut usable: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for i in groups.iter().filter_map(|g| g.iter().copied().find(|i| !held_out[*i])) {
        usable.entry(&data.trials[i].primitive).or_default().push(i);
    }
    let several = usable.len() > 1;
    let mut out = NamedModel::own("base", "", default_model());
    let mut used = 0;
    for (primitive, places) in usable {
        let count = places.len().min(TRIALS);
        let trials: Vec<(usize, Trial)> = (0..count)
            .into_par_iter()
            .map(|k| places[k * places.len() / count])
            .filter_map(|i| load(data, i).0.ok().map(|trial| (i, trial)))
            .collect();
        let all = Share { share: 1.0, fewest: count };
        let found = match of_primitive(&data.description, primitive, &trials, &default_model(), all) {
            Ok(found) => found,
            Err(error) => {
                notes.push(format!(
                    "friction of {primitive} was not calibrated ({error}): the default is used"
                ));
                continue;
            }
        };
        used += found.calibration_trials.len();
        for e in found.estimates.iter().filter(|e| !e.determined) {
            let range = match (e.low, e.high) {
                (None, None) => "not bounded by these data".to_owned(),
                (Some(low), None) => format!("only bounded by these data, at least {low:.3}"),
                (None, Some(high)) => format!("only bounded by these data, at most {high:.3}"),
                (Some(low), Some(high)) => format!("only bounded by these data, {low:.3} to {high:.3}"),
            };
            let of = if several { format!(" ({primitive})") } else { String::new() };
            notes.push(format!(
                "{} friction{of} is {range}: {:.3} is used. Errors that depend on it are not significant.",
                name(e.coefficient),
                e.value
            ));
            let prefix = if several { format!("{primitive}.") } else { String::new() };
            out.only_bounded.push(prefix + name(e.coefficient));
        }
        if several {
            out.by_primitive.insert(primitive.to_owned(), found.model);
        } else {
            out.model = found.model;
        }
    }
    out.origin = match used {
        0 => "no model was given and none could be calibrated: hard contact, friction of the default"
            .to_owned(),
        n => format!("no model was given: hard contact, friction calibrated on {n} of these trials"),
    };
    out
}
