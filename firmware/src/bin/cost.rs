//! Counts the instructions of the tick and its parts on the emulated board (`stickslip cost`
//! starts it under `-icount` and makes a table of what it prints).
//!
//! What to run lies at [`INPUT`], put there by QEMU's loader: magic, length, then postcard
//! records: a head, and for each trial its scene, model and plan, followed by its samples; then
//! pairs of contact problems for the pyramid solver (`lcp::contact`); then problems whose answers are printed, by
//! their factors for that solver and dense ones for Lemke's method (`lcp::dense`).
//! Printed are lines of counts of the 25 MHz timer; the first line says how many counts a
//! million instructions take.
#![no_std]
#![no_main]

use core::cell::RefCell;
use core::fmt::Write;

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hio};
use critical_section::Mutex;
use heapless::{String, Vec};
use postcard_rpc::Topic;
use serde::de::DeserializeOwned;
use stickslip_firmware::board::current::{self as board, timer};
use stickslip_selftest as selftest;
use stickslip_shared::lcp::contact::ContactSolver;
use stickslip_shared::lcp::dense::Dense;
use stickslip_shared::lcp::factors::{Contact, Factors};
use stickslip_shared::lcp::{Report, SolveStatus};
use stickslip_shared::model::Formulation;
use stickslip_shared::predictor::{HASH_START, Plan, Prediction, Predictor};
use stickslip_shared::probe::{self, Edge, Part};
use stickslip_shared::wire::frame::{MAX_LINE, encode};
use stickslip_shared::wire::{self, ModelPackage, TelemetryReport};

/// Start of the board's second memory (16 MiB).
const INPUT: usize = 0x2100_0000;
const INPUT_BYTES: usize = 16 << 20;
const MAGIC: u32 = 0x5354_4331;

/// Trials that follow; formulation, seed, ticks and horizon (s) of the self-test; contact problems that
/// follow the trials, in pairs; contact problems and dense ones whose answers are printed.
type Head = (u32, Formulation, u32, u32, f32, u32, u32, u32);
/// Contacts and degrees of freedom of the contact problems.
const CONTACTS: usize = 16;
const FREEDOMS: usize = 8;
/// Normal, tangents, compliance, friction, separation and slip.
type ContactRecord = ([f32; FREEDOMS], [[f32; FREEDOMS]; 2], [f32; 5]);
/// Inverse masses and contacts.
type ProblemRecord = ([f32; FREEDOMS], Vec<ContactRecord, CONTACTS>);
/// Unknowns of a dense problem, at most, and entries of its matrix.
const UNKNOWNS: usize = 62;
const ENTRIES: usize = UNKNOWNS * UNKNOWNS;
/// Matrix, row by row, and constant.
type DenseRecord = (Vec<f32, ENTRIES>, Vec<f32, UNKNOWNS>);
/// Scene, model and limits, plan, place in the data set, samples that follow.
type Trial = (ModelPackage, Plan, f32, u32);

/// A mark: what, which end, counts since the tick began without those of the marks.
type Mark = (Part, Edge, u32);

struct Marks {
    list: Vec<Mark, 512>,
    /// Counts that the marks themselves took since the tick began.
    taken: u32,
    /// Counts of a mark that lie outside its two readings of the timer.
    around: u32,
}

static MARKS: Mutex<RefCell<Marks>> =
    Mutex::new(RefCell::new(Marks { list: Vec::new(), taken: 0, around: 0 }));

fn note(part: Part, edge: Edge) {
    let entered = timer();
    critical_section::with(|cs| {
        let marks = &mut *MARKS.borrow(cs).borrow_mut();
        // Far more than any tick has: a full list shows in the sums.
        let _ = marks.list.push((part, edge, entered.wrapping_sub(marks.taken)));
        marks.taken += marks.around + timer().wrapping_sub(entered);
    });
}

/// Runs `what`; its counts without those of the marks, and the marks since it began.
fn watched<T>(what: impl FnOnce() -> T) -> (T, u32, Vec<Mark, 512>) {
    critical_section::with(|cs| {
        let marks = &mut *MARKS.borrow(cs).borrow_mut();
        marks.list.clear();
        marks.taken = 0;
    });
    let began = timer();
    let result = what();
    let all = timer().wrapping_sub(began);
    let (mut list, taken) = critical_section::with(|cs| {
        let marks = &mut *MARKS.borrow(cs).borrow_mut();
        (core::mem::take(&mut marks.list), marks.taken)
    });
    for mark in &mut list {
        mark.2 = mark.2.wrapping_sub(began);
    }
    (result, all.saturating_sub(taken), list)
}

