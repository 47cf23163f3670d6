//! What the pads hold of an object before anything moves.
//!
//! Springs start as they are where the object was measured at rest ([`sink`]). An object that also lies on something
//! may be carried by either: how much the fingers bear is left from closing the grasp. Where it is known the springs are
//! loaded to it ([`carry`]), or an edge that touches is pressed against it ([`press`]). Where it is not, what lies on a table or
//! a platform lies there with its weight, and pads carry what only touches an edge: it was grasped before.

use nalgebra::Vector3;
use stickslip_shared::cone::SolveStatus;
use stickslip_shared::contact::{self, Body, Contacts, SLOTS, is_finger};
use stickslip_shared::effects::Effect;
use stickslip_shared::model::{Base, Model, Scene};
use stickslip_shared::step::{Drive, State, StepSummary, Workspace, step_f64};

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

/// How an object rests before anything moves.
pub(super) struct Rest {
    /// It lies on a table or a platform.
    pub lies: bool,
    /// Upward, carrier axes, and how much the fingers carry of which weight, N; `None` where that is not known.
    pub carried: Option<(Vector3<f64>, (f64, f64))>,
}

/// Loads pads, jaw and what is under the object as they are at rest. The pusher is moved by what it presses with; by how much, m,
/// world axes.
pub(super) fn load(
    (scene, model): (&Scene<f64>, &Model<f64>),
    state: &mut State<f64, SLOTS>,
    drive: &mut Drive<f64>,
    rest: &Rest,
    work: &mut Workspace<f64, SLOTS>,
) -> Vector3<f64> {
    let gives_way = scene.fingers.is_some() && gives_way(model);
    if gives_way {
        // What only touches an edge was grasped before.
        let pusher = drive.pusher.filter(|_| rest.lies);
        sink(scene, model, state, &Drive { pusher, ..*drive }, work);
    }
    let Some(carried) = rest.carried else { return Vector3::zeros() };
    if rest.lies {
        carry(scene, model, state, drive, carried, work);
    } else if gives_way {
        let by = press(scene, model, state, drive, carried, work);
        if let Some(p) = &mut drive.pusher {
            p.position_m += by;
        }
        return drive.carrier.transform_vector(&by);
    }
    Vector3::zeros()
}

/// Whether contacts of `model` give way.
fn gives_way(model: &Model<f64>) -> bool {
    let compliance = |e: &Effect<f64>| e.info().is_some_and(|i| i.role.is_compliance());
    matches!(model.base, Base::Soft { .. }) || model.effects.iter().any(compliance)
}

/// Loads the springs of pads that give way, and the jaw, as they are where the object was measured at rest:
/// it is let go, sinks into its pads, and is put back to where it was measured with the springs as they are.
fn sink(
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
        forget_slip(state);
    }
}

/// Nothing has slipped yet.
fn forget_slip(state: &mut State<f64, SLOTS>) {
    for slot in &mut state.slots {
        (slot.slip_m, slot.speed_m_s, slot.rest_s) = (0.0, 0.0, 0.0);
    }
}

/// What both fingers carry along `up` in a step, N.
fn borne_n(step: &StepSummary<f64>, up: &Vector3<f64>) -> f64 {
    let force = |k: usize| Vector3::from_row_slice(&step.reading.finger[k][..3]);
    up.dot(&(force(0) + force(1)))
}

/// Presses a pusher that touches the object at the start against it until the fingers carry no more than `carried_n` of `weight_n`
/// along `up` (carrier axes): the rest of the weight is what it pushes with. Springs and pusher are then as that leaves them where the
/// object was measured. By how much the pusher has moved, carrier axes.
fn press(
    scene: &Scene<f64>,
    model: &Model<f64>,
    state: &mut State<f64, SLOTS>,
    drive: &Drive<f64>,
    (up, (carried_n, weight_n)): (Vector3<f64>, (f64, f64)),
    work: &mut Workspace<f64, SLOTS>,
) -> Vector3<f64> {
    let nearest = |state: &State<f64, SLOTS>, drive: &Drive<f64>| -> Option<(f64, Vector3<f64>)> {
        let mut found: Contacts<f64, SLOTS> = heapless::Vec::new();
        contact::find(scene, model, state, drive, &mut found);
        let of_pusher = found.iter().filter(|c| c.body == Body::Pusher);
        of_pusher.min_by(|a, b| a.gap_m.total_cmp(&b.gap_m)).map(|c| (c.gap_m, c.axes[0]))
    };
    let moved = |by: Vector3<f64>| {
        let mut moved = Drive { dt_s: LOADING_STEP_S, ..*drive };
        if let Some(p) = &mut moved.pusher {
            p.position_m += by;
        }
        moved
    };
    let Some((gap_m, normal)) = nearest(state, drive) else { return Vector3::zeros() };
    let tangential_n_m: f64 =
        work.contacts.iter().filter(|c| is_finger(c.body)).map(|c| c.tangential_n_m).sum();
    let start = state.clone();
    let (mut by_m, mut before): (f64, Option<(f64, f64)>) = (0.0, None);
    for _ in 0..CARRY_ROUNDS {
        let mut tried = start.clone();
        let drive = moved(normal * by_m);
        let mut now_n = f64::NAN;
        for _ in 0..LOADING_STEPS {
            let step = step_f64(scene, model, &mut tried, &drive, work);
            if step.status != SolveStatus::Solved {
                return Vector3::zeros();
            }
            now_n = borne_n(&step, &up);
        }
        let missing_n = now_n - carried_n;
        if missing_n.abs() < CARRIED * weight_n {
            forget_slip(&mut tried);
            let pressed_m = nearest(&tried, &drive).map_or(0.0, |(gap_m, _)| gap_m.min(0.0));
            *state = State { slots: tried.slots, jaw_m: tried.jaw_m, ..start };
            return normal * (gap_m - pressed_m);
        }
        // Along the secant; at first, and where it leads nowhere, as if all of the motion went into the pads.
        let slope = before.map(|(m, n)| (now_n - n) / (by_m - m)).filter(|s| *s < 0.0 && s.is_finite());
        before = Some((by_m, now_n));
        by_m -= missing_n / slope.unwrap_or(-tangential_n_m.max(f64::MIN_POSITIVE));
    }
    Vector3::zeros()
}

/// Loads the springs of the fingers such that they carry `carried_n` of `weight_n` along `up` (carrier axes); what lies under the object bears the
/// rest. As they were where the force does not follow them: friction bears no more, or nothing lies under the object.
fn carry(
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
        let now_n = borne_n(&step, &up);
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
        for c in work.contacts.iter().filter(|c| is_finger(c.body)) {
            let Some(slot) = state.slots.get_mut(c.slot) else { continue };
            for k in 0..2 {
                // Each finger half; a spring pushes against its length.
                slot.spring_m[k] -= 0.5 * change_n * up.dot(&c.axes[k + 1]) / c.tangential_n_m;
            }
        }
    }
}
