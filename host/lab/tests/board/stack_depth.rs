//! The deepest that the stack of the real board's firmware can be, by the frames in its machine code: beside the variables it
//! must fit into 96 KiB, and into the budget that the soak holds the painted stack to. `make size` builds the firmware and
//! names the file in `STICKSLIP_G474_ELF`.
//!
//! All share one stack, and each can interrupt those before it: what starts the unit and then idles, the deepest task of the
//! lower executor, the tick, and a handler of each of the priorities above it. A processor that takes an interrupt puts 26
//! words and a filler there (Armv7-M manual, B1.5.7). Calls through a register go to effects and wakers, each counted with the
//! deepest of them; those of the executors go to their tasks. Behind a panic comes a reset: its frames end the count.

use std::collections::BTreeMap;

use super::code::Code;

/// What an interrupt puts on the stack: registers with those of the floating-point unit, and a word to align it.
const EXCEPTION_BYTES: u64 = 27 * 4;
/// Interrupt priorities above that of the tick: 0, 1 and 2 (`board::init`).
const PRIORITIES_ABOVE: usize = 3;
/// RAM of the board (SRAM1 and SRAM2), bytes.
const RAM_BYTES: u64 = 96 << 10;
/// What starts the unit.
const START: &[&str] = &["stickslip_firmware", "5start", "5begin"];

struct Depths<'a> {
    code: &'a Code,
    /// Deepest of what is called through a register.
    tabled: u64,
    known: BTreeMap<u64, (u64, Option<u64>)>,
}

impl<'a> Depths<'a> {
    fn of(code: &'a Code) -> Self {
        let mut depths = Self { code, tabled: 0, known: BTreeMap::new() };
        let tabled: Vec<u64> = code.tabled.iter().map(|at| depths.deepest(*at, &mut Vec::new())).collect();
        assert!(
            code.tabled.iter().all(|at| !code.name(*at).contains("effects") || !code.indirect.contains(at)),
            "an effect that calls through a register"
        );
        depths.tabled = tabled.into_iter().max().unwrap_or(0);
        depths.known.clear();
        depths
    }

    /// Bytes from the call of a function on.
    fn deepest(&mut self, at: u64, path: &mut Vec<u64>) -> u64 {
        if let Some((bytes, _)) = self.known.get(&at) {
            return *bytes;
        }
        let name = self.code.name(at);
        if path.contains(&at) {
            let names: Vec<_> = path.iter().map(|at| self.code.name(*at)).collect();
            panic!("a recursion has no deepest frame: {names:?} -> {name}");
        }
        assert!(!self.code.unbounded.contains(&at), "{name} moves the stack pointer by a register");
        let frame = self.code.functions.get(&at).map_or(0, |f| f.frame);
        let through = if self.code.indirect.contains(&at) { self.tabled } else { 0 };
        let mut below = (through, None);
        if !name.contains("panicking") {
            path.push(at);
            for called in self.code.calls.get(&at).cloned().unwrap_or_default() {
                let bytes = self.deepest(called, path);
                if bytes > below.0 {
                    below = (bytes, Some(called));
                }
            }
            path.pop();
        }
        self.known.insert(at, (frame + below.0, below.1));
        frame + below.0
    }

    /// The same of the first of several functions that is deepest, with its path.
    fn deepest_of(&mut self, all: &[u64]) -> (u64, String) {
        let (bytes, at) =
            all.iter().map(|at| (self.deepest(*at, &mut Vec::new()), *at)).max().expect("a function");
        let mut path = Vec::new();
        let mut next = Some(at);
        while let Some(at) = next {
            let frame = self.code.functions.get(&at).map_or(0, |f| f.frame);
            path.push(format!("    {frame:6} {}", self.code.name(at)));
            next = self.known.get(&at).and_then(|(_, called)| *called);
        }
        (bytes, path.join("\n"))
    }
}

#[test]
#[ignore = "needs the firmware: make size"]
fn the_deepest_stack_by_the_machine_code_fits_beside_the_variables() {
    let code = Code::read(&super::named("STICKSLIP_G474_ELF", "size"));
    let mut depths = Depths::of(&code);
    let tasks = code.tasks();
    let (tick, lower) = tasks.split_first().expect("tasks");
    let start = code.find(START);
    assert!(!start.is_empty(), "no function {START:?}: was it inlined?");
    let parts = [
        ("start", depths.deepest_of(&start)),
        ("a task of the lower executor", depths.deepest_of(lower)),
        ("the tick", depths.deepest_of(&[*tick])),
    ];
    let mut handlers: Vec<u64> =
        code.handlers.iter().map(|at| depths.deepest(*at, &mut Vec::new())).collect();
    handlers.sort_unstable_by(|a, b| b.cmp(a));
    for (what, (bytes, path)) in &parts {
        println!("{what}: {bytes} bytes\n{path}");
    }
    let above: u64 = handlers.iter().take(PRIORITIES_ABOVE).sum();
    // While the unit starts no tick runs: its own frame stands under tasks, what it calls does not.
    let [(_, (start_bytes, _)), (_, (lower_bytes, _)), (_, (tick_bytes, _))] = &parts;
    let frame = start.iter().filter_map(|at| code.functions.get(at)).map(|f| f.frame).max().unwrap_or(0);
    let running = frame + lower_bytes + tick_bytes;
    let exceptions = EXCEPTION_BYTES * (2 + PRIORITIES_ABOVE as u64);
    let bound = running.max(*start_bytes) + above + exceptions;
    println!(
        "deepest: {frame} + {lower_bytes} + {tick_bytes}, handlers {above}, exceptions {exceptions}: {bound} bytes; \
         variables {} bytes; {} of {RAM_BYTES} left",
        code.static_bytes,
        RAM_BYTES.saturating_sub(bound + code.static_bytes)
    );
    let budget = budget();
    assert!(bound <= budget, "{bound} bytes of stack, the budget is {budget} (firmware/src/stack.rs)");
    assert!(bound + code.static_bytes <= RAM_BYTES, "stack and variables do not fit");
}

/// `BUDGET_BYTES` of the firmware, which this crate does not link.
fn budget() -> u64 {
    let source = include_str!("../../../../firmware/src/stack.rs");
    let line = source.lines().find(|line| line.contains("const BUDGET_BYTES")).expect("BUDGET_BYTES");
    let digits: String = line.chars().skip_while(|c| *c != '=').filter(char::is_ascii_digit).collect();
    digits.parse().expect("a number")
}
