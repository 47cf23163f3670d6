//! What is looked at while the soak goes on, and what must hold at its end.

use core::sync::atomic::Ordering;

use cortex_m_semihosting::{debug, hprintln};
use embassy_time::{Duration, Ticker, Timer};
use stickslip_firmware::board::current as board;
use stickslip_firmware::queues::BETWEEN;
use stickslip_firmware::stack::BUDGET_BYTES;
use stickslip_shared::wire::TICK_US;
use stickslip_unit::board::Board;
use stickslip_unit::host_clock::MAX_AGE_US;

use crate::done::{DONE, ON_SENSORS, TOLD_US, count, value};
use crate::host::UNIT_SAMPLES;
use crate::sensors;

/// Looks at the line that says 'sure' while a run on the sensors goes on: it must be down where a finger's wrench or the
/// poses are out of date for more than three ticks (one to see it, one for what is on its way, one to spare).
#[embassy_executor::task]
pub async fn watch() -> ! {
    const SPARE_US: i32 = 12_000;
    let mut ticker = Ticker::every(Duration::from_micros(u64::from(TICK_US)));
    let mut since = 0;
    loop {
        ticker.next().await;
        if !ON_SENSORS.load(Ordering::Relaxed) {
            since = 0;
            continue;
        }
        since += 1;
        // The run begins, and with it the first poses.
        if since < 20 {
            continue;
        }
        count(&DONE.unit_ticks);
        if board::ALARM_BITS.load(Ordering::Relaxed) & 4 == 0 {
            continue;
        }
        count(&DONE.sure_ticks);
        let told_us = sensors::now_us().wrapping_sub(value(&TOLD_US)).cast_signed();
        let late = (0..2).any(|finger| sensors::overdue_us(finger) > SPARE_US);
        if late || told_us > MAX_AGE_US as i32 + SPARE_US {
            count(&DONE.unsure_late);
            hprintln!(
                "'sure' in step {} with {:?}: wrenches {} and {} us, poses {} us out of date",
                since,
                sensors::connected(),
                sensors::overdue_us(0),
                sensors::overdue_us(1),
                told_us
            );
        }
    }
}

/// Of a tick: four fifths of what 4 ms hold.
const MOST_INSTRUCTIONS: u32 = 400_000;

