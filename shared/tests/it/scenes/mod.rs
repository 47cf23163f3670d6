//! Scenes with known answers in which effects are tried.
#![allow(dead_code)]

use nalgebra::UnitQuaternion;
use stickslip_shared::contact::SLOTS;
use stickslip_shared::effects::{Effect, Environment, StepContext};
use stickslip_shared::model::*;
use stickslip_shared::real::{Real, Rotation, Vec3};
use stickslip_shared::shape::inertia;
use stickslip_shared::step::{Drive, Moving, State, StepOutput, step, support_under};

pub type Out<R> = StepOutput<R, SLOTS>;

/// One run: what is there, how it is driven, for how long.
#[derive(Clone)]
pub struct Run<R: Real> {
    pub scene: Scene<R>,
    pub model: Model<R>,
    pub drive: Drive<R>,
    pub rotation: Rotation<R>,
    /// Angular velocity of the object relative to the carrier at the start.
    pub turning_rad_s: Vec3<R>,
    /// Velocity of the object relative to the carrier at the start.
    pub moving_m_s: Vec3<R>,
    pub steps: usize,
}

/// Every step's output and the last state.
pub struct Record<R: Real> {
    pub outputs: Vec<Out<R>>,
    pub state: State<R, SLOTS>,
}

impl<R: Real> Record<R> {
    pub fn last(&self) -> &Out<R> {
        self.outputs.last().unwrap()
    }

    /// Largest size of channel `k` of the pusher.
    pub fn peak(&self, k: usize) -> f64 {
        self.outputs.iter().map(|o| o.reading.pusher[k].to_f64().abs()).fold(0.0, f64::max)
    }
}

impl<R: Real> Run<R> {
    pub fn play(&self) -> Record<R> {
        let mut drive = self.drive;
        let mut state = State::held(&self.scene, &self.model, &drive, Vec3::zeros(), self.rotation);
        state.velocity = [
            self.moving_m_s.x,
            self.moving_m_s.y,
            self.moving_m_s.z,
            self.turning_rad_s.x,
            self.turning_rad_s.y,
            self.turning_rad_s.z,
            R::zero(),
        ];
        state.absolute_m_s += self.moving_m_s;
        state.absolute_rad_s += self.turning_rad_s;
        let mut outputs = Vec::new();
        for _ in 0..self.steps {
            outputs.push(step(&self.scene, &self.model, &mut state, &drive));
            if let Some(p) = &mut drive.pusher {
                p.position_m += p.velocity_m_s * drive.dt_s;
                p.reference_m = p.position_m;
            }
        }
        Record { outputs, state }
    }

    /// With effect `id`; the parameters not given are zero.
    pub fn with(mut self, id: &str, parameters: &[f64]) -> Self {
        let mut effect = Effect::neutral(id).unwrap();
        for (to, p) in effect.parameters.iter_mut().zip(parameters) {
            *to = R::of(*p);
        }
        self.model.effects.push(effect).unwrap();
        self
    }
}

fn v<R: Real>(x: f64, y: f64, z: f64) -> Vec3<R> {
    Vec3::new(R::of(x), R::of(y), R::of(z))
}

fn fixed<R: Real>(position_m: Vec3<R>) -> Moving<R> {
    Moving {
        position_m,
        rotation: UnitQuaternion::identity(),
        velocity_m_s: Vec3::zeros(),
        angular_rad_s: Vec3::zeros(),
        reference_m: position_m,
    }
}

/// The prism of the paper in a gripper at rest: grip 20 N, friction 0.4.
pub fn hold<R: Real>() -> Run<R> {
    let shape = Shape::Prism { length_m: R::of(0.1), side_m: R::of(0.025) };
    let mass_kg = R::of(0.2005);
    Run {
        scene: Scene {
            gravity_m_s2: [R::zero(), R::zero(), R::of(-9.81)],
            object: Object { inertia_kg_m2: inertia(&shape, mass_kg), shape, mass_kg },
            fingers: Some(FingerContact::Disc { diameter_m: R::of(0.02) }),
            pusher: None,
            support: None,
        },
        model: Model::base(
            Base::Hard,
            Friction { finger: R::of(0.4), pusher: R::of(0.25), support: R::of(0.3) },
        ),
        drive: Drive {
            dt_s: R::of(0.004),
            carrier: UnitQuaternion::identity(),
            carrier_m_s: Vec3::zeros(),
            carrier_rad_s: Vec3::zeros(),
            pusher: None,
            support: None,
            grip_n: R::of(20.0),
            trial: R::of(100.0),
        },
        rotation: UnitQuaternion::identity(),
        turning_rad_s: Vec3::zeros(),
        moving_m_s: Vec3::zeros(),
        steps: 50,
    }
}

