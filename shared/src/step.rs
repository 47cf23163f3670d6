//! The time step: state and drive in, next state and forces out.
//!
//! Semi-implicit: contact geometry at the beginning of the step, contact forces and
//! velocity at its end (`cone`), then the pose moves with the new velocity. The velocity
//! that is solved for is that relative to the carrier (the gripper), in carrier axes, so
//! that a stuck object has velocity zero exactly, also in `f32`.

use crate::cone::{self, Answer, Before, Bodies, ContactPoint, DOF, Kept, SolveBudget, SolveStatus};
use crate::contact::{self, Body, Contact, Contacts};
use crate::effects::formula::Fault;
use crate::effects::{self, Environment, FrictionLaw, Loads, MEMORY, Reading, Slip, StepContext};
use crate::model::{MAX_EFFECTS, Model, PusherContact, Scene, SupportContact};
use crate::probe::{self, Part};
use crate::real::{Real, Rotation, Vec3, max, sqrt};
use crate::shape::rotated_inertia;
use heapless::Vec;
use nalgebra::{Quaternion, UnitQuaternion};

/// Inertia of the jaw's opening motion, kg. It only matters while the jaw accelerates.
pub const JAW_MASS_KG: f64 = 0.3;
/// Points farther apart than this are not handed to the solver, m.
const NEAR_M: f64 = 1.0e-3;
/// A body that presses harder than this (2 kN, ten times the range of the fingertip sensors)
/// contradicts another one: the springs that stand for rigid contact would be 0.2 mm deep.
const MOST_FORCE_N: f64 = 2.0e3;
/// Adhesion ends at this separation, m.
const ADHESION_RANGE_M: f64 = 2.0e-5;

/// A body that moves as prescribed, seen from the carrier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moving<R: Real> {
    /// Origin, carrier frame.
    pub position_m: Vec3<R>,
    /// Body axes to carrier axes.
    pub rotation: Rotation<R>,
    /// Velocity of the origin relative to the carrier, carrier axes.
    pub velocity_m_s: Vec3<R>,
    /// Angular velocity relative to the carrier, carrier axes.
    pub angular_rad_s: Vec3<R>,
    /// Point about which its wrench is reported (its origin at the first sample), carrier frame.
    pub reference_m: Vec3<R>,
}

impl<R: Real> Moving<R> {
    /// Velocity of the body's point at `from_origin_m`, relative to the carrier.
    pub fn velocity_at(&self, from_origin_m: &Vec3<R>) -> Vec3<R> {
        self.velocity_m_s + self.angular_rad_s.cross(from_origin_m)
    }
}

/// What is imposed during one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive<R: Real> {
    /// Step.
    pub dt_s: R,
    /// Carrier axes to world axes at the beginning of the step.
    pub carrier: Rotation<R>,
    /// Absolute velocity of the carrier's origin, carrier axes.
    pub carrier_m_s: Vec3<R>,
    /// Absolute angular velocity of the carrier, carrier axes.
    pub carrier_rad_s: Vec3<R>,
    /// Pusher or environment.
    pub pusher: Option<Moving<R>>,
    /// Table: its frame's +X is the table's normal.
    pub support: Option<Moving<R>>,
    /// Grip force commanded, each finger.
    pub grip_n: R,
    /// Place of the trial in its data set.
    pub trial: R,
}

/// Memory of one contact point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slot<R: Real> {
    /// Tangential spring, m.
    pub spring_m: [R; 2],
    /// Distance slipped.
    pub slip_m: R,
    /// Slip speed in the last step; zero while sticking.
    pub speed_m_s: R,
    /// Time since it last slipped.
    pub rest_s: R,
    /// Normal force in the last step.
    pub load_n: R,
}

/// What rates are taken from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LastStep<R: Real> {
    /// Its duration.
    pub dt_s: R,
    /// Grip force commanded.
    pub grip_n: R,
    /// Normal force of each body at its beginning; `None` in the first, before which nothing was solved.
    pub load_n: Option<[R; 4]>,
}

