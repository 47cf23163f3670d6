//! Which point of the object a contact's memory belongs to, when the face that touches changes.
//!
//! The corners of a plane pusher's face, and the cells of a face on a table, are points of the object:
//! where another face comes nearer, its points have other slots. A corner that both faces
//! share takes its memory along; all others begin anew. The points of a pad, of a line
//! and of a tip are the tool's: they keep theirs, but for a pad whose points are arranged otherwise
//! on a round side than on a flat one.

use crate::contact::{Body, Contacts};
use crate::model::{PusherContact, Scene};
use crate::real::{Real, Vec3};
use crate::shape::{MAX_SAMPLES, ROUND};
use crate::state::{Slot, State};
use heapless::Vec;

/// Corners nearer than this are the same one, m: rounding of a lever, far below any corner's distance.
const SAME_M: f64 = 1e-5;

/// Gives every slot of `state` to the point that has it in `contacts`.
pub(super) fn keep_owners<R: Real, const NC: usize>(
    scene: &Scene<R>,
    state: &mut State<R, NC>,
    contacts: &Contacts<R, NC>,
) {
    for (i, c) in contacts.iter().enumerate() {
        let Some(known) = state.faces.get_mut(c.body.index()) else { continue };
        let before = known.replace(c.face);
        let Some(before) = before.filter(|b| *b != c.face) else { continue };
        let range = c.body.slots();
        let of_object = match c.body {
            Body::Finger1 | Body::Finger2 => before == ROUND || c.face == ROUND,
            Body::Pusher => matches!(scene.pusher, Some(PusherContact::Plane)),
            Body::Support => true,
        };
        let (true, Some(slots)) = (of_object, state.slots.get_mut(range.clone())) else { continue };
        let mut old: Vec<Slot<R>, MAX_SAMPLES> = Vec::new();
        let _ = old.extend_from_slice(slots);
        slots.fill(Slot::default());
        if c.body != Body::Pusher {
            continue;
        }
        let Some(face) = scene.object.shape.face(before) else { continue };
        let same = |a: &Vec3<R>, b: &Vec3<R>| (a - b).norm_squared() < R::of(SAME_M * SAME_M);
        for c in contacts.iter().skip(i).filter(|c| c.body == Body::Pusher) {
            let from = face.corners().iter().position(|corner| same(corner, &c.object_m));
            let to = c.slot.checked_sub(range.start).and_then(|k| slots.get_mut(k));
            if let (Some(to), Some(slot)) = (to, from.and_then(|k| old.get(k))) {
                *to = *slot;
            }
        }
    }
}
