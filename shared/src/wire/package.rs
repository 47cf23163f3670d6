//! A scene and a model from their bytes, in place.
//!
//! `postcard` returns what it decodes by value, and a value of 1 KB that is moved through a dozen
//! functions takes ten times that of the stack. Here it is decoded piece by piece; the bytes are the same.

use super::ModelPackage;
use crate::effects::formula::Formula;
use crate::model::{Base, Friction, Model, Scene};
use crate::predictor::types::Limits;
use crate::real::Real;
use heapless::Vec;
use serde::de::DeserializeOwned;

/// Takes a value off the front of `bytes`.
// A function of its own: its stack is that of one piece.
#[inline(never)]
fn take<T: DeserializeOwned>(bytes: &mut &[u8]) -> Option<T> {
    let (value, rest) = postcard::take_from_bytes(bytes).ok()?;
    *bytes = rest;
    Some(value)
}

/// Decodes a [`ModelPackage`]; `None`, and nothing in `place`, where the bytes are not one, or more than one.
#[inline]
pub fn decode(mut bytes: &[u8], place: &mut Option<ModelPackage>) -> Option<()> {
    *place = None;
    let rest = &mut bytes;
    let scene: Scene<f32> = take(rest)?;
    let (base, friction): (Base<f32>, Friction<f32>) = take(rest)?;
    let package = insert(place, scene, base, friction);
    let whole = fill(rest, package);
    if whole.is_none() {
        *place = None;
    }
    whole
}

/// Puts what was decoded into its place, without effects.
// Generic, so that it is compiled with what uses it; a function of its own, as `take`.
#[inline(never)]
fn insert<R: Real>(
    place: &mut Option<(Scene<R>, Model<R>, Limits)>,
    scene: Scene<R>,
    base: Base<R>,
    friction: Friction<R>,
) -> &mut (Scene<R>, Model<R>, Limits) {
    place.insert((scene, Model::base(base, friction), Limits::default()))
}

/// Decodes a list and appends it to `list`.
#[inline(never)]
fn append<T: DeserializeOwned, const N: usize>(bytes: &mut &[u8], list: &mut Vec<T, N>) -> Option<()> {
    for _ in 0..take::<usize>(bytes)? {
        list.push(take(bytes)?).ok()?;
    }
    Some(())
}

/// Decodes what follows the friction coefficients.
#[inline]
fn fill(bytes: &mut &[u8], (_, model, limits): &mut ModelPackage) -> Option<()> {
    append(bytes, &mut model.effects)?;
    for _ in 0..take::<usize>(bytes)? {
        let (target, bodies) = take(bytes)?;
        model.formulas.push(Formula { target, bodies, program: Vec::new() }).ok()?;
        append(bytes, &mut model.formulas.last_mut()?.program)?;
    }
    *limits = take(bytes)?;
    bytes.is_empty().then_some(())
}
