//! The firmware in QEMU at the end of a good, a bad and a cut line. `make hil` builds the
//! firmware and names it in `STICKSLIP_FIRMWARE`; without it these tests are ignored.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::port::Port;
use stickslip_analysis::run::replay::{Feed, feed};
use stickslip_data::Index;
use stickslip_device::clock::Clock;
use stickslip_device::log;
use stickslip_device::package::Package;
use stickslip_device::session::{self, Event, Outcome, Pace};
use stickslip_device::{Device, DeviceError};
use stickslip_lab::held::{Held, NOISE_M};
use stickslip_shared::model::{Base, Formulation, Friction, Model};
use stickslip_shared::predictor::{Predictor, validity};
use stickslip_shared::wire::{self, Mode, Recalled, Refusal, ResetCause};

pub(super) fn firmware() -> String {
    format!("qemu:{}", super::named("STICKSLIP_FIRMWARE", "hil").to_string_lossy())
}

fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo")
}

pub(super) fn package() -> Package {
    let index = Index::open(&data()).expect("the demo's data");
    let trial = index.read_trial(&index.trials[0]).expect("its first trial");
    let friction = Friction { finger: 0.4, pusher: 0.25, support: 0.3 };
    let Feed { scene, plan, samples, .. } = feed(&index.description, &trial).expect("its scene");
    Package::new(scene, &Model::base(Base::Hard, friction), plan, samples, 0)
}

fn stream(device: &mut Device, package: &Package, faults: Option<u64>) -> Outcome {
    session::stream(device, package, Pace::Board, faults, &mut |_| Ok(())).expect("a run")
}

/// How long a board may take by this machine's clock, which is not its own.
const PATIENCE: Duration = Duration::from_secs(30);

/// Asks again until the board says what is awaited: after how much of this machine's time is not in its hands.
pub(super) fn await_info(device: &mut Device, what: impl Fn(&wire::Info) -> bool) -> wire::Info {
    let began = Instant::now();
    loop {
        let info = device.request::<wire::GetInfo>(&()).unwrap();
        if what(&info) {
            return info;
        }
        assert!(began.elapsed() < PATIENCE, "{info:?}");
        std::thread::sleep(Duration::from_millis(4));
    }
}

