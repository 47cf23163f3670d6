//! Varied pushes made from a seed, run through the predictor, and hashed: the same number
//! must come out on every platform, in debug and in release.
//!
//! The samples are kinematics and noise only; nothing here is meant to be realistic beyond
//! making every contact type, effect and branch of the solver work.
#![no_std]
#![forbid(unsafe_code)]

pub mod hostile;

use heapless::Vec;
use nalgebra::UnitQuaternion;
use stickslip_shared::effects::{Effect, MAX_PARAMETERS, REGISTRY};
use stickslip_shared::model::{
    Base, FingerContact, Formulation, Friction, Model, Object, PusherContact, Scene, Shape, SupportContact,
};
use stickslip_shared::predictor::{HASH_START, Intent, Limits, Plan, Predictor, Sample, Segment, validity};
use stickslip_shared::real::Vec3;
use stickslip_shared::shape::inertia;
use stickslip_shared::step::turned;
use stickslip_shared::track::Pose;
use stickslip_shared::wire::ModelPackage;

/// Ticks of one trial.
const TRIAL_TICKS: u32 = 150;

/// Levels drawn for the parameters of an effect; more parameters take them again.
const LEVELS: usize = 6;

/// What a self-test produced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Digest {
    /// Of every output word of every tick.
    pub hash: u32,
    /// Ticks run.
    pub ticks: u32,
    /// Ticks whose validity word marks a solve.
    pub marked: u32,
    /// Ticks in which a step asked for pyramids and was solved with the cone.
    pub cone_instead: u32,
    /// Ticks during which a finger slipped.
    pub slipping: u32,
}

/// Numerical Recipes' linear congruential generator: enough to vary scenes.
struct Draw(u32);

impl Draw {
    fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        self.0 >> 8
    }

    fn below(&mut self, n: u32) -> u32 {
        self.next() % n.max(1)
    }

    /// Uniform in `[low, high)`.
    fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * (self.next() as f32 / 16_777_216.0)
    }
}

/// One trial: its scene, model and prescribed motion.
struct Scenario {
    scene: Scene<f32>,
    model: Model<f32>,
    intent: Intent,
    /// Gripper, world.
    velocity_m_s: Vec3<f32>,
    turn_rad_s: Vec3<f32>,
    pusher: Option<Pose<f32>>,
    pusher_velocity_m_s: Vec3<f32>,
    grip_n: f32,
    /// Change of grip, N/s.
    grip_rate_n_s: f32,
    object: Pose<f32>,
}

fn at(x: f32, y: f32, z: f32) -> Pose<f32> {
    Pose { position_m: Vec3::new(x, y, z), rotation: UnitQuaternion::identity() }
}

fn object(shape: Shape<f32>, mass_kg: f32) -> Object<f32> {
    Object { inertia_kg_m2: inertia(&shape, mass_kg), shape, mass_kg }
}

/// The paper's push, for tests: a prism of 100 x 25 mm between discs, a flat pusher, rigid contact.
pub fn push(mass_kg: f32, finger_friction: f32) -> ModelPackage {
    let scene = Scene {
        gravity_m_s2: [0.0, 0.0, -9.81],
        object: object(Shape::Prism { length_m: 0.1, side_m: 0.025 }, mass_kg),
        fingers: Some(FingerContact::Disc { diameter_m: 0.02 }),
        pusher: Some(PusherContact::Plane),
        support: None,
    };
    let friction = Friction { finger: finger_friction, pusher: 0.25, support: 0.3 };
    (scene, Model::base(Base::Hard, friction), Limits::default())
}

/// Trials draw from so many effects, the first of the list: a new one leaves them as they are.
const EFFECTS: u32 = 26;

fn random_model(draw: &mut Draw) -> Model<f32> {
    let friction = Friction {
        finger: draw.within(0.1, 0.6),
        pusher: draw.within(0.1, 0.4),
        support: draw.within(0.1, 0.5),
    };
    let base = if draw.below(4) == 0 {
        Base::Soft {
            normal_n_m: draw.within(2e4, 5e5),
            tangential_n_m: draw.within(1e4, 2e5),
            damping_s: draw.within(0.0, 0.01),
        }
    } else {
        Base::Hard
    };
    let mut effects = Vec::new();
    for _ in 0..draw.below(3) {
        let Some(info) = REGISTRY.get(draw.below(EFFECTS) as usize) else { continue };
        let mut parameters = [0.0; MAX_PARAMETERS];
        // As many draws for each, so that a new parameter leaves the other trials as they are.
        let levels: [f32; LEVELS] = core::array::from_fn(|_| draw.within(0.3, 1.0));
        for ((p, i), level) in parameters.iter_mut().zip(info.parameters).zip(levels.iter().cycle()) {
            *p = (i.typical as f32 * level).clamp(i.low as f32, i.high as f32);
        }
        let _ = effects.push(Effect { code: info.code, parameters });
    }
    Model { effects, ..Model::base(base, friction) }
}

