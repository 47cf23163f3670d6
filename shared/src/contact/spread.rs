//! Contacts that effects spread: more points in place of few, whose sum is the same contact.

use heapless::Vec;

use super::{Contact, Contacts, FINGER_POINTS, is_finger};
use crate::real::{Real, abs, clamp, max, sqrt};

/// Replaces every point that is a whole contact by itself and has a `spread_m` above zero
/// by three points at that radius, which bear torsion `mu N spread_m`. They take the slots
/// after the point's own, which its body leaves free. What bears evenly takes the places that the force of the
/// pusher, `pusher_n` or about that, gives it. Returns the points that did not fit.
// Few models have such contacts: not with the time step in the board's fast memory.
#[inline(never)]
pub fn spread<R: Real, const NC: usize>(contacts: &mut Contacts<R, NC>, pusher_n: R) -> usize {
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
    ringed(contacts);
    lost + evened(contacts, pusher_n)
}

/// What the outer and the inner points of a disc have: radius in those of a ring (2/3 of the disc's), and share of the load.
/// Torsional friction is the ring's, force and torsion together within 3 % of the uniform disc's limit surface, and the
/// onset of sliding, straight and in torsion, of pads under even, Hertz's and Gaussian pressure is described within 6 % of the
/// limit (docs/lab/torsion-of-pads.md).
const OUT: (f64, f64) = (1.5, 0.35);
const IN: (f64, f64) = ((1.0 - OUT.0 * OUT.1) / (1.0 - OUT.1), 1.0 - OUT.1);
/// Torsional stiffness over the tangential one and the squared radius: a ring's, and the largest, as the inner points need some.
const RATIOS: [f64; 2] = [RING, 0.95];
const RING: f64 = 4.0 / 9.0;

/// Moves the points of flat fingers whose torsional stiffness is given ([`Contact::profile`]) outward and inward in turn, and
/// gives the outer ones as much of the tangential stiffness as that takes. Each moves on the line to the one opposite.
///
/// Three points under a slow shift beside a fast turn resist it otherwise forth than back (by a tenth, where the shift at the rim is
/// an eighth of the turn). The second finger has its outer ones where the first has its inner ones: together they do not.
/// With a negative ratio both are exchanged ([`crate::effects::contact_compliance::exchange_points`]).
fn ringed<R: Real, const NC: usize>(contacts: &mut Contacts<R, NC>) {
    let (least, most) = (R::of(RATIOS[0]), R::of(RATIOS[1]));
    let (outer2, inner2) = (RING * OUT.0 * OUT.0, RING * IN.0 * IN.0);
    for i in 0..contacts.len() {
        let Some(a) = contacts.get(i).copied().filter(|c| is_finger(c.body)) else { continue };
        let opposite = |c: &Contact<R>| c.body == a.body && c.slot == a.slot + FINGER_POINTS / 2;
        let j = contacts.iter().position(opposite);
        let (Some(ratio), Some(j)) = (a.profile, j) else { continue };
        let Some(b) = contacts.get(j).copied() else { continue };
        let outer = (clamp(abs(ratio), least, most) - R::of(inner2)) * R::of(1.0 / (outer2 - inner2));
        let first = a.body.index() + usize::from(ratio < R::zero());
        for (at, from, to) in [(i, &a, &b), (j, &b, &a)] {
            // The line is twice the radius long. Constants of each: no double precision on the board.
            let (moves, load, stiffer) = match (from.slot + first) % 2 {
                0 => (R::of(0.5 - 0.5 * OUT.0), R::of(2.0 * OUT.1), outer * R::of(1.0 / OUT.1)),
                _ => (R::of(0.5 - 0.5 * IN.0), R::of(2.0 * IN.1), (R::one() - outer) * R::of(1.0 / IN.1)),
            };
            if let Some(c) = contacts.get_mut(at) {
                *c = between(from, &[(to, moves)], (from.slot, from.share * load));
                c.tangential_n_m *= stiffer;
            }
        }
    }
}

/// Ends of what bears evenly: two of a line, four of a face.
const ENDS: usize = 4;
/// Least share of its length on which a line touches: before it is pressed nothing is known of it.
const TOUCHES: f64 = 0.2;
/// The same along the second axis: what is hard turns flat within a step, and must find points there. It bears at the end all
/// the same, as one of its points does.
const TOUCHES_ALONG: f64 = 1.0 / 3.0;
/// Places and weights of two points that integrate a cubic over 0 to 1 (Gauss), and of four with both ends (Simpson).
const GAUSS: [(f64, f64); 2] = [(0.211_324_865_405_187_13, 0.5), (0.788_675_134_594_812_9, 0.5)];
const SIMPSON: [(f64, f64); 4] = [(0.0, 0.125), (1.0 / 3.0, 0.375), (2.0 / 3.0, 0.375), (1.0, 0.125)];

