//! `stickslip check DATA`: what a data set holds and whether it can be trusted.

use std::path::PathBuf;

use stickslip_analysis::check::physics::Clocks;
use stickslip_analysis::check::{self, Balance, Report, check};
use stickslip_analysis::evidence::pose_clock::Delay;
use stickslip_analysis::evidence::stages::STAGES;
use stickslip_data::Index;
use stickslip_report::signals;
use stickslip_report::terminal::{Output, command_line, table};

/// Arguments of `stickslip check`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  stickslip check data/demo --html check.html")]
pub struct Args {
    /// Folder of the data set (holds dataset.toml)
    pub data: PathBuf,
    /// List at most this many errors, warnings and failing trials (--json lists all)
    #[arg(long, default_value_t = 10)]
    pub most: usize,
    /// Print noise and scatter of every channel, the balance of forces and the offsets at rest too
    #[arg(long, short)]
    pub verbose: bool,
    /// Write a page that shows signals and frames as they were understood: one trial of each primitive
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
}

/// Reads the data set leniently and reports.
///
/// # Errors
/// Where nothing can be read, and, after the report, where anything was refused or physics does not
/// allow it. A balance that fails in at most half of the trials is reported, but is an event in
/// them and no error.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let index = Index::open(&args.data)?;
    let report = check(&index, output);
    output.text(format_args!("{}\n", signals::verdict(&report).1));
    holdings(&report, output);
    if args.verbose {
        channel_table(&report, output);
    }
    balance(&report.balance, args, output);
    clocks(&report.clocks, output);
    delay(report.object_delay.filter(|delay| args.verbose || delay.is_found()), output);
    list("warnings", report.warnings.iter().map(ToString::to_string), args.most, output);
    list("physics errors", report.findings.iter().map(ToString::to_string), args.most, output);
    let left_out = report.left_out.iter().map(ToString::to_string);
    list("trials that no model can be run along", left_out, args.most, output);
    list("errors", report.errors.iter().cloned(), args.most, output);
    let sound = report.errors.is_empty() && report.findings.is_empty() && report.balance.failing == 0;
    let next = ["calibrate", &args.data.display().to_string(), "--out", "model.toml"].map(str::to_owned);
    if let Some(path) = &args.html {
        let line = if sound || !report.suspects.is_empty() {
            command_line(next.iter().map(String::as_str))
        } else {
            String::new()
        };
        let trials = signals::examples(&index);
        output.page(path, signals::page(&report, &index.description, &trials, &line))?;
    }
    output.document(&report)?;
    let (errors, findings) = (report.errors.len(), report.findings.len());
    let folder = args.data.display();
    anyhow::ensure!(errors == 0, "{errors} refused in {folder}; the rest was read");
    anyhow::ensure!(findings == 0, "{findings} physics error(s) in {folder}: the data contradict physics");
    match report.balance.failing {
        0 => {
            output.text(if args.verbose {
                "\nNo errors."
            } else {
                "\nNo errors. Noise of every channel, balance, offsets at rest: --verbose, or --html for the page"
            });
            output.next(next.iter().map(String::as_str));
        }
        failing => {
            output.text(format_args!(
                "Nothing was refused, but the forces do not balance in {failing} of {} trials (see above).",
                report.balance.checked
            ));
            // A sensor that explains it is an effect that a diagnosis names.
            if !report.suspects.is_empty() {
                output.next(next.iter().map(String::as_str));
            }
        }
    }
    Ok(())
}

fn holdings(report: &Report, output: &Output) {
    output.text(format_args!(
        "{}: {} trials, {} samples ({})",
        report.name,
        report.trials,
        report.samples,
        check::primitive_names(report)
    ));
    output.left_out(&report.left_out, report.trials, "by every command with a model; see below");
    for count in &report.primitives {
        let conditions: Vec<String> = count
            .conditions
            .iter()
            .map(|(name, values)| match values.as_slice() {
                values if values.len() <= 8 => {
                    let values: Vec<String> = values.iter().map(|value| short(*value)).collect();
                    format!("; {name} {}", values.join(" "))
                }
                [first, .., last] => {
                    format!("; {name} {} to {} ({} values)", short(*first), short(*last), values.len())
                }
                _ => format!("; {name}"),
            })
            .collect();
        let (primitive, object) = (count.primitive.replace('_', " "), &count.object);
        output.text(format_args!(
            "  {primitive} of {object}: {} trials{}",
            count.trials,
            conditions.concat()
        ));
    }
    let [slowest, fastest] = report.rate_hz;
    let gaps = match report.gaps.gaps {
        0 => "no gaps".to_owned(),
        gaps => format!(
            "{gaps} gaps in {} trials, longest {:.1} ms",
            report.gaps.trials,
            report.gaps.longest_s * 1e3
        ),
    };
    let repeated = match report.repeated_groups {
        0 => "repetitions: none, so there is no noise floor".to_owned(),
        groups => format!("repetitions: {} trials in {groups} groups", report.repeated_trials),
    };
    let nominal = report.nominal_rate_hz;
    output.text(format_args!(
        "  rate: {slowest:.2} to {fastest:.2} Hz (nominal {nominal}); {gaps}; {repeated}"
    ));
}

