//! What a unit remembers in two copies: power cut at every byte of a store and again while it is repaired, bits that
//! flip, copies that hold something else. A test's state is told by the number of the unit and the model.

use embassy_futures::block_on;
use stickslip_selftest::push;
use stickslip_shared::wire::frame::crc32;
use stickslip_shared::wire::{self, CHUNK, Mode, ModelChunk, Recalled, Refusal};
use stickslip_unit::memory::{Memory, Settings, VERSION};
use stickslip_unit::slot::Slot;
use stickslip_unit::stored::Stored;
use stickslip_unit::upload::Upload;

use super::bench::{self, Unit};
use super::flash::{Cut, Flash, PAGE, PAGES, RANGE, SharedFlash, WORD, cuts};
use super::memory::settings;

fn model(friction: f32) -> Vec<u8> {
    bench::bytes(&push(friction, 0.4))
}

/// A unit's memory and what it holds of it.
struct Keeper {
    stored: Stored<SharedFlash>,
    flash: SharedFlash,
    upload: Upload,
    slot: Slot,
    settings: Settings,
    recalled: Recalled,
    in_use: Option<u32>,
}

impl Keeper {
    fn start(flash: Flash) -> Self {
        let flash = SharedFlash::of(flash);
        let mut stored = Stored::new(Some(flash.clone()), RANGE);
        let (mut upload, mut slot) = (Upload::default(), Slot::new());
        let (settings, recalled) = stored.recall(&mut upload, &mut slot);
        let in_use = slot.package.as_ref().map(|_| slot.crc);
        Self { stored, flash, upload, slot, settings, recalled, in_use }
    }

    fn send(&mut self, model: &[u8]) {
        for (k, bytes) in model.chunks(CHUNK).enumerate() {
            let bytes = heapless::Vec::from_slice(bytes).unwrap();
            self.upload.take(&ModelChunk { offset: (k * CHUNK) as u16, bytes }).unwrap();
        }
    }

    fn load(&mut self, model: &[u8]) {
        self.send(model);
        self.in_use = Some(crc32(model));
    }

    fn store(&mut self, unit: u32) -> Result<(), Refusal> {
        self.settings = Settings { stamp: self.settings.stamp, ..settings(unit) };
        self.stored.store(&mut self.settings, &self.upload, self.in_use)
    }

    fn flash(&self) -> Flash {
        self.flash.0.borrow().clone()
    }

    /// Unit and model, where all of it is there as it was stored.
    fn state(&self) -> Option<(u32, Option<u32>)> {
        let whole = Settings { stamp: self.settings.stamp, ..settings(self.settings.unit) };
        let sound = self.recalled == Recalled::Done
            && self.settings == whole
            && self.settings.stamp.model == self.in_use.unwrap_or(0)
            && self.in_use.is_none_or(|crc| crc32(self.upload.bytes()) == crc);
        sound.then_some((self.settings.unit, self.in_use))
    }
}

/// Flash in which units 0 to `last` were stored with this model.
fn filled(last: u32, model: &[u8]) -> Flash {
    let mut keeper = Keeper::start(Flash::new());
    keeper.load(model);
    for unit in 0..=last {
        keeper.store(unit).unwrap();
    }
    keeper.flash().powered(None)
}

/// What is stored instead, and how many operations that takes.
fn change(flash: &Flash, model: Option<&[u8]>, left: Option<(usize, Cut)>) -> (Result<(), Refusal>, Flash) {
    let mut keeper = Keeper::start(flash.powered(left));
    if let Some(model) = model {
        keeper.load(model);
    }
    let stored = keeper.store(99);
    (stored, keeper.flash())
}

/// After 3 stores they have room, with 12 old values are moved and pages erased.
fn states() -> impl Iterator<Item = (u32, Option<Vec<u8>>)> {
    [0, 3, 12].into_iter().flat_map(|last| [(last, None), (last, Some(model(0.3)))])
}

#[test]
fn wherever_the_power_is_cut_all_of_the_old_state_or_of_the_new_one_is_there() {
    let old_model = model(0.2);
    let mut moved = false;
    for (last, new_model) in states() {
        let flash = filled(last, &old_model);
        let old = (last, Some(crc32(&old_model)));
        let new = (99, Some(crc32(new_model.as_ref().unwrap_or(&old_model))));
        let (stored, whole) = change(&flash, new_model.as_deref(), None);
        assert_eq!((stored, Keeper::start(whole.powered(None)).state()), (Ok(()), Some(new)));
        assert!(whole.done > 60);
        moved |= whole.erasures > flash.erasures;
        for (at, cut) in (0..whole.done).flat_map(|at| cuts().map(move |cut| (at, cut))) {
            let place = format!("{last} {} {at} of {} {cut:?}", new_model.is_some(), whole.done);
            let (stored, off) = change(&flash, new_model.as_deref(), Some((at, cut)));
            assert_eq!(stored, Err(Refusal::NotStored), "{place}");
            let mut after = Keeper::start(off.powered(None));
            let kept = after.state();
            assert!(kept == Some(old) || kept == Some(new), "{place}: {:?}, {kept:?}", after.recalled);
            // And what is stored next is stored, with its model.
            assert_eq!(after.store(7), Ok(()), "{place}");
            let next = Keeper::start(after.flash().powered(None)).state();
            assert_eq!(next, kept.map(|(_, model)| (7, model)), "{place}");
        }
    }
    assert!(moved, "no page was erased");
}

