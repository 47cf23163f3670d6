//! How often the intervals of `calibrate` hold the truth: small rigs whose friction is drawn
//! anew for each seed, for each primitive. Prints the share of seeds in which the interval
//! (or the bound, where a coefficient is only bounded) holds the rig's coefficient.
//!
//! `cargo run --release -p stickslip-lab --example calibration_coverage [SEEDS [SHARE [PRIMITIVE [FIRST]]]]`

use stickslip_analysis::calibrate::{Coefficient, Share, name, of_primitive};
use stickslip_analysis::model::file::default_model;
use stickslip_rig::plan::{PlanName, conditions, trials};
use stickslip_rig::{self, Nuisance, Reality, STEP_S, Setup, objects};

/// Determined, interval holds the truth, width, error.
type Covered = (bool, bool, f64, f64);

fn main() -> anyhow::Result<()> {
    let mut words = std::env::args().skip(1);
    let seeds: u64 = words.next().map_or(Ok(20), |w| w.parse())?;
    let share: f64 = words.next().map_or(Ok(0.1), |w| w.parse())?;
    let only = words.next();
    let plans = [
        ("linear_push", PlanName::PushSmall),
        ("pivot", PlanName::PivotSmall),
        ("roll", PlanName::RollSmall),
    ];
    println!(
        "| primitive | coefficient | determined | interval holds the truth | median width | rms error |"
    );
    println!("|---|---|---|---|---|---|");
    let first: u64 = words.next().map_or(Ok(1), |w| w.parse())?;
    for (primitive, plan) in plans.into_iter().filter(|p| only.as_ref().is_none_or(|o| o == p.0)) {
        let mut seen: Vec<(Coefficient, Vec<Covered>)> = Vec::new();
        for seed in first..first + seeds {
            let description = objects::bench("coverage");
            let reality = Reality::draw(&description, Nuisance::PAPER, seed);
            let truth = (reality.mu_finger, reality.mu_pusher, reality.mu_platform);
            let setup = Setup { description, reality, step_s: STEP_S };
            let list = trials(&conditions(plan, &[], seed, 0.0), 1);
            let recorded = list
                .iter()
                .enumerate()
                .map(|(at, (condition, run))| {
                    stickslip_rig::simulate(&setup, condition, *run, seed)
                        .map(|t| (at, t))
                        .map_err(anyhow::Error::msg)
                })
                .collect::<anyhow::Result<Vec<_>>>()?;
            let found =
                of_primitive(&setup.description, primitive, &recorded, &default_model(), Share::of(share))?;
            for e in &found.estimates {
                let truth = match e.coefficient {
                    Coefficient::Finger => truth.0,
                    Coefficient::Pusher => truth.1,
                    Coefficient::Support => truth.2,
                };
                let holds = e.low.is_none_or(|l| l <= truth) && e.high.is_none_or(|h| truth <= h);
                let width = match (e.low, e.high) {
                    (Some(l), Some(h)) => h / l - 1.0,
                    _ => f64::NAN,
                };
                let row = (e.determined, holds, width, e.value / truth - 1.0);
                match seen.iter_mut().find(|s| s.0 == e.coefficient) {
                    Some(s) => s.1.push(row),
                    None => seen.push((e.coefficient, vec![row])),
                }
                let bound = |b: Option<f64>| b.map_or_else(|| "-".into(), |b| format!("{b:.3}"));
                eprintln!(
                    "{primitive} seed {seed} {}: {:.3} [{}, {}] truth {truth:.3}{}{}",
                    name(e.coefficient),
                    e.value,
                    bound(e.low),
                    bound(e.high),
                    if e.determined { "" } else { " (bounded)" },
                    if holds { "" } else { "  MISSED" }
                );
            }
        }
        for (coefficient, rows) in seen {
            let determined: Vec<_> = rows.iter().filter(|r| r.0).collect();
            let mut widths: Vec<f64> = determined.iter().map(|r| r.2).collect();
            widths.sort_by(f64::total_cmp);
            let width = widths.get(widths.len() / 2).copied().unwrap_or(f64::NAN);
            let n = determined.len() as f64;
            let rms = (determined.iter().map(|r| r.3 * r.3).sum::<f64>() / n).sqrt();
            println!(
                "| {primitive} | {} | {} of {} | {} of {} | {:.1} % | {:.1} % |",
                name(coefficient),
                determined.len(),
                rows.len(),
                rows.iter().filter(|r| r.1).count(),
                rows.len(),
                100.0 * width,
                100.0 * rms
            );
        }
    }
    Ok(())
}
