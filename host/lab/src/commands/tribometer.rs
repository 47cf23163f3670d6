//! `stickslip-lab tribometer DATA`: rigid friction, and a spring before it, on one contact's record.

use std::path::PathBuf;

use anyhow::{Context, bail};

use crate::tribometer::study;
use stickslip_report::terminal::{Output, table};

/// Arguments of `stickslip-lab tribometer`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  stickslip import tribometer test_data_2.txt --out data/tribometer
  stickslip-lab tribometer data/tribometer")]
pub struct Args {
    /// Folder of the data set (holds dataset.toml)
    pub data: PathBuf,
}

/// Fits both laws and prints their errors.
///
/// # Errors
/// Where the data cannot be read, or hold no record of position and force.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let data = stickslip_report::data::read(&args.data, output)?;
    let Some(trial) = data.trials.first() else { bail!("{}: no trials", args.data.display()) };
    let study = study(trial).with_context(|| {
        let name = &trial.info.trial;
        format!("trial {name} has no record of the gripper's position and finger 1's force")
    })?;
    output.text(format_args!(
        "{} samples under {:.2} N; friction {:.2} N (root mean square)",
        study.samples, study.load_n, study.signal_n
    ));
    let mut shown = table(["law", "mu", "stiffness N/mm", "rms error N"]);
    shown.add_row([
        "rigid Coulomb".to_owned(),
        format!("{:.2}", study.rigid_mu),
        "-".into(),
        format!("{:.2}", study.rigid_rms_n),
    ]);
    shown.add_row([
        "spring and slider".to_owned(),
        format!("{:.2}", study.slider_mu),
        format!("{:.1}", 1e-3 * study.stiffness_n_m),
        format!("{:.2}", study.slider_rms_n),
    ]);
    output.table(&shown);
    output.text(format_args!(
        "after a reversal friction is back at 90 % after {:.3} mm (median of {})",
        1e3 * study.travel_m,
        study.reversals
    ));
    output.document(&study)
}
