//! The time step: state and drive in, next state and forces out.
//!
//! Semi-implicit: contact geometry at the beginning of the step, contact forces and
//! velocity at its end (`cone`, or `lcp` as the
//! model asks), then the pose moves with the new velocity. The velocity
//! that is solved for is that relative to the carrier (the gripper), in carrier axes, so
//! that a stuck object has velocity zero exactly, also in `f32`.

mod gather;
mod output;
mod owners;
mod params;
mod solver;

use crate::contact::{self, Body, Contact, Contacts, is_finger};
use crate::effects::{self, Environment, FrictionLaw, Loads, Reading, Slip, StepContext};
use crate::lcp::step::Past;
use crate::model::{Model, PusherContact, Scene, SupportContact};
use crate::probe::{self, Part};
use crate::real::{Real, Vec3, max, sqrt};
pub use crate::rotation::{support_under, turned};
use crate::shape::rotated_inertia;
use crate::solve::{Before, Bodies, ContactPoint, DOF, Follows, SolveBudget, SolveStatus};
pub use crate::state::{Drive, LastStep, Moving, Slot, State};
use gather::gather;
pub use output::{FormulaFault, StepOutput, StepSummary, Workspace};
use owners::keep_owners;
pub use params::{JAW_MASS_KG, StepParams};
pub use solver::SolvedBy;

/// The laws of a model's effects, each with its place and its parameters.
pub(crate) fn effect_hooks<'a, R: Real>(
    model: &'a Model<R>,
) -> impl Iterator<Item = (usize, &'a dyn effects::Law<R>, &'a [R; effects::MAX_PARAMETERS])> {
    let mut formulas = model.formulas.iter();
    model.effects.iter().enumerate().filter_map(move |(i, e)| {
        let law: Option<&'a dyn effects::Law<R>> = match e.code {
            effects::formula::CODE => formulas.next().map(|f| f as &dyn effects::Law<R>),
            code => effects::law::<R>(code).map(|law| law as &dyn effects::Law<R>),
        };
        law.map(|law| (i, law, &e.parameters))
    })
}

/// By how much the object's pose is late with the effects of `model`, s.
pub fn pose_late_s<R: Real>(model: &Model<R>) -> R {
    effect_hooks(model).fold(R::zero(), |late_s, (_, law, p)| late_s + law.pose_late_s(p))
}

/// Zero in place of a negative number. NaN stays: the solver refuses it as `BadInput`.
fn not_negative<R: Real>(x: R) -> R {
    if x < R::zero() { R::zero() } else { x }
}

/// Coefficient of the base model at a body.
fn base_mu<R: Real>(
    scene: &Scene<R>,
    model: &Model<R>,
    contact: &Contact<R>,
    down: &Vec3<R>,
    platform_cosine2: R,
) -> R {
    // A plane under the object is a platform, not the pusher's face: it has the support's
    // friction (the paper's silicone platform beside its rubber-faced pusher).
    let under = || {
        let along = contact.axes[0].dot(down);
        let level = along < R::zero() && along * along > platform_cosine2 * down.dot(down);
        level && matches!(scene.pusher, Some(PusherContact::Plane))
    };
    match contact.body {
        Body::Finger1 | Body::Finger2 => model.friction.finger,
        Body::Pusher if under() => model.friction.support,
        Body::Pusher => model.friction.pusher,
        Body::Support => model.friction.support,
    }
}

/// Whether it is a point pusher against an upright face: its first tangent is level, its second goes up or down.
fn is_upright_rod<R: Real>(scene: &Scene<R>, contact: &Contact<R>, down: &Vec3<R>, cosine2: R) -> bool {
    let along = contact.axes[2].dot(down);
    contact.body == Body::Pusher
        && matches!(scene.pusher, Some(PusherContact::Point { .. }))
        && along * along > cosine2 * down.dot(down)
}

