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
//! depends on it.
//!
//! The tasks of the lower executor (link, sensors), which their handler calls through a register, are roots of a test of
//! their own: none of this project's functions in them panics, but drivers and the storage that they are made of check
//! themselves, in the places listed here. A panic there is a reset into what is stored.

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
/// Callers and panics that stay in the tasks of the lower executor, beside those above.
const EXEMPT_BELOW: &[(&str, &str)] = &[
    // A future that is polled after its end: its task, or the future that awaits it, does not do so.
    ("TaskStorage", "async_fn_resumed"),
    ("write_all", "async_fn_resumed"),
    ("8block_on", "async_fn_resumed"),
    ("5lines4send", "async_fn_resumed"),
    // The CAN driver's `write`: it borrows its state in a critical section and gives it back there, as its handler does.
    ("5lines4send", "panic_already_borrowed"),
    ("6stored9has_model", "async_fn_resumed"),
    ("6memory15Memory", "async_fn_resumed"),
    ("18sequential_storage", "async_fn_resumed"),
    // In the tasks themselves, what the compiler put there of `embassy_stm32::usart` and `can` and of their waiting: the
    // state of a driver's own transfer, frame or wakers.
    ("TaskStorage", "unwrap_failed"),
    ("TaskStorage", "expect_failed"),
    ("TaskStorage", "9panic_fmt"),
    ("TaskStorage", "slice_index_fail"),
    ("TaskStorage", "panic_already_borrowed"),
    ("TaskStorage", "defmt_default_panic"),
    ("TaskStorage", "acquire_header_and_release"),
    ("write_all", "9panic_fmt"),
    ("write_all", "unwrap_failed"),
    ("write_all", "slice_index_fail"),
    ("future..select..Select", "panic_bounds_check"),
    ("future..select..Select", "expect_failed"),
    // Number of a DMA channel, fixed when it is built; its ring is not empty; an address that is none.
    ("3dma8dma_bdma", "panic_bounds_check"),
    ("dma..dma_bdma..Transfer", "panic_bounds_check"),
    ("3dma8dma_bdma", "div_by_zero"),
    ("3dma8dma_bdma", "rem_by_zero"),
    ("3dma8dma_bdma", "defmt_default_panic"),
    ("3dma10ringbuffer", "panic_bounds_check"),
    // The CAN controller's memory, as in its handler; a frame's length is one that a frame may have.
    ("peripheral9Registers", "panic_bounds_check"),
    ("peripheral9Registers", "slice_index_fail"),
    ("peripheral9Registers", "defmt_default_panic"),
    ("10peripheral13extract_frame", "slice_index_fail"),
    ("10peripheral19data_from_tx_buffer", "slice_index_fail"),
    ("3can8_version6TxMode8register", "defmt_default_panic"),
    ("10DataLength3new", "defmt_default_panic"),
    ("6FdData3new", "slice_index_fail"),
    // Page and bank of an address in the flash, a word of eight bytes: those of the board's own range.
    ("5flash6common", "div_by_zero"),
    ("5flash6common", "defmt_default_panic"),
    ("flash..FlashBank", "defmt_default_panic"),
    // The storage looks up its own checksum that is never zero, a buffer that it took and put back, parts of a header of
    // fixed length, states of pages that it has just read.
    ("18sequential_storage", "unwrap_failed"),
    ("18sequential_storage", "slice_index_fail"),
    ("18sequential_storage", "13assert_failed"),
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
    // The executors: all their tasks are roots.
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

/// The same in the tasks of the lower executor.
const INDIRECT_BELOW: &[&str] = &[
    // Wakers, also where they stand in the task itself.
    "WakerRegistration",
    "TaskStorage",
    // What is stored: the bytes of one type.
    "16store_item_inner",
];

/// What functions reach.
struct Reached {
    functions: usize,
    /// Paths to panics that stay nowhere in the lists.
    panics: Vec<String>,
    /// Paths to calls through a register that are not listed.
    anywhere: Vec<String>,
}

fn reach(code: &Code, roots: &[u64], exempt: &[&[(&str, &str)]], indirect: &[&[&str]]) -> Reached {
    let mut from: BTreeMap<u64, u64> = BTreeMap::new();
    let mut queue: VecDeque<u64> = roots.iter().copied().collect();
    let mut seen: BTreeSet<u64> = queue.iter().copied().collect();
    let mut reached = Reached { functions: 0, panics: Vec::new(), anywhere: Vec::new() };
    while let Some(at) = queue.pop_front() {
        let name = code.name(at);
        if FORBIDDEN.iter().any(|word| name.contains(word)) {
            reached.panics.push(path_to(at, &from, code));
            continue;
        }
        let known = indirect.iter().copied().flatten();
        if code.indirect.contains(&at) && !known.into_iter().any(|known| name.contains(known)) {
            reached.anywhere.push(path_to(at, &from, code));
        }
        for &target in code.calls.get(&at).into_iter().flatten() {
            let called = code.name(target);
            let mut stay = exempt.iter().copied().flatten();
            if stay.any(|(caller, panic)| name.contains(caller) && called.contains(panic)) {
                continue;
            }
            if seen.insert(target) {
                from.insert(target, at);
                queue.push_back(target);
            }
        }
    }
    reached.functions = seen.len();
    reached
}

fn check(reached: &Reached, who: &str) {
    println!("{} functions reached from {who}", reached.functions);
    assert!(reached.functions > 60, "only {} functions reached: calls were not found", reached.functions);
    assert!(reached.panics.is_empty(), "{who} can panic:\n{}", reached.panics.join("\n"));
    let anywhere = reached.anywhere.join("\n");
    assert!(anywhere.is_empty(), "calls through a register from {who} that nobody knows:\n{anywhere}");
}

fn firmware() -> Code {
    Code::read(&super::named("STICKSLIP_NO_PANIC_ELF", "no-panic"))
}

#[test]
#[ignore = "needs the firmware: make no-panic"]
fn neither_the_control_task_nor_a_handler_can_panic() {
    let code = firmware();
    assert!(!code.find(PREDICTOR).is_empty(), "no function {PREDICTOR:?}: was it inlined?");
    let task = code.tasks()[0];
    let roots: Vec<u64> = [task].iter().chain(&code.handlers).chain(&code.tabled).copied().collect();
    check(&reach(&code, &roots, &[EXEMPT], &[INDIRECT]), "the control task or a handler");
}

#[test]
#[ignore = "needs the firmware: make no-panic"]
fn the_other_tasks_panic_only_where_drivers_and_storage_check_themselves() {
    let code = firmware();
    let tasks = code.tasks();
    // Receiving, sending, serial sensor, CAN.
    assert_eq!(tasks.len(), 5, "tasks of the firmware");
    let reached = reach(&code, &tasks[1..], &[EXEMPT, EXEMPT_BELOW], &[INDIRECT, INDIRECT_BELOW]);
    check(&reached, "a task of the lower executor");
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
