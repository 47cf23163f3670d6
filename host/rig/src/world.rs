//! One trial's world: the object, the jaw, the pusher and the table, stepped together.

use nalgebra::Vector3;

use super::body::Body;
use super::drive::Drive;
use super::fingers::{Jaw, Loading};
use super::surroundings::Obstacle;
use super::truth::{CABLE_AT_M, CABLE_WAY, Truth};

/// Rest before the recording, in which springs and jaw settle, s.
const SETTLING_S: f64 = 0.08;
/// Time over which the force sensors average before a sample, s.
const SENSOR_WINDOW_S: f64 = 1e-3;

/// True values at one sample, before any sensor.
#[derive(Clone, Copy, Debug)]
pub struct Exact {
    /// s.
    pub t_s: f64,
    /// Commanded grip, N.
    pub grip_n: f64,
    /// Gripper position and quaternion (w, x, y, z).
    pub gripper: ([f64; 3], [f64; 4]),
    /// Object frame.
    pub object: ([f64; 3], [f64; 4]),
    /// Rod position where there is one.
    pub rod: Option<[f64; 3]>,
    /// Fingers' wrenches, gripper axes about patch centres.
    pub finger: [[f64; 6]; 2],
    /// Pusher's wrench, world axes about its told origin at the start.
    pub pusher: [f64; 6],
    /// Table's force, world axes, N.
    pub support: [f64; 3],
    /// Kinetic energy, J.
    pub kinetic_j: f64,
}

/// Everything that moves and touches.
pub struct World {
    /// The object.
    pub body: Body,
    /// The jaw, where something is grasped.
    pub jaw: Option<Jaw>,
    /// The pusher.
    pub pusher: Option<Obstacle>,
    /// About where the pusher's torque is measured, m.
    pub pusher_reference_m: Vector3<f64>,
    /// The table.
    pub support: Option<Obstacle>,
    /// What is really so.
    pub truth: Truth,
}

#[derive(Clone, Copy, Default)]
struct Forces {
    finger: [[f64; 6]; 2],
    pusher: Loading,
    support: Loading,
}

impl World {
    /// Runs the drive and samples every `period_s`, with steps of about `dt_s`. After each sample `control` sees all so
    /// far and may command another grip force of each finger, N; `None`: as the drive has it.
    pub fn run(
        &mut self,
        mut drive: Drive,
        period_s: f64,
        dt_s: f64,
        control: &mut dyn FnMut(&[Exact]) -> Option<f64>,
    ) -> Vec<Exact> {
        let steps = (period_s / dt_s).round().max(1.0) as usize;
        let dt = period_s / steps as f64;
        let window = ((SENSOR_WINDOW_S / dt).round() as usize).clamp(1, steps);
        let start_x = self.along_x(&drive);
        let settling = (SETTLING_S / dt) as usize;
        let mut mean = Averager::default();
        for i in 0..settling {
            let forces = self.step(&mut drive, -dt, start_x, dt);
            if i + window >= settling {
                mean.add(&forces, &self.body.com_m);
            }
        }
        let count = (drive.duration_s / period_s).round() as usize;
        let mut samples = Vec::with_capacity(count + 1);
        for i in 0..=count {
            let t = i as f64 * period_s;
            samples.push(self.sample(&drive, t, &mean.take(self.pusher_reference_m)));
            drive.commanded_n = control(&samples);
            for j in 0..steps {
                let t = t + j as f64 * dt;
                drive.gripper.advance(t, dt);
                if let Some(rod) = &mut drive.rod {
                    rod.advance(t, dt);
                }
                let forces = self.step(&mut drive, t, start_x, dt);
                if j + window >= steps {
                    mean.add(&forces, &self.body.com_m);
                }
            }
        }
        samples
    }

    /// Where the object is along X: in the gripper where there is one, else in the world, m.
    fn along_x(&self, drive: &Drive) -> f64 {
        match self.jaw {
            Some(_) => {
                let gripper = &drive.gripper;
                (gripper.attitude().inverse() * (self.body.com_m - gripper.origin_m)).x
            }
            None => self.body.com_m.x,
        }
    }

