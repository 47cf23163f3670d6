//! A host that tells its clock: what it measured long before the tick is no measurement of the tick. With the product's
//! firmware in QEMU (`make hil`).

use std::time::{Duration, Instant};

use stickslip_device::Device;
use stickslip_device::clock::Clock;
use stickslip_device::session::{self, Event, Pace};
use stickslip_lab::held::Held;
use stickslip_shared::model::{Base, Friction, Model};
use stickslip_shared::predictor::{flags, validity};
use stickslip_shared::wire::{self, TelemetryReport};

/// Samples of a run.
const COUNT: u32 = 60;

/// A run of samples, one every two ticks, with the host's time `late` before they are sent; its reports on samples. The clock
/// counts from `zero`.
fn run(device: &mut Device, zero: Instant, clock: Option<&Clock>, late: Duration) -> Vec<TelemetryReport> {
    run_every(device, zero, clock, late, Duration::from_millis(8))
}

fn run_every(
    device: &mut Device,
    zero: Instant,
    clock: Option<&Clock>,
    late: Duration,
    every: Duration,
) -> Vec<TelemetryReport> {
    let friction = Friction { finger: 0.4, pusher: 0.25, support: 0.3 };
    let package = Held::Plate.package(&Model::base(Base::Hard, friction), COUNT, 0.0);
    device.load_model(&package.bytes().unwrap()).unwrap();
    session::await_model(device).unwrap();
    let start = wire::StartRequest { source: wire::Source::Link, trial: 0.0, prefill: 1, length: None };
    device.command::<wire::Start>(&start).unwrap();
    if let Some(clock) = clock {
        device.tell_clock(clock).unwrap();
    }
    device.forget_reports();
    let mut reports = Vec::new();
    for sample in &package.samples {
        let sent = Instant::now();
        let t_us = (sent - zero).saturating_sub(late).as_micros() as u32;
        assert!(sample.finger.iter().all(Option::is_some), "the samples have wrenches");
        device.publish::<wire::Samples>(sample.seq, &wire::Sample { t_us, ..*sample }).unwrap();
        while sent.elapsed() < every {
            let report = device.report(Duration::from_millis(1)).unwrap();
            reports.extend(report.filter(|report| report.sample_seq.is_some()));
        }
    }
    // What still waits on the board.
    while let Some(report) = device.report(Duration::from_millis(50)).unwrap() {
        if report.sample_seq.is_none() && report.waiting == 0 {
            break;
        }
        reports.extend(report.sample_seq.map(|_| report));
    }
    device.command::<wire::Stop>(&()).unwrap();
    std::thread::sleep(Duration::from_millis(50));
    reports
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn a_late_stream_of_a_host_that_told_its_clock_is_flagged_and_not_taken_for_the_present() {
    let name = super::named("STICKSLIP_FIRMWARE", "hil");
    let mut device = Device::open(&format!("qemu:{}", name.to_string_lossy())).unwrap();
    let zero = Instant::now();
    // Time enough for a run that counts from before `zero`.
    std::thread::sleep(Duration::from_millis(300));
    let exchanges = device.exchange_clocks_since(zero, 20, Duration::from_millis(5)).unwrap();
    let clock = Clock::of(&exchanges).expect("a clock");
    // Without a pose too a tick has no sample, or waits for a first one.
    let none = validity::NO_WRENCH | validity::SAMPLE | validity::WAITING;
    let unmeasured =
        |reports: &[TelemetryReport]| reports.iter().filter(|r| r.prediction.validity & none != 0).count();
    let late = run(&mut device, zero, Some(&clock), Duration::from_millis(100));
    let present = run(&mut device, zero, Some(&clock), Duration::ZERO);
    // A start forgets the clock: without it a sample is of the tick that takes it.
    let untold = run(&mut device, zero, None, Duration::from_millis(100));
    println!(
        "not measured: {} of {} late, {} of {} present, {} of {} untold",
        unmeasured(&late),
        late.len(),
        unmeasured(&present),
        present.len(),
        unmeasured(&untold),
        untold.len()
    );
    assert!([&late, &present, &untold].iter().all(|reports| reports.len() > COUNT as usize / 2));
    assert_eq!(unmeasured(&late), late.len());
    assert!(late.iter().all(|report| report.prediction.flags & flags::UNSURE != 0));
    assert!(unmeasured(&present) < present.len(), "a sample of now is a measurement");
    assert!(untold.iter().all(|r| r.prediction.validity & validity::NO_WRENCH == 0));
    assert!(device.statistics().unwrap().readings_dropped as usize >= late.len());
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn samples_of_a_host_whose_clock_is_twice_as_fast_never_pile_up_on_a_board_that_was_told_it() {
    let mut device = Device::open(&super::device::firmware()).unwrap();
    let zero = Instant::now();
    let exchanges = device.exchange_clocks_since(zero, 20, Duration::from_millis(5)).unwrap();
    let clock = Clock::of(&exchanges).expect("a clock");
    let before = device.statistics().unwrap().readings_dropped;
    let reports = run_every(&mut device, zero, Some(&clock), Duration::ZERO, Duration::from_millis(2));
    let left_out = COUNT as usize - reports.len();
    let dropped = (device.statistics().unwrap().readings_dropped - before) as usize;
    println!("{} of {COUNT} samples taken, {dropped} too old", reports.len());
    // One a tick would have taken all of them, the last ones 120 ms late.
    assert!(left_out > 0 && dropped >= left_out, "{left_out} left out, {dropped} counted");
    assert_eq!(reports.last().and_then(|r| r.sample_seq), Some(COUNT - 1), "the newest is taken");
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn a_trial_streamed_by_this_machines_clock_keeps_its_times_on_the_board_and_what_came_too_late_is_counted() {
    let package = super::device::package();
    let mut device = Device::open(&super::device::firmware()).unwrap();
    let mut reports = Vec::new();
    let outcome = session::stream(&mut device, &package, Pace::Host, None, &mut |event| {
        if let Event::Report(report) = event {
            reports.extend(report.sample_seq.map(|seq| (seq, *report)));
        }
        Ok(())
    })
    .expect("a run");
    let clock = outcome.clock.expect("it was told");
    let wanted = |seq: u32| clock.board_s(f64::from(package.samples[seq as usize].t_us) * 1e-6) * 1e6;
    for (seq, report) in &reports {
        let off_us = report.at_us.wrapping_sub(wanted(*seq) as i64 as u32).cast_signed();
        assert!(off_us.abs() <= 2, "sample {seq}: measured {off_us} us beside its time by the told clock");
    }
    assert_eq!((outcome.first_difference, outcome.unknown_from), (None, None));
    assert!(outcome.compared > 0 && outcome.equal == outcome.compared);
    // Each that is missing was left out for a newer one; of those taken, the old ones had no wrench.
    let left_out = outcome.samples - outcome.taken;
    let none = validity::NO_WRENCH | validity::SAMPLE | validity::WAITING;
    let unmeasured = reports.iter().filter(|(_, r)| r.prediction.validity & none != 0).count();
    let too_old = outcome.too_old as usize;
    println!("{} taken, {too_old} too old, {left_out} left out, {unmeasured} not measured", outcome.taken);
    assert!((left_out..=left_out + unmeasured).contains(&too_old));
    assert_eq!(outcome.statistics.samples_lost, 0);
}
