//! What is kept over a reset: how it ended, where, and the last ticks before.
//!
//! Words in memory that a reset leaves alone, with a mark and a checksum, since after power-on they hold anything.
//! A tick is noted at its beginning and its end: where the watchdog ended it, the last note has no cost.

use stickslip_shared::wire::{Ending, PostMortem, TickNote};

/// Ticks that are kept.
const TICKS: usize = 4;
/// Mark, starts, ending, pc, lr, line, checksum of these; ticks of three words.
pub const WORDS: usize = HEAD + 3 * TICKS;
const HEAD: usize = 7;
/// Of them the one with the starts.
pub const STARTS: usize = 1;

const MARK: u32 = 0x57_1c_51_1b;

/// The words, wherever they lie.
#[derive(Debug)]
pub struct Recorder<'a> {
    words: &'a mut [u32; WORDS],
    next: usize,
}

fn sum(head: &[u32]) -> u32 {
    // FNV-1a over whole words: six of them.
    head.iter().fold(0x811c_9dc5, |hash, word| (hash ^ word).wrapping_mul(0x0100_0193))
}

fn ending(word: u32) -> Ending {
    match word {
        1 => Ending::Panic,
        2 => Ending::HardFault,
        3 => Ending::StackOverflow,
        4 => Ending::Watchdog,
        5 => Ending::MemoryDamaged,
        _ => Ending::Unnoted,
    }
}

impl<'a> Recorder<'a> {
    /// After a start of the processor: what was kept, `None` after power-on, and the starts since then, this one
    /// included. Begins a new record.
    pub fn begin(words: &'a mut [u32; WORDS]) -> (Self, Option<PostMortem>, u32) {
        let [mark, starts, end, pc, lr, line, checksum, ticks @ ..] = &*words;
        let known = *mark == MARK && *checksum == sum(&[*mark, *starts, *end, *pc, *lr, *line]);
        let (kept, starts) = if known {
            let mut last = [TickNote::default(); TICKS];
            for (note, words) in last.iter_mut().zip(ticks.chunks_exact(3)) {
                if let [tick, flags, cost] = *words {
                    *note = TickNote { tick, flags, cost };
                }
            }
            last.sort_unstable_by_key(|note| note.tick);
            let kept = PostMortem { ending: ending(*end), pc: *pc, lr: *lr, line: *line, last };
            (Some(kept), starts.wrapping_add(1))
        } else {
            (None, 1)
        };
        *words = [0; WORDS];
        let recorder = Self { words, next: 0 };
        let [mark, second, ..] = &mut *recorder.words;
        (*mark, *second) = (MARK, starts);
        note_end(recorder.words, Ending::Unnoted, 0, 0, 0);
        (recorder, kept, starts)
    }

    /// The tick begins.
    pub fn tick_begins(&mut self, tick: u32) {
        self.next = (self.next + 1) % TICKS;
        self.note(TickNote { tick, flags: 0, cost: 0 });
    }

    /// The tick that began has ended.
    pub fn tick_ends(&mut self, note: TickNote) {
        self.note(note);
    }

    fn note(&mut self, note: TickNote) {
        if let Some([tick, flags, cost]) =
            self.words.get_mut(HEAD + 3 * self.next..).and_then(|w| w.first_chunk_mut())
        {
            (*tick, *flags, *cost) = (note.tick, note.flags, note.cost);
        }
    }
}

/// Notes the end in the words of a recorder, from a handler that has nothing but them.
pub fn note_end(words: &mut [u32; WORDS], how: Ending, pc: u32, lr: u32, line: u32) {
    let [mark, starts, end, at, from, in_line, checksum, ..] = words;
    let code = match how {
        Ending::Unnoted => 0,
        Ending::Panic => 1,
        Ending::HardFault => 2,
        Ending::StackOverflow => 3,
        Ending::Watchdog => 4,
        Ending::MemoryDamaged => 5,
    };
    (*end, *at, *from, *in_line) = (code, pc, lr, line);
    *checksum = sum(&[*mark, *starts, code, pc, lr, line]);
}
