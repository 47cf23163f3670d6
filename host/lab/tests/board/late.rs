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
/// How long a report may take by this machine's clock, which is not the board's.
const PATIENCE: Duration = Duration::from_secs(20);

/// A unit in a run of samples that the host sends, told `clock`; and the samples.
fn begin(device: &mut Device, clock: Option<&Clock>) -> Vec<wire::Sample> {
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
    assert!(package.samples.iter().all(|s| s.finger.iter().all(Option::is_some)), "they have wrenches");
    package.samples
}

fn end(device: &mut Device) {
    device.command::<wire::Stop>(&()).unwrap();
    super::device::await_info(device, |info| info.mode == wire::Mode::Ready);
}

/// A report on a sample, and how old that was in its tick by the board's own clock, us.
struct Taken {
    report: TelemetryReport,
    age_us: i32,
}

/// The report on a sample that was just sent.
fn await_report(device: &mut Device, seq: u32) -> TelemetryReport {
    let sent = Instant::now();
    loop {
        assert!(sent.elapsed() < PATIENCE, "sample {seq} was not taken");
        let report = device.report(Duration::from_millis(5)).unwrap();
        if let Some(report) = report.filter(|report| report.sample_seq == Some(seq)) {
            return report;
        }
    }
}

/// A tick's number, and when it began by the board's clock, us: the time of a sample of a host that did not tell its clock.
fn beat(device: &mut Device) -> (u32, u32) {
    let first = begin(device, None)[0];
    device.publish::<wire::Samples>(first.seq, &first).unwrap();
    let report = await_report(device, first.seq);
    end(device);
    (report.tick, report.at_us)
}

