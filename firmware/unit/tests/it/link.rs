//! The line to the host: frames, garbage between them, queues that are full.

use postcard_rpc::Endpoint;
use proptest::prelude::*;
use stickslip_shared::wire::frame::{MAX_LINE, encode};
use stickslip_shared::wire::{self, Mode, Refusal, SAMPLE_QUEUE, Source, StartRequest};

use super::bench::{Unit, sample};

const START: StartRequest = StartRequest { source: Source::Link, trial: 0.0, prefill: 1, length: None };

#[test]
fn a_unit_says_what_it_is_and_what_it_counts() {
    let mut unit = Unit::ready();
    let info = unit.request::<wire::GetInfo>(&());
    assert_eq!((info.board.as_str(), info.mode, info.boots), ("bench", Mode::Ready, 1));
    assert_eq!((info.model_crc, info.post_mortem), (unit.between.model_crc(), None));
    let counted = unit.request::<wire::GetStatistics>(&());
    assert_eq!((counted.ticks, counted.model_swaps), (1, 1));
    assert_eq!((counted.stack_bytes, counted.static_bytes), (100, 200));
}

#[test]
fn garbage_cut_and_damaged_frames_are_counted_each_and_the_next_frame_is_answered() {
    let mut unit = Unit::start(None);
    let whole = unit.frame::<wire::GetInfo>(&());
    // Ends within a frame, then a whole one.
    let cut = &whole[..whole.len() / 2];
    assert!(unit.hear(cut).0.is_empty());
    assert!(unit.hear(&[0]).0.is_empty());
    let mut damaged = whole.clone();
    damaged[5] ^= 1;
    assert!(unit.hear(&damaged).0.is_empty());
    assert!(unit.hear(&[&vec![7; 2 * MAX_LINE][..], &[0]].concat()).0.is_empty());
    assert_eq!(unit.hear(&whole).0.len(), 1);
    // Nothing between two ends is no frame.
    assert!(unit.hear(&[0, 0, 0]).0.is_empty());
    let counters = &unit.between.counters;
    assert_eq!((counters.frames_damaged.get(), counters.frames_too_long.get()), (2, 1));
}

#[test]
fn an_unknown_kind_is_answered_as_such_and_a_body_that_is_none_is_counted_and_changes_nothing() {
    let mut unit = Unit::start(None);
    let mut line = [0; MAX_LINE];
    let unknown = encode(wire::GetInfo::RESP_KEY, 9, &(), &mut line).expect("fits").to_vec();
    let (answers, _) = unit.hear(&unknown);
    assert_eq!((answers.len(), unit.between.counters.keys_unknown.get()), (1, 1));
    // A start without its body, and a stop with one too many.
    let short = encode(wire::Start::REQ_KEY, 10, &(), &mut line).expect("fits").to_vec();
    let long = encode(wire::Stop::REQ_KEY, 11, &7u32, &mut line).expect("fits").to_vec();
    assert!(unit.hear(&short).0.is_empty() && unit.hear(&long).0.is_empty());
    assert_eq!(unit.between.counters.bodies_undecodable.get(), 2);
    assert!(unit.between.commands.is_empty());
}

#[test]
fn more_samples_than_there_is_room_for_are_dropped_the_newest_and_counted() {
    let mut unit = Unit::ready();
    assert_eq!(unit.request::<wire::Start>(&START), Ok(()));
    for seq in 0..SAMPLE_QUEUE as u32 + 5 {
        unit.publish(&sample(seq, seq * 4000));
    }
    assert_eq!((unit.between.samples.len(), unit.between.counters.samples_dropped.get()), (SAMPLE_QUEUE, 5));
    let taken: Vec<_> = (0..SAMPLE_QUEUE).filter_map(|_| unit.tick()?.sample_seq).collect();
    assert_eq!(taken, (0..SAMPLE_QUEUE as u32).collect::<Vec<_>>());
    // The next one that fits shows no loss on the line: they came.
    unit.publish(&sample(SAMPLE_QUEUE as u32 + 5, 4000 * (SAMPLE_QUEUE as u32 + 5)));
    assert_eq!(unit.between.counters.samples_lost.get(), 0);
}

#[test]
fn a_fifth_command_before_a_tick_is_refused_as_busy_and_the_four_are_carried_out() {
    let mut unit = Unit::ready();
    for k in 0..4 {
        assert_eq!(unit.request::<wire::SetGrip>(&(10.0 + k as f32)), Ok(()));
    }
    assert_eq!(unit.request::<wire::SetGrip>(&14.0), Err(Refusal::Busy));
    assert_eq!(unit.request::<wire::Start>(&START), Err(Refusal::Busy));
    assert_eq!(unit.between.counters.commands_refused.get(), 2);
    unit.tick();
    assert_eq!(unit.request::<wire::Start>(&START), Ok(()));
    let report = unit.tick().expect("of a run");
    // The model, four grips and the start.
    assert_eq!((report.commands, report.mode), (6, Mode::Running));
}

#[test]
fn a_report_that_nobody_fetches_is_dropped_and_counted_and_so_is_a_state_for_the_bus() {
    let mut unit = Unit::ready();
    while unit.between.states.try_receive().is_some() {}
    let unsent = unit.between.counters.frames_unsent.get();
    assert_eq!(unit.request::<wire::Start>(&START), Ok(()));
    let first = unit.tick().expect("of a run");
    let between = unit.between;
    for _ in 0..8 {
        // The bench fetches one a tick: fill the queue besides.
        assert!(between.reports.try_send(first).is_ok() || between.reports.len() == 8);
    }
    unit.tick();
    assert_eq!(between.counters.reports_dropped.get(), 1);
    assert_eq!(between.states.len(), 2);
    unit.tick();
    assert!(between.counters.frames_unsent.get() > unsent);
}

#[test]
fn samples_lost_doubled_and_overtaken_are_counted_by_what_they_are() {
    let mut unit = Unit::ready();
    assert_eq!(unit.request::<wire::Start>(&START), Ok(()));
    for seq in [0, 1, 1, 4, 3, 4, 7] {
        unit.publish(&sample(seq, seq * 4000));
    }
    let counters = &unit.between.counters;
    // 2 and 3 were missing before 4, 5 and 6 before 7; 3 came late.
    assert_eq!((counters.samples_lost.get(), counters.samples_repeated.get()), (4, 2));
    assert_eq!(counters.samples_reordered.get(), 1);
    assert_eq!(unit.between.samples.len(), 4);
}

#[test]
fn a_restart_is_asked_for_by_its_frame_alone_and_answered_first() {
    let mut unit = Unit::start(None);
    let info = unit.frame::<wire::GetInfo>(&());
    assert!(!unit.hear(&info).1);
    let restart = unit.frame::<wire::ResetBoard>(&());
    let (answers, restarts) = unit.hear(&restart);
    assert!(restarts && unit.answer::<wire::ResetBoard>(&answers[0]).is_ok());
}

proptest! {
    #[test]
    fn any_bytes_are_survived_and_the_frame_after_their_end_is_answered(
        garbage in prop::collection::vec(any::<u8>(), 0..1500),
    ) {
        let mut unit = Unit::start(None);
        let before = unit.hear(&garbage).0.len();
        unit.hear(&[0]);
        let info = unit.frame::<wire::GetInfo>(&());
        let (answers, _) = unit.hear(&info);
        // No garbage has a checksum of 32 bits, nor the key of a request.
        prop_assert_eq!((before, answers.len()), (0, 1));
        prop_assert!(unit.between.commands.is_empty());
    }
}
