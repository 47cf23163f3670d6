//! The model run along a recorded trial: what it would have measured.
//!
//! Open loop, in `f64`: the object starts where it was measured; gripper and pusher move as
//! they were measured; forces and motion of the object are the model's own. The same
//! `step` runs on the board in `f32`.

use nalgebra::{UnitQuaternion, UnitVector3, Vector3};
use stickslip_shared::cone::SolveStatus;
use stickslip_shared::contact::{self, Body, Contacts, SLOTS};
use stickslip_shared::model::{Base, FingerContact, Friction, Model, PusherContact, Scene};
use stickslip_shared::step::{Drive, State, StepOutput, StepSummary, Workspace, pose_late_s, step_f64};
use stickslip_shared::track::{self, Pose, Poses, between_pads, drive_between, seat, settle, support_pose};

use crate::channels::{self, COUNT, Signals, object_channels};
use crate::run::late::Track;
use crate::run::motion::{between, denoised, interpolated};
use crate::run::preload;
pub use crate::run::preload::Carried;
use crate::run::scene::{SceneError, scene};
use stickslip_data::{Description, Trial};

/// A trial made ready: its scene, and the start of everything.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// Rig and object of this trial.
    pub scene: Scene<f64>,
    /// Carrier where no gripper is measured.
    pub carrier: Pose<f64>,
    /// Object in the carrier frame at the start (mean of the samples before anything moved).
    pub start: Pose<f64>,
    /// Table, world.
    pub support: Option<Pose<f64>>,
    /// What the fingers bear of an object that lies on something before anything moves. `None`: the model decides.
    pub carried: Option<Carried>,
    /// Measured channels, one for each sample.
    pub measured: Vec<Signals>,
    /// Time stamps.
    pub t_s: Vec<f64>,
    /// Poses of the prescribed bodies without measurement noise, one for each sample.
    poses: Vec<Poses<f64>>,
    grip_n: Vec<f64>,
    /// Place of the trial in its data set.
    pub ordinal: f64,
}

impl Prepared {
    /// Whether the pusher's plane lies under the object: a platform, which has the support's
    /// friction in the model.
    #[must_use]
    pub fn on_platform(&self) -> bool {
        let gravity = Vector3::from(self.scene.gravity_m_s2);
        let plane = matches!(self.scene.pusher, Some(PusherContact::Plane));
        let pusher = self.poses.first().and_then(|p| p.pusher);
        plane && pusher.is_some_and(|p| (p.rotation * Vector3::x()).dot(&gravity) < -0.7 * gravity.norm())
    }

    /// Which coefficients of friction its contacts have: of the fingers, of the pusher, of the support.
    #[must_use]
    pub fn frictions(&self) -> [bool; 3] {
        let scene = &self.scene;
        let platform = self.on_platform();
        [scene.fingers.is_some(), scene.pusher.is_some() && !platform, scene.support.is_some() || platform]
    }
}

/// The model's channels along a trial, and how the solver fared.
#[derive(Clone, Debug)]
pub struct Simulated {
    /// One for each sample.
    pub signals: Vec<Signals>,
    /// Steps whose solve did not reach its tolerance.
    pub unsolved: usize,
    /// Largest momentum error, N.
    pub worst_residual_n: f64,
    /// Slip speed of the object over each finger, m/s; one for each sample.
    pub slip_m_s: Vec<[f64; 2]>,
    /// Normal force of finger 1, finger 2, pusher, support; one for each sample.
    pub normal_n: Vec<[f64; 4]>,
}

/// The last step before a sample; its summary's fields are read as its own.
pub struct Step<'a> {
    summary: StepSummary<f64>,
    work: &'a Workspace<f64, SLOTS>,
}

impl Step<'_> {
    /// With its contact points.
    #[must_use]
    pub fn output(&self) -> StepOutput<f64, SLOTS> {
        StepOutput::of(self.summary, self.work)
    }
}

impl std::ops::Deref for Step<'_> {
    type Target = StepSummary<f64>;
    fn deref(&self) -> &StepSummary<f64> {
        &self.summary
    }
}

/// Arm at which a turn counts as a path, m.
pub const TURN_ARM_M: f64 = 0.03;

