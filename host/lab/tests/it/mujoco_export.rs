//! The MJCF that MuJoCo is given: well formed, with the rig's masses and sizes. Needs no
//! MuJoCo.

use nalgebra::Vector3;
use roxmltree::{Document, Node};
use stickslip_analysis::run::simulate::{Prepared, prepare};
use stickslip_lab::mujoco::{Setting, mjcf::mjcf};
use stickslip_rig::{self, Condition, Primitive, Reality, STEP_S, Setup, objects};
use stickslip_shared::model::Friction;

const FRICTION: Friction<f64> = Friction { finger: 0.4, pusher: 0.25, support: 2.5 };

fn trial(primitive: Primitive, object: &str) -> Prepared {
    let description = objects::bench("export");
    let setup =
        Setup { description: description.clone(), reality: Reality::ideal(0.4, 0.25), step_s: STEP_S };
    let condition = Condition { grip_n: 5.0, travel: 0.002, ..Condition::new(primitive, object) };
    let trial = stickslip_rig::simulate(&setup, &condition, 1, 1).expect("the rig runs");
    prepare(&description, &trial, 0).expect("a complete trial")
}

fn numbers(node: Node, attribute: &str) -> Vec<f64> {
    let text = node.attribute(attribute).unwrap_or_else(|| panic!("no {attribute}"));
    text.split_whitespace().map(|x| x.parse().expect("a number")).collect()
}

fn named<'a>(document: &'a Document, tag: &str, name: &str) -> Node<'a, 'a> {
    document
        .descendants()
        .find(|n| n.has_tag_name(tag) && n.attribute("name") == Some(name))
        .unwrap_or_else(|| panic!("no {tag} {name}"))
}

#[test]
fn every_primitive_and_setting_is_well_formed_and_has_the_objects_mass_and_size() {
    for (primitive, object, mass, half) in [
        (Primitive::LinearPush, "obj4", 0.2005, vec![0.05, 0.0125, 0.0125]),
        (Primitive::Pivot, "obj5", 0.0938, vec![0.05, 0.0125, 0.0125]),
        (Primitive::Roll, "obj1", 0.158, vec![0.0125, 0.05]),
        (Primitive::LinearPush, "obj3", 0.145, vec![0.0125, 0.05]),
    ] {
        for setting in Setting::ALL {
            let text = mjcf(&trial(primitive, object), &FRICTION, setting).expect("an exportable trial");
            let document = Document::parse(&text).expect("well-formed XML");
            let body = named(&document, "body", "object");
            let inertial = body.children().find(|n| n.has_tag_name("inertial")).expect("an inertia");
            assert_eq!(numbers(inertial, "mass"), [mass]);
            assert_eq!(numbers(named(&document, "geom", "object"), "size"), half);
            let full = numbers(inertial, "fullinertia");
            assert!(full[..3].iter().all(|i| *i > 0.0) && full[0] < full[1], "{full:?}");
        }
    }
}

#[test]
fn the_pads_points_touch_the_object_on_a_ring_of_two_thirds_of_the_radius() {
    let prepared = trial(Primitive::LinearPush, "obj4");
    let text = mjcf(&prepared, &FRICTION, Setting::Tuned).expect("an exportable trial");
    let document = Document::parse(&text).expect("well-formed XML");
    for (k, side) in [(1, 1.0), (2, -1.0)] {
        let finger = named(&document, "body", &format!("finger{k}"));
        assert_eq!(numbers(finger, "pos"), [0.0, side * 0.0125, 0.0]);
        let pads: Vec<Node> = finger.children().filter(|n| n.has_tag_name("geom")).collect();
        assert_eq!(pads.len(), 6);
        for pad in pads {
            let (at, radius) = (numbers(pad, "pos"), numbers(pad, "size")[0]);
            assert!((at[0].hypot(at[2]) - 0.02 / 3.0).abs() < 1e-9);
            assert!((side * at[1] - radius).abs() < 1e-12, "the sphere touches the face");
            assert_eq!(numbers(pad, "friction")[0], FRICTION.finger);
        }
    }
}

#[test]
fn planes_face_the_object_and_have_the_friction_of_pusher_or_platform() {
    for (primitive, object, normal, mu) in [
        (Primitive::LinearPush, "obj4", Vector3::x(), FRICTION.pusher),
        (Primitive::Roll, "obj1", Vector3::z(), FRICTION.support),
    ] {
        let text = mjcf(&trial(primitive, object), &FRICTION, Setting::Default).expect("exportable");
        let document = Document::parse(&text).expect("well-formed XML");
        let plane = named(&document, "geom", "pusher");
        let q = numbers(plane, "quat");
        let rotation =
            nalgebra::UnitQuaternion::new_normalize(nalgebra::Quaternion::new(q[0], q[1], q[2], q[3]));
        assert!((rotation * Vector3::z() - normal).norm() < 1e-9);
        assert_eq!(numbers(plane, "friction")[0], mu);
    }
}

#[test]
fn the_edge_is_a_capsule_of_its_length_whose_crest_is_the_recorded_edge() {
    let prepared = trial(Primitive::Pivot, "obj4");
    let text = mjcf(&prepared, &FRICTION, Setting::Tuned).expect("exportable");
    let document = Document::parse(&text).expect("well-formed XML");
    let edge = named(&document, "geom", "pusher");
    let size = numbers(edge, "size");
    assert!((2.0 * (size[0] + size[1]) - 0.028).abs() < 1e-12, "{size:?}");
    let pose = prepared.poses()[0].pusher.expect("a pusher");
    let at = Vector3::from_vec(numbers(edge, "pos"));
    let crest = at + pose.rotation * Vector3::x() * size[0];
    assert!((crest - pose.position_m).norm() < 1e-12);
}

#[test]
fn polygons_are_refused_with_the_reason() {
    let description = objects::bench("export");
    let setup =
        Setup { description: description.clone(), reality: Reality::ideal(0.4, 0.25), step_s: STEP_S };
    let condition =
        Condition { speed_m_s: 0.05, travel: 0.004, ..Condition::new(Primitive::PlanarPush, "tri") };
    let trial = stickslip_rig::simulate(&setup, &condition, 1, 1).expect("the rig runs");
    let prepared = prepare(&description, &trial, 0).expect("a complete trial");
    assert!(mjcf(&prepared, &FRICTION, Setting::Tuned).unwrap_err().contains("polygon"));
}