/// What effects see of a contact point.
fn slip_of<R: Real>(c: &Contact<R>, slot: &Slot<R>, patch_load_n: &[R; 4]) -> Slip<R> {
    Slip {
        body: c.body,
        share: c.share,
        patch_m: c.patch_m,
        object_m: c.object_m,
        load_n: slot.load_n,
        patch_load_n: patch_load_n.get(c.body.index()).copied().unwrap_or(R::zero()),
        speed_m_s: slot.speed_m_s,
        distance_m: slot.slip_m,
        rest_s: slot.rest_s,
    }
}

/// The first of the model's formulas that has no value in the step that begins, and why.
#[cold]
fn formula_fault<R: Real, const NC: usize>(
    model: &Model<R>,
    context: &StepContext<R>,
    state: &State<R, NC>,
    contacts: &Contacts<R, NC>,
    patch_load_n: &[R; 4],
) -> Option<FormulaFault> {
    let own = model.effects.iter().zip(&state.memory).filter(|(e, _)| e.code == effects::formula::CODE);
    own.zip(&model.formulas).enumerate().find_map(|(number, ((effect, memory), formula))| {
        let slips = contacts.iter().filter_map(|c| Some(slip_of(c, state.slots.get(c.slot)?, patch_load_n)));
        let fault = formula.fault(&effect.parameters, context, memory, slips)?;
        Some(FormulaFault { number: number as u8, fault })
    })
}

fn context<R: Real, const NC: usize>(
    scene: &Scene<R>,
    state: &State<R, NC>,
    drive: &Drive<R>,
) -> StepContext<R> {
    let mut slip_m = [R::zero(); 4];
    let mut speed = slip_m;
    let mut load_n = slip_m;
    let mut stretch_m = [[R::zero(); 2]; 4];
    for body in [Body::Finger1, Body::Finger2, Body::Pusher, Body::Support] {
        let (k, range) = (body.index(), body.slots());
        let mut count = R::zero();
        for slot in state.slots.iter().take(range.end).skip(range.start) {
            if slot.load_n > R::zero() {
                slip_m[k] += slot.slip_m;
                speed[k] += slot.speed_m_s;
                load_n[k] += slot.load_n;
                stretch_m[k][0] += slot.spring_m[0];
                stretch_m[k][1] += slot.spring_m[1];
                count += R::one();
            }
        }
        if count > R::zero() {
            slip_m[k] /= count;
            speed[k] /= count;
            stretch_m[k] = stretch_m[k].map(|sum| sum / count);
        }
    }
    let [_, _, _, wx, wy, wz, _] = state.velocity;
    let environment = [&drive.pusher, &drive.support].map(|moving| match moving {
        Some(m) => Environment {
            normal: m.rotation.transform_vector(&Vec3::x()),
            along_y: m.rotation.transform_vector(&Vec3::y()),
            turning_rad_s: Vec3::new(wx, wy, wz) - m.angular_rad_s,
            angular_rad_s: m.angular_rad_s,
        },
        None => Environment {
            normal: Vec3::zeros(),
            along_y: Vec3::zeros(),
            turning_rad_s: Vec3::zeros(),
            angular_rad_s: Vec3::zeros(),
        },
    });
    let mut grip_rate_n_s = R::zero();
    let mut load_rate_n_s = [R::zero(); 4];
    if let Some(last) = &state.last {
        grip_rate_n_s = (drive.grip_n - last.grip_n) / drive.dt_s;
        if let Some(before_n) = last.load_n {
            for ((rate, now_n), before_n) in load_rate_n_s.iter_mut().zip(load_n).zip(before_n) {
                *rate = (now_n - before_n) / last.dt_s;
            }
        }
    }
    StepContext {
        time_s: state.time_s,
        dt_s: drive.dt_s,
        trial: drive.trial,
        grip_cmd_n: drive.grip_n,
        grip_rate_n_s,
        position_m: state.position_m,
        rotation: state.rotation,
        carrier: drive.carrier,
        slip_m,
        slip_speed_m_s: speed,
        load_n,
        load_rate_n_s,
        environment,
        stretch_m: [stretch_m[0], stretch_m[1]],
        fingers: scene.fingers,
        pusher: scene.pusher,
        whole_face: matches!(scene.support, Some(SupportContact::Patch)),
        velocity_m_s: state.absolute_m_s,
        angular_rad_s: state.absolute_rad_s,
    }
}

