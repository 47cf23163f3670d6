//! Families: named groups of pads, friction laws, jaws and plans, drawn from within wide ranges.

use serde::Serialize;

use crate::physics::friction::Kind;
use crate::plan::bench::Primitive::{self, Lift, LinearPush, Pivot, PlanarPush, Roll};
use crate::plan::grasps::{self, Weight};

/// What kind of data set.
#[derive(Clone, Copy, Debug, Serialize)]
pub enum Plan {
    /// Hidden effects: one of these sets of primitives.
    Bench(&'static [&'static [Primitive]]),
    /// Warnings: scenarios with weights.
    Grasps(&'static [Weight]),
}

/// A named group.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Family {
    /// Name.
    pub name: &'static str,
    /// One line.
    pub what: &'static str,
    /// Data set.
    pub plan: Plan,
    /// Tangential stiffness of a pad, N/m, log-uniform.
    pub shear_n_m: [f64; 2],
    /// Damping ratio, log-uniform.
    pub damping: [f64; 2],
    /// Friction laws.
    pub kinds: &'static [Kind],
    /// Probability that pads relax (Zener).
    pub relaxes: f64,
    /// Probability that bristles' stiffness goes with the load.
    pub per_load: f64,
    /// Probability that the jaw lags and sticks noticeably.
    pub poor_jaw: f64,
    /// Probability of poor sensors: drift, coloured noise, rare poses, nothing stated.
    pub poor_sensors: f64,
}

const EVERY: &[Kind] = &[Kind::Dahl, Kind::LuGre, Kind::ElastoPlastic];
const PUSH_PIVOT: &[&[Primitive]] = &[&[LinearPush, Pivot], &[LinearPush, Pivot], &[LinearPush], &[Pivot]];

const BENCH: Family = Family {
    name: "bench-wide",
    what: "pushes and pivots; pads, laws, jaws and sensors from the whole range",
    plan: Plan::Bench(PUSH_PIVOT),
    shear_n_m: [5e3, 2e6],
    damping: [0.05, 1.0],
    kinds: EVERY,
    relaxes: 0.4,
    per_load: 0.3,
    poor_jaw: 0.3,
    poor_sensors: 0.3,
};

const GRASPS: Family = Family {
    name: "grasp-wide",
    what: "all scenarios; pads, laws, jaws and sensors from the whole range",
    plan: Plan::Grasps(grasps::ALL),
    ..BENCH
};

/// All families.
pub static FAMILIES: &[Family] = &[
    Family {
        name: "bench-hard",
        what: "pushes and pivots on pads of 300 to 2,000 N/mm, Kelvin-Voigt, good jaw and sensors",
        shear_n_m: [3e5, 2e6],
        kinds: &[Kind::LuGre, Kind::Dahl],
        relaxes: 0.0,
        poor_jaw: 0.0,
        poor_sensors: 0.0,
        ..BENCH
    },
    Family {
        name: "bench-medium",
        what: "pushes and pivots on pads of 60 to 300 N/mm, every law",
        shear_n_m: [6e4, 3e5],
        ..BENCH
    },
    Family {
        name: "bench-soft",
        what: "pushes and pivots on pads of 5 to 60 N/mm, every law",
        shear_n_m: [5e3, 6e4],
        ..BENCH
    },
    Family {
        name: "bench-creep",
        what: "pushes and pivots on pads that relax (Zener), elasto-plastic bristles",
        shear_n_m: [2e4, 1e6],
        kinds: &[Kind::ElastoPlastic],
        relaxes: 1.0,
        ..BENCH
    },
    Family {
        name: "bench-poor-jaw",
        what: "pushes and pivots with a jaw that lags and sticks, stiffness in proportion to load",
        per_load: 1.0,
        poor_jaw: 1.0,
        ..BENCH
    },
    Family {
        name: "bench-poor-sensors",
        what: "pushes and pivots; drift, coloured noise, clock offset, poses at 60 or 120 Hz, nothing stated",
        poor_sensors: 1.0,
        ..BENCH
    },
    Family {
        name: "bench-roll",
        what: "a cylinder rolled over a platform",
        plan: Plan::Bench(&[&[Roll]]),
        ..BENCH
    },
    Family {
        name: "bench-lift",
        what: "lifts and pushes of the same objects",
        plan: Plan::Bench(&[&[LinearPush, Lift], &[Lift]]),
        ..BENCH
    },
    Family {
        name: "bench-planar",
        what: "a block pushed over a table with a rod",
        plan: Plan::Bench(&[&[PlanarPush]]),
        ..BENCH
    },
    BENCH,
    Family {
        name: "grasp-hard",
        what: "all scenarios on pads of 300 to 2,000 N/mm",
        shear_n_m: [3e5, 2e6],
        ..GRASPS
    },
    Family {
        name: "grasp-medium",
        what: "all scenarios on pads of 50 to 300 N/mm",
        shear_n_m: [5e4, 3e5],
        ..GRASPS
    },
    Family {
        name: "grasp-soft",
        what: "all scenarios on pads of 5 to 50 N/mm",
        shear_n_m: [5e3, 5e4],
        ..GRASPS
    },
    Family {
        name: "grasp-underdamped",
        what: "all scenarios, damping ratio of 0.05 to 0.15: the grasp rings",
        damping: [0.05, 0.15],
        ..GRASPS
    },
    Family {
        name: "grasp-creep",
        what: "all scenarios on pads that relax, bristles that creep under oscillation (LuGre)",
        kinds: &[Kind::LuGre],
        relaxes: 1.0,
        shear_n_m: [5e3, 3e5],
        ..GRASPS
    },
    Family {
        name: "grasp-shaken",
        what: "motion, knocks and disturbed holds",
        plan: Plan::Grasps(grasps::SHAKEN),
        ..GRASPS
    },
    Family {
        name: "grasp-wet",
        what: "friction that falls, masses that grow",
        plan: Plan::Grasps(grasps::WET),
        ..GRASPS
    },
    Family {
        name: "grasp-poor-sensors",
        what: "all scenarios; drift, coloured noise, late and rare poses, jaw that lags",
        poor_sensors: 1.0,
        poor_jaw: 1.0,
        ..GRASPS
    },
    GRASPS,
];

impl Family {
    /// The family of this name.
    pub fn named(name: &str) -> Option<&'static Family> {
        FAMILIES.iter().find(|f| f.name == name)
    }
}
