//! What the pads hold of an object before anything moves.
//!
//! Springs start as they are where the object was measured at rest ([`sink`]). An object that also lies on something
//! may be carried by either: how much the fingers bear is left from closing the grasp. Where it is known the springs are
//! loaded to it ([`carry`]).

use nalgebra::Vector3;
use stickslip_shared::cone::SolveStatus;
use stickslip_shared::contact::{Body, SLOTS};
use stickslip_shared::model::{Model, Scene};
use stickslip_shared::step::{Drive, State, Workspace, step_f64};

/// Steps of [`sink`] and their time: long against the swing of an object on its pads, which the implicit
/// step then damps.
const LOADING_STEPS: usize = 3;
const LOADING_STEP_S: f64 = 0.02;
/// How often the object is put back.
const LOADING_ROUNDS: usize = 3;
/// How often [`carry`] loads the springs at most, how near it comes (share of the weight), and the least share of a
/// spring's change that stays in the force where they are loaded at all.
const CARRY_ROUNDS: usize = 8;
const CARRIED: f64 = 0.01;
const LEAST_STAYS: f64 = 0.05;

/// Loads the springs of pads that give way, and the jaw, as they are where the object was measured at rest:
/// it is let go, sinks into its pads, and is put back to where it was measured with the springs as they are.
pub(super) fn sink(
    scene: &Scene<f64>,
    model: &Model<f64>,
    state: &mut State<f64, SLOTS>,
    drive: &Drive<f64>,
    work: &mut Workspace<f64, SLOTS>,
) {
    let start = state.clone();
    let still = Drive { dt_s: LOADING_STEP_S, ..*drive };
    for _ in 0..LOADING_ROUNDS {
        for _ in 0..LOADING_STEPS {
            if step_f64(scene, model, state, &still, work).status != SolveStatus::Solved {
                *state = start;
                return;
            }
        }
        let (slots, jaw_m) = (state.slots, state.jaw_m);
        *state = State { slots, jaw_m, ..start.clone() };
        for slot in &mut state.slots {
            (slot.slip_m, slot.speed_m_s, slot.rest_s) = (0.0, 0.0, 0.0);
        }
    }
}

/// Loads the springs of the fingers such that they carry `carried_n` of `weight_n` along `up` (carrier axes); what lies under the object bears the
/// rest. As they were where the force does not follow them: friction bears no more, or nothing lies under the object.
pub(super) fn carry(
    scene: &Scene<f64>,
    model: &Model<f64>,
    state: &mut State<f64, SLOTS>,
    drive: &Drive<f64>,
    (up, (carried_n, weight_n)): (Vector3<f64>, (f64, f64)),
    work: &mut Workspace<f64, SLOTS>,
) {
    let mut before: Option<(State<f64, SLOTS>, f64, f64)> = None;
    let mut stays = 1.0;
    for _ in 0..CARRY_ROUNDS {
        let mut tried = state.clone();
        let step = step_f64(scene, model, &mut tried, drive, work);
        let force = |k: usize| Vector3::from_row_slice(&step.reading.finger[k][..3]);
        let now_n = up.dot(&(force(0) + force(1)));
        let solved = step.status == SolveStatus::Solved;
        if let Some((then, then_n, changed_n)) = before.take() {
            stays = (now_n - then_n) / changed_n;
            if !(solved && stays > LEAST_STAYS) {
                *state = then;
                return;
            }
        }
        let missing_n = carried_n - now_n;
        if !solved || missing_n.abs() < CARRIED * weight_n {
            return;
        }
        let change_n = missing_n / stays.min(1.0);
        before = Some((state.clone(), now_n, change_n));
        for c in work.contacts.iter().filter(|c| matches!(c.body, Body::Finger1 | Body::Finger2)) {
            let Some(slot) = state.slots.get_mut(c.slot) else { continue };
            for k in 0..2 {
                // Each finger half; a spring pushes against its length.
                slot.spring_m[k] -= 0.5 * change_n * up.dot(&c.axes[k + 1]) / c.tangential_n_m;
            }
        }
    }
}
