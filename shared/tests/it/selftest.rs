//! The reference side of the bit-for-bit test; `hil-tests` runs the same on the board.

use stickslip_shared::model::Formulation;
use stickslip_shared::selftest::{self, hostile};

#[test]
fn varied_trials_slip_and_hardly_one_tick_in_a_thousand_hits_the_bound_of_its_work() {
    for by in [Formulation::Cone, Formulation::Lcp] {
        let d = selftest::run(by, 1, 30_000, 0.0);
        println!("{by:?} {d:?}");
        assert_eq!(d.ticks, 30_000);
        assert!(d.slipping > 2_000, "{d:?}");
        // The work of a tick is bounded; one that hits the bound is marked.
        assert!(d.marked <= d.ticks / 1000, "{by:?} {d:?}");
        assert_eq!(d.cone_instead > 0, by == Formulation::Lcp, "{by:?} {d:?}");
        assert!(d.cone_instead <= d.ticks / 20, "{by:?} {d:?}");
    }
}

#[test]
fn hostile_problems_are_solved_refused_or_marked_and_the_same_each_time() {
    let a = hostile::run(7, 1_000);
    println!("{a:?}");
    // Eight solves of a step and six of complementarity problems a round.
    assert_eq!(a.solved + a.refused + a.marked, 14_000);
    assert!(a.solved > 3_000 && a.refused > 1_000 && a.marked > 100, "{a:?}");
    assert_eq!(hostile::run(7, 1_000), a);
    assert_ne!(hostile::run(8, 1_000).hash, a.hash);
}