#[embassy_executor::task]
pub async fn judge(ticks: u32) {
    // In a run on its sensors the unit counts samples that the host never sent.
    while BETWEEN.counters.ticks.get() < ticks || ON_SENSORS.load(Ordering::Relaxed) {
        Timer::after_millis(100).await;
    }
    let (s, d) = (BETWEEN.counters.read(&board::This::memory()), &DONE);
    let [erasures, worn] = board::erasures();
    let waiting = u32::try_from(BETWEEN.samples.len()).unwrap_or(u32::MAX);
    hprintln!("virtual time {} s: {} ticks, {} missed", s.ticks / 250, s.ticks, s.ticks_missed);
    // 8 ns an instruction, 40 ns a count.
    hprintln!("instructions a tick: mean {}, worst {}", s.mean_cost * 5, s.worst_cost * 5);
    hprintln!(
        "stack: {} of {} bytes at the deepest; static, with this program: {}",
        s.stack_bytes,
        BUDGET_BYTES,
        s.static_bytes
    );
    hprintln!(
        "done: {} samples sound, {} lost, {} damaged, {} overtaken, {} repeated, {} bursts of garbage, {} sensor faults",
        value(&d.sound),
        value(&d.lost),
        value(&d.damaged),
        value(&d.overtaken),
        value(&d.repeated),
        value(&d.garbage),
        value(&d.sensor_faults)
    );
    hprintln!(
        "board: {} processed, {} dropped, {} unasked, {} waiting, {} missing, {} late, {} repeated",
        s.samples,
        s.samples_dropped,
        s.samples_unasked,
        waiting,
        s.samples_lost,
        s.samples_reordered,
        s.samples_repeated
    );
    hprintln!(
        "board: {} frames damaged, {} too long; {} samples marked, {} contact problems unsolved",
        s.frames_damaged,
        s.frames_too_long,
        s.sensor_marks,
        s.solver_marks
    );
    hprintln!(
        "commands: {} sent, {} answered; {} bad, {} refused; {} models sent, {} put to use",
        value(&d.requests),
        value(&d.answers),
        value(&d.refused),
        s.commands_refused,
        value(&d.models),
        s.model_swaps
    );
    hprintln!(
        "reports: {} received, {} missing, {} dropped; the host stopped reading {} times",
        value(&d.reports),
        value(&d.reports_missing),
        s.reports_dropped,
        value(&d.stalls)
    );
    hprintln!(
        "sensors: {} readings lost, {} damaged or disturbed, {} refused, {} saturated; {} gauge faults ({} scans failed, {} saturated)",
        value(&d.readings_lost),
        value(&d.readings_damaged),
        value(&d.readings_refused),
        value(&d.saturated),
        value(&d.gauge_faults),
        value(&d.scans_failed),
        value(&d.scans_saturated)
    );
    hprintln!(
        "{} times unplugged, {} bus off, {} host silent, {} clock steps; board: {} damaged, {} lost, {} dropped, {} starved",
        value(&d.unplugged),
        value(&d.bus_off),
        value(&d.silences),
        value(&d.clock_steps),
        s.readings_damaged,
        s.readings_lost,
        s.readings_dropped,
        s.starved
    );
    hprintln!(
        "bus: {} states and {} requests sent, {} frames unsent; flash: {} erasures, {} failed",
        value(&d.states),
        value(&d.asked),
        s.frames_unsent,
        erasures,
        worn
    );
    hprintln!(
        "'sure' in {} of {} ticks on sensors ({} runs), {} of them too late",
        value(&d.sure_ticks),
        value(&d.unit_ticks),
        value(&d.unit_runs),
        value(&d.unsure_late)
    );
    let missing = value(&d.lost) + value(&d.damaged) + value(&d.overtaken);
    let finished = value(&d.unit_runs) * UNIT_SAMPLES;
    let taken = s.samples.saturating_sub(finished) + s.samples_dropped + s.samples_unasked + waiting;
    let refused = value(&d.readings_refused) + value(&d.scans_saturated) + value(&d.late_by_clock);
    // Reports and states are made together; eight of the reports may wait for the host.
    let states = value(&d.reports) + s.reports_dropped;
    let unsent = states.saturating_sub(value(&d.states)) + value(&d.requests_begun) - value(&d.asked);
    let near = |a: u32, b: u32, slack: u32| a.abs_diff(b) <= slack;
    // Slack: what is on its way at this moment.
    let held = [
        ("no tick began late", s.ticks_missed == 0),
        ("no tick takes 400,000 instructions", s.worst_cost < MOST_INSTRUCTIONS / 5),
        ("the stack keeps within its budget", s.stack_bytes <= BUDGET_BYTES),
        ("every sound sample is accounted for", near(value(&d.sound), taken, 2)),
        ("every missing sample is counted", near(missing, s.samples_lost, 2)),
        ("every late sample is counted", near(value(&d.overtaken), s.samples_reordered, 1)),
        ("every repeated sample is counted", near(value(&d.repeated), s.samples_repeated, 1)),
        (
            "every bad frame is counted",
            near(value(&d.damaged) + value(&d.garbage), s.frames_damaged + s.frames_too_long, 1),
        ),
        // An erasure that fails is made once more, with the whole copy: no store is refused for it.
        ("every bad command is refused, and no other", near(value(&d.refused), s.commands_refused, 1)),
        ("every model is put to use", near(value(&d.models), s.model_swaps, 1)),
        ("every request is answered", near(value(&d.requests), value(&d.answers), 12)),
        // A stall may end after this moment: its drops show later.
        ("every missing report was counted", near(value(&d.reports_missing), s.reports_dropped, 600)),
        ("no frame came out broken", value(&d.frames_bad) == 0),
        ("no byte was lost", s.bytes_lost == 0),
        ("no line says 'sure' of what is out of date", value(&d.unsure_late) == 0),
        ("the line does say 'sure'", value(&d.sure_ticks) > value(&d.unit_ticks) / 4),
        // A fault begins and ends between two ticks.
        (
            "every damaged reading is counted",
            near(
                value(&d.readings_damaged) + value(&d.scans_failed),
                s.readings_damaged,
                4 + value(&d.gauge_faults),
            ),
        ),
        ("every refused reading is counted", near(refused, s.readings_dropped, 4 + value(&d.gauge_faults))),
        ("every frame that the bus did not take is counted", near(unsent, s.frames_unsent, 12)),
    ];
    let mut failed = false;
    for (claim, holds) in held {
        if !holds {
            failed = true;
            hprintln!("NOT SO: {}", claim);
        }
    }
    hprintln!("{}", if failed { "soak failed" } else { "soak passed" });
    debug::exit(if failed { debug::EXIT_FAILURE } else { debug::EXIT_SUCCESS });
}
