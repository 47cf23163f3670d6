//! Instruction counts of the tick and its parts on the emulated board.
//!
//! `firmware/src/bin/cost.rs` runs under QEMU with `-icount shift=3`: every instruction takes
//! 8 ns of the board's time, so its 25 MHz timer counts instructions in fives, the same ones
//! on every run. These are instructions, not cycles.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context, bail, ensure};
use serde::Serialize;
use stickslip_shared::model::Formulation;
use stickslip_shared::wire::Sample;

use stickslip_device::package::Package;
use stickslip_lcp::files::Factors;

/// Where QEMU's loader puts what the board shall run.
const INPUT: &str = "0x21000000";
const MAGIC: u32 = 0x5354_4331;
/// A tick's share of a 168 MHz Cortex-M4F: 4 ms at 125 million instructions a second.
pub const TICK_INSTRUCTIONS: f64 = 500_000.0;

/// Formulation, seed, ticks and horizon (s) of the self-test.
pub type SelfTest = (Formulation, u32, u32, f32);

/// One time step, instructions.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct StepCost {
    /// Place in its tick; 1 follows the last sample, the others look ahead.
    pub place: u32,
    /// All of it.
    pub step: f64,
    /// Where the bodies touch.
    pub contacts: f64,
    /// Forces and velocity.
    pub cone: f64,
    /// The first of its trial.
    pub cold: bool,
}

/// One tick, instructions.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct TickCost {
    /// Trial, and tick of the trial.
    pub trial: usize,
    /// From 0.
    pub tick: usize,
    /// `Predictor::tick`.
    pub tick_all: f64,
    /// Before the step: poses, filters, drive.
    pub track: f64,
    /// The step from the last sample to this one.
    pub step: f64,
    /// After it: comparison with the measurement, utilisation, description.
    pub observe: f64,
    /// Steps along the plan.
    pub look_ahead: f64,
    /// Flags and what else follows.
    pub judge: f64,
    /// Hash of the outputs.
    pub hash: f64,
    /// Frame of the telemetry.
    pub encode: f64,
    /// Steps made.
    pub steps: u32,
    /// Iterations of all steps.
    pub iterations: u32,
    /// Worst status of the solver; 0 is solved.
    pub status: u32,
    /// `Prediction::validity`.
    pub validity: u32,
}

/// Contacts and degrees of freedom of the contact problems that the board solves.
pub const PROBLEM: (usize, usize) = (16, 8);

/// A contact problem and its neighbour, solved on the board by `lcp::contact`; instructions.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SolveCost {
    /// From open contacts.
    pub cold: f64,
    /// The same problem from its own answer.
    pub same: f64,
    /// The neighbour from that answer.
    pub moved: f64,
    /// Which of the three were solved.
    pub solved: [bool; 3],
}

/// What a run counted.
#[derive(Clone, Debug, Default)]
pub struct Counts {
    /// Every tick that stepped.
    pub ticks: Vec<TickCost>,
    /// Every step of these.
    pub steps: Vec<StepCost>,
    /// Every pair of contact problems.
    pub solves: Vec<SolveCost>,
    /// Deepest stack below the caller of `tick`, bytes.
    pub stack_bytes: u32,
    /// Hash over all predictions.
    pub hash: u32,
}

/// What the board shall run, as it reads it.
fn input(trials: &[Package], selftest: SelfTest, pairs: &[[Factors; 2]]) -> anyhow::Result<Vec<u8>> {
    let number = u32::try_from(trials.len()).context("too many trials")?;
    let (formulation, seed, ticks, horizon_s) = selftest;
    let problems = u32::try_from(pairs.len()).context("too many problems")?;
    let mut records = postcard::to_stdvec(&(number, formulation, seed, ticks, horizon_s, problems))?;
    for trial in trials {
        let count = u32::try_from(trial.samples.len()).context("too many samples")?;
        records.extend(postcard::to_stdvec(&(&trial.model, &trial.plan, trial.ordinal, count))?);
        for sample in &trial.samples {
            records.extend(postcard::to_stdvec::<Sample>(sample)?);
        }
    }
    for problem in pairs.as_flattened() {
        records.extend(record(problem)?);
    }
    let length = u32::try_from(records.len()).ok().filter(|l| *l < (16 << 20) - 8);
    let length = length.context("more samples than the board's memory holds (16 MiB): fewer trials")?;
    let mut bytes = MAGIC.to_le_bytes().to_vec();
    bytes.extend(length.to_le_bytes());
    bytes.extend(records);
    Ok(bytes)
}

