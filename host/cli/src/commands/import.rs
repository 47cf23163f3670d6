//! `stickslip import`: recordings of others into the data set format.

use std::fs;
use std::path::Path;

use anyhow::Context;
use clap::Subcommand;
use schemars::JsonSchema;
use serde::Serialize;

use stickslip_data::import::{BadRow, cmu_push, tribometer};
use stickslip_data::{Dataset, Stage};
use stickslip_report::terminal::{Output, table};

use super::import_recording::{self, Files};

/// Arguments of `stickslip import`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    source: Source,
}

#[derive(Debug, Subcommand)]
enum Source {
    /// Any recording, by a mapping file that `stickslip new` begins
    #[command(
        after_help = "Example:\n  stickslip new raw/obj4_r1_ft.csv raw/obj4_r1_mocap.csv --out mapping.toml\n  \
                      stickslip import recording mapping.toml --out data/mine --html mine.html"
    )]
    Recording(import_recording::Args),
    /// Planar pushes of the CMU Manipulation Lab (MLab_EXP/PushExp/sensor_log)
    #[command(
        after_help = "Example:\n  stickslip import cmu-push patch__exp_08_18_1435_50.txt --out data/cmu_patch"
    )]
    CmuPush(CmuPushArgs),
    /// A tribometer's record: time s, normal uN, position mm, friction uN
    #[command(after_help = "Example:\n  stickslip import tribometer test_data_2.txt --out data/tribometer")]
    Tribometer(Files),
}

#[derive(Debug, clap::Args)]
struct CmuPushArgs {
    #[command(flatten)]
    files: Files,
    /// `patch`, or `a_b_c_d_e_f`: support points x = a,b,c and y = d,e,f in mm from the right
    /// corner [default: from the name of the file or its folder]
    #[arg(long)]
    support: Option<String>,
    /// Radius of the rod about the recorded robot point; the data give 0.05 +- 0.07 mm
    #[arg(long, default_value_t = 0.0, value_parser = not_negative)]
    tip_radius_m: f64,
}

fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && number >= 0.0 => Ok(number),
        _ => Err("a length in metres, zero or more".to_owned()),
    }
}

#[derive(JsonSchema, Serialize)]
/// Published measurements that were imported.
pub(super) struct Report<'r, V> {
    /// Folder of the data set.
    out: &'r Path,
    /// Trials.
    trials: usize,
    /// Rows of all trials.
    samples: usize,
    /// What physics says of the mapping.
    verification: &'r V,
    /// Rows that could not be used.
    bad_rows: &'r [BadRow],
}

/// Imports and prints what the physics of the data say about the mapping.
///
/// # Errors
/// A file that is not there or not of its kind, and what writing answers.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    match &args.source {
        Source::Recording(args) => import_recording::run(args, output),
        Source::CmuPush(args) => cmu(args, output),
        Source::Tribometer(files) => {
            let (text, name) = read(&files.file)?;
            let import =
                tribometer::import(&text, &name).with_context(|| files.file.display().to_string())?;
            let v = &import.verification;
            let [low, middle, high] = v.friction_share;
            let rows = [
                ("samples, of them loaded", format!("{}, {}", v.samples, v.loaded)),
                ("working normal force", format!("{:.3} N", v.normal_force_n)),
                ("stroke, drive speed", format!("{:.3} mm, {:.3} mm/s", v.stroke_m * 1e3, v.speed_m_s * 1e3)),
                (
                    "friction / normal, sliding (5 %, median, 95 %)",
                    format!("{low:.3}, {middle:.3}, {high:.3}"),
                ),
                (
                    "friction drags the object along",
                    format!("{:.1} % of sliding samples", v.dragging * 100.0),
                ),
                ("greatest time step", format!("{:.0} ms", v.gap_s * 1e3)),
            ];
            finish(files, &import.dataset, v, &import.bad_rows, &rows, output)
        }
    }
}

fn cmu(args: &CmuPushArgs, output: &Output) -> anyhow::Result<()> {
    let (text, name) = read(&args.files.file)?;
    let support = match &args.support {
        Some(support) => cmu_push::Support::from_name(support),
        None => cmu_push::support_of(&args.files.file),
    };
    let support = support.context("unknown support; give --support patch or --support 30_90_30_30_30_90")?;
    let options = cmu_push::Options { support, tip_radius_m: args.tip_radius_m };
    let import =
        cmu_push::import(&text, &name, &options).with_context(|| args.files.file.display().to_string())?;
    let v = &import.verification;
    let [angle, angle_95, angle_most] = v.force_angle_rad.map(f64::to_degrees);
    let [least, middle, most] = v.sliding_force_n;
    let rows = [
        ("pushes", v.pushes.to_string()),
        ("pusher does positive work", format!("{} of {}", v.positive_work, v.pushes)),
        (
            "pusher starts outside the object",
            format!("{} of {}, median {:.2} mm", v.start_outside, v.pushes, v.start_distance_m * 1e3),
        ),
        (
            "pusher to edge at the end",
            format!("median {:.2} mm, rms {:.2} mm", v.end_distance_m[0] * 1e3, v.end_distance_m[1] * 1e3),
        ),
        (
            "force to inward normal",
            format!("median {angle:.1}, 95 % within {angle_95:.1}, all within {angle_most:.1} degrees"),
        ),
        ("mean sliding force (least, median, most)", format!("{least:.2}, {middle:.2}, {most:.2} N")),
        ("median / (0.282 m g)", format!("{:.2}", v.sliding_force_share)),
        ("peak / mean sliding force", format!("{:.2}", v.peak_share)),
        ("white noise of the force", format!("{:.4} N", v.force_noise_n)),
        ("in contact within 0.3 s", v.early_contact.to_string()),
        ("tilt of recorded poses, ignored", format!("at most {:.2} degrees", v.tilt_rad.to_degrees())),
    ];
    finish(&args.files, &import.dataset, v, &import.bad_rows, &rows, output)
}

fn read(file: &Path) -> anyhow::Result<(String, String)> {
    let text = fs::read_to_string(file).with_context(|| format!("{}", file.display()))?;
    let name = file.file_stem().map(|name| name.to_string_lossy().into_owned());
    Ok((text, name.unwrap_or_default()))
}

fn finish<V: Serialize>(
    files: &Files,
    dataset: &Dataset,
    verification: &V,
    bad_rows: &[BadRow],
    rows: &[(&str, String)],
    output: &Output,
) -> anyhow::Result<()> {
    let stage = Stage::begin(&files.out)?;
    stickslip_data::write_as(dataset, stage.folder(), files.format)?;
    stage.finish()?;
    let samples = dataset.trials.iter().map(|trial| trial.samples.len()).sum();
    let mut table = table(["what", "measured"]);
    for (what, value) in rows {
        table.add_row([(*what).to_owned(), value.clone()]);
    }
    output.table(&table);
    output.text(format_args!("{} rows could not be used", bad_rows.len()));
    for row in bad_rows.iter().take(20) {
        output.text(format_args!("  line {}: {:?}: {}", row.line, row.text, row.reason));
    }
    if bad_rows.len() > 20 {
        output.text(format_args!("  and {} more; --json lists all", bad_rows.len() - 20));
    }
    output.text(format_args!("{}: {} trials, {samples} samples", files.out.display(), dataset.trials.len()));
    output.document(&Report {
        out: &files.out,
        trials: dataset.trials.len(),
        samples,
        verification,
        bad_rows,
    })
}
