//! What was measured, what a model says, and what the predictor announced, as columns over time.
//!
//! Columns: `t_s`; `measured_<channel>` as recorded; `modelled_<channel>` (with several models
//! `modelled_<model>_<channel>`) along the measured drive; `predicted_<field>` for every field of a
//! [`Prediction`], lists numbered from 0. Channels and axes are those of [`crate::channels`].

use std::collections::BTreeMap;

use serde_json::Value;
use stickslip_data::series::{Series, Values};
use stickslip_shared::predictor::Prediction;

use crate::channels::{NAMES, Signals};
use crate::run::simulate::{Prepared, Simulated};

/// Measured and modelled channels; `models` are their names (one model needs none) and runs.
#[must_use]
pub fn signals(trial: &str, prepared: &Prepared, models: &[(&str, &Simulated)]) -> Series {
    let mut columns = vec![("t_s".to_owned(), Values::Numbers(prepared.t_s.clone()))];
    columns.extend(channels("measured", &prepared.measured));
    for (name, simulated) in models {
        let prefix = if models.len() > 1 { format!("modelled_{name}") } else { "modelled".into() };
        columns.extend(channels(&prefix, &simulated.signals));
    }
    Series { trial: trial.to_owned(), columns }
}

/// Adds the predictions, one for each sample.
pub fn add_predictions(series: &mut Series, predictions: &[Prediction]) {
    let mut columns: BTreeMap<String, Vec<Value>> = BTreeMap::new();
    for (row, prediction) in predictions.iter().enumerate() {
        // A prediction of numbers and lists can always be written.
        let value = serde_json::to_value(prediction).unwrap_or_default();
        flatten("predicted", value, &mut |name, leaf| {
            let column = columns.entry(name).or_default();
            column.resize(row, Value::Null);
            column.push(leaf);
        });
    }
    for (name, mut values) in columns {
        values.resize(predictions.len(), Value::Null);
        let words = values.iter().any(Value::is_string);
        let values = match words {
            true => Values::Words(values.iter().map(|v| v.as_str().unwrap_or_default().into()).collect()),
            false => Values::Numbers(values.iter().map(number).collect()),
        };
        series.columns.push((name, values));
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().or(value.as_bool().map(f64::from)).unwrap_or(f64::NAN)
}

fn channels<'a>(prefix: &'a str, rows: &'a [Signals]) -> impl Iterator<Item = (String, Values)> + 'a {
    NAMES.iter().enumerate().map(move |(k, name)| {
        (format!("{prefix}_{name}"), Values::Numbers(rows.iter().map(|s| s[k]).collect()))
    })
}

/// Hands every leaf of `value` to `take`, with its path as name.
fn flatten(name: &str, value: Value, take: &mut dyn FnMut(String, Value)) {
    match value {
        Value::Object(keys) => keys.into_iter().for_each(|(k, v)| flatten(&format!("{name}_{k}"), v, take)),
        Value::Array(items) => {
            items.into_iter().enumerate().for_each(|(k, v)| flatten(&format!("{name}_{k}"), v, take));
        }
        leaf => take(name.to_owned(), leaf),
    }
}
