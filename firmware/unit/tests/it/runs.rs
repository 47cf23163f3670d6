//! Runs: how they begin and end, where a tick's sample comes from, and how old it may be.

use stickslip_selftest::push;
use stickslip_shared::predictor::{Prediction, flags, validity};
use stickslip_shared::wire::{
    self, Calibration, HostClock, Mode, Port, Recalled, Refusal, Sensor, Sensors, Source, StartRequest,
    TICK_US, TelemetryReport,
};
use stickslip_unit::alarm::Alarms;
use stickslip_unit::bus::{WRENCH_ID, Wrench};

use super::bench::{Unit, alarms, bytes, now_us, sample, set_counts};
use super::flash::SharedFlash;

const LINK: StartRequest = StartRequest { source: Source::Link, trial: 0.0, prefill: 1, length: None };
const UNIT: StartRequest = StartRequest { source: Source::Unit, ..LINK };

/// Row k of the matrix: so much a count.
fn matrix(per_count: f32) -> [[f32; 6]; 6] {
    core::array::from_fn(|i| core::array::from_fn(|j| if i == j { per_count } else { 0.0 }))
}

fn gauges() -> Sensors {
    [0, 1].map(|finger| Sensor { port: Port::Gauges, finger }).into_iter().collect()
}

#[test]
fn a_run_begins_with_a_model_once_and_ends_when_told_or_after_its_length() {
    let mut unit = Unit::start(None);
    assert_eq!(unit.request::<wire::Start>(&LINK), Err(Refusal::NoModel));
    // Stopping what does not run changes nothing.
    assert_eq!(unit.request::<wire::Stop>(&()), Ok(()));
    unit.tick();
    assert_eq!(unit.between.mode(), Mode::Safe);
    assert_eq!(unit.load(&bytes(&push(0.2, 0.4)), wire::CHUNK), Ok(()));
    unit.tick();
    assert_eq!(unit.request::<wire::Start>(&LINK), Ok(()));
    unit.tick();
    assert_eq!(unit.between.mode(), Mode::Running);
    for refused in [LINK, UNIT] {
        assert_eq!(unit.request::<wire::Start>(&refused), Err(Refusal::Busy));
    }
    assert_eq!(unit.request::<wire::SetSensors>(&gauges()), Err(Refusal::Busy));
    assert_eq!(unit.request::<wire::Store>(&None), Err(Refusal::Busy));
    assert_eq!(unit.request::<wire::Forget>(&()), Err(Refusal::Busy));
    assert_eq!(unit.request::<wire::Stop>(&()), Ok(()));
    unit.tick();
    assert_eq!(unit.between.mode(), Mode::Ready);
    assert_eq!(unit.request::<wire::Start>(&StartRequest { length: Some(3), ..LINK }), Ok(()));
    for seq in 0..5 {
        unit.publish(&sample(seq, seq * 4000));
    }
    let taken: Vec<_> = (0..5).filter_map(|_| unit.tick()?.sample_seq).collect();
    assert_eq!((taken, unit.between.mode()), (vec![0, 1, 2], Mode::Ready));
    // What nobody asked for any more is counted when the next run begins.
    assert_eq!(unit.request::<wire::Start>(&LINK), Ok(()));
    assert_eq!(unit.between.counters.samples_unasked.get(), 2);
}

#[test]
fn a_run_on_the_units_sensors_needs_a_sensor_and_a_matrix_of_each_finger() {
    let mut unit = Unit::ready();
    assert_eq!(unit.request::<wire::Start>(&UNIT), Err(Refusal::NoSensor { finger: 0 }));
    assert_eq!(unit.request::<wire::SetSensors>(&gauges()), Ok(()));
    assert_eq!(unit.request::<wire::Start>(&UNIT), Err(Refusal::NotCalibrated { finger: 0 }));
    let calibration = |finger| Calibration { finger, matrix: matrix(0.01) };
    assert_eq!(unit.request::<wire::SetCalibration>(&calibration(0)), Ok(()));
    assert_eq!(unit.request::<wire::Start>(&UNIT), Err(Refusal::NotCalibrated { finger: 1 }));
    assert_eq!(unit.request::<wire::SetCalibration>(&calibration(1)), Ok(()));
    assert_eq!(unit.request::<wire::Start>(&UNIT), Ok(()));
}