fn print(text: core::fmt::Arguments) {
    let mut line: String<256> = String::new();
    // A line longer than that would be a defect of this file.
    let _ = line.write_fmt(text);
    let _ = line.push('\n');
    if let Ok(mut out) = hio::hstdout() {
        let _ = out.write_all(line.as_bytes());
    }
}

/// A loop of two instructions, a million in all.
fn million() {
    // SAFETY: touches one register and the flags.
    unsafe {
        core::arch::asm!("2:", "subs {0}, {0}, #1", "bne 2b", inout(reg) 500_000_u32 => _);
    }
}

fn calibrate() -> u32 {
    let began = timer();
    million();
    let million = timer().wrapping_sub(began);
    probe::watch(note);
    let ((), _, list) = watched(|| {
        for _ in 0..200 {
            let _span = probe::span(Part::Step);
        }
    });
    // From one mark to the next with nothing between.
    let span = list.last().map_or(0, |m| m.2) - list.first().map_or(0, |m| m.2);
    critical_section::with(|cs| MARKS.borrow(cs).borrow_mut().around = span / 399);
    million
}

struct Input {
    rest: &'static [u8],
}

impl Input {
    fn next<T: DeserializeOwned>(&mut self) -> Option<T> {
        let (value, rest) = postcard::take_from_bytes(self.rest).ok()?;
        self.rest = rest;
        Some(value)
    }
}

fn input() -> Option<Input> {
    // SAFETY: memory of the board that nothing else uses and nothing writes.
    let [magic, length] = unsafe { (INPUT as *const [u32; 2]).read_volatile() };
    let length = length as usize;
    if magic != MAGIC || length > INPUT_BYTES - 8 {
        return None;
    }
    // SAFETY: as above; the length is within it.
    let rest = unsafe { core::slice::from_raw_parts((INPUT + 8) as *const u8, length) };
    Some(Input { rest })
}

/// Totals of a tick from its marks, and a line for every step.
fn tick(run: impl FnOnce() -> Prediction, hash: &mut u32) {
    let (prediction, total, marks) = watched(run);
    let (next, hashing, _) = watched(|| prediction.hash(*hash));
    *hash = next;
    let (_, encoding, _) = watched(|| telemetry(&prediction));
    let mut inner = [0; 2];
    let mut opened = [0; 3];
    let mut steps = 0;
    let (mut first, mut second, mut ended) = ((0, 0), 0, 0);
    for (part, edge, at) in &marks {
        match edge {
            Edge::Begin => {
                opened[*part as usize] = *at;
                if *part == Part::Step {
                    steps += 1;
                    inner = [0; 2];
                    match steps {
                        1 => first.0 = *at,
                        2 => second = *at,
                        _ => {}
                    }
                }
            }
            Edge::End => {
                let took = at.wrapping_sub(opened[*part as usize]);
                match part {
                    Part::Contacts => inner[0] += took,
                    Part::Cone => inner[1] += took,
                    Part::Step => {
                        print(format_args!("step {steps} {took} {} {}", inner[0], inner[1]));
                        if steps == 1 {
                            first.1 = *at;
                        }
                        ended = *at;
                    }
                }
            }
        }
    }
    print(format_args!(
        "tick {total} {hashing} {encoding} {steps} {} {} {second} {ended} {} {} {}",
        first.0, first.1, prediction.solver_iterations, prediction.solver_status as u8, prediction.validity
    ));
}

fn problem(record: &ProblemRecord) -> Factors<f32, CONTACTS, FREEDOMS> {
    let mut contacts = Vec::new();
    for (normal, tangents, [compliance, friction, separation, first, second]) in &record.1 {
        // As many as the record holds: there is room.
        let _ = contacts.push(Contact {
            normal: *normal,
            tangents: *tangents,
            compliance: *compliance,
            tangential_compliance: 0.0,
            friction: *friction,
            separation: *separation,
            slip: [*first, *second],
        });
    }
    Factors { inverse_mass: record.0, contacts }
}

/// A problem cold, once more from its own answer, and its neighbour from that answer.
#[inline(never)]
fn solve_pair(solver: &mut ContactSolver<f32, CONTACTS, FREEDOMS>, pair: &[ProblemRecord; 2]) {
    let [first, second] = [problem(&pair[0]), problem(&pair[1])];
    solver.forget();
    let (cold, cold_counts, _) = watched(|| solver.solve(&first).report());
    let (same, same_counts, _) = watched(|| solver.solve(&first).report());
    let (moved, moved_counts, _) = watched(|| solver.solve(&second).report());
    let solved = [cold, same, moved].map(|r| u32::from(r.status == SolveStatus::Solved));
    print(format_args!(
        "solve {cold_counts} {same_counts} {moved_counts} {} {} {}",
        solved[0], solved[1], solved[2]
    ));
}

