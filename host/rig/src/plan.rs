//! Plans: which conditions a data set holds, and in which order its trials are run.
//!
//! A plan is run through as often as there are runs, so that repetitions of a condition lie
//! a whole pass apart and slow changes (wear) show as a difference between them.

use rand::Rng;
use rand_chacha::ChaCha8Rng;

use super::condition::{Condition, Primitive, Scenario};
use super::reality::stream;

/// The plans by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum PlanName {
    /// The paper's whole grid: 2,760 trials of linear pushing, pivoting and rolling
    Paper,
    /// 18 conditions of linear pushing
    PushSmall,
    /// 18 conditions of pivoting
    PivotSmall,
    /// 6 conditions of rolling
    RollSmall,
    /// Lifts: steady ones, and each way of losing an object
    Lift,
    /// 60 lifts whose grip decays at all speeds, to where the object slips or short of it
    Decay,
    /// 27 conditions of pushing a triangle over a table with a rod
    Planar,
    /// Hours of lifting and pushing, mostly without any unexpected slip
    SlipHours,
    /// Three short trials: push, pivot and roll
    Demo,
}

/// The paper's grid of linear pushes.
const PUSH_GRIPS_N: [f64; 7] = [20.0, 22.0, 25.0, 27.0, 30.0, 32.0, 35.0];
const PUSH_SPEEDS_MM_S: [f64; 4] = [10.0, 15.0, 20.0, 25.0];
const PUSH_SLOPES_DEG: [f64; 5] = [-20.0, -10.0, 0.0, 10.0, 20.0];

impl PlanName {
    /// Runs of each condition where the user does not say.
    pub fn usual_runs(self) -> usize {
        match self {
            Self::Demo | Self::SlipHours | Self::Lift | Self::Decay => 1,
            _ => 3,
        }
    }
}

/// The conditions of a plan. `objects` restricts and replaces its objects where it is not
/// empty; `seed` and `hours` only matter to the plans that draw their conditions.
pub fn conditions(name: PlanName, objects: &[String], seed: u64, hours: f64) -> Vec<Condition> {
    let of = |usual: &[&str]| -> Vec<String> {
        match objects {
            [] => usual.iter().map(|o| (*o).to_string()).collect(),
            _ => objects.to_vec(),
        }
    };
    let restricted = |usual: &[&str]| -> Vec<String> {
        let usual = usual.iter().map(|o| (*o).to_string());
        usual.filter(|o| objects.is_empty() || objects.contains(o)).collect()
    };
    match name {
        PlanName::Paper => {
            let mut all = pushes(
                &restricted(&["obj3", "obj4", "obj5"]),
                &PUSH_GRIPS_N,
                &PUSH_SPEEDS_MM_S,
                &PUSH_SLOPES_DEG,
            );
            all.extend(pivots(
                &restricted(&["obj4", "obj5"]),
                &PUSH_GRIPS_N,
                &[2.5, 5.0, 10.0, 15.0, 20.0],
                &[0.0, 5.0, 10.0, 15.0, 20.0, 25.0],
            ));
            all.extend(rolls(
                &restricted(&["obj1", "obj2"]),
                &[3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0],
                &[5.0, 10.0, 15.0, 20.0, 25.0],
            ));
            all
        }
        PlanName::PushSmall => {
            pushes(&of(&["obj4"]), &[20.0, 27.0, 35.0], &[10.0, 20.0], &[-10.0, 0.0, 10.0])
        }
        PlanName::PivotSmall => pivots(&of(&["obj4"]), &[20.0, 27.0, 35.0], &[5.0, 10.0, 20.0], &[0.0, 15.0]),
        PlanName::RollSmall => rolls(&of(&["obj1"]), &[2.0, 3.5, 5.0], &[10.0, 20.0]),
        PlanName::Lift => lifts(&of(&["obj4", "obj5", "obj3"]), seed),
        PlanName::Decay => decays(&of(&["obj1", "obj2", "obj3", "obj4", "obj5"]), seed),
        PlanName::Planar => planar(&of(&["tri"])),
        PlanName::SlipHours => slip_hours(&of(&["obj1", "obj2", "obj3", "obj4", "obj5"]), seed, hours),
        PlanName::Demo => demo(),
    }
}

