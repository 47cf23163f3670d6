//! What the blind test hides: effects, strengths, nuisance, plan and noise, all from one
//! seed; and the data that the rig's independent reality makes of it.

use rand::Rng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use crate::dataset::Dataset;
use crate::rig::condition::{Condition, Primitive};
use crate::rig::plan::{PlanName, conditions, trials};
use crate::rig::reality::stream;
use crate::rig::{HiddenEffect, Kind, Nuisance, Reality, STEP_S, Setup, objects, simulate};

/// How many effects of which kind are hidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    /// Nothing.
    Nothing,
    /// One effect of the list.
    One,
    /// Two effects of the list.
    Two,
    /// One that is not in the list.
    Unknown,
}

/// What is hidden.
#[derive(Clone, Debug, Serialize)]
pub struct Key {
    /// How many of which kind.
    pub class: Class,
    /// The effects with their strengths.
    pub effects: Vec<HiddenEffect>,
    /// Variation and errors.
    pub nuisance: Nuisance,
    /// Primitive of the plan.
    pub primitive: &'static str,
    /// Trials made.
    pub trials: usize,
}

/// Plans that the test draws from; each is small.
const PLANS: [(PlanName, Primitive); 3] = [
    (PlanName::PushSmall, Primitive::LinearPush),
    (PlanName::PivotSmall, Primitive::Pivot),
    (PlanName::RollSmall, Primitive::Roll),
];

/// Draws the key of run `number`, and the conditions and runs of its plan.
pub fn draw(seed: u64, number: usize, most_conditions: usize) -> (Key, Vec<(Condition, usize)>) {
    let mut rng = stream(seed, &format!("blind-{number}"));
    let class = match rng.random_range(0..20) {
        0..4 => Class::Nothing,
        4..13 => Class::One,
        13..16 => Class::Two,
        _ => Class::Unknown,
    };
    let kinds: Vec<Kind> =
        Kind::ALL.iter().copied().filter(|k| k.is_listed() == (class != Class::Unknown)).collect();
    let count = match class {
        Class::Nothing => 0,
        Class::One | Class::Unknown => 1,
        Class::Two => 2,
    };
    let effects: Vec<HiddenEffect> = pick(&kinds, count, &mut rng)
        .into_iter()
        .map(|kind| HiddenEffect { kind, strength: kind.typical_strength() * rng.random_range(0.8..2.0) })
        .collect();
    let nuisance = Nuisance {
        friction_run: rng.random_range(0.005..0.03),
        bias: rng.random_range(0.0..0.9),
        noise: rng.random_range(0.5..1.5),
        ..Nuisance::PAPER
    };
    // What shows only while rolling or pushing is hidden only there.
    let fits = |p: Primitive| {
        effects.iter().all(|e| match e.kind {
            Kind::RollingResistance => p == Primitive::Roll,
            Kind::PlateTilt | Kind::PusherHeight => p == Primitive::LinearPush,
            _ => p != Primitive::Roll,
        })
    };
    let plans: Vec<_> = PLANS.iter().filter(|p| fits(p.1)).collect();
    let (plan, primitive) = match plans.len() {
        0 => PLANS[0],
        n => *plans[rng.random_range(0..n)],
    };
    let mut all = conditions(plan, &[], seed, 1.0);
    all.shuffle(&mut rng);
    all.truncate(rng.random_range(most_conditions.div_ceil(2).max(6)..=most_conditions.max(6)));
    let runs = rng.random_range(2..=3);
    let list = trials(&all, runs);
    let key = Key { class, effects, nuisance, primitive: primitive.name(), trials: list.len() };
    (key, list)
}

fn pick(kinds: &[Kind], count: usize, rng: &mut ChaCha8Rng) -> Vec<Kind> {
    let mut kinds = kinds.to_vec();
    kinds.shuffle(rng);
    kinds.truncate(count);
    kinds
}

/// The data of a key.
///
/// # Errors
/// Where the rig refuses a condition.
pub fn data(key: &Key, list: &[(Condition, usize)], seed: u64) -> Result<Dataset, String> {
    use rayon::prelude::*;
    let bench = objects::bench("blind");
    let mut reality = Reality::draw(&bench, key.nuisance, seed);
    reality.effects.clone_from(&key.effects);
    let setup = Setup { description: bench.clone(), reality, step_s: STEP_S };
    let trials =
        list.par_iter().map(|(c, run)| simulate(&setup, c, *run, seed)).collect::<Result<Vec<_>, _>>()?;
    Ok(Dataset { folder: "blind".into(), description: bench, trials })
}