/// What a solver says, what it took, and its answer, number by number as bits.
fn print_answer(report: Report<f32>, counts: u32, z: &[f32]) {
    print(format_args!("answer {} {} {} {counts}", report.status as u8, report.pivots, z.len()));
    for part in z.chunks(8) {
        let mut line: String<128> = String::new();
        let _ = line.push('z');
        for number in part {
            // Eight numbers of ten digits fit.
            let _ = write!(line, " {}", number.to_bits());
        }
        print(format_args!("{line}"));
    }
}

#[inline(never)]
fn solve_contact(solver: &mut ContactSolver<f32, CONTACTS, FREEDOMS>, record: &ProblemRecord) {
    let problem = problem(record);
    let mut z = [0.0; 6 * CONTACTS];
    let z = z.get_mut(..problem.unknowns()).unwrap_or_default();
    solver.forget();
    let (report, counts, _) = watched(|| {
        let (impulses, report) = solver.solve(&problem).best();
        impulses.write_unknowns(z);
        report
    });
    print_answer(report, counts, z);
}

#[inline(never)]
fn solve_dense(record: &DenseRecord) {
    let mut solver = Dense::<f32, { UNKNOWNS + 2 }>::new();
    let (outcome, counts, _) = watched(|| solver.solve(&record.0, &record.1));
    let (z, report) = outcome.best();
    print_answer(report, counts, z);
}

fn telemetry(prediction: &Prediction) -> usize {
    let report = TelemetryReport { prediction: *prediction, ..Default::default() };
    let mut line = [0; MAX_LINE];
    encode(wire::Telemetry::TOPIC_KEY, 0, &report, &mut line).map_or(0, <[u8]>::len)
}

/// A word that the stack does not hold by chance.
const PAINT: u32 = 0x5741_4c4c;
const PAINTED_WORDS: usize = 16 << 10;

/// Words from here down that nothing uses yet.
fn paint() -> *mut u32 {
    let here = cortex_m::register::msp::read() as usize & !3;
    let lowest = (here - 256 - 4 * PAINTED_WORDS) as *mut u32;
    for k in 0..PAINTED_WORDS {
        // SAFETY: 4 MiB of RAM, less than a tenth of it in use, lie below the stack pointer.
        unsafe { lowest.add(k).write_volatile(PAINT) };
    }
    lowest
}

/// Bytes of stack used below this function since [`paint`].
fn depth(lowest: *mut u32) -> usize {
    let untouched =
        // SAFETY: what `paint` wrote.
        (0..PAINTED_WORDS).take_while(|k| unsafe { lowest.add(*k).read_volatile() } == PAINT).count();
    256 + 4 * (PAINTED_WORDS - untouched)
}

#[entry]
fn main() -> ! {
    let _board = board::init(false);
    let million = calibrate();
    let around = critical_section::with(|cs| MARKS.borrow(cs).borrow().around);
    print(format_args!("million {million} {around}"));
    match run() {
        Some(()) => debug::exit(debug::EXIT_SUCCESS),
        None => {
            print(format_args!("malformed"));
            debug::exit(debug::EXIT_FAILURE);
        }
    }
    board::halt()
}

fn run() -> Option<()> {
    let mut input = input()?;
    let (trials, formulation, seed, ticks, horizon_s, pairs, contact, dense): Head = input.next()?;
    let mut hash = HASH_START;
    for k in 0..trials {
        let ((scene, model, limits), plan, ordinal, count): Trial = input.next()?;
        print(format_args!("trial {k}"));
        let mut predictor = Predictor::new(scene, model, limits).ok()?;
        predictor.set_plan(plan);
        predictor.set_trial(ordinal);
        let lowest = paint();
        for _ in 0..count {
            let sample: wire::Sample = input.next()?;
            tick(|| predictor.take(&sample), &mut hash);
        }
        print(format_args!("stack {}", depth(lowest)));
    }
    let mut solver = ContactSolver::new();
    for _ in 0..pairs {
        solve_pair(&mut solver, &[input.next()?, input.next()?]);
    }
    for _ in 0..contact {
        solve_contact(&mut solver, &input.next()?);
    }
    for _ in 0..dense {
        solve_dense(&input.next()?);
    }
    if ticks > 0 {
        print(format_args!("selftest"));
        selftest::each(formulation, seed, ticks, horizon_s, |predictor, sample| {
            tick(|| predictor.tick(sample), &mut hash)
        });
    }
    print(format_args!("end {hash}"));
    Some(())
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    board::halt()
}
