//! What the blind test hides: effects, strengths, nuisance, plan and noise, all from one
//! seed; and the data that the rig's independent reality makes of it.

use rand::Rng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use stickslip_data::Dataset;
use stickslip_rig::condition::Condition;
use stickslip_rig::plan::{PlanName, conditions, trials};
use stickslip_rig::reality::stream;
use stickslip_rig::{HiddenEffect, Kind, Nuisance, Reality, STEP_S, Setup, objects, simulate};

/// How many effects of which kind are hidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    /// Nothing
    Nothing,
    /// One effect of the list
    One,
    /// Two effects of the list
    Two,
    /// One that is not in the list
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
    /// Stiffness of pads and contact surfaces, N/m.
    pub stiffness_n_m: f64,
    /// Plan.
    pub plan: Plan,
    /// Trials made.
    pub trials: usize,
}

/// Which primitives a data set holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Plan {
    /// Linear pushing
    Push,
    /// Pivoting
    Pivot,
    /// Linear pushing and pivoting
    Mixed,
    /// Rolling
    Roll,
}

impl Plan {
    const ALL: [Plan; 4] = [Plan::Push, Plan::Pivot, Plan::Mixed, Plan::Roll];

    fn conditions(self, seed: u64) -> Vec<Condition> {
        let of = |name| conditions(name, &[], seed, 1.0);
        match self {
            Plan::Push => of(PlanName::PushSmall),
            Plan::Pivot => of(PlanName::PivotSmall),
            Plan::Roll => of(PlanName::RollSmall),
            Plan::Mixed => [of(PlanName::PushSmall), of(PlanName::PivotSmall)].concat(),
        }
    }

    /// What shows only while rolling or pushing is hidden only there.
    fn shows(self, kind: Kind) -> bool {
        match kind {
            Kind::RollingResistance => self == Plan::Roll,
            Kind::PlateTilt | Kind::PusherHeight => matches!(self, Plan::Push | Plan::Mixed),
            _ => self != Plan::Roll,
        }
    }
}

/// Hidden only where it is asked for: what a seed draws stays what it was when this came into the rig.
const BY_NAME: [Kind; 1] = [Kind::ExternalForce];

/// What is not left to chance.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// These effects, where not empty.
    pub effects: Vec<HiddenEffect>,
    /// How many effects of which kind.
    pub class: Option<Class>,
    /// This plan.
    pub plan: Option<Plan>,
    /// Multiple of the typical strength.
    pub strength: Option<f64>,
}

/// Draws the key of run `number`, and the conditions and runs of its plan.
pub fn draw(
    seed: u64,
    number: usize,
    most_conditions: usize,
    wanted: &Wanted,
) -> (Key, Vec<(Condition, usize)>) {
    let mut rng = stream(seed, &format!("blind-{number}"));
    let drawn = match rng.random_range(0..20) {
        0..4 => Class::Nothing,
        4..13 => Class::One,
        13..16 => Class::Two,
        _ => Class::Unknown,
    };
    let class = wanted.class.unwrap_or(drawn);
    let kinds: Vec<Kind> = Kind::ALL
        .iter()
        .copied()
        .filter(|k| k.is_listed() == (class != Class::Unknown) && !BY_NAME.contains(k))
        .filter(|k| wanted.plan.is_none_or(|p| p.shows(*k)))
        .collect();
    let count = match class {
        Class::Nothing => 0,
        Class::One | Class::Unknown => 1,
        Class::Two => 2,
    };
    let mut effects: Vec<HiddenEffect> = pick(&kinds, count, &mut rng)
        .into_iter()
        .map(|kind| {
            let share = rng.random_range(0.8..2.0);
            HiddenEffect { kind, strength: kind.typical_strength() * wanted.strength.unwrap_or(share) }
        })
        .collect();
    let class = match wanted.effects.as_slice() {
        [] => class,
        given => {
            effects = given.to_vec();
            match given {
                [one] if !one.kind.is_listed() => Class::Unknown,
                [_] => Class::One,
                _ => Class::Two,
            }
        }
    };
    let nuisance = Nuisance {
        friction_run: rng.random_range(0.005..0.03),
        bias: rng.random_range(0.0..0.9),
        noise: rng.random_range(0.5..1.5),
        ..Nuisance::PAPER
    };
    // Pads from soft rubber of 40 um under 20 N to practically rigid.
    let stiffness_n_m = 10.0_f64.powf(rng.random_range(5.7..6.7));
    let plans: Vec<Plan> =
        Plan::ALL.into_iter().filter(|p| effects.iter().all(|e| p.shows(e.kind))).collect();
    let plan = match (wanted.plan, plans.len()) {
        (Some(plan), _) => plan,
        (None, 0) => Plan::Mixed,
        (None, n) => plans[rng.random_range(0..n)],
    };
    let mut all = plan.conditions(seed);
    all.shuffle(&mut rng);
    all.truncate(rng.random_range(most_conditions.div_ceil(2).max(6)..=most_conditions.max(6)));
    let runs = rng.random_range(2..=3);
    let list = trials(&all, runs);
    let key = Key { class, effects, nuisance, stiffness_n_m, plan, trials: list.len() };
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
    reality.stiffness_n_m = key.stiffness_n_m;
    let setup = Setup { description: bench.clone(), reality, step_s: STEP_S };
    let trials =
        list.par_iter().map(|(c, run)| simulate(&setup, c, *run, seed)).collect::<Result<Vec<_>, _>>()?;
    Ok(Dataset { folder: "blind".into(), description: bench, trials })
}
