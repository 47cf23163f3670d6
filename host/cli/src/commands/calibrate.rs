//! `stickslip calibrate DATA`: friction from a small share of the trials, validated on the rest.

use std::path::{Path, PathBuf};

use anyhow::Context;
use schemars::JsonSchema;
use serde::Serialize;

use crate::commands::fitted::{file_or_default, write};
use stickslip_analysis::calibrate::{Calibration, Options, PadStiffness, Share, calibrate, name};
use stickslip_analysis::channels;
use stickslip_report::terminal::{Output, table};

/// Arguments of `stickslip calibrate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  stickslip calibrate data/push --out model.toml
  stickslip calibrate data/push --model soft.toml --share 0.2 --out soft-calibrated.toml")]
pub struct Args {
    /// Folder of the data set (holds dataset.toml)
    pub data: PathBuf,
    /// Model to start from; its contact law and effects do not change [default: hard contact, no effects]
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    /// File of the calibrated model; with several primitives one more file for each, its
    /// name before the extension, and in this one the best determined friction of all
    #[arg(long, value_name = "FILE.toml")]
    pub out: Option<PathBuf>,
    /// Share of the trials that friction is fitted to, at least eight trials; the rest validate
    #[arg(long, value_name = "SHARE", default_value_t = 0.1, value_parser = share)]
    pub share: f64,
    /// Only trials of this primitive
    #[arg(long, value_name = "NAME")]
    pub primitive: Option<String>,
}

fn share(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("'{text}' is not a number"))?;
    if value > 0.0 && value <= 1.0 { Ok(value) } else { Err("give a share above 0 and at most 1".into()) }
}

#[derive(JsonSchema, Serialize)]
/// A primitive's calibration.
pub(super) struct Written<'a> {
    /// The fit.
    #[serde(flatten)]
    calibration: &'a Calibration,
    /// The model file, with `--out`.
    file: Option<String>,
}

/// Calibrates each primitive of the data set.
///
/// # Errors
/// Where data or model cannot be read, or no trial can be simulated.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let file = file_or_default(args.model.as_deref())?;
    let data = stickslip_report::data::read(&args.data, output)?;
    let options = Options { share: Share::of(args.share), primitive: args.primitive.clone(), pads: true };
    let report =
        calibrate(&data, &file, &options, output).with_context(|| args.data.display().to_string())?;
    let several = report.primitives.len() > 1;
    let mut documents = Vec::new();
    for calibration in &report.primitives {
        // The file first: a closed pipe ends the text, not the work.
        let path = args.out.as_ref().map(|out| named(out, &calibration.primitive, several));
        if let Some(path) = &path {
            write(&calibration.on(&file), path)?;
            output.note(format_args!("model of {} written to {}", calibration.primitive, path.display()));
        }
        print(calibration, output);
        documents.push(Written { calibration, file: path.map(|f| f.display().to_string()) });
    }
    if let Some(path) = args.out.as_ref().filter(|_| several) {
        write(&report.model, path)?;
        output.note(format_args!(
            "model with the best determined friction of all written to {}",
            path.display()
        ));
    }
    let data = args.data.display().to_string();
    match &args.out {
        Some(out) => output.next(["diagnose", &data, "--model", &out.display().to_string()]),
        None => output.next(["calibrate", &data, "--out", "model.toml"]),
    }
    output.document(&documents)
}

fn named(out: &Path, primitive: &str, several: bool) -> PathBuf {
    if !several {
        return out.to_path_buf();
    }
    let stem = out.file_stem().map_or_else(|| "model".into(), |s| s.to_string_lossy().into_owned());
    let extension = out.extension().map_or_else(|| "toml".into(), |s| s.to_string_lossy().into_owned());
    out.with_file_name(format!("{stem}-{primitive}.{extension}"))
}

fn print(c: &Calibration, output: &Output) {
    output.text(format_args!(
        "{}: friction from {} trial(s), validated on {}",
        c.primitive,
        c.calibration_trials.len(),
        c.held_out_trials
    ));
    let all = c.calibration_trials.len() + c.held_out_trials + c.left_out.len();
    output.left_out(&c.left_out, all, "all: --json");
    let mut friction = table(["coefficient", "value", "95 % interval", "determined"]);
    for e in &c.estimates {
        let bound = |b: Option<f64>| b.map_or_else(|| "-".into(), |b| format!("{b:.3}"));
        let range = format!("{} to {}", bound(e.low), bound(e.high));
        let (value, known) =
            if e.determined { (format!("{:.3}", e.value), "yes") } else { ("-".into(), "no: range only") };
        friction.add_row([name(e.coefficient).into(), value, range, known.to_string()]);
    }
    output.table(&friction);
    if let Some(pads) = &c.pads {
        output.text(pad_words(pads));
    }
    let mut errors = table(["quantity", "unit", "signal", "before", "calibration", "held out"]);
    let size = |x: f64| if x.is_finite() { format!("{x:.3e}") } else { "-".into() };
    for e in &c.errors {
        errors.add_row([
            format!("{:?}", e.quantity).to_lowercase(),
            e.unit.into(),
            size(e.signal),
            size(e.before),
            size(e.calibration),
            size(e.held_out),
        ]);
    }
    output.text("root mean square errors over windows of the motion:");
    output.table(&errors);
    let mut offsets = table(["channel", "offset at rest"]);
    let shown = |(k, o): (usize, &f64)| {
        let small = if k % 6 < 3 { 5e-3 } else { 1e-4 };
        (o.abs() > small).then(|| [channels::NAMES[k].to_string(), format!("{o:.4}")])
    };
    let rows: Vec<_> = c.offsets.iter().enumerate().filter_map(shown).collect();
    if !rows.is_empty() {
        for row in rows {
            offsets.add_row(row);
        }
        output.text("sensor offsets removed (tare):");
        output.table(&offsets);
    }
    for remark in &c.remarks {
        output.text(format_args!("- {remark}"));
    }
    output.text("");
}

fn pad_words(pads: &PadStiffness) -> String {
    let n_mm = |n_m: f64| format!("{:.0}", 1e-3 * n_m);
    let range = match pads.high_n_m {
        Some(high) => format!("{} to {}", n_mm(pads.low_n_m), n_mm(high)),
        None => format!("at least {}", n_mm(pads.low_n_m)),
    };
    let value = pads
        .tangential_n_m
        .map_or_else(|| "as rigid as these data can show".into(), |k| format!("{} N/mm", n_mm(k)));
    let model = match pads.in_model {
        true => "in the model",
        false => "within the tolerance of rigid contact: not in the model",
    };
    format!(
        "pads, tangential stiffness of one: {value} ({range}), read off {} loadings; {model}",
        pads.loadings
    )
}
