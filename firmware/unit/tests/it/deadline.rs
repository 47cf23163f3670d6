//! When ticks are due, and which are missed.

use proptest::prelude::*;
use stickslip_unit::deadline::Deadline;

const PERIOD_US: u64 = 4_000;

/// Ticks that take so long each, us: when each was due and began, and how many were missed.
fn run(take_us: &[u64]) -> (Vec<(u64, u64)>, u64) {
    let (mut now_us, mut missed) = (1_000_000, 0);
    let mut deadline = Deadline::from(now_us, PERIOD_US as u32);
    let mut begun = Vec::new();
    for take_us in take_us {
        let due_us = deadline.next_us();
        now_us = now_us.max(due_us);
        missed += u64::from(deadline.missed(now_us));
        begun.push((due_us, now_us));
        now_us += take_us;
    }
    (begun, missed)
}

#[test]
fn ticks_that_end_in_time_begin_when_they_are_due_and_none_is_missed() {
    let (begun, missed) = run(&[0, 3_999, 4_000, 100, 4_000]);
    assert!(begun.iter().all(|(due, began)| due == began));
    assert_eq!(missed, 0);
}

#[test]
fn a_tick_of_three_and_a_half_periods_makes_two_begin_a_period_late_and_the_rest_catch_up() {
    let (begun, missed) = run(&[14_000, 100, 100, 100, 100, 100]);
    let late: Vec<u64> = begun.iter().map(|(due, began)| began - due).collect();
    assert_eq!(late, [0, 10_000, 6_100, 2_200, 0, 0]);
    assert_eq!(missed, 2);
}

proptest! {
    #[test]
    fn due_times_never_drift_and_missed_are_those_that_begin_a_period_late(
        take_us in prop::collection::vec(0u64..20_000, 1..60),
    ) {
        let (begun, missed) = run(&take_us);
        for (k, (due, _)) in begun.iter().enumerate() {
            prop_assert_eq!(*due, 1_000_000 + PERIOD_US * (k as u64 + 1));
        }
        let late = begun.iter().filter(|(due, began)| began - due >= PERIOD_US).count();
        prop_assert_eq!(missed, late as u64);
    }
}
