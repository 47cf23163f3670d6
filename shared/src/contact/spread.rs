//! Contacts that effects spread: more points in place of few, whose sum is the same contact.

use heapless::Vec;

use super::{Contact, Contacts};
use crate::real::Real;

/// Replaces every point that is a whole contact by itself and has a `spread_m` above zero
/// by three points at that radius, which bear torsion `mu N spread_m`. They take the slots
/// after the point's own, which its body leaves free. Returns the points that did not fit.
// Few models have such contacts: not with the time step in the board's fast memory.
#[inline(never)]
pub fn spread<R: Real, const NC: usize>(contacts: &mut Contacts<R, NC>) -> usize {
    let third = R::of(1.0 / 3.0);
    let (half, high) = (R::of(-0.5), R::of(0.866_025_403_784_438_6));
    let mut lost = 0;
    for i in 0..contacts.len() {
        let Some(c) = contacts.get_mut(i) else { continue };
        if !(c.spread_m > R::zero() && c.share > R::of(0.999)) {
            continue;
        }
        let centre = *c;
        let at = |k: usize, x: R, y: R| {
            let (x, y) = (x * centre.spread_m, y * centre.spread_m);
            Contact {
                slot: centre.slot + k,
                lever_m: centre.lever_m + centre.axes[1] * x + centre.axes[2] * y,
                patch_m: [centre.patch_m[0] + x, centre.patch_m[1] + y],
                share: centre.share * third,
                ..centre
            }
        };
        *c = at(0, R::one(), R::zero());
        for point in [at(1, half, high), at(2, half, -high)] {
            lost += usize::from(point.slot >= NC || contacts.push(point).is_err());
        }
    }
    lost + evened(contacts)
}

/// Ends of what bears evenly: two of a line, four of a face.
const ENDS: usize = 4;

/// Puts two points between the ends of each line, or of each long edge of a face, that bears evenly. The edges are those
/// across the second axis. Returns the points that did not fit.
fn evened<R: Real, const NC: usize>(contacts: &mut Contacts<R, NC>) -> usize {
    let mut ends: Vec<(usize, Contact<R>), ENDS> = Vec::new();
    for (i, c) in contacts.iter().enumerate() {
        if c.even && ends.push((i, *c)).is_err() {
            break;
        }
    }
    match ends.as_slice() {
        [a, b] => between(contacts, [a, b], a.1.slot + ENDS),
        [a, b, c, d] => {
            let along = |from: &Contact<R>, to: &Contact<R>| (to.patch_m[1] - from.patch_m[1]).abs();
            let [one, other] =
                if along(&a.1, &b.1) > along(&b.1, &c.1) { [[a, b], [c, d]] } else { [[b, c], [d, a]] };
            let slot = a.1.slot + ENDS;
            between(contacts, one, slot) + between(contacts, other, slot + 2)
        }
        _ => 0,
    }
}

/// Shares what two ends bear with two points between them, from `slot` on, by Simpson's weights (1, 3, 3, 1): a foundation's
/// stiffness against shift and turning, and less of it where it touches in part. Returns the points that did not fit.
fn between<R: Real, const NC: usize>(
    contacts: &mut Contacts<R, NC>,
    [(from, a), (to, b)]: [&(usize, Contact<R>); 2],
    slot: usize,
) -> usize {
    let mut lost = 0;
    for k in 0..2 {
        let t = R::of((k + 1) as f64 / 3.0);
        let point = Contact {
            slot: slot + k,
            lever_m: a.lever_m + (b.lever_m - a.lever_m) * t,
            gap_m: a.gap_m + (b.gap_m - a.gap_m) * t,
            surface_m_s: a.surface_m_s + (b.surface_m_s - a.surface_m_s) * t,
            patch_m: [0, 1].map(|i| a.patch_m[i] + (b.patch_m[i] - a.patch_m[i]) * t),
            object_m: a.object_m + (b.object_m - a.object_m) * t,
            share: a.share * R::of(0.75),
            ..*a
        };
        lost += usize::from(point.slot >= NC || contacts.push(point).is_err());
    }
    for end in [*from, *to] {
        if let Some(c) = contacts.get_mut(end) {
            c.share *= R::of(0.25);
        }
    }
    lost
}
