//! Friction pyramids beside the exact cone, step by step.
//!
//! Each step of a run with pyramids ([`crate::steps`]) is made once more with the cone. What differs is the set
//! of friction forces alone.

use serde::Serialize;
use stickslip_shared::model::{Formulation, Model};
use stickslip_shared::solve::{SolveBudget, SolveStatus};
use stickslip_shared::step::{SolvedBy, Workspace, step_in};

use crate::steps::{Spread, Walked};

/// One step in both formulations.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// Pyramids were not solved within their part of the work.
    pub cone_instead: bool,
    /// Both were solved, each by its own formulation.
    pub compared: bool,
    /// Loaded contact points, and those of them that stick in one and slide in the other.
    pub points: usize,
    /// See `points`.
    pub differing: usize,
    /// Largest difference of a component of a body's normal force, or of a finger's force, N.
    pub force_n: f64,
    /// Largest normal force of a body, N.
    pub load_n: f64,
    /// Largest difference of a component of the object's velocity, m/s.
    pub velocity_m_s: f64,
    /// Work of the step with pyramids and with the cone: factorisations and evaluations.
    pub work: [[u32; 2]; 2],
}

/// Makes the step of `walked`, which asked for pyramids, with the cone.
#[must_use]
pub fn pair(walked: &Walked) -> Pair {
    let model = Model { formulation: Formulation::Cone, ..walked.model.clone() };
    let mut state = walked.before.clone();
    let mut work = Workspace::new();
    let cone = step_in(walked.scene, &model, &mut state, walked.drive, &SolveBudget::present(), &mut work);
    let own = walked.out;
    let compared = own.solved_by == SolvedBy::Pyramids
        && own.status == SolveStatus::Solved
        && cone.status == SolveStatus::Solved;
    let (mut points, mut differing) = (0, 0);
    for (a, b) in walked.after.slots.iter().zip(&state.slots) {
        if a.load_n > 0.0 && b.load_n > 0.0 {
            points += 1;
            differing += usize::from((a.speed_m_s > 0.0) != (b.speed_m_s > 0.0));
        }
    }
    let finger = |k: usize, i: usize| (own.reading.finger[k][i] - cone.reading.finger[k][i]).abs();
    let fingers = (0..2).flat_map(|k| (0..3).map(move |i| finger(k, i))).fold(0.0, f32::max);
    let normals = own.normal_n.iter().zip(&cone.normal_n).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    let velocity = |i: usize| (walked.after.velocity[i] - state.velocity[i]).abs();
    Pair {
        cone_instead: own.solved_by == SolvedBy::ConeInstead,
        compared,
        points,
        differing,
        force_n: f64::from(fingers.max(normals)),
        load_n: f64::from(cone.normal_n.iter().copied().fold(0.0, f32::max)),
        velocity_m_s: f64::from((0..3).map(velocity).fold(0.0, f32::max)),
        work: [[own.iterations, own.evaluations], [cone.iterations, cone.evaluations]],
    }
}

/// Steps of one kind.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Which.
    pub steps: String,
    /// All of them.
    pub number: usize,
    /// Share in which the cone was solved in place of pyramids.
    pub cone_instead_share: f64,
    /// Solved by both formulations.
    pub compared: usize,
    /// Share of the compared steps in which every loaded point sticks or slides in both alike.
    pub same_share: f64,
    /// Share of loaded points that do.
    pub same_points_share: f64,
    /// Body forces, N.
    pub force_n: Spread,
    /// Over the largest normal force (at least 1 N).
    pub relative: Spread,
    /// Object, m/s.
    pub velocity_m_s: Spread,
    /// Factorisations of a step with pyramids.
    pub factorisations: Spread,
    /// Evaluations and kinks of a step with pyramids.
    pub evaluations: Spread,
    /// Newton steps of the same with the cone, and evaluations.
    pub cone_iterations: Spread,
    /// See `cone_iterations`.
    pub cone_evaluations: Spread,
}

/// Summary of steps.
#[must_use]
pub fn summarise(steps: &str, pairs: &[Pair]) -> Summary {
    let compared: Vec<Pair> = pairs.iter().copied().filter(|p| p.compared).collect();
    let share = |part: usize, whole: usize| part as f64 / whole.max(1) as f64;
    let points: usize = compared.iter().map(|p| p.points).sum();
    let work = |by: usize, what: usize| Spread::of(pairs.iter().map(move |p| f64::from(p.work[by][what])));
    Summary {
        steps: steps.to_owned(),
        number: pairs.len(),
        cone_instead_share: share(pairs.iter().filter(|p| p.cone_instead).count(), pairs.len()),
        compared: compared.len(),
        same_share: share(compared.iter().filter(|p| p.differing == 0).count(), compared.len()),
        same_points_share: 1.0 - share(compared.iter().map(|p| p.differing).sum(), points),
        force_n: Spread::of(compared.iter().map(|p| p.force_n)),
        relative: Spread::of(compared.iter().map(|p| p.force_n / p.load_n.max(1.0))),
        velocity_m_s: Spread::of(compared.iter().map(|p| p.velocity_m_s)),
        factorisations: work(0, 0),
        evaluations: work(0, 1),
        cone_iterations: work(1, 0),
        cone_evaluations: work(1, 1),
    }
}
