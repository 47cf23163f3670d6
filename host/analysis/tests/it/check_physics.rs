//! Data that physics does not allow are found and named: one clean bench, one mistake each.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use stickslip_analysis::check::physics::{Cause, Means, Unknown};
use stickslip_analysis::check::{Report, check};
use stickslip_data::{Dataset, Index, Pose, Sample, write};
use stickslip_rig::{Condition, Nuisance, Primitive, Reality, STEP_S, Setup, objects, run};

/// Three trials of each of `primitives`, as the rig measures them.
fn bench(primitives: &[Primitive]) -> Dataset {
    let description = objects::bench("clean");
    let reality = Reality::draw(&description, Nuisance::PAPER, 4);
    let names: Vec<_> = primitives.iter().map(|p| p.name()).collect();
    let setup = Setup { description, reality, step_s: STEP_S };
    let mut trials = Vec::new();
    for primitive in primitives {
        let object = match primitive {
            Primitive::Roll => "obj1",
            Primitive::PlanarPush => "rectangle",
            _ => "obj4",
        };
        let grip_n = if *primitive == Primitive::Roll { 3.0 } else { 20.0 };
        let known = setup.description.objects.iter().any(|o| o.id == object);
        let fallback = setup.description.objects.iter().find(|o| o.shape == "polygon").map(|o| o.id.clone());
        let object = if known { object.to_owned() } else { fallback.expect("a polygon") };
        for speed_m_s in [0.01, 0.02, 0.03] {
            let label = format!("{}-{}", primitive.name(), (speed_m_s * 1e3) as u32);
            let condition =
                Condition { label, grip_n, speed_m_s, edge: 2, ..Condition::new(*primitive, &object) };
            trials.push(run(&setup, &condition, 1, 9).expect("suits the rig").trial);
        }
    }
    let used: Vec<_> = trials.iter().map(|t| t.info.object.as_str()).collect();
    let description = objects::trimmed(setup.description.clone(), &names, &used);
    Dataset { folder: PathBuf::new(), description, trials }
}

fn pushes() -> &'static Dataset {
    static MADE: OnceLock<Dataset> = OnceLock::new();
    MADE.get_or_init(|| bench(&[Primitive::LinearPush]))
}

fn everything() -> &'static Dataset {
    static MADE: OnceLock<Dataset> = OnceLock::new();
    MADE.get_or_init(|| {
        bench(&[
            Primitive::LinearPush,
            Primitive::Pivot,
            Primitive::Roll,
            Primitive::Lift,
            Primitive::PlanarPush,
        ])
    })
}

fn report(dataset: &Dataset) -> Report {
    let folder = tempfile::tempdir().expect("folder");
    write(dataset, folder.path()).expect("written");
    check(&Index::open(folder.path()).expect("readable"), &())
}

/// Causes found after `change` was made to the pushes, with the text.
fn causes(of: &Dataset, change: impl Fn(&mut Dataset)) -> (Vec<Cause>, String) {
    let mut changed = of.clone();
    change(&mut changed);
    let report = report(&changed);
    assert_eq!(report.errors, Vec::<String>::new());
    let text: Vec<String> = report.findings.iter().map(ToString::to_string).collect();
    (report.findings.iter().map(|f| f.cause).collect(), text.join("\n"))
}

fn samples(dataset: &mut Dataset, change: impl Fn(&mut Sample)) {
    dataset.trials.iter_mut().flat_map(|trial| &mut trial.samples).for_each(change);
}

fn poses(dataset: &mut Dataset, change: impl Fn(&mut Pose)) {
    for trial in &mut dataset.trials {
        trial.info.pusher.iter_mut().for_each(&change);
        for s in &mut trial.samples {
            [&mut s.gripper, &mut s.object, &mut s.pusher].into_iter().flatten().for_each(&change);
        }
    }
}

fn wrenches(sample: &mut Sample) -> impl Iterator<Item = &mut stickslip_data::Wrench> {
    let [a, b] = &mut sample.finger;
    [a, b, &mut sample.pusher_wrench].into_iter().flatten()
}

#[test]
fn clean_data_of_every_primitive_have_no_finding() {
    let report = report(everything());
    assert_eq!(report.findings, vec![], "{:?}", report.findings);
    assert_eq!(report.balance.failing, 0);
}

