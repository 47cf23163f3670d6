//! Short runs of the predictor as candidates: numbers between 0 and 1 (genes) are turned into
//! a scene, a model, a plan and samples.
//!
//! The samples are kinematics with noise, within what a rig can do or a sensor can show; they
//! need not be a physical motion. Every contact type, effect and intent can occur.

use nalgebra::UnitQuaternion;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use stickslip_shared::cone::SolveStatus;
use stickslip_shared::effects::{Effect, MAX_PARAMETERS, REGISTRY, formula};
use stickslip_shared::model::{
    Base, FingerContact, Friction, Model, Object, PusherContact, Scene, Shape, SupportContact,
};
use stickslip_shared::predictor::{Intent, Limits, Plan, Predictor, Segment};
use stickslip_shared::real::Vec3;
use stickslip_shared::shape::inertia;
use stickslip_shared::wire::{ModelPackage, Pose, Sample, TICK_US};

use super::Target;
use super::search::Candidate;
use crate::{precision, steps};
use stickslip_device::package::Package;
use stickslip_lcp::generate::rng;

/// Ticks of a candidate.
pub const TICKS: u32 = 48;
const GENES: usize = 48;

/// A candidate.
#[derive(Clone, Debug, PartialEq)]
pub struct Genes([f32; GENES]);

impl Candidate for Genes {
    fn fresh(rng: &mut ChaCha8Rng) -> Self {
        Genes([0; GENES].map(|_| rng.random_range(0.0..1.0)))
    }

    fn mutated(&self, rng: &mut ChaCha8Rng) -> Self {
        let mut genes = self.0;
        for _ in 0..rng.random_range(1..6) {
            let gene = &mut genes[rng.random_range(0..GENES)];
            *gene = match rng.random_range(0..4) {
                0 => rng.random_range(0.0..1.0),
                1 => (*gene + rng.random_range(-0.1..0.1_f32)).clamp(0.0, 0.999_999),
                _ => (*gene + rng.random_range(-0.01..0.01_f32)).clamp(0.0, 0.999_999),
            };
        }
        Genes(genes)
    }

    fn mixed(&self, other: &Self, rng: &mut ChaCha8Rng) -> Self {
        let mut genes = self.0;
        for (a, b) in genes.iter_mut().zip(other.0) {
            if rng.random_bool(0.5) {
                *a = b;
            }
        }
        Genes(genes)
    }
}

/// Reads genes one after the other.
struct Reader<'a>(std::slice::Iter<'a, f32>);

impl Reader<'_> {
    fn unit(&mut self) -> f32 {
        self.0.next().copied().unwrap_or(0.5)
    }
    fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }
    /// Even in the logarithm.
    fn scale(&mut self, low: f32, high: f32) -> f32 {
        low * (high / low).powf(self.unit())
    }
    fn below(&mut self, n: usize) -> usize {
        ((self.unit() * n as f32) as usize).min(n - 1)
    }
    fn vector(&mut self, size: f32) -> Vec3<f32> {
        Vec3::new(self.within(-size, size), self.within(-size, size), self.within(-size, size))
    }
}

fn effects(g: &mut Reader) -> Vec<Effect<f32>> {
    let number = g.below(5).saturating_sub(2);
    (0..2)
        .map(|_| {
            let info = &REGISTRY[g.below(REGISTRY.len())];
            let strength = g.within(0.2, 2.0);
            let mut parameters = [0.0; MAX_PARAMETERS];
            for (p, i) in parameters.iter_mut().zip(info.parameters) {
                *p = (i.typical as f32 * strength).clamp(i.low as f32, i.high as f32);
            }
            Effect { code: info.code, parameters }
        })
        .take(number)
        .filter(|e| e.code != formula::CODE)
        .collect()
}

fn pose(position_m: Vec3<f32>, rotation: UnitQuaternion<f32>) -> Pose {
    let q = rotation.quaternion();
    Pose { position_m: position_m.into(), quaternion: [q.w, q.i, q.j, q.k] }
}

