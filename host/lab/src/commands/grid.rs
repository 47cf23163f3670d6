//! `stickslip-lab grid DATA`: the model along every trial of a data set, in parallel, and how
//! long a step takes by the number of its contact points.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::bail;
use cpu_time::ThreadTime;
use rayon::prelude::*;
use serde::Serialize;
use stickslip_shared::cone::SolveStatus;
use stickslip_shared::model::Model;

use stickslip_analysis::model::file::model_or_default;
use stickslip_analysis::run::simulate::prepare;
use stickslip_report::data;
use stickslip_report::terminal::{Output, table};

/// Arguments of `stickslip-lab grid`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  stickslip rig --plan paper --out data/paper
  stickslip-lab grid data/paper --model model.toml")]
pub struct Args {
    /// Folder of the data set (holds dataset.toml)
    pub data: PathBuf,
    /// Model [default: hard contact, friction 0.4, 0.25 and 0.3; platforms 2.5 where trials roll]
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    /// Threads [default: one for each core]
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
}

/// Steps with the same number of contact points.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Steps {
    /// How many.
    pub steps: usize,
    /// Median time of one, s.
    pub median_s: f64,
    /// Newton steps of the solver.
    pub newton_steps: usize,
    /// Steps whose solve did not reach its tolerance.
    pub unsolved: usize,
}

impl Steps {
    fn add(&mut self, other: &Steps) {
        self.steps += other.steps;
        self.newton_steps += other.newton_steps;
        self.unsolved += other.unsolved;
    }
}

/// What was done, and how fast.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Trials that were run.
    pub trials: usize,
    /// Trials that could not be run.
    pub left_out: usize,
    /// Threads.
    pub threads: usize,
    /// Wall time from the first file to the last step, s.
    pub wall_s: f64,
    /// Steps a second of wall time, reading included.
    pub steps_per_s: f64,
    /// Processor time of all threads: reading files.
    pub reading_s: f64,
    /// Processor time of all threads: poses freed of noise, channels, start.
    pub preparing_s: f64,
    /// Processor time of all threads: stepping.
    pub stepping_s: f64,
    /// All steps.
    pub all: Steps,
    /// By number of contact points handed to the solver.
    pub by_contacts: BTreeMap<usize, Steps>,
    /// By primitive.
    pub by_primitive: BTreeMap<String, Steps>,
}

/// One trial's share of it.
struct One {
    reading_s: f64,
    preparing_s: f64,
    stepping_s: f64,
    primitive: String,
    by_contacts: BTreeMap<usize, Steps>,
    /// Wall time of each step in nanoseconds, with its contact points. Medians of these are
    /// those of an idle machine also where other work interrupts some.
    times: Vec<(u16, u32)>,
}