/// Makes a trial ready: converts poses and measurements once, for many simulations.
/// `ordinal` is the trial's place in its data set.
///
/// # Errors
/// See [`scene`]; also where the first sample lacks the object's or the gripper's pose.
pub fn prepare(description: &Description, trial: &Trial, ordinal: usize) -> Result<Prepared, SceneError> {
    let fail = |what: &str| SceneError::Description { trial: trial.info.trial.clone(), what: what.into() };
    let scene = scene(description, trial)?;
    let samples = &trial.samples;
    let first = samples.first().ok_or_else(|| fail("it has no samples"))?;
    let object = samples
        .iter()
        .take(10)
        .find_map(|s| s.object.as_ref())
        .map(channels::pose)
        .ok_or_else(|| fail("the object's pose is not known at the start; the model needs it there"))?;
    let mut carrier = match (&first.gripper, &scene.fingers) {
        (Some(g), _) => channels::pose(g),
        (None, None) => object,
        (None, Some(_)) => return Err(fail("the gripper's pose is not known at the start")),
    };
    let t_s: Vec<f64> = samples.iter().map(|s| s.t_s).collect();
    // Poses may come at a lower rate than forces: between them the motion is straight. Held, they
    // would be a staircase.
    let grippers: Vec<_> = samples.iter().map(|s| s.gripper.as_ref().map(channels::pose)).collect();
    let grippers = interpolated(&t_s, &grippers).filter(|_| scene.fingers.is_some());
    let grippers = grippers.unwrap_or_else(|| vec![carrier; samples.len()]);
    let mut pushers: Vec<_> = samples.iter().map(|s| s.pusher.as_ref().map(channels::pose)).collect();
    if let Some(first) = pushers.first_mut() {
        *first = first.or(trial.info.pusher.as_ref().map(channels::pose));
    }
    let known = scene.pusher.is_some() && pushers.first().is_some_and(Option::is_some);
    let pushers = interpolated(&t_s, &pushers).filter(|_| known).unwrap_or_default();
    let mut grip = trial.info.grip_n.unwrap_or(0.0);
    let mut grip_n = Vec::with_capacity(samples.len());
    for s in samples {
        grip = s.grip_cmd_n.unwrap_or(grip);
        grip_n.push(grip);
    }
    if scene.pusher.is_some() && pushers.len() < samples.len() {
        return Err(fail(
            "its primitive has a pusher, but neither trials.csv nor its first sample gives its pose (in a mapping: [fixed.pusher])",
        ));
    }
    let (grippers, pushers) = (denoised(&t_s, &grippers), denoised(&t_s, &pushers));
    carrier = grippers.first().copied().unwrap_or(carrier);
    let start = between_pads(&scene, &mean_start(trial, &grippers, &object), &track::Params::default());
    let support = support_pose(&scene, &carrier.to_world(&start));
    let poses: Vec<Poses<f64>> = (0..samples.len())
        .map(|i| Poses { t_s: t_s[i], carrier: grippers[i], pusher: pushers.get(i).copied(), support })
        .collect();
    let measured =
        samples.iter().zip(&poses).map(|(s, p)| channels::measured(s, &p.carrier, &start.rotation)).collect();
    Ok(Prepared {
        scene,
        carrier,
        start,
        support,
        carried: None,
        measured,
        t_s,
        poses,
        grip_n,
        ordinal: ordinal as f64,
    })
}

/// Mean pose of the object in the carrier while nothing moves yet (at most 100 ms): pose
/// noise at a single sample would tilt the whole simulation.
fn mean_start(trial: &Trial, carriers: &[Pose<f64>], object: &Pose<f64>) -> Pose<f64> {
    let Some(carrier) = carriers.first() else { return *object };
    let first = carrier.to_local(object);
    let (mut position, mut turn, mut count) = (Vector3::zeros(), Vector3::zeros(), 0.0);
    let t0 = trial.samples.first().map_or(0.0, |s| s.t_s);
    for (s, here) in trial.samples.iter().zip(carriers).take_while(|(s, _)| s.t_s - t0 <= 0.1) {
        let moved =
            (here.position_m - carrier.position_m).norm() + here.rotation.angle_to(&carrier.rotation) * 0.05;
        if moved > 2e-5 {
            break;
        }
        let Some(o) = &s.object else { continue };
        let local = here.to_local(&channels::pose(o));
        position += local.position_m - first.position_m;
        turn += (local.rotation * first.rotation.inverse()).scaled_axis();
        count += 1.0;
    }
    if count == 0.0 {
        return first;
    }
    Pose {
        position_m: first.position_m + position / count,
        rotation: UnitQuaternion::from_scaled_axis(turn / count) * first.rotation,
    }
}

