//! A controller of the grip in the loop.

use stickslip_rig::condition::{Condition, Primitive, Scenario};
use stickslip_rig::{Nuisance, Reality, STEP_S, Setup, objects, run, run_controlled};

fn bench() -> Setup {
    let description = objects::bench("controlled");
    let reality = Reality::draw(&description, Nuisance::PAPER, 3);
    Setup { description, reality, step_s: STEP_S }
}

fn short(scenario: Scenario) -> Condition {
    Condition {
        travel: 0.01,
        hold_s: 0.3,
        speed_m_s: 0.06,
        scenario,
        ..Condition::new(Primitive::Lift, "obj4")
    }
}

#[test]
fn a_controller_that_commands_nothing_changes_nothing() {
    let (setup, condition) = (bench(), short(Scenario::Steady));
    let planned = run(&setup, &condition, 1, 3).unwrap();
    let mut seen = Vec::new();
    let controlled = run_controlled(&setup, &condition, 1, 3, &mut |sample| {
        seen.push(*sample);
        None
    });
    assert_eq!(format!("{:?}", planned.trial.samples), format!("{:?}", controlled.unwrap().trial.samples));
    assert_eq!(format!("{:?}", planned.trial.samples), format!("{seen:?}"));
}

#[test]
fn the_fingers_press_with_what_is_commanded_less_what_the_gripper_loses() {
    let scenario = Scenario::DecayingGrip { share: 0.5, from_s: 0.2, until_s: 0.4 };
    let outcome = run_controlled(&bench(), &short(scenario), 1, 3, &mut |_| Some(30.0)).unwrap();
    let at = |t_s: f64| outcome.exact.iter().find(|e| e.t_s >= t_s).expect("a sample");
    assert!((at(0.1).grip_n - 30.0).abs() < 1e-9);
    assert!((at(0.45).grip_n - 15.0).abs() < 1e-9);
    let pressed = at(0.18).finger[0][1].abs();
    assert!((pressed - 30.0).abs() < 3.0, "{pressed} N: the jaw follows");
}
