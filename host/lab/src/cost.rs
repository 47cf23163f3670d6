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
use stickslip_shared::lcp::SolveStatus;
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

/// Unknowns of the dense problems that the board solves, at most.
const UNKNOWNS: usize = 62;
/// Contacts and degrees of freedom of the contact problems that the board solves, at most.
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

/// An answer of one of the board's solvers.
#[derive(Clone, Debug, Default)]
pub struct BoardAnswer {
    /// It claims to be a solution.
    pub claimed: bool,
    /// It says that there is none.
    pub none: bool,
    /// What it took.
    pub instructions: f64,
    /// The unknowns; fewer than the problem's where none was found.
    pub z: Vec<f32>,
    unknowns: usize,
}

/// What the board shall run.
#[derive(Clone, Copy, Default)]
struct Work<'a> {
    trials: &'a [Package],
    selftest: Option<SelfTest>,
    pairs: &'a [[Factors; 2]],
    contact: &'a [Factors],
    dense: &'a [(Vec<f64>, Vec<f64>)],
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
    /// Of the problems whose answers were asked for, in their order.
    pub answers: Vec<BoardAnswer>,
    /// Deepest stack below the caller of `tick`, bytes.
    pub stack_bytes: u32,
    /// Hash over all predictions.
    pub hash: u32,
}

/// What the board shall run, as it reads it.
fn input(work: Work<'_>) -> anyhow::Result<Vec<u8>> {
    let number = |length: usize, of: &str| u32::try_from(length).with_context(|| format!("too many {of}"));
    let (formulation, seed, ticks, horizon_s) = work.selftest.unwrap_or((Formulation::Cone, 0, 0, 0.0));
    let head = (
        (number(work.trials.len(), "trials")?, formulation, seed, ticks, horizon_s),
        (number(work.pairs.len(), "pairs")?, number(work.contact.len(), "problems")?),
        number(work.dense.len(), "problems")?,
    );
    let mut records = postcard::to_stdvec(&head)?;
    for trial in work.trials {
        let count = number(trial.samples.len(), "samples")?;
        records.extend(postcard::to_stdvec(&(&trial.model, &trial.plan, trial.ordinal, count))?);
        for sample in &trial.samples {
            records.extend(postcard::to_stdvec::<Sample>(sample)?);
        }
    }
    for problem in work.pairs.as_flattened().iter().chain(work.contact) {
        records.extend(record(problem)?);
    }
    for (m, q) in work.dense {
        ensure!(q.len() <= UNKNOWNS, "{} unknowns; the board's program holds {UNKNOWNS}", q.len());
        records.extend(postcard::to_stdvec(&(single(m), single(q)))?);
    }
    let length = u32::try_from(records.len()).ok().filter(|l| *l < (16 << 20) - 8);
    let length = length.context("more samples than the board's memory holds (16 MiB): fewer trials")?;
    let mut bytes = MAGIC.to_le_bytes().to_vec();
    bytes.extend(length.to_le_bytes());
    bytes.extend(records);
    Ok(bytes)
}

fn single(numbers: &[f64]) -> Vec<f32> {
    numbers.iter().map(|x| *x as f32).collect()
}

/// A problem of [`PROBLEM`]'s size at most, rounded to single precision.
fn record(problem: &Factors) -> anyhow::Result<Vec<u8>> {
    let (contacts, freedoms) = (problem.friction.len(), problem.inverse_mass.len());
    ensure!(
        contacts <= PROBLEM.0 && freedoms <= PROBLEM.1,
        "{contacts} contacts and {freedoms} degrees of freedom; the board's program holds {PROBLEM:?}"
    );
    // A degree of freedom that is not there does not move.
    let padded =
        |numbers: &[f64]| [0, 1, 2, 3, 4, 5, 6, 7].map(|k| numbers.get(k).map_or(0.0, |x| *x as f32));
    let row = |r: usize| padded(&problem.jacobian[r * freedoms..(r + 1) * freedoms]);
    let list: Vec<_> = (0..contacts)
        .map(|i| {
            let tangent = contacts + 4 * i;
            let q = &problem.constant;
            let numbers = [problem.compliance[i], problem.friction[i], q[i], q[tangent], q[tangent + 1]];
            (row(i), [row(tangent), row(tangent + 1)], numbers.map(|x| x as f32))
        })
        .collect();
    Ok(postcard::to_stdvec(&(padded(&problem.inverse_mass), list))?)
}

/// Solves contact problems by their factors, then dense ones, on the emulated board in single precision; their
/// answers in this order.
///
/// # Errors
/// QEMU or the program is missing, a problem is too large for it, or what it printed is not what was asked for.
pub fn answers(
    program: &Path,
    contact: &[Factors],
    dense: &[(Vec<f64>, Vec<f64>)],
) -> anyhow::Result<Vec<BoardAnswer>> {
    let counts = on_board(program, Work { contact, dense, ..Work::default() })?;
    let asked = contact.len() + dense.len();
    ensure!(counts.answers.len() == asked, "{} answers for {asked} problems", counts.answers.len());
    let whole = counts.answers.iter().all(|a| a.z.len() == a.unknowns);
    ensure!(whole, "the board did not print all of an answer");
    Ok(counts.answers)
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
    on_board(program, Work { trials, selftest: Some(selftest), pairs, ..Work::default() })
}

fn on_board(program: &Path, work: Work<'_>) -> anyhow::Result<Counts> {
    ensure!(program.is_file(), "{} is not there: `make cost` builds it", program.display());
    let file = std::env::temp_dir().join(format!("stickslip-cost-{}.bin", std::process::id()));
    std::fs::write(&file, input(work)?).with_context(|| file.display().to_string())?;
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
            ("answer", &[status, _, unknowns, counts]) => self.counts.answers.push(BoardAnswer {
                claimed: status == SolveStatus::Solved as u32,
                none: status == SolveStatus::Contradiction as u32,
                instructions: instructions(counts),
                z: Vec::new(),
                unknowns: unknowns as usize,
            }),
            ("z", bits) => {
                let last = self.counts.answers.last_mut().context("numbers of no answer")?;
                last.z.extend(bits.iter().map(|bits| f32::from_bits(*bits)));
            }
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
