//! Random complementarity problems of the families that the solvers are judged by.
//!
//! Grasps: a prism (25 x 25 x 100 mm, 200.5 g) between two fingertip patches at Y = +-12.5 mm
//! and, with enough contacts, a pusher at the end X = -50 mm; one step is 4 ms. Finger `force`
//! gives each finger a body of its own that is pushed by the grip; `approach` gives the pad a
//! compliance and a closing speed. The degenerate families break what solvers lean on:
//! contacts twice, points on a line, no friction, patches exactly opposed, fingers a million
//! times heavier or lighter than the object, and exact ties in positions and speeds.

use crate::files::Factors;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stickslip_shared::lcp::factors::{Contact, Factors as Problem};

/// Which kind of problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Family {
    /// Grip given as force on finger bodies.
    Force,
    /// Grip given as approach against a stiff pad.
    Approach,
    /// Every contact twice.
    Dup,
    /// No friction.
    Mu0,
    /// The points of each finger on a line.
    Collinear,
    /// Patches exactly opposed.
    Opposite,
    /// Fingers a million times heavier than the object.
    Heavy,
    /// Fingers a million times lighter than the object.
    Light,
    /// Exact symmetry and ties in q.
    Ties,
    /// Directions, points, masses, friction (to 10), gaps and approach at random.
    Scattered,
    /// All contacts in one point.
    Coincident,
    /// No solution: rigid walls exactly opposed advance on the object from both sides.
    Crushed,
    /// No solution: three rigid walls around the object close in on it.
    Wedged,
}

/// Families without any solution. Their normal rows cancel exactly (in pairs or threes), so
/// that the sum of the separation speeds is the sum of their constants, which is negative,
/// whatever the impulses are.
pub const IMPOSSIBLE: [Family; 2] = [Family::Crushed, Family::Wedged];

/// Every family that has a solution, in the order of reports.
pub const FAMILIES: [Family; 11] = [
    Family::Force,
    Family::Approach,
    Family::Dup,
    Family::Mu0,
    Family::Collinear,
    Family::Opposite,
    Family::Heavy,
    Family::Light,
    Family::Ties,
    Family::Scattered,
    Family::Coincident,
];

