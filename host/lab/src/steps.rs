//! Steps of the board, one by one: what studies that repeat a step in another way are shown.
//!
//! A run of the board is walked through in `f32`, within a tick's bounds; from every state on the way a study
//! makes the same step once more, in another precision or another formulation.

use serde::Serialize;
use stickslip_device::package::Package;
use stickslip_lcp::solve::percentile;
use stickslip_shared::contact::SLOTS;
use stickslip_shared::model::{Model, Scene};
use stickslip_shared::real::Vec3;
use stickslip_shared::solve::SolveBudget;
use stickslip_shared::step::{Drive, State, StepSummary, Workspace, step_in};
use stickslip_shared::track::{
    self, PathFilter, Poses, Settling, between_pads, drive_between, seat, support_pose,
};
use stickslip_shared::wire::Sample;

/// What a step in `f32` is shown with: what it began with, what it gave.
pub struct Walked<'a> {
    /// Scene and model.
    pub scene: &'a Scene<f32>,
    /// Model.
    pub model: &'a Model<f32>,
    /// At the beginning of the step.
    pub before: &'a State<f32, SLOTS>,
    /// What was imposed.
    pub drive: &'a Drive<f32>,
    /// What it gave.
    pub out: &'a StepSummary<f32>,
    /// Its contact points, laws and forces.
    pub work: &'a Workspace<f32, SLOTS>,
    /// At the end of the step.
    pub after: &'a State<f32, SLOTS>,
}

fn poses(package: &Package, sample: &Sample) -> Option<Poses<f32>> {
    let sample = sample.at::<f32>(sample.t_us as f32 * 1e-6);
    let held = package.model.0.fingers.is_some();
    let carrier = if held { sample.gripper? } else { sample.object.or(sample.gripper)? };
    Some(Poses { t_s: sample.t_s, carrier, pusher: sample.pusher, support: None })
}

/// Steps the model in `f32` from sample to sample of a package and shows every step, until a
/// sample cannot be used. `options` as in a tick.
pub fn walk(package: &Package, mut see: impl FnMut(&Walked)) {
    let (scene, model, _) = &package.model;
    let Some((first, rest)) = package.samples.split_first() else { return };
    let (Some(mut from), Some(object)) = (poses(package, first), first.at::<f32>(0.0).object) else { return };
    let params = track::Params::default();
    let local = between_pads(scene, &from.carrier.to_local(&object), &params);
    let support = support_pose(scene, &from.carrier.to_world(&local));
    from.support = support;
    let unseated = from.pusher.map_or_else(Vec3::zeros, |p| p.position_m);
    let later = Poses { t_s: from.t_s + 0.004, ..from };
    let Some(drive) = drive_between(&from, &later, &unseated, first.grip_cmd_n, package.ordinal) else {
        return;
    };
    let mut state: State<f32, SLOTS> = State::held(scene, model, &drive, local.position_m, local.rotation);
    let seat_m = seat(scene, model, &state, &drive);
    let mut seated = drive;
    if let (Some(p), Some(m)) = (&mut from.pusher, &mut seated.pusher) {
        p.position_m += seat_m;
        m.position_m += drive.carrier.inverse_transform_vector(&seat_m);
    }
    let mut work = Workspace::new();
    if let Some(mut settling) = Settling::begin(scene, model, &mut state, &seated, params.settling) {
        settling.go_on(scene, model, &mut state, u32::MAX, &mut work);
    }
    let reference = unseated + seat_m;
    let mut carrier = PathFilter::new(from.carrier, params.path);
    let mut pusher = from.pusher.map(|p| PathFilter::new(p, params.path));
    for sample in rest {
        let Some(mut to) = poses(package, sample) else { return };
        let dt_s = to.t_s - from.t_s;
        if scene.fingers.is_none() {
            to.carrier = from.carrier;
        }
        if !(dt_s > 0.0) {
            return;
        }
        let planned = package
            .plan
            .at(to.t_s)
            .map(|s| (Vec3::from(s.velocity_m_s), Vec3::from(s.angular_rad_s)))
            .filter(|_| scene.fingers.is_some());
        to.carrier = carrier.follow(&to.carrier, dt_s, planned);
        to.support = support;
        if let (Some(p), Some(filter)) = (&mut to.pusher, &mut pusher) {
            p.position_m += seat_m;
            *p = filter.follow(p, dt_s, None);
        }
        let Some(drive) = drive_between(&from, &to, &reference, sample.grip_cmd_n, package.ordinal) else {
            return;
        };
        let before = state.clone();
        let out = step_in(scene, model, &mut state, &drive, &SolveBudget::present(), &mut work);
        let (before, drive, out) = (&before, &drive, &out);
        see(&Walked { scene, model, before, drive, out, work: &work, after: &state });
        from = to;
    }
}

/// Percentiles of a difference.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Spread {
    /// Half of the steps are below.
    pub median: f64,
    /// 99 of a hundred are below.
    pub p99: f64,
    /// Largest.
    pub worst: f64,
}

impl Spread {
    /// Of `values`.
    pub fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.collect();
        values.sort_by(f64::total_cmp);
        let at = |k| percentile(&values, k);
        Self { median: at(50), p99: at(99), worst: at(100) }
    }
}