fn scenario(draw: &mut Draw) -> Scenario {
    let model = random_model(draw);
    let prism = || Shape::Prism { length_m: 0.1, side_m: 0.025 };
    let mass = draw.within(0.05, 0.4);
    let grip_n = draw.within(5.0, 35.0);
    let speed = draw.within(0.005, 0.025);
    let mut s = Scenario {
        scene: Scene {
            gravity_m_s2: [0.0, 0.0, -9.81],
            object: object(prism(), mass),
            fingers: Some(FingerContact::Disc { diameter_m: 0.02 }),
            pusher: None,
            support: None,
        },
        model,
        intent: Intent::Hold,
        velocity_m_s: Vec3::zeros(),
        turn_rad_s: Vec3::zeros(),
        pusher: None,
        pusher_velocity_m_s: Vec3::zeros(),
        grip_n,
        grip_rate_n_s: 0.0,
        object: at(0.3, 0.1, 0.2),
    };
    match draw.below(5) {
        0 => {
            let slope = draw.within(-0.35, 0.35);
            s.velocity_m_s = Vec3::new(-speed, 0.0, speed * slope);
            s.scene.pusher = Some(PusherContact::Plane);
            s.pusher = Some(at(0.3 - 0.0505, 0.1, 0.2));
            s.intent = Intent::Slide;
        }
        1 => {
            s.turn_rad_s = Vec3::new(0.0, draw.within(-0.35, 0.35), 0.0);
            s.scene.pusher = Some(PusherContact::Line { length_m: 0.028 });
            s.pusher = Some(at(0.3 - 0.05005, 0.1, 0.2 + draw.within(-0.01, 0.01)));
            s.velocity_m_s = Vec3::new(-draw.within(0.0, 0.002), 0.0, 0.0);
            s.intent = Intent::Pivot;
        }
        2 => {
            s.scene.object =
                object(Shape::Cylinder { length_m: 0.1, diameter_m: 0.025, across_flats_m: 0.025 }, mass);
            s.scene.pusher = Some(PusherContact::Plane);
            // +X of the platform's frame points up.
            let up = UnitQuaternion::rotation_between(&Vec3::x(), &Vec3::z())
                .unwrap_or_else(UnitQuaternion::identity);
            s.pusher = Some(Pose { position_m: Vec3::new(0.3, 0.1, 0.2 - 0.01251), rotation: up });
            s.velocity_m_s = Vec3::new(0.0, speed, -0.0002);
            s.model.friction.support = 2.5;
            s.grip_n *= 0.3;
            s.intent = Intent::Free;
        }
        3 => {
            s.velocity_m_s = Vec3::new(0.0, 0.0, draw.within(0.0, 0.1));
            s.scene.support = Some(SupportContact::Patch);
            s.grip_rate_n_s = -s.grip_n * draw.within(0.5, 1.8);
        }
        _ => {
            let leg = 0.15;
            let mut corners = Vec::new();
            for c in [[-leg / 3.0, -leg / 3.0], [2.0 * leg / 3.0, -leg / 3.0], [-leg / 3.0, 2.0 * leg / 3.0]]
            {
                let _ = corners.push(c);
            }
            s.scene.object = object(Shape::Polygon { vertices_m: corners, height_m: 0.02 }, 1.5);
            s.scene.fingers = None;
            s.scene.pusher = Some(PusherContact::Point { tip_radius_m: 0.005 });
            let mut feet = Vec::new();
            for f in [[-0.02, -0.02], [0.06, -0.03], [-0.03, 0.05]] {
                let _ = feet.push(f);
            }
            s.scene.support =
                Some(if draw.below(2) == 0 { SupportContact::Patch } else { SupportContact::Points(feet) });
            s.pusher = Some(at(0.3 - leg / 3.0 - 0.0055, 0.1 + draw.within(-0.03, 0.03), 0.2));
            s.pusher_velocity_m_s = Vec3::new(speed, 0.0, 0.0);
            s.intent = Intent::Free;
        }
    }
    s
}

