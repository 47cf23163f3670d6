//! A trial as MJCF, MuJoCo's model format.

use std::fmt::Write as _;

use nalgebra::{UnitQuaternion, Vector3};
use stickslip_shared::model::{FingerContact, Friction, Object, PusherContact, Shape};
use stickslip_shared::step::JAW_MASS_KG;
use stickslip_shared::track::Pose;

use super::Setting;
use stickslip_analysis::run::simulate::Prepared;

/// Radius of the spheres and the capsule that stand for points and edges, m.
const POINT_M: f64 = 5e-4;
/// Mass of the gripper, kg: its motion is prescribed, and nothing shall stop it in a step.
const GRIPPER_KG: f64 = 1000.0;
/// Pads and what they touch; environment and what it touches.
const PAD: u32 = 1;
const OUTSIDE: u32 = 2;

/// The scene of a trial with the object where it starts.
///
/// # Errors
/// A polygon, or a pusher that moves: neither is a primitive of the paper's gripper.
pub fn mjcf(prepared: &Prepared, friction: &Friction<f64>, setting: Setting) -> Result<String, String> {
    let scene = &prepared.scene;
    let poses = prepared.poses();
    let first = poses.first().ok_or("it has no samples")?;
    let mut s = String::new();
    let [gx, gy, gz] = scene.gravity_m_s2;
    let tuned = setting == Setting::Tuned;
    let _ = writeln!(s, "<mujoco model=\"stickslip\">");
    let _ = writeln!(s, "  <compiler angle=\"radian\"/>");
    let cone = if tuned { " cone=\"elliptic\" impratio=\"100\"" } else { "" };
    let step_s = setting.step_s();
    let _ = writeln!(s, "  <option timestep=\"{step_s}\" gravity=\"{gx} {gy} {gz}\"{cone}/>");
    let stiff = if tuned { " solref=\"0.005 1\"" } else { "" };
    let _ = writeln!(s, "  <default>\n    <geom condim=\"3\"{stiff}/>\n    <equality{stiff}/>\n  </default>");
    let _ = writeln!(s, "  <worldbody>");
    if let Some(finger) = &scene.fingers {
        let half = scene.object.shape.reach(&prepared.start.rotation.inverse_transform_vector(&Vector3::y()));
        gripper(&mut s, &first.carrier, finger, &scene.object.shape, half, friction.finger);
    }
    object(&mut s, &first.carrier.to_world(&prepared.start), &scene.object)?;
    if let (Some(pusher), Some(pose)) = (&scene.pusher, &first.pusher) {
        let still = |p: &Pose<f64>| {
            (p.position_m - pose.position_m).norm() < 1e-4 && p.rotation.angle_to(&pose.rotation) < 1e-3
        };
        if !poses.iter().filter_map(|p| p.pusher).all(|p| still(&p)) {
            return Err("its pusher moves: only fixed pushers are exported".into());
        }
        // A plane under the object has the platform's friction, as in the own model.
        let platform = prepared.rests() && scene.support.is_none();
        let mu = if platform { friction.support } else { friction.pusher };
        environment(&mut s, pusher, pose, mu);
    }
    if let (Some(_), Some(pose)) = (&scene.support, &first.support) {
        plane(&mut s, "support", pose, friction.support);
    }
    let _ = writeln!(s, "  </worldbody>");
    if scene.fingers.is_some() {
        let _ = writeln!(
            s,
            "  <equality>\n    <joint joint1=\"jaw1\" joint2=\"jaw2\" polycoef=\"0 -1 0 0 0\"/>\n  </equality>\n  <actuator>\n    \
             <motor name=\"grip1\" joint=\"jaw1\" gear=\"-1\"/>\n    <motor name=\"grip2\" joint=\"jaw2\"/>\n  </actuator>"
        );
    }
    let _ = writeln!(s, "</mujoco>");
    Ok(s)
}