#[test]
fn repetitions_that_differ_by_noise_alone_have_a_floor_of_that_noise() {
    let description = objects::bench("noise");
    let reality = Reality::draw(&description, Nuisance { noise: 1.0, ..Nuisance::NONE }, 4);
    let setup = Setup { description, reality, step_s: STEP_S };
    let condition = Condition {
        label: "same".into(),
        grip_n: 20.0,
        speed_m_s: 0.02,
        travel: 0.004,
        ..Condition::new(Primitive::LinearPush, "obj4")
    };
    let trials = (1..=12).map(|k| run(&setup, &condition, k, 9).expect("suits the rig").trial).collect();
    let description = objects::trimmed(setup.description.clone(), &["linear_push"], &["obj4"]);
    let report = report(&Dataset { folder: PathBuf::new(), description, trials });
    for channel in report.channels.iter().filter(|c| c.channel.starts_with("object")) {
        let (white, floor) = (channel.white.expect("noise"), channel.floor[0].expect("repetitions"));
        assert!((floor / white - 1.0).abs() < 0.12, "{}: {white:.1e} {floor:.1e}", channel.channel);
    }
}

#[test]
fn the_demonstration_data_have_no_finding() {
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo");
    let report = check(&Index::open(&demo).expect("readable"), &());
    assert_eq!(report.findings, vec![], "{:?}", report.findings);
}

#[test]
fn positions_in_millimetres_are_named() {
    let (found, text) = causes(everything(), |d| poses(d, |p| p.position_m = p.position_m.map(|x| 1e3 * x)));
    assert!(found.contains(&Cause::LengthUnit) && text.contains("Positions in mm?"), "{text}");
}

#[test]
fn torques_in_newton_millimetres_are_named_for_fingers_and_pusher() {
    let turn = |d: &mut Dataset| {
        samples(d, |s| wrenches(s).for_each(|w| w.torque_nm = w.torque_nm.map(|t| 1e3 * t)));
    };
    let (found, text) = causes(pushes(), turn);
    assert!(found.iter().all(|c| *c == Cause::TorqueUnit), "{text}");
    assert!(text.contains("finger1_t") && text.contains("pusher_t") && text.contains("N mm?"), "{text}");
}

#[test]
fn exchanged_fingers_are_named() {
    let (found, text) = causes(everything(), |d| samples(d, |s| s.finger.swap(0, 1)));
    assert_eq!(found, vec![Cause::FingersSwapped], "{text}");
    assert!(text.contains("finger 1 and finger 2 exchanged"), "{text}");
}

#[test]
fn wrenches_on_the_fingers_in_place_of_those_on_the_object_are_named() {
    let negate = |w: &mut stickslip_data::Wrench| {
        w.force_n = w.force_n.map(|f| -f);
        w.torque_nm = w.torque_nm.map(|t| -t);
    };
    let (found, text) = causes(pushes(), |d| samples(d, |s| wrenches(s).for_each(negate)));
    assert!(found.iter().all(|c| *c == Cause::SignsTurned) && !found.is_empty(), "{text}");
    // Of the fingers alone, and of the pusher alone.
    let (found, text) = causes(pushes(), |d| samples(d, |s| s.finger.iter_mut().flatten().for_each(negate)));
    assert!(found.contains(&Cause::SignsTurned) && !found.contains(&Cause::FingersSwapped), "{text}");
    let (found, text) = causes(pushes(), |d| samples(d, |s| s.pusher_wrench.iter_mut().for_each(negate)));
    assert!(found.contains(&Cause::SignsTurned) && text.contains("pusher_f"), "{text}");
}

#[test]
fn a_mass_in_grams_is_named_by_density_and_by_the_weight_that_is_carried() {
    let (found, text) = causes(pushes(), |d| d.description.objects.iter_mut().for_each(|o| o.mass_kg *= 1e3));
    assert_eq!(found, vec![Cause::MassUnit; 2], "{text}");
    assert!(text.contains("grams? write 0.201 kg"), "{text}");
}

#[test]
fn time_in_milliseconds_or_microseconds_is_named() {
    for (factor, unit) in [(1e3, "milliseconds"), (1e6, "microseconds")] {
        let (found, text) = causes(pushes(), |d| samples(d, |s| s.t_s *= factor));
        assert_eq!(found, vec![Cause::TimeUnit], "{text}");
        assert!(text.contains(unit), "{text}");
    }
}