impl Prepared {
    /// Runs the model along the trial. Every sample gets a row; a time gap longer than a
    /// tenth of a second is bridged in steps of 20 ms at most.
    pub fn simulate(&self, model: &Model<f64>) -> Simulated {
        self.simulate_every(model, 1)
    }

    /// As [`Prepared::simulate`], stepping over `stride` samples at a time; rows between are
    /// copies of the last step's. For sensitivities, where coarse steps will do.
    pub fn simulate_every(&self, model: &Model<f64>, stride: usize) -> Simulated {
        let n = self.poses.len();
        let mut out = Simulated {
            signals: Vec::with_capacity(n),
            unsolved: 0,
            worst_residual_n: 0.0,
            slip_m_s: Vec::with_capacity(n),
            normal_n: Vec::with_capacity(n),
        };
        let mut track = Track::default();
        self.observe(model, stride, |sample, state, step, _| {
            while out.signals.len() <= sample {
                self.record(step, &mut out);
            }
            track.push(&self.poses[sample], state, out.signals.len());
        });
        track.show(pose_late_s(model), &self.start.rotation, &mut out.signals);
        out
    }

    /// Runs the model along the trial and shows the last step before each sample it reaches:
    /// sample, state after the step, what the step produced, its drive. The first call is
    /// for sample 0, at rest in the grasp.
    pub fn observe(
        &self,
        model: &Model<f64>,
        stride: usize,
        mut each: impl FnMut(usize, &State<f64, SLOTS>, &Step, &Drive<f64>),
    ) {
        let n = self.poses.len();
        let Some((mut drive, unseated, mut state)) = self.at_rest(model) else { return };
        let mut work = Workspace::new();
        let mut shift = seat(&self.scene, model, &state, &drive);
        if let Some(p) = &mut drive.pusher {
            p.position_m += drive.carrier.inverse_transform_vector(&shift);
        }
        settle(&self.scene, model, &mut state, &drive, track::SettlingParams::default());
        let (side, weight_n) = (self.side().unwrap_or_default(), self.weight_n());
        let borne =
            self.carried.zip(self.up()).map(|(force, up)| preload::Borne { up, side, force, weight_n });
        let rest = preload::Rest { lies: self.rests(), borne };
        shift += preload::load((&self.scene, model), &mut state, &mut drive, &rest, &mut work);
        let summary = step_f64(&self.scene, model, &mut state, &drive, &mut work);
        each(0, &state, &Step { summary, work: &work }, &drive);
        let stride = stride.max(1);
        let mut from = 0;
        while from + 1 < n {
            let to = (from + stride).min(n - 1);
            let (mut a, mut b) = (self.poses[from], self.poses[to]);
            for p in [&mut a.pusher, &mut b.pusher].into_iter().flatten() {
                p.position_m += shift;
            }
            let parts = ((b.t_s - a.t_s) / 0.0201).ceil().max(1.0);
            if let Some(whole) = drive_between(&a, &b, &unseated, self.grip_n[to], self.ordinal) {
                let mut part = whole;
                part.dt_s = whole.dt_s / parts;
                let mut summary = step_f64(&self.scene, model, &mut state, &part, &mut work);
                for _ in 1..parts as usize {
                    for m in [&mut part.pusher, &mut part.support].into_iter().flatten() {
                        m.position_m += m.velocity_m_s * part.dt_s;
                        m.rotation =
                            stickslip_shared::step::turned(&m.rotation, &(m.angular_rad_s * part.dt_s));
                    }
                    summary = step_f64(&self.scene, model, &mut state, &part, &mut work);
                }
                each(to, &state, &Step { summary, work: &work }, &part);
            }
            from = to;
        }
    }

    /// Drive of a first step in which nothing moves, where the pusher is measured (m, the origin of its drive), and
    /// the object at rest in the grasp: the carrier's own speed enters with the first step.
    fn at_rest(&self, model: &Model<f64>) -> Option<(Drive<f64>, Vector3<f64>, State<f64, SLOTS>)> {
        let first = self.poses.first()?;
        let unseated = first.pusher.map_or_else(Vector3::zeros, |p| p.position_m);
        let still = Poses { t_s: first.t_s + 0.004, ..*first };
        let grip_n = self.grip_n.first().copied()?;
        let drive = drive_between(first, &still, &unseated, grip_n, self.ordinal)?;
        let state = State::held(&self.scene, model, &drive, self.start.position_m, self.start.rotation);
        Some((drive, unseated, state))
    }

