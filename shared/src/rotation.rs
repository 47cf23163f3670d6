//! Small turns, and the frame of the table under an object.

use crate::model::{Scene, SupportContact};
use crate::real::{Real, Rotation, Vec3, sqrt};
use crate::state::Moving;
use nalgebra::{Quaternion, UnitQuaternion};

/// `rotation` turned by a small rotation vector given in the parent's axes. Exact in the
/// axis; the angle's relative error is angle²/12, below 1e-6 for any step here.
pub fn turned<R: Real>(rotation: &Rotation<R>, by_rad: &Vec3<R>) -> Rotation<R> {
    let half = by_rad * R::of(0.5);
    let d = Quaternion::new(R::one(), half.x, half.y, half.z);
    let q = d * rotation.quaternion();
    let norm = sqrt(q.w * q.w + q.i * q.i + q.j * q.j + q.k * q.k);
    UnitQuaternion::new_unchecked(q / norm)
}

/// The shortest turn that takes +X to the unit vector `to`.
fn turn_from_x<R: Real>(to: &Vec3<R>) -> Rotation<R> {
    let zero = R::zero();
    let w = R::one() + to.x;
    if !(w > R::of(1e-6)) {
        return UnitQuaternion::new_unchecked(Quaternion::new(zero, zero, R::one(), zero));
    }
    // Twice the half-angle's cosine and sine times cos(angle / 2): normalised below.
    let norm = sqrt(w * w + to.z * to.z + to.y * to.y);
    UnitQuaternion::new_unchecked(Quaternion::new(w, zero, -to.z, to.y) / norm)
}

/// The height of the table that just touches the object at `position_m`, as a frame at rest
/// relative to the carrier with +X along `up` (carrier axes).
pub fn support_under<R: Real>(
    scene: &Scene<R>,
    position_m: &Vec3<R>,
    rotation: &Rotation<R>,
    up: &Vec3<R>,
) -> Moving<R> {
    let down = rotation.inverse_transform_vector(&-up);
    let reach = match &scene.support {
        Some(SupportContact::Points(_)) => scene.object.shape.reach(&-Vec3::z()),
        _ => scene.object.shape.reach(&down),
    };
    let at = position_m - up * reach;
    Moving {
        position_m: at,
        rotation: turn_from_x(up),
        velocity_m_s: Vec3::zeros(),
        angular_rad_s: Vec3::zeros(),
        reference_m: at,
    }
}
