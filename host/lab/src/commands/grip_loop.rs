//! `stickslip-lab grip-loop`: drops prevented by the advised grip, on the rig.

use std::collections::BTreeMap;

use serde::Serialize;
use stickslip_cli::grip_loop::{Options, Pair, run as trials};
use stickslip_report::terminal::{Output, table};
use stickslip_rig::plan::PlanName;
use stickslip_shared::wire::{GripLimits, check};

/// Command line of `stickslip-lab grip-loop`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip-lab grip-loop
  stickslip-lab grip-loop --plan decay --seeds 3,4 --no-pose

Each trial is run twice from the same seed: with the planned grip, and with the grip that the predictor's
advice commands.")]
pub struct Args {
    /// Plan of the rig: lift or decay
    #[arg(long, value_enum, default_value = "lift")]
    pub plan: PlanName,
    /// Seeds of plan, reality and runs
    #[arg(long, value_delimiter = ',', default_value = "1,2")]
    pub seeds: Vec<u64>,
    /// Hide the object's pose after the first sample, as on a unit without a camera
    #[arg(long)]
    pub no_pose: bool,
    /// Largest grip that may be advised, N
    #[arg(long, value_name = "N", default_value_t = 60.0)]
    pub most: f32,
    /// Fastest rise of the grip, N/s
    #[arg(long, value_name = "N/S", default_value_t = 200.0)]
    pub rise: f32,
}

/// Trials of one scenario.
#[derive(Clone, Debug, Default, Serialize)]
struct Row {
    scenario: &'static str,
    trials: usize,
    kept_open: usize,
    kept_closed: usize,
    /// Kept with the planned grip, lost with the advised one.
    made_worse: usize,
    /// Largest slip of a kept object in the grasp, m.
    slid_open_m: f64,
    slid_closed_m: f64,
    /// Largest force of a finger over the planned one: mean and most.
    peak_mean: f64,
    peak_most: f64,
}

/// # Errors
/// Limits that are none; a trial that cannot be run.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let limits = GripLimits { most_n: args.most, rise_n_s: args.rise, ..GripLimits::default() };
    check::grip_limits(&limits).map_err(|refusal| anyhow::anyhow!("--most, --rise: {refusal:?}"))?;
    let mut rows: BTreeMap<&'static str, Row> = BTreeMap::new();
    let mut all: Vec<Pair> = Vec::new();
    for seed in &args.seeds {
        let options =
            Options { plan: args.plan, objects: vec![], seed: *seed, sees_object: !args.no_pose, limits };
        all.extend(trials(&options)?.into_iter().map(|trial| trial.pair));
    }
    for pair in &all {
        for name in [pair.scenario, "all"] {
            let row = rows.entry(name).or_insert_with(|| Row { scenario: name, ..Row::default() });
            row.trials += 1;
            row.kept_open += usize::from(pair.open.kept);
            row.kept_closed += usize::from(pair.closed.kept);
            row.made_worse += usize::from(pair.open.kept && !pair.closed.kept);
            row.slid_open_m = row.slid_open_m.max(pair.open.slid_m);
            row.slid_closed_m = row.slid_closed_m.max(pair.closed.slid_m);
            let peak = pair.closed.peak_n / pair.planned_n;
            row.peak_mean += (peak - row.peak_mean) / row.trials as f64;
            row.peak_most = row.peak_most.max(peak);
        }
    }
    let mut shown = table([
        "scenario",
        "trials",
        "kept, planned",
        "kept, advised",
        "worse",
        "slid, planned",
        "slid, advised",
        "peak grip, mean",
        "most",
    ]);
    for row in rows.values() {
        shown.add_row([
            row.scenario.to_owned(),
            row.trials.to_string(),
            row.kept_open.to_string(),
            row.kept_closed.to_string(),
            row.made_worse.to_string(),
            format!("{:.1} mm", row.slid_open_m * 1e3),
            format!("{:.1} mm", row.slid_closed_m * 1e3),
            format!("{:.2} x", row.peak_mean),
            format!("{:.2} x", row.peak_most),
        ]);
    }
    output.table(&shown);
    output.document(&serde_json::json!({ "rows": rows.values().collect::<Vec<_>>(), "trials": all }))
}
