//! 'No solution' is said with a proof only.

use heapless::Vec;
use stickslip_shared::lcp::contact::ContactSolver;
use stickslip_shared::lcp::factors::{Contact, Factors};
use stickslip_shared::real::Real;
use stickslip_shared::solve::SolveStatus;

/// An object between two walls that approach each other at 0.1 m/s each, four contacts.
fn crushed<R: Real>(wall_inverse_mass: f64, compliance: f64) -> Factors<R, 8, 8> {
    let r = R::of;
    let mut contacts = Vec::new();
    for k in 0..4 {
        let (wall, side) = (6 + k / 2, if k < 2 { 1.0 } else { -1.0 });
        let at = if k % 2 == 0 { 0.01 } else { -0.012 };
        let row = |x: f64, y: f64, z: f64, turn: [f64; 3], own: f64| {
            let mut row = [r(x), r(y), r(z), r(turn[0]), r(turn[1]), r(turn[2]), R::zero(), R::zero()];
            row[wall] = r(own);
            row
        };
        let _ = contacts.push(Contact {
            normal: row(side, 0.0, 0.0, [0.0, 0.0, -side * at], -side),
            tangents: [
                row(0.0, 1.0, 0.0, [0.0, 0.0, -side * 0.02], 0.0),
                row(0.0, 0.0, 1.0, [at, side * 0.02, 0.0], 0.0),
            ],
            compliance: r(compliance),
            tangential_compliance: R::zero(),
            friction: r(0.4),
            separation: r(-0.1),
            slip: [r(0.01), r(-0.02)],
        });
    }
    let wall = r(wall_inverse_mass);
    Factors { inverse_mass: [r(5.0), r(5.0), r(5.0), r(5e4), r(5e3), r(5e3), wall, wall], contacts }
}

fn status<R: Real>(problem: &Factors<R, 8, 8>) -> SolveStatus {
    ContactSolver::<R, 8, 8>::new().solve(problem).report().status
}

#[test]
fn an_object_crushed_between_immovable_walls_is_proved_to_have_no_solution() {
    assert_eq!(status(&crushed::<f64>(0.0, 0.0)), SolveStatus::Contradiction);
    assert_eq!(status(&crushed::<f32>(0.0, 0.0)), SolveStatus::Contradiction);
}

#[test]
fn where_something_gives_no_contradiction_is_claimed() {
    for power in 0..9 {
        let heavy = 10f64.powi(-power);
        for (wall, compliance) in [(heavy, 0.0), (0.0, heavy)] {
            let double = status(&crushed::<f64>(wall, compliance));
            assert_ne!(double, SolveStatus::Contradiction, "walls of {wall} /kg, compliance {compliance}");
            let single = status(&crushed::<f32>(wall, compliance));
            assert_ne!(
                single,
                SolveStatus::Contradiction,
                "walls of {wall} /kg, compliance {compliance}, f32"
            );
        }
    }
}