    fn step(&mut self, drive: &mut Drive, t_s: f64, start_x: f64, dt: f64) -> Forces {
        let mut forces = Forces::default();
        let mut total = Loading {
            force_n: Vector3::from(self.truth.gravity_m_s2) * self.body.mass_kg,
            torque_nm: Vector3::zeros(),
        };
        total.force_n.y += self.truth.lateral_pull_n_m * (self.along_x(drive) - start_x);
        let body = &self.body;
        let at = |point_m: Vector3<f64>, force_n: Vector3<f64>| {
            let lever = body.attitude * (point_m - body.com_offset_m);
            Loading { force_n, torque_nm: lever.cross(&force_n) }
        };
        total += at(CABLE_AT_M.into(), Vector3::from(CABLE_WAY) * self.truth.external_force_n);
        for load in &drive.loads {
            total += at(load.point_m, load.force_n * load.course.at(t_s));
        }
        if let Some(jaw) = &mut self.jaw {
            let (loading, wrenches) = jaw.press(
                &self.body,
                &drive.gripper,
                drive.grip_at(t_s),
                drive.finger_friction.at(t_s),
                &self.truth,
                dt,
            );
            total += loading;
            forces.finger = wrenches;
        }
        if let Some(pusher) = &mut self.pusher {
            forces.pusher = pusher.press(&self.body, drive.rod.as_ref(), dt);
            total += forces.pusher;
        }
        if let Some(support) = &mut self.support {
            forces.support = support.press(&self.body, None, dt);
            total += forces.support;
        }
        self.body.advance(&total.force_n, &total.torque_nm, dt);
        forces
    }

    fn sample(&self, drive: &Drive, t_s: f64, mean: &MeanForces) -> Exact {
        let wxyz = |q: &nalgebra::UnitQuaternion<f64>| [q.w, q.i, q.j, q.k];
        Exact {
            t_s,
            grip_n: drive.grip_at(t_s),
            gripper: (drive.gripper.origin_m.into(), wxyz(&drive.gripper.attitude())),
            object: (self.body.origin_m().into(), wxyz(&self.body.attitude)),
            rod: drive.rod.as_ref().map(|r| r.origin_m.into()),
            finger: mean.finger,
            pusher: mean.pusher,
            support: mean.support,
            kinetic_j: self.body.kinetic_energy_j(),
        }
    }
}

/// Collects forces over the sensors' window.
#[derive(Default)]
struct Averager {
    count: f64,
    finger: [[f64; 6]; 2],
    pusher: Loading,
    support: Vector3<f64>,
    com: Vector3<f64>,
}

struct MeanForces {
    finger: [[f64; 6]; 2],
    pusher: [f64; 6],
    support: [f64; 3],
}

impl Averager {
    fn add(&mut self, forces: &Forces, com: &Vector3<f64>) {
        self.count += 1.0;
        for (sum, new) in self.finger.iter_mut().flatten().zip(forces.finger.iter().flatten()) {
            *sum += new;
        }
        self.pusher += forces.pusher;
        // The torque moves with its reference point, so the point is averaged beside it.
        self.com += com;
        self.support += forces.support.force_n;
    }

    /// Means so far, with the pusher's torque taken about `reference`; starts anew.
    fn take(&mut self, reference: Vector3<f64>) -> MeanForces {
        let share = 1.0 / self.count.max(1.0);
        let force = self.pusher.force_n * share;
        let com = self.com * share;
        let torque = self.pusher.torque_nm * share + (com - reference).cross(&force);
        let means = MeanForces {
            finger: self.finger.map(|w| w.map(|x| x * share)),
            pusher: [force.x, force.y, force.z, torque.x, torque.y, torque.z],
            support: (self.support * share).into(),
        };
        *self = Self::default();
        means
    }
}
