//! No path from the control task, or from a handler of the vector table, to a panic may be linked: `make no-panic`
//! builds the firmware of the real board and names the file in `STICKSLIP_NO_PANIC_ELF`. Without it there is nothing
//! to check.
//!
//! The task is the function that the executor polls and all that it calls: the tick with
//! converters and queues, the predictor, waiting for the next tick, the logs. The calls are
//! read from the machine code: `bl` and `b.w` of Thumb-2 (Armv7-M manual, A7.7.12 and
//! A7.7.18); what mapping symbols (`$d`) say to be data is not read as code. What is called through a table counts as
//! called by the task where the table is one of the effects' (`dyn Law`), which the step calls, or of a waker, which queues
//! call. A call through a register in any other function than those listed here fails the check: nobody knows where it goes.
//!
//! Handlers are those of the vector table but the reset's: what fails while the unit starts is told by a reset, and no grasp
//! depends on it. The tasks of the lower executor (link, sensors) are called through a register and not followed:
//! a panic there is a reset into what is stored.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};

/// The tick, and the predictor's part of it.
const TICKS: [&[&str]; 2] = [&["control", "Control", "4tick"], &["control", "7predict"]];
/// What the executor polls: the task is the one that calls the tick.
const TASK: &[&str] = &["TaskStorage", "4poll"];
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
    "on_board7install",
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

struct Function {
    name: String,
    end: u64,
}