/// A problem of [`PROBLEM`]'s size, rounded to single precision.
fn record(problem: &Factors) -> anyhow::Result<Vec<u8>> {
    let (contacts, freedoms) = (problem.friction.len(), problem.inverse_mass.len());
    ensure!(
        (contacts, freedoms) == PROBLEM,
        "{contacts} contacts and {freedoms} degrees of freedom; the board's program holds {PROBLEM:?}"
    );
    let row = |r: usize| [0, 1, 2, 3, 4, 5, 6, 7].map(|k| problem.jacobian[r * freedoms + k] as f32);
    let inverse_mass = [0, 1, 2, 3, 4, 5, 6, 7].map(|k| problem.inverse_mass[k] as f32);
    let list: Vec<_> = (0..contacts)
        .map(|i| {
            let tangent = contacts + 4 * i;
            let q = &problem.constant;
            let numbers = [problem.compliance[i], problem.friction[i], q[i], q[tangent], q[tangent + 1]];
            (row(i), [row(tangent), row(tangent + 1)], numbers.map(|x| x as f32))
        })
        .collect();
    Ok(postcard::to_stdvec(&(inverse_mass, list))?)
}

/// Runs `trials`, the self-test and pairs of contact problems on the emulated board and counts.
///
/// # Errors
/// QEMU or the program is missing, or what it printed is not what was asked for.
pub fn count(
    program: &Path,
    trials: &[Package],
    selftest: SelfTest,
    pairs: &[[Factors; 2]],
) -> anyhow::Result<Counts> {
    ensure!(program.is_file(), "{} is not there: `make cost` builds it", program.display());
    let file = std::env::temp_dir().join(format!("stickslip-cost-{}.bin", std::process::id()));
    std::fs::write(&file, input(trials, selftest, pairs)?).with_context(|| file.display().to_string())?;
    let result = run(program, &file);
    let _ = std::fs::remove_file(&file);
    result
}

fn run(program: &Path, file: &Path) -> anyhow::Result<Counts> {
    let mut child = Command::new("qemu-system-arm")
        .args(["-machine", "mps2-an386", "-display", "none", "-monitor", "none", "-serial", "null"])
        .args(["-icount", "shift=3,align=off,sleep=off"])
        .args(["-semihosting-config", "enable=on,target=native"])
        .args(["-device", &format!("loader,file={},addr={INPUT},force-raw=on", file.display())])
        .arg("-kernel")
        .arg(program)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .context("qemu-system-arm; `make setup` installs it")?;
    let mut reader = Reader::default();
    if let Some(stdout) = child.stdout.take() {
        for line in BufReader::new(stdout).lines() {
            let line = line.context("output of QEMU")?;
            if let Err(error) = reader.take(&line) {
                let _ = child.kill();
                let _ = child.wait();
                return Err(error.context(format!("the board printed `{line}`")));
            }
        }
    }
    let status = child.wait()?;
    ensure!(status.success() && reader.ended, "the board stopped early ({status})");
    Ok(reader.counts)
}

#[derive(Default)]
struct Reader {
    counts: Counts,
    /// Instructions of one count of the timer.
    scale: f64,
    trial: Option<usize>,
    tick: usize,
    ended: bool,
}