#[test]
fn a_run_waits_for_the_samples_it_asked_for_and_not_for_ever() {
    let mut unit = Unit::ready();
    assert_eq!(unit.request::<wire::Start>(&StartRequest { prefill: 4, ..LINK }), Ok(()));
    let taken = |unit: &mut Unit| unit.tick().and_then(|report| report.sample_seq);
    assert!((0..300).all(|_| taken(&mut unit).is_none()), "nothing came");
    for seq in 0..3 {
        unit.publish(&sample(seq, seq * 4000));
    }
    assert_eq!(unit.between.counters.starved.get(), 0, "that is by intention");
    let waited = (0..200).take_while(|_| taken(&mut unit).is_none()).count();
    assert_eq!(waited, 124, "one of four was lost: half a second is enough");
    assert_eq!((taken(&mut unit), taken(&mut unit)), (Some(1), Some(2)));
    assert_eq!(taken(&mut unit), None);
    assert_eq!(unit.between.counters.starved.get(), 1);
}

#[test]
fn without_a_run_all_lines_are_down_and_in_a_run_a_tick_without_a_sample_is_not_sure() {
    let mut unit = Unit::ready();
    assert_eq!(alarms(), Alarms { slip: false, drop: false, sure: false });
    assert_eq!(unit.request::<wire::Start>(&LINK), Ok(()));
    let first = unit.tick().expect("of a run");
    assert_eq!(first.prediction.flags, flags::UNSURE);
    assert_eq!(first.prediction.validity, validity::WAITING);
    for seq in 0..40 {
        unit.publish(&sample(seq, seq * 4000));
        let report = unit.tick().expect("of a run");
        assert_eq!(alarms().sure, report.prediction.flags & flags::UNSURE == 0, "{report:?}");
    }
    assert!(alarms().sure);
    unit.tick();
    assert_eq!(alarms(), Alarms { slip: false, drop: false, sure: false });
    unit.publish(&sample(40, 41 * 4000));
    unit.tick();
    assert!(alarms().sure);
    assert_eq!(unit.request::<wire::Stop>(&()), Ok(()));
    unit.tick();
    assert!(!alarms().sure);
}

#[test]
fn samples_of_a_host_that_told_its_clock_are_as_old_as_they_are_and_the_newest_is_taken() {
    let mut unit = Unit::ready();
    assert_eq!(unit.request::<wire::Start>(&LINK), Ok(()));
    // The host's clock is 7 s ahead.
    let host_us = |ago_us: u32| now_us().wrapping_add(7_000_000).wrapping_sub(ago_us);
    let clock = HostClock { host_us: host_us(0), board_us: now_us(), drift: 0.0 };
    unit.tick();
    assert_eq!(unit.request::<wire::SetClock>(&clock), Ok(()));
    let mut seq = 0;
    // So many ticks without a sample, then these: no sample is of a time before the last.
    let mut run = |unit: &mut Unit, ticks: u32, ages_us: &[u32]| {
        for _ in 0..ticks {
            unit.tick();
        }
        for age_us in ages_us {
            unit.publish(&sample(seq, host_us(*age_us)));
            seq += 1;
        }
        unit.tick().expect("of a run")
    };
    for _ in 0..30 {
        let report = run(&mut unit, 0, &[0]);
        assert_eq!(now_us() - report.at_us, TICK_US, "measured a tick ago");
    }
    let report = run(&mut unit, 0, &[0]);
    assert_eq!(report.prediction.validity & validity::UNRELIABLE, 0, "{report:?}");
    // 12 ms and a tick: its wrenches are of the past, its poses are not.
    let report = run(&mut unit, 4, &[12_000]);
    assert_ne!(report.prediction.validity & validity::NO_WRENCH, 0, "{report:?}");
    assert_eq!(report.prediction.validity & validity::SAMPLE, 0, "{report:?}");
    let report = run(&mut unit, 20, &[80_000]);
    assert_ne!(report.prediction.validity & validity::SAMPLE, 0, "{report:?}");
    assert_ne!(report.prediction.flags & flags::UNSURE, 0);
    // A host that was held up sends all at once: the first that is young enough is taken, each left out is counted.
    let before = unit.between.counters.readings_dropped.get();
    let report = run(&mut unit, 10, &[40_000, 36_000, 32_000, 5_000, 1_000]);
    assert_eq!((report.sample_seq, now_us() - report.at_us), (Some(36), 9_000));
    assert_eq!(unit.between.counters.readings_dropped.get() - before, 3);
    // A sample of a time to come is none.
    let ahead = host_us(0).wrapping_add(3_000_000);
    unit.publish(&sample(38, ahead));
    unit.tick();
    let report = unit.tick().expect("of a run");
    assert_ne!(report.prediction.validity & validity::SAMPLE, 0, "{report:?}");
}

