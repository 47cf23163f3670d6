//! No path from the control task, or from a handler of the vector table, to a panic may be linked: `make no-panic`
//! builds the firmware of the real board and names the file in `STICKSLIP_NO_PANIC_ELF`. Without it there is nothing
//! to check.
//!
//! The task is the function that the executor polls and all that it calls: the tick with
//! converters and queues, the predictor, waiting for the next tick, the logs. The calls are
//! read from the machine code ([`super::code`]). What is called through a table counts as
//! called by the task where the table is one of the effects' (`dyn Law`), which the step calls, or of a waker, which queues
//! call. A call through a register in any other function than those listed here fails the check: nobody knows where it goes.
//!
//! Handlers are those of the vector table but the reset's: what fails while the unit starts is told by a reset, and no grasp
//! depends on it. The tasks of the lower executor (link, sensors) are called through a register and not followed:
//! a panic there is a reset into what is stored.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use super::code::Code;

/// The predictor's part of the tick.
const PREDICTOR: &[&str] = &["control", "7predict"];
/// Callers and panics that stay, all in embassy. Its time driver borrows its timer queue in a
/// critical section and gives it back there, so it is never found borrowed. And it refuses a
/// waker that is not its executor's: the control task is polled by that executor with no other.
const EXEMPT: &[(&str, &str)] = &[
    ("_embassy_time_schedule_wake", "panic_already_borrowed"),
    ("_embassy_time_schedule_wake", "borrow_mut"),
    // It says so in the log, then panics.
    ("_embassy_time_queue_item_from_waker", "acquire_header_and_release"),
    ("_embassy_time_queue_item_from_waker", "defmt_default_panic"),
    // The same where that function is inlined.
    ("_embassy_time_schedule_wake", "acquire_header_and_release"),
    ("_embassy_time_schedule_wake", "defmt_default_panic"),
    // The timer's interrupt borrows the same queue in the same way.
    ("TIM1_BRK_TIM15", "panic_already_borrowed"),
    // DMA met an address that is none: the converters' and the table of counts are fixed.
    ("dma_bdma", "defmt_default_panic"),
    // Reading the CAN controller's memory: number of an element, a length by a frame's code (at most 64), slices of it, and a
    // time by a counter that is off are the controller's own, not what a frame says.
    ("RxMode12on_interrupt", "peripheral9Registers4read"),
    ("FDCAN1_IT0", "peripheral9Registers4read"),
    ("calc_timestamp", "expect_failed"),
    // The handler borrows the driver's state in a critical section and gives it back there, as its users do.
    ("FDCAN1_IT0", "panic_already_borrowed"),
    // The handler writes frames in the driver's buffered mode only, which is not used.
    ("FDCAN1_IT0", "peripheral9Registers5write"),
    // The log's writer refuses to be taken twice, and to be released by one that does not hold it: it is taken and released in
    // pairs, in a critical section, and nothing is logged between.
    ("_defmt_acquire", "panic_fmt"),
    ("_defmt_release", "panic_fmt"),
];
const FORBIDDEN: &[&str] =
    &["panicking", "rust_begin_unwind", "unwrap_failed", "expect_failed", "defmt_panic"];

/// Functions that call through a register, and where to.
const INDIRECT: &[&str] = &[
    // Wakers: their table is followed.
    "_embassy_time_schedule_wake",
    "next_expiration",
    "AtomicWaker",
    // Effects: their tables are followed.
    "5patch10of_effects",
    "step7step_in",
    // The executors: the control task is a root, the lower one's tasks are not followed (above).
    "UART4",
    "UART5",
    // Queues of the CAN driver's buffered mode, which is not used.
    "FDCAN1_IT0",
    "RxMode12on_interrupt",
    // The writer of logs, one function of defmt-rtt.
    "_defmt_acquire",
    "_defmt_release",
    "_defmt_write",
];

#[test]
#[ignore = "needs the firmware: make no-panic"]
fn the_control_task_cannot_panic() {
    let code = Code::read(&super::named("STICKSLIP_NO_PANIC_ELF", "no-panic"));
    assert!(!code.find(PREDICTOR).is_empty(), "no function {PREDICTOR:?}: was it inlined?");
    let task = code.tasks()[0];
    let mut from: BTreeMap<u64, u64> = BTreeMap::new();
    let mut queue: VecDeque<u64> = [task].iter().chain(&code.handlers).chain(&code.tabled).copied().collect();
    let mut seen: BTreeSet<u64> = queue.iter().copied().collect();
    let (mut bad, mut anywhere) = (Vec::new(), Vec::new());
    while let Some(at) = queue.pop_front() {
        let name = code.name(at);
        if FORBIDDEN.iter().any(|word| name.contains(word)) {
            bad.push(path_to(at, &from, &code));
            continue;
        }
        if code.indirect.contains(&at) && !INDIRECT.iter().any(|known| name.contains(known)) {
            anywhere.push(path_to(at, &from, &code));
        }
        for &target in code.calls.get(&at).into_iter().flatten() {
            let called = code.name(target);
            if EXEMPT.iter().any(|(caller, panic)| name.contains(caller) && called.contains(panic)) {
                continue;
            }
            if seen.insert(target) {
                from.insert(target, at);
                queue.push_back(target);
            }
        }
    }
    println!("{} functions reached from the control task", seen.len());
    assert!(seen.len() > 60, "only {} functions reached: calls were not found", seen.len());
    assert!(bad.is_empty(), "the control task or a handler can panic:\n{}", bad.join("\n"));
    assert!(anywhere.is_empty(), "calls through a register that nobody knows:\n{}", anywhere.join("\n"));
}

fn path_to(end: u64, from: &BTreeMap<u64, u64>, code: &Code) -> String {
    let mut names = Vec::new();
    let mut at = Some(end);
    while let Some(address) = at {
        names.push(code.name(address));
        at = from.get(&address).copied();
    }
    names.reverse();
    format!("  {}", names.join("\n    -> "))
}
