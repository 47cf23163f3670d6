//! A model that is put to use in the midst of a run.

use stickslip_selftest::push;
use stickslip_shared::predictor::{Intent, Plan, Predictor, Sample, Segment, validity};
use stickslip_shared::track::Pose;

#[test]
fn a_model_swap_in_a_run_keeps_plan_learnt_friction_and_object() {
    let (mut scene, model, limits) = push(0.2, 0.4);
    scene.pusher = None;
    let mut predictor = Predictor::new(scene.clone(), model.clone(), limits).expect("sound");
    let mut plan = Plan::default();
    let _ = plan.segments.push(Segment {
        duration_s: 10.0,
        velocity_m_s: [0.0; 3],
        angular_rad_s: [0.0; 3],
        grip_n: 30.0,
        intent: Intent::Hold,
    });
    predictor.set_plan(plan);
    let sample = |k: u8, object: bool| Sample {
        t_s: f32::from(k) * 0.004,
        grip_cmd_n: 30.0,
        gripper: Some(Pose::identity()),
        object: object.then(Pose::identity),
        pusher: None,
        finger: [Some([0.0, -30.0, 0.98, 0.0, 0.0, 0.0]), Some([0.0, 30.0, 0.98, 0.0, 0.0, 0.0])],
    };
    let mut before = predictor.tick(&sample(0, true));
    for k in 1..20 {
        before = predictor.tick(&sample(k, true));
    }
    assert_eq!(before.validity, 0, "{before:?}");
    let mut softer = model.clone();
    softer.friction.finger = 0.8;
    predictor.swap(scene.clone(), softer.clone(), limits);
    // The object is out of the camera's sight.
    let after = predictor.tick(&sample(20, false));
    assert_eq!(after.validity & (validity::WAITING | validity::NO_PLAN), 0, "{after:?}");
    assert_eq!(after.friction, before.friction, "the friction learnt");
    assert!((after.position_m[2] - before.position_m[2]).abs() < 1e-6, "{before:?} {after:?}");
    // Another object is seen anew.
    scene.object.mass_kg *= 2.0;
    predictor.swap(scene, softer, limits);
    assert_ne!(predictor.tick(&sample(21, false)).validity & validity::WAITING, 0);
}