impl Reader {
    fn take(&mut self, line: &str) -> anyhow::Result<()> {
        let mut words = line.split_whitespace();
        let kind = words.next().unwrap_or_default();
        let numbers: Vec<u32> = words.map(str::parse).collect::<Result<_, _>>()?;
        let scale = self.scale;
        let instructions = |counts: u32| f64::from(counts) * scale;
        match (kind, numbers.as_slice()) {
            ("million", [million, _]) => self.scale = 1e6 / f64::from((*million).max(1)),
            ("trial" | "selftest", _) => {
                self.trial = Some(self.trial.map_or(0, |t| t + 1));
                self.tick = 0;
            }
            ("step", &[place, step, contacts, cone]) => self.counts.steps.push(StepCost {
                place,
                step: instructions(step),
                contacts: instructions(contacts),
                cone: instructions(cone),
                cold: place == 1 && self.tick == 1,
            }),
            (
                "tick",
                &[all, hash, encode, steps, first, first_end, second, last_end, iterations, status, validity],
            ) => {
                // A tick without look-ahead has no second step.
                let (second, last_end) = if steps < 2 { (first_end, first_end) } else { (second, last_end) };
                // Ticks that only start a trial settle it; they are no ticks of the loop.
                if validity & WAITING_OR_START == 0 && steps > 0 && self.tick > 0 {
                    self.counts.ticks.push(TickCost {
                        trial: self.trial.unwrap_or(0),
                        tick: self.tick,
                        tick_all: instructions(all),
                        track: instructions(first),
                        step: instructions(first_end.saturating_sub(first)),
                        observe: instructions(second.saturating_sub(first_end)),
                        look_ahead: instructions(last_end.saturating_sub(second)),
                        judge: instructions(all.saturating_sub(last_end)),
                        hash: instructions(hash),
                        encode: instructions(encode),
                        steps,
                        iterations,
                        status,
                        validity,
                    });
                }
                self.tick += 1;
            }
            ("solve", &[cold, same, moved, a, b, c]) => self.counts.solves.push(SolveCost {
                cold: instructions(cold),
                same: instructions(same),
                moved: instructions(moved),
                solved: [a, b, c].map(|x| x == 1),
            }),
            ("stack", [bytes]) => self.counts.stack_bytes = self.counts.stack_bytes.max(*bytes),
            ("end", [hash]) => {
                self.counts.hash = *hash;
                self.ended = true;
            }
            _ => bail!("the program on the board and this one are not built from the same source"),
        }
        Ok(())
    }
}

/// `validity::WAITING`.
const WAITING_OR_START: u32 = stickslip_shared::predictor::validity::WAITING;

/// Median, 99th percentile and largest of a part.
#[derive(Clone, Debug, Serialize)]
pub struct Part {
    /// What was counted.
    pub part: &'static str,
    /// How many.
    pub number: usize,
    /// Instructions.
    pub median: f64,
    /// Instructions.
    pub p99: f64,
    /// Instructions.
    pub worst: f64,
}

fn part(part: &'static str, mut values: Vec<f64>) -> Part {
    values.sort_by(f64::total_cmp);
    let at = |k| stickslip_lcp::solve::percentile(&values, k);
    Part { part, number: values.len(), median: at(50), p99: at(99), worst: at(100) }
}

/// So many of the parts, from the first on, are of steps.
pub const STEP_PARTS: usize = 7;

/// Median, 99th percentile and largest of every part.
#[must_use]
pub fn summarise(counts: &Counts) -> Vec<Part> {
    let ticks = |f: fn(&TickCost) -> f64| counts.ticks.iter().map(f).collect::<Vec<_>>();
    let steps = |keep: fn(&&StepCost) -> bool, f: fn(&StepCost) -> f64| {
        counts.steps.iter().filter(keep).map(f).collect::<Vec<_>>()
    };
    vec![
        part("warm step from sample to sample", steps(|s| s.place == 1 && !s.cold, |s| s.step)),
        part("  where the bodies touch", steps(|s| s.place == 1 && !s.cold, |s| s.contacts)),
        part("  forces and velocity", steps(|s| s.place == 1 && !s.cold, |s| s.cone)),
        part("cold step (first of a trial)", steps(|s| s.cold, |s| s.step)),
        part("step of the look-ahead", steps(|s| s.place > 1, |s| s.step)),
        part("  forces and velocity", steps(|s| s.place > 1, |s| s.cone)),
        part("tick", ticks(|t| t.tick_all)),
        part("  poses, filters, drive", ticks(|t| t.track)),
        part("  step", ticks(|t| t.step)),
        part("  comparison, utilisation", ticks(|t| t.observe)),
        part("  look-ahead", ticks(|t| t.look_ahead)),
        part("  flags", ticks(|t| t.judge)),
        part("  iterations (a count)", ticks(|t| f64::from(t.iterations))),
        part("hash of the outputs", ticks(|t| t.hash)),
        part("telemetry frame", ticks(|t| t.encode)),
    ]
}

/// Median, 99th percentile and largest of the solves of contact problems.
#[must_use]
pub fn summarise_solves(counts: &Counts) -> Vec<Part> {
    let solves = |of: fn(&SolveCost) -> f64| counts.solves.iter().map(of).collect::<Vec<_>>();
    vec![
        part("cold", solves(|s| s.cold)),
        part("warm, unchanged", solves(|s| s.same)),
        part("warm, moved", solves(|s| s.moved)),
    ]
}