/// The trials in the order in which they are run, with their share of wear and run number.
pub fn trials(conditions: &[Condition], runs: usize) -> Vec<(Condition, usize)> {
    let distance = |c: &Condition| match c.primitive {
        // A turn wears at two thirds of the patch radius.
        Primitive::Pivot => c.travel * 0.0067,
        Primitive::Lift => 0.0,
        _ => c.travel,
    };
    let whole = conditions.iter().map(distance).sum::<f64>() * runs as f64;
    let mut done = 0.0;
    let mut list = Vec::with_capacity(conditions.len() * runs);
    for run in 1..=runs {
        for condition in conditions {
            let worn = if whole > 0.0 { done / whole } else { 0.0 };
            list.push((Condition { worn, ..condition.clone() }, run));
            done += distance(condition);
        }
    }
    list
}

fn pushes(objects: &[String], grips: &[f64], speeds_mm_s: &[f64], slopes_deg: &[f64]) -> Vec<Condition> {
    let mut all = Vec::new();
    for object in objects {
        for grip in grips {
            for speed in speeds_mm_s {
                for slope in slopes_deg {
                    all.push(Condition {
                        label: format!("linear_push-{object}-g{grip}-v{speed}-s{slope}"),
                        grip_n: *grip,
                        speed_m_s: speed / 1e3,
                        slope_rad: slope.to_radians(),
                        ..Condition::new(Primitive::LinearPush, object)
                    });
                }
            }
        }
    }
    all
}

/// Pivots last equally long at all speeds, so the angle grows with the speed.
fn pivots(objects: &[String], grips: &[f64], speeds_deg_s: &[f64], offsets_mm: &[f64]) -> Vec<Condition> {
    let mut all = Vec::new();
    for object in objects {
        for grip in grips {
            for speed in speeds_deg_s {
                for offset in offsets_mm {
                    all.push(Condition {
                        label: format!("pivot-{object}-g{grip}-w{speed}-o{offset}"),
                        grip_n: *grip,
                        speed_rad_s: speed.to_radians(),
                        travel: speed.to_radians() * PIVOT_TIME_S,
                        pusher_offset_m: offset / 1e3,
                        ..Condition::new(Primitive::Pivot, object)
                    });
                }
            }
        }
    }
    all
}

/// How long the gripper turns in the paper's plan, s.
const PIVOT_TIME_S: f64 = 2.4;

fn rolls(objects: &[String], grips: &[f64], speeds_mm_s: &[f64]) -> Vec<Condition> {
    let mut all = Vec::new();
    for object in objects {
        for grip in grips {
            for speed in speeds_mm_s {
                all.push(Condition {
                    label: format!("roll-{object}-g{grip}-v{speed}"),
                    grip_n: *grip,
                    speed_m_s: speed / 1e3,
                    ..Condition::new(Primitive::Roll, object)
                });
            }
        }
    }
    all
}

fn planar(objects: &[String]) -> Vec<Condition> {
    let mut all = Vec::new();
    for object in objects {
        for edge in 0..3 {
            for offset in [-5.0, 0.0, 5.0] {
                for slope in [-15.0_f64, 0.0, 15.0] {
                    all.push(Condition {
                        label: format!("planar_push-{object}-e{edge}-o{offset}-s{slope}"),
                        edge,
                        pusher_offset_m: offset / 1e3,
                        slope_rad: slope.to_radians(),
                        speed_m_s: 0.02,
                        ..Condition::new(Primitive::PlanarPush, object)
                    });
                }
            }
        }
    }
    all
}

fn demo() -> Vec<Condition> {
    let push = pushes(&["obj4".into()], &[20.0], &[10.0], &[0.0]);
    let short = |c: Condition, travel: f64| Condition { travel, ..c };
    let pivot = pivots(&["obj4".into()], &[20.0], &[10.0], &[15.0]);
    let roll = rolls(&["obj1".into()], &[3.0], &[15.0]);
    let pivot = pivot.into_iter().map(|c| short(c, 0.2));
    push.into_iter().chain(pivot).chain(roll).collect()
}

/// A lift with a grip that holds `margin` times what plain friction of 0.4 needs.
fn lift(object: &str, margin: f64, hold_s: f64) -> Condition {
    let weight =
        super::objects::catalogue().iter().find(|o| o.id == object).map_or(2.0, |o| o.mass_kg * 9.81);
    Condition {
        grip_n: (margin * weight / (2.0 * 0.4) * 10.0).round() / 10.0,
        speed_m_s: 0.06,
        hold_s,
        ..Condition::new(Primitive::Lift, object)
    }
}

fn lifts(objects: &[String], seed: u64) -> Vec<Condition> {
    let mut rng = stream(seed, "lifts");
    let mut all = Vec::new();
    for object in objects {
        for margin in [1.6, 2.5] {
            let steady = lift(object, margin, 4.0);
            for (name, scenario) in scenarios(&steady, margin, &mut rng) {
                let label = format!("lift-{object}-m{margin}-{name}");
                all.push(Condition { label, scenario, ..steady.clone() });
            }
        }
    }
    for (i, c) in all.iter_mut().enumerate() {
        // The name of a trial must not tell what happens in it.
        c.label = format!("lift-{:03}", i + 1);
    }
    all
}

