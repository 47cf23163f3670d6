//! What the pads hold of an object before anything moves.
//!
//! Springs start as they are where the object was measured at rest ([`sink`]). An object that also lies on something
//! may be carried by either: how much the fingers bear is left from closing the grasp. Where it is known the springs are
//! loaded to it ([`carry`]), or an edge that touches is pressed against it ([`press`]). Where it is not, what lies on a table or
//! a platform lies there with its weight, and pads carry what only touches an edge: it was grasped before.

use nalgebra::{Matrix2, Vector2, Vector3};
use stickslip_shared::cone::SolveStatus;
use stickslip_shared::contact::{self, Body, Contact, Contacts, SLOTS, is_finger};
use stickslip_shared::effects::Effect;
use stickslip_shared::model::{Base, Friction, Model, Scene};
use stickslip_shared::step::{Drive, State, StepSummary, Workspace, step_f64};

/// Steps of [`sink`] and their time: long against the swing of an object on its pads, which the implicit
/// step then damps.
const LOADING_STEPS: usize = 3;
const LOADING_STEP_S: f64 = 0.02;
/// Steps of [`press`] in which it swings onto an edge, and the time of each of its steps: long against that swing too (0.14 s where it
/// turns between pads of 3 N/mm).
const SWINGS: usize = 2;
const PRESSING_STEP_S: f64 = 0.2;
/// How often the object is put back.
const LOADING_ROUNDS: usize = 3;
const PRESSING_ROUNDS: usize = 3;
/// How often [`carry`] and [`press`] try at most.
const CARRY_ROUNDS: usize = 8;
/// How near [`carry`] comes (share of the weight), and the least share of a spring's change that stays in the force where springs are
/// loaded at all.
const CARRIED: f64 = 0.01;
const LEAST_STAYS: f64 = 0.05;
/// How near [`press`] comes, far below the steps of a fit's sensitivities; and what is left as it is where it comes neither so near
/// nor half as far as it was.
const PRESSED: f64 = 1e-4;
const NEAR_ENOUGH: f64 = 0.05;
/// The least change of what the fingers bear that is an answer to where the edge is, share of the weight.
const ANSWERS: f64 = 1e-6;
/// Farther away than that it is not held: pads of 3 N/mm give way by half of it where they hold 2 N with an arm of 30 mm; what falls goes 0.4 m in a step.
const MOST_SAG_M: f64 = 1e-2;
const MOST_SAG_RAD: f64 = 0.4;
/// Share of an edge's friction that it can be left with: beyond it slides, and no motion of the edge changes its force.
const HELD: f64 = 0.9;

/// Force of both fingers together on an object at rest, across the grip's axis, N: left from closing the grasp where it lies on
/// something.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Carried {
    /// Along [`super::simulate::Prepared::up`]: of its weight.
    pub up_n: f64,
    /// Along [`super::simulate::Prepared::side`]: what an edge holds by friction.
    pub side_n: f64,
}

/// How an object rests before anything moves.
pub(super) struct Rest {
    /// It lies on a table or a platform.
    pub lies: bool,
    /// `None` where that is not known.
    pub borne: Option<Borne>,
}

/// What the fingers bear of an object at rest.
#[derive(Clone, Copy)]
pub(super) struct Borne {
    /// Upward, and across it and the grip's axis (zero where these are one); carrier axes.
    pub up: Vector3<f64>,
    pub side: Vector3<f64>,
    /// Along both, and the object's weight, N.
    pub force: Carried,
    pub weight_n: f64,
}

