//! Single against double precision of one time step.
//!
//! Each step of a run ([`crate::steps`]) is made once more in `f64`, from the very numbers that the `f32` step
//! began with. What differs is therefore the arithmetic alone, not a history that has drifted apart.

use serde::Serialize;
use stickslip_shared::cone::{SolveBudget, SolveStatus};
use stickslip_shared::contact::SLOTS;
use stickslip_shared::effects::MEMORY;
use stickslip_shared::model::MAX_EFFECTS;
use stickslip_shared::real::{Rotation, Vec3};
use stickslip_shared::step::{Drive, LastStep, Moving, Slot, State, Workspace, step_from};

use crate::steps::Walked;

/// How one step in `f32` compares with the same in `f64`.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct StepPair {
    /// Largest difference of a force component at a contact point, N.
    pub force_n: f64,
    /// Largest difference of a component of a body's force (sum over its points), N.
    pub body_force_n: f64,
    /// Largest force at a contact point, N.
    pub load_n: f64,
    /// Largest difference of a component of the object's velocity, m/s.
    pub velocity_m_s: f64,
    /// The same of its angular velocity, rad/s.
    pub turning_rad_s: f64,
    /// Contact points.
    pub contacts: usize,
    /// Both were solved.
    pub solved: bool,
    /// The equations have several solutions, and the two found different ones: compared is with
    /// that of `f64` to which the answer of `f32` leads.
    pub several: bool,
}

/// Velocities farther apart than this are not rounding, m/s and rad/s: perhaps another solution.
const APART: f64 = 1e-3;

/// Makes the step of `walked` in `f64` and compares. Where the answers are far apart it is made
/// once more from the answer of `f32`: friction against a body that presses back admits several
/// solutions (Painlevé), and which of them is found is no matter of precision.
#[must_use]
pub fn compare(walked: &Walked) -> StepPair {
    let first = pair(walked, &walked.before.velocity);
    if first.velocity_m_s.max(first.turning_rad_s) <= APART {
        return first;
    }
    let second = pair(walked, &walked.after.velocity);
    let nearer =
        second.velocity_m_s.max(second.turning_rad_s) <= 0.1 * first.velocity_m_s.max(first.turning_rad_s);
    if nearer && second.solved { StepPair { several: true, ..second } } else { first }
}

/// The iteration in `f64` begins at the velocity `guess`, that of the jaw included.
fn pair(walked: &Walked, guess: &[f32; 7]) -> StepPair {
    let (scene, model) = (walked.scene.cast::<f64>(), walked.model.cast::<f64>());
    let mut state = wide_state(walked.before);
    let guess = guess.map(f64::from);
    let mut work: Workspace<f64, SLOTS> = Workspace::new();
    let drive = wide_drive(walked.drive);
    let out = step_from(&scene, &model, &mut state, &drive, &SolveBudget::default(), &guess, &mut work);
    let mut pair = StepPair {
        force_n: 0.0,
        body_force_n: 0.0,
        load_n: 0.0,
        velocity_m_s: 0.0,
        turning_rad_s: 0.0,
        contacts: work.contacts.len(),
        solved: out.status == SolveStatus::Solved && walked.out.status == SolveStatus::Solved,
        several: false,
    };
    let mut narrow = [[0.0; 3]; SLOTS];
    let mut bodies = [[0.0; 3]; 4];
    for (c, answer) in walked.work.contacts.iter().zip(walked.work.answers()) {
        let f = answer.force_n.map(f64::from);
        narrow[c.slot] = f;
        let force: Vec3<f64> = world(&c.axes.map(|a| a.cast()), &f);
        (0..3).for_each(|k| bodies[c.body.index()][k] -= force[k]);
    }
    for (c, answer) in work.contacts.iter().zip(work.answers()) {
        let f = answer.force_n;
        let force = world(&c.axes, &f);
        for k in 0..3 {
            pair.force_n = pair.force_n.max((f[k] - narrow[c.slot][k]).abs());
            pair.load_n = pair.load_n.max(f[k].abs());
            bodies[c.body.index()][k] += force[k];
        }
    }
    pair.body_force_n = bodies.iter().flatten().fold(0.0, |m, x| m.max(x.abs()));
    for (k, (a, b)) in state.velocity.iter().zip(walked.after.velocity).enumerate() {
        let apart = (a - f64::from(b)).abs();
        match k {
            0..=2 => pair.velocity_m_s = pair.velocity_m_s.max(apart),
            3..=5 => pair.turning_rad_s = pair.turning_rad_s.max(apart),
            _ => {}
        }
    }
    pair
}

fn world(axes: &[Vec3<f64>; 3], f: &[f64; 3]) -> Vec3<f64> {
    axes[0] * f[0] + axes[1] * f[1] + axes[2] * f[2]
}

fn turn(r: &Rotation<f32>) -> Rotation<f64> {
    nalgebra::UnitQuaternion::new_unchecked(r.into_inner().cast())
}

fn wide_moving(m: &Moving<f32>) -> Moving<f64> {
    Moving {
        position_m: m.position_m.cast(),
        rotation: turn(&m.rotation),
        velocity_m_s: m.velocity_m_s.cast(),
        angular_rad_s: m.angular_rad_s.cast(),
        reference_m: m.reference_m.cast(),
    }
}

fn wide_drive(d: &Drive<f32>) -> Drive<f64> {
    Drive {
        dt_s: f64::from(d.dt_s),
        carrier: turn(&d.carrier),
        carrier_m_s: d.carrier_m_s.cast(),
        carrier_rad_s: d.carrier_rad_s.cast(),
        pusher: d.pusher.as_ref().map(wide_moving),
        support: d.support.as_ref().map(wide_moving),
        grip_n: f64::from(d.grip_n),
        trial: f64::from(d.trial),
    }
}

fn wide_state(s: &State<f32, SLOTS>) -> State<f64, SLOTS> {
    let mut memory = [[0.0; MEMORY]; MAX_EFFECTS];
    for (to, from) in memory.iter_mut().flatten().zip(s.memory.iter().flatten()) {
        *to = f64::from(*from);
    }
    State {
        time_s: f64::from(s.time_s),
        position_m: s.position_m.cast(),
        rotation: turn(&s.rotation),
        velocity: s.velocity.map(f64::from),
        absolute_m_s: s.absolute_m_s.cast(),
        absolute_rad_s: s.absolute_rad_s.cast(),
        jaw_half_m: f64::from(s.jaw_half_m),
        jaw_m: f64::from(s.jaw_m),
        slots: s.slots.map(|slot| Slot {
            spring_m: slot.spring_m.map(f64::from),
            slip_m: f64::from(slot.slip_m),
            speed_m_s: f64::from(slot.speed_m_s),
            rest_s: f64::from(slot.rest_s),
            load_n: f64::from(slot.load_n),
        }),
        faces: s.faces,
        memory,
        last: s.last.map(|last| LastStep {
            dt_s: f64::from(last.dt_s),
            grip_n: f64::from(last.grip_n),
            load_n: last.load_n.map(|loads| loads.map(f64::from)),
        }),
    }
}
