//! Claims about the predictor on a held object whose sensors are simulated with noise.

use nalgebra::UnitQuaternion;
use proptest::prelude::*;
use stickslip_shared::effects::{Effect, MAX_PARAMETERS, mocap_latency};
use stickslip_shared::model::{Base, FingerContact, Friction, Model, Object, Scene, Shape};
use stickslip_shared::predictor::{
    Intent, Limits, Plan, Prediction, Predictor, Sample, Segment, Slip, flags, validity,
};
use stickslip_shared::real::Vec3;
use stickslip_shared::track::Pose;

const DT: f32 = 0.004;
const WEIGHT_N: f32 = 0.2 * 9.81;
const MU: f32 = 0.4;

fn scene() -> Scene<f32> {
    let (a, b) = (0.2 * (0.025f32.powi(2) * 2.0) / 12.0, 0.2 * (0.1f32.powi(2) + 0.025f32.powi(2)) / 12.0);
    Scene {
        gravity_m_s2: [0.0, 0.0, -9.81],
        object: Object {
            shape: Shape::Prism { length_m: 0.1, side_m: 0.025 },
            mass_kg: 0.2,
            inertia_kg_m2: [[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, b]],
        },
        fingers: Some(FingerContact::Disc { diameter_m: 0.02 }),
        pusher: None,
        support: None,
    }
}

fn model() -> Model<f32> {
    Model::base(Base::Hard, Friction { finger: MU, pusher: 0.25, support: 0.3 })
}

/// A held object: grip and load over time, white sensor noise as in the paper's sensors.
struct Hold {
    predictor: Predictor<f32>,
    random: u32,
    tick: u32,
    pose: bool,
}

impl Hold {
    fn new(grip_n: f32) -> Self {
        let mut predictor = Predictor::new(scene(), model(), Limits::default()).unwrap();
        let mut plan = Plan::default();
        let still = Segment { duration_s: 1000.0, grip_n, intent: Intent::Hold, ..Segment::default() };
        plan.segments.push(still).unwrap();
        predictor.set_plan(plan);
        Self { predictor, random: 1, tick: 0, pose: true }
    }

    /// Nearly normal: the sum of four uniform numbers.
    fn noise(&mut self, deviation: f32) -> f32 {
        let mut sum = 0.0;
        for _ in 0..4 {
            self.random = self.random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            sum += (self.random >> 8) as f32 / 16_777_216.0 - 0.5;
        }
        sum * deviation * 1.732
    }

    /// The sample of a grasp that carries `load_n` with `grip_n` on each finger.
    fn sample(&mut self, grip_n: f32, load_n: f32, slipped_m: f32) -> Sample<f32> {
        let t_s = self.tick as f32 * DT;
        self.tick += 1;
        let finger = [-1.0, 1.0].map(|side| {
            let mut w = [0.0; 6];
            let exact = [0.0, side * grip_n, 0.5 * load_n, 0.0, 0.0, 0.0];
            for (i, (w, e)) in w.iter_mut().zip(exact).enumerate() {
                *w = e + self.noise(if i < 3 { 0.02 } else { 4e-4 });
            }
            Some(w)
        });
        let position_m = Vec3::new(self.noise(3e-5), self.noise(3e-5), self.noise(3e-5) - slipped_m);
        let object = Pose { position_m, rotation: UnitQuaternion::identity() };
        Sample {
            t_s,
            grip_cmd_n: grip_n,
            gripper: Some(Pose::identity()),
            object: (self.pose || self.tick == 1).then_some(object),
            pusher: None,
            finger,
        }
    }

    fn tick(&mut self, grip_n: f32, load_n: f32, slipped_m: f32) -> Prediction {
        let sample = self.sample(grip_n, load_n, slipped_m);
        self.predictor.tick(&sample)
    }
}

const ALARMS: u32 = flags::SLIP_1
    | flags::SLIP_2
    | flags::SLIP_AHEAD_1
    | flags::SLIP_AHEAD_2
    | flags::UNEXPECTED
    | flags::DROP
    | flags::SAG
    | flags::ROTATION;

#[test]
fn a_steady_hold_with_noise_raises_no_alarm_in_a_minute() {
    for pose in [true, false] {
        // Half again as much grip as friction needs.
        let grip = 1.5 * WEIGHT_N / (2.0 * MU);
        let mut hold = Hold { pose, ..Hold::new(grip) };
        for tick in 0..15_000 {
            let p = hold.tick(grip, WEIGHT_N, 0.0);
            assert_eq!(p.flags & (ALARMS | flags::UNSURE), 0, "pose {pose}, tick {tick}: {p:?}");
        }
    }
}