#[test]
fn in_a_run_on_its_sensors_the_host_gives_poses_and_the_sensors_wrenches_each_for_as_long_as_it_stands() {
    let mut unit = Unit::ready();
    assert_eq!(unit.request::<wire::SetSensors>(&gauges()), Ok(()));
    for finger in 0..2 {
        assert_eq!(
            unit.request::<wire::SetCalibration>(&Calibration { finger, matrix: matrix(0.01) }),
            Ok(())
        );
    }
    unit.tick();
    assert_eq!(unit.request::<wire::Start>(&UNIT), Ok(()));
    // 20 N of each finger, 0.98 N of weight: counts about the middle of the range, none twice.
    let counts = |k: u32| {
        let noise = ((k * 7) % 5) as i32 - 2;
        let finger = |side: i32| [0, side * 2000, 98, 0, 0, 0].map(|x| (2047 + x + noise) as u16);
        let [a, b] = [finger(-1), finger(1)].map(|f| f.map(|count| count.clamp(20, 4075)));
        let mut all = [0; 12];
        all[..6].copy_from_slice(&a);
        all[6..].copy_from_slice(&b);
        all
    };
    let step = |unit: &mut Unit, k: u32, host: bool, sound: bool| {
        set_counts(sound.then(|| counts(k)));
        if host {
            // The host's own wrenches are not what is measured.
            unit.publish(&wire::Sample { finger: [Some([9e3; 6]); 2], ..sample(k, k * 4000) });
        }
        unit.tick().expect("of a run").prediction.validity
    };
    for k in 0..40 {
        step(&mut unit, k, true, true);
    }
    let sound = step(&mut unit, 40, true, true);
    assert_eq!(sound & (validity::NO_WRENCH | validity::SATURATED | validity::SAMPLE), 0, "{sound:#x}");
    let before = unit.between.counters.readings_damaged.get();
    let failed = step(&mut unit, 41, true, false);
    assert_ne!(failed & validity::NO_WRENCH, 0, "a conversion that failed is no measurement: {failed:#x}");
    assert_eq!(unit.between.counters.readings_damaged.get() - before, 1);
    // Without the host its poses stand for 20 ms, then there is no sample.
    let silent: Vec<u32> = (42..52).map(|k| step(&mut unit, k, false, true)).collect();
    let stood = silent.iter().take_while(|bits| *bits & validity::SAMPLE == 0).count();
    assert_eq!(stood, 5, "{silent:x?}");
}

