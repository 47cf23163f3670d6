//! What of the scene a viewer needs.

use stickslip_shared::model::{FingerContact, Scene, Shape};

/// Distance of each finger's pad from the middle of the grasp, m: half the object along gripper Y, object axes
/// parallel to the gripper's.
#[must_use]
pub fn half_width_m(scene: &Scene<f32>) -> f32 {
    match &scene.object.shape {
        Shape::Prism { side_m, .. } => side_m / 2.0,
        Shape::Cylinder { across_flats_m, .. } => across_flats_m / 2.0,
        Shape::Polygon { vertices_m, .. } => vertices_m.iter().map(|v| v[1].abs()).fold(0.0, f32::max),
    }
}

/// Half the pad's extent, m; that of a point is 0.
#[must_use]
pub fn pad_radius_m(scene: &Scene<f32>) -> f32 {
    match scene.fingers {
        Some(FingerContact::Disc { diameter_m }) => diameter_m / 2.0,
        Some(FingerContact::Line { length_m }) => length_m / 2.0,
        Some(FingerContact::Point) | None => 0.0,
    }
}
