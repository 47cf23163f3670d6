//! What is kept of a run.

use stickslip_live::event::{Event, Happened};
use stickslip_live::state::State;
use stickslip_live::{plain, words};
use stickslip_shared::predictor::{Prediction, Slip, flags};
use stickslip_shared::wire::{Mode, TelemetryReport};

use crate::recorded::{COST, TIMER_HZ, events};

fn report(seq: u32, flags: u32) -> TelemetryReport {
    let mut prediction = Prediction { flags, ..Prediction::default() };
    if flags & flags::SLIP_AHEAD_1 != 0 {
        prediction.finger[0].slip = Slip::In(0.12);
    }
    TelemetryReport {
        seq,
        mode: Mode::Running,
        sample_seq: Some(seq),
        taken: seq + 1,
        prediction,
        ..TelemetryReport::default()
    }
}

fn told(at_s: f64, report: TelemetryReport) -> Event {
    Event { at_s, what: Happened::Report(Box::new(report)) }
}

#[test]
fn a_warning_is_one_alarm_however_long_it_stands_and_tells_how_much_it_came_ahead() {
    let mut state = State::default();
    let mut raised = Vec::new();
    for seq in 0..100 {
        let bits = match seq {
            20..40 => flags::SLIP_AHEAD_1,
            40..60 => flags::SLIP_AHEAD_1 | flags::SLIP_1,
            _ => 0,
        };
        raised.extend(state.take(&told(f64::from(seq) * 0.004, report(seq, bits))));
    }
    assert_eq!(raised.iter().map(|a| a.flag).collect::<Vec<_>>(), [flags::SLIP_AHEAD_1, flags::SLIP_1]);
    let warning = &state.alarms[0];
    assert_eq!((warning.at_s, warning.foreseen_in_s), (0.08, Some(0.12)));
    assert!((warning.came_after_s.expect("it slipped") - 0.08).abs() < 1e-9);
    assert!((warning.over_s.expect("it is over") - 0.24).abs() < 1e-9);
    assert_eq!(state.alarms_counted, 2);
    let line = plain::alarm(warning);
    assert!(line.contains("foreseen in 120 ms") && line.contains("came after 80 ms"), "{line}");
}

#[test]
fn the_last_sample_of_a_run_counts_though_its_report_comes_when_the_run_is_over() {
    let mut state = State::default();
    let ready = |seq: u32, sample_seq: Option<u32>| TelemetryReport {
        mode: Mode::Ready,
        sample_seq,
        ..report(seq, 0)
    };
    // What a board that runs nothing reports is of an earlier run.
    state.take(&told(0.0, ready(0, Some(77))));
    assert_eq!(state.predictions, 0);
    for seq in 1..5 {
        state.take(&told(0.0, report(seq, 0)));
    }
    for (seq, sample_seq) in [(5, Some(5)), (6, Some(5)), (7, None)] {
        state.take(&told(0.0, ready(seq, sample_seq)));
    }
    assert_eq!(state.predictions, 5);
}

#[test]
fn reports_that_never_came_are_counted_and_a_board_that_began_anew_lost_none() {
    let mut state = State::default();
    for seq in (0..10).chain(13..20).chain(0..5) {
        state.take(&told(0.0, report(seq, 0)));
    }
    assert_eq!(state.line().reports_lost, 3);
    assert_eq!(state.predictions, 22);
}

#[test]
fn rates_and_the_work_of_the_tick_are_those_of_the_recorded_run() {
    let mut state = State::default();
    for event in events() {
        state.take(event);
    }
    let line = state.line();
    assert!((line.samples_per_s - 250.0).abs() < 2.0, "{line:?}");
    assert_eq!(line.reports_lost, 1);
    let work_ms = f64::from(COST) / f64::from(TIMER_HZ) * 1e3;
    assert_eq!((line.work_ms, line.work_worst_ms), (Some(work_ms), Some(work_ms)));
    assert_eq!(state.sample.map(|s| s.seq), Some(state.predictions as u32));
    // Ten seconds at most, an hour or a minute in.
    assert!(state.trace.len() <= 2501);
}

#[test]
fn a_line_says_what_the_prediction_says() {
    let mut state = State::default();
    for event in events() {
        state.take(event);
    }
    let p = state.prediction.expect("a prediction");
    let line = plain::line(&state);
    for part in [
        format!("sag {:.2} mm", p.sag_m * 1e3),
        format!("of friction {:.2}", p.friction),
        format!("flags {}", words::flag_names(p.flags)),
        "250 samples/s, 1 reports lost, tick 1.50 ms (38 % of its period)".to_owned(),
    ] {
        assert!(line.contains(&part), "{part:?} is not in {line:?}");
    }
}
