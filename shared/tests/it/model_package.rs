//! A model as it is sent to the board, and what is refused.

use stickslip_selftest::push;
use stickslip_shared::effects::Effect;
use stickslip_shared::effects::formula::{Formula, Op, Target};
use stickslip_shared::model::MAX_EFFECTS;
use stickslip_shared::wire::package::decode;
use stickslip_shared::wire::{MAX_MODEL_BYTES, ModelPackage};

fn with_everything() -> ModelPackage {
    let (scene, mut model, limits) = push(0.2, 0.3);
    model.effects.clear();
    for code in 0..MAX_EFFECTS as u8 {
        let parameters = core::array::from_fn(|k| f32::from(code) + k as f32);
        model.effects.push(Effect { code, parameters }).unwrap();
    }
    for bodies in [1, 6] {
        let ops = [Op::Constant(0.5), Op::Constant(2.0), Op::Multiply];
        let formula = Formula::new(Target::Friction, bodies, &ops).unwrap();
        let formula = if bodies == 6 { formula.with_state(&[Op::Constant(1.0)]).unwrap() } else { formula };
        model.formulas.push(formula).unwrap();
    }
    (scene, model, limits)
}

#[test]
fn a_decoded_model_is_the_one_that_was_sent() {
    for package in [push(0.2, 0.3), with_everything()] {
        let mut buffer = [0; MAX_MODEL_BYTES];
        let bytes = postcard::to_slice(&package, &mut buffer).unwrap();
        assert_eq!(decode(bytes), Some(package));
    }
}

#[test]
fn bytes_too_few_or_too_many_are_refused() {
    let mut buffer = [0; MAX_MODEL_BYTES];
    let whole = postcard::to_slice(&with_everything(), &mut buffer).unwrap().to_vec();
    for length in 0..whole.len() {
        assert_eq!(decode(&whole[..length]), None, "{length} of {} bytes", whole.len());
    }
    assert_eq!(decode(&[&whole[..], &[0]].concat()), None);
}

#[test]
fn lists_longer_than_the_board_holds_are_refused() {
    let mut buffer = [0; MAX_MODEL_BYTES];
    let (scene, model, limits) = with_everything();
    // The model's own fields one by one, with one effect more than fit.
    let effects: heapless::Vec<_, { MAX_EFFECTS + 1 }> =
        model.effects.iter().chain(&model.effects[..1]).copied().collect();
    let package = (
        scene,
        (&model.base, model.formulation, model.witness, &model.friction, effects, &model.formulas),
        limits,
    );
    let bytes = postcard::to_slice(&package, &mut buffer).unwrap();
    assert_eq!(decode(bytes), None);
}
