//! How far a pad reaches over the edge of the face that it presses: what hangs over bears nothing, and the pressure of the
//! rest is no disc's any more, which no point of the model's patch (within two thirds of its radius) shows.

use nalgebra::{UnitQuaternion, Vector3};
use stickslip_shared::shape::Face;

use crate::channels::Signals;
use crate::run::simulate::Prepared;

/// A pad that reaches over an edge by more than this share of its radius is reported, and what it does there not relied on.
const OVERHANG: f64 = 0.03;
/// Directions in which a pad's rim is looked at.
const DIRECTIONS: usize = 48;
/// The same of samples of a trial, about.
const SAMPLES: usize = 100;

/// The largest distance by which one of the two round pads reaches over the edge of its face along a radius, m; zero where
/// both lie on it throughout. `None` where the fingers have no round pads or the object was never seen.
#[must_use]
pub fn overhang_m(prepared: &Prepared) -> Option<f64> {
    let radius_m = 0.5 * prepared.pad_diameter_m()?;
    let step = prepared.measured.len().div_ceil(SAMPLES).max(1);
    let of_pads = prepared.measured.iter().step_by(step).filter_map(|row| pads(prepared, row));
    let over = |pads: [Option<Pad>; 2]| {
        let of_pad = pads.into_iter().flatten().map(|pad| pad.over_m(radius_m));
        of_pad.fold(0.0, f64::max)
    };
    of_pads.map(over).fold(None, |most: Option<f64>, x| Some(most.unwrap_or(0.0).max(x)))
}

/// How far an even pressure on what of each round pad lies on its face has its centre from the pad's middle, carrier axes, m,
/// for each sample of the trial: pads fixed in a stiff jaw press so. Pads that turn about their middle, or stand still on a
/// face that goes on, have no such shift. `None` where no pad reaches over by more than is reported.
#[must_use]
pub fn shifts_m(prepared: &Prepared) -> Option<Vec<[Vector3<f64>; 2]>> {
    let radius_m = 0.5 * prepared.pad_diameter_m()?;
    overhang_m(prepared).filter(|over_m| *over_m > OVERHANG * radius_m)?;
    let of_sample = |row: &Signals| {
        let of_pad = |pad: Option<Pad>| pad.map_or_else(Vector3::zeros, |pad| pad.shift_m(radius_m));
        pads(prepared, row).map_or_else(|| [Vector3::zeros(); 2], |pads| pads.map(of_pad))
    };
    Some(prepared.measured.iter().map(of_sample).collect())
}

/// A pad over the face that it presses.
struct Pad {
    face: Face<f64>,
    /// Its middle, in the face's plane.
    at: [f64; 2],
    /// From the object's axes to the carrier's.
    turn: UnitQuaternion<f64>,
}

/// Finger 1 and finger 2 in a sample; `None` where the object is not seen, or a pad lies on no flat face.
fn pads(prepared: &Prepared, row: &Signals) -> Option<[Option<Pad>; 2]> {
    if !row[..6].iter().all(|x| x.is_finite()) {
        return None;
    }
    let turn =
        UnitQuaternion::from_scaled_axis(Vector3::from_row_slice(&row[3..6])) * prepared.start.rotation;
    let back = turn.inverse();
    let middle_m = back * -Vector3::from_row_slice(&row[..3]);
    let shape = &prepared.scene.object.shape;
    Some([1.0, -1.0].map(|side| {
        let face = shape.face_towards(&(back * Vector3::y() * side))?;
        Some(Pad { at: face.local(&middle_m), face, turn })
    }))
}

impl Pad {
    /// Angles in the face's plane, and how much of the radius lies on the face there.
    fn on_face(&self, radius_m: f64) -> impl Iterator<Item = (f64, f64)> {
        (0..DIRECTIONS).map(move |k| {
            let angle = std::f64::consts::TAU * k as f64 / DIRECTIONS as f64;
            let rim = [self.at[0] + radius_m * angle.cos(), self.at[1] + radius_m * angle.sin()];
            let clipped = self.face.clip(self.at, rim).filter(|_| self.face.covers(self.at));
            (angle, clipped.map_or(0.0, |[_, end]| end) * radius_m)
        })
    }

    fn over_m(&self, radius_m: f64) -> f64 {
        self.on_face(radius_m).map(|(_, on_m)| radius_m - on_m).fold(0.0, f64::max)
    }

    /// The centroid of the part on the face: in polar coordinates about the pad's middle.
    fn shift_m(&self, radius_m: f64) -> Vector3<f64> {
        let (mut area, mut first) = (0.0, [0.0; 2]);
        for (angle, on_m) in self.on_face(radius_m) {
            area += on_m.powi(2) / 2.0;
            first[0] += on_m.powi(3) / 3.0 * angle.cos();
            first[1] += on_m.powi(3) / 3.0 * angle.sin();
        }
        if area <= 0.0 {
            return Vector3::zeros();
        }
        self.turn * (self.face.axes[0] * (first[0] / area) + self.face.axes[1] * (first[1] / area))
    }
}
