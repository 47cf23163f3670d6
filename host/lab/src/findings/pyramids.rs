//! The paper's push with fixed friction pyramids, beside the exact cone.
//!
//! The time stepping of Stewart and Trinkle (1996), on which the paper's hard model rests,
//! replaces each contact's friction cone by a pyramid. Force along the push hardly depends
//! on it, sag does: gravity acts across the slip, and what friction remains in that
//! direction is decided by where the pyramid's edges happen to lie. This module steps the
//! same scene with fixed pyramids of 4, 8 and 16 edges, turned by several angles, with pyramids whose
//! first edge follows the slip, and with the model's exact cone.

use nalgebra::{UnitQuaternion, Vector3};
use serde::Serialize;
use stickslip_shared::contact::{Body, SLOTS};
use stickslip_shared::lcp::step::{FirstEdge, PyramidParams};
use stickslip_shared::model::{
    Base, FingerContact, Formulation, Friction, Model, Object, PusherContact, Scene, Shape,
};
use stickslip_shared::shape::inertia;
use stickslip_shared::solve::{SolveBudget, SolveStatus};
use stickslip_shared::step::{Drive, Moving, SolvedBy, State, StepParams, Workspace, step_in};

/// Step, s.
const DT_S: f64 = 0.004;
const GRIP_N: f64 = 20.0;
const SPEED_M_S: f64 = 0.01;
const TIME_S: f64 = 1.5;
/// The pusher's face is so far from the object at the start, m.
const FREE_M: f64 = 5e-4;
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
    /// A pyramid whose first edge follows the slip of each point.
    Following {
        /// Edges.
        edges: usize,
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
    /// Steps whose problem was not solved, or with the cone in place of pyramids.
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
        FrictionShape::Following { edges: 4 },
        FrictionShape::Following { edges: 8 },
    ];
    laws.into_iter().map(|law| push(mu, law)).collect()
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
    let (formulation, pyramid) = match friction {
        FrictionShape::Cone => (Formulation::Cone, PyramidParams::default()),
        FrictionShape::Pyramid { edges, turned_deg, outside } => {
            let (sin, cos) = turned_deg.to_radians().sin_cos();
            let first_edge = FirstEdge::Fixed([cos, sin]);
            let edges = edges as u8;
            (
                Formulation::Lcp,
                PyramidParams { edges, first_edge, circumscribed: outside, ..Default::default() },
            )
        }
        FrictionShape::Following { edges } => {
            (Formulation::Lcp, PyramidParams { edges: edges as u8, ..Default::default() })
        }
    };
    let friction_coefficients = Friction { finger: mu, pusher: 0.25, support: 0.3 };
    let model = Model { formulation, ..Model::base(Base::Hard, friction_coefficients) };
    let mut state: State<f64, SLOTS> =
        State::held(&scene, &model, &drive(0.0), Vector3::zeros(), UnitQuaternion::identity());
    let params = StepParams { pyramid, ..StepParams::default() };
    let mut work = Workspace::with(params, Default::default());
    let steps = (TIME_S / DT_S).round() as usize;
    let mut row = Row { friction, push_n: 0.0, sag_m: 0.0, pitch_rad: 0.0, unsolved: 0, steps };
    for k in 0..steps {
        let drive = drive(k as f64 * DT_S);
        let out = step_in(&scene, &model, &mut state, &drive, &SolveBudget::default(), &mut work);
        let own = out.status == SolveStatus::Solved && out.solved_by != SolvedBy::ConeInstead;
        row.unsolved += usize::from(!own);
        if 2 * k >= steps {
            row.push_n += out.normal_n[Body::Pusher.index()] / (steps - steps / 2) as f64;
        }
    }
    row.sag_m = -state.position_m.z;
    row.pitch_rad = state.rotation.scaled_axis().y.abs();
    row
}

/// A law in words.
pub fn words(friction: FrictionShape) -> String {
    match friction {
        FrictionShape::Cone => "exact cone".into(),
        FrictionShape::Following { edges } => format!("{edges} edges, the first along the slip"),
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