/// Advances `state` by one step and returns every contact point as well: see [`step_in`].
pub fn step<R: Real, const NC: usize>(
    scene: &Scene<R>,
    model: &Model<R>,
    state: &mut State<R, NC>,
    drive: &Drive<R>,
) -> StepOutput<R, NC> {
    let mut work = Workspace::new();
    let summary = step_in(scene, model, state, drive, &SolveBudget::default(), &mut work);
    StepOutput::of(summary, &work)
}

/// Advances `state` by one step. On `SolveStatus::BadInput` and `SolveStatus::Contradiction`, and where
/// the answer is far from solved ([`StepParams::unsolved_n`], [`SolveBudget::follows`]), its
/// motion and springs are left as they were ([`StepSummary::followed`]); otherwise it has moved and
/// `residual_n` says how exactly.
///
/// Never panics; bounded by `options` and the capacity `NC`.
// Said here, one instance is shared by all crates; otherwise the firmware has one of its own beside that of
// `Predictor::settle`, 24 KiB.
#[inline(never)]
pub fn step_in<R: Real, const NC: usize>(
    scene: &Scene<R>,
    model: &Model<R>,
    state: &mut State<R, NC>,
    drive: &Drive<R>,
    options: &SolveBudget<R>,
    work: &mut Workspace<R, NC>,
) -> StepSummary<R> {
    let guess = state.velocity;
    step_from(scene, model, state, drive, options, &guess, work)
}