#[test]
fn quaternions_that_end_with_w_are_named() {
    let last = |p: &mut Pose| p.quaternion.rotate_left(1);
    let (found, text) = causes(pushes(), |d| poses(d, last));
    assert!(!found.is_empty() && found.iter().all(|c| *c == Cause::QuaternionOrder), "{text}");
    let (found, text) = causes(&bench(&[Primitive::PlanarPush]), |d| poses(d, last));
    assert!(found.contains(&Cause::QuaternionOrder), "{text}");
    // Nothing but a habit tells where the gripper is turned about gravity and nothing pushes sideways.
    let mut lifts = bench(&[Primitive::Lift]);
    poses(&mut lifts, last);
    let warnings: Vec<String> = report(&lifts).warnings.iter().map(ToString::to_string).collect();
    assert!(warnings.iter().any(|w| w.contains("x,y,z,w")), "{warnings:?}");
}

#[test]
fn a_column_that_only_one_finger_has_is_named() {
    let (found, text) =
        causes(pushes(), |d| samples(d, |s| s.finger[0].iter_mut().for_each(|w| w.force_n[2] = f64::NAN)));
    assert_eq!(found, vec![Cause::MissingColumn], "{text}");
    assert!(text.contains("finger1_fz_n"), "{text}");
}

#[test]
fn a_grip_that_is_not_stated_is_named() {
    let (found, text) = causes(pushes(), |d| d.trials.iter_mut().for_each(|t| t.info.grip_n = None));
    assert_eq!(found, vec![Cause::MissingGrip], "{text}");
}

/// All poses so many samples late.
fn late(dataset: &mut Dataset, samples: i64) {
    for trial in &mut dataset.trials {
        let old = trial.samples.clone();
        for (k, s) in trial.samples.iter_mut().enumerate() {
            let from = (k as i64 - samples).clamp(0, old.len() as i64 - 1) as usize;
            (s.gripper, s.object, s.pusher) = (old[from].gripper, old[from].object, old[from].pusher);
        }
    }
}

#[test]
fn poses_28_ms_late_or_early_are_found_within_five_by_the_pushers_force_or_the_fingers_alone() {
    for (samples_late, by_pusher) in [(7_i64, true), (-7, true), (7, false), (-7, false)] {
        let shift = |d: &mut Dataset| {
            late(d, samples_late);
            if !by_pusher {
                samples(d, |s| s.pusher_wrench = None);
            }
        };
        let (found, text) = causes(pushes(), shift);
        assert_eq!(found, vec![Cause::ClockOffset], "{text}");
        let (late, early) = if samples_late > 0 { ("poses", "forces") } else { ("forces", "poses") };
        let start = format!("the {late} are ");
        let ms = text.split(&start).nth(1).and_then(|rest| rest.split(" ms").next()?.parse::<f64>().ok());
        let ms = ms.unwrap_or_else(|| panic!("not {start}: {text}"));
        assert!((ms - 28.0).abs() <= 5.0 && text.contains(early), "{text}");
    }
}

/// Forces that rise in a straight line during so many samples before the object moves in the grasp, as between stiff pads on an arm
/// that bends.
fn rising_before(dataset: &mut Dataset, samples: usize) {
    for trial in &mut dataset.trials {
        let force =
            |s: &Sample| s.pusher_wrench.map_or(0.0, |w| w.force_n.iter().map(|f| f * f).sum::<f64>());
        let touched = trial.samples.iter().position(|s| force(s) > 1.0).expect("pushed");
        let level = trial.samples[touched + 10];
        for k in 0..samples {
            let share = (k + 1) as f64 / samples as f64;
            let s = &mut trial.samples[touched - samples + k];
            let to = [level.finger[0], level.finger[1], level.pusher_wrench];
            for (w, to) in wrenches(s).zip(to.into_iter().flatten()) {
                for (x, to) in w.force_n.iter_mut().zip(to.force_n) {
                    *x += share * (to - *x);
                }
                for (x, to) in w.torque_nm.iter_mut().zip(to.torque_nm) {
                    *x += share * (to - *x);
                }
            }
        }
        for s in &mut trial.samples[touched..touched + 10] {
            (s.finger, s.pusher_wrench) = (level.finger, level.pusher_wrench);
        }
    }
}

