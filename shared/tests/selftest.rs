//! The reference side of the bit-for-bit test; `hil-tests` runs the same on the board.

use stickslip_shared::selftest;

#[test]
fn varied_trials_slip_and_are_nearly_always_solved() {
    let d = selftest::run(1, 30_000, 0.0);
    println!("{d:?}");
    assert_eq!(d.ticks, 30_000);
    assert!(d.slipping > 2_000, "{d:?}");
    assert!(d.marked <= 2, "{d:?}");
}
