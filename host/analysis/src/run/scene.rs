//! The scene of a trial: rig and object of a description as the model takes them.
//!
//! `dataset.toml` is free in what it leaves out; the model is not. What it lacks and what it
//! names that the format does not know is an error that says which key to add.

use stickslip_data::{ContactSpec, Description, ObjectSpec, Trial, TrialInfo};
use stickslip_shared::model::{FingerContact, Object, PusherContact, Scene, Shape, SupportContact};
use stickslip_shared::shape::inertia;
use thiserror::Error;

/// Why a trial cannot be simulated.
#[derive(Debug, Error)]
pub enum SceneError {
    /// The description lacks or contradicts something.
    #[error("trial {trial}: {what}")]
    Description {
        /// Trial.
        trial: String,
        /// What, and what to do.
        what: String,
    },
}

/// Rig and object of a trial as the model sees them.
///
/// # Errors
/// Where `dataset.toml` lacks a dimension or names a contact that the format does not know.
pub fn scene(description: &Description, trial: &Trial) -> Result<Scene<f64>, SceneError> {
    // A primitive that grips nothing leaves the gripper's columns empty.
    scene_of(description, &trial.info, trial.samples.iter().any(|s| s.gripper.is_some()))
}

/// The same of a trial that is not recorded yet; `grasped`: the fingers hold the object.
///
/// # Errors
/// As [`scene`].
pub fn scene_of(
    description: &Description,
    info: &TrialInfo,
    grasped: bool,
) -> Result<Scene<f64>, SceneError> {
    let fail = |what: String| SceneError::Description { trial: info.trial.clone(), what };
    let spec = description
        .objects
        .iter()
        .find(|o| o.id == info.object)
        .ok_or_else(|| fail(format!("object `{}` is not in dataset.toml", info.object)))?;
    let object = object(spec).map_err(&fail)?;
    let primitive = &info.primitive;
    let fingers = description.fingers.as_ref().map(finger).transpose().map_err(&fail)?;
    let pusher = description.pushers.get(primitive).map(pusher).transpose().map_err(&fail)?;
    let support = description.supports.get(primitive).map(support).transpose().map_err(&fail)?;
    Ok(Scene {
        gravity_m_s2: description.gravity_m_s2,
        object,
        fingers: fingers.filter(|_| grasped),
        pusher,
        support,
    })
}

fn need(value: Option<f64>, what: &str) -> Result<f64, String> {
    value.ok_or_else(|| format!("dataset.toml lacks {what}; add it"))
}

fn object(spec: &ObjectSpec) -> Result<Object<f64>, String> {
    let id = &spec.id;
    let shape = match spec.shape.as_str() {
        "prism" => Shape::Prism {
            length_m: need(spec.length_m, &format!("length_m of object `{id}`"))?,
            side_m: need(spec.side_m, &format!("side_m of object `{id}`"))?,
        },
        "cylinder" => {
            let diameter_m = need(spec.side_m, &format!("side_m of object `{id}`"))?;
            Shape::Cylinder {
                length_m: need(spec.length_m, &format!("length_m of object `{id}`"))?,
                diameter_m,
                across_flats_m: spec.across_flats_m.unwrap_or(diameter_m),
            }
        }
        "polygon" => {
            let given = spec.vertices_m.as_deref().unwrap_or_default();
            let mut vertices_m = heapless::Vec::from_slice(given).map_err(|_| {
                format!(
                    "object `{id}` has {} vertices; at most {} fit",
                    given.len(),
                    stickslip_shared::model::MAX_VERTICES
                )
            })?;
            if vertices_m.len() < 3 {
                return Err(format!("object `{id}` is a polygon with {} vertices", vertices_m.len()));
            }
            // Counter-clockwise, whatever the file has.
            let area: f64 = (0..vertices_m.len())
                .map(|i| {
                    let (a, b) = (vertices_m[i], vertices_m[(i + 1) % vertices_m.len()]);
                    a[0] * b[1] - a[1] * b[0]
                })
                .sum();
            if area < 0.0 {
                vertices_m.reverse();
            }
            Shape::Polygon {
                vertices_m,
                height_m: need(spec.height_m, &format!("height_m of object `{id}`"))?,
            }
        }
        other => return Err(format!("object `{id}`: unknown shape `{other}` (prism, cylinder, polygon)")),
    };
    let inertia_kg_m2 = spec.inertia_kg_m2.unwrap_or_else(|| inertia(&shape, spec.mass_kg));
    Ok(Object { shape, mass_kg: spec.mass_kg, inertia_kg_m2 })
}

fn finger(spec: &ContactSpec) -> Result<FingerContact<f64>, String> {
    match spec.contact.as_str() {
        "disc" => Ok(FingerContact::Disc { diameter_m: need(spec.diameter_m, "diameter_m of [fingers]")? }),
        "line" => Ok(FingerContact::Line { length_m: need(spec.length_m, "length_m of [fingers]")? }),
        "point" => Ok(FingerContact::Point),
        other => Err(format!("[fingers]: unknown contact `{other}` (disc, line, point)")),
    }
}

fn pusher(spec: &ContactSpec) -> Result<PusherContact<f64>, String> {
    match spec.contact.as_str() {
        "plane" => Ok(PusherContact::Plane),
        "line" => Ok(PusherContact::Line { length_m: need(spec.length_m, "length_m of the pusher")? }),
        "point" => {
            Ok(PusherContact::Point { tip_radius_m: need(spec.tip_radius_m, "tip_radius_m of the pusher")? })
        }
        other => Err(format!("pusher: unknown contact `{other}` (plane, line, point)")),
    }
}

fn support(spec: &ContactSpec) -> Result<SupportContact<f64>, String> {
    match spec.contact.as_str() {
        "patch" => Ok(SupportContact::Patch),
        "points" => {
            let given = spec.points_m.as_deref().unwrap_or_default();
            heapless::Vec::from_slice(given)
                .map(SupportContact::Points)
                .map_err(|_| format!("{} support points; at most 8 fit", given.len()))
        }
        other => Err(format!("support: unknown contact `{other}` (patch, points)")),
    }
}