/// Runs the model along every trial.
///
/// # Errors
/// Where data or model cannot be read, or no trial can be run.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let index = data::open(&args.data, output)?;
    let model = model_or_default(args.model.as_deref())?;
    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(threads) = args.threads {
        pool = pool.num_threads(threads.max(1));
    }
    let pool = pool.build()?;
    let bar = output.progress(index.trials.len() as u64, "stepping");
    let start = Instant::now();
    let results: Vec<Result<One, String>> = pool.install(|| {
        index
            .trials
            .par_iter()
            .enumerate()
            .map(|(at, info)| {
                let started = ThreadTime::now();
                let trial = data::trial(&index, info, output).ok_or("it cannot be read")?;
                let read = ThreadTime::now();
                let prepared = prepare(&index.description, &trial, at).map_err(|e| e.to_string())?;
                let ready = ThreadTime::now();
                let model = match (&args.model, info.primitive.as_str()) {
                    (None, "roll") => on_silicone(&model),
                    _ => model.clone(),
                };
                let mut by_contacts: BTreeMap<usize, Steps> = BTreeMap::new();
                let mut times = Vec::with_capacity(prepared.t_s.len());
                let mut last = Instant::now();
                prepared.observe(&model, 1, |_, _, step, _| {
                    let now = Instant::now();
                    by_contacts.entry(usize::from(step.points)).or_default().add(&Steps {
                        steps: 1,
                        median_s: 0.0,
                        newton_steps: step.iterations as usize,
                        unsolved: usize::from(step.status != SolveStatus::Solved),
                    });
                    times.push((step.points, (now - last).as_nanos() as u32));
                    last = now;
                });
                let stepped = ThreadTime::now();
                bar.inc(1);
                Ok(One {
                    reading_s: read.duration_since(started).as_secs_f64(),
                    preparing_s: ready.duration_since(read).as_secs_f64(),
                    stepping_s: stepped.duration_since(ready).as_secs_f64(),
                    primitive: info.primitive.clone(),
                    by_contacts,
                    times,
                })
            })
            .collect()
    });
    let wall_s = start.elapsed().as_secs_f64();
    bar.finish_and_clear();
    let mut report = Report {
        trials: 0,
        left_out: 0,
        threads: pool.current_num_threads(),
        wall_s,
        steps_per_s: 0.0,
        reading_s: 0.0,
        preparing_s: 0.0,
        stepping_s: 0.0,
        all: Steps::default(),
        by_contacts: BTreeMap::new(),
        by_primitive: BTreeMap::new(),
    };
    let mut times: Vec<(String, Vec<(u16, u32)>)> = Vec::new();
    for result in results {
        match result {
            Ok(one) => {
                report.trials += 1;
                report.reading_s += one.reading_s;
                report.preparing_s += one.preparing_s;
                report.stepping_s += one.stepping_s;
                match times.iter_mut().find(|t| t.0 == one.primitive) {
                    Some(t) => t.1.extend(one.times),
                    None => times.push((one.primitive.clone(), one.times)),
                }
                for (contacts, steps) in one.by_contacts {
                    report.all.add(&steps);
                    report.by_contacts.entry(contacts).or_default().add(&steps);
                    report.by_primitive.entry(one.primitive.clone()).or_default().add(&steps);
                }
            }
            Err(why) => {
                report.left_out += 1;
                output.note(format_args!("left out: {why}"));
            }
        }
    }
    if report.trials == 0 {
        bail!("{}: no trial can be run", args.data.display());
    }
    medians(&mut report, &times);
    report.steps_per_s = report.all.steps as f64 / wall_s;
    print(&report, output);
    output.document(&report)
}

/// Fills in the medians.
fn medians(report: &mut Report, times: &[(String, Vec<(u16, u32)>)]) {
    let median = |mut all: Vec<u32>| {
        all.sort_unstable();
        1e-9 * f64::from(all.get(all.len() / 2).copied().unwrap_or(0))
    };
    let all = || times.iter().flat_map(|t| &t.1);
    report.all.median_s = median(all().map(|t| t.1).collect());
    for (contacts, steps) in &mut report.by_contacts {
        steps.median_s = median(all().filter(|t| usize::from(t.0) == *contacts).map(|t| t.1).collect());
    }
    for (primitive, of) in times {
        if let Some(steps) = report.by_primitive.get_mut(primitive) {
            steps.median_s = median(of.iter().map(|t| t.1).collect());
        }
    }
}

/// Rubber pads roll a cylinder only on something that grips: the paper's platform.
fn on_silicone(model: &Model<f64>) -> Model<f64> {
    let mut model = model.clone();
    model.friction.support = 2.5;
    model
}

fn print(report: &Report, output: &Output) {
    output.text(format_args!(
        "{} trials, {} steps in {:.1} s on {} threads: {:.0} steps a second",
        report.trials, report.all.steps, report.wall_s, report.threads, report.steps_per_s
    ));
    output.text(format_args!(
        "processor time of all threads: reading {:.1} s, preparing {:.1} s, stepping {:.1} s ({:.2} us a step)",
        report.reading_s,
        report.preparing_s,
        report.stepping_s,
        1e6 * report.stepping_s / report.all.steps.max(1) as f64
    ));
    let row = |name: String, s: &Steps| {
        let n = s.steps.max(1) as f64;
        [
            name,
            s.steps.to_string(),
            format!("{:.2}", 1e6 * s.median_s),
            format!("{:.2}", s.newton_steps as f64 / n),
            s.unsolved.to_string(),
        ]
    };
    let mut shown = table(["primitive", "steps", "us a step (median)", "Newton steps", "unsolved"]);
    for (name, steps) in &report.by_primitive {
        shown.add_row(row(name.clone(), steps));
    }
    output.table(&shown);
    let mut shown = table(["contact points", "steps", "us a step (median)", "Newton steps", "unsolved"]);
    for (contacts, steps) in &report.by_contacts {
        shown.add_row(row(contacts.to_string(), steps));
    }
    output.table(&shown);
}
