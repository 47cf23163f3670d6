//! The paper's scenes, driven in world coordinates through `track` as a recorded trial is.
#![allow(dead_code)]

pub mod grasps;

use nalgebra::{UnitQuaternion, Vector3};
use stickslip_shared::contact::SLOTS;
use stickslip_shared::model::*;
use stickslip_shared::real::{Real, Vec3};
use stickslip_shared::shape::inertia;
use stickslip_shared::step::{Drive, State, StepOutput, step};
use stickslip_shared::track::{Pose, Poses, drive_between, support_pose};

pub const DT_S: f64 = 0.004;
pub const G: f64 = 9.81;

pub fn object<R: Real>(shape: Shape<R>, mass_kg: f64) -> Object<R> {
    let mass_kg = R::of(mass_kg);
    Object { inertia_kg_m2: inertia(&shape, mass_kg), shape, mass_kg }
}

/// The paper's square prism of aluminium.
pub fn obj4<R: Real>() -> Object<R> {
    object(Shape::Prism { length_m: R::of(0.1), side_m: R::of(0.025) }, 0.2005)
}

/// The paper's cylinder of aluminium.
pub fn obj1<R: Real>() -> Object<R> {
    let (l, d) = (R::of(0.1), R::of(0.025));
    object(Shape::Cylinder { length_m: l, diameter_m: d, across_flats_m: d }, 0.158)
}

pub fn gripped<R: Real>(object: Object<R>, pusher: Option<PusherContact<R>>) -> Scene<R> {
    Scene {
        gravity_m_s2: [R::zero(), R::zero(), R::of(-G)],
        object,
        fingers: Some(FingerContact::Disc { diameter_m: R::of(0.02) }),
        pusher,
        support: None,
    }
}

pub fn hard<R: Real>(finger: f64, pusher: f64, support: f64) -> Model<R> {
    let friction = Friction { finger: R::of(finger), pusher: R::of(pusher), support: R::of(support) };
    Model::base(Base::Hard, friction)
}

/// The hard model, whose friction enters the step as said.
pub fn hard_by<R: Real>(formulation: Formulation, finger: f64, pusher: f64, support: f64) -> Model<R> {
    Model { formulation, ..hard(finger, pusher, support) }
}

/// Makes two tests of each function: with the exact cone, and with friction pyramids.
#[macro_export]
macro_rules! on_both_formulations {
    ($($test:ident),* $(,)?) => {
        mod cone {
            $(#[test] fn $test() { super::$test(stickslip_shared::model::Formulation::Cone) })*
        }
        mod lcp {
            $(#[test] fn $test() { super::$test(stickslip_shared::model::Formulation::Lcp) })*
        }
    };
}

pub fn at<R: Real>(x: f64, y: f64, z: f64) -> Vec3<R> {
    Vec3::new(R::of(x), R::of(y), R::of(z))
}

/// Turned about an axis.
pub fn turn<R: Real>(axis: [f64; 3], angle_rad: f64) -> UnitQuaternion<R> {
    UnitQuaternion::from_scaled_axis(at(axis[0], axis[1], axis[2]) * R::of(angle_rad))
}

pub fn pose<R: Real>(position_m: Vec3<R>, rotation: UnitQuaternion<R>) -> Pose<R> {
    Pose { position_m, rotation }
}

/// A scene with prescribed motions, in world coordinates.
pub struct Play<'a, R: Real> {
    pub scene: Scene<R>,
    pub model: Model<R>,
    pub gripper: &'a dyn Fn(f64) -> Pose<R>,
    pub pusher: Option<&'a dyn Fn(f64) -> Pose<R>>,
    /// World, at the start.
    pub object: Pose<R>,
    pub grip_n: f64,
    pub seconds: f64,
}

/// What a check sees after each step.
pub struct Seen<'a, R: Real> {
    pub t_s: f64,
    pub state: &'a State<R, SLOTS>,
    pub out: &'a StepOutput<R, SLOTS>,
    /// Object in the world.
    pub world: Pose<R>,
    /// Gripper axes to world axes at the beginning of the step.
    pub axes: UnitQuaternion<R>,
    /// `m a` less weight less the sum of contact forces, world axes, N.
    pub imbalance_n: Vector3<f64>,
}

