//! The reference side of the bit-for-bit test; `hil-tests` runs the same on the board.

use stickslip_selftest::{self as selftest, hostile};
use stickslip_shared::model::Formulation;

/// Trials of one seed differ from those of another by a factor of ten in how often they are hard: over 24 seeds 3.7
/// ticks in a thousand hit the bound with the cone, 0.25 to 12.5 over one.
const SEEDS: u32 = 12;

#[test]
fn varied_trials_slip_and_few_ticks_in_a_thousand_hit_the_bound_of_their_work() {
    for by in [Formulation::Cone, Formulation::Lcp] {
        let (mut ticks, mut marked, mut slipping, mut instead) = (0, 0, 0, 0);
        for seed in 1..=SEEDS {
            let d = selftest::run(by, seed, 20_000, 0.0);
            println!("{by:?}, seed {seed}: {d:?}");
            assert_eq!(d.ticks, 20_000);
            ticks += d.ticks;
            marked += d.marked;
            slipping += d.slipping;
            instead += d.cone_instead;
        }
        assert!(slipping > ticks / 15, "{by:?} {slipping} of {ticks}");
        // The work of a tick is bounded; one that hits the bound is marked.
        assert!(marked <= ticks / 200, "{by:?} {marked} of {ticks}");
        assert_eq!(instead > 0, by == Formulation::Lcp, "{by:?} {instead} of {ticks}");
        assert!(instead <= ticks / 20, "{by:?} {instead} of {ticks}");
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
