//! A scene and a model from their bytes, in place.
//!
//! `postcard` returns what it decodes by value, and a value of 2 KB that is moved through several functions takes several
//! times that of the stack: on a board a tick may begin at its deepest. Here it is decoded piece by piece into where it
//! stays; the bytes are those of the derived decoder.

use super::ModelPackage;
use crate::formula::{Formula, Target};
use crate::model::{Base, Friction, Model, Scene};
use crate::predictor::Limits;
use crate::program::Program;
use heapless::Vec;
use serde::de::DeserializeOwned;

/// Decodes a [`ModelPackage`]; `None` where the bytes are not one, or more than one.
pub fn decode(bytes: &[u8]) -> Option<ModelPackage> {
    let mut place = None;
    decode_into(bytes, &mut place)?;
    place
}

/// The same into `place`, which is empty where that fails. Returned is how many of the bytes are the scene's: they come
/// first, and scenes of the same bytes are the same.
pub fn decode_into(bytes: &[u8], place: &mut Option<ModelPackage>) -> Option<usize> {
    *place = None;
    let mut rest = bytes;
    let package = begin(&mut rest, place)?;
    let scene = bytes.len() - rest.len();
    let filled = fill(&mut rest, package);
    if filled.is_none() || !rest.is_empty() {
        *place = None;
        return None;
    }
    Some(scene)
}

/// Decodes a value off the front of `bytes` to where it stays.
// A function of its own: its stack is that of one piece.
#[inline(never)]
fn put<T: DeserializeOwned>(bytes: &mut &[u8], to: &mut T) -> Option<()> {
    (*to, *bytes) = postcard::take_from_bytes(bytes).ok()?;
    Some(())
}

/// The scene, with nothing of the model yet.
#[inline(never)]
fn begin<'p>(bytes: &mut &[u8], place: &'p mut Option<ModelPackage>) -> Option<&'p mut ModelPackage> {
    let (scene, rest): (Scene<f32>, _) = postcard::take_from_bytes(bytes).ok()?;
    *bytes = rest;
    let nothing = Friction { finger: 0.0, pusher: 0.0, support: 0.0 };
    Some(place.insert((scene, Model::base(Base::Hard, nothing), Limits::default())))
}

/// Model and limits: field by field, as the derived decoder reads them.
fn fill(bytes: &mut &[u8], (_, model, limits): &mut ModelPackage) -> Option<()> {
    let Model { base, formulation, witness, friction, effects, formulas } = model;
    put(bytes, base)?;
    put(bytes, formulation)?;
    put(bytes, witness)?;
    put(bytes, friction)?;
    put(bytes, effects)?;
    let mut count = 0_usize;
    put(bytes, &mut count)?;
    for _ in 0..count {
        add_blank(formulas)?;
        let Formula { target, bodies, program, state } = formulas.last_mut()?;
        put(bytes, target)?;
        put(bytes, bodies)?;
        put(bytes, program)?;
        put(bytes, state)?;
    }
    put(bytes, limits)
}

/// One formula more; `None` where there is no room.
#[inline(never)]
fn add_blank<const N: usize>(formulas: &mut Vec<Formula<f32>, N>) -> Option<()> {
    let blank =
        Formula { target: Target::Friction, bodies: 0, program: Program::none(), state: Program::none() };
    formulas.push(blank).ok()
}
