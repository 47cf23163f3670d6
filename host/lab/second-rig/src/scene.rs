//! The world that a reality makes of a trial.

use nalgebra::{UnitQuaternion, Vector3};
use serde::Serialize;

use crate::physics::body::{Body, box_inertia, cylinder_inertia};
use crate::physics::foundation::Foundation;
use crate::physics::friction::Law;
use crate::physics::layout::{self, Element, Profile};
use crate::physics::motion::Motion;
use crate::physics::patch::{Patch, Shear};
use crate::physics::surface::{Geometry, Surface};
use crate::physics::world::{Cable, Grasp, Others, Tool, World};
use crate::random::{normal, stream};
use crate::reality::{Counterpart, Reality};
use crate::trial::{PusherKind, TrialSpec, upwards};

/// True numbers of one run, for the key.
#[derive(Clone, Debug, Serialize)]
pub struct RunTruth {
    /// Finger 1, finger 2.
    pub mu_finger: [f64; 2],
    /// Pusher.
    pub mu_pusher: f64,
    /// Table.
    pub mu_table: f64,
    /// True mass at the start, kg.
    pub mass_kg: f64,
}

/// Mass for which damping ratios are meant, kg.
const TYPICAL_KG: f64 = 0.2;

/// The world of a trial. `rate_hz` is that of the record; the run's scatter comes from `seed` and
/// the trial's name.
pub fn world(reality: &Reality, trial: &TrialSpec, seed: u64) -> (World, RunTruth) {
    let rng = &mut stream(seed, &format!("run {}", trial.id));
    let r = reality;
    let spec = &r.objects[trial.object];
    let scatter = &r.scatter;
    let worn = 1.0 - r.wear * trial.progress;
    let finger_factor = (scatter.friction * normal(rng)).exp() * worn;
    let pusher_factor = (scatter.other_friction * normal(rng)).exp();
    // Where nothing is grasped it is the table that wears.
    let table_worn = if trial.grasped { 1.0 } else { worn };
    let table_factor = (scatter.other_friction * normal(rng)).exp() * table_worn;
    let half = Vector3::new(spec.length_m, spec.side_m, spec.side_m) * 0.5;
    let surface = Surface { half, round: spec.round, taper: r.taper, wave: r.wave };
    let mass_kg = spec.mass_kg * r.mass_factor;
    let inertia = if spec.round {
        cylinder_inertia(mass_kg, spec.length_m, spec.side_m)
    } else {
        box_inertia(mass_kg, &(half * 2.0))
    };
    let place = Vector3::new(normal(rng), 0.0, 0.0) * scatter.place_m;
    // A cylinder that lies on its platform keeps its height; so does a box on a table.
    let resting = trial.table || matches!(trial.pusher, Some((PusherKind::Platform, _)));
    let lift = if resting { 0.0 } else { normal(rng) * scatter.place_m };
    let angle = normal(rng) * scatter.angle_rad;
    let turn = if !trial.grasped {
        UnitQuaternion::new(Vector3::z() * angle)
    } else if resting {
        UnitQuaternion::identity()
    } else {
        UnitQuaternion::new(Vector3::y() * angle)
    };
    let centre = Vector3::new(r.centre_m[0], r.centre_m[1], 0.0);
    let origin = trial.start + place + Vector3::z() * lift;
    let body = Body::at_rest(mass_kg, inertia, centre, origin, turn);

    let tilt = UnitQuaternion::new(Vector3::new(r.gravity_tilt[0], r.gravity_tilt[1], 0.0));
    let mut gripper = trial.gripper.clone();
    gripper.ripple = r.ripple;
    let shift = [[0; 2]; 2].map(|p: [i32; 2]| p.map(|_| scatter.pressure_m * normal(rng)));
    let grasp = trial.grasped.then(|| {
        let pad = |k: usize| {
            let sign = if k == 0 { 1.0 } else { -1.0 };
            let mut law = r.finger;
            law.mu *= finger_factor * (1.0 + sign * r.mismatch);
            finger_patch(r, law, k, sign, spec.round, shift[k])
        };
        Grasp {
            pads: [pad(0), pad(1)],
            jaw: r.jaw,
            command: trial.grip.clone(),
            wetness: trial.wetness.clone(),
        }
    });
    let pusher = trial.pusher.as_ref().map(|(kind, motion)| {
        let mut patch = pusher_patch(r, *kind, &surface);
        patch.law.mu *= pusher_factor;
        let mut motion = motion.clone();
        let (pitch, yaw) = (r.plate_tilt[0], r.plate_tilt[1]);
        let tilt = match kind {
            // An edge can only lean: about its own X that lifts one end, about Z it is skew.
            PusherKind::Edge(_) => Vector3::new(pitch, 0.0, yaw),
            PusherKind::Rod(_) => Vector3::zeros(),
            PusherKind::Plate | PusherKind::Platform => Vector3::new(0.0, pitch, yaw),
        };
        motion.rotation *= UnitQuaternion::new(tilt);
        motion.ripple = r.ripple;
        Tool { patch, motion }
    });
    let support = trial.table.then(|| {
        let mut patch = table_patch(r, &surface);
        patch.law.mu *= table_factor;
        let table = trial.start - Vector3::z() * half.z;
        Tool { patch, motion: Motion::fixed(Vector3::new(0.0, 0.0, table.z), upwards()) }
    });
    let cable = r.cable.map(|(pull_n, stiffness, direction)| {
        let at = Vector3::new(half.x, 0.0, 0.0);
        let length_m = 0.35;
        Cable { anchor: origin + at + direction * length_m, at, pull_n, stiffness, length_m }
    });
    let truth = RunTruth {
        mu_finger: [
            r.finger.mu * finger_factor * (1.0 + r.mismatch),
            r.finger.mu * finger_factor * (1.0 - r.mismatch),
        ],
        mu_pusher: r.pusher.law.mu * pusher_factor,
        mu_table: r.table.law.mu * table_factor,
        mass_kg,
    };
    let world = World {
        gravity: tilt * Vector3::new(0.0, 0.0, -9.81),
        body,
        added_kg: trial.added_kg.clone(),
        surface,
        grasp,
        pusher,
        support,
        others: Others {
            knocks: trial.knocks.clone(),
            spring_n_m: r.spring_n_m,
            spring_rest: origin - trial.gripper.start,
            cable,
            magnet: r.magnet.map(|(pull, place)| (trial.start + place, pull)),
        },
        gripper,
        settle_s: 0.4,
        duration_s: trial.duration_s,
        rate_hz: r.sensors.rate_hz,
        window_s: r.sensors.window_s,
        step_s: None,
        after_drop_s: 0.15,
    };
    (world, truth)
}

