//! A model in pieces: whatever order, length and checksum they come with, only whole ones are taken.

use proptest::prelude::*;
use stickslip_selftest::push;
use stickslip_shared::wire::frame::crc32;
use stickslip_shared::wire::{CHUNK, MAX_MODEL_BYTES, Mode, ModelChunk, ModelCommit, Refusal};
use stickslip_unit::upload::Upload;

use super::bench::{Unit, bytes};

fn chunk(offset: usize, bytes: &[u8]) -> ModelChunk {
    ModelChunk { offset: offset as u16, bytes: heapless::Vec::from_slice(bytes).expect("a piece") }
}

#[test]
fn a_model_is_taken_in_pieces_of_any_length() {
    let model = bytes(&push(0.2, 0.4));
    for piece in [1, 7, 64, CHUNK] {
        let mut unit = Unit::start(None);
        assert_eq!(unit.load(&model, piece), Ok(()), "{piece}");
        unit.tick();
        assert_eq!((unit.between.mode(), unit.between.model_crc()), (Mode::Ready, Some(crc32(&model))));
    }
}

#[test]
fn a_piece_too_far_a_wrong_length_and_a_wrong_checksum_are_refused_by_name_and_nothing_is_installed() {
    let model = bytes(&push(0.2, 0.4));
    let mut upload = Upload::default();
    let mut place = None;
    let commit = |crc| ModelCommit { length: model.len() as u16, crc };
    assert_eq!(upload.take(&chunk(1, &model[1..9])), Err(Refusal::Offset { expected: 0 }));
    assert_eq!(upload.take(&chunk(0, &model[..50])), Ok(()));
    assert_eq!(upload.take(&chunk(51, &model[51..60])), Err(Refusal::Offset { expected: 50 }));
    let refused = upload.commit(&commit(crc32(&model)), &mut place);
    assert_eq!(refused, Err(Refusal::Length { received: 50 }));
    // A piece whose answer was lost comes again.
    assert_eq!(upload.take(&chunk(40, &model[40..50])), Ok(()));
    for (k, rest) in model[50..].chunks(CHUNK).enumerate() {
        assert_eq!(upload.take(&chunk(50 + k * CHUNK, rest)), Ok(()));
    }
    assert_eq!(upload.commit(&commit(1), &mut place), Err(Refusal::Crc { received: crc32(&model) }));
    assert!(place.is_none());
    assert!(upload.commit(&commit(crc32(&model)), &mut place).is_ok() && place.is_some());
    assert_eq!(place, Some(push(0.2, 0.4)));
}

#[test]
fn what_is_too_long_is_no_model_or_cannot_be_run_is_refused_and_the_old_model_stays() {
    let mut unit = Unit::ready();
    let crc = unit.between.model_crc();
    let long = vec![1; MAX_MODEL_BYTES + 1];
    assert_eq!(unit.load(&long, CHUNK), Err(Refusal::TooLarge { limit: MAX_MODEL_BYTES as u16 }));
    assert_eq!(unit.load(&[0xff; 90], CHUNK), Err(Refusal::Undecodable));
    let mut longer = bytes(&push(0.2, 0.4));
    longer.push(0);
    assert_eq!(unit.load(&longer, CHUNK), Err(Refusal::Undecodable));
    assert!(matches!(unit.load(&bytes(&push(f32::NAN, 0.4)), CHUNK), Err(Refusal::Model(_))));
    assert!(matches!(unit.load(&bytes(&push(0.2, -1.0)), CHUNK), Err(Refusal::Model(_))));
    assert_eq!(unit.between.counters.commands_refused.get(), 5);
    unit.tick();
    assert_eq!((unit.between.mode(), unit.between.model_crc()), (Mode::Ready, crc));
    // The place for the next one is free again.
    assert_eq!(unit.load(&bytes(&push(0.3, 0.4)), CHUNK), Ok(()));
}

#[test]
fn a_second_model_before_the_first_is_in_use_is_refused_as_busy_and_can_be_sent_again() {
    let mut unit = Unit::start(None);
    let [first, second] = [0.2, 0.3].map(|mass_kg| bytes(&push(mass_kg, 0.4)));
    assert_eq!(unit.load(&first, CHUNK), Ok(()));
    assert_eq!(unit.load(&second, CHUNK), Err(Refusal::Busy));
    unit.tick();
    assert_eq!(unit.between.model_crc(), Some(crc32(&first)));
    assert_eq!(unit.load(&second, CHUNK), Ok(()));
    unit.tick();
    assert_eq!(unit.between.model_crc(), Some(crc32(&second)));
    assert_eq!(unit.between.counters.model_swaps.get(), 2);
}

proptest! {
    #[test]
    fn pieces_in_any_order_make_the_model_or_are_refused(
        steps in prop::collection::vec((0usize..400, 0usize..=CHUNK, any::<bool>()), 0..30),
    ) {
        let model = bytes(&push(0.2, 0.4));
        let mut upload = Upload::default();
        // As the pieces add up.
        let mut held: Vec<u8> = Vec::new();
        for (from, length, damaged) in steps {
            let from = from.min(model.len());
            let mut piece = model[from..model.len().min(from + length)].to_vec();
            if let Some(byte) = piece.first_mut().filter(|_| damaged) {
                *byte ^= 0x10;
            }
            let answer = upload.take(&chunk(from, &piece));
            if from > held.len() {
                prop_assert_eq!(answer, Err(Refusal::Offset { expected: held.len() as u16 }));
            } else {
                prop_assert_eq!(answer, Ok(()));
                held.truncate(from);
                held.extend(&piece);
            }
        }
        prop_assert_eq!(upload.bytes(), &held[..]);
        let mut place = None;
        let commit = ModelCommit { length: model.len() as u16, crc: crc32(&model) };
        let taken = upload.commit(&commit, &mut place).is_ok();
        prop_assert_eq!((taken, place.is_some()), (held == model, held == model));
    }
}