/// Everything that changes from step to step.
#[derive(Clone, Debug, PartialEq)]
pub struct State<R: Real, const NC: usize> {
    /// Since the start.
    pub time_s: R,
    /// Centre of mass, carrier frame.
    pub position_m: Vec3<R>,
    /// Object axes to carrier axes.
    pub rotation: Rotation<R>,
    /// Velocity relative to the carrier: linear, angular, jaw opening.
    pub velocity: [R; DOF],
    /// Absolute velocity of the centre of mass, carrier axes.
    pub absolute_m_s: Vec3<R>,
    /// Absolute angular velocity, carrier axes.
    pub absolute_rad_s: Vec3<R>,
    /// Half the jaw opening at the start.
    pub jaw_half_m: R,
    /// Change of half the jaw opening since.
    pub jaw_m: R,
    /// One for each contact point.
    pub slots: [Slot<R>; NC],
    /// Memory of the model's effects.
    pub memory: [[R; MEMORY]; MAX_EFFECTS],
    /// The last step; `None` before the first.
    pub last: Option<LastStep<R>>,
}

/// A formula without a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FormulaFault {
    /// Which of the model's formulas, from 0.
    pub number: u8,
    /// Why it has none.
    pub fault: Fault,
}

/// What a step produces besides the next state.
#[derive(Clone, Copy, Debug)]
pub struct StepSummary<R: Real> {
    /// How far the rest can be trusted.
    pub status: SolveStatus,
    /// The formula behind a [`SolveStatus::BadInput`], if it is one.
    pub formula_fault: Option<FormulaFault>,
    /// Error of the momentum balance.
    pub residual_n: R,
    /// Newton steps.
    pub iterations: u32,
    /// Evaluations of the momentum balance.
    pub evaluations: u32,
    /// Contact points handed to the solver.
    pub points: u16,
    /// Contact points times effects: how often an effect was asked for its friction.
    pub hooks: u16,
    /// What the sensors would show at the end of the step.
    pub reading: Reading<R>,
    /// Share of the friction limit used by each finger, force and torsion together (1: slipping).
    pub utilisation: [R; 2],
    /// Mean slip velocity of the object over each finger, carrier axes, m/s.
    pub slip_m_s: [Vec3<R>; 2],
    /// Slip about the patch normal of each finger, rad/s.
    pub spin_rad_s: [R; 2],
    /// Normal force of each body: finger 1, finger 2, pusher, support.
    pub normal_n: [R; 4],
    /// Contact points that did not fit the capacity and were left out.
    pub points_lost: usize,
}

/// Working memory of a step; keeps its contact points, one entry each in the lists.
#[derive(Clone, Debug)]
pub struct Workspace<R: Real, const NC: usize> {
    /// Contact points handed to the solver.
    pub contacts: Contacts<R, NC>,
    cone: cone::Workspace<R, NC>,
}

impl<R: Real, const NC: usize> Workspace<R, NC> {
    /// Factors of the last solve, with which the next begins.
    pub fn kept(&mut self) -> &mut Kept<R> {
        &mut self.cone.kept
    }

    /// Empty.
    // Built in place: it is larger than all else in a tick.
    #[inline(always)]
    pub fn new() -> Self {
        Self { contacts: Vec::new(), cone: cone::Workspace::new() }
    }

    /// What each contact point answered; none after a step that has not moved.
    #[inline(always)]
    pub fn answers(&self) -> impl Iterator<Item = Answer<R>> {
        self.cone.answers()
    }
}

impl<R: Real, const NC: usize> Default for Workspace<R, NC> {
    fn default() -> Self {
        Self::new()
    }
}

/// What a step produces besides the next state, with every contact point; the summary's
/// fields are read as its own.
#[derive(Clone, Debug)]
pub struct StepOutput<R: Real, const NC: usize> {
    /// All but the contact points.
    pub summary: StepSummary<R>,
    /// Contact points handed to the solver.
    pub contacts: Contacts<R, NC>,
    /// Friction law of each.
    pub friction: Vec<FrictionLaw<R>, NC>,
    /// Force on the object at each, along its axes.
    pub force_n: Vec<[R; 3], NC>,
}

impl<R: Real, const NC: usize> core::ops::Deref for StepOutput<R, NC> {
    type Target = StepSummary<R>;
    fn deref(&self) -> &StepSummary<R> {
        &self.summary
    }
}

