//! Doubts of the model and of the sample: each shows in the validity word, and makes the flags unsure.

use crate::common::bar;
use nalgebra::UnitQuaternion;
use stickslip_selftest::push;
use stickslip_shared::contact::{self, Contacts, SLOTS};
use stickslip_shared::model::{Base, Formulation, Friction, Model};
use stickslip_shared::predictor::{Limits, Params, Prediction, Predictor, Sample, Tuning, flags, validity};
use stickslip_shared::real::Vec3;
use stickslip_shared::solve::SolveStatus;
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

/// A bar of 20 kg that is seen to jump by up to a centimetre between discs, table and plate, where three steps in a row are
/// not solved, and to rest from the sixth sample on. `samples` of the stream, by a predictor that starts anew after so many unsolved ones.
fn jumps(unsolved_samples: u8, samples: u32) -> Vec<Prediction> {
    let scene = bar(20.0);
    let friction = Friction { finger: 0.4, pusher: 0.4, support: 0.4 };
    let model = Model { formulation: Formulation::Lcp, ..Model::base(Base::Hard, friction) };
    let predictor = Params { unsolved_samples, ..Params::default() };
    let tuning = Tuning { predictor, ..Tuning::default() }.checked().expect("within bounds");
    let mut predictor =
        Predictor::new(scene, model, Limits::default()).expect("a sound model").with_tuning(&tuning);
    let mut state = 1_u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        1e-5 * 1024.0 * ((state >> 8) as f32 / 8_388_608.0 - 1.0)
    };
    let mut tick = |k: u32| {
        let mut jump = || if k < 5 { noise() } else { 0.0 };
        let mut seen = |x: f32| Pose {
            position_m: Vec3::new(x + jump(), jump(), jump()),
            rotation: UnitQuaternion::identity(),
        };
        let wrench = |side: f32| Some([0.0, side * 20.0, 1.0, 0.0, 0.0, 0.0]);
        predictor.tick(&Sample {
            t_s: k as f32 * 0.004,
            grip_cmd_n: 20.0,
            gripper: Some(seen(0.0)),
            object: Some(seen(0.0)),
            pusher: Some(seen(-0.05)),
            finger: [wrench(-1.0), wrench(1.0)],
        })
    };
    (0..samples).map(&mut tick).collect()
}

#[test]
fn after_three_samples_in_a_row_that_were_not_solved_the_model_starts_anew_and_says_so_as_long_as_it_lasts() {
    let first = |all: &[Prediction]| {
        let unsolved = |p: &Prediction| p.solver_status == SolveStatus::IterationLimit;
        let from = all.iter().position(unsolved).expect("an unsolved sample");
        (from, all.iter().skip(from).take_while(|p| unsolved(p)).count())
    };
    let present = jumps(Params::default().unsolved_samples, 12);
    let (from, count) = first(&present);
    assert_eq!(count, 3, "unsolved from sample {from} on");
    for p in present.iter().skip(from).take(3) {
        assert!(doubts(p, validity::SOLVER), "{p:?}");
    }
    assert_eq!(present[from + 3].solver_status, SolveStatus::Solved, "{:?}", present[from + 3]);
    // One that never starts anew is the same until then, and another one after it.
    let never = jumps(250, 12);
    let words = |p: &Prediction| p.words().collect::<Vec<_>>();
    for (k, (one, other)) in present.iter().zip(&never).enumerate().take(from + 4) {
        assert_eq!(words(one) == words(other), k < from + 3, "sample {k}: {one:?} and {other:?}");
    }
}