impl<R: Real> Play<'_, R> {
    pub fn run(&self, mut each: impl FnMut(&Seen<'_, R>)) -> State<R, SLOTS> {
        let support = support_pose(&self.scene, &self.object);
        let poses = |t: f64| Poses {
            t_s: R::of(t),
            carrier: (self.gripper)(t),
            pusher: self.pusher.map(|p| p(t)),
            support,
        };
        let reference = self.pusher.map_or_else(Vec3::zeros, |p| p(0.0).position_m);
        let n = (self.seconds / DT_S).round() as usize;
        let drive = |k: usize| {
            let (a, b) = (poses(k as f64 * DT_S), poses((k + 1) as f64 * DT_S));
            let mut d = drive_between(&a, &b, &reference, R::of(self.grip_n), R::zero()).unwrap();
            d.dt_s = R::of(DT_S);
            d
        };
        let local = poses(0.0).carrier.to_local(&self.object);
        let mut state = State::held(&self.scene, &self.model, &drive(0), local.position_m, local.rotation);
        let mut before = wide(&poses(0.0).carrier.rotation.transform_vector(&state.absolute_m_s));
        for k in 0..n {
            let d = drive(k);
            let out = step(&self.scene, &self.model, &mut state, &d);
            let after = wide(&d.carrier.transform_vector(&state.absolute_m_s));
            let mass = self.scene.object.mass_kg.to_f64();
            let mut sum = Vector3::from(self.scene.gravity_m_s2.map(Real::to_f64)) * mass;
            for (c, f) in out.contacts.iter().zip(&out.force_n) {
                let force = c.axes[0] * f[0] + c.axes[1] * f[1] + c.axes[2] * f[2];
                sum += wide(&d.carrier.transform_vector(&force));
            }
            let imbalance_n = (after - before) * (mass / DT_S) - sum;
            before = after;
            let end = poses((k + 1) as f64 * DT_S).carrier;
            let world = end.to_world(&pose(state.position_m, state.rotation));
            let t_s = (k + 1) as f64 * DT_S;
            each(&Seen { t_s, state: &state, out: &out, world, axes: d.carrier, imbalance_n });
        }
        state
    }
}

pub fn wide<R: Real>(v: &Vec3<R>) -> Vector3<f64> {
    Vector3::new(v.x.to_f64(), v.y.to_f64(), v.z.to_f64())
}

/// The paper's linear push: the gripper carries the object against a fixed plane along its
/// own -X, which is inclined by `slope_rad` (positive: the push goes uphill).
pub fn linear_push<R: Real>(
    model: Model<R>,
    grip_n: f64,
    speed_m_s: f64,
    slope_rad: f64,
    seconds: f64,
    each: impl FnMut(&Seen<'_, R>),
) -> State<R, SLOTS> {
    let frame = turn::<R>([0.0, 1.0, 0.0], slope_rad);
    let back = frame.transform_vector(&at(-1.0, 0.0, 0.0));
    let play = Play {
        scene: gripped(obj4(), Some(PusherContact::Plane)),
        model,
        gripper: &|t| pose(back * R::of(speed_m_s * t), frame),
        pusher: Some(&|_| pose(back * R::of(0.0505), frame)),
        object: pose(Vec3::zeros(), frame),
        grip_n,
        seconds,
    };
    play.run(each)
}

/// A drive of bodies at rest.
pub fn still(dt_s: f64, grip_n: f64) -> Drive<f64> {
    Drive {
        dt_s,
        carrier: UnitQuaternion::identity(),
        carrier_m_s: Vec3::zeros(),
        carrier_rad_s: Vec3::zeros(),
        pusher: None,
        support: None,
        grip_n,
        trial: 0.0,
    }
}

/// Nearly normal numbers of unit variance: sums of four uniform ones.
pub struct Noise(pub u32);

impl Noise {
    pub fn next(&mut self) -> f32 {
        let mut sum = 0.0;
        for _ in 0..4 {
            self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            sum += (self.0 >> 8) as f32 / 16_777_216.0 - 0.5;
        }
        sum * 1.732
    }
}

/// A bar of this mass between discs, table and plate.
pub fn bar(mass_kg: f64) -> Scene<f32> {
    Scene {
        gravity_m_s2: [0.0, 0.0, -9.81],
        object: object(Shape::Prism { length_m: 0.1, side_m: 0.025 }, mass_kg),
        fingers: Some(FingerContact::Disc { diameter_m: 0.01 }),
        pusher: Some(PusherContact::Plane),
        support: Some(SupportContact::Patch),
    }
}