/// The generator of one problem: the same seed gives the same problem on every machine.
pub fn rng(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

const HALF_SIDE_M: f64 = 0.0125;
const HALF_LENGTH_M: f64 = 0.05;
const DISC_RADIUS_M: f64 = 0.01;
const MASS_KG: f64 = 0.2005;
const STEP_S: f64 = 0.004;

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

struct Point {
    at: [f64; 3],
    normal: [f64; 3],
    tangents: [[f64; 3]; 2],
    /// Which finger body, if any.
    finger: Option<usize>,
}

fn finger_point(finger: usize, x: f64, z: f64) -> Point {
    let side = if finger == 0 { 1.0 } else { -1.0 };
    Point {
        at: [x, side * HALF_SIDE_M, z],
        normal: [0.0, -side, 0.0],
        tangents: [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        finger: Some(finger),
    }
}

fn pusher_point(y: f64, z: f64) -> Point {
    Point {
        at: [-HALF_LENGTH_M, y, z],
        normal: [1.0, 0.0, 0.0],
        tangents: [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        finger: None,
    }
}

fn unit(rng: &mut ChaCha8Rng) -> [f64; 3] {
    loop {
        let v = [0; 3].map(|_| rng.random_range(-1.0..1.0_f64));
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        if (0.1..1.0).contains(&length) {
            return v.map(|x| x / length);
        }
    }
}

/// Three walls around Z, whose normals add up to zero in every digit, at several heights.
fn wedge(contacts: usize, rng: &mut ChaCha8Rng) -> Vec<Point> {
    let mut list = Vec::new();
    for _ in 0..(contacts / 3).max(1) {
        let height = rng.random_range(-0.03..0.03);
        for normal in [[1.0, 0.0, 0.0], [-0.5, 0.75, 0.0], [-0.5, -0.75, 0.0]] {
            let at = [-0.02 * normal[0], -0.02 * normal[1], height];
            let across = [-normal[1], normal[0], 0.0];
            list.push(Point { at, normal, tangents: [across, [0.0, 0.0, 1.0]], finger: None });
        }
    }
    list
}

fn points(family: Family, contacts: usize, rng: &mut ChaCha8Rng) -> Vec<Point> {
    if family == Family::Wedged {
        return wedge(contacts, rng);
    }
    let pushers = match contacts {
        0..=8 => contacts % 2,
        _ => 2 - contacts % 2,
    };
    let each = (contacts - pushers) / 2;
    let mut list = Vec::new();
    let angle = rng.random_range(0.0..std::f64::consts::TAU);
    let mut first_patch: Vec<(f64, f64)> = Vec::new();
    for finger in 0..2 {
        for k in 0..each {
            let (x, z) = match family {
                Family::Ties => {
                    let turn = std::f64::consts::TAU * k as f64 / each as f64;
                    (0.0059 * turn.cos(), 0.0059 * turn.sin())
                }
                Family::Collinear => {
                    let along = 2.0 * (k as f64 + 0.5) / each as f64 - 1.0;
                    (along * DISC_RADIUS_M * angle.cos(), along * DISC_RADIUS_M * angle.sin())
                }
                Family::Opposite | Family::Crushed if finger == 1 => first_patch[k],
                Family::Dup if k % 2 == 1 => {
                    let Some(last) = list.last() else { continue };
                    let last: &Point = last;
                    (last.at[0], last.at[2])
                }
                Family::Coincident => (0.003, 0.001),
                _ => {
                    let radius = DISC_RADIUS_M * rng.random_range(0.0..1.0_f64).sqrt();
                    let turn = rng.random_range(0.0..std::f64::consts::TAU);
                    (radius * turn.cos(), radius * turn.sin())
                }
            };
            if finger == 0 {
                first_patch.push((x, z));
            }
            list.push(finger_point(finger, x, z));
        }
    }
    for k in 0..pushers {
        let side = if k == 0 { 1.0 } else { -1.0 };
        let y = match family {
            Family::Ties => 0.005 * side,
            Family::Coincident => 0.0,
            Family::Dup => 0.004,
            _ => rng.random_range(0.1..0.9) * HALF_SIDE_M * side,
        };
        let z = if family == Family::Ties { 0.0 } else { 0.003 };
        list.push(pusher_point(y, z));
    }
    if family == Family::Scattered {
        for point in &mut list {
            let normal = unit(rng);
            let mut other = unit(rng);
            while cross(normal, other).iter().map(|x| x * x).sum::<f64>() < 0.1 {
                other = unit(rng);
            }
            let t1 = cross(normal, other);
            let length = t1.iter().map(|x| x * x).sum::<f64>().sqrt();
            let t1 = t1.map(|x| x / length);
            // On the far side of the object from where the normal points: all push inwards.
            point.at = normal.map(|x| -0.02 * x + rng.random_range(-0.01..0.01));
            point.normal = normal;
            point.tangents = [t1, cross(normal, t1)];
        }
    }
    list
}

/// A problem of `contacts` contacts (at least 2); 6 degrees of freedom, or 8 with finger bodies.
pub fn contact_problem(family: Family, contacts: usize, seed: u64) -> Factors {
    let rng = &mut rng(seed ^ ((family as u64) << 56) ^ ((contacts as u64) << 48));
    let contacts = contacts.max(2);
    let points = points(family, contacts, rng);
    let ties = family == Family::Ties;
    let bodies = match family {
        Family::Force | Family::Collinear | Family::Heavy | Family::Light => true,
        Family::Approach | Family::Scattered | Family::Crushed | Family::Wedged => false,
        _ => rng.random_bool(0.5),
    };
    let freedoms = if bodies { 8 } else { 6 };
    let (side, length) = (2.0 * HALF_SIDE_M, 2.0 * HALF_LENGTH_M);
    let about_length = MASS_KG * side * side / 6.0;
    let across = MASS_KG * (side * side + length * length) / 12.0;
    let mut inverse_mass = vec![1.0 / MASS_KG; 3];
    inverse_mass.extend([1.0 / about_length, 1.0 / across, 1.0 / across]);
    if bodies {
        for _ in 0..2 {
            inverse_mass.push(match family {
                Family::Heavy => 1e-6 / MASS_KG,
                Family::Light => 1e6 / MASS_KG,
                _ if ties => 5.0,
                _ => rng.random_range(2.0..20.0),
            });
        }
    }
    let mu_finger = if ties { 0.4 } else { rng.random_range(0.2..0.5) };
    let mu_pusher = if ties { 0.4 } else { rng.random_range(0.2..0.5) };
    let grip_ns: [f64; 2] = if ties {
        [0.08 / 2.0; 2]
    } else {
        let grip = rng.random_range(1.0..40.0) * STEP_S;
        [grip, grip * rng.random_range(0.8..1.2)]
    };
    let each = points.iter().filter(|p| p.finger == Some(0)).count().max(1);
    let compliance_pad = if ties { 0.9375 } else { 10f64.powf(rng.random_range(-1.0..0.6)) };
    let noise = if ties { 0.0 } else { 1e-4 };
    let gravity = if ties { 0.0 } else { -9.81 * STEP_S };
    let velocity: [f64; 6] = if ties {
        [0.0; 6]
    } else {
        let spread = [0.01, 1e-4, 5e-3, 0.05, 0.05, 0.05];
        let mut v = spread.map(|s| rng.random_range(-s..s));
        v[2] += gravity;
        v
    };
    let pushing = if ties { 0.0031 } else { rng.random_range(0.001..0.012) };
    let mut problem = Factors { inverse_mass, ..Factors::default() };
    let (mut normals, mut tangents) = (Vec::new(), Vec::new());
    let (mut separation, mut slips) = (Vec::new(), Vec::new());
    for point in &points {
        let row = |direction: [f64; 3], finger: Option<usize>| {
            let mut row = direction.to_vec();
            row.extend(cross(point.at, direction));
            row.resize(freedoms, 0.0);
            if let (Some(finger), true) = (finger, bodies) {
                row[6 + finger] = -1.0;
            }
            row
        };
        let normal = row(point.normal, point.finger);
        let free: f64 = normal.iter().zip(&velocity).map(|(a, b)| a * b).sum();
        let jitter = if noise > 0.0 { rng.random_range(-noise..noise) } else { 0.0 };
        let (compliance, friction, approach) = match (family, point.finger) {
            (Family::Scattered, _) => (
                // Rigid contacts from all sides would often have no solution.
                10f64.powf(rng.random_range(-3.0..1.0)),
                10f64.powf(rng.random_range(-3.0..1.0)),
                rng.random_range(-0.05..0.15),
            ),
            (Family::Crushed | Family::Wedged, _) => {
                // Far more than the noise of 0.1 mm/s.
                (0.0, mu_finger, 10f64.powf(rng.random_range(-2.5..0.0)))
            }
            (_, Some(finger)) if bodies => {
                let speed = match family {
                    Family::Heavy => rng.random_range(-2e-4..8e-4),
                    _ => grip_ns[finger] * problem.inverse_mass[6 + finger],
                };
                (0.0, mu_finger, speed)
            }
            (_, Some(finger)) => (compliance_pad, mu_finger, compliance_pad * grip_ns[finger] / each as f64),
            (_, None) => (0.0, mu_pusher, pushing),
        };
        problem.compliance.push(compliance);
        problem.friction.push(if family == Family::Mu0 { 0.0 } else { friction });
        separation.push(free + jitter - approach);
        normals.extend(normal);
        let mut pair = Vec::new();
        for direction in point.tangents {
            let tangent = row(direction, None);
            pair.push((
                tangent.iter().zip(&velocity).map(|(a, b)| a * b).sum::<f64>()
                    + if ties { 0.0003 * direction[2] } else { 0.0 },
                tangent,
            ));
        }
        for sign in [1.0, -1.0] {
            for (slip, tangent) in &pair {
                tangents.extend(tangent.iter().map(|x| sign * x));
                slips.push(sign * slip);
            }
        }
    }
    problem.jacobian = normals;
    problem.jacobian.extend(tangents);
    problem.constant = separation;
    problem.constant.extend(slips);
    problem.constant.extend(vec![0.0; points.len()]);
    problem
}

/// The problem of a step later: the object has moved and turned, and its velocity has changed,
/// by about `change` of their sizes (12 mm, 0.05 m/s, 0.5 rad/s), alike for all contacts.
pub fn neighbour(problem: &Factors, change: f64, seed: u64) -> Factors {
    let rng = &mut rng(seed);
    let mut next = problem.clone();
    let (contacts, freedoms) = (next.friction.len(), next.inverse_mass.len());
    let mut some = |size: f64| change * size * rng.random_range(-1.0..1.0);
    let shift = [some(HALF_SIDE_M), some(HALF_SIDE_M), some(HALF_SIDE_M)];
    let velocity = [some(0.05), some(0.05), some(0.05), some(0.5), some(0.5), some(0.5)];
    for (row, q) in next.jacobian.chunks_exact_mut(freedoms).zip(&mut next.constant) {
        if freedoms < 6 {
            continue;
        }
        let turn = cross(shift, [row[0], row[1], row[2]]);
        for k in 0..3 {
            row[3 + k] += turn[k];
        }
        *q += row.iter().zip(&velocity).map(|(a, b)| a * b).sum::<f64>();
    }
    // Opposite tangents stay exact opposites.
    for i in 0..contacts {
        for k in 0..2 {
            let (plus, minus) = (contacts + 4 * i + k, contacts + 4 * i + k + 2);
            next.constant[minus] = -next.constant[plus];
            for c in 0..freedoms {
                next.jacobian[minus * freedoms + c] = -next.jacobian[plus * freedoms + c];
            }
        }
    }
    next
}

/// Kinds of dense problems that are not contact problems.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum DenseFamily {
    /// Symmetric positive definite.
    Spd,
    /// P-matrices: a skew part and positive principal minors.
    Pmat,
    /// Strictly copositive.
    Copos,
}

/// A dense problem with n unknowns: `M` row by row, and `q`.
pub fn dense_problem(family: DenseFamily, n: usize, seed: u64) -> (Vec<f64>, Vec<f64>) {
    let rng = &mut rng(seed ^ ((family as u64 + 100) << 56) ^ ((n as u64) << 48));
    let a: Vec<f64> = (0..n * n).map(|_| rng.random_range(-1.0..1.0)).collect();
    let mut m = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..n {
            m[i * n + j] = match family {
                DenseFamily::Copos => {
                    if i == j {
                        1.0 + a[i * n + j].abs()
                    } else {
                        a[i * n + j].abs()
                    }
                }
                _ => (0..n).map(|k| a[i * n + k] * a[j * n + k]).sum::<f64>() / n as f64,
            };
        }
    }
    if family == DenseFamily::Pmat {
        for i in 0..n {
            for j in 0..i {
                let skew = rng.random_range(-1.0..1.0);
                m[i * n + j] += skew;
                m[j * n + i] -= skew;
            }
        }
    }
    if family != DenseFamily::Copos {
        for i in 0..n {
            m[i * n + i] += 0.01;
        }
    }
    let q = (0..n).map(|_| rng.random_range(-1.0..0.5)).collect();
    (m, q)
}

/// For the solver: `None` where the problem exceeds the capacities, or its third and fourth
/// tangents are not the opposites of the first two, or the slip bounds have constants (only
/// the dense form expresses these).
pub fn to_problem<const NC: usize, const ND: usize>(p: &Factors) -> Option<Problem<f64, NC, ND>> {
    let (contacts, freedoms) = (p.friction.len(), p.inverse_mass.len());
    if contacts > NC || freedoms > ND || freedoms == 0 {
        return None;
    }
    let mut inverse_mass = [0.0; ND];
    inverse_mass[..freedoms].copy_from_slice(&p.inverse_mass);
    let mut problem = Problem { inverse_mass, contacts: heapless::Vec::new() };
    let row = |r: usize| {
        let mut row = [0.0; ND];
        row[..freedoms].copy_from_slice(&p.jacobian[r * freedoms..(r + 1) * freedoms]);
        row
    };
    for i in 0..contacts {
        let tangent = contacts + 4 * i;
        for k in 0..2 {
            let opposite = row(tangent + k).iter().zip(row(tangent + k + 2)).all(|(a, b)| *a == -b);
            if !opposite || p.constant[tangent + k] != -p.constant[tangent + k + 2] {
                return None;
            }
        }
        if p.constant[5 * contacts + i] != 0.0 {
            return None;
        }
        let contact = Contact {
            normal: row(i),
            tangents: [row(tangent), row(tangent + 1)],
            compliance: p.compliance[i],
            tangential_compliance: 0.0,
            friction: p.friction[i],
            separation: p.constant[i],
            slip: [p.constant[tangent], p.constant[tangent + 1]],
        };
        problem.contacts.push(contact).ok()?;
    }
    Some(problem)
}
