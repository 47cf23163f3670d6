//! The user's formulas: rates, memory, and what happens where they have no value.

use crate::common::{DT_S, gripped, hard, obj4, pose};
use nalgebra::UnitQuaternion;
use stickslip_shared::cone::SolveStatus;
use stickslip_shared::contact::SLOTS;
use stickslip_shared::effects::formula::{CODE, Fault, Formula, Op, Program, Target, Variable, Variables};
use stickslip_shared::effects::{Effect, MAX_PARAMETERS};
use stickslip_shared::model::Model;
use stickslip_shared::real::Vec3;
use stickslip_shared::step::{FormulaFault, State, StepOutput, step};
use stickslip_shared::track::{Poses, drive_between};

const FINGERS: u8 = 0b11;
const ONE: [Op<f64>; 1] = [Op::Constant(1.0)];

/// A held prism, friction 0.4, with these formulas; the grip force is a function of time.
fn hold(
    formulas: &[Formula<f64>],
    grip_n: impl Fn(f64) -> f64,
    steps: usize,
) -> (State<f64, SLOTS>, StepOutput<f64, SLOTS>) {
    let scene = gripped(obj4(), None);
    let mut model: Model<f64> = hard(0.4, 0.25, 0.3);
    for formula in formulas {
        model.effects.push(Effect { code: CODE, parameters: [0.0; MAX_PARAMETERS] }).unwrap();
        model.formulas.push(formula.clone()).unwrap();
    }
    let still = pose(Vec3::zeros(), UnitQuaternion::identity());
    let at = |t_s: f64| Poses { t_s, carrier: still, pusher: None, support: None };
    let drive = |k: usize| {
        let t_s = k as f64 * DT_S;
        let mut drive = drive_between(&at(t_s), &at(t_s + DT_S), &Vec3::zeros(), grip_n(t_s), 0.0).unwrap();
        drive.dt_s = DT_S;
        drive
    };
    let mut state = State::held(&scene, &model, &drive(0), Vec3::zeros(), UnitQuaternion::identity());
    let mut out = step(&scene, &model, &mut state, &drive(0));
    for k in 1..steps {
        out = step(&scene, &model, &mut state, &drive(k));
    }
    (state, out)
}

fn variable(v: Variable) -> Op<f64> {
    Op::Variable(v)
}

#[test]
fn a_grip_that_remembers_falls_with_the_sum_of_the_steps() {
    // Factor 1 - state, state + dt: after t seconds 1 - t.
    let factor = [Op::Constant(1.0), variable(Variable::State), Op::Subtract];
    let sum = [variable(Variable::State), variable(Variable::Step), Op::Add];
    let formula = Formula::new(Target::Grip, 0, &factor).unwrap().with_state(&sum).unwrap();
    let (state, out) = hold(&[formula], |_| 20.0, 100);
    assert!((state.memory[0][0] - 0.4).abs() < 1e-12);
    for n in &out.normal_n[..2] {
        assert!((n - 20.0 * 0.6).abs() < 0.05, "{n}");
    }
}

#[test]
fn a_low_pass_of_the_load_rises_with_its_time_constant() {
    let tau = 0.1;
    let low_pass = [
        variable(Variable::State),
        variable(Variable::Load),
        variable(Variable::State),
        Op::Subtract,
        variable(Variable::Step),
        Op::Multiply,
        Op::Constant(tau),
        Op::Divide,
        Op::Add,
    ];
    let formula = Formula::new(Target::Friction, FINGERS, &ONE).unwrap().with_state(&low_pass).unwrap();
    let steps = 40;
    let (state, _) = hold(&[formula], |_| 20.0, steps);
    // Both fingers: 40 N. The first step knows of no load yet.
    let expected = 40.0 * (1.0 - (1.0 - DT_S / tau).powi(steps as i32 - 1));
    assert!((state.memory[0][0] - expected).abs() < 0.01 * expected, "{} {expected}", state.memory[0][0]);
}

