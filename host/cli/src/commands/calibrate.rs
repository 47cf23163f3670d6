//! `stickslip calibrate DATA`: friction from a small share of the trials, validated on the rest.

use std::path::{Path, PathBuf};

use anyhow::Context;
use schemars::JsonSchema;
use serde::Serialize;

use crate::commands::fitted::{file_or_default, write};
use stickslip_analysis::calibrate::{Calibration, Options, PadStiffness, Share, calibrate, name};
use stickslip_analysis::channels;
use stickslip_analysis::compare::verdict::readable;
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
    /// Print errors before and after, and the sensors' offsets at rest too
    #[arg(long, short)]
    pub verbose: bool,
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
    // The files first: a closed pipe ends the text, not the work.
    let mut files = Vec::new();
    for calibration in &report.primitives {
        let path = args.out.as_ref().map(|out| named(out, &calibration.primitive, several));
        if let Some(path) = &path {
            write(&report.model_of(calibration), path)?;
        }
        files.push(path);
    }
    let joint = args.out.as_ref().filter(|_| several);
    if let Some(path) = joint {
        write(&report.model, path)?;
    }
    let mut documents = Vec::new();
    for (calibration, path) in report.primitives.iter().zip(files) {
        if let Some(path) = &path {
            output.note(format_args!("model of {} written to {}", calibration.primitive, path.display()));
        }
        print(calibration, args.verbose, output);
        documents.push(Written { calibration, file: path.map(|f| f.display().to_string()) });
    }
    if let Some(path) = joint {
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

fn print(c: &Calibration, verbose: bool, output: &Output) {
    let known: Vec<String> = c
        .estimates
        .iter()
        .filter(|e| e.determined)
        .map(|e| format!("{} {:.3} ({})", name(e.coefficient), e.value, range(e.low, e.high)))
        .collect();
    let primitive = c.primitive.replace('_', " ");
    output.text(match known.as_slice() {
        [] => format!("{primitive}: these trials determine no friction, only the range that it may have."),
        known => format!("{primitive}: friction {}.", known.join(", ")),
    });
    output.text(format_args!(
        "  fitted to {} trial(s), validated on {}",
        c.calibration_trials.len(),
        c.held_out_trials
    ));
    let all = c.calibration_trials.len() + c.held_out_trials + c.left_out.len();
    output.left_out(&c.left_out, all, "all: --json");
    for e in c.estimates.iter().filter(|e| !e.determined) {
        output.text(format_args!("  {}: not determined, {}", name(e.coefficient), range(e.low, e.high)));
    }
    if let Some(pads) = &c.pads {
        output.text(format_args!("  {}", pad_words(pads)));
    }
    let held: Vec<String> = c
        .errors
        .iter()
        .filter_map(|e| {
            let quantity = format!("{:?}", e.quantity).to_lowercase();
            Some(format!("{quantity} {} of {}", readable(e.held_out?, e.unit), readable(e.signal?, e.unit)))
        })
        .collect();
    if !held.is_empty() {
        output.text(format_args!("  held-out error of the signal, RMS: {}", held.join("; ")));
    }
    if verbose {
        tables(c, output);
    }
    // That a coefficient is not determined stands above, with its range.
    let told = |text: &str| !verbose && text.contains("friction is not determined");
    for remark in c.remarks.iter().map(ToString::to_string).filter(|text| !told(text)) {
        output.text(format_args!("  {remark}"));
    }
    output.text(if verbose {
        ""
    } else {
        "\nErrors before and after, the sensors' offsets at rest: --verbose"
    });
}

fn range(low: Option<f64>, high: Option<f64>) -> String {
    match (low, high) {
        (Some(low), Some(high)) => format!("{low:.3} to {high:.3}"),
        (Some(low), None) => format!("{low:.3} or more"),
        (None, Some(high)) => format!("{high:.3} or less"),
        (None, None) => "any".into(),
    }
}

fn tables(c: &Calibration, output: &Output) {
    let mut errors = table(["quantity", "signal", "before", "calibration", "held out"]);
    for e in &c.errors {
        let size = |x: Option<f64>| x.map_or_else(|| "-".into(), |x| readable(x, e.unit));
        errors.add_row([
            format!("{:?}", e.quantity).to_lowercase(),
            size(e.signal),
            size(e.before),
            size(e.calibration),
            size(e.held_out),
        ]);
    }
    output.text("\nroot mean square errors over windows of the motion:");
    output.table(&errors);
    let mut offsets = table(["channel", "offset at rest"]);
    let mut some = false;
    for (k, offset) in c.offsets.iter().enumerate() {
        let small = if k % 6 < 3 { 5e-3 } else { 1e-4 };
        if offset.abs() > small {
            some = true;
            let unit = channels::quantity(k).unit();
            offsets.add_row([channels::channel_words(channels::NAMES[k]), readable(*offset, unit)]);
        }
    }
    if some {
        output.text("\nsensor offsets removed (tare):");
        output.table(&offsets);
    }
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
    let from = match (pads.tangential_n_m == pads.read_off_n_m, pads.read_off_n_m) {
        (false, Some(k)) => format!("{} N/mm read off {} loadings", n_mm(k), pads.loadings),
        (false, None) => format!("nothing read off {} loadings", pads.loadings),
        (true, _) => format!("read off {} loadings", pads.loadings),
    };
    format!(
        "pads, tangential stiffness of one at a grip of {:.0} N: {value} ({range}), {from}; {model}",
        pads.grip_n
    )
}