    fn record(&self, step: &StepSummary<f64>, out: &mut Simulated) {
        let mut row = [f64::NAN; COUNT];
        let r = &step.reading;
        let local = Pose { position_m: r.position_m, rotation: r.rotation };
        row[..6].copy_from_slice(&object_channels(&local, &self.start.rotation));
        if self.scene.fingers.is_some() {
            row[6..12].copy_from_slice(&r.finger[0]);
            row[12..18].copy_from_slice(&r.finger[1]);
        }
        if self.scene.pusher.is_some() {
            row[18..24].copy_from_slice(&r.pusher);
        }
        out.signals.push(row);
        out.slip_m_s.push(step.slip_m_s.map(|s| s.norm()));
        out.normal_n.push(step.normal_n);
        if step.status != SolveStatus::Solved {
            out.unsolved += 1;
        }
        out.worst_residual_n = out.worst_residual_n.max(step.residual_n);
    }

    /// Whether the pusher is nearer to the object at the start than `gap_m`.
    pub fn pusher_touches(&self, gap_m: f64) -> bool {
        let model = Model::base(Base::Hard, Friction { finger: 0.0, pusher: 0.0, support: 0.0 });
        let Some((drive, _, state)) = self.at_rest(&model) else { return false };
        let mut found: Contacts<f64, SLOTS> = heapless::Vec::new();
        contact::find(&self.scene, &model, &state, &drive, &mut found);
        found.iter().any(|c| c.body == Body::Pusher && c.gap_m < gap_m)
    }

    /// Mean time between samples, s.
    pub fn period_s(&self) -> f64 {
        let length = self.t_s.last().unwrap_or(&0.0) - self.t_s.first().unwrap_or(&0.0);
        length / (self.t_s.len().max(2) - 1) as f64
    }

    /// Poses of the prescribed bodies, one for each sample.
    pub fn poses(&self) -> &[Poses<f64>] {
        &self.poses
    }

    /// Whether the object lies on a table or a platform at the start.
    pub fn rests(&self) -> bool {
        self.on_platform() || self.scene.support.is_some()
    }

    /// Grip force commanded on each finger, one for each sample, N.
    pub fn grips_n(&self) -> &[f64] {
        &self.grip_n
    }

    /// Grip force commanded while the trial moves (the median over its samples), N.
    pub fn grip_n(&self) -> f64 {
        let mut all = self.grip_n.clone();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or(0.0)
    }

    /// Diameter of the fingers' pads, m; none where the fingers have no discs.
    pub fn pad_diameter_m(&self) -> Option<f64> {
        match self.scene.fingers {
            Some(FingerContact::Disc { diameter_m }) => Some(diameter_m),
            _ => None,
        }
    }

    /// Length of the prescribed path, m; see [`Prepared::drive_speed`].
    pub fn drive_path(&self) -> f64 {
        let speed = self.drive_speed();
        self.t_s.windows(2).zip(&speed).map(|(t, v)| v * (t[1] - t[0])).sum()
    }

    /// The same trial with every commanded grip force multiplied by `factor`.
    #[must_use]
    pub fn with_grip(&self, factor: f64) -> Self {
        let mut out = self.clone();
        out.grip_n.iter_mut().for_each(|g| *g *= factor);
        out
    }

    /// Whether the object's pose is known in less than a tenth of the samples.
    #[must_use]
    pub fn is_sparse(&self) -> bool {
        let known = self.measured.iter().filter(|row| row[0].is_finite()).count();
        10 * known < self.measured.len()
    }

    /// The same trial with the object's poses measured `by_s` earlier than stated.
    #[must_use]
    pub fn seen_earlier(&self, by_s: f64) -> Self {
        let mut out = self.clone();
        if by_s == 0.0 {
            return out;
        }
        let known = |i: &usize| self.measured[*i][..6].iter().all(|x| x.is_finite());
        let seen: Vec<usize> = (0..self.measured.len()).filter(known).collect();
        let at: Vec<_> =
            seen.iter().map(|i| (self.t_s[*i], self.world_pose(*i, &self.measured[*i]))).collect();
        let then = between(&at, seen.iter().map(|i| self.t_s[*i] + by_s)).unwrap_or_default();
        for (i, object) in seen.iter().zip(&then) {
            let local = self.poses[*i].carrier.to_local(object);
            out.measured[*i][..6].copy_from_slice(&object_channels(&local, &self.start.rotation));
        }
        out
    }