#[test]
fn rates_of_grip_and_load_are_those_of_a_ramp() {
    let remembering =
        |v| Formula::new(Target::Friction, FINGERS, &ONE).unwrap().with_state(&[variable(v)]).unwrap();
    let formulas = [remembering(Variable::GripRate), remembering(Variable::LoadRate)];
    let (state, _) = hold(&formulas, |t_s| 20.0 + 10.0 * t_s, 50);
    assert!((state.memory[0][0] - 10.0).abs() < 1e-9, "{}", state.memory[0][0]);
    // The sum over both fingers.
    assert!((state.memory[1][0] - 20.0).abs() < 0.2, "{}", state.memory[1][0]);
    // Nothing before the first step to take a rate from; no load before the second.
    for steps in [1, 2] {
        let (state, _) = hold(&formulas, |_| 20.0, steps);
        assert_eq!((state.memory[0][0], state.memory[1][0]), (0.0, 0.0), "{steps}");
    }
}

#[test]
fn a_division_by_zero_stops_the_step_and_is_named() {
    let inverse = [Op::Constant(1.0), variable(Variable::SlipSpeed), Op::Divide];
    let fine = Formula::new(Target::Grip, 0, &ONE).unwrap();
    for (target, bodies) in [(Target::Friction, FINGERS), (Target::Grip, 0), (Target::ForceZ, 0)] {
        let formula = Formula::new(target, bodies, &inverse).unwrap();
        let (state, out) = hold(&[fine.clone(), formula], |_| 20.0, 1);
        assert_eq!(out.status, SolveStatus::BadInput);
        assert_eq!(out.formula_fault, Some(FormulaFault { number: 1, fault: Fault::DivisionByZero }));
        assert_eq!(state.time_s, 0.0, "nothing has moved");
    }
    let state = Formula::new(Target::Friction, FINGERS, &ONE).unwrap().with_state(&inverse).unwrap();
    let (_, out) = hold(&[state], |_| 20.0, 1);
    assert_eq!(out.formula_fault, Some(FormulaFault { number: 0, fault: Fault::DivisionByZero }));
}

#[test]
fn what_has_no_value_is_a_fault_also_where_a_later_operation_would_hide_it() {
    let nothing: Variables<f64> = [0.0; Variable::NAMES.len()];
    let minus = Op::Constant(-1.0);
    for (ops, fault) in [
        // min(2, 1/0), 1/(1/0)
        (
            vec![Op::Constant(2.0), Op::Constant(1.0), Op::Constant(0.0), Op::Divide, Op::Minimum],
            Fault::DivisionByZero,
        ),
        (
            vec![Op::Constant(1.0), Op::Constant(1.0), Op::Constant(0.0), Op::Divide, Op::Divide],
            Fault::DivisionByZero,
        ),
        (vec![Op::Constant(0.0), minus, Op::Power], Fault::DivisionByZero),
        (vec![minus, Op::SquareRoot, Op::Constant(1.0), Op::Maximum], Fault::Domain),
        (vec![Op::Constant(0.0), Op::Logarithm], Fault::Domain),
        (vec![minus, Op::Constant(0.5), Op::Power], Fault::Domain),
        (vec![Op::Constant(1000.0), Op::Exponential], Fault::Overflow),
    ] {
        let value = Program::new(&ops).unwrap().evaluate(&[0.0; MAX_PARAMETERS], &nothing);
        assert_eq!(value, Err(fault), "{ops:?}");
    }
    // A sigmoid far out is 0 without a fault: exp may overflow under a division.
    let sigmoid =
        [Op::Constant(1.0), Op::Constant(1.0), Op::Constant(1000.0), Op::Exponential, Op::Add, Op::Divide];
    assert_eq!(Program::new(&sigmoid).unwrap().evaluate(&[0.0; MAX_PARAMETERS], &nothing), Ok(0.0));
}
