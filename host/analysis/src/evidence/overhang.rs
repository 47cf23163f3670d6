//! How far a pad reaches over the edge of the face that it presses: what hangs over bears nothing, and the pressure of the
//! rest is no disc's any more, which no point of the model's patch (within two thirds of its radius) shows.

use nalgebra::{UnitQuaternion, Vector3};
use stickslip_shared::model::FingerContact;
use stickslip_shared::shape::Face;

use crate::run::simulate::Prepared;

/// Directions in which a pad's rim is looked at.
const DIRECTIONS: usize = 48;
/// The same of samples of a trial, about.
const SAMPLES: usize = 100;

/// The largest distance by which one of the two round pads reaches over the edge of its face along a radius, m; zero where
/// both lie on it throughout. `None` where the fingers have no round pads or the object was never seen.
#[must_use]
pub fn overhang_m(prepared: &Prepared) -> Option<f64> {
    let Some(FingerContact::Disc { diameter_m }) = prepared.scene.fingers else { return None };
    let shape = &prepared.scene.object.shape;
    let over = |row: &[f64]| {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::from_row_slice(&row[3..6]));
        let back = (turn * prepared.start.rotation).inverse();
        let pad_m = back * -Vector3::from_row_slice(&row[..3]);
        let faces = [1.0, -1.0].map(|side| shape.face_towards(&(back * Vector3::y() * side)));
        faces.into_iter().flatten().map(|face| beyond(&face, &pad_m, 0.5 * diameter_m)).fold(0.0, f64::max)
    };
    let step = prepared.measured.len().div_ceil(SAMPLES).max(1);
    let seen = prepared.measured.iter().step_by(step).filter(|row| row[..6].iter().all(|x| x.is_finite()));
    seen.map(|row| over(row)).fold(None, |most: Option<f64>, x| Some(most.unwrap_or(0.0).max(x)))
}

/// How far a disc about `centre_m` (object axes) reaches over the edge of `face`.
fn beyond(face: &Face<f64>, centre_m: &Vector3<f64>, radius_m: f64) -> f64 {
    let at = face.local(centre_m);
    let along = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / DIRECTIONS as f64;
        let rim = [at[0] + radius_m * angle.cos(), at[1] + radius_m * angle.sin()];
        let on_face = face.clip(at, rim).filter(|_| face.covers(at)).map_or(0.0, |[_, end]| end);
        (1.0 - on_face) * radius_m
    };
    (0..DIRECTIONS).map(along).fold(0.0, f64::max)
}