#[test]
fn a_run_on_the_units_sensors_reports_when_the_oldest_of_its_readings_was_measured() {
    let mut unit = Unit::ready();
    let sensors = [0, 1].map(|finger| Sensor { port: Port::Can, finger }).into_iter().collect();
    assert_eq!(unit.request::<wire::SetSensors>(&sensors), Ok(()));
    for finger in 0..2 {
        let calibration = Calibration { finger, matrix: matrix(1.0) };
        assert_eq!(unit.request::<wire::SetCalibration>(&calibration), Ok(()));
    }
    unit.tick();
    assert_eq!(unit.request::<wire::Start>(&UNIT), Ok(()));
    // Measured 700 us and 2.5 ms before they came, every eighth tick only.
    let mut last_us = None;
    for k in 0..64_u32 {
        if k % 8 == 0 {
            for (finger, age_us) in [(0, 700), (1, 2500)] {
                let wrench = Wrench {
                    age_us,
                    period_us: 32_000,
                    counter: (k / 8) as u8,
                    valid: true,
                    values: [1.0; 6],
                };
                let came_us = now_us();
                unit.sensors
                    .take(unit.between, |hub| hub.frame(WRENCH_ID + finger, &wrench.encode(), came_us));
            }
            last_us = Some(now_us() - 2500);
        }
        let report = unit.tick().expect("of a run");
        assert_eq!(Some(report.at_us), last_us, "tick {k}");
    }
    // They stand for 50 ms at most.
    let report = (0..10).filter_map(|_| unit.tick()).last().expect("of a run");
    assert_eq!(report.at_us, now_us(), "nothing is measured: the tick's");
}

#[test]
fn what_is_stored_is_there_after_a_start_and_a_run_begins_by_itself() {
    let flash = SharedFlash::new();
    let mut unit = Unit::start(Some(flash.clone()));
    assert_eq!(unit.load(&bytes(&push(0.2, 0.4)), wire::CHUNK), Ok(()));
    unit.tick();
    assert_eq!(unit.request::<wire::SetUnit>(&7), Ok(()));
    assert_eq!(unit.request::<wire::SetGrip>(&15.0), Ok(()));
    assert_eq!(unit.request::<wire::Store>(&Some(LINK)), Ok(()));
    let mut again = Unit::start(Some(flash.clone()));
    let info = again.request::<wire::GetInfo>(&());
    assert_eq!((info.recalled, info.unit, info.model_crc), (Recalled::Done, 7, unit.between.model_crc()));
    again.publish(&sample(0, 0));
    let report = again.tick().expect("it runs");
    assert_eq!((report.mode, report.sample_seq), (Mode::Running, Some(0)));
    // In a run nothing is written.
    assert_eq!(again.request::<wire::Store>(&None), Err(Refusal::Busy));
    assert_eq!(again.request::<wire::Stop>(&()), Ok(()));
    again.tick();
    assert_eq!(again.request::<wire::Forget>(&()), Ok(()));
    let mut empty = Unit::start(Some(flash));
    assert_eq!(empty.request::<wire::GetInfo>(&()).recalled, Recalled::Empty);
    assert_eq!(Unit::start(None).request::<wire::Store>(&None), Err(Refusal::NoMemory));
}

#[test]
fn a_store_of_a_run_with_a_number_that_is_none_is_refused_and_nothing_is_stored() {
    let flash = SharedFlash::new();
    let mut unit = Unit::start(Some(flash.clone()));
    assert_eq!(unit.load(&bytes(&push(0.2, 0.4)), wire::CHUNK), Ok(()));
    unit.tick();
    for none in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30] {
        let answer = unit.request::<wire::Store>(&Some(StartRequest { trial: none, ..LINK }));
        assert!(matches!(answer, Err(Refusal::OutOfRange { .. })), "{answer:?} to {none}");
    }
    assert_eq!(Unit::start(Some(flash)).request::<wire::GetInfo>(&()).recalled, Recalled::Empty);
}

