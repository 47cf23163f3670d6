//! Doubts of the model and of the sample: each shows in the validity word, and makes the flags unsure.

use nalgebra::UnitQuaternion;
use stickslip_shared::contact::{self, Contacts, SLOTS};
use stickslip_shared::predictor::{Prediction, Predictor, Sample, flags, validity};
use stickslip_shared::real::Vec3;
use stickslip_shared::selftest::push;
use stickslip_shared::step::{Drive, State};
use stickslip_shared::track::Pose;

/// Ticks in which the object comes to rest.
const QUIET: u32 = 60;

struct Rig {
    predictor: Predictor<f32>,
    tick: u32,
}

impl Rig {
    fn new() -> Self {
        let (scene, model, limits) = push(0.2, 0.4);
        let mut rig =
            Self { predictor: Predictor::new(scene, model, limits).expect("a sound model"), tick: 0 };
        for _ in 0..QUIET {
            let p = rig.take(|_| ());
            assert_eq!(
                p.validity & !(validity::WAITING | validity::NO_FORESIGHT | validity::NO_PLAN),
                0,
                "{p:?}"
            );
        }
        let p = rig.take(|_| ());
        assert_eq!(p.flags & flags::UNSURE, 0, "{p:?}");
        rig
    }

    /// An object held still, seen with some noise, and what is wrong with the sample.
    fn take(&mut self, spoil: impl FnOnce(&mut Sample<f32>)) -> Prediction {
        self.tick += 1;
        let noise = |k: u32| 1e-5 * ((self.tick * 7 + k * 3) % 11) as f32 - 5e-5;
        let wrench =
            |side: f32, k: u32| Some([noise(k), side * 30.0 + 100.0 * noise(k + 1), 0.98, 0.0, 0.0, 0.0]);
        let object =
            Pose { position_m: Vec3::new(noise(2), 0.0, noise(4)), rotation: UnitQuaternion::identity() };
        let mut sample = Sample {
            t_s: self.tick as f32 * 0.004,
            grip_cmd_n: 30.0,
            gripper: Some(Pose::identity()),
            object: Some(object),
            pusher: None,
            finger: [wrench(-1.0, 0), wrench(1.0, 5)],
        };
        spoil(&mut sample);
        self.predictor.tick(&sample)
    }
}

fn doubts(p: &Prediction, bit: u32) -> bool {
    p.validity & bit != 0 && p.flags & flags::UNSURE != 0
}

#[test]
fn without_a_wrench_the_flags_are_unsure_and_with_it_again_they_are_not() {
    let mut rig = Rig::new();
    let p = rig.take(|sample| sample.finger = [None; 2]);
    assert!(doubts(&p, validity::NO_WRENCH), "{p:?}");
    assert_eq!(p.validity & validity::UNRELIABLE, validity::NO_WRENCH, "for no other reason: {p:?}");
    let p = rig.take(|_| ());
    assert_eq!(p.flags & flags::UNSURE, 0, "{p:?}");
}

#[test]
fn an_object_that_is_seen_elsewhere_and_stays_there_is_said_to_have_parted_from_the_model() {
    let mut rig = Rig::new();
    let mut parted = None;
    for tick in 0..20 {
        let p = rig.take(|sample| {
            if let Some(object) = &mut sample.object {
                object.position_m.x += 0.02;
            }
        });
        if p.validity & validity::DIVERGED != 0 {
            assert!(doubts(&p, validity::DIVERGED), "{p:?}");
            parted = parted.or(Some(tick));
        }
    }
    assert!(parted.is_some(), "it never said so");
}

#[test]
fn points_that_found_no_place_are_counted_and_such_a_step_makes_flags_unsure() {
    let (scene, model, _) = push(0.2, 0.4);
    let drive = Drive {
        dt_s: 0.004,
        carrier: UnitQuaternion::identity(),
        carrier_m_s: Vec3::zeros(),
        carrier_rad_s: Vec3::zeros(),
        pusher: None,
        support: None,
        grip_n: 30.0,
        trial: 0.0,
    };
    let state: State<f32, SLOTS> =
        State::held(&scene, &model, &drive, Vec3::zeros(), UnitQuaternion::identity());
    let mut all = Contacts::<f32, SLOTS>::new();
    assert_eq!(contact::find(&scene, &model, &state, &drive, &mut all), 0);
    // The predictor has a place for every point of any scene (`held`, in the lab's tests): it cannot be made to lose one.
    let small: State<f32, 8> = State::held(&scene, &model, &drive, Vec3::zeros(), UnitQuaternion::identity());
    let mut some = Contacts::<f32, 8>::new();
    assert_eq!(contact::find(&scene, &model, &small, &drive, &mut some), all.len() - 8);
    assert_ne!(validity::UNRELIABLE & validity::POINTS_LOST, 0);
}