#[test]
fn a_decaying_grip_is_warned_of_at_least_100_ms_before_the_limit() {
    for (pose, seconds) in [(true, 0.5f32), (true, 3.0), (false, 0.5), (false, 3.0)] {
        let full = 2.0 * WEIGHT_N / (2.0 * MU);
        let mut hold = Hold { pose, ..Hold::new(full) };
        let (mut slip, mut drop) = (None, None);
        for tick in 0..2000u32 {
            let since = (tick as f32 * DT - 1.0).max(0.0);
            let grip = full * (1.0 - 0.6 * (since / seconds).min(1.0));
            // The limit: half the grip.
            if 2.0 * MU * grip <= WEIGHT_N {
                let warned = |at: Option<u32>| at.is_some_and(|at| (tick - at) as f32 * DT >= 0.1);
                assert!(warned(slip), "slip: limit at tick {tick}, warned at {slip:?}");
                assert!(warned(drop), "drop: limit at tick {tick}, warned at {drop:?}");
                break;
            }
            let p = hold.tick(grip, WEIGHT_N, 0.0);
            let raised = |flag: u32, at: &mut Option<u32>| {
                *at = if p.flags & flag == 0 { None } else { at.or(Some(tick)) };
            };
            raised(flags::SLIP_AHEAD_1 | flags::SLIP_1, &mut slip);
            raised(flags::DROP, &mut drop);
            assert!(since > 0.0 || slip.is_none(), "alarm before the decay, tick {tick}");
        }
    }
}

#[test]
fn a_sudden_load_beyond_the_limit_is_flagged_within_20_ms() {
    let grip = 2.0 * WEIGHT_N / (2.0 * MU);
    for pose in [true, false] {
        let mut hold = Hold { pose, ..Hold::new(grip) };
        for _ in 0..500 {
            hold.tick(grip, WEIGHT_N, 0.0);
        }
        // At the limit friction carries no more; the rest accelerates the object.
        let mut flagged = None;
        for tick in 0..10u32 {
            let t = tick as f32 * DT;
            let p = hold.tick(grip, 2.0 * MU * grip, 0.5 * 2.0 * t * t);
            if p.flags & flags::UNEXPECTED != 0 {
                flagged = flagged.or(Some(tick));
            }
        }
        assert!(flagged.is_some_and(|tick| tick < 5), "pose {pose}: {flagged:?}");
    }
}

#[test]
fn a_slip_that_a_second_one_like_it_would_turn_into_a_drop_leaves_a_drop_warning_up() {
    // The face ends 12.5 mm below the pads' centres.
    for (slip_m, warned) in [(0.008f32, true), (0.004, false)] {
        let grip = 2.0 * WEIGHT_N / (2.0 * MU);
        let mut hold = Hold::new(grip);
        for _ in 0..250 {
            hold.tick(grip, WEIGHT_N, 0.0);
        }
        let mut p = Prediction::default();
        for tick in 0..300 {
            let slipped_m = slip_m * (tick as f32 * DT / 0.08).min(1.0);
            p = hold.tick(grip, WEIGHT_N, slipped_m);
        }
        assert_eq!(p.flags & flags::DROP != 0, warned, "after {slip_m} m: {p:?}");
        assert_eq!(p.flags & (flags::SLIP_1 | flags::SLIP_2), 0, "it rests");
    }
}

#[test]
fn friction_is_learnt_from_a_slip_and_stays_within_bounds() {
    let grip = 2.0 * WEIGHT_N / (2.0 * MU);
    let mut hold = Hold::new(grip);
    for _ in 0..250 {
        hold.tick(grip, WEIGHT_N, 0.0);
    }
    // It slips although only half the friction told is used.
    let mut p = Prediction::default();
    for tick in 0..250 {
        p = hold.tick(grip, WEIGHT_N, 0.01 * tick as f32 * DT);
    }
    assert!((p.friction - 0.2).abs() < 0.03, "learnt {}", p.friction);
    assert_ne!(p.flags & flags::UNEXPECTED, 0);
    hold.predictor.reset_friction();
    let p = hold.tick(grip, WEIGHT_N, 0.01);
    assert!((p.friction - MU).abs() < 0.05, "after the reset {}", p.friction);
}