#[test]
#[ignore = "needs the firmware: make no-panic"]
fn the_control_task_cannot_panic() {
    let path = super::named("STICKSLIP_NO_PANIC_ELF", "no-panic");
    let bytes = std::fs::read(&path).expect("STICKSLIP_NO_PANIC_ELF can be read");
    let file = object::File::parse(&*bytes).expect("STICKSLIP_NO_PANIC_ELF is an ELF file");
    let mut functions: BTreeMap<u64, Function> = BTreeMap::new();
    for symbol in file.symbols().filter(|s| s.kind() == SymbolKind::Text && s.size() > 0) {
        let (start, name) = (symbol.address() & !1, symbol.name().unwrap_or_default().to_owned());
        functions.insert(start, Function { name, end: start + symbol.size() });
    }
    let thunks = thunks(&file);
    functions.retain(|at, _| !thunks.contains_key(at));
    let texts = [".text", ".fast"].map(|name| {
        let text = file.section_by_name(name).unwrap_or_else(|| panic!("a section {name}"));
        (text.address(), text.data().expect("its bytes"))
    });
    let half = |address: u64| {
        texts.iter().find_map(|(from, code)| {
            let at = address.checked_sub(*from).and_then(|at| usize::try_from(at).ok())?;
            Some(u16::from_le_bytes([*code.get(at)?, *code.get(at + 1)?]))
        })
    };
    let marks = marks(&file);
    assert!(
        marks.values().filter(|code| !**code).count() > 100,
        "no mapping symbols: was the file stripped?"
    );
    let is_code = |at: u64| marks.range(..=at).next_back().is_none_or(|(_, code)| *code);
    let mut calls: BTreeMap<u64, BTreeSet<u64>> = BTreeMap::new();
    let mut indirect: BTreeSet<u64> = BTreeSet::new();
    for (&start, function) in &functions {
        let mut at = start;
        while at < function.end {
            let Some(first) = half(at) else { break };
            if !is_code(at) {
                at += 2;
                continue;
            }
            if first < 0xe800 {
                if through_register(first) {
                    indirect.insert(start);
                }
                at += 2;
                continue;
            }
            let second = half(at + 2);
            if second.is_some_and(|second| loads_pc(first, second)) {
                indirect.insert(start);
            }
            if let Some(target) = second.and_then(|second| branch(at, first, second))
                && !(start..function.end).contains(&target)
            {
                calls.entry(start).or_default().insert(*thunks.get(&target).unwrap_or(&target));
            }
            at += 4;
        }
    }
    let named = |words: &[&str], name: &str| words.iter().all(|w| name.contains(w));
    let find = |words: &[&str]| -> Vec<u64> {
        functions.iter().filter(|(_, f)| named(words, &f.name)).map(|(at, _)| *at).collect()
    };
    let ticks = TICKS.map(find);
    assert!(ticks.iter().all(|found| !found.is_empty()), "no functions {TICKS:?}: were they inlined?");
    let [tick, _] = &ticks;
    let mut task = find(TASK);
    task.retain(|at| calls.get(at).is_some_and(|called| tick.iter().any(|t| called.contains(t))));
    assert_eq!(task.len(), 1, "one task calls the tick");
    let handlers = handlers(&file);
    assert!(handlers.len() > 5, "the vector table was not found");
    let unknown: Vec<_> = handlers.iter().filter(|at| !functions.contains_key(*at)).collect();
    assert!(unknown.is_empty(), "handlers that are no functions: {unknown:x?}");
    let roots: Vec<u64> = task.into_iter().chain(handlers).collect();
    let tabled: Vec<u64> = tables(&file)
        .filter(|target| {
            let tabled = |f: &Function| f.name.contains("effects") || f.name.contains("waker");
            functions.get(target).is_some_and(tabled)
        })
        .collect();
    assert!(tabled.len() > 20, "the tables of the effects were not found: {}", tabled.len());
    let mut from: BTreeMap<u64, u64> = BTreeMap::new();
    let mut queue: VecDeque<u64> = roots.iter().chain(&tabled).copied().collect();
    let mut seen: BTreeSet<u64> = queue.iter().copied().collect();
    let (mut bad, mut anywhere) = (Vec::new(), Vec::new());
    while let Some(at) = queue.pop_front() {
        let name = functions.get(&at).map_or("", |f| f.name.as_str());
        if FORBIDDEN.iter().any(|word| name.contains(word)) {
            bad.push(path_to(at, &from, &functions));
            continue;
        }
        if indirect.contains(&at) && !INDIRECT.iter().any(|known| name.contains(known)) {
            anywhere.push(path_to(at, &from, &functions));
        }
        for &target in calls.get(&at).into_iter().flatten() {
            let called = functions.get(&target).map_or("", |f| f.name.as_str());
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

/// Target of `bl` or `b.w` at `at`.
fn branch(at: u64, first: u16, second: u16) -> Option<u64> {
    if first & 0xf800 != 0xf000 || second & 0x9000 != 0x9000 {
        return None;
    }
    let (first, second) = (u64::from(first), u64::from(second));
    let bit = |word: u64, place: u32| word >> place & 1;
    let sign = bit(first, 10);
    let i1 = 1 ^ bit(second, 13) ^ sign;
    let i2 = 1 ^ bit(second, 11) ^ sign;
    let offset = sign << 24 | i1 << 23 | i2 << 22 | (first & 0x3ff) << 12 | (second & 0x7ff) << 1;
    let offset = offset.wrapping_sub(sign << 25);
    Some(at.wrapping_add(4).wrapping_add(offset))
}

/// Where the linker's thunks lead, by their addresses: what is too far for a branch is called through one, whose name is that
/// of the function with this before it.
fn thunks(file: &object::File<'_>) -> BTreeMap<u64, u64> {
    const THUNK: &str = "__Thumbv7ABSLongThunk_";
    let by_name: BTreeMap<&str, u64> =
        file.symbols().filter_map(|s| Some((s.name().ok()?, s.address() & !1))).collect();
    let thunks = file.symbols().filter_map(|s| {
        let function = s.name().ok()?.strip_prefix(THUNK)?;
        let target =
            by_name.get(function).unwrap_or_else(|| panic!("a thunk to {function}, which is not there"));
        Some((s.address() & !1, *target))
    });
    thunks.collect()
}

/// From where on there is code (`$t`) or data (`$d`).
fn marks(file: &object::File<'_>) -> BTreeMap<u64, bool> {
    let named = |name: &str, mark: &str| name == mark || name.starts_with(&format!("{mark}."));
    let marks = file.symbols().filter_map(|symbol| {
        let name = symbol.name().ok()?;
        match (named(name, "$t"), named(name, "$d")) {
            (true, _) => Some((symbol.address() & !1, true)),
            (_, true) => Some((symbol.address(), false)),
            _ => None,
        }
    });
    marks.collect()
}

/// `blx` or `bx` of a register that is not the link register, or a move to the program counter (A7.7.19, 20, 77).
fn through_register(half: u16) -> bool {
    let register = half >> 3 & 0xf;
    half & 0xff87 == 0x4780 || (half & 0xff87 == 0x4700 && register != 14) || half & 0xff87 == 0x4687
}

/// A load of the program counter that is no return: not from the stack (A7.7.43).
fn loads_pc(first: u16, second: u16) -> bool {
    matches!(first & 0xfff0, 0xf850 | 0xf8d0) && second >> 12 == 15 && first & 0xf != 13
}

/// Handlers of the vector table, but the reset's: its first two words are the stack and the reset.
fn handlers(file: &object::File<'_>) -> BTreeSet<u64> {
    let table = file.section_by_name(".vector_table").expect("a vector table");
    let words = table.data().expect("its words").chunks_exact(4).skip(2);
    let words = words.map(|w| u64::from(u32::from_le_bytes([w[0], w[1], w[2], w[3]])));
    words.filter(|word| word & 1 == 1).map(|word| word & !1).collect()
}

/// Words of constant data that may be addresses of functions.
fn tables<'a>(file: &'a object::File<'a>) -> impl Iterator<Item = u64> + 'a {
    let sections = file.sections().filter(|s| matches!(s.name(), Ok(".rodata" | ".data")));
    sections
        .flat_map(|s| {
            let data = s.data().unwrap_or_default();
            data.chunks_exact(4)
                .map(|w| u64::from(u32::from_le_bytes([w[0], w[1], w[2], w[3]])))
                .collect::<Vec<_>>()
        })
        .filter(|word| word & 1 == 1)
        .map(|word| word & !1)
}

fn path_to(end: u64, from: &BTreeMap<u64, u64>, functions: &BTreeMap<u64, Function>) -> String {
    let mut names = Vec::new();
    let mut at = Some(end);
    while let Some(address) = at {
        names.push(functions.get(&address).map_or("?", |f| f.name.as_str()));
        at = from.get(&address).copied();
    }
    names.reverse();
    format!("  {}", names.join("\n    -> "))
}