fn finger_patch(r: &Reality, law: Law, k: usize, sign: f64, round: bool, shift: [f64; 2]) -> Patch {
    let pad = &r.pad;
    // The radius that is told is that of the disc with uniform pressure and the same torsional limit:
    // a pressure profile alone is no hidden effect.
    let radius = pad.radius_m * pad.radius_factor * (2.0 / 3.0) / layout::torsion_share(pad.profile);
    let (elements, geometry) = if round {
        // A disc on a cylinder touches along the generator.
        let geometry = Geometry::CylinderOnPlane { normal: Vector3::y() * -sign, distance: 0.0 };
        (layout::line(Vector3::x(), 2.0 * radius, 15, pad.profile), geometry)
    } else {
        let geometry = Geometry::ToolOnFace { axis: 1, sign };
        (layout::disc(radius, pad.profile, 0.4 + k as f64), geometry)
    };
    let offset = [pad.offset_m[k][0] + shift[0], pad.offset_m[k][1] + shift[1]];
    let elements = layout::shift_pressure(elements, offset);
    let stiffness = pad.shear_n_m * pad.normal_ratio;
    let foundation = Foundation {
        stiffness,
        damping: pad.damping_ratio * (stiffness * TYPICAL_KG).sqrt(),
        relaxing: stiffness * pad.relaxing_ratio,
        relaxation_s: pad.relaxation_s,
        tension_n: law.adhesion_n,
    };
    let shear = if pad.shear_per_load {
        Shear::PerLoad(pad.shear_n_m / pad.reference_n)
    } else {
        Shear::Fixed(pad.shear_n_m)
    };
    let damping_s = pad.damping_ratio * (2.0 * TYPICAL_KG / pad.shear_n_m).sqrt();
    Patch::new(elements, law, foundation, shear, damping_s, geometry)
}

fn counterpart(c: &Counterpart, elements: Vec<Element>, geometry: Geometry) -> Patch {
    let foundation = Foundation {
        stiffness: c.normal_n_m,
        damping: 2.0 * c.damping_ratio * (c.normal_n_m * TYPICAL_KG).sqrt(),
        relaxing: 0.0,
        relaxation_s: 1.0,
        tension_n: c.law.adhesion_n,
    };
    let damping_s = 2.0 * c.damping_ratio * (TYPICAL_KG / c.shear_n_m).sqrt();
    Patch::new(elements, c.law, foundation, Shear::Fixed(c.shear_n_m), damping_s, geometry)
}

fn pusher_patch(r: &Reality, kind: PusherKind, surface: &Surface) -> Patch {
    let h = surface.half;
    let plane = Geometry::ObjectOnPlane { normal: Vector3::x(), distance: 0.0 };
    match kind {
        PusherKind::Plate => {
            let sides = [Vector3::y() * h.y, Vector3::z() * h.z];
            counterpart(&r.pusher, layout::plate(-Vector3::x() * h.x, sides), plane)
        }
        PusherKind::Edge(length) => {
            let elements = layout::line(Vector3::y(), length, 11, Profile::Uniform);
            counterpart(&r.pusher, elements, Geometry::ToolOnFace { axis: 2, sign: -1.0 })
        }
        PusherKind::Platform => {
            let elements = layout::line(Vector3::x(), 2.0 * h.x, 13, Profile::Uniform);
            let geometry = Geometry::CylinderOnPlane { normal: Vector3::x(), distance: 0.0 };
            let mut patch = counterpart(&r.pusher, elements, geometry);
            patch.rolling_arm_m = r.rolling_arm_m;
            patch
        }
        PusherKind::Rod(radius_m) => {
            let element = Element { position: Vector3::zeros(), area: 1.0, load: 1.0 };
            counterpart(&r.pusher, vec![element], Geometry::Rod { radius_m })
        }
    }
}

fn table_patch(r: &Reality, surface: &Surface) -> Patch {
    let h = surface.half;
    let elements = match &r.feet_m {
        Some(feet) => {
            let foot =
                |p: &[f64; 2]| Element { position: Vector3::new(p[0], p[1], -h.z), area: 1.0, load: 1.0 };
            layout::normalised(feet.iter().map(foot).collect())
        }
        None => {
            let sides = [Vector3::x() * h.x, Vector3::y() * h.y];
            layout::rectangle(-Vector3::z() * h.z, sides)
        }
    };
    counterpart(&r.table, elements, Geometry::ObjectOnPlane { normal: Vector3::x(), distance: 0.0 })
}
