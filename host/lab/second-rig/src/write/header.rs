//! `dataset.toml`, and the `model.toml` that goes with grasps.

use serde::Serialize;
use std::collections::BTreeMap;
use toml::{Table, Value};

use crate::dataset::DataSet;
use crate::error::Error;
use crate::plan::bench::{EDGE_M, Primitive, ROD_M};

#[derive(Serialize)]
struct Header {
    format: &'static str,
    name: String,
    sample_rate_hz: f64,
    gravity_m_s2: [f64; 3],
    objects: Vec<Object>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fingers: Option<Table>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pushers: BTreeMap<&'static str, Table>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    supports: BTreeMap<&'static str, Table>,
    #[serde(skip_serializing_if = "Option::is_none")]
    sensors: Option<BTreeMap<&'static str, Table>>,
}

#[derive(Serialize)]
struct Object {
    id: String,
    shape: &'static str,
    length_m: f64,
    side_m: f64,
    mass_kg: f64,
}

fn table<const N: usize>(pairs: [(&str, Value); N]) -> Table {
    pairs.into_iter().map(|(k, v)| (k.to_owned(), v)).collect()
}

/// The rig as the user is told.
pub fn dataset_toml(set: &DataSet) -> Result<String, Error> {
    let r = &set.reality;
    let s = &r.sensors;
    let primitives = set.bench.as_ref().map_or(&[][..], |b| &b.primitives);
    let grasped = set.trials.iter().any(|t| t.grasped);
    let contact = |name: &str| ("contact", Value::from(name));
    let mut pushers = BTreeMap::new();
    let mut supports = BTreeMap::new();
    for p in primitives {
        match p {
            Primitive::LinearPush => drop(pushers.insert("linear_push", table([contact("plane")]))),
            Primitive::Pivot => {
                drop(pushers.insert("pivot", table([contact("line"), ("length_m", EDGE_M.into())])));
            }
            Primitive::Roll => drop(pushers.insert("roll", table([contact("plane")]))),
            Primitive::PlanarPush => {
                drop(
                    pushers.insert("planar_push", table([contact("point"), ("tip_radius_m", ROD_M.into())])),
                );
            }
            Primitive::Lift => {}
        }
    }
    for t in set.trials.iter().filter(|t| t.table) {
        let name = if t.grasped { "lift" } else { "planar_push" };
        let told = match &r.feet_m {
            Some(feet) if r.feet_told => {
                let points = feet.iter().map(|p| Value::from(p.to_vec())).collect::<Vec<_>>();
                table([contact("points"), ("points_m", points.into())])
            }
            _ => table([contact("patch")]),
        };
        supports.insert(name, told);
    }
    let sensor = |x: &crate::sensors::Stated| {
        table([
            ("force_noise_n", x.force_noise_n.into()),
            ("force_uncertainty_n", x.force_uncertainty_n.into()),
            ("torque_noise_nm", x.torque_noise_nm.into()),
            ("torque_uncertainty_nm", x.torque_uncertainty_nm.into()),
        ])
    };
    let mut sensors = BTreeMap::new();
    if grasped {
        sensors.insert("finger", sensor(&s.finger));
    }
    if !pushers.is_empty() && s.pusher_measured {
        sensors.insert("pusher", sensor(&s.pusher));
    }
    let pose = [
        ("position_noise_m", s.position_noise_m.into()),
        ("rotation_noise_rad", s.rotation_noise_rad.into()),
    ];
    sensors.insert("pose", table(pose));
    let header = Header {
        format: "stickslip-dataset/1",
        name: format!("second rig {}", set.seed),
        sample_rate_hz: s.rate_hz,
        gravity_m_s2: [0.0, 0.0, -9.81],
        objects: r
            .objects
            .iter()
            .map(|o| Object {
                id: o.id.clone(),
                shape: if o.round { "cylinder" } else { "prism" },
                length_m: o.length_m,
                side_m: o.side_m,
                mass_kg: o.mass_kg,
            })
            .collect(),
        fingers: grasped.then(|| {
            let diameter = (r.pad.radius_m * 2e6).round() / 1e6;
            table([contact("disc"), ("diameter_m", diameter.into())])
        }),
        pushers,
        supports,
        sensors: s.stated.then_some(sensors),
    };
    Ok(toml::to_string(&header)?)
}

/// Friction as the user of a gripper believes it: off by the reality's `told_factor`.
pub fn model_toml(set: &DataSet) -> Result<String, Error> {
    let r = &set.reality;
    let told = |mu: f64| Value::from((mu * r.told_factor * 1e4).round() / 1e4);
    let friction = table([
        ("finger", told(r.break_away_mu())),
        ("pusher", told(r.pusher.law.mu)),
        ("support", told(r.table.law.mu)),
    ]);
    let model = table([
        ("format", "stickslip-model/1".into()),
        ("base", "hard".into()),
        ("friction", friction.into()),
    ]);
    Ok(toml::to_string(&model)?)
}