/// Puts points in place of the ends of a line, or of the corners of a face, that bears evenly, whose sums are those of
/// Winkler's foundation pressed with `load_n`: a foundation's stiffness against shift and turning, and less of it where it
/// touches in part. The points lie where it touches under that load: depth is linear there, so that two of them along the first
/// axis, and three along the second, about which an object turns while it is pushed, give force and moment exactly. A fourth
/// stays at the other end, where the depth begins: what turns flat, and beyond, within the step meets it. Some of a face's
/// stiffness may lie at both ends of the second axis instead ([`Contact::profile`]). Returns the points that did not fit.
fn evened<R: Real, const NC: usize>(contacts: &mut Contacts<R, NC>, load_n: R) -> usize {
    let mut ends: Vec<(usize, Contact<R>), ENDS> = Vec::new();
    for (i, c) in contacts.iter().enumerate() {
        if c.profile.is_some() && !is_finger(c.body) && ends.push((i, *c)).is_err() {
            break;
        }
    }
    let mut lost = 0;
    match ends.as_slice() {
        [(i, a), (j, b)] => {
            let whole = a.share + b.share;
            let touches = touching((a, b), load_n, R::zero(), TOUCHES);
            for (at, (s, weight)) in [*i, *j].into_iter().zip(GAUSS.map(|place| within(touches, place))) {
                lost += placed(contacts, Some(at), between(a, &[(b, s)], (a.slot, whole * weight)));
            }
        }
        [(i, a), (j, b), (k, c), (l, d)] => {
            let whole = a.share + b.share + c.share + d.share;
            let second = |to: &Contact<R>| (to.patch_m[1] - a.patch_m[1]).abs();
            // From `a` across, along, and both.
            let [(k1, u), (k2, v)] = if second(b) > second(d) { [(l, d), (j, b)] } else { [(j, b), (l, d)] };
            let corners = [[*i, *k2], [*k1, *k]];
            let across = touching((a, u), load_n, R::zero(), TOUCHES);
            let rim = a.profile.unwrap_or(R::zero());
            let along = touching((a, v), load_n / across.1, rim, TOUCHES_ALONG);
            let columns = GAUSS.map(|place| within(across, place));
            for ((s, of), (column, row)) in columns.into_iter().zip(corners.iter().zip(0..)) {
                for (place, (t, weight)) in pressed(along, rim).into_iter().enumerate() {
                    let at = match place {
                        0 => column.first(),
                        3 => column.last(),
                        _ => None,
                    };
                    let slot = a.slot + ENDS + 2 * row + place.saturating_sub(1);
                    let share = whole * of * weight;
                    lost += placed(contacts, at.copied(), between(a, &[(u, s), (v, t)], (slot, share)));
                }
            }
        }
        _ => {}
    }
    lost
}

/// Puts `point` in place of the one `at`, whose slot it takes, or adds it. Returns the points that did not fit.
fn placed<R: Real, const NC: usize>(
    contacts: &mut Contacts<R, NC>,
    at: Option<usize>,
    point: Contact<R>,
) -> usize {
    match at {
        Some(at) => match contacts.get_mut(at) {
            Some(c) => {
                *c = Contact { slot: c.slot, ..point };
                0
            }
            None => 1,
        },
        None => usize::from(point.slot >= NC || contacts.push(point).is_err()),
    }
}

/// Where the side from `a` to `b` begins to touch and on how much of it, as shares of it. It gives way by `load_n` over its
/// stiffness `k` where all of it is pressed evenly. A wedge that is `w` of the side long, whose gap grows by `r` over the
/// side, bears `k r ((1 - rim) w^2 + rim w) / 2`. Not less than `least` of it.
fn touching<R: Real>((a, b): (&Contact<R>, &Contact<R>), load_n: R, rim: R, least: f64) -> (R, R) {
    let (one, zero, two) = (R::one(), R::zero(), R::of(2.0));
    let rise_m = b.gap_m - a.gap_m;
    let twice_m = two * max(load_n, zero) / a.normal_n_m;
    let mut touches = one;
    if rise_m.abs() > twice_m {
        let twice = twice_m / rise_m.abs();
        let under = rim + sqrt(rim * rim + R::of(4.0) * (one - rim) * twice);
        touches = max(R::of(least), if under > zero { two * twice / under } else { zero });
    }
    // At the end where the gap is less.
    (if rise_m < zero { one - touches } else { zero }, touches)
}

/// A place of the part of a side that touches, as a share of the side, and the share of its stiffness that it stands for.
fn within<R: Real>((from, touches): (R, R), (place, weight): (f64, f64)) -> (R, R) {
    (from + touches * R::of(place), touches * R::of(weight))
}

/// Simpson's places and weights on the part of a side that touches; of what touches in part, the one that bears nothing at the
/// other end of the side. `rim` of the stiffness lies at the ends instead.
fn pressed<R: Real>(touches: (R, R), rim: R) -> [(R, R); 4] {
    let (one, zero) = (R::one(), R::zero());
    let mut places = SIMPSON.map(|place| within(touches, place));
    let [first, .., last] = &mut places;
    match touches {
        (from, _) if from > zero => *first = (zero, R::of(SIMPSON[0].1)),
        (_, share) if share < one => *last = (one, R::of(SIMPSON[3].1)),
        _ => {}
    }
    for (_, weight) in &mut places {
        *weight *= one - rim;
    }
    let [first, .., last] = &mut places;
    for (_, weight) in [first, last] {
        *weight += rim * R::of(0.5);
    }
    places
}

/// The place `s` of the way from `a` to each of `towards`.
// Once in the flash.
#[inline(never)]
fn between<R: Real>(a: &Contact<R>, towards: &[(&Contact<R>, R)], (slot, share): (usize, R)) -> Contact<R> {
    let mut out = Contact { slot, share, ..*a };
    for (b, s) in towards {
        let s = *s;
        out.lever_m += (b.lever_m - a.lever_m) * s;
        out.gap_m += (b.gap_m - a.gap_m) * s;
        out.surface_m_s += (b.surface_m_s - a.surface_m_s) * s;
        out.object_m += (b.object_m - a.object_m) * s;
        for (to, (b, a)) in out.patch_m.iter_mut().zip(b.patch_m.iter().zip(a.patch_m)) {
            *to += (*b - a) * s;
        }
    }
    out
}