/// Waits until the board's tick was reached so many times more.
pub(super) fn await_ticks(device: &mut Device, more: u32) {
    let began = Instant::now();
    let from = device.statistics().unwrap().ticks;
    while device.statistics().unwrap().ticks.wrapping_sub(from) < more {
        assert!(began.elapsed() < PATIENCE, "{more} ticks");
        std::thread::sleep(Duration::from_millis(4));
    }
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn every_prediction_of_a_streamed_push_equals_the_hosts() {
    let name = firmware();
    let outcome = stream(&mut Device::open(&name).unwrap(), &package(), None);
    assert_eq!(outcome.taken, outcome.samples);
    assert_eq!(outcome.first_difference, None);
    assert!(outcome.equal > 0 && outcome.equal == outcome.compared);
    assert_eq!(outcome.unknown_from, None);
    // Time is instructions while the host is at the line: this machine's load has no part in it.
    assert_eq!(outcome.ticks_missed, 0);
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn a_bad_line_costs_what_was_done_to_it_and_every_loss_is_counted() {
    let name = firmware();
    let outcome = stream(&mut Device::open(&name).unwrap(), &package(), Some(5));
    let injected = outcome.injected.expect("faults were asked for");
    let counted = outcome.statistics;
    assert!(injected.lost > 0 && injected.damaged > 0 && injected.overtaken > 0 && injected.garbage > 0);
    // What comes late is missing first. A loss at the very end has no successor to show it.
    let missing = injected.lost + injected.damaged + injected.overtaken;
    // A host that a busy machine held up may send more than there is room for: that is a loss of its own, and counted.
    let no_room = counted.samples_dropped;
    assert!(
        counted.samples_lost <= missing && counted.samples_lost + 2 >= missing,
        "{injected:?} {counted:?}"
    );
    assert_eq!(counted.samples_reordered, injected.overtaken);
    assert_eq!(counted.samples_repeated, injected.repeated);
    assert_eq!(counted.frames_damaged + counted.frames_too_long, injected.damaged + injected.garbage);
    assert_eq!(counted.samples as usize, outcome.taken);
    assert_eq!(outcome.taken + (missing + no_room) as usize, outcome.samples);
    // One before the first of the run has none before it to show it.
    let hidden = injected.reports_lost - outcome.reports_lost.min(injected.reports_lost);
    assert!(outcome.reports_lost <= injected.reports_lost && hidden <= 1, "{outcome:?}");
    assert_eq!(outcome.first_difference, None);
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn a_serial_port_carries_the_same_push_bit_for_bit() {
    let name = firmware();
    // This line's clock goes on while a busy machine stops the emulator: its watchdog may then end the run. Once more.
    let outcome = (0..10).find_map(|_| {
        let (_qemu, port) = Port::open(name.trim_start_matches("qemu:"));
        let mut device = Device::open(&port).unwrap();
        match session::stream(&mut device, &package(), Pace::Board, None, &mut |_| Ok(())) {
            Ok(outcome) => Some(outcome),
            Err(error) => match error.downcast_ref::<DeviceError>() {
                Some(DeviceError::Restarted { .. }) => None,
                _ => panic!("{error:?}"),
            },
        }
    });
    let outcome = outcome.expect("a run that the watchdog lets end");
    assert_eq!((outcome.taken, outcome.first_difference), (outcome.samples, None));
    assert!(outcome.equal > 0 && outcome.equal == outcome.compared);
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn a_line_cut_in_the_middle_is_told_and_the_log_keeps_what_happened_before() {
    let name = firmware();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let header = log::Header { scene: vec![], model: vec![], meta: serde_json::Value::Null };
    let mut log = log::Writer::create(&path, &header).unwrap();
    let mut device = Device::open(&name).unwrap();
    let emulator = device.emulator().expect("QEMU");
    let mut reports = 0;
    let result = session::stream(&mut device, &package(), Pace::Board, None, &mut |event| {
        if let Event::Report(report) = event {
            reports += 1;
            log.record(0, log::Entry::Telemetry(report)).unwrap();
            if reports == 60 {
                Command::new("kill").args(["-9", &emulator.to_string()]).status()?;
            }
        }
        Ok(())
    });
    let error = result.expect_err("the line was cut");
    let fault = error.downcast_ref::<DeviceError>();
    assert!(matches!(fault, Some(DeviceError::Cut { .. } | DeviceError::Silent { .. })), "{error}");
    drop(log);
    let kept = log::read(&path).unwrap();
    assert_eq!((kept.records.len(), kept.lost.len()), (reports, 0));
    assert!(reports >= 60);
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn garbage_before_the_first_word_does_not_keep_the_board_from_answering() {
    let name = firmware();
    let mut device = Device::open(&name).unwrap();
    for burst in [&[0xff; 700][..], &[0; 40], &[1, 2, 3, 0, 5, 0, 200, 7, 7, 0]] {
        device.write_raw(burst).unwrap();
    }
    device.write_raw(&[0]).unwrap();
    let statistics = device.statistics().unwrap();
    assert_eq!(statistics.frames_too_long, 1);
    assert_eq!(statistics.frames_damaged, 3);
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn a_refused_command_names_field_value_and_limits_and_changes_nothing() {
    let name = firmware();
    let mut device = Device::open(&name).unwrap();
    let error = device.command::<wire::SetGrip>(&1e9).unwrap_err();
    assert!(matches!(error, DeviceError::Refused { refusal: Refusal::OutOfRange { .. }, .. }), "{error}");
    assert!(error.to_string().contains("Grip is 1000000000, allowed is 0 to 500"), "{error}");
    let request = wire::StartRequest { source: wire::Source::Link, trial: 0.0, prefill: 1, length: None };
    let error = device.command::<wire::Start>(&request).unwrap_err();
    assert!(matches!(error, DeviceError::Refused { refusal: Refusal::NoModel, .. }), "{error}");
    let mut package = package();
    package.model.1.friction.finger = -1.0;
    let error = device.load_model(&package.bytes().unwrap()).unwrap_err();
    assert!(matches!(error, DeviceError::Refused { refusal: Refusal::Model(_), .. }), "{error}");
    assert_eq!(device.statistics().unwrap().commands_refused, 3);
    assert_eq!(device.request::<wire::GetInfo>(&()).unwrap().mode, Mode::Safe);
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn a_model_of_another_scene_is_refused_in_a_run_which_goes_on() {
    let name = firmware();
    let mut device = Device::open(&name).unwrap();
    let (package, mut other) = (package(), package());
    device.load_model(&package.bytes().unwrap()).unwrap();
    session::await_model(&mut device).unwrap();
    let start = wire::StartRequest { source: wire::Source::Link, trial: 0.0, prefill: 1, length: None };
    device.command::<wire::Start>(&start).unwrap();
    let crc = await_info(&mut device, |info| info.mode == Mode::Running).model_crc;
    other.model.0.object.mass_kg *= 2.0;
    let error = device.load_model(&other.bytes().unwrap()).unwrap_err();
    assert!(matches!(error, DeviceError::Refused { refusal: Refusal::OtherScene, .. }), "{error}");
    await_ticks(&mut device, 25);
    let info = device.request::<wire::GetInfo>(&()).unwrap();
    assert_eq!((info.mode, info.model_crc), (Mode::Running, crc));
    // Another friction is none: it is taken.
    other = package.clone();
    other.model.1.friction.finger *= 1.5;
    device.load_model(&other.bytes().unwrap()).unwrap();
    // Once the run is over any scene is.
    device.command::<wire::Stop>(&()).unwrap();
    await_info(&mut device, |info| info.mode == Mode::Ready);
    other.model.0.object.mass_kg *= 2.0;
    device.load_model(&other.bytes().unwrap()).unwrap();
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn the_board_counts_what_the_other_formulation_says_and_predicts_the_same() {
    let name = firmware();
    let mut package = package();
    package.model.1.witness = true;
    let outcome = stream(&mut Device::open(&name).unwrap(), &package, None);
    assert_eq!((outcome.taken, outcome.first_difference), (outcome.samples, None));
    let counted = outcome.statistics;
    println!("{} steps solved by both, {} of them apart", counted.witnessed, counted.witness_apart);
    // What the same predictor counts here over the same samples.
    let (scene, model, limits) = package.model.clone();
    let mut predictor = Predictor::<f32>::new(scene, model, limits).expect("a sound model");
    predictor.set_trial(package.ordinal);
    predictor.set_plan(package.plan.clone());
    for sample in &package.samples {
        predictor.take(sample);
    }
    let said = predictor.testimony();
    assert_eq!((counted.witnessed, counted.witness_apart), (said.compared, said.compared - said.alike));
    assert!(said.alike > said.compared / 2, "{said:?}");
    assert_eq!(counted.ticks_missed, 0);
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn a_tick_takes_fewer_than_400_000_instructions_in_either_formulation_with_the_other_as_its_witness() {
    let name = firmware();
    for formulation in [Formulation::Cone, Formulation::Lcp] {
        let friction = Friction { finger: 0.4, pusher: 0.25, support: 0.3 };
        let model = Model { formulation, witness: true, ..Model::base(Base::Hard, friction) };
        let mut push = package();
        (push.model.1.formulation, push.model.1.witness) = (formulation, true);
        for (what, package) in [
            ("a push", push),
            ("32 points at rest, measured with noise", Held::Plate.package(&model, 200, NOISE_M)),
            ("36 points at rest", Held::Bar.package(&model, 200, 0.0)),
            ("36 points at rest, measured with noise", Held::Bar.package(&model, 200, NOISE_M)),
        ] {
            let outcome = stream(&mut Device::open(&name).unwrap(), &package, None);
            assert_eq!((outcome.taken, outcome.first_difference), (outcome.samples, None));
            // 8 ns an instruction, 40 ns a count.
            let worst = 5 * outcome.statistics.worst_cost;
            let mean = 5 * outcome.statistics.mean_cost;
            println!("{formulation:?}, {what}: {worst} instructions in the dearest tick, {mean} in the mean");
            assert!(worst < 400_000, "{formulation:?}, {what}: {worst}");
        }
    }
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn a_reset_board_is_safe_says_why_it_started_and_runs_again() {
    let name = firmware();
    let mut device = Device::open(&name).unwrap();
    assert_eq!(device.info().reset_cause, ResetCause::PowerOn);
    stream(&mut device, &package(), None);
    let info = reset(&mut device);
    assert_eq!((info.mode, info.model_crc, info.boots), (Mode::Safe, None, 2));
    assert_eq!(info.reset_cause, ResetCause::WatchdogOrSoftware);
    let outcome = stream(&mut device, &package(), None);
    assert_eq!((outcome.taken, outcome.first_difference), (outcome.samples, None));
}

/// Restarts the board and waits until it answers.
fn reset(device: &mut Device) -> wire::Info {
    let before = device.request::<wire::GetInfo>(&()).unwrap().boots;
    device.command::<wire::ResetBoard>(&()).unwrap();
    // What is asked while the board restarts is not answered: it is asked again.
    let began = Instant::now();
    std::thread::sleep(Duration::from_millis(300));
    loop {
        match device.request::<wire::GetInfo>(&()) {
            Ok(info) if info.boots != before => return info,
            answer => assert!(began.elapsed() < PATIENCE, "{answer:?}"),
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn what_was_stored_is_there_after_a_reset_until_it_is_forgotten() {
    let name = firmware();
    let mut device = Device::open(&name).unwrap();
    assert_eq!((device.info().recalled, device.info().unit), (Recalled::Empty, 0));
    assert_eq!(device.info().post_mortem, None);
    device.load_model(&package().bytes().unwrap()).unwrap();
    session::await_model(&mut device).unwrap();
    device.command::<wire::SetUnit>(&7).unwrap();
    device.command::<wire::Store>(&None).unwrap();
    let info = reset(&mut device);
    assert_eq!((info.recalled, info.unit, info.mode), (Recalled::Done, 7, Mode::Ready));
    assert_eq!(info.model_crc, Some(wire::frame::crc32(&package().bytes().unwrap())));
    let last = info.post_mortem.expect("kept over the reset");
    assert_eq!(last.ending, wire::Ending::Unnoted);
    assert!(last.last.iter().all(|note| note.tick > 0 && note.cost > 0), "{last:?}");
    device.command::<wire::Forget>(&()).unwrap();
    let info = reset(&mut device);
    assert_eq!((info.recalled, info.unit, info.mode), (Recalled::Empty, 0, Mode::Safe));
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn a_unit_that_is_reset_in_mid_grasp_predicts_again_within_100_ms_of_its_clock() {
    let name = firmware();
    let mut device = Device::open(&name).unwrap();
    let package = package();
    device.load_model(&package.bytes().unwrap()).unwrap();
    session::await_model(&mut device).unwrap();
    let start = wire::StartRequest { source: wire::Source::Link, trial: 0.0, prefill: 1, length: None };
    device.command::<wire::Store>(&Some(start)).unwrap();
    device.command::<wire::Start>(&start).unwrap();
    for sample in &package.samples[..50] {
        device.publish::<wire::Samples>(sample.seq, sample).unwrap();
        std::thread::sleep(Duration::from_millis(4));
    }
    // Reports of the run before are still on the line: they have ticks that the unit after its reset reaches much later.
    let mut old_tick = 0;
    let drained = Instant::now();
    while drained.elapsed() < Duration::from_millis(40) || old_tick <= 60 {
        assert!(drained.elapsed() < PATIENCE, "tick {old_tick}");
        old_tick = device.report(Duration::from_millis(1)).unwrap().map_or(old_tick, |report| report.tick);
    }
    device.command::<wire::ResetBoard>(&()).unwrap();
    // The reset comes 20 ms after the answer; the host goes on as if nothing had happened.
    std::thread::sleep(Duration::from_millis(25));
    // How soon a sample comes is this machine's matter. Judged is the unit's time: from its start to where it takes samples, and
    // from the first of them to a prediction, but for ticks in which no sample was there.
    let (mut runs, mut taken, mut predicted) = (None, None, None);
    let mut without = 0;
    let mut samples = package.samples[50..].iter();
    let began = Instant::now();
    while predicted.is_none() {
        assert!(began.elapsed() < PATIENCE, "runs {runs:?}, took {taken:?}");
        if let Some(sample) = samples.next() {
            device.publish::<wire::Samples>(sample.seq, sample).unwrap();
        }
        let sent = Instant::now();
        while sent.elapsed() < Duration::from_millis(4) {
            let Some(report) = device.report(Duration::from_millis(1)).unwrap() else { continue };
            if report.mode != Mode::Running || report.tick >= old_tick {
                continue;
            }
            runs = runs.or(Some(report));
            if report.sample_seq.is_some() {
                taken = taken.or(Some(report));
                // Present and look-ahead, and the flags can be relied on.
                let doubts = validity::UNRELIABLE | validity::NO_FORESIGHT;
                let predicts = report.prediction.validity & doubts == 0;
                predicted = predicted.or(predicts.then_some(report));
            } else if taken.is_some() && predicted.is_none() {
                without += 1;
            }
        }
    }
    let info = device.request::<wire::GetInfo>(&()).unwrap();
    assert_eq!(info.boots, 2);
    let (runs, taken) = (runs.expect("it runs"), taken.expect("a sample arrives"));
    let predicted = predicted.expect("it predicts again");
    let settles_us = predicted.at_us - taken.at_us - without * wire::TICK_US;
    // The host did not tell its clock: a sample is of the tick that takes it.
    let runs_us = taken.at_us - (taken.tick - runs.tick) * wire::TICK_US;
    println!(
        "runs from tick {} ({runs_us} us after the start), predicts {} ticks ({settles_us} us) after its first sample (tick {})",
        runs.tick,
        predicted.tick - taken.tick,
        taken.tick
    );
    assert!(runs_us + settles_us <= 100_000, "{runs_us} + {settles_us} us");
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn settings_that_are_none_are_refused_by_the_board_and_counted() {
    let name = firmware();
    let mut device = Device::open(&name).unwrap();
    let sensor = |port, finger| wire::Sensor { port, finger };
    let twice: wire::Sensors =
        [sensor(wire::Port::Can, 0), sensor(wire::Port::Gauges, 0)].into_iter().collect();
    let error = device.command::<wire::SetSensors>(&twice).unwrap_err();
    assert!(matches!(error, DeviceError::Refused { refusal: Refusal::NoPort, .. }), "{error}");
    let error = device.command::<wire::Tare>(&()).unwrap_err();
    assert!(
        matches!(error, DeviceError::Refused { refusal: Refusal::NoSensor { finger: 0 }, .. }),
        "{error}"
    );
    let singular = wire::Calibration { finger: 1, matrix: [[0.5; 6]; 6] };
    let error = device.command::<wire::SetCalibration>(&singular).unwrap_err();
    assert!(
        matches!(error, DeviceError::Refused { refusal: Refusal::Singular { finger: 1 }, .. }),
        "{error}"
    );
    let start = wire::StartRequest { source: wire::Source::Unit, trial: 0.0, prefill: 0, length: None };
    let error = device.command::<wire::Store>(&Some(start)).unwrap_err();
    assert!(
        matches!(error, DeviceError::Refused { refusal: Refusal::NoSensor { finger: 0 }, .. }),
        "{error}"
    );
    let limits = wire::GripLimits { rise_n_s: f32::NAN, ..Default::default() };
    assert!(device.command::<wire::SetGripLimits>(&limits).is_err());
    let pose = wire::Pose { position_m: [0.0; 3], quaternion: [0.0; 4] };
    assert!(device.command::<wire::SetGrasp>(&Some(wire::Grasp { gripper: pose, object: pose })).is_err());
    assert_eq!(device.statistics().unwrap().commands_refused, 6);
}

/// Sends one command that must be refused.
fn refuse<E: postcard_rpc::Endpoint<Response = wire::Answer>>(
    device: &mut Device,
    request: &E::Request,
) -> u32
where
    E::Request: serde::Serialize,
{
    let error = device.command::<E>(request).expect_err(E::PATH);
    assert!(matches!(error, DeviceError::Refused { .. }), "{}: {error}", E::PATH);
    1
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn after_every_kind_of_bad_command_model_settings_and_predictions_are_the_old_ones() {
    let name = firmware();
    let mut device = Device::open(&name).unwrap();
    let limits = wire::GripLimits { least_n: 5.0, most_n: 10.0, rise_n_s: 100.0, fall_n_s: 2.0 };
    device.command::<wire::SetUnit>(&12).unwrap();
    device.command::<wire::SetGripLimits>(&limits).unwrap();
    device.load_model(&package().bytes().unwrap()).unwrap();
    session::await_model(&mut device).unwrap();
    let crc = device.request::<wire::GetInfo>(&()).unwrap().model_crc;
    let d = &mut device;
    let mut refused = 0;
    for none in [f32::NAN, f32::INFINITY, -1.0, 1e30] {
        refused += refuse::<wire::SetGrip>(d, &none);
        refused += refuse::<wire::SetGripLimits>(d, &wire::GripLimits { most_n: none, ..limits });
        let mut plan = package().plan;
        plan.segments[0].grip_n = none;
        refused += refuse::<wire::SetPlan>(d, &plan);
        let start = wire::StartRequest { source: wire::Source::Link, trial: none, prefill: 8, length: None };
        refused += refuse::<wire::Start>(d, &start);
        refused += refuse::<wire::Store>(d, &Some(start));
        let matrix = [[none; 6]; 6];
        refused += refuse::<wire::SetCalibration>(d, &wire::Calibration { finger: 0, matrix });
        let pose = wire::Pose { position_m: [0.0; 3], quaternion: [none; 4] };
        refused += refuse::<wire::SetGrasp>(d, &Some(wire::Grasp { gripper: pose, object: pose }));
    }
    let two = [wire::Sensor { port: wire::Port::Can, finger: 0 }; 2].into_iter().collect();
    refused += refuse::<wire::SetSensors>(d, &two);
    refused += refuse::<wire::Tare>(d, &());
    let own = wire::StartRequest { source: wire::Source::Unit, trial: 0.0, prefill: 0, length: None };
    refused += refuse::<wire::Start>(d, &own);
    refused += refuse::<wire::Store>(d, &Some(own));
    refused += refuse::<wire::LoadModelChunk>(d, &wire::ModelChunk { offset: 9000, ..Default::default() });
    refused += refuse::<wire::CommitModel>(d, &wire::ModelCommit { length: 1, crc: 0 });
    let mut sliding = package();
    sliding.model.1.friction.finger = f32::NAN;
    assert!(device.load_model(&sliding.bytes().unwrap()).is_err());
    refused += 1;
    // Its bytes have taken the place of those of the model in use.
    refused += refuse::<wire::Store>(&mut device, &None);
    assert_eq!(device.statistics().unwrap().commands_refused, refused);
    let info = device.request::<wire::GetInfo>(&()).unwrap();
    assert_eq!((info.mode, info.model_crc, info.unit), (Mode::Ready, crc, 12));
    // `stream` loads the model: the board's own is compared by its checksum above.
    let mut advised = Vec::new();
    let outcome = session::stream(&mut device, &package(), Pace::Board, None, &mut |event| {
        if let Event::Report(report) = event {
            advised.extend(report.advised_grip_n);
        }
        Ok(())
    })
    .unwrap();
    assert_eq!((outcome.taken, outcome.first_difference), (outcome.samples, None));
    let most = advised.iter().copied().fold(0.0, f32::max);
    assert!(!advised.is_empty() && most <= 10.0, "{most}");
    // Once it was sent again it is stored.
    device.command::<wire::Store>(&None).unwrap();
    let info = reset(&mut device);
    assert_eq!((info.recalled, info.unit, info.mode, info.model_crc), (Recalled::Done, 12, Mode::Ready, crc));
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn a_stack_that_overflows_is_stopped_by_its_guard_spares_the_variables_and_is_told_after_the_reset() {
    let program = super::named("STICKSLIP_OVERFLOW", "hil");
    let output = Command::new("timeout")
        .args(["60", "qemu-system-arm", "-machine", "mps2-an386", "-display", "none", "-monitor", "none"])
        .args(["-serial", "null", "-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(program)
        .stdin(Stdio::null())
        .output()
        .expect("QEMU");
    let said =
        String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("stopped by the guard: true; variables whole: true"), "{said}");
    assert!(output.status.success(), "{said}");
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn a_unit_whose_stored_number_limits_and_grip_are_set_has_them_after_a_reset() {
    let name = firmware();
    let mut device = Device::open(&name).unwrap();
    let limits = wire::GripLimits { least_n: 5.0, most_n: 10.0, rise_n_s: 100.0, fall_n_s: 2.0 };
    device.command::<wire::SetUnit>(&12).unwrap();
    device.command::<wire::SetGrip>(&15.0).unwrap();
    device.command::<wire::SetGripLimits>(&limits).unwrap();
    device.load_model(&package().bytes().unwrap()).unwrap();
    session::await_model(&mut device).unwrap();
    device.command::<wire::Store>(&None).unwrap();
    let info = reset(&mut device);
    assert_eq!((info.recalled, info.unit, info.mode), (Recalled::Done, 12, Mode::Ready));
    // The trial commands 20 N and more: the advice keeps within what is stored.
    let mut advised = Vec::new();
    session::stream(&mut device, &package(), Pace::Board, None, &mut |event| {
        if let Event::Report(report) = event {
            advised.extend(report.advised_grip_n);
        }
        Ok(())
    })
    .unwrap();
    let most = advised.iter().copied().fold(0.0, f32::max);
    assert!(!advised.is_empty() && most <= 10.0, "{most}");
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn the_boards_clock_is_told_with_its_uncertainty() {
    let name = firmware();
    let mut device = Device::open(&name).unwrap();
    let exchanges = device.exchange_clocks(10, Duration::from_millis(10)).unwrap();
    let clock = Clock::of(&exchanges).expect("a clock");
    // A busy machine stops the emulated clock for a while, so each exchange bounds the offset of its own time only.
    let bounds = exchanges.iter().map(|e| (e.board_s[1] - e.answered_s, e.board_s[0] - e.asked_s));
    assert!(
        bounds.clone().all(|(least, most)| least <= most),
        "read between question and answer: {exchanges:?}"
    );
    assert!(exchanges.is_sorted_by(|a, b| a.board_s[1] < b.board_s[0]), "runs on: {exchanges:?}");
    let quickest = bounds.clone().map(|(least, most)| (most - least) / 2.0).reduce(f64::min).unwrap();
    assert!((clock.uncertainty_s - quickest).abs() < 1e-9, "{clock:?} {exchanges:?}");
    let least = bounds.clone().map(|b| b.0).reduce(f64::min).unwrap();
    let most = bounds.map(|b| b.1).reduce(f64::max).unwrap();
    assert!((least..=most).contains(&clock.offset_s), "{clock:?} {exchanges:?}");
}

#[test]
fn a_device_that_is_not_there_is_named_with_what_to_check() {
    let error = Device::open("serial:/dev/no-such-port").err().expect("no such port");
    assert!(error.to_string().contains("/dev/no-such-port: check the cable"), "{error}");
    let error = Device::open("qemu:/no/such/firmware").err().expect("no such file");
    assert!(error.to_string().contains("make firmware"), "{error}");
    assert!(Device::open("bluetooth").err().expect("no such kind").to_string().contains("serial:PORT"));
}