impl Borne {
    /// What both fingers bear along both directions in a step, N.
    fn of(&self, step: &StepSummary<f64>) -> Vector2<f64> {
        let force = |k: usize| Vector3::from_row_slice(&step.reading.finger[k][..3]);
        let both = force(0) + force(1);
        Vector2::new(self.up.dot(&both), self.side.dot(&both))
    }
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
    if !rest.lies && gives_way {
        if let Some(by) = rest.borne.and_then(|borne| press(scene, model, state, drive, &borne, work)) {
            if let Some(p) = &mut drive.pusher {
                p.position_m += by;
            }
            return drive.carrier.transform_vector(&by);
        }
        // What only touches an edge was grasped before.
        sink(scene, model, state, &Drive { pusher: None, ..*drive }, work);
    }
    if rest.lies {
        if gives_way {
            sink(scene, model, state, drive, work);
        }
        if let Some(borne) = &rest.borne {
            carry(scene, model, state, drive, borne, work);
        }
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

/// Whether the pads do not hold it: it has gone from where it was measured farther than any let it.
fn has_strayed(start: &State<f64, SLOTS>, state: &State<f64, SLOTS>) -> bool {
    (state.position_m - start.position_m).norm() > MOST_SAG_M
        || state.rotation.angle_to(&start.rotation) > MOST_SAG_RAD
}

/// Nothing has slipped yet.
fn forget_slip(state: &mut State<f64, SLOTS>) {
    for slot in &mut state.slots {
        (slot.slip_m, slot.speed_m_s, slot.rest_s) = (0.0, 0.0, 0.0);
    }
}

/// Presses a pusher that touches the object at the start against it, and along it, until the fingers bear what is `borne`: what is
/// missing to balance is what it pushes with, as far as it does not slide. Springs and pusher are then as that leaves them where the
/// object was measured. By how much the pusher has moved, carrier axes; `None` where no edge is near, or nothing comes near to what is
/// borne.
fn press(
    scene: &Scene<f64>,
    model: &Model<f64>,
    state: &mut State<f64, SLOTS>,
    drive: &Drive<f64>,
    borne: &Borne,
    work: &mut Workspace<f64, SLOTS>,
) -> Option<Vector3<f64>> {
    let (mut by_m, mut drive, mut way_m): (Option<Vector3<f64>>, _, _) = (None, *drive, 0.0);
    // Contacts with the effects of the model are in `work` after a step.
    let _ = step_f64(scene, model, &mut state.clone(), &drive, work);
    // Again from where it is put back: its contacts lie elsewhere than where it swung to.
    for _ in 0..PRESSING_ROUNDS {
        let Some(pressed) = press_once(scene, model, state, &drive, borne, way_m, work) else { break };
        by_m = Some(by_m.unwrap_or_default() + pressed.by_m);
        way_m = pressed.way_m;
        if let Some(p) = &mut drive.pusher {
            p.position_m += pressed.by_m;
        }
        if pressed.tries == 1 {
            break;
        }
    }
    by_m
}

/// What [`press_once`] did.
struct Pressed {
    /// How far the edge has moved, carrier axes.
    by_m: Vector3<f64>,
    /// Its way along the object.
    way_m: f64,
    tries: usize,
}

/// As [`press`], from springs and pusher as they are and, at first, with this way along the object.
fn press_once(
    scene: &Scene<f64>,
    model: &Model<f64>,
    state: &mut State<f64, SLOTS>,
    drive: &Drive<f64>,
    borne: &Borne,
    way_m: f64,
    work: &mut Workspace<f64, SLOTS>,
) -> Option<Pressed> {
    let mut contacts: Contacts<f64, SLOTS> = heapless::Vec::new();
    contact::find(scene, model, state, drive, &mut contacts);
    let edge = nearest(&contacts)?;
    let (gap_m, normal) = (edge.gap_m, edge.axes[0]);
    let mut answers = -answers(&work.contacts, edge, borne)?;
    let across = borne.side - normal * normal.dot(&borne.side);
    // It swings to rest on an edge without friction; what friction holds comes from the edge's way along the object.
    let slippery = Model { friction: Friction { pusher: 0.0, ..model.friction }, ..model.clone() };
    let pressed = |by_m: &Vector2<f64>| {
        let mut still = Drive { dt_s: PRESSING_STEP_S, ..*drive };
        if let Some(p) = &mut still.pusher {
            p.position_m += normal * by_m.x;
        }
        let mut along = still;
        if let Some(p) = &mut along.pusher {
            p.velocity_m_s += across * (by_m.y / PRESSING_STEP_S);
        }
        (still, [(still, &slippery); SWINGS].into_iter().chain([(along, model)]))
    };
    let held_n = HELD * model.friction.pusher * (borne.weight_n - borne.force.up_n).max(0.0);
    let wanted = Vector2::new(borne.force.up_n, borne.force.side_n.clamp(-held_n, held_n));
    let start = state.clone();
    // From where it touches on.
    let mut by_m = Vector2::new(gap_m.max(0.0), way_m);
    let mut before: Option<(Vector2<f64>, Vector2<f64>)> = None;
    let mut best: Option<(f64, State<f64, SLOTS>, Drive<f64>, f64)> = None;
    let (mut tries, mut first_n): (usize, Option<f64>) = (0, None);
    'tries: while tries < CARRY_ROUNDS {
        tries += 1;
        let mut tried = start.clone();
        let (still, drives) = pressed(&by_m);
        let mut now = Vector2::repeat(f64::NAN);
        for (drive, model) in drives {
            let step = step_f64(scene, model, &mut tried, &drive, work);
            if step.status != SolveStatus::Solved || has_strayed(&start, &tried) {
                break 'tries;
            }
            now = borne.of(&step);
        }
        let missing = now - wanted;
        let off_n = missing.norm();
        let first_n = *first_n.get_or_insert(off_n);
        let near = off_n < NEAR_ENOUGH * borne.weight_n || off_n < 0.5 * first_n;
        if near && best.as_ref().is_none_or(|(least_n, ..)| off_n < *least_n) {
            best = Some((off_n, tried, still, by_m.y));
        }
        if off_n < PRESSED * borne.weight_n {
            break;
        }
        // Broyden's method.
        if let Some((by_then, then)) = before {
            let (step, change) = (by_m - by_then, now - then);
            // An edge that has left the object answers nothing.
            if change.norm() < ANSWERS * borne.weight_n {
                break;
            }
            let answered = answers * change;
            let along = step.dot(&answered);
            if along.abs() > f64::EPSILON * step.norm_squared() {
                answers += (step - answered) * (step.transpose() * answers) / along;
            }
        }
        before = Some((by_m, now));
        by_m -= answers * missing;
    }
    let (_, mut tried, drive, way_m) = best?;
    forget_slip(&mut tried);
    contact::find(scene, model, &tried, &drive, &mut contacts);
    let pressed_m = nearest(&contacts).map_or(0.0, |c| c.gap_m.min(0.0));
    *state = State { slots: tried.slots, jaw_m: tried.jaw_m, ..start };
    Some(Pressed { by_m: normal * (gap_m - pressed_m), way_m, tries })
}

/// The pusher's point nearest to the object.
fn nearest(contacts: &[Contact<f64>]) -> Option<&Contact<f64>> {
    let of_pusher = contacts.iter().filter(|c| c.body == Body::Pusher);
    of_pusher.min_by(|a, b| a.gap_m.total_cmp(&b.gap_m))
}

/// How an `edge` moves, upward and then along the object, for each force that the fingers bear less, upward and to the side, m/N: between
/// their springs the object is shifted and turned about the grip's axis, without friction first, and the edge gives way too.
/// `None` where these are no springs.
fn answers(contacts: &[Contact<f64>], edge: &Contact<f64>, borne: &Borne) -> Option<Matrix2<f64>> {
    let fingers = || contacts.iter().filter(|c| is_finger(c.body)).map(|c| (c, c.share * c.tangential_n_m));
    let shift_n_m: f64 = fingers().map(|(_, k)| k).sum();
    let centre_m = fingers().map(|(c, k)| c.lever_m * k).sum::<Vector3<f64>>() / shift_n_m;
    let grip = borne.side.cross(&borne.up);
    let turned = |lever_m: Vector3<f64>| grip.cross(&(lever_m - centre_m));
    let turn_nm_rad: f64 = fingers().map(|(c, k)| k * turned(c.lever_m).norm_squared()).sum();
    let arm = turned(edge.lever_m);
    let arms_m = Vector2::new(arm.dot(&borne.up), arm.dot(&borne.side));
    let of_edge = contacts.iter().find(|c| c.body == edge.body);
    let edge_m_n =
        of_edge.map_or(Vector2::zeros(), |c| Vector2::new(1.0 / c.normal_n_m, 1.0 / c.tangential_n_m));
    let gives = Matrix2::identity() / shift_n_m
        + arms_m * arms_m.transpose() / turn_nm_rad
        + Matrix2::from_diagonal(&edge_m_n);
    let up = gives[(0, 0)];
    let answers = Matrix2::new(up, gives[(0, 1)], 0.0, gives.determinant() / up);
    answers.iter().all(|a| a.is_finite()).then_some(answers)
}

/// Loads the springs of the fingers such that they carry what is `borne` upward; what lies under the object bears the
/// rest. As they were where the force does not follow them: friction bears no more, or nothing lies under the object.
fn carry(
    scene: &Scene<f64>,
    model: &Model<f64>,
    state: &mut State<f64, SLOTS>,
    drive: &Drive<f64>,
    borne: &Borne,
    work: &mut Workspace<f64, SLOTS>,
) {
    let mut before: Option<(State<f64, SLOTS>, f64, f64)> = None;
    let mut stays = 1.0;
    for _ in 0..CARRY_ROUNDS {
        let mut tried = state.clone();
        let step = step_f64(scene, model, &mut tried, drive, work);
        let now_n = borne.of(&step).x;
        let solved = step.status == SolveStatus::Solved;
        if let Some((then, then_n, changed_n)) = before.take() {
            stays = (now_n - then_n) / changed_n;
            if !(solved && stays > LEAST_STAYS) {
                *state = then;
                return;
            }
        }
        let missing_n = borne.force.up_n - now_n;
        if !solved || missing_n.abs() < CARRIED * borne.weight_n {
            return;
        }
        let change_n = missing_n / stays.min(1.0);
        before = Some((state.clone(), now_n, change_n));
        for c in work.contacts.iter().filter(|c| is_finger(c.body)) {
            let Some(slot) = state.slots.get_mut(c.slot) else { continue };
            for k in 0..2 {
                // Each finger half; a spring pushes against its length.
                slot.spring_m[k] -= 0.5 * change_n * borne.up.dot(&c.axes[k + 1]) / c.tangential_n_m;
            }
        }
    }
}