fn channel_table(report: &Report, output: &Output) {
    let mut rows =
        table(["channel", "measured", "white noise", "floor before contact", "floor pushed", "floor end"]);
    for channel in report.channels.iter().filter(|channel| channel.measured > 0.0) {
        let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), short);
        let mut row = vec![
            channel.channel.to_owned(),
            format!("{:.1} %", channel.measured * 100.0),
            number(channel.white),
        ];
        row.extend(channel.floor.iter().take(STAGES.len()).map(|floor| number(*floor)));
        rows.add_row(row);
    }
    output.text("\nchannels (SI units; the floor is the standard deviation between repetitions)");
    output.table(&rows);
}

fn balance(balance: &Balance, args: &Args, output: &Output) {
    for (reason, trials) in &balance.not_checked {
        output.text(format_args!("  balance of forces: not checked in {trials} trials: {}", reason.label()));
    }
    if balance.checked == 0 {
        return;
    }
    if balance.failing == 0 {
        let checked = balance.checked;
        output.text(format_args!("  forces balance within the sensors' uncertainty in all {checked} trials"));
    } else {
        output.text(format_args!(
            "  FORCES DO NOT BALANCE in {} of {} trials, beyond the sensors' uncertainty: a sensor, the stated mass, or \
             a force that is not measured (cable, table, knock, filling); no model of the measured contacts can \
             explain it",
            balance.failing, balance.checked
        ));
        for (trial, worst) in balance.worst.iter().take(args.most) {
            output.text(format_args!("    {trial}, {}: {} N", worst.stage.label(), vector(&worst.sum_n)));
        }
        if balance.worst.len() > args.most {
            output.text(format_args!("    and {} more", balance.worst.len() - args.most));
        }
    }
    if args.verbose || balance.failing > 0 {
        balance_table(balance, output);
    }
}

fn balance_table(balance: &Balance, output: &Output) {
    output.text("\nsum of measured forces: fingers + pusher + weight, world axes");
    let mut rows = table(["stage", "trials", "mean sum N", "scatter N", "worst N", "bound N"]);
    for stage in &balance.stages {
        rows.add_row([
            stage.stage.to_owned(),
            stage.trials.to_string(),
            vector(&stage.mean_n),
            vector(&stage.scatter_n),
            short(stage.worst_n),
            short(stage.bound_n),
        ]);
    }
    output.table(&rows);
    if let Some(tare) = &balance.tare {
        output.text(format_args!(
            "constant offsets found before contact ({} trials): fingers together {} N in gripper axes \
             (scatter {}){}\n",
            tare.trials,
            vector(&tare.fingers_sum_n),
            vector(&tare.fingers_scatter_n),
            tare.pusher_n
                .map_or_else(String::new, |pusher| format!(", pusher {} N in world axes", vector(&pusher)))
        ));
    } else {
        output
            .text("constant offsets are unknown: no phase before contact with all finger forces measured\n");
    }
}

fn clocks(clocks: &[Clocks], output: &Output) {
    for Clocks { primitive, compared, behind_s, scattered, unknown } in clocks {
        let primitive = primitive.replace('_', " ");
        if let (Some((means, trials)), Some([behind_s, half_s])) = (compared, behind_s) {
            output.text(format_args!(
                "  clocks, {primitive}: poses {:.0} ms {} forces (\u{b1} {:.0} ms), by the {} ({trials} trials)",
                1e3 * behind_s.abs(),
                if *behind_s < 0.0 { "ahead of" } else { "behind" },
                1e3 * half_s,
                means.label()
            ));
        }
        if *scattered > 0 {
            output.text(format_args!(
                "  clocks, {primitive}: not known in {scattered} trials: the object moves in the grasp at no fixed time \
                 after the contact"
            ));
        }
        for (why, trials) in unknown {
            output.text(format_args!("  clocks, {primitive}: not known in {trials} trials: {}", why.label()));
        }
    }
}

fn delay(delay: Option<Delay>, output: &Output) {
    if let Some(delay) = delay {
        output.text(format_args!(
            "  clocks, object: {:.1} ms {} the gripper (\u{b1} {:.1} ms), by their motion before contact ({} trials)",
            1e3 * delay.late_s.abs(),
            if delay.late_s < 0.0 { "ahead of" } else { "behind" },
            2e3 * delay.sd_s,
            delay.trials
        ));
    }
}

fn list(what: &str, items: impl ExactSizeIterator<Item = String>, most: usize, output: &Output) {
    let count = items.len();
    if count > 0 {
        output.text(format_args!("\n{count} {what}"));
    }
    for item in items.take(most) {
        output.text(format_args!("  {item}"));
    }
    if count > most {
        output.text(format_args!("  and {} more", count - most));
    }
}

fn vector(values: &[f64; 3]) -> String {
    let [x, y, z] = values;
    format!("[{x:.3}, {y:.3}, {z:.3}]")
}

/// Three digits, as short as they get.
fn short(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        let digits = (2 - value.abs().max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
        let text = format!("{value:.digits$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{value:.2e}")
    }
}