    /// The same trial with the object lying elsewhere at the start, by `shift_m` (carrier axes).
    #[must_use]
    pub fn placed(&self, shift_m: &Vector3<f64>) -> Self {
        let mut out = self.clone();
        out.start.position_m += shift_m;
        out
    }

    /// The same trial with the pusher turned by `angle_rad` about `axis` of its own axes, as if it were mounted so.
    #[must_use]
    pub fn mounted(&self, axis: &UnitVector3<f64>, angle_rad: f64) -> Self {
        let mut out = self.clone();
        let turn = UnitQuaternion::from_axis_angle(axis, angle_rad);
        out.poses.iter_mut().filter_map(|p| p.pusher.as_mut()).for_each(|pusher| pusher.rotation *= turn);
        out
    }

    /// The same trial with the fingers bearing that much of the object before anything moves.
    #[must_use]
    pub fn carrying(&self, carried: Carried) -> Self {
        Self { carried: Some(carried), ..self.clone() }
    }

    /// The same trial along two paths that nobody can tell from the measured one: the carrier
    /// drifts by 5 um sideways and 0.05 mrad about its own X and Z, to either side, which is
    /// below what motion capture sees. A rigid grasp that touches something has forces that
    /// hang on it. None where nothing is grasped.
    pub fn drifted(&self) -> Vec<Self> {
        const DRIFT_M: f64 = 5e-6;
        const DRIFT_RAD: f64 = 5e-5;
        let signs: &[f64] = if self.scene.fingers.is_some() { &[1.0, -1.0] } else { &[] };
        let drift = |sign: &f64| {
            let turn = Vector3::new(DRIFT_RAD, 0.0, sign * DRIFT_RAD);
            self.with_drift(&(Vector3::y() * (sign * DRIFT_M)), &turn)
        };
        signs.iter().map(drift).collect()
    }

    /// The same trial with the carrier drifting away from its measured track, evenly from
    /// nothing at the first sample to `shift_m` and `turn_rad` (carrier axes) at the last.
    #[must_use]
    pub fn with_drift(&self, shift_m: &Vector3<f64>, turn_rad: &Vector3<f64>) -> Self {
        let last = self.poses.len().max(2) as f64 - 1.0;
        let shifts: Vec<_> = (0..self.poses.len()).map(|i| shift_m * (i as f64 / last)).collect();
        let mut out = self.shifted(&shifts);
        for (i, p) in out.poses.iter_mut().enumerate() {
            p.carrier.rotation *= UnitQuaternion::from_scaled_axis(turn_rad * (i as f64 / last));
        }
        out
    }

    /// The same trial with the carrier that far off its measured track at each sample (carrier axes).
    #[must_use]
    pub fn shifted(&self, shifts_m: &[Vector3<f64>]) -> Self {
        let mut out = self.clone();
        for (p, shift_m) in out.poses.iter_mut().zip(shifts_m) {
            p.carrier.position_m += p.carrier.rotation.transform_vector(shift_m);
        }
        out
    }

    /// Speed of the prescribed motion at each sample, m/s: gripper and pusher relative to
    /// the world, a turn counted at [`TURN_ARM_M`]. Zero at rest.
    pub fn drive_speed(&self) -> Vec<f64> {
        let turned = |a: &Pose<f64>, b: &Pose<f64>| {
            (b.position_m - a.position_m).norm() + TURN_ARM_M * b.rotation.angle_to(&a.rotation)
        };
        let mut speed: Vec<f64> = self
            .poses
            .windows(2)
            .map(|w| {
                let pusher = match (&w[0].pusher, &w[1].pusher) {
                    (Some(a), Some(b)) => turned(a, b),
                    _ => 0.0,
                };
                (turned(&w[0].carrier, &w[1].carrier) + pusher) / (w[1].t_s - w[0].t_s)
            })
            .collect();
        speed.push(0.0);
        speed
    }

    /// Object's pose in the world for a row of channels at sample `index`.
    pub fn world_pose(&self, index: usize, row: &Signals) -> Pose<f64> {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::new(row[3], row[4], row[5]));
        let local =
            Pose { position_m: Vector3::new(row[0], row[1], row[2]), rotation: turn * self.start.rotation };
        self.poses[index].carrier.to_world(&local)
    }
}
