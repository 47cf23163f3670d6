//! The view, drawn into memory.

use ratatui::Terminal;
use ratatui::backend::TestBackend;
use stickslip_live::event::{Event, Happened};
use stickslip_live::plain;
use stickslip_live::state::State;
use stickslip_live::view::draw;
use stickslip_shared::predictor::{FingerPrediction, Prediction};

use crate::recorded::events;

fn drawn(state: &State, width: u16, height: u16) -> String {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).expect("a terminal");
    terminal.draw(|frame| draw(frame, state)).expect("drawn");
    terminal.backend().to_string()
}

#[test]
fn the_view_of_a_recorded_push_shows_every_quantity_of_its_prediction() {
    let mut state = State::default();
    for event in events() {
        state.take(event);
    }
    let p = state.prediction.expect("a prediction");
    let f = p.finger[0];
    let picture = drawn(&state, 150, 36);
    for part in [
        format!("{:.0} % of friction used, measured", 100.0 * f.measured_utilisation.expect("measured")),
        format!("model {:.2}, ahead {:.2}, slip ", f.model_utilisation, f.peak_utilisation),
        "finger 1, pressed ".to_owned(),
        format!("sag           {:.2} mm", p.sag_m * 1e3),
        format!("friction      {:.2}, min {:.2}", p.friction, p.friction_least),
        "linear_push-obj4-g20-v10-s0-r1  running".to_owned(),
        "samples/s      250".to_owned(),
        "reports lost   1".to_owned(),
        "tick           1.50 ms, 38 %".to_owned(),
        "q: quit".to_owned(),
    ] {
        assert!(picture.contains(&part), "{part:?} is not in\n{picture}");
    }
    // Alarms of the push: the newest first.
    let newest = state.alarms.back().expect("a push slips").what;
    assert!(picture.contains(newest), "{newest} is not in\n{picture}");
}

#[test]
fn view_and_lines_tell_how_probably_it_holds_and_never_more_than_that() {
    for (probability, words) in
        [(None, "-"), (Some(0.99968), "99.9 %"), (Some(0.25), "25.0 %"), (Some(1.0), "100.0 %")]
    {
        let prediction =
            Prediction { hold_probability: probability, friction_least: 0.31, ..Prediction::default() };
        let mut state = State::default();
        state.take(&Event { at_s: 0.0, what: Happened::Prediction(Box::new(prediction)) });
        // The smallest terminal that is usual has room for all.
        for picture in [drawn(&state, 80, 24), drawn(&state, 150, 36)] {
            assert!(picture.contains(&format!("holds         {words} ")), "{words}: {picture}");
            assert!(picture.contains("friction      -, min 0.31"), "{picture}");
        }
        let line = plain::line(&state);
        assert!(line.contains(&format!("of friction - (at least 0.31), holds {words},")), "{line}");
    }
}

#[test]
fn in_the_smallest_usual_terminal_alarms_fingers_and_the_health_of_the_line_are_not_cut() {
    let mut state = State::default();
    let mut sure = None;
    for event in events() {
        state.take(event);
        // While an alarm that was foreseen is the last.
        if state.alarms.back().is_some_and(|alarm| alarm.foreseen_in_s.is_some()) && sure.is_none() {
            sure = Some((drawn(&state, 80, 24), plain::alarm(&state.alarms[0])));
        }
    }
    let (picture, alarm) = sure.expect("a push is foreseen");
    assert!(
        alarm.contains("foreseen in") && picture.contains(alarm.trim_start()),
        "{alarm} is not in\n{picture}"
    );
    let picture = drawn(&state, 80, 24);
    let p = state.prediction.expect("a prediction");
    for part in [
        format!("ahead {:.2}, slip not ahead", p.finger[1].peak_utilisation),
        "finger 2, pressed ".to_owned(),
        "samples/s 250, lost ".to_owned(),
        "reports/s 250, lost 1".to_owned(),
        "tick 38 % of its time".to_owned(),
    ] {
        assert!(picture.contains(&part), "{part:?} is not in\n{picture}");
    }
}

#[test]
fn a_terminal_of_any_size_and_numbers_of_any_kind_are_drawn_without_panic() {
    let empty = State::default();
    for (width, height) in [(1, 1), (3, 2), (20, 5), (80, 24), (300, 90)] {
        drawn(&empty, width, height);
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -1.0] {
            let finger = FingerPrediction {
                measured_utilisation: Some(bad),
                model_utilisation: bad,
                peak_utilisation: bad,
                ..FingerPrediction::default()
            };
            let prediction =
                Prediction { finger: [finger; 2], sag_m: bad, drop_in_s: Some(bad), ..Prediction::default() };
            let mut state = State::default();
            for at_s in [0.0, 1.0] {
                state.take(&Event { at_s, what: Happened::Prediction(Box::new(prediction)) });
            }
            drawn(&state, width, height);
        }
    }
}