/// The paper's linear push: the gripper moves towards -X, the object slides towards +X in
/// it, after a gap of half a millimetre.
pub fn push<R: Real>(speed_m_s: f64) -> Run<R> {
    let mut run = hold();
    run.scene.pusher = Some(PusherContact::Plane);
    run.drive.carrier_m_s = v(-speed_m_s, 0.0, 0.0);
    let mut plate = fixed(v(-0.0505, 0.0, 0.0));
    plate.velocity_m_s = v(speed_m_s, 0.0, 0.0);
    run.drive.pusher = Some(plate);
    run.steps = 200;
    run
}

/// The push with neither weight nor friction at the pusher: pure sliding along X.
pub fn pure_push<R: Real>(speed_m_s: f64) -> Run<R> {
    let mut run = push(speed_m_s);
    run.scene.gravity_m_s2 = [R::zero(); 3];
    run.model.friction.pusher = R::zero();
    run
}

/// No weight, spinning about the fingers' axis in their grip.
pub fn spin<R: Real>(fingers: FingerContact<R>) -> Run<R> {
    let mut run = hold();
    run.scene.gravity_m_s2 = [R::zero(); 3];
    run.scene.fingers = Some(fingers);
    run.turning_rad_s = v(0.0, 60.0, 0.0);
    run.steps = 3;
    run
}

/// Gripper turning about its Y while a line edge holds the object's end: the paper's pivot.
pub fn pivot<R: Real>() -> Run<R> {
    let mut run = hold();
    run.scene.pusher = Some(PusherContact::Line { length_m: R::of(0.028) });
    run.drive.carrier_m_s = v(-0.01, 0.0, 0.0);
    let mut edge = fixed(v(-0.0502, 0.0, 0.008));
    edge.velocity_m_s = v(0.01, 0.0, 0.0);
    run.drive.pusher = Some(edge);
    run.steps = 200;
    run
}

/// A cylinder of radius 20 mm rolling freely along Y on a level table.
pub fn roll<R: Real>() -> Run<R> {
    let shape =
        Shape::Cylinder { length_m: R::of(0.1), diameter_m: R::of(0.04), across_flats_m: R::of(0.04) };
    let mut run = hold();
    let mass_kg = R::of(0.3);
    run.scene.object = Object { inertia_kg_m2: inertia(&shape, mass_kg), shape, mass_kg };
    run.scene.fingers = None;
    run.scene.support = Some(SupportContact::Patch);
    run.drive.support = Some(support_under(&run.scene, &Vec3::zeros(), &run.rotation, &v(0.0, 0.0, 1.0)));
    run.moving_m_s = v(0.0, 0.2, 0.0);
    run.turning_rad_s = v(-10.0, 0.0, 0.0);
    run.steps = 100;
    run
}

/// A prism pushed on a table by a rod off its middle.
pub fn planar<R: Real>() -> Run<R> {
    let mut run = hold();
    run.scene.fingers = None;
    run.scene.pusher = Some(PusherContact::Point { tip_radius_m: R::of(0.005) });
    run.scene.support = Some(SupportContact::Patch);
    run.drive.support = Some(support_under(&run.scene, &Vec3::zeros(), &run.rotation, &v(0.0, 0.0, 1.0)));
    let mut rod = fixed(v(0.02, -0.0176, 0.0));
    rod.velocity_m_s = v(0.0, 0.02, 0.0);
    run.drive.pusher = Some(rod);
    run
}

/// Every scene, by name.
pub fn all<R: Real>() -> [(&'static str, Run<R>); 6] {
    let disc = FingerContact::Disc { diameter_m: R::of(0.02) };
    [
        ("hold", hold()),
        ("push", push(0.01)),
        ("spin", spin(disc)),
        ("pivot", pivot()),
        ("roll", roll()),
        ("planar", planar()),
    ]
}

/// What a hook sees of an object at rest in the gripper.
pub fn at_rest_context(dt_s: f64) -> StepContext<f64> {
    let still = Vec3::zeros();
    let none = Environment { normal: still, along_y: still, turning_rad_s: still, angular_rad_s: still };
    StepContext {
        time_s: 0.0,
        dt_s,
        trial: 0.0,
        grip_cmd_n: 20.0,
        grip_rate_n_s: 0.0,
        position_m: Vec3::zeros(),
        rotation: UnitQuaternion::identity(),
        carrier: UnitQuaternion::identity(),
        slip_m: [0.0; 4],
        slip_speed_m_s: [0.0; 4],
        load_n: [20.0, 20.0, 0.0, 0.0],
        load_rate_n_s: [0.0; 4],
        environment: [none; 2],
        stretch_m: [[0.0; 2]; 2],
        fingers: Some(FingerContact::Disc { diameter_m: 0.02 }),
        pusher: None,
        whole_face: false,
        velocity_m_s: Vec3::zeros(),
        angular_rad_s: Vec3::zeros(),
    }
}
