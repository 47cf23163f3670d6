//! The reference side of the bit-for-bit test; `hil-tests` runs the same on the board.

use stickslip_shared::selftest;

#[test]
fn varied_trials_slip_and_hardly_one_tick_in_a_thousand_hits_the_bound_of_its_work() {
    let d = selftest::run(1, 30_000, 0.0);
    println!("{d:?}");
    assert_eq!(d.ticks, 30_000);
    assert!(d.slipping > 2_000, "{d:?}");
    // The work of a tick is bounded; one that hits the bound is marked.
    assert!(d.marked <= d.ticks / 1000, "{d:?}");
}