fn place(pose: &Pose<f64>) -> String {
    let (p, q) = (pose.position_m, pose.rotation);
    format!("pos=\"{} {} {}\" quat=\"{} {} {} {}\"", p.x, p.y, p.z, q.w, q.i, q.j, q.k)
}

/// Contact attributes of a rigid surface whose friction decides.
fn surface(group: u32, mu: f64) -> String {
    format!("contype=\"{group}\" conaffinity=\"0\" priority=\"1\" friction=\"{mu} 0 0\"")
}

fn gripper(
    s: &mut String,
    carrier: &Pose<f64>,
    finger: &FingerContact<f64>,
    shape: &Shape<f64>,
    half_m: f64,
    mu: f64,
) {
    let mass = 0.5 * JAW_MASS_KG;
    let _ = writeln!(s, "    <body name=\"gripper\" {} gravcomp=\"1\">", place(carrier));
    let _ = writeln!(s, "      <freejoint name=\"gripper\"/>");
    let _ = writeln!(s, "      <inertial pos=\"0 0 0\" mass=\"{GRIPPER_KG}\" diaginertia=\"100 100 100\"/>");
    for (k, sign) in [(1, 1.0), (2, -1.0)] {
        let y = sign * half_m;
        let _ = writeln!(s, "      <body name=\"finger{k}\" pos=\"0 {y} 0\" gravcomp=\"1\">");
        let _ = writeln!(
            s,
            "        <inertial pos=\"0 0 0\" mass=\"{mass}\" diaginertia=\"0.0001 0.0001 0.0001\"/>\n        <joint \
             name=\"jaw{k}\" type=\"slide\" axis=\"0 1 0\"/>"
        );
        let surface = surface(PAD, mu);
        match round(shape) {
            // The object's spheres touch a flat pad.
            Some(_) => {
                let size = pad_half(finger) + POINT_M;
                let _ = writeln!(
                    s,
                    "        <geom name=\"pad{k}\" type=\"box\" size=\"{size} {POINT_M} {size}\" pos=\"0 {} 0\" {surface}/>",
                    sign * POINT_M
                );
            }
            None => {
                for (i, [x, z]) in pad_points(finger).into_iter().enumerate() {
                    let _ = writeln!(
                        s,
                        "        <geom name=\"pad{k}_{i}\" type=\"sphere\" size=\"{POINT_M}\" pos=\"{x} {} {z}\" {surface}/>",
                        sign * POINT_M
                    );
                }
            }
        }
        let _ = writeln!(s, "      </body>");
    }
    let _ = writeln!(s, "    </body>");
}

/// Radius of a cylinder without flats.
fn round(shape: &Shape<f64>) -> Option<f64> {
    match shape {
        Shape::Cylinder { diameter_m, across_flats_m, .. } if across_flats_m >= diameter_m => {
            Some(0.5 * diameter_m)
        }
        _ => None,
    }
}

fn pad_half(finger: &FingerContact<f64>) -> f64 {
    match finger {
        FingerContact::Point => 0.0,
        FingerContact::Line { length_m } => 0.5 * length_m,
        FingerContact::Disc { diameter_m } => 0.5 * diameter_m,
    }
}

/// Points of a pad on a flat face, gripper X and Z: those of the own model.
fn pad_points(finger: &FingerContact<f64>) -> Vec<[f64; 2]> {
    let half = pad_half(finger);
    match finger {
        FingerContact::Point => vec![[0.0, 0.0]],
        FingerContact::Line { .. } => vec![[-half, 0.0], [half, 0.0]],
        FingerContact::Disc { .. } => (0..6)
            .map(|k| {
                let (z, x) = (f64::from(k) * std::f64::consts::FRAC_PI_3).sin_cos();
                [x * half * 2.0 / 3.0, z * half * 2.0 / 3.0]
            })
            .collect(),
    }
}