/// Runs one trial through `tick`; `false` where scene or model is refused.
fn run_trial(
    draw: &mut Draw,
    formulation: Formulation,
    ticks: u32,
    horizon_s: f32,
    tick: &mut impl FnMut(&mut Predictor<f32>, &Sample<f32>),
) -> bool {
    let mut s = scenario(draw);
    s.model.formulation = formulation;
    let limits = Limits { horizon_s, ..Limits::default() };
    let Ok(mut predictor) = Predictor::new(s.scene.clone(), s.model.clone(), limits) else {
        return false;
    };
    let mut plan = Plan { start_s: 0.0, segments: Vec::new() };
    let narrow = |v: &Vec3<f32>| [v.x, v.y, v.z];
    let _ = plan.segments.push(Segment {
        duration_s: 10.0,
        velocity_m_s: narrow(&s.velocity_m_s),
        angular_rad_s: narrow(&s.turn_rad_s),
        grip_n: s.grip_n,
        intent: s.intent,
    });
    if draw.below(5) > 0 {
        predictor.set_plan(plan);
    }
    let dt = 0.004;
    let mut gripper = at(0.3, 0.1, 0.2);
    let mut pusher = s.pusher;
    for k in 0..ticks {
        let t_s = k as f32 * dt;
        if k > 0 {
            gripper.position_m += s.velocity_m_s * dt;
            gripper.rotation = turned(&gripper.rotation, &(s.turn_rad_s * dt));
            if let Some(p) = &mut pusher {
                p.position_m += s.pusher_velocity_m_s * dt;
            }
        }
        let mut wrench = [0.0; 6];
        for w in &mut wrench {
            *w = draw.within(-1.0, 1.0);
        }
        wrench[1] += s.grip_n;
        let noise = Vec3::new(draw.within(-3e-5, 3e-5), draw.within(-3e-5, 3e-5), draw.within(-3e-5, 3e-5));
        let seen = Pose { position_m: s.object.position_m + noise, ..s.object };
        let sample = Sample {
            t_s,
            grip_cmd_n: (s.grip_n + s.grip_rate_n_s * t_s).max(0.0),
            gripper: s.scene.fingers.is_some().then_some(gripper),
            object: (k == 0).then_some(seen),
            pusher,
            finger: [Some(wrench), (k % 7 != 3).then_some(wrench)],
        };
        tick(&mut predictor, &sample);
    }
    true
}

/// The trials of [`run`], each tick made by `tick`.
pub fn each(
    formulation: Formulation,
    seed: u32,
    ticks: u32,
    horizon_s: f32,
    mut tick: impl FnMut(&mut Predictor<f32>, &Sample<f32>),
) {
    trials(formulation, seed, ticks, horizon_s, &mut tick, |_| {});
}

fn trials(
    formulation: Formulation,
    seed: u32,
    ticks: u32,
    horizon_s: f32,
    tick: &mut impl FnMut(&mut Predictor<f32>, &Sample<f32>),
    mut refused: impl FnMut(u32),
) {
    let mut draw = Draw(seed);
    let mut done = 0;
    while done < ticks {
        let more = (ticks - done).min(TRIAL_TICKS);
        if !run_trial(&mut draw, formulation, more, horizon_s, tick) {
            refused(more);
        }
        done += more;
    }
}

/// Runs `ticks` ticks of varied trials; `horizon_s` 0 switches the look-ahead off.
pub fn run(formulation: Formulation, seed: u32, ticks: u32, horizon_s: f32) -> Digest {
    let digest = core::cell::Cell::new(Digest { hash: HASH_START, ..Digest::default() });
    let mut tick = |predictor: &mut Predictor<f32>, sample: &Sample<f32>| {
        let p = predictor.tick(sample);
        let mut d = digest.get();
        d.hash = p.hash(d.hash);
        d.ticks += 1;
        d.marked += u32::from(p.validity & validity::SOLVER != 0);
        d.cone_instead += u32::from(p.validity & validity::CONE_INSTEAD != 0);
        d.slipping += u32::from(p.finger[0].slip_speed_m_s > 0.0);
        digest.set(d);
    };
    trials(formulation, seed, ticks, horizon_s, &mut tick, |ticks| {
        // A refused model is part of the result as well.
        let mut d = digest.get();
        d.hash = (d.hash ^ 0xdead).wrapping_mul(0x0100_0193);
        d.ticks += ticks;
        digest.set(d);
    });
    digest.get()
}
