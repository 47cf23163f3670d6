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

/// Puts two points between the ends of each line, or of each long edge of a face, that bears evenly, with Simpson's weights
/// (1, 3, 3, 1): a foundation's stiffness against shift and turning, and less of it where it touches in part. The
/// edges are those across the second axis. Returns the points that did not fit.
fn evened<R: Real, const NC: usize>(contacts: &mut Contacts<R, NC>) -> usize {
    let mut ends: Vec<usize, 4> = Vec::new();
    let mut lost = 0;
    for (i, c) in contacts.iter().enumerate() {
        if c.even {
            lost += usize::from(ends.push(i).is_err());
        }
    }
    let pairs: [[usize; 2]; 2] = match ends.as_slice() {
        [a, b] => [[*a, *b], [*a, *a]],
        [a, b, c, d] => {
            let along = |from: usize, to: usize| match (contacts.get(from), contacts.get(to)) {
                (Some(from), Some(to)) => (to.patch_m[1] - from.patch_m[1]).abs(),
                _ => R::zero(),
            };
            if along(*a, *b) > along(*b, *c) { [[*a, *b], [*c, *d]] } else { [[*b, *c], [*d, *a]] }
        }
        _ => return lost,
    };
    let first = ends.iter().filter_map(|i| contacts.get(*i)).map(|c| c.slot).min().unwrap_or(NC);
    for (pair, [from, to]) in pairs.into_iter().enumerate() {
        let (Some(a), Some(b)) = (contacts.get(from).copied(), contacts.get(to).copied()) else { continue };
        if from == to {
            continue;
        }
        for k in 0..2 {
            let t = R::of((k + 1) as f64 / 3.0);
            let point = Contact {
                slot: first + 4 + 2 * pair + k,
                lever_m: a.lever_m + (b.lever_m - a.lever_m) * t,
                gap_m: a.gap_m + (b.gap_m - a.gap_m) * t,
                surface_m_s: a.surface_m_s + (b.surface_m_s - a.surface_m_s) * t,
                patch_m: [0, 1].map(|i| a.patch_m[i] + (b.patch_m[i] - a.patch_m[i]) * t),
                object_m: a.object_m + (b.object_m - a.object_m) * t,
                share: a.share * R::of(0.75),
                ..a
            };
            lost += usize::from(point.slot >= NC || contacts.push(point).is_err());
        }
        for end in [from, to] {
            if let Some(c) = contacts.get_mut(end) {
                c.share *= R::of(0.25);
            }
        }
    }
    lost
}
