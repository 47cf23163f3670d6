//! The objects and the rig's description (`dataset.toml`) of the paper's bench.

use std::collections::BTreeMap;

use stickslip_data::{ContactSpec, Description, ObjectSpec, PoseSensor, Sensors, WrenchSensor};

/// The paper's five objects and a triangle for planar pushing.
///
/// Masses are the paper's, which include the marker. obj3's flats are not given: 20 mm
/// across them make an aluminium cylinder lighter by 13.8 g, the paper's difference
/// between obj1 and obj3 being 13 g.
pub fn catalogue() -> Vec<ObjectSpec> {
    let bar = |id: &str, shape: &str, mass_kg: f64, across_flats_m: Option<f64>| ObjectSpec {
        id: id.into(),
        shape: shape.into(),
        length_m: Some(0.1),
        side_m: Some(0.025),
        across_flats_m,
        vertices_m: None,
        height_m: None,
        mass_kg,
        inertia_kg_m2: None,
    };
    vec![
        bar("obj1", "cylinder", 0.158, None),
        bar("obj2", "cylinder", 0.0725, None),
        bar("obj3", "cylinder", 0.145, Some(0.02)),
        bar("obj4", "prism", 0.2005, None),
        bar("obj5", "prism", 0.0938, None),
        ObjectSpec {
            id: "tri".into(),
            shape: "polygon".into(),
            length_m: None,
            side_m: None,
            across_flats_m: None,
            vertices_m: Some(vec![[-0.04, -0.04], [0.08, -0.04], [-0.04, 0.08]]),
            height_m: Some(0.03),
            mass_kg: 1.2,
            inertia_kg_m2: None,
        },
    ]
}

/// The rig as it is told to whoever reads the data.
pub fn bench(name: &str) -> Description {
    let disc = ContactSpec { contact: "disc".into(), diameter_m: Some(0.02), ..Default::default() };
    let named = |contact: &str| ContactSpec { contact: contact.into(), ..Default::default() };
    let line = ContactSpec { contact: "line".into(), length_m: Some(0.028), ..Default::default() };
    let rod = ContactSpec { contact: "point".into(), tip_radius_m: Some(0.005), ..Default::default() };
    Description {
        format: "stickslip-dataset/1".into(),
        name: name.into(),
        sample_rate_hz: 250.0,
        gravity_m_s2: [0.0, 0.0, -9.81],
        objects: catalogue(),
        fingers: Some(disc),
        pushers: BTreeMap::from([
            ("linear_push".into(), named("plane")),
            ("pivot".into(), line),
            ("roll".into(), named("plane")),
            ("planar_push".into(), rod),
        ]),
        supports: BTreeMap::from([("lift".into(), named("patch")), ("planar_push".into(), named("patch"))]),
        sensors: Sensors {
            finger: WrenchSensor {
                force_noise_n: 0.02,
                force_uncertainty_n: 0.25,
                torque_noise_nm: 0.0004,
                torque_uncertainty_nm: 0.003,
            },
            pusher: WrenchSensor {
                force_noise_n: 0.02,
                force_uncertainty_n: 0.75,
                torque_noise_nm: 0.0004,
                torque_uncertainty_nm: 0.037,
            },
            pose: PoseSensor { position_noise_m: 3e-5, rotation_noise_rad: 3e-4 },
        },
    }
}

/// Keeps of a description what the given primitives and objects need.
pub fn trimmed(mut description: Description, primitives: &[&str], objects: &[&str]) -> Description {
    description.objects.retain(|o| objects.contains(&o.id.as_str()));
    description.pushers.retain(|p, _| primitives.contains(&p.as_str()));
    description.supports.retain(|p, _| primitives.contains(&p.as_str()));
    if primitives.iter().all(|p| *p == "planar_push") {
        description.fingers = None;
    }
    description
}
