//! The paper's push with fixed friction pyramids, beside the exact cone.
//!
//! The time stepping of Stewart and Trinkle (1996), on which the paper's hard model rests,
//! replaces each contact's friction cone by a pyramid. Force along the push hardly depends
//! on it, sag does: gravity acts across the slip, and what friction remains in that
//! direction is decided by where the pyramid's edges happen to lie. This module steps the
//! same scene with pyramids of 4, 8 and 16 edges, turned by several angles, with rigid
//! contacts and Lemke's method, and with the model's exact cone.

use nalgebra::{Matrix3, SMatrix, SVector, UnitQuaternion, Vector3};
use serde::Serialize;
use stickslip_shared::contact::{Body, Contacts, SLOTS, find, is_finger};
use stickslip_shared::lcp::dense::Dense;
use stickslip_shared::model::{Base, FingerContact, Friction, Model, Object, PusherContact, Scene, Shape};
use stickslip_shared::shape::{inertia, rotated_inertia};
use stickslip_shared::step::{Drive, JAW_MASS_KG, Moving, State, step, turned};

/// Step, s.
const DT_S: f64 = 0.004;
const GRIP_N: f64 = 20.0;
const SPEED_M_S: f64 = 0.01;
const TIME_S: f64 = 1.5;
/// The pusher's face is so far from the object at the start, m.
const FREE_M: f64 = 5e-4;
/// Room for 16 contacts with 16 edges each.
const CAPACITY: usize = 16 * 18 + 2;
/// Stack of a thread that holds the dense solver.
const STACK_BYTES: usize = 64 << 20;

/// A friction law of one row.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FrictionShape {
    /// The exact cone.
    Cone,
    /// A pyramid.
    Pyramid {
        /// Edges.
        edges: usize,
        /// Turned from the direction of the push, degrees.
        turned_deg: f64,
        /// Whether its faces touch the cone (circumscribed) instead of its edges.
        outside: bool,
    },
}

/// What came of one friction law.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Which.
    pub friction: FrictionShape,
    /// Mean force on the pusher over the second half, N.
    pub push_n: f64,
    /// How far the object has gone down in the grasp, m.
    pub sag_m: f64,
    /// How far it has turned about the fingers' axis, rad.
    pub pitch_rad: f64,
    /// Steps whose problem was not solved.
    pub unsolved: usize,
    /// Steps.
    pub steps: usize,
}

/// The rows of the table, at finger friction `mu` (pusher 0.25).
pub fn table(mu: f64) -> Vec<Row> {
    let pyramid = |edges, turned_deg| FrictionShape::Pyramid { edges, turned_deg, outside: false };
    let laws = [
        FrictionShape::Cone,
        pyramid(4, 0.0),
        pyramid(4, 45.0),
        FrictionShape::Pyramid { edges: 4, turned_deg: 45.0, outside: true },
        pyramid(4, 22.5),
        pyramid(8, 0.0),
        pyramid(8, 22.5),
        pyramid(16, 0.0),
    ];
    std::thread::scope(|scope| {
        let start = |law: FrictionShape| {
            std::thread::Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, move || push(mu, law))
        };
        // Two at a time: the laws with many edges take seconds each.
        let mut rows = Vec::new();
        for pair in laws.chunks(2) {
            let running: Vec<_> = pair.iter().map(|law| start(*law)).collect();
            rows.extend(running.into_iter().filter_map(|r| r.ok()?.join().ok()));
        }
        rows
    })
}

/// The scene of the paper's figure: obj4, the fingers at rest, the flat pusher moving.
fn scene() -> Scene<f64> {
    let shape = Shape::Prism { length_m: 0.1, side_m: 0.025 };
    let mass_kg = 0.2005;
    Scene {
        gravity_m_s2: [0.0, 0.0, -9.81],
        object: Object { inertia_kg_m2: inertia(&shape, mass_kg), shape, mass_kg },
        fingers: Some(FingerContact::Disc { diameter_m: 0.02 }),
        pusher: Some(PusherContact::Plane),
        support: None,
    }
}