/// [`step_in`] whose iteration begins at the velocity `guess` and not at that of the last step.
#[inline(always)]
pub fn step_from<R: Real, const NC: usize>(
    scene: &Scene<R>,
    model: &Model<R>,
    state: &mut State<R, NC>,
    drive: &Drive<R>,
    options: &SolveBudget<R>,
    guess: &[R; DOF],
    work: &mut Workspace<R, NC>,
) -> StepSummary<R> {
    let _span = probe::span(Part::Step);
    let zero = R::zero();
    let dt = drive.dt_s;
    let context = context(scene, state, drive);
    let mut loads = Loads {
        gravity_m_s2: Vec3::from(scene.gravity_m_s2),
        mass_kg: scene.object.mass_kg,
        force_n: Vec3::zeros(),
        torque_nm: Vec3::zeros(),
    };
    let mut grip_n = drive.grip_n;
    let mut memory = state.memory;
    for (i, law, p) in effect_hooks(model) {
        if let Some(memory) = memory.get_mut(i) {
            law.loads(p, &context, memory, &mut loads);
            law.grip(p, &context, memory, &mut grip_n);
        }
    }
    // A jaw cannot pull.
    grip_n = not_negative(grip_n);

    let gravity = drive.carrier.inverse_transform_vector(&loads.gravity_m_s2);
    let part = probe::span(Part::Contacts);
    let mut points_lost =
        contact::find_with(&work.params.contact, scene, model, state, drive, &mut work.contacts);
    keep_owners(scene, state, &work.contacts);
    let mut patch_load = [zero; 4];
    if !model.effects.is_empty() {
        for c in &mut work.contacts {
            for (i, law, p) in effect_hooks(model) {
                if let Some(memory) = memory.get(i) {
                    law.contact(p, &context, memory, c);
                }
            }
        }
        let [_, _, pusher_n, _] = context.load_n;
        // Before it touches: a quarter of what slides between the fingers.
        let slides_n = R::of(0.5) * model.friction.finger * grip_n;
        points_lost += contact::spread(&mut work.contacts, max(pusher_n, slides_n));
        for c in &work.contacts {
            if let (Some(sum), Some(slot)) = (patch_load.get_mut(c.body.index()), state.slots.get(c.slot)) {
                *sum += slot.load_n;
            }
        }
    }
    drop(part);
    let inertia = rotated_inertia(&scene.object, &state.rotation);
    let ratio = loads.mass_kg / scene.object.mass_kg;
    let inertia = inertia.map(|r| r.map(|x| x * ratio));
    let (turn, v) = (drive.carrier_rad_s, state.absolute_m_s);
    let w = coasted(&inertia, &state.absolute_rad_s, dt);
    let carried = drive.carrier_m_s + turn.cross(&state.position_m);
    // Velocity without contact; components turn with the carrier's axes.
    let v_free = v - turn.cross(&v) * dt + (gravity + loads.force_n / loads.mass_kg) * dt - carried;
    let w_free = w - turn.cross(&w) * dt + inverse_times(&inertia, &loads.torque_nm) * dt - turn;
    let jaw_mass = work.params.jaw_mass_kg;
    let jaw_free = state.velocity[6] - R::of(2.0) * grip_n * dt / jaw_mass;
    let bodies = Bodies {
        mass_kg: loads.mass_kg,
        inertia_kg_m2: inertia,
        jaw_mass_kg: jaw_mass,
        dt_s: dt,
        free: [v_free.x, v_free.y, v_free.z, w_free.x, w_free.y, w_free.z, jaw_free],
    };
    work.solver.begin(options.only.unwrap_or(model.formulation), &bodies);
    let mut kept = 0;
    // Slots of the points that are handed to the solver.
    let mut near: u64 = 0;
    for i in 0..work.contacts.len() {
        let Some(c) = work.contacts.get_mut(i) else { continue };
        // The slot is below the capacity: `contact` sees to it.
        let Some(slot) = state.slots.get(c.slot) else { continue };
        let jaw = if is_finger(c.body) { R::one() } else { zero };
        let along = |k: usize| -c.axes[k].dot(&c.surface_m_s);
        // As far as it comes within the step where nothing stops it.
        let comes_m = || {
            let free_m_s = v_free + w_free.cross(&c.lever_m);
            -(c.axes[0].dot(&free_m_s) + along(0) + jaw * jaw_free) * dt
        };
        let far = c.gap_m > work.params.near_m && c.gap_m > work.params.near_m + comes_m();
        if far || !(c.share > zero) {
            continue;
        }
        near |= 1u64.checked_shl(c.slot as u32).unwrap_or(0);
        let slip = slip_of(c, slot, &patch_load);
        let mu = base_mu(scene, model, c, &gravity, work.params.platform_cosine2);
        let mut law = FrictionLaw { mu: [mu; 2], adhesion_n: zero, viscosity_s_m: zero };
        for (i, effect, p) in effect_hooks(model) {
            if let Some(memory) = memory.get(i) {
                effect.friction(p, &context, memory, &slip, &mut law);
            }
        }
        law.mu = law.mu.map(not_negative);
        if c.gap_m > work.params.adhesion_range_m {
            law.adhesion_n = zero;
        }
        let load_n = slot.load_n;
        let before = if !(load_n > zero) {
            Before::Open
        } else if slot.speed_m_s > zero {
            Before::Slid { load_n }
        } else {
            Before::Stuck { load_n }
        };
        let spring_m = c.stretch_m(slot.spring_m);
        let larger = max(law.mu[0], law.mu[1]);
        let bound_n = larger * (load_n + law.adhesion_n);
        if c.microslip > zero && load_n > zero && bound_n > zero {
            let (k, [s1, s2]) = (c.tangential_n_m * c.share, slot.spring_m);
            // All of it slides where the spring holds what friction bears.
            if k * k * (s1 * s1 + s2 * s2) < work.params.sliding_share2 * bound_n * bound_n {
                // Implicit in the spring, with the distance of the last step; `gather` has that of this one.
                let [x, y, z, wx, wy, wz, _] = state.velocity;
                let u = Vec3::new(x, y, z) + Vec3::new(wx, wy, wz).cross(&c.lever_m) - c.surface_m_s;
                let (u1, u2) = (c.axes[1].dot(&u), c.axes[2].dot(&u));
                let gives_n_m = c.microslip * k;
                c.reach_m = if gives_n_m > zero { bound_n / gives_n_m } else { zero };
                c.kept = bound_n / (bound_n + gives_n_m * sqrt(u1 * u1 + u2 * u2) * dt);
            }
        }
        // Spring k and damper d over a step: force = -(k dt + d) (u + k s / (k dt + d)).
        let (kn, kt) = (c.normal_n_m * c.share, c.tangential_n_m * c.share * c.kept);
        let (sn, st) = (kn * (dt + c.damping_s), kt * (dt + c.damping_s));
        let ratio = R::one() / (dt + c.damping_s);
        // Stiffness in proportion to mu² makes the slip direction that of maximum
        // dissipation on an elliptic cone.
        let shape = |m: R| {
            if larger > zero {
                max((m / larger) * (m / larger), work.params.min_stiffness_ratio)
            } else {
                R::one()
            }
        };
        let across = [shape(law.mu[0]), shape(law.mu[1])];
        let point = ContactPoint {
            lever_m: c.lever_m,
            axes: c.axes,
            jaw,
            bias_m_s: [
                along(0) + c.gap_m * ratio,
                along(1) + spring_m[0] * ratio,
                along(2) + spring_m[1] * ratio,
            ],
            stiffness_n_s_m: [sn, st * across[0], st * across[1]],
            mu: law.mu,
            adhesion_n: law.adhesion_n,
            viscous_n_s_m: law.viscosity_s_m * max(slot.load_n, zero),
        };
        work.solver.add(&point, Past { before, spring_m });
        if let Ok([to, from]) = work.contacts.get_disjoint_mut([kept, i]) {
            core::mem::swap(to, from);
        }
        kept += 1;
    }
    work.contacts.truncate(kept);

    let part = probe::span(Part::Cone);
    let hooks = (work.contacts.len() * model.effects.len()) as u16;
    let options = options.beside(u32::from(hooks) / 2);
    let (solution, solved_by) = work.solver.solve(&bodies, guess, &options, &work.params.pyramid);
    drop(part);
    let mut output = StepSummary {
        status: solution.status,
        solved_by,
        followed: false,
        formula_fault: None,
        residual_n: solution.residual_n,
        iterations: solution.iterations,
        evaluations: solution.evaluations,
        points: work.contacts.len() as u16,
        hooks,
        reading: Reading {
            position_m: state.position_m,
            rotation: state.rotation,
            finger: [[zero; 6]; 2],
            pusher: [zero; 6],
        },
        utilisation: [zero; 2],
        slip_m_s: [Vec3::zeros(); 2],
        spin_rad_s: [zero; 2],
        normal_n: [zero; 4],
        points_lost,
    };
    if solution.status == SolveStatus::BadInput {
        output.formula_fault = formula_fault(model, &context, state, &work.contacts, &patch_load);
        return output;
    }
    for (answer, c) in work.solver.answers().zip(&work.contacts) {
        if let Some(sum) = output.normal_n.get_mut(c.body.index()) {
            *sum += answer.force_n[0];
        }
    }
    if output.normal_n.iter().any(|n| *n > work.params.max_force_n) {
        output.status = SolveStatus::Contradiction;
        work.solver.forget();
        return output;
    }
    let most_n = output.normal_n.iter().fold(zero, |most, n| max(*n, most));
    let credible_n = work.params.unsolved_n + work.params.unsolved_share * most_n;
    let solved = solution.status == SolveStatus::Solved;
    let follows = match options.follows {
        Follows::Any => true,
        Follows::Credible => solved || solution.residual_n <= credible_n,
        Follows::Solved => solved,
    };
    if !follows {
        work.solver.forget();
        return output;
    }
    output.followed = true;
    let u = solution.velocity;
    state.memory = memory;
    let load_n = state.last.map(|_| context.load_n);
    state.last = Some(LastStep { dt_s: dt, grip_n: drive.grip_n, load_n });
    for (k, slot) in state.slots.iter_mut().enumerate() {
        // What has left the face, or is far from it, bears and holds nothing.
        if near & 1u64.checked_shl(k as u32).unwrap_or(0) == 0 {
            slot.load_n = zero;
            slot.spring_m = [zero; 2];
            slot.speed_m_s = zero;
        }
    }
    gather(state, drive, work, &mut output);
    if drive.support.is_some() {
        for c in
            work.contacts.iter().filter(|c| is_upright_rod(scene, c, &gravity, work.params.platform_cosine2))
        {
            // See the table of `contact`.
            if let Some(slot) = state.slots.get_mut(c.slot) {
                slot.spring_m[1] = zero;
            }
        }
    }
    let v_rel = Vec3::new(u[0], u[1], u[2]);
    let w_rel = Vec3::new(u[3], u[4], u[5]);
    state.velocity = u;
    state.absolute_m_s = v_rel + carried;
    state.absolute_rad_s = w_rel + turn;
    state.position_m += v_rel * dt;
    state.jaw_m += u[6] * dt;
    state.rotation = turned(&state.rotation, &(w_rel * dt));
    state.time_s += dt;
    output.reading.position_m = state.position_m;
    output.reading.rotation = state.rotation;
    let end = StepContext {
        velocity_m_s: state.absolute_m_s,
        angular_rad_s: state.absolute_rad_s,
        position_m: state.position_m,
        rotation: state.rotation,
        ..context
    };
    for (_, law, p) in effect_hooks(model) {
        law.sense(p, &end, &mut output.reading);
    }
    output
}