#[test]
fn a_second_cut_while_the_first_is_repaired_leaves_a_whole_state_too() {
    let (old_model, new_model) = (model(0.2), model(0.3));
    for last in [3, 12] {
        let flash = filled(last, &old_model);
        let (_, whole) = change(&flash, Some(&new_model), None);
        for (at, cut) in (0..whole.done).flat_map(|at| [(at, Cut::Torn), (at, Cut::Part(3))]) {
            let (_, off) = change(&flash, Some(&new_model), Some((at, cut)));
            let kept = Keeper::start(off.powered(None)).state();
            // Of the start and the store that repair it; another step for each, so that all are met.
            for again in (at % 7..).step_by(29) {
                let mut repair = Keeper::start(off.powered(Some((again, Cut::Torn))));
                let stored = repair.store(7);
                let place = format!("{last} {at} of {} {cut:?}, {again}", whole.done);
                let mut after = Keeper::start(repair.flash().powered(None));
                let state = after.state();
                let next = kept.map(|(_, model)| (7, model));
                assert!(
                    state.is_some() && (state == kept || state == next),
                    "{place}: {state:?}, {:?}",
                    after.recalled
                );
                assert_eq!(after.store(8), Ok(()), "{place}");
                let next = Keeper::start(after.flash().powered(None)).state();
                assert_eq!(next.map(|(unit, _)| unit), Some(8), "{place}");
                if stored.is_ok() {
                    break;
                }
            }
        }
    }
}

/// Two bits of every byte of a word.
fn rot(flash: &mut Flash, word: usize) {
    for byte in &mut flash.bytes[word * WORD..][..WORD] {
        *byte ^= 0b0010_0100;
    }
}

#[test]
fn where_bits_of_one_copy_flip_the_other_is_taken_and_of_both_an_older_state_or_none() {
    let (first, second) = (model(0.2), model(0.3));
    for last in [3, 12] {
        let (stored, flash) = change(&filled(last, &first), Some(&second), None);
        assert_eq!(stored, Ok(()));
        let newest = Some((99, Some(crc32(&second))));
        let (mut older, mut none) = (0, 0);
        let half = PAGES * PAGE / WORD / 2;
        for word in 0..half {
            for copy in [0, half] {
                let mut one = flash.powered(None);
                rot(&mut one, copy + word);
                assert_eq!(Keeper::start(one).state(), newest, "word {word} of the copy at {copy}");
            }
            let mut both = flash.powered(None);
            rot(&mut both, word);
            rot(&mut both, half + word);
            let kept = Keeper::start(both);
            match (kept.recalled, kept.state()) {
                (Recalled::Done, state) if state == newest => {}
                (Recalled::Done, state) => {
                    let (unit, model) = state.expect("a state that was stored");
                    assert!(unit <= last && model == Some(crc32(&first)), "word {word}: {state:?}");
                    older += 1;
                }
                (Recalled::WithoutModel, _) => {
                    let unit = kept.settings.unit;
                    assert!(
                        (unit == 99 || unit <= last) && kept.slot.package.is_none(),
                        "word {word}: {unit}"
                    );
                    none += 1;
                }
                (Recalled::Empty | Recalled::Unusable, _) => {
                    assert_eq!((kept.settings, kept.in_use), (Settings::default(), None), "word {word}");
                    none += 1;
                }
                (other, _) => panic!("word {word}: {other:?}"),
            }
        }
        assert!(older + none > 20, "{older} {none}: of both copies nothing was damaged");
    }
}

#[test]
fn settings_whose_model_is_another_one_are_taken_without_it_and_no_run_begins() {
    let flash = SharedFlash::new();
    let mut unit = Unit::start(Some(flash.clone()));
    assert_eq!(unit.load(&model(0.2), CHUNK), Ok(()));
    unit.tick();
    assert_eq!(unit.request::<wire::SetUnit>(&7), Ok(()));
    let link = wire::StartRequest { source: wire::Source::Link, trial: 0.0, prefill: 1, length: None };
    assert_eq!(unit.request::<wire::Store>(&Some(link)), Ok(()));
    for half in [0..RANGE.end / 2, RANGE.end / 2..RANGE.end] {
        let mut copy = Memory::new(flash.clone(), half).unwrap();
        block_on(copy.store_model(&model(0.3))).unwrap();
    }
    let mut again = Unit::start(Some(flash.clone()));
    let info = again.request::<wire::GetInfo>(&());
    assert_eq!(
        (info.recalled, info.unit, info.mode, info.model_crc),
        (Recalled::WithoutModel, 7, Mode::Safe, None)
    );
    assert_eq!(again.tick().map_or(Mode::Safe, |report| report.mode), Mode::Safe);
    // Loaded and stored again, it is as it was.
    assert_eq!(again.load(&model(0.2), CHUNK), Ok(()));
    again.tick();
    assert_eq!(again.request::<wire::Store>(&Some(link)), Ok(()));
    assert_eq!(Unit::start(Some(flash)).request::<wire::GetInfo>(&()).recalled, Recalled::Done);
}