/// Scene, model, plan and samples of a candidate.
#[must_use]
pub fn package(genes: &Genes) -> Package {
    let g = &mut Reader(genes.0.iter());
    let kind = g.below(6);
    let mass_kg = g.scale(0.02, 2.0);
    let friction =
        Friction { finger: g.scale(0.03, 1.5), pusher: g.scale(0.03, 3.0), support: g.scale(0.03, 3.0) };
    let base = if g.unit() < 0.7 {
        Base::Hard
    } else {
        Base::Soft {
            normal_n_m: 3e4 + 5e5 * genes.0[GENES - 1],
            tangential_n_m: 1e4 + 3e5 * genes.0[GENES - 2],
            damping_s: 0.01 * genes.0[GENES - 3],
        }
    };
    let mut model = Model::base(base, friction);
    model.effects.extend(effects(g));
    let length_m = g.within(0.04, 0.15);
    let side_m = g.within(0.012, 0.04);
    let shape = match (kind, g.below(3)) {
        (2, _) | (_, 2) => Shape::Cylinder { length_m, diameter_m: side_m, across_flats_m: side_m },
        (4, _) => {
            let a = length_m;
            let corners = [[-a / 3.0, -a / 3.0], [2.0 * a / 3.0, -a / 3.0], [-a / 3.0, 2.0 * a / 3.0]];
            Shape::Polygon { vertices_m: corners.into_iter().collect(), height_m: side_m }
        }
        _ => Shape::Prism { length_m, side_m },
    };
    let (half_m, half_side_m) = (length_m * 0.5, side_m * 0.5);
    let grip_n = g.scale(0.5, 50.0);
    let speed = g.scale(0.002, 0.08);
    let finger = match g.below(4) {
        0 => FingerContact::Point,
        1 => FingerContact::Line { length_m: 0.015 },
        _ => FingerContact::Disc { diameter_m: 0.02 },
    };
    let mut scene = Scene {
        gravity_m_s2: [0.0, 0.0, -9.81],
        object: Object { inertia_kg_m2: inertia(&shape, mass_kg), shape, mass_kg },
        fingers: Some(finger),
        pusher: None,
        support: None,
    };
    let start = Vec3::new(0.3, 0.1, 0.2);
    let (mut velocity, mut turning) = (Vec3::zeros(), Vec3::zeros());
    let mut pusher: Option<(Vec3<f32>, UnitQuaternion<f32>)> = None;
    let mut pusher_velocity = Vec3::zeros();
    let gap_m = g.within(-2e-5, 2e-4);
    let shift = g.within(-0.8, 0.8);
    let upright = UnitQuaternion::identity();
    // +X of the frame points up, or down.
    let up = UnitQuaternion::from_axis_angle(&Vec3::y_axis(), -core::f32::consts::FRAC_PI_2);
    let mut intent = Intent::Hold;
    match kind {
        0 => {
            scene.pusher = Some(PusherContact::Plane);
            pusher = Some((start - Vec3::x() * (half_m + gap_m), upright));
            velocity = Vec3::new(-speed, 0.0, speed * shift * 0.5);
            intent = Intent::Slide;
        }
        1 => {
            scene.pusher = Some(PusherContact::Line { length_m: 0.03 });
            pusher = Some((start + Vec3::new(-half_m - gap_m, 0.0, half_side_m * shift), upright));
            turning = Vec3::y() * (speed * 8.0 * if shift > 0.0 { 1.0 } else { -1.0 });
            intent = Intent::Pivot;
        }
        2 => {
            scene.pusher = Some(PusherContact::Plane);
            pusher = Some((start - Vec3::z() * (half_side_m + gap_m), up));
            velocity = Vec3::new(0.0, speed, -0.02 * speed);
            intent = Intent::Free;
        }
        3 => {
            scene.support = Some(SupportContact::Patch);
            velocity = Vec3::new(speed * shift, 0.0, speed);
        }
        4 => {
            scene.fingers = None;
            scene.pusher = Some(PusherContact::Point { tip_radius_m: 0.005 });
            scene.support = Some(if g.below(2) == 0 {
                SupportContact::Patch
            } else {
                SupportContact::Points([[-0.01, -0.01], [0.02, -0.01], [-0.01, 0.02]].into_iter().collect())
            });
            pusher = Some((start + Vec3::new(-length_m / 3.0 - 0.005 - gap_m, 0.02 * shift, 0.0), upright));
            pusher_velocity = Vec3::x() * speed;
            intent = Intent::Free;
        }
        _ => {
            // Held against a wall that turns, with the table below.
            scene.pusher = Some(PusherContact::Plane);
            scene.support = Some(SupportContact::Patch);
            pusher = Some((start - Vec3::x() * (half_m + gap_m), upright));
            velocity = Vec3::new(-speed, 0.0, -speed * 0.02);
            pusher_velocity = Vec3::new(speed * shift, 0.0, 0.0);
            intent = Intent::Slide;
        }
    }
    velocity += g.vector(0.3 * speed);
    turning += g.vector(0.1);
    let tilt = UnitQuaternion::from_scaled_axis(g.vector(0.01));
    // From here on the motion is another one.
    let turn_at = (g.unit() * TICKS as f32) as u32;
    let (after, after_turning) = (g.vector(speed), g.vector(0.3));
    let grip_rate_n_s = grip_n * g.within(-6.0, 3.0);
    let noise_m = g.scale(1e-9, 3e-5);
    let object_noise_m = g.scale(1e-9, 1e-4);
    let planned = g.unit() < 0.8;
    let mut draw = rng(u64::from(genes.0[0].to_bits()));
    let mut noise = |size: f32| Vec3::from([0; 3].map(|_| size * draw.random_range(-1.0..1.0_f32)));
    let (mut at, mut rotation) = (start, upright);
    let dt_s = 1e-6 * TICK_US as f32;
    let mut samples = Vec::new();
    for k in 0..TICKS {
        if k > 0 {
            let (v, w) = if k < turn_at { (velocity, turning) } else { (after, after_turning) };
            at += v * dt_s;
            rotation = UnitQuaternion::from_scaled_axis(w * dt_s) * rotation;
            if let Some((p, _)) = &mut pusher {
                *p += pusher_velocity * dt_s;
            }
        }
        let grip_cmd_n = (grip_n + grip_rate_n_s * dt_s * k as f32).max(0.0);
        let jitter = noise(0.05);
        let wrench = |sign: f32| {
            let weight = mass_kg * 4.9;
            Some([jitter.x, sign * grip_cmd_n + jitter.y, weight + jitter.z, 0.0, 0.0, 0.0])
        };
        samples.push(Sample {
            seq: k,
            t_us: k * TICK_US,
            grip_cmd_n,
            gripper: scene.fingers.is_some().then(|| pose(at + noise(noise_m), rotation)),
            object: (k == 0 || g_seen(genes, k)).then(|| pose(start + noise(object_noise_m), tilt)),
            pusher: pusher.map(|(p, r)| pose(p + noise(noise_m), r)),
            finger: if scene.fingers.is_some() { [wrench(-1.0), wrench(1.0)] } else { [None; 2] },
        });
    }
    let mut plan = Plan::default();
    if planned {
        let segment = |duration_s, v: Vec3<f32>, w: Vec3<f32>| Segment {
            duration_s,
            velocity_m_s: v.into(),
            angular_rad_s: w.into(),
            grip_n,
            intent,
        };
        let first = segment(dt_s * turn_at as f32, velocity, turning);
        // Two segments fit.
        let _ = plan.segments.push(first);
        let _ = plan.segments.push(segment(10.0, after, after_turning));
    }
    Package { model: (scene, model, Limits::default()), plan, ordinal: 0.0, samples }
}