/// [`step_in`] in `f64` for any scene, compiled in this crate: a host built for tests optimises
/// this crate alone. Nothing of the step before is used but `work`'s memory. Not on a board, which computes in `f32`.
#[cfg(not(target_os = "none"))]
pub fn step_f64(
    scene: &Scene<f64>,
    model: &Model<f64>,
    state: &mut State<f64, { contact::SLOTS }>,
    drive: &Drive<f64>,
    work: &mut Workspace<f64, { contact::SLOTS }>,
) -> StepSummary<f64> {
    *work.kept() = crate::cone::Kept::nothing();
    step_in(scene, model, state, drive, &SolveBudget::default(), work)
}

/// Angular velocity `w` after a step without torques: one Newton step on
/// `I (w' - w) + dt w' x I w' = 0`, the gyroscopic torque at the end of the step, which gains no
/// energy at any spin (Catto 2015). Exactly `w` where it turns about a principal axis of the inertia.
fn coasted<R: Real>(i: &[[R; 3]; 3], w: &Vec3<R>, dt: R) -> Vec3<R> {
    let rows = i.map(Vec3::from);
    let momentum = Vec3::new(rows[0].dot(w), rows[1].dot(w), rows[2].dot(w));
    let torque = w.cross(&momentum);
    if torque == Vec3::zeros() {
        return *w;
    }
    // I + dt ([w] I - [I w]), [a] b = a x b.
    let mut jacobian = *i;
    for k in 0..3 {
        let column = Vec3::new(i[0][k], i[1][k], i[2][k]);
        let unit = Vec3::ith(k, R::one());
        let change = (w.cross(&column) - momentum.cross(&unit)) * dt;
        for (row, change) in jacobian.iter_mut().zip(change.iter()) {
            row[k] += *change;
        }
    }
    w - inverse_times(&jacobian, &(torque * dt))
}

/// `A^-1 t` for a regular 3 x 3 matrix, by cofactors; zero for a singular one.
fn inverse_times<R: Real>(i: &[[R; 3]; 3], t: &Vec3<R>) -> Vec3<R> {
    let rows = i.map(Vec3::from);
    let c = [rows[1].cross(&rows[2]), rows[2].cross(&rows[0]), rows[0].cross(&rows[1])];
    let determinant = rows[0].dot(&c[0]);
    if !(determinant.abs() > R::zero()) {
        return Vec3::zeros();
    }
    (c[0] * t.x + c[1] * t.y + c[2] * t.z) / determinant
}