#[test]
fn each_sensor_fault_shows_within_three_samples_and_is_no_silence() {
    type Fault = fn(&mut Sample<f32>, &Sample<f32>);
    let faults: [(&str, u32, Fault); 6] = [
        ("stuck", validity::STUCK, |s, before| s.finger = before.finger),
        ("saturated", validity::SATURATED, |s, _| s.finger[0] = s.finger[0].map(|w| w.map(|x| x + 500.0))),
        ("not finite", validity::WRENCH, |s, _| s.finger[1] = s.finger[1].map(|w| w.map(|_| f32::NAN))),
        ("one missing", validity::ONE_FINGER, |s, _| s.finger[1] = None),
        ("biased", validity::BIASED, |s, _| {
            s.finger[0] = s.finger[0].map(|mut w| {
                w[1] -= 4.0;
                w
            })
        }),
        ("late", validity::SAMPLE, |s, before| s.t_s = before.t_s),
    ];
    for (name, bit, fault) in faults {
        let grip = 2.0 * WEIGHT_N / (2.0 * MU);
        let mut hold = Hold::new(grip);
        let mut before = hold.sample(grip, WEIGHT_N, 0.0);
        for tick in 0..300 {
            before = hold.sample(grip, WEIGHT_N, 0.0);
            let p = hold.predictor.tick(&before);
            assert!(tick < 2 || p.validity == 0, "{name}: validity {:b} at tick {tick}", p.validity);
        }
        let p = (0..3).map(|_| {
            let mut sample = hold.sample(grip, WEIGHT_N, 0.0);
            fault(&mut sample, &before);
            hold.predictor.tick(&sample)
        });
        let last = p.last().unwrap();
        assert_ne!(last.validity & bit, 0, "{name} not shown: {:b}", last.validity);
        assert_ne!(last.flags & flags::UNSURE, 0, "{name}: flags do not say that they are unsure");
    }
}

fn number() -> impl Strategy<Value = f32> {
    prop_oneof![
        8 => -10.0f32..10.0,
        1 => prop::num::f32::ANY,
        1 => Just(0.0f32),
    ]
}

fn pose() -> impl Strategy<Value = Option<Pose<f32>>> {
    let position = prop::array::uniform3(number());
    let quaternion = prop_oneof![
        4 => Just([1.0f32, 0.0, 0.0, 0.0]),
        1 => Just([0.0f32, 1.0, 0.0, 0.0]),
        1 => prop::array::uniform4(number()),
    ];
    (position, quaternion).prop_map(|(p, q)| Pose::new(p, q))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn arbitrary_samples_never_panic_and_times_are_never_nan(
        samples in prop::collection::vec(
            (number(), number(), pose(), pose(), prop::array::uniform2(prop::option::of(prop::array::uniform6(number())))),
            1..40,
        )
    ) {
        let mut hold = Hold::new(5.0);
        let mut t_s = 0.0;
        for (step, grip_cmd_n, gripper, object, finger) in samples {
            t_s += if step > 9.0 { step } else { DT };
            let p = hold.predictor.tick(&Sample { t_s, grip_cmd_n, gripper, object, pusher: None, finger });
            prop_assert!(p.drop_in_s.is_none_or(|t| t >= 0.0));
            prop_assert!(p.finger.iter().all(|f| !f.slip.in_s().is_some_and(f32::is_nan)));
        }
    }
}

/// The gripper sways by 40 mm at 1.5 Hz for four seconds and the object with it; its pose is `late_s` late, and slips by
/// 1 mm at 3.1 s. When a slip is flagged, by a predictor that is told of `told_s`.
fn slips_flagged_s(late_s: f32, told_s: f32) -> Vec<f32> {
    let mut model = model();
    let mut parameters = [0.0; MAX_PARAMETERS];
    parameters[0] = told_s;
    model.effects.push(Effect { code: mocap_latency::INFO.code, parameters }).unwrap();
    let mut hold = Hold::new(20.0);
    hold.predictor = Predictor::new(scene(), model, Limits::default()).unwrap();
    let place_m = |t_s: f32| 0.04 * (9.42 * t_s.max(0.0)).sin();
    (0..1000)
        .filter_map(|tick| {
            let t_s = tick as f32 * DT;
            let slipped_m = if t_s - late_s > 3.1 { 1e-3 } else { 0.0 };
            let mut sample = hold.sample(20.0, WEIGHT_N, slipped_m);
            // Its mass is borne along X.
            for w in sample.finger.iter_mut().flatten() {
                w[0] -= 0.5 * 0.2 * 9.42 * 9.42 * place_m(t_s);
            }
            sample.gripper = Some(Pose { position_m: Vec3::new(place_m(t_s), 0.0, 0.0), ..Pose::identity() });
            if let Some(object) = &mut sample.object {
                object.position_m.x += place_m(t_s - late_s);
            }
            let p = hold.predictor.tick(&sample);
            (p.flags & (flags::SLIP_1 | flags::SLIP_2) != 0).then_some(t_s)
        })
        .collect()
}

