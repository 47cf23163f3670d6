//! Data sets that others made, with what is hidden in them: of the second rig, or of anyone who writes such keys.
//!
//! A key is a JSON file named after its data set: `effects` with `id`, `level` and `listed`, `family`, and
//! `pad_tangential_n_m`, the stiffness of a finger's pad. Pads below [`SOFT_N_M`] give way by more than the
//! tolerance of rigid contact: naming `contact_compliance` there is not wrong, and not asked for. Nor is
//! `external_force` where a cable or a magnet pulls ([`super::score::pulled`]): keys call them not listed, as they were when the
//! second rig was written.

use std::path::Path;

use anyhow::{Context, ensure};
use serde::Deserialize;

use super::generate::Class;
use super::score::{Opened, Truth, open, pulled};
use stickslip_analysis::diagnose::diagnose;
use stickslip_analysis::model::file::default_model;

/// Tangential stiffness of a finger's pad, N/m, below which it may be named: 0.05 mm, the tolerance of rigid
/// contact, under 10 N.
pub const SOFT_N_M: f64 = 2e5;

#[derive(Deserialize)]
struct Key {
    effects: Vec<Hidden>,
    family: String,
    pad_tangential_n_m: f64,
}

#[derive(Deserialize)]
struct Hidden {
    id: String,
    level: f64,
    listed: bool,
}

impl Key {
    fn truth(self, trials: usize) -> anyhow::Result<Truth> {
        let class = match self.effects.as_slice() {
            [] => Class::Nothing,
            [one] if !one.listed => Class::Unknown,
            [_] => Class::One,
            [a, b] if a.listed && b.listed => Class::Two,
            more => {
                anyhow::bail!("{} effects, of which some are not listed: not one of the classes", more.len())
            }
        };
        let soft = (self.pad_tangential_n_m < SOFT_N_M).then_some("contact_compliance");
        let effects: Vec<String> = self.effects.iter().map(|e| e.id.clone()).collect();
        Ok(Truth {
            class,
            also_true: soft.into_iter().chain(pulled(&effects)).collect(),
            effects,
            strengths: self.effects.iter().map(|e| format!("{}={:.2}", e.id, e.level)).collect(),
            family: self.family,
            trials,
        })
    }
}

/// Names of the data sets in `folder`, in order.
///
/// # Errors
/// Where there are none.
pub fn names(folder: &Path) -> anyhow::Result<Vec<String>> {
    let entries = std::fs::read_dir(folder).with_context(|| format!("{}", folder.display()))?;
    let mut names = Vec::new();
    for entry in entries {
        let entry = entry?;
        if entry.path().join("dataset.toml").exists() {
            names.push(entry.file_name().to_string_lossy().into_owned());
        }
    }
    ensure!(!names.is_empty(), "{}: no folder in it holds a dataset.toml", folder.display());
    names.sort();
    Ok(names)
}

/// Diagnoses the data set `name` of `folder`, then opens its key in `keys`.
///
/// # Errors
/// Where the data set or its key cannot be read, or the diagnosis fails.
pub fn run(folder: &Path, keys: &Path, name: &str) -> anyhow::Result<Opened> {
    let dataset = stickslip_data::read(&folder.join(name)).with_context(|| name.to_owned())?;
    let report = diagnose(&dataset, &default_model(), &[], &()).with_context(|| name.to_owned())?;
    let path = keys.join(format!("{name}.json"));
    let text = std::fs::read_to_string(&path).with_context(|| format!("{}: no key", path.display()))?;
    let key: Key = serde_json::from_str(&text).with_context(|| format!("{}", path.display()))?;
    Ok(open(key.truth(dataset.trials.len())?, &report, Vec::new()))
}