#[test]
fn an_object_that_moves_when_the_force_has_risen_and_not_before_is_no_sign_of_two_clocks() {
    let (found, text) = causes(pushes(), |d| rising_before(d, 6));
    assert!(found.is_empty(), "{text}");
    let both = |d: &mut Dataset| {
        rising_before(d, 6);
        late(d, 12);
    };
    let (found, text) = causes(pushes(), both);
    assert_eq!(found, vec![Cause::ClockOffset], "{text}");
}

#[test]
fn the_report_says_by_what_the_clocks_were_compared_and_where_they_cannot_be() {
    let of = |report: &Report, primitive: &str| {
        report.clocks.iter().find(|c| c.primitive == primitive).cloned().expect("listed")
    };
    let report_of = |lateness: i64| {
        let mut data = everything().clone();
        late(&mut data, lateness);
        report(&data)
    };
    let clean = report_of(0);
    let push = of(&clean, "linear_push");
    assert_eq!(push.compared, Some((Means::PusherContact, 3)));
    assert!(push.behind_s.is_some_and(|[s, _]| s.abs() < 0.008), "{push:?}");
    // Nothing tells the clocks of a lift apart, right or wrong: that is said.
    for report in [clean, report_of(7)] {
        let lift = of(&report, "lift");
        assert_eq!((lift.compared, lift.unknown.as_slice()), (None, [(Unknown::NoContact, 3)].as_slice()));
    }
    let mut blind = pushes().clone();
    samples(&mut blind, |s| (s.pusher_wrench, s.finger) = (None, [None; 2]));
    assert_eq!(of(&report(&blind), "linear_push").unknown, [(Unknown::NoForce, 3)]);
}

#[test]
fn a_mass_that_is_wrong_by_half_is_a_possible_cause_of_the_imbalance() {
    let (found, text) = causes(pushes(), |d| d.description.objects.iter_mut().for_each(|o| o.mass_kg *= 2.0));
    assert_eq!(found, vec![Cause::Balance], "{text}");
    assert!(text.contains("a wrong mass (the forces carry 0."), "{text}");
}

#[test]
fn a_primitive_without_known_intent_is_named_with_those_that_are_known() {
    let mut renamed = pushes().clone();
    let contact = renamed.description.pushers.remove("linear_push").expect("a plate");
    renamed.description.pushers.insert("linear_pusch".into(), contact);
    renamed.trials.iter_mut().for_each(|t| t.info.primitive = "linear_pusch".into());
    let warnings: Vec<String> = report(&renamed).warnings.iter().map(ToString::to_string).collect();
    let named =
        |w: &String| w.contains("linear_pusch (did you mean linear_push?)") && w.contains("planar_push");
    assert!(warnings.iter().any(named), "{warnings:?}");
}

#[test]
fn sensors_about_which_nothing_is_stated_are_a_loud_warning_and_no_perfect_sensors() {
    use stickslip_analysis::evidence::sensors::sensors_or_estimated;
    let mut silent = pushes().clone();
    silent.description.sensors = Default::default();
    let told = report(&silent);
    let warnings: Vec<String> = told.warnings.iter().map(ToString::to_string).collect();
    assert!(warnings.iter().any(|w| w.contains("SENSOR UNCERTAINTY NOT STATED")), "{warnings:?}");
    assert_eq!(told.balance.failing, 0, "a bound of zero would fail everywhere");
    let used = sensors_or_estimated(&silent.description, silent.trials.iter());
    let stated = &pushes().description.sensors;
    // Noise as it was made; uncertainty 1 % of some 20 N.
    let near = |found: f64, made: f64| (found / made - 1.0).abs() < 0.15;
    assert!(near(used.sensors.finger.force_noise_n, stated.finger.force_noise_n), "{used:?}");
    assert!(near(used.sensors.pose.position_noise_m, stated.pose.position_noise_m), "{used:?}");
    assert!(near(used.sensors.pose.rotation_noise_rad, stated.pose.rotation_noise_rad), "{used:?}");
    assert!((0.2..0.3).contains(&used.sensors.finger.force_uncertainty_n), "{used:?}");
    assert!(!used.unstated.uncertainty.is_empty() && !used.taken.is_empty());
    let full = sensors_or_estimated(&pushes().description, pushes().trials.iter());
    assert!(full.unstated.is_empty() && &full.sensors == stated, "{full:?}");
}