fn object(s: &mut String, pose: &Pose<f64>, object: &Object<f64>) -> Result<(), String> {
    let i = object.inertia_kg_m2;
    let _ = writeln!(s, "    <body name=\"object\" {}>\n      <freejoint name=\"object\"/>", place(pose));
    let _ = writeln!(
        s,
        "      <inertial pos=\"0 0 0\" mass=\"{}\" fullinertia=\"{} {} {} {} {} {}\"/>",
        object.mass_kg, i[0][0], i[1][1], i[2][2], i[0][1], i[0][2], i[1][2]
    );
    let touched = |group: u32| format!("contype=\"0\" conaffinity=\"{group}\"");
    match &object.shape {
        Shape::Prism { length_m, side_m } => {
            let (l, h) = (0.5 * length_m, 0.5 * side_m);
            let _ = writeln!(
                s,
                "      <geom name=\"object\" type=\"box\" size=\"{l} {h} {h}\" {}/>",
                touched(PAD | OUTSIDE)
            );
        }
        Shape::Cylinder { length_m, diameter_m, across_flats_m } => {
            let (l, r) = (0.5 * length_m, 0.5 * diameter_m);
            let along_x = "quat=\"0.7071067811865476 0 0.7071067811865476 0\"";
            let _ = writeln!(
                s,
                "      <geom name=\"object\" type=\"cylinder\" size=\"{r} {l}\" {along_x} {}/>",
                touched(OUTSIDE)
            );
            if across_flats_m < diameter_m {
                let h = 0.5 * across_flats_m;
                let wide = (r * r - h * h).sqrt();
                let _ = writeln!(
                    s,
                    "      <geom name=\"flats\" type=\"box\" size=\"{l} {h} {wide}\" {}/>",
                    touched(PAD)
                );
            } else {
                // The line of contact under a pad, by its ends.
                for (name, x) in [("line1", -0.01), ("line2", 0.01)] {
                    let _ = writeln!(
                        s,
                        "      <geom name=\"{name}\" type=\"sphere\" size=\"{r}\" pos=\"{x} 0 0\" {}/>",
                        touched(PAD)
                    );
                }
            }
        }
        Shape::Polygon { .. } => {
            return Err("its object is a polygon: prisms and cylinders are exported".into());
        }
    }
    let _ = writeln!(s, "    </body>");
    Ok(())
}

fn environment(s: &mut String, pusher: &PusherContact<f64>, pose: &Pose<f64>, mu: f64) {
    let surface = surface(OUTSIDE, mu);
    match pusher {
        PusherContact::Plane => plane(s, "pusher", pose, mu),
        PusherContact::Line { length_m } => {
            // Its crest is the edge, along the pusher's Y.
            let half = 0.5 * length_m - POINT_M;
            let normal = pose.rotation.transform_vector(&Vector3::x());
            let turn = UnitQuaternion::rotation_between(&Vector3::z(), &Vector3::y()).unwrap_or_default();
            let at = Pose { position_m: pose.position_m - normal * POINT_M, rotation: pose.rotation * turn };
            let _ = writeln!(
                s,
                "    <geom name=\"pusher\" type=\"capsule\" size=\"{POINT_M} {half}\" {} {surface}/>",
                place(&at)
            );
        }
        PusherContact::Point { tip_radius_m } => {
            let _ = writeln!(
                s,
                "    <geom name=\"pusher\" type=\"sphere\" size=\"{tip_radius_m}\" {} {surface}/>",
                place(pose)
            );
        }
    }
}

/// A plane whose normal is the pose's +X.
fn plane(s: &mut String, name: &str, pose: &Pose<f64>, mu: f64) {
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &Vector3::x()).unwrap_or_default();
    let at = Pose { position_m: pose.position_m, rotation: pose.rotation * turn };
    let _ = writeln!(
        s,
        "    <geom name=\"{name}\" type=\"plane\" size=\"1 1 0.1\" {} {}/>",
        place(&at),
        surface(OUTSIDE, mu)
    );
}