#[test]
fn a_copy_that_holds_something_else_is_replaced_by_a_whole_one_and_the_other_stands_meanwhile() {
    let flash = filled(3, &model(0.2));
    let crc = Some(crc32(&model(0.2)));
    let half = PAGES * PAGE / 2;
    // All written, no page free: nothing that repairs itself.
    for other in [0, half] {
        let mut spoilt = flash.powered(None);
        spoilt.bytes[other..][..half].fill(0);
        let mut keeper = Keeper::start(spoilt);
        assert_eq!(keeper.state(), Some((3, crc)));
        assert_eq!(keeper.store(4), Ok(()));
        // The model came back with the settings: either copy does alone.
        for gone in [0, half] {
            let mut alone = keeper.flash().powered(None);
            alone.bytes[gone..][..half].fill(0);
            assert_eq!(Keeper::start(alone).state(), Some((4, crc)));
        }
    }
}

#[test]
fn a_store_without_the_bytes_of_the_model_in_use_is_refused_and_nothing_is_written() {
    let flash = filled(3, &model(0.2));
    // They are in one copy only.
    let (_, cut) = change(&flash, Some(&model(0.3)), Some((40, Cut::Before)));
    for (flash, answer) in [(flash, Ok(())), (cut, Err(Refusal::NotStored))] {
        let mut keeper = Keeper::start(flash.powered(None));
        // Others were sent, and refused.
        keeper.send(&[1; 100]);
        assert_eq!(keeper.store(4), answer);
        let done = keeper.flash().done;
        assert_eq!(done > 0, answer.is_ok(), "{done} operations");
    }
}

#[test]
fn copies_of_another_version_are_refused_kept_and_replaced_by_what_is_stored_next() {
    use sequential_storage::cache::Cache;
    use sequential_storage::map::{MapConfig, MapStorage};
    // As protocol 12 stored: one ring over all pages. Wherever its newest value lies.
    for stores in [1, 5, 40] {
        let ring = MapConfig::new(RANGE);
        let mut old = MapStorage::<u8, _, _>::new(Flash::new(), ring, Cache::new_uncached());
        let mut value = (VERSION - 1).to_le_bytes().to_vec();
        value.extend([3; 600]);
        for key in [2_u8].into_iter().chain((0..stores).map(|_| 1)) {
            block_on(old.store_item(&mut [0; 1024], &key, &value.as_slice())).unwrap();
        }
        let mut keeper = Keeper::start(old.destroy().0.powered(None));
        assert_eq!(keeper.recalled, Recalled::OtherVersion { found: VERSION - 1 }, "{stores}");
        assert_eq!((&keeper.settings, keeper.in_use, keeper.flash().done), (&Settings::default(), None, 0));
        keeper.load(&model(0.2));
        assert_eq!(keeper.store(5), Ok(()));
        let state = Keeper::start(keeper.flash().powered(None)).state();
        assert_eq!(state, Some((5, Some(crc32(&model(0.2))))), "{stores}");
    }
}

#[test]
fn forgetting_leaves_all_of_the_state_or_nothing_wherever_it_is_cut() {
    let flash = filled(5, &model(0.2));
    let old = Some((5, Some(crc32(&model(0.2)))));
    for (at, cut) in (0..PAGES).flat_map(|at| cuts().map(move |cut| (at, cut))) {
        let mut keeper = Keeper::start(flash.powered(Some((at, cut))));
        assert_eq!(keeper.stored.forget(), Err(Refusal::NotStored));
        let mut after = Keeper::start(keeper.flash().powered(None));
        let state = after.state();
        assert!(state == old || after.in_use.is_none(), "{at} {cut:?}: {:?}, {state:?}", after.recalled);
        assert_eq!(after.stored.forget(), Ok(()), "{at} {cut:?}");
        assert_eq!(Keeper::start(after.flash().powered(None)).recalled, Recalled::Empty);
    }
}

#[test]
fn with_both_copies_and_a_model_a_store_takes_an_eighth_of_each_pages_life_at_most() {
    // 10,000 erasures of each page (DS12288): 80,000 stores.
    let mut keeper = Keeper::start(Flash::new());
    keeper.load(&model(0.2));
    for unit in 0..400 {
        keeper.store(unit).unwrap();
    }
    let all = keeper.flash().erasures;
    assert!(all < 400, "{all} erasures of a page in 400 stores");
}
