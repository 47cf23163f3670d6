//! The load under a supported object is not spread as the model says.
//!
//! A body that lies on a table presses on it with forces `N_i >= 0` at the points `x_i` of its
//! face (from the centre of mass, in the face). Statics fixes their sum and their first moment,
//! nothing else: which points bear, and how far from the middle, depends on how flat face and
//! table are to a micrometre. Friction at a twist `(v, w)` is `-sum mu N_i (v + w x x_i) / |v + w x x_i|`,
//! so that the spread decides how a push turns the body (Goyal, Ruina and Papadopoulos 1991).
//!
//! Spread: every point bears at `x_i + D x_i`, `D = diag(spread_x, spread_y)`. Loads are still those of
//! statics, not negative, and the second moments of a load distribution `N(x)` become
//! `(1 + spread_k)(1 + spread_l) sum N x_k x_l` exactly; at -1 all of it would lie under the centre of
//! mass, the most is a body that stands on its corners (a triangle: 1, a rectangle: 0.73, of the face). Feet
//! that are told stay where they are.
//!
//! Offset: as statics fixes the first moment, a load that is centred elsewhere needs a moment that the
//! model does not have (the centre of mass is elsewhere, the pusher touches higher or lower than said).
//! With the load `N` of the last step it is `-offset x N n`: solved against it, the loads are centred
//! at the model's own centre plus `offset`; those that would have to pull are zero.
//!
//! Axes are the two object axes that lie in the table (X and Y of a body on its end face). A body
//! that stands at a slant, or on its round side, has no spread.

use super::law::{Law, Loads, StepContext};
use crate::contact::{Body, Contact};
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::{Real, Vec3};
use crate::shape::ROUND;

/// Cosine (8 degrees) between the table's normal and an object axis below which the face does not lie on the
/// table. Doubled angle: a body that tips presses on more than its edge.
const FLAT: f64 = 0.99;

/// See the module.
pub struct SupportPressure;

/// Description.
pub const INFO: Info = Info {
    id: "support_pressure",
    code: 25,
    summary: "the load under a supported object is not spread as the model says",
    signature: "a push turns the object more or less than it should, and its force leans to one side, while a \
                push through the middle takes mu times weight",
    on_robot: "an object pushed on its support turns otherwise than planned: it ends up askew and leans against fingers or pusher",
    source: "Goyal, Ruina and Papadopoulos 1991, limit surface of a pressure distribution",
    role: Role::Plain,
    parameters: &[
        Parameter::new("offset_x_m", "m", 0.005, 0.0, [-0.03, 0.03], "centre of the load, along object X"),
        Parameter::new("offset_y_m", "m", 0.005, 0.0, [-0.03, 0.03], "along object Y"),
        Parameter::new(
            "spread_x",
            "1",
            0.3,
            0.0,
            [-0.9, 1.0],
            "relative change of its spread along object X",
        ),
        Parameter::new("spread_y", "1", 0.3, 0.0, [-0.9, 1.0], "along object Y"),
    ],
};

/// `along` of two axes in the table as a vector in object axes, for a table normal in object axes; `None`
/// where no object axis is near the normal.
fn in_table<R: Real>(normal: &Vec3<R>, along: [R; 2]) -> Option<Vec3<R>> {
    let zero = R::zero();
    let flat = |x: R| x.abs() > R::of(FLAT);
    if flat(normal.z) {
        Some(Vec3::new(along[0], along[1], zero))
    } else if flat(normal.y) {
        Some(Vec3::new(along[0], zero, along[1]))
    } else if flat(normal.x) {
        Some(Vec3::new(zero, along[0], along[1]))
    } else {
        None
    }
}

impl<R: Real> Law<R> for SupportPressure {
    fn loads(&self, p: &[R; MAX_PARAMETERS], c: &StepContext<R>, _: &mut [R; MEMORY], loads: &mut Loads<R>) {
        let [_, _, _, load_n] = c.load_n;
        if (p[0] == R::zero() && p[1] == R::zero()) || !(load_n > R::zero()) {
            return;
        }
        let [_, table] = c.environment;
        let normal = c.rotation.inverse_transform_vector(&table.normal);
        if let Some(offset) = in_table(&normal, [p[0], p[1]]) {
            let offset = c.rotation.transform_vector(&offset);
            loads.torque_nm += (table.normal * load_n).cross(&offset);
        }
    }

    fn contact(
        &self,
        p: &[R; MAX_PARAMETERS],
        c: &StepContext<R>,
        _: &[R; MEMORY],
        contact: &mut Contact<R>,
    ) {
        let (x, y) = (p[2], p[3]);
        let flat_face = contact.body == Body::Support && c.whole_face && contact.face != ROUND;
        if (x == R::zero() && y == R::zero()) || !flat_face {
            return;
        }
        let [_, table] = c.environment;
        let normal = c.rotation.inverse_transform_vector(&table.normal);
        let at = contact.object_m;
        let Some(by) = in_table(&normal, [x, y]) else { return };
        let moved = Vec3::new(by.x * at.x, by.y * at.y, by.z * at.z);
        let in_carrier = c.rotation.transform_vector(&moved);
        contact.lever_m += in_carrier;
        // A face that is not quite level is nearer to the table on one side.
        contact.gap_m += normal.dot(&moved);
        contact.surface_m_s += table.angular_rad_s.cross(&in_carrier);
        contact.object_m += moved;
        contact.patch_m = [contact.patch_m[0] + moved.x, contact.patch_m[1] + moved.y];
    }
}
