//! The blind test of the diagnosis: `generate` draws what is hidden and makes the data,
//! `score` opens the key. `keys` does the same with data sets and keys that others made. The diagnosis between them sees a data set and nothing else.

pub mod generate;
pub mod keys;
pub mod score;

use anyhow::anyhow;

use generate::{Class, Wanted, data, draw};
use score::{Opened, Truth, open};
use stickslip_analysis::diagnose::{base_misfit, diagnose};
use stickslip_analysis::model::candidate::CandidateEffect;
use stickslip_analysis::model::file::default_model;

/// Draws number `number` of the series `seed`, makes its data, diagnoses them without the key (the
/// formulas of `own` are tried beside the listed effects), and opens it. A formula stands for a
/// hidden effect whose name it bears.
///
/// # Errors
/// Where the rig or the diagnosis fails.
pub fn run(
    seed: u64,
    number: usize,
    most_conditions: usize,
    (wanted, own): (&Wanted, &[CandidateEffect]),
) -> anyhow::Result<Opened> {
    let (key, list) = draw(seed, number, most_conditions, wanted);
    let of_data = seed.wrapping_mul(1_000_003).wrapping_add(number as u64);
    let dataset = data(&key, &list, of_data).map_err(|e| anyhow!(e))?;
    let model = default_model();
    let report = diagnose(&dataset, &model, own, &())?;
    let mut each_alone = Vec::new();
    if key.class == Class::Two {
        for effect in &key.effects {
            let mut alone = key.clone();
            alone.effects = vec![*effect];
            let misfit = base_misfit(&data(&alone, &list, of_data).map_err(|e| anyhow!(e))?, &model)?;
            each_alone.push([misfit.error, misfit.perfect_model]);
        }
    }
    Ok(open(Truth::from(&key), &report, each_alone))
}