impl<R: Real, const NC: usize> State<R, NC> {
    /// An object at rest relative to a carrier that moves as `drive` says, already gripped:
    /// the finger and support springs carry grip and weight.
    pub fn held(
        scene: &Scene<R>,
        model: &Model<R>,
        drive: &Drive<R>,
        position_m: Vec3<R>,
        rotation: Rotation<R>,
    ) -> Self {
        let zero = R::zero();
        let half = scene.object.shape.reach(&rotation.inverse_transform_vector(&Vec3::y()));
        let mut state = Self {
            time_s: zero,
            position_m,
            rotation,
            velocity: [zero; DOF],
            absolute_m_s: drive.carrier_m_s + drive.carrier_rad_s.cross(&position_m),
            absolute_rad_s: drive.carrier_rad_s,
            jaw_half_m: half,
            jaw_m: zero,
            slots: [Slot::default(); NC],
            memory: [[zero; MEMORY]; MAX_EFFECTS],
            last: None,
        };
        let stiffness = match model.base {
            crate::model::Base::Hard => R::of(contact::RIGID_N_M),
            crate::model::Base::Soft { normal_n_m, .. } => normal_n_m,
        };
        state.jaw_m = -drive.grip_n / stiffness;
        state
    }
}

fn effect_hooks<'a, R: Real>(
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

/// Zero in place of a negative number. NaN stays: the solver refuses it as `BadInput`.
fn not_negative<R: Real>(x: R) -> R {
    if x < R::zero() { R::zero() } else { x }
}