/// Whether the camera sees the object in tick `k`.
fn g_seen(genes: &Genes, k: u32) -> bool {
    genes.0[GENES - 4] > 0.5 && k.is_multiple_of(4)
}

/// A run that was found, as it is kept in a file.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Case {
    /// Target, as on the command line.
    pub target: String,
    /// Its value when it was found, in the target's unit.
    pub found: f64,
    /// Scene, model and limits.
    pub model: ModelPackage,
    /// What the gripper will do.
    pub plan: Plan,
    /// The run.
    pub samples: Vec<Sample>,
}

impl Case {
    /// From what was found.
    #[must_use]
    pub fn new(target: Target, found: f64, package: Package) -> Self {
        let Package { model, plan, samples, .. } = package;
        Self { target: target.name(), found, model, plan, samples }
    }

    /// As `stickslip-lab cost` and the predictor take it.
    #[must_use]
    pub fn package(&self) -> Package {
        let Self { model, plan, samples, .. } = self.clone();
        Package { model, plan, ordinal: 0.0, samples }
    }
}

/// Largest of a target over the ticks of a run; `None` where scene or model is refused.
#[must_use]
pub fn worst(target: Target, package: &Package) -> Option<f64> {
    let (scene, model, limits) = package.model.clone();
    if target == Target::TickWork {
        let mut predictor = Predictor::new(scene, model, limits).ok()?;
        predictor.set_plan(package.plan.clone());
        let work = package.samples.iter().map(|sample| {
            predictor.take(sample);
            f64::from(predictor.work())
        });
        return Some(work.fold(0.0, f64::max));
    }
    stickslip_shared::predictor::validate(&scene, &model).ok()?;
    let mut worst = 0.0_f64;
    steps::walk(package, |walked| {
        let out = walked.out;
        if out.status == SolveStatus::BadInput || out.status == SolveStatus::Contradiction {
            return;
        }
        let value = match target {
            Target::StepWork => f64::from(out.work()),
            Target::StepResidual => f64::from(out.residual_n),
            _ => {
                let pair = precision::compare(walked);
                match (pair.solved, target) {
                    (false, _) => 0.0,
                    (true, Target::StepForce) => pair.force_n / pair.load_n.max(1.0),
                    (true, _) => pair.velocity_m_s,
                }
            }
        };
        worst = worst.max(value);
    });
    Some(worst)
}

/// How bad a candidate is.
#[must_use]
pub fn score(target: Target, genes: &Genes) -> f64 {
    worst(target, &package(genes)).unwrap_or(0.0)
}