fn drive(t_s: f64) -> Drive<f64> {
    let at = Vector3::new(-0.05 - FREE_M + SPEED_M_S * t_s, 0.0, 0.0);
    Drive {
        dt_s: DT_S,
        carrier: UnitQuaternion::identity(),
        carrier_m_s: Vector3::zeros(),
        carrier_rad_s: Vector3::zeros(),
        pusher: Some(Moving {
            position_m: at,
            rotation: UnitQuaternion::identity(),
            velocity_m_s: Vector3::new(SPEED_M_S, 0.0, 0.0),
            angular_rad_s: Vector3::zeros(),
            reference_m: at,
        }),
        support: None,
        grip_n: GRIP_N,
        trial: 0.0,
    }
}

/// One push.
pub fn push(mu: f64, friction: FrictionShape) -> Row {
    let scene = scene();
    let model = Model::base(Base::Hard, Friction { finger: mu, pusher: 0.25, support: 0.3 });
    let mut state: State<f64, SLOTS> =
        State::held(&scene, &model, &drive(0.0), Vector3::zeros(), UnitQuaternion::identity());
    let mut solver = Box::new(Dense::<f64, CAPACITY>::new());
    let steps = (TIME_S / DT_S).round() as usize;
    let mut row = Row { friction, push_n: 0.0, sag_m: 0.0, pitch_rad: 0.0, unsolved: 0, steps };
    for k in 0..steps {
        let drive = drive(k as f64 * DT_S);
        let force_n = match friction {
            FrictionShape::Cone => {
                let out = step(&scene, &model, &mut state, &drive);
                row.unsolved += usize::from(out.status != stickslip_shared::cone::SolveStatus::Solved);
                out.normal_n[Body::Pusher.index()]
            }
            FrictionShape::Pyramid { edges, turned_deg, outside } => {
                let shape = Pyramid { edges, turned_rad: turned_deg.to_radians(), outside };
                match pyramid_step(&scene, &model, &mut state, &drive, &shape, &mut solver) {
                    Some(force_n) => force_n,
                    None => {
                        row.unsolved += 1;
                        continue;
                    }
                }
            }
        };
        if 2 * k >= steps {
            row.push_n += force_n / (steps - steps / 2) as f64;
        }
    }
    row.sag_m = -state.position_m.z;
    row.pitch_rad = state.rotation.scaled_axis().y.abs();
    row
}

struct Pyramid {
    edges: usize,
    turned_rad: f64,
    outside: bool,
}

type Row7 = SVector<f64, 7>;