/// Coefficient of the base model at a body.
fn base_mu<R: Real>(scene: &Scene<R>, model: &Model<R>, contact: &Contact<R>, down: &Vec3<R>) -> R {
    // A plane under the object is a platform, not the pusher's face: it has the support's
    // friction (the paper's silicone platform beside its rubber-faced pusher).
    let under = || {
        let along = contact.axes[0].dot(down);
        let level = along < R::zero() && along * along > R::of(0.49) * down.dot(down);
        level && matches!(scene.pusher, Some(PusherContact::Plane))
    };
    match contact.body {
        Body::Finger1 | Body::Finger2 => model.friction.finger,
        Body::Pusher if under() => model.friction.support,
        Body::Pusher => model.friction.pusher,
        Body::Support => model.friction.support,
    }
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
    let ranges = [
        (0, contact::FINGER_POINTS),
        (contact::FINGER_POINTS, 2 * contact::FINGER_POINTS),
        (2 * contact::FINGER_POINTS, contact::SUPPORT_SLOT),
        (contact::SUPPORT_SLOT, contact::SLOTS),
    ];
    for (k, (from, to)) in ranges.into_iter().enumerate() {
        let mut count = R::zero();
        for slot in state.slots.iter().take(to).skip(from) {
            if slot.load_n > R::zero() {
                slip_m[k] += slot.slip_m;
                speed[k] += slot.speed_m_s;
                load_n[k] += slot.load_n;
                count += R::one();
            }
        }
        if count > R::zero() {
            slip_m[k] /= count;
            speed[k] /= count;
        }
    }
    let [_, _, _, wx, wy, wz, _] = state.velocity;
    let environment = [&drive.pusher, &drive.support].map(|moving| match moving {
        Some(m) => Environment {
            normal: m.rotation.transform_vector(&Vec3::x()),
            turning_rad_s: Vec3::new(wx, wy, wz) - m.angular_rad_s,
        },
        None => Environment { normal: Vec3::zeros(), turning_rad_s: Vec3::zeros() },
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
        pusher: scene.pusher,
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
    StepOutput {
        summary,
        friction: work.answers().map(|a| FrictionLaw { mu: a.mu, adhesion_n: a.adhesion_n }).collect(),
        force_n: work.answers().map(|a| a.force_n).collect(),
        contacts: work.contacts,
    }
}

/// Advances `state` by one step. On `SolveStatus::BadInput` and `SolveStatus::Contradiction` its
/// motion and springs are left as they were;
/// with any other status it has moved and `residual_n` says how exactly.
///
/// Never panics; bounded by `options` and the capacity `NC`.
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
    let mut points_lost = contact::find(scene, model, state, drive, &mut work.contacts);
    let mut patch_load = [zero; 4];
    if !model.effects.is_empty() {
        for c in &mut work.contacts {
            for (_, law, p) in effect_hooks(model) {
                law.contact(p, &context, c);
            }
        }
        points_lost += contact::spread(&mut work.contacts);
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
    let (turn, v, w) = (drive.carrier_rad_s, state.absolute_m_s, state.absolute_rad_s);
    let carried = drive.carrier_m_s + turn.cross(&state.position_m);
    // Velocity without contact; components turn with the carrier's axes.
    let v_free = v - turn.cross(&v) * dt + (gravity + loads.force_n / loads.mass_kg) * dt - carried;
    let w_free = w - turn.cross(&w) * dt + inverse_times(&inertia, &loads.torque_nm) * dt - turn;
    let jaw_mass = R::of(JAW_MASS_KG);
    let jaw_free = state.velocity[6] - R::of(2.0) * grip_n * dt / jaw_mass;
    let bodies = Bodies {
        mass_kg: loads.mass_kg,
        inertia_kg_m2: inertia,
        jaw_mass_kg: jaw_mass,
        dt_s: dt,
        free: [v_free.x, v_free.y, v_free.z, w_free.x, w_free.y, w_free.z, jaw_free],
    };
    work.cone.begin(&bodies);
    let mut kept = 0;
    for i in 0..work.contacts.len() {
        let Some(c) = work.contacts.get(i) else { continue };
        // The slot is below the capacity: `contact` sees to it.
        let Some(slot) = state.slots.get_mut(c.slot) else { continue };
        if c.gap_m > R::of(NEAR_M) || !(c.share > zero) {
            slot.load_n = zero;
            slot.spring_m = [zero; 2];
            continue;
        }
        let slip = slip_of(c, slot, &patch_load);
        let mu = base_mu(scene, model, c, &gravity);
        let mut law = FrictionLaw { mu: [mu; 2], adhesion_n: zero };
        for (i, effect, p) in effect_hooks(model) {
            if let Some(memory) = memory.get(i) {
                effect.friction(p, &context, memory, &slip, &mut law);
            }
        }
        law.mu = law.mu.map(not_negative);
        if c.gap_m > R::of(ADHESION_RANGE_M) {
            law.adhesion_n = zero;
        }
        // Spring k and damper d over a step: force = -(k dt + d) (u + k s / (k dt + d)).
        let (kn, kt) = (c.normal_n_m * c.share, c.tangential_n_m * c.share);
        let (sn, st) = (kn * (dt + c.damping_s), kt * (dt + c.damping_s));
        let ratio = R::one() / (dt + c.damping_s);
        let larger = max(law.mu[0], law.mu[1]);
        // Stiffness in proportion to mu² makes the slip direction that of maximum
        // dissipation on an elliptic cone.
        let shape =
            |m: R| if larger > zero { max((m / larger) * (m / larger), R::of(1e-4)) } else { R::one() };
        let across = [shape(law.mu[0]), shape(law.mu[1])];
        let along = |k: usize| -c.axes[k].dot(&c.surface_m_s);
        let point = ContactPoint {
            lever_m: c.lever_m,
            axes: c.axes,
            jaw: if matches!(c.body, Body::Finger1 | Body::Finger2) { R::one() } else { zero },
            bias_m_s: [
                along(0) + c.gap_m * ratio,
                along(1) + slot.spring_m[0] * ratio,
                along(2) + slot.spring_m[1] * ratio,
            ],
            stiffness_n_s_m: [sn, st * across[0], st * across[1]],
            mu: law.mu,
            adhesion_n: law.adhesion_n,
        };
        // The capacities are that of the contacts: these cannot fail.
        work.cone.add(&point);
        let load_n = slot.load_n;
        work.cone.expect(if !(load_n > zero) {
            Before::Open
        } else if slot.speed_m_s > zero {
            Before::Slid { load_n }
        } else {
            Before::Stuck { load_n }
        });
        if let Ok([to, from]) = work.contacts.get_disjoint_mut([kept, i]) {
            core::mem::swap(to, from);
        }
        kept += 1;
    }
    work.contacts.truncate(kept);

    let part = probe::span(Part::Cone);
    let hooks = (work.contacts.len() * model.effects.len()) as u16;
    let options = options.beside(u32::from(hooks) / 2);
    let solution = work.cone.solve(&bodies, guess, &options);
    drop(part);
    let mut output = StepSummary {
        status: solution.status,
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
    for (answer, c) in work.cone.answers().zip(&work.contacts) {
        if let Some(sum) = output.normal_n.get_mut(c.body.index()) {
            *sum += answer.force_n[0];
        }
    }
    if output.normal_n.iter().any(|n| *n > R::of(MOST_FORCE_N)) {
        output.status = SolveStatus::Contradiction;
        work.cone.forget();
        return output;
    }
    let u = solution.velocity;
    state.memory = memory;
    let load_n = state.last.map(|_| context.load_n);
    state.last = Some(LastStep { dt_s: dt, grip_n: drive.grip_n, load_n });
    gather(state, drive, work, &mut output);
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

/// [`step`] in `f64` for any scene, compiled in this crate: a host built for tests optimises
/// this crate alone.
pub fn step_f64(
    scene: &Scene<f64>,
    model: &Model<f64>,
    state: &mut State<f64, { contact::SLOTS }>,
    drive: &Drive<f64>,
) -> StepOutput<f64, { contact::SLOTS }> {
    step(scene, model, state, drive)
}

/// Wrenches, utilisation and the memory of the contact points at the end of a step.
fn gather<R: Real, const NC: usize>(
    state: &mut State<R, NC>,
    drive: &Drive<R>,
    work: &Workspace<R, NC>,
    out: &mut StepSummary<R>,
) {
    let zero = R::zero();
    let dt = drive.dt_s;
    let mut pusher_force = Vec3::zeros();
    let mut pusher_torque = Vec3::zeros();
    // Per finger: greatest tangential force and torsion, those acting, loads.
    let mut limit = [[zero; 2]; 2];
    let mut weight = [zero; 2];
    let by_dt = R::one() / dt;
    for (answer, c) in work.answers().zip(&work.contacts) {
        let f = answer.force_n;
        let force = c.axes[0] * f[0] + c.axes[1] * f[1] + c.axes[2] * f[2];
        let Some(slot) = state.slots.get_mut(c.slot) else { continue };
        let ratio = R::one() / (dt + c.damping_s);
        let mut slipped = [zero; 2];
        for k in 0..2 {
            // The bias was spring memory over step and damper, and the other body's motion.
            let speed = answer.biased_slip_m_s[k] - slot.spring_m[k] * ratio;
            let moved = speed * dt;
            let stiffness = answer.stiffness_n_s_m[k];
            let damper = c.damping_s * ratio * stiffness;
            let spring = (-f[k + 1] - damper * speed) * dt / (stiffness - damper);
            slipped[k] = slot.spring_m[k] + moved - spring;
            slot.spring_m[k] = spring;
        }
        let bound = f[0] + answer.adhesion_n;
        let [m1, m2] = answer.mu;
        let sliding = if bound > zero && m1 > zero && m2 > zero {
            let (a, b) = (f[1] / m1, f[2] / m2);
            a * a + b * b > R::of(0.9998) * bound * bound
        } else {
            true
        };
        let square = slipped[0] * slipped[0] + slipped[1] * slipped[1];
        slot.load_n = max(f[0], zero);
        if !(bound > zero) {
            slot.spring_m = [zero; 2];
            slot.speed_m_s = zero;
        } else if sliding && square > R::of(1e-16) {
            let travel = sqrt(square);
            slot.slip_m += travel;
            slot.speed_m_s = travel * by_dt;
            slot.rest_s = zero;
        } else {
            slot.speed_m_s = zero;
            slot.rest_s += dt;
        }
        match c.body {
            Body::Finger1 | Body::Finger2 => {
                let (sign, k) = if c.body == Body::Finger1 { (R::one(), 0) } else { (-R::one(), 1) };
                let centre = Vec3::new(zero, sign * (state.jaw_half_m + state.jaw_m), zero);
                let at = state.position_m + c.lever_m;
                add_wrench(&mut out.reading.finger[k], &force, &(at - centre));
                let arm = sqrt(c.patch_m[0] * c.patch_m[0] + c.patch_m[1] * c.patch_m[1]);
                let held = max(bound, zero);
                let most_n = (m1 + m2) * R::of(0.5) * held;
                limit[k][0] += most_n;
                limit[k][1] += most_n * arm;
                weight[k] += held;
                if bound > zero && sliding {
                    let slide = (c.axes[1] * slipped[0] + c.axes[2] * slipped[1]) * by_dt;
                    out.slip_m_s[k] += slide * bound;
                    if arm > R::of(1e-5) {
                        let turned = c.patch_m[0] * slipped[1] - c.patch_m[1] * slipped[0];
                        out.spin_rad_s[k] += turned * by_dt / (arm * arm) * bound;
                    }
                }
            }
            Body::Pusher => {
                let at = state.position_m + c.lever_m;
                let reference = drive.pusher.map_or(at, |p| p.reference_m);
                pusher_force += force;
                pusher_torque += (at - reference).cross(&force);
            }
            Body::Support => {}
        }
    }
    for k in 0..2 {
        if weight[k] > zero {
            out.slip_m_s[k] /= weight[k];
            out.spin_rad_s[k] /= weight[k];
        }
        let w = &out.reading.finger[k];
        let tangential = sqrt(w[0] * w[0] + w[2] * w[2]);
        let a = if limit[k][0] > zero { tangential / limit[k][0] } else { zero };
        let b = if limit[k][1] > zero { w[4] / limit[k][1] } else { zero };
        out.utilisation[k] = sqrt(a * a + b * b);
    }
    let force = drive.carrier.transform_vector(&pusher_force);
    let torque = drive.carrier.transform_vector(&pusher_torque);
    out.reading.pusher = [force.x, force.y, force.z, torque.x, torque.y, torque.z];
}

fn add_wrench<R: Real>(to: &mut [R; 6], force: &Vec3<R>, arm: &Vec3<R>) {
    let torque = arm.cross(force);
    for k in 0..3 {
        to[k] += force[k];
        to[3 + k] += torque[k];
    }
}

/// `rotation` turned by a small rotation vector given in the parent's axes. Exact in the
/// axis; the angle's relative error is angle²/12, below 1e-6 for any step here.
pub fn turned<R: Real>(rotation: &Rotation<R>, by_rad: &Vec3<R>) -> Rotation<R> {
    let half = by_rad * R::of(0.5);
    let d = Quaternion::new(R::one(), half.x, half.y, half.z);
    let q = d * rotation.quaternion();
    let norm = sqrt(q.w * q.w + q.i * q.i + q.j * q.j + q.k * q.k);
    UnitQuaternion::new_unchecked(q / norm)
}

/// `I^-1 t` for a symmetric positive definite 3 x 3 inertia, by cofactors.
fn inverse_times<R: Real>(i: &[[R; 3]; 3], t: &Vec3<R>) -> Vec3<R> {
    let rows = i.map(Vec3::from);
    let c = [rows[1].cross(&rows[2]), rows[2].cross(&rows[0]), rows[0].cross(&rows[1])];
    let determinant = rows[0].dot(&c[0]);
    if !(determinant.abs() > R::zero()) {
        return Vec3::zeros();
    }
    (c[0] * t.x + c[1] * t.y + c[2] * t.z) / determinant
}

/// The shortest turn that takes +X to the unit vector `to`.
fn turn_from_x<R: Real>(to: &Vec3<R>) -> Rotation<R> {
    let zero = R::zero();
    let w = R::one() + to.x;
    if !(w > R::of(1e-6)) {
        return UnitQuaternion::new_unchecked(Quaternion::new(zero, zero, R::one(), zero));
    }
    // Twice the half-angle's cosine and sine times cos(angle / 2): normalised below.
    let norm = sqrt(w * w + to.z * to.z + to.y * to.y);
    UnitQuaternion::new_unchecked(Quaternion::new(w, zero, -to.z, to.y) / norm)
}

/// The height of the table that just touches the object at `position_m`, as a frame at rest
/// relative to the carrier with +X along `up` (carrier axes).
pub fn support_under<R: Real>(
    scene: &Scene<R>,
    position_m: &Vec3<R>,
    rotation: &Rotation<R>,
    up: &Vec3<R>,
) -> Moving<R> {
    let down = rotation.inverse_transform_vector(&-up);
    let reach = match &scene.support {
        Some(SupportContact::Points(_)) => scene.object.shape.reach(&-Vec3::z()),
        _ => scene.object.shape.reach(&down),
    };
    let at = position_m - up * reach;
    Moving {
        position_m: at,
        rotation: turn_from_x(up),
        velocity_m_s: Vec3::zeros(),
        angular_rad_s: Vec3::zeros(),
        reference_m: at,
    }
}
