//! Objects at rest between the fingers, with as many contact points as are asked for: scenes in which what a warm
//! step costs does not depend on a recording.

use stickslip_device::package::Package;
use stickslip_shared::model::{FingerContact, Model, Object, PusherContact, Scene, Shape, SupportContact};
use stickslip_shared::predictor::{Intent, Plan, Segment};
use stickslip_shared::shape::inertia;
use stickslip_shared::wire::{Pose, Sample};

const MASS_KG: f32 = 0.2;
const GRIP_N: f32 = 20.0;
/// Of motion capture, along each axis.
pub const NOISE_M: f32 = 2e-5;

/// What an object is held by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Held {
    /// A prism of 100 x 25 mm between discs, a flat pusher at its end: 16 points.
    Prism,
    /// A prism of eight sides that stands on a table between discs, a plate on its upper face: 36 points.
    Octagon,
    /// A prism on a table between discs, a plate on its upper face: 32 points.
    Plate,
    /// A bar of eight sides that lies on a table between discs, a plate at its end: 36 points, the most of any scene.
    Bar,
}

impl Held {
    /// Contact points, all within reach of a step.
    #[must_use]
    pub fn points(self) -> usize {
        match self {
            Self::Prism => 16,
            Self::Octagon | Self::Bar => 36,
            Self::Plate => 32,
        }
    }

    /// Samples every 4 ms of an object at rest; `noise_m` moves what is measured in each, evenly up to so much.
    #[must_use]
    pub fn package(self, model: &Model<f64>, samples: u32, noise_m: f32) -> Package {
        let upright = [1.0, 0.0, 0.0, 0.0];
        let (scene, pusher) = match self {
            Self::Prism => {
                let shape = Shape::Prism { length_m: 0.1, side_m: 0.025 };
                (scene(shape, None), Pose { position_m: [0.25, 0.1, 0.2], quaternion: [1.0, 0.0, 0.0, 0.0] })
            }
            Self::Octagon => (scene(octagon(), Some(SupportContact::Patch)), above(0.02)),
            Self::Bar => {
                let end = Pose { position_m: [0.28, 0.1, 0.2], quaternion: upright };
                (scene(octagon(), Some(SupportContact::Patch)), end)
            }
            Self::Plate => {
                let shape = Shape::Prism { length_m: 0.1, side_m: 0.025 };
                (scene(shape, Some(SupportContact::Patch)), above(0.0125))
            }
        };
        let mut plan = Plan::default();
        let _ = plan.segments.push(Segment {
            duration_s: 60.0,
            velocity_m_s: [0.0; 3],
            angular_rad_s: [0.0; 3],
            grip_n: GRIP_N,
            intent: Intent::Hold,
        });
        let mut state = 1_u32;
        let mut noise = move || {
            // Numerical Recipes' generator, as in the self-test.
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            noise_m * ((state >> 8) as f32 / 8_388_608.0 - 1.0)
        };
        let centre = Pose { position_m: [0.3, 0.1, 0.2], quaternion: [1.0, 0.0, 0.0, 0.0] };
        let mut seen = move |pose: Pose| Pose { position_m: pose.position_m.map(|x| x + noise()), ..pose };
        // The bar's axis, its own Z, along the gripper's X.
        let lying = [std::f32::consts::FRAC_1_SQRT_2, 0.0, std::f32::consts::FRAC_1_SQRT_2, 0.0];
        let object = Pose { quaternion: if self == Self::Bar { lying } else { upright }, ..centre };
        let half_n = 0.5 * MASS_KG * 9.81;
        let samples = (0..samples).map(|seq| Sample {
            seq,
            t_us: seq * 4_000,
            grip_cmd_n: GRIP_N,
            gripper: Some(seen(centre)),
            object: Some(seen(object)),
            pusher: Some(seen(pusher)),
            finger: [Some([0.0, -GRIP_N, half_n, 0.0, 0.0, 0.0]), Some([0.0, GRIP_N, half_n, 0.0, 0.0, 0.0])],
        });
        Package::new(scene, model, plan, samples.collect(), 0)
    }
}

/// Faces at plus and minus Y for the fingers.
fn octagon() -> Shape<f32> {
    let (far, near) = (0.02, 0.02 * std::f32::consts::FRAC_PI_8.tan());
    let corners = [
        [far, -near],
        [far, near],
        [near, far],
        [-near, far],
        [-far, near],
        [-far, -near],
        [-near, -far],
        [near, -far],
    ];
    Shape::Polygon { vertices_m: corners.into_iter().collect(), height_m: 0.04 }
}

/// A plate so far above the object's centre: its X axis, the normal into the object, points down.
fn above(height_m: f32) -> Pose {
    let down = std::f32::consts::FRAC_1_SQRT_2;
    Pose { position_m: [0.3, 0.1, 0.2 + height_m], quaternion: [down, 0.0, down, 0.0] }
}

fn scene(shape: Shape<f32>, support: Option<SupportContact<f32>>) -> Scene<f32> {
    Scene {
        gravity_m_s2: [0.0, 0.0, -9.81],
        object: Object { inertia_kg_m2: inertia(&shape, MASS_KG), shape, mass_kg: MASS_KG },
        fingers: Some(FingerContact::Disc { diameter_m: 0.01 }),
        pusher: Some(PusherContact::Plane),
        support,
    }
}
