//! What is kept over a reset.

use proptest::prelude::*;
use stickslip_shared::wire::{Ending, TickNote};
use stickslip_unit::post_mortem::{Recorder, WORDS, note_end};

#[test]
fn after_power_on_nothing_is_told_and_after_a_reset_the_end_and_the_last_ticks() {
    let mut words = [0xdead_beef; WORDS];
    let (mut recorder, kept, starts) = Recorder::begin(&mut words);
    assert_eq!((kept, starts), (None, 1));
    for tick in 1..=10 {
        recorder.tick_begins(tick);
        if tick < 10 {
            recorder.tick_ends(TickNote { tick, flags: 7, cost: 100 + tick });
        }
    }
    note_end(&mut words, Ending::HardFault, 0x0800_1234, 0x0800_5678, 0);
    let (_, kept, starts) = Recorder::begin(&mut words);
    let kept = kept.expect("kept");
    assert_eq!((kept.ending, kept.pc, kept.lr, starts), (Ending::HardFault, 0x0800_1234, 0x0800_5678, 2));
    assert_eq!(kept.last.map(|note| note.tick), [7, 8, 9, 10]);
    // The tenth began and did not end.
    assert_eq!(kept.last.map(|note| note.cost), [107, 108, 109, 0]);
}

#[test]
fn a_reset_that_nothing_noted_is_told_as_such() {
    let mut words = [0; WORDS];
    let _ = Recorder::begin(&mut words);
    let (_, kept, _) = Recorder::begin(&mut words);
    assert_eq!(kept.map(|k| (k.ending, k.pc)), Some((Ending::Unnoted, 0)));
}

proptest! {
    #[test]
    fn words_of_any_kind_are_survived(mut words in any::<[u32; WORDS]>(), pc in any::<u32>()) {
        let (_, kept, starts) = Recorder::begin(&mut words);
        prop_assert!(kept.is_none() && starts == 1, "a mark and a checksum by chance");
        note_end(&mut words, Ending::Panic, pc, 0, 77);
        let (_, kept, _) = Recorder::begin(&mut words);
        prop_assert_eq!(kept.map(|k| (k.ending, k.pc, k.line)), Some((Ending::Panic, pc, 77)));
    }
}