#[test]
fn poses_that_are_late_or_early_as_the_model_knows_raise_no_alarm_and_show_the_slip_as_late_as_they_are() {
    for late_s in [0.048, 0.0055, 0.001, -0.001, -0.0055] {
        let told = slips_flagged_s(late_s, late_s);
        let first = told.first().copied().unwrap_or(f32::INFINITY);
        assert!((3.1..3.13 + late_s.max(0.0)).contains(&first), "{late_s} s late and told: {first}");
    }
    // Not told, they slide with every move.
    let untold = slips_flagged_s(0.048, 0.0);
    assert!(untold.first().is_some_and(|t| *t < 1.0), "{untold:?}");
}

#[test]
fn a_grasp_that_rests_just_below_the_limit_is_a_state_and_no_alarm() {
    for pose in [true, false] {
        let grip = 1.06 * WEIGHT_N / (2.0 * MU);
        let mut hold = Hold { pose, ..Hold::new(grip) };
        for tick in 0..15_000 {
            let p = hold.tick(grip, WEIGHT_N, 0.0);
            assert_eq!(p.flags & ALARMS, 0, "pose {pose}, tick {tick}: {p:?}");
            if tick > 100 {
                let used = p.finger[0].measured_utilisation.unwrap_or(f32::NAN);
                assert!(used > 0.75, "utilisation {used} at tick {tick}");
                let holds = p.holding_grip_n.expect("a held grasp");
                assert!(holds > grip, "a grip of {holds} holds with margin");
            }
        }
    }
}

#[test]
fn knocks_that_move_nothing_raise_no_alarm_even_beyond_the_friction_told() {
    let grip = 2.0 * WEIGHT_N / (2.0 * MU);
    let mut hold = Hold::new(grip);
    for tick in 0..10_000u32 {
        // 40 ms every 0.7 s; the last ones need 1.1 times the friction told.
        let phase = (tick % 175) as f32 / 5.0 - 1.0;
        let knock = (1.0 - phase.abs()).max(0.0) * 1.2 * (tick as f32 / 10_000.0) * WEIGHT_N;
        let p = hold.tick(grip, WEIGHT_N + knock, 0.0);
        assert_eq!(p.flags & ALARMS, 0, "tick {tick}: {p:?}");
    }
}

#[test]
fn an_effect_of_the_model_on_friction_moves_the_limit_that_the_load_is_held_against() {
    use stickslip_shared::effects::Effect;
    let grip = 2.0 * WEIGHT_N / (2.0 * MU);
    let used = |effect: Option<Effect<f32>>| {
        let mut model = model();
        model.effects.extend(effect);
        let mut hold = Hold::new(grip);
        hold.predictor = Predictor::new(scene(), model, Limits::default()).unwrap();
        let mut p = Prediction::default();
        for _ in 0..300 {
            p = hold.tick(grip, WEIGHT_N, 0.0);
        }
        p.finger[0].measured_utilisation.unwrap_or(f32::NAN)
    };
    // mu (N / 20 N)^(-1/3) at this grip.
    let mut effect = Effect::<f32>::neutral("load_dependent_friction").unwrap();
    effect.parameters[0] = 1.0 / 3.0;
    let factor = (grip / 20.0).powf(-1.0 / 3.0);
    let (plain, with) = (used(None), used(Some(effect)));
    assert!((plain / with / factor - 1.0).abs() < 0.05, "{plain} against {with}, factor {factor}");
}

#[test]
fn the_default_prediction_and_the_first_one_say_neither_slip_nor_drop() {
    let first = Hold::new(20.0).tick(20.0, WEIGHT_N, 0.0);
    for p in [Prediction::default(), first] {
        assert_eq!(p.flags, 0, "{p:?}");
        assert!(p.finger.iter().all(|f| f.slip == Slip::None && f.slip.in_s().is_none()), "{p:?}");
        assert_eq!((p.drop_in_s, p.holding_grip_n), (None, None));
    }
    assert_ne!(first.validity & validity::NO_FORESIGHT, 0, "nothing lies behind the first");
}

#[test]
fn a_start_anew_is_unsure_while_a_wrench_is_missing_and_after_a_gap() {
    for (missing, later_s) in [(true, 0.0), (false, 2.0)] {
        let grip = 1.5 * WEIGHT_N / (2.0 * MU);
        let mut hold = Hold::new(grip);
        if later_s > 0.0 {
            hold.tick(grip, WEIGHT_N, 0.0);
            hold.tick(grip, WEIGHT_N, 0.0);
        }
        let mut first = hold.sample(grip, WEIGHT_N, 0.0);
        first.t_s += later_s;
        if missing {
            first.finger[1] = None;
        }
        let p = hold.predictor.tick(&first);
        assert_ne!(p.validity & validity::NO_FORESIGHT, 0, "it begins: {p:?}");
        assert_ne!(p.flags & flags::UNSURE, 0, "{p:?}");
        assert_eq!(p.flags & ALARMS, 0);
    }
}