/// A run of samples, each sent when the one before was taken, with the host's time of what the board's clock said just now less
/// `late`: a busy machine stops the emulated clock, and the time of its own that a sample waits on this machine is in its age.
fn run(device: &mut Device, zero: Instant, told: &Clock, tell: bool, late: Duration) -> Vec<Taken> {
    let (tick, at_us) = beat(device);
    let samples = begin(device, tell.then_some(told));
    let mut taken = Vec::new();
    for sample in &samples {
        let exchange = device.exchange_clocks_since(zero, 1, Duration::ZERO).unwrap()[0];
        let board_s = exchange.board_s[1] - late.as_secs_f64();
        let drift = told.drift.unwrap_or(0.0);
        let host_s = told.at_s + (board_s - told.at_s - told.offset_s) / (1.0 + drift);
        let t_us = (host_s * 1e6) as u32;
        device.publish::<wire::Samples>(sample.seq, &wire::Sample { t_us, ..*sample }).unwrap();
        let report = await_report(device, sample.seq);
        let now_us = at_us + report.tick.wrapping_sub(tick) * wire::TICK_US;
        taken.push(Taken { report, age_us: now_us.wrapping_sub(report.at_us).cast_signed() });
    }
    end(device);
    taken
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn a_late_stream_of_a_host_that_told_its_clock_is_flagged_and_not_taken_for_the_present() {
    let name = super::named("STICKSLIP_FIRMWARE", "hil");
    let mut device = Device::open(&format!("qemu:{}", name.to_string_lossy())).unwrap();
    let zero = Instant::now();
    // Time enough for a run that counts from before `zero`.
    std::thread::sleep(Duration::from_millis(300));
    super::device::await_ticks(&mut device, 75);
    let exchanges = device.exchange_clocks_since(zero, 20, Duration::from_millis(5)).unwrap();
    let clock = Clock::of(&exchanges).expect("a clock");
    // Without a pose too a tick has no sample, or waits for a first one.
    let none = validity::NO_WRENCH | validity::SAMPLE | validity::WAITING;
    let measured = |taken: &Taken| taken.report.prediction.validity & none == 0;
    let late = run(&mut device, zero, &clock, true, Duration::from_millis(100));
    let present = run(&mut device, zero, &clock, true, Duration::ZERO);
    // A start forgets the clock: without it a sample is of the tick that takes it.
    let untold = run(&mut device, zero, &clock, false, Duration::from_millis(100));
    for (name, taken) in [("late", &late), ("present", &present), ("untold", &untold)] {
        let number = taken.iter().filter(|taken| measured(taken)).count();
        let ages: Vec<i32> = taken.iter().map(|taken| taken.age_us).collect();
        let (least, most) = (ages.iter().min(), ages.iter().max());
        println!("{name}: {number} of {} measured, {least:?} to {most:?} us old", taken.len());
        assert!(taken.len() > COUNT as usize / 2);
    }
    assert!(late.iter().all(|taken| taken.age_us > 99_000 && !measured(taken)));
    assert!(late.iter().all(|taken| taken.report.prediction.flags & flags::UNSURE != 0));
    // A tick begins within 0.2 ms of its time. How old a sample became on its way is this machine's matter.
    let longest_us = 5 * wire::TICK_US as i32 / 2;
    for taken in &present {
        let Taken { report, age_us } = taken;
        if report.prediction.validity & validity::WAITING != 0 {
            // It waits for a first pose, or settles on the table.
            continue;
        }
        assert!(measured(taken) || *age_us > longest_us - 200, "{age_us} us: {report:?}");
        assert!(*age_us < longest_us + 200 || !measured(taken), "{age_us} us: {report:?}");
    }
    assert!(present.iter().any(measured), "a sample of now is a measurement");
    assert!(untold.iter().all(|taken| taken.report.prediction.validity & validity::NO_WRENCH == 0));
    assert!(device.statistics().unwrap().readings_dropped as usize >= late.len());
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn samples_of_a_host_whose_clock_is_twice_as_fast_never_pile_up_on_a_board_that_was_told_it() {
    let mut device = Device::open(&super::device::firmware()).unwrap();
    let zero = Instant::now();
    // A busy machine may hold this program up until it is no faster than the board: then once more.
    let faster = (0..50).any(|_| {
        let exchanges = device.exchange_clocks_since(zero, 20, Duration::from_millis(5)).unwrap();
        let clock = Clock::of(&exchanges).expect("a clock");
        let before = device.statistics().unwrap();
        let mut reports = Vec::new();
        let mut hear = |device: &mut Device, wait: Duration| {
            let report = device.report(wait).unwrap();
            reports.extend(report.filter(|report| report.sample_seq.is_some()));
            report
        };
        for sample in begin(&mut device, Some(&clock)) {
            let sent = Instant::now();
            let t_us = (sent - zero).as_micros() as u32;
            device.publish::<wire::Samples>(sample.seq, &wire::Sample { t_us, ..sample }).unwrap();
            while sent.elapsed() < Duration::from_millis(2) {
                hear(&mut device, Duration::from_millis(1));
            }
        }
        // What still waits on the board, or on its way there: until ticks came without any.
        let (sent, mut without) = (Instant::now(), 0);
        while without < 10 {
            assert!(sent.elapsed() < PATIENCE);
            if let Some(report) = hear(&mut device, Duration::from_millis(50)) {
                let nothing = report.sample_seq.is_none() && report.waiting == 0;
                without = if nothing { without + 1 } else { 0 };
            }
        }
        end(&mut device);
        let after = device.statistics().unwrap();
        // By the board's own count: reports may be lost on a line that nobody reads.
        let left_out = COUNT - reports.last().map_or(0, |report| report.taken);
        let dropped = after.readings_dropped - before.readings_dropped;
        let no_room = after.samples_dropped - before.samples_dropped;
        let spanned = reports.first().zip(reports.last()).map(|(first, last)| last.tick - first.tick + 1);
        println!("{} of {COUNT} samples taken in {spanned:?} ticks, {dropped} too old", reports.len());
        assert!(dropped + no_room >= left_out, "{left_out} left out, {dropped} and {no_room} counted");
        if no_room > 0 || after.reports_dropped > before.reports_dropped {
            // This machine stopped one of the two for longer than its queue holds.
            return false;
        }
        assert_eq!(reports.last().and_then(|r| r.sample_seq), Some(COUNT - 1), "the newest is taken");
        // One a tick would have taken all of them, the last ones 120 ms late.
        spanned.is_some_and(|ticks| ticks < COUNT * 3 / 4) && left_out > 0
    });
    assert!(faster, "this machine never sent faster than the board ticks");
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn a_trial_streamed_by_this_machines_clock_keeps_its_times_on_the_board_and_what_came_too_late_is_counted() {
    // Where a busy machine stops this program for so long that reports find no room, it is not known what the board took: once
    // more.
    let complete = (0..10).any(|_| a_trial_by_this_machines_clock_is_told_in_whole());
    assert!(complete, "reports were lost each time");
}

/// `false`: reports were lost; what was told is judged all the same.
fn a_trial_by_this_machines_clock_is_told_in_whole() -> bool {
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
    assert_eq!(outcome.first_difference, None);
    if outcome.reports_lost > 0 || outcome.statistics.reports_dropped > 0 {
        return false;
    }
    assert_eq!(outcome.unknown_from, None);
    assert!(outcome.compared > 0 && outcome.equal == outcome.compared);
    // Each that is missing was left out for a newer one, or found no room while this machine stopped the board for longer than
    // its queue holds; of those taken, the old ones had no wrench.
    let no_room = outcome.statistics.samples_dropped as usize;
    let left_out = outcome.samples - outcome.taken;
    let none = validity::NO_WRENCH | validity::SAMPLE | validity::WAITING;
    let unmeasured = reports.iter().filter(|(_, r)| r.prediction.validity & none != 0).count();
    let too_old = outcome.too_old as usize;
    println!(
        "{} taken, {too_old} too old, {no_room} without room, {left_out} left out, {unmeasured} not measured",
        outcome.taken
    );
    assert!((left_out..=left_out + unmeasured).contains(&(too_old + no_room)));
    assert_eq!(outcome.statistics.samples_lost, 0);
    true
}
