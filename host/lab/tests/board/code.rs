//! A firmware's functions, what calls what, and what each takes of the stack, read from its machine code.
//!
//! Calls are `bl` and `b.w` of Thumb-2 (Armv7-M manual, A7.7.12 and A7.7.18); what mapping symbols (`$d`) say to be data is
//! not read as code. What is called through a register is not followed here: such functions are listed.
//!
//! A function's frame is the sum of everything in it that moves the stack pointer down, wherever it stands: no path
//! through it takes more. One that moves it by a register is listed apart.

use std::collections::{BTreeMap, BTreeSet};

use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};

/// What the control task is: the function that the executor polls and that calls the tick.
const TASK: &[&str] = &["TaskStorage", "4poll"];
const TICK: &[&str] = &["control", "Control", "4tick"];

/// A function.
pub struct Function {
    /// As linked.
    pub name: String,
    /// Behind its last instruction.
    pub end: u64,
    /// Bytes of stack, without what it calls.
    pub frame: u64,
}

/// A firmware's code, by the addresses of its functions.
pub struct Code {
    pub functions: BTreeMap<u64, Function>,
    pub calls: BTreeMap<u64, BTreeSet<u64>>,
    /// Functions that call through a register.
    pub indirect: BTreeSet<u64>,
    /// Functions that move the stack pointer by a register, or to where one says.
    pub unbounded: BTreeSet<u64>,
    /// Handlers of the vector table, but the reset's.
    pub handlers: BTreeSet<u64>,
    /// What tables of constant data name: effects, wakers.
    pub tabled: Vec<u64>,
    /// Bytes of memory that variables take.
    pub static_bytes: u64,
}

impl Code {
    /// Of an ELF file with its symbols.
    pub fn read(path: &std::ffi::OsStr) -> Self {
        let bytes = std::fs::read(path).expect("the firmware can be read");
        let file = object::File::parse(&*bytes).expect("the firmware is an ELF file");
        let mut functions: BTreeMap<u64, Function> = BTreeMap::new();
        for symbol in file.symbols().filter(|s| s.kind() == SymbolKind::Text && s.size() > 0) {
            let (start, name) = (symbol.address() & !1, symbol.name().unwrap_or_default().to_owned());
            functions.insert(start, Function { name, end: start + symbol.size(), frame: 0 });
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
        let (mut indirect, mut unbounded) = (BTreeSet::new(), BTreeSet::new());
        for (&start, function) in &mut functions {
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
                    if first & 0xff87 == 0x4685 {
                        unbounded.insert(start);
                    }
                    function.frame += pushed_by_half(first);
                    at += 2;
                    continue;
                }
                let Some(second) = half(at + 2) else { break };
                if loads_pc(first, second) {
                    indirect.insert(start);
                }
                match pushed_by_word(first, second) {
                    Some(bytes) => function.frame += bytes,
                    None => drop(unbounded.insert(start)),
                }
                if let Some(target) = branch(at, first, second)
                    && !(start..function.end).contains(&target)
                {
                    calls.entry(start).or_default().insert(*thunks.get(&target).unwrap_or(&target));
                }
                at += 4;
            }
        }
        let handlers = handlers(&file);
        assert!(handlers.len() > 5, "the vector table was not found");
        let unknown: Vec<_> = handlers.iter().filter(|at| !functions.contains_key(*at)).collect();
        assert!(unknown.is_empty(), "handlers that are no functions: {unknown:x?}");
        let tabled: Vec<u64> = tables(&file)
            .filter(|target| {
                let tabled = |f: &Function| f.name.contains("effects") || f.name.contains("waker");
                functions.get(target).is_some_and(tabled)
            })
            .collect();
        assert!(tabled.len() > 20, "the tables of the effects were not found: {}", tabled.len());
        let static_bytes = [".data", ".bss", ".uninit"]
            .map(|name| file.section_by_name(name).map_or(0, |section| section.size()))
            .iter()
            .sum();
        Self { functions, calls, indirect, unbounded, handlers, tabled, static_bytes }
    }

    /// The name of a function.
    pub fn name(&self, at: u64) -> &str {
        self.functions.get(&at).map_or("?", |f| f.name.as_str())
    }

    /// Functions whose names have all of the words.
    pub fn find(&self, words: &[&str]) -> Vec<u64> {
        let named = |f: &Function| words.iter().all(|w| f.name.contains(w));
        self.functions.iter().filter(|(_, f)| named(f)).map(|(at, _)| *at).collect()
    }

    /// All tasks, the one that calls the tick first.
    pub fn tasks(&self) -> Vec<u64> {
        let ticks = self.find(TICK);
        assert!(!ticks.is_empty(), "no function {TICK:?}: was it inlined?");
        let control =
            |at: &u64| self.calls.get(at).is_some_and(|called| ticks.iter().any(|t| called.contains(t)));
        let (mut own, others): (Vec<u64>, Vec<u64>) = self.find(TASK).iter().partition(|at| control(at));
        assert_eq!(own.len(), 1, "one task calls the tick");
        own.extend(others);
        own
    }
}

/// Bytes by which a half word's instruction moves the stack pointer down: `push` and `sub sp` (A7.7.101, A7.7.176).
fn pushed_by_half(half: u16) -> u64 {
    match half {
        0xb400..=0xb5ff => 4 * u64::from((half & 0x1ff).count_ones()),
        0xb080..=0xb0ff => 4 * u64::from(half & 0x7f),
        _ => 0,
    }
}

/// The same of a word's: `push`, `vpush`, stores that move the pointer before, `sub sp`, `subw sp` (A7.7.101, A7.7.159,
/// A7.7.175, A7.7.250); `None` where a register says by how much.
fn pushed_by_word(first: u16, second: u16) -> Option<u64> {
    let low = u64::from(second & 0xff);
    Some(match (first, second) {
        // stmdb sp!, {...}
        (0xe92d, _) => 4 * u64::from(second.count_ones()),
        // vpush of doubles or singles: as many words as it says.
        (_, _) if first & 0xffbf == 0xed2d && second & 0x0e00 == 0x0a00 => 4 * low,
        // str, strh, strb [sp, #-x]!
        (0xf84d | 0xf82d | 0xf80d, _) if second & 0x0f00 == 0x0d00 => low,
        // strd [sp, #-x]!
        (0xe96d, _) => 4 * low,
        // sub.w sp, sp, #modified constant
        (0xf1ad | 0xf5ad | 0xf1bd | 0xf5bd, _) if second & 0x8f00 == 0x0d00 => modified(first, second),
        // subw sp, sp, #x
        (0xf2ad | 0xf6ad, _) if second & 0x8f00 == 0x0d00 => {
            u64::from(first >> 10 & 1) << 11 | u64::from(second >> 12 & 7) << 8 | low
        }
        // sub.w sp, sp, register
        (0xebad, _) if second & 0x0f00 == 0x0d00 => return None,
        _ => 0,
    })
}

/// The constant of a 32-bit instruction (A5.3.2).
fn modified(first: u16, second: u16) -> u64 {
    let code = (first >> 10 & 1) << 11 | (second >> 12 & 7) << 8 | second & 0xff;
    let byte = u64::from(code & 0xff);
    match code >> 8 {
        0 => byte,
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte << 24 | byte << 16 | byte << 8 | byte,
        _ => u64::from((0x80 | u32::from(code & 0x7f)).rotate_right(u32::from(code >> 7))),
    }
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