#[test]
fn in_a_run_a_model_of_the_same_scene_is_taken_and_of_another_refused_and_the_run_goes_on() {
    let mut unit = Unit::ready();
    assert_eq!(unit.request::<wire::Start>(&LINK), Ok(()));
    unit.tick();
    let crc = unit.between.model_crc();
    assert_eq!(unit.load(&bytes(&push(0.3, 0.4)), wire::CHUNK), Err(Refusal::OtherScene));
    unit.tick();
    assert_eq!((unit.between.mode(), unit.between.model_crc()), (Mode::Running, crc));
    assert_eq!(unit.load(&bytes(&push(0.2, 0.5)), wire::CHUNK), Ok(()));
    unit.tick();
    assert_eq!(unit.between.mode(), Mode::Running);
    assert_ne!(unit.between.model_crc(), crc);
}

/// Flags and validity of the newest state that was handed to the bus, and its time.
fn said_on_the_bus(unit: &Unit) -> (u32, u32, u32) {
    let last = std::iter::from_fn(|| unit.between.states.try_receive()).last().expect("a state");
    (last.flags, last.validity, last.at_us)
}

/// The next report and state outside a run.
fn idle(unit: &mut Unit) -> (TelemetryReport, (u32, u32, u32)) {
    while unit.between.states.try_receive().is_some() {}
    let report = (0..25).find_map(|_| unit.tick()).expect("ten a second");
    (report, said_on_the_bus(unit))
}

#[test]
fn a_tick_without_a_sample_says_on_the_bus_that_it_is_unsure_and_keeps_the_last_samples_time() {
    let mut unit = Unit::ready();
    assert_eq!(unit.request::<wire::Start>(&LINK), Ok(()));
    unit.tick();
    let (flags, validity, _) = said_on_the_bus(&unit);
    assert_eq!((flags, validity), (flags::UNSURE, validity::WAITING), "nothing came yet");
    let mut last = TelemetryReport::default();
    for seq in 0..40 {
        unit.publish(&sample(seq, seq * 4000));
        last = unit.tick().expect("of a run");
        let Prediction { flags, validity, .. } = last.prediction;
        assert_eq!(said_on_the_bus(&unit), (flags, validity, now_us()));
    }
    assert_eq!(last.prediction.flags & flags::UNSURE, 0);
    for _ in 0..3 {
        let starved = unit.tick().expect("of a run");
        let flags = last.prediction.flags | flags::UNSURE;
        let validity = last.prediction.validity | validity::SAMPLE;
        assert_eq!(said_on_the_bus(&unit), (flags, validity, last.at_us));
        let told = &starved.prediction;
        assert_eq!((starved.sample_seq, told.flags, told.validity), (None, flags, validity));
        assert_eq!((starved.at_us, starved.hash), (last.at_us, last.hash));
    }
    // The next sample is predicted from as ever.
    unit.publish(&sample(40, 43 * 4000));
    unit.tick();
    let (flags, validity, at_us) = said_on_the_bus(&unit);
    assert_eq!((flags & flags::UNSURE, validity & validity::SAMPLE, at_us), (0, 0, now_us()));
}

#[test]
fn without_a_run_report_and_bus_say_that_nothing_is_predicted_whatever_a_run_said_before() {
    let mut unit = Unit::ready();
    let nothing = (flags::UNSURE, validity::WAITING);
    let (before, bus) = idle(&mut unit);
    assert_eq!((before.prediction.flags, before.prediction.validity), nothing);
    assert_eq!((bus.0, bus.1), nothing);
    let idles = before.prediction;
    for length in [None, Some(40)] {
        assert_eq!(unit.request::<wire::Start>(&StartRequest { length, ..LINK }), Ok(()));
        let mut last = TelemetryReport::default();
        for seq in 0..40 {
            unit.publish(&sample(seq, seq * 4000));
            last = unit.tick().expect("of a run");
        }
        assert_eq!(last.prediction.flags & flags::UNSURE, 0, "also the last of a run's length is told");
        if length.is_none() {
            assert_eq!(unit.request::<wire::Stop>(&()), Ok(()));
        }
        for _ in 0..2 {
            let (report, bus) = idle(&mut unit);
            assert_eq!((report.mode, report.prediction), (Mode::Ready, idles), "{length:?}");
            assert_eq!(bus, (nothing.0, nothing.1, last.at_us), "{length:?}");
        }
    }
}
