//! A model decoded in place is what `postcard` decodes.

use stickslip_shared::effects::Effect;
use stickslip_shared::effects::formula::{Formula, Op, Target};
use stickslip_shared::model::MAX_EFFECTS;
use stickslip_shared::selftest::push;
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
        let program = [Op::Constant(0.5), Op::Constant(2.0), Op::Multiply].into_iter().collect();
        model.formulas.push(Formula { target: Target::Friction, bodies, program }).unwrap();
    }
    (scene, model, limits)
}

#[test]
fn a_model_decoded_in_place_is_the_one_that_was_sent() {
    for package in [push(0.2, 0.3), with_everything()] {
        let mut buffer = [0; MAX_MODEL_BYTES];
        let bytes = postcard::to_slice(&package, &mut buffer).unwrap();
        let mut place = None;
        assert_eq!(decode(bytes, &mut place), Some(()));
        assert_eq!(place, Some(package));
    }
}

#[test]
fn damaged_bytes_are_refused_where_postcard_refuses_them() {
    let mut buffer = [0; MAX_MODEL_BYTES];
    let package = with_everything();
    let whole = postcard::to_slice(&package, &mut buffer).unwrap().to_vec();
    let mut cases: Vec<Vec<u8>> = (0..whole.len()).map(|length| whole[..length].to_vec()).collect();
    cases.push([&whole[..], &[0]].concat());
    for at in 0..whole.len() {
        for value in [0, 1, 7, 0x7f, 0x80, 0xff] {
            let mut bytes = whole.clone();
            bytes[at] = value;
            cases.push(bytes);
        }
    }
    for bytes in cases {
        let expected = match postcard::take_from_bytes::<ModelPackage>(&bytes) {
            Ok((package, [])) => Some(package),
            _ => None,
        };
        let mut place = Some(push(0.2, 0.3));
        let done = decode(&bytes, &mut place);
        assert_eq!(done.is_some(), place.is_some());
        // Bytes as numbers: a NaN is not equal to itself.
        let again = |p: &Option<ModelPackage>| {
            p.as_ref().map(|p| postcard::to_slice(p, &mut [0; MAX_MODEL_BYTES]).unwrap().to_vec())
        };
        assert_eq!(again(&place), again(&expected), "{bytes:?}");
    }
}
