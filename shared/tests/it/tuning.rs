//! The predictor's numbers: all are described, none beyond its bounds reaches it, and none within them stops it.

use crate::common::bar;
use nalgebra::UnitQuaternion;
use stickslip_shared::model::{Base, Formulation, Friction, Model};
use stickslip_shared::predictor::{Checked, Limits, Predictor, Sample, Tuning};
use stickslip_shared::real::Vec3;
use stickslip_shared::track::Pose;
use stickslip_shared::tuning::{About, OutOfBounds, Slot, Tuned, Visitor};

/// Does something to each number in turn.
struct Each<F: FnMut(&str, &About, &mut dyn Slot)>(Vec<&'static str>, F);

impl<F: FnMut(&str, &About, &mut dyn Slot)> Visitor for Each<F> {
    fn enter(&mut self, name: &'static str, doc: &'static str) {
        assert!(doc.trim().len() > 5, "{name} has no documentation");
        self.0.push(name);
    }
    fn leave(&mut self) {
        self.0.pop();
    }
    fn number(&mut self, about: &About, slot: &mut dyn Slot) {
        let key = format!("{}.{}", self.0.join("."), about.name);
        (self.1)(&key, about, slot);
    }
}

fn each(tuning: &mut Tuning<f32>, of: impl FnMut(&str, &About, &mut dyn Slot)) {
    let mut each = Each(Vec::new(), of);
    tuning.visit(&mut each);
    assert!(each.0.is_empty(), "every table ends");
}

fn keys() -> Vec<String> {
    let mut keys = Vec::new();
    each(&mut Tuning::default(), |key, _, _| keys.push(key.to_owned()));
    keys
}

/// The defaults but for one number, all of whose places are `value` of what is said of it.
fn with(key: &str, value: impl Fn(&About) -> f64) -> Tuning<f32> {
    let mut tuning = Tuning::default();
    each(&mut tuning, |own, about, slot| {
        if own == key {
            (0..slot.count()).for_each(|at| slot.set(at, value(about)));
        }
    });
    tuning
}

#[test]
fn every_number_has_a_name_of_its_own_a_meaning_and_a_default_within_its_bounds() {
    let keys = keys();
    assert!(keys.len() > 170, "{}", keys.len());
    let mut sorted = keys.clone();
    sorted.sort();
    sorted.dedup();
    assert_eq!(sorted.len(), keys.len());
    each(&mut Tuning::default(), |key, about, slot| {
        assert!(about.doc.trim().len() > 10, "{key}: {:?}", about.doc);
        assert!(about.low < about.high, "{key}");
        assert!(slot.get(slot.count()).is_none(), "{key}");
        // One that is a bound already would leave no room on one side; only zero, 'off', may.
        for at in 0..slot.count() {
            let value = slot.get(at).expect("a number");
            assert!(value < about.high && (value > about.low || about.low == 0.0), "{key} = {value}");
        }
    });
    assert_eq!(Tuning::<f32>::default().checked().expect("within bounds"), Checked::default());
    assert!(Tuning::<f64>::default().checked().is_ok());
}

#[test]
fn every_number_is_refused_by_name_where_it_is_none_or_beyond_its_bounds() {
    for key in keys() {
        let refused = |value: &dyn Fn(&About) -> f64| -> OutOfBounds {
            let tuning = with(&key, value);
            let why = tuning.checked().expect_err(&key);
            assert!(why.to_string().starts_with(&format!("{key} = ")), "{why}");
            why
        };
        let mut whole = false;
        each(&mut Tuning::default(), |own, _, slot| whole |= own == key && slot.is_whole());
        let mut low = 0.0;
        each(&mut Tuning::default(), |own, about, _| low = if own == key { about.low } else { low });
        if whole {
            refused(&|about| about.high + 1.0);
            if low > 0.0 {
                refused(&|about| about.low - 1.0);
            }
            continue;
        }
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0] {
            refused(&|_| value);
        }
        refused(&|about| about.high * 1.01);
        if low > 0.0 {
            refused(&|about| about.low * 0.99);
        }
    }
}

#[test]
fn bounds_themselves_are_accepted() {
    for key in keys() {
        for bound in [|a: &About| a.low, |a: &About| a.high] {
            assert!(with(&key, bound).checked().is_ok(), "{key}");
        }
    }
}

/// 0 to 1.
struct Draw(u32);

impl Draw {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / 16_777_216.0
    }
}

/// A grasp that rests, is moved, slips, jumps, is unseen and unfelt for a while, and pauses. The most work of a tick.
fn runs(tuning: Tuning<f32>, seed: u32) -> u32 {
    let friction = Friction { finger: 0.4, pusher: 0.4, support: 0.4 };
    let model = Model { formulation: Formulation::Cone, ..Model::base(Base::Hard, friction) };
    let tuning = tuning.checked().expect("within bounds");
    let mut predictor =
        Predictor::new(bar(0.3), model, Limits::default()).expect("a sound model").with_tuning(&tuning);
    let mut draw = Draw(seed);
    let (mut t_s, mut most) = (0.0, 0);
    for k in 0..160_u32 {
        t_s += if k == 90 { 0.06 } else { 0.004 };
        let mut noise = || (draw.unit() - 0.5) * 6e-5;
        let moved = if k > 60 { (k - 60) as f32 * 4e-4 } else { 0.0 };
        let slid = if k > 110 { (k - 110) as f32 * 8e-5 } else { 0.0 };
        let jump = if k % 53 == 52 { 0.02 } else { 0.0 };
        let mut seen = |x: f32, z: f32| Pose {
            position_m: Vec3::new(x + noise(), noise(), z + noise()),
            rotation: UnitQuaternion::identity(),
        };
        let (gripper, object) = (seen(0.0, moved), seen(jump, moved - slid));
        let pusher = seen(-0.05, 0.0);
        let grip = if k > 70 { 20.0 - (k - 70) as f32 * 0.1 } else { 20.0 };
        let wrench = |side: f32| Some([0.1, side * grip, 1.5 + slid * 1e3, 0.0, 0.001, 0.0]);
        let p = predictor.tick(&Sample {
            t_s,
            grip_cmd_n: grip,
            gripper: Some(gripper),
            object: (k % 37 != 36).then_some(object),
            pusher: Some(pusher),
            finger: [wrench(-1.0), if k % 29 == 28 { None } else { wrench(1.0) }],
        });
        assert!(p.solver_residual_n.is_finite());
        most = most.max(predictor.work());
    }
    most
}

#[test]
fn no_numbers_within_their_bounds_make_the_predictor_panic_or_a_tick_without_end() {
    // The bound of `host/lab/tests/it/worst_cases.rs`.
    const MOST: u32 = 190;
    for (at, key) in keys().iter().enumerate() {
        for bound in [|a: &About| a.low, |a: &About| a.high] {
            let work = runs(with(key, bound), at as u32);
            assert!(work <= MOST, "{key}: {work}");
        }
    }
    let mut draw = Draw(7);
    for seed in 0..200 {
        let mut tuning = Tuning::default();
        each(&mut tuning, |_, about, slot| {
            for at in 0..slot.count() {
                // As many small as large ones.
                let [low, high] = [about.low.max(about.high * 1e-6), about.high].map(f64::ln);
                let value = (low + (high - low) * f64::from(draw.unit())).exp();
                slot.set(at, if draw.unit() < 0.1 { about.low } else { value.clamp(about.low, about.high) });
            }
        });
        let work = runs(tuning, seed);
        assert!(work <= MOST, "draw {seed}: {work}");
    }
}