/// One step with rigid contacts and pyramids; the pusher's normal force. `None` where Lemke's
/// method found no solution: the state is left then.
fn pyramid_step(
    scene: &Scene<f64>,
    model: &Model<f64>,
    state: &mut State<f64, SLOTS>,
    drive: &Drive<f64>,
    pyramid: &Pyramid,
    solver: &mut Dense<f64, CAPACITY>,
) -> Option<f64> {
    let mut contacts: Contacts<f64, SLOTS> = heapless::Vec::new();
    find(scene, model, state, drive, &mut contacts);
    contacts.retain(|c| c.gap_m < 1e-3);
    let (nc, e) = (contacts.len(), pyramid.edges);
    let inverse = inverse_mass(scene, state);
    let mut free = Row7::from(state.velocity);
    for k in 0..3 {
        free[k] += scene.gravity_m_s2[k] * DT_S;
    }
    free[6] -= 2.0 * drive.grip_n * DT_S / JAW_MASS_KG;
    // Rows of the Jacobian: normals, then the edges of each contact.
    let mut rows: Vec<Row7> = Vec::with_capacity(nc * (1 + e));
    let mut q = Vec::with_capacity(nc * (2 + e));
    for c in &contacts {
        let mut row = along(&c.axes[0], &c.lever_m);
        row[6] = if is_finger(c.body) { 1.0 } else { 0.0 };
        q.push(row.dot(&free) - c.axes[0].dot(&c.surface_m_s) + c.gap_m / DT_S);
        rows.push(row);
    }
    for c in &contacts {
        for k in 0..e {
            let angle = pyramid.turned_rad + k as f64 * std::f64::consts::TAU / e as f64;
            let edge = c.axes[1] * angle.cos() + c.axes[2] * angle.sin();
            let row = along(&edge, &c.lever_m);
            q.push(row.dot(&free) - edge.dot(&c.surface_m_s));
            rows.push(row);
        }
    }
    q.extend(std::iter::repeat_n(0.0, nc));
    let n = q.len();
    let mut m = vec![0.0; n * n];
    let weighed: Vec<Row7> = rows.iter().map(|r| inverse * r).collect();
    for (i, row) in rows.iter().enumerate() {
        for (j, w) in weighed.iter().enumerate() {
            m[i * n + j] = row.dot(w);
        }
    }
    let wider = if pyramid.outside { 1.0 / (std::f64::consts::PI / e as f64).cos() } else { 1.0 };
    for (i, c) in contacts.iter().enumerate() {
        let bound = nc * (1 + e) + i;
        let mu = if is_finger(c.body) { model.friction.finger } else { model.friction.pusher };
        m[bound * n + i] = mu * wider;
        for k in 0..e {
            let edge = nc + i * e + k;
            m[edge * n + bound] = 1.0;
            m[bound * n + edge] = -1.0;
        }
    }
    let outcome = solver.solve(&m, &q);
    let z = outcome.solved()?;
    let mut velocity = free;
    for (w, impulse) in weighed.iter().zip(z) {
        velocity += w * *impulse;
    }
    let (v, w) = (velocity.fixed_rows::<3>(0).into_owned(), velocity.fixed_rows::<3>(3).into_owned());
    state.velocity = velocity.into();
    state.position_m += v * DT_S;
    state.rotation = turned(&state.rotation, &(w * DT_S));
    state.jaw_m += velocity[6] * DT_S;
    let pushed = contacts.iter().zip(z).filter(|(c, _)| c.body == Body::Pusher);
    Some(pushed.map(|(_, impulse)| impulse / DT_S).sum())
}

/// Velocity of the object's point at `lever` along `direction`, as a row.
fn along(direction: &Vector3<f64>, lever: &Vector3<f64>) -> Row7 {
    let turn = lever.cross(direction);
    Row7::from([direction.x, direction.y, direction.z, turn.x, turn.y, turn.z, 0.0])
}

fn inverse_mass(scene: &Scene<f64>, state: &State<f64, SLOTS>) -> SMatrix<f64, 7, 7> {
    let mut inverse = SMatrix::<f64, 7, 7>::zeros();
    for k in 0..3 {
        inverse[(k, k)] = 1.0 / scene.object.mass_kg;
    }
    let i = rotated_inertia(&scene.object, &state.rotation);
    let i = Matrix3::from_fn(|r, c| i[r][c]).try_inverse().unwrap_or_else(Matrix3::zeros);
    inverse.fixed_view_mut::<3, 3>(3, 3).copy_from(&i);
    inverse[(6, 6)] = 1.0 / JAW_MASS_KG;
    inverse
}

/// A law in words.
pub fn words(friction: FrictionShape) -> String {
    match friction {
        FrictionShape::Cone => "exact cone".into(),
        FrictionShape::Pyramid { edges, turned_deg, outside } => {
            let turned = if turned_deg == 0.0 {
                "one along the push".into()
            } else {
                format!("at {turned_deg} degrees")
            };
            format!("{edges} edges, {turned}{}", if outside { ", circumscribed" } else { "" })
        }
    }
}