/// Lifts whose grip decays within half a second to eight, to half of what friction of 0.4 needs
/// or up to a quarter more than that.
fn decays(objects: &[String], seed: u64) -> Vec<Condition> {
    let mut rng = stream(seed, "decays");
    (1..=60)
        .map(|i| {
            let object = &objects[rng.random_range(0..objects.len())];
            let margin = rng.random_range(1.5..3.0);
            let steady = lift(object, margin, 10.0);
            let from_s = 0.2 + steady.travel / steady.speed_m_s + rng.random_range(0.4..1.4);
            let scenario = Scenario::DecayingGrip {
                share: rng.random_range(0.5..1.25) / margin,
                from_s,
                until_s: from_s + 0.5 * 16.0_f64.powf(rng.random_range(0.0..1.0)),
            };
            Condition { label: format!("lift-{i:03}"), scenario, ..steady }
        })
        .collect()
}

/// One of each scenario for a lift that holds `margin` times what it needs.
fn scenarios(lift: &Condition, margin: f64, rng: &mut ChaCha8Rng) -> Vec<(&'static str, Scenario)> {
    let needed_n = 2.0 * 0.4 * lift.grip_n / margin;
    let held_s = 0.2 + lift.travel / lift.speed_m_s + 0.4;
    let at_s = held_s + rng.random_range(0.0..0.3 * lift.hold_s);
    let down = |share: f64| [0.0, 0.0, -share * needed_n];
    vec![
        ("steady", Scenario::Steady),
        (
            "decaying",
            Scenario::DecayingGrip {
                share: 0.6 / margin,
                from_s: at_s,
                until_s: at_s + rng.random_range(0.5..1.0) * 0.5 * lift.hold_s,
            },
        ),
        ("load", Scenario::SuddenLoad { force_n: down(margin * rng.random_range(1.1..1.5)), at_s }),
        ("held_load", Scenario::SuddenLoad { force_n: down((margin - 1.0) * 0.5), at_s }),
        (
            "bumps",
            Scenario::Bumps { force_n: down((margin - 1.0) * rng.random_range(0.4..2.0)), from_s: at_s },
        ),
        ("creep", Scenario::SoftCreep { rate_m_n_s: rng.random_range(1e-4..4e-4) }),
        ("heavier", Scenario::HeavierThanTold { factor: margin * rng.random_range(0.8..1.6) }),
        ("off_centre", Scenario::OffCentre { offset_m: rng.random_range(0.004..0.02) }),
        ("drop", Scenario::FrictionDrop { share: rng.random_range(0.5..0.9) / margin, at_s }),
    ]
}

fn slip_hours(objects: &[String], seed: u64, hours: f64) -> Vec<Condition> {
    let mut rng = stream(seed, "slip-hours");
    let mut left_s = hours * 3600.0;
    let mut all: Vec<Condition> = Vec::new();
    while left_s > 0.0 && !objects.is_empty() {
        let object = &objects[rng.random_range(0..objects.len())];
        let kind = rng.random_range(0.0..1.0);
        let condition = if kind < 0.75 {
            let margin = rng.random_range(1.5..3.0);
            let steady = lift(object, margin, rng.random_range(10.0..30.0));
            let eventful = rng.random_range(0.0..1.0) < 0.2;
            let mut happenings = scenarios(&steady, margin, &mut rng);
            let which = rng.random_range(1..happenings.len());
            let scenario = if eventful { happenings.swap_remove(which).1 } else { Scenario::Steady };
            left_s -= steady.hold_s + 1.5;
            Condition { scenario, ..steady }
        } else {
            let mut of = |values: &[f64]| values[rng.random_range(0..values.len())];
            let (speed, grip_n) = (of(&PUSH_SPEEDS_MM_S) / 1e3, of(&PUSH_GRIPS_N));
            let slope_rad = of(&PUSH_SLOPES_DEG).to_radians();
            let scenario = match kind {
                k if k > 0.96 => Scenario::Jam { mu_pusher: rng.random_range(0.7..1.2) },
                _ => Scenario::Steady,
            };
            left_s -= 0.5 + 0.015 / speed;
            Condition {
                grip_n,
                speed_m_s: speed,
                slope_rad,
                scenario,
                ..Condition::new(Primitive::LinearPush, object)
            }
        };
        let label = format!("{}-{:05}", condition.primitive.name(), all.len() + 1);
        all.push(Condition { label, ..condition });
    }
    all
}
