//! A lift of the rig whose course is known.

use stickslip_data::{Description, Trial};
use stickslip_rig::{Condition, Nuisance, Primitive, Reality, STEP_S, Scenario, Setup, objects, run};

/// obj4 (0.2005 kg) lifted with twice the grip that friction of 0.4 needs: friction 0.42, ordinary noise and
/// constant errors.
pub fn lift(scenario: Scenario) -> (Description, Trial) {
    let description = objects::bench("lifts");
    let mut reality = Reality::draw(&description, Nuisance::PAPER, 3);
    reality.mu_finger = 0.42;
    let setup = Setup { description, reality, step_s: STEP_S };
    let condition = Condition {
        grip_n: 4.9,
        speed_m_s: 0.06,
        hold_s: 2.0,
        scenario,
        ..Condition::new(Primitive::Lift, "obj4")
    };
    let trial = run(&setup, &condition, 1, 5).expect("the rig runs").trial;
    (setup.description, trial)
}
