//! The decision as a table: what a tick shows, and which flags it raises.

use stickslip_shared::predictor::decide::{Alarms, Evidence, decide};
use stickslip_shared::predictor::{Intent, Limits, Params, Slip, flags};

/// A held grasp that is seen, at rest, with nothing ahead.
fn rest() -> Evidence {
    Evidence { dt_s: 0.004, slips: Some(false), agrees: true, ..Evidence::default() }
}

fn push() -> Evidence {
    Evidence { intent: Intent::Slide, moves: true, pushing: true, ..rest() }
}

/// Flags after the same evidence in so many samples.
fn after(samples: u32, e: &Evidence) -> u32 {
    let (limits, params) = (Limits::default(), Params::default());
    let mut alarms = Alarms::default();
    let mut flags = 0;
    for _ in 0..samples {
        let (verdict, next) = decide(e, &alarms, &limits, &params);
        (flags, alarms) = (verdict.flags, next);
    }
    flags
}

const SLIPS: u32 = flags::SLIP_1 | flags::SLIP_2;
const AHEAD: u32 = flags::SLIP_AHEAD_1 | flags::SLIP_AHEAD_2;

#[test]
fn each_row_of_the_table_raises_its_flags_and_no_others() {
    let soon = [Slip::In(0.05); 2];
    let blind = Evidence { blind: true, slips: None, agrees: false, ..rest() };
    let rows: &[(&str, Evidence, u32, u32)] = &[
        // What; evidence; samples; flags.
        ("nothing", rest(), 100, 0),
        ("slip seen while holding", Evidence { slips: Some(true), ..rest() }, 1, SLIPS | flags::UNEXPECTED),
        (
            "a proven trend",
            Evidence { limit_in_s: Some(0.2), ..rest() },
            1,
            AHEAD | flags::UNEXPECTED | flags::DROP,
        ),
        ("a trend too far off for slip", Evidence { limit_in_s: Some(0.4), ..rest() }, 1, flags::DROP),
        ("a trend too far off", Evidence { limit_in_s: Some(0.6), ..rest() }, 1, 0),
        ("foreseen by the model once", Evidence { slip: soon, ..rest() }, 4, 0),
        ("foreseen by the model lastingly", Evidence { slip: soon, ..rest() }, 5, AHEAD | flags::UNEXPECTED),
        ("foreseen by a model that is wrong", Evidence { slip: soon, agrees: false, ..rest() }, 50, 0),
        (
            "foreseen against a pusher at rest",
            Evidence { slip: soon, pushing: true, ..rest() },
            50,
            flags::PUSHING,
        ),
        (
            "foreseen by the model alone",
            Evidence { slip: soon, ..blind },
            5,
            SLIPS | flags::UNEXPECTED | flags::DROP,
        ),
        (
            "over the limit, unseen",
            Evidence { slips: None, over_s: 0.004, ..rest() },
            1,
            SLIPS | flags::UNEXPECTED,
        ),
        (
            "over the limit for long, unseen",
            Evidence { slips: None, over_s: 0.04, ..rest() },
            1,
            SLIPS | flags::UNEXPECTED | flags::DROP,
        ),
        (
            "it leaves the pads",
            Evidence { slips: Some(true), leaves_in_s: Some(0.1), ..rest() },
            1,
            SLIPS | flags::UNEXPECTED | flags::DROP,
        ),
        ("the next slip is the last", Evidence { next_is_last: true, ..rest() }, 1, flags::DROP),
        ("sag", Evidence { sag_m: 0.003, ..rest() }, 1, flags::SAG),
        ("sag ahead, for a moment", Evidence { sag_ahead_m: 0.003, ..rest() }, 4, 0),
        ("sag ahead, lastingly", Evidence { sag_ahead_m: 0.003, ..rest() }, 5, flags::SAG),
        (
            "sag ahead with slip",
            Evidence { sag_ahead_m: 0.003, slips: Some(true), ..rest() },
            1,
            SLIPS | flags::UNEXPECTED | flags::SAG,
        ),
        ("turned", Evidence { rotation_rad: 0.06, ..rest() }, 1, flags::ROTATION),
        ("a push slides", Evidence { slips: Some(true), ..push() }, 10, SLIPS | flags::PUSHING),
        ("a push will slide", Evidence { slip: soon, ..push() }, 10, AHEAD | flags::PUSHING),
        (
            "a push sags",
            Evidence { sag_m: 0.003, ..push() },
            1,
            flags::SAG | flags::UNEXPECTED | flags::PUSHING,
        ),
        (
            "a push turns",
            Evidence { rotation_rad: 0.06, ..push() },
            1,
            flags::ROTATION | flags::UNEXPECTED | flags::PUSHING,
        ),
        (
            "a pivot turns",
            Evidence { rotation_rad: 0.06, intent: Intent::Pivot, moves: true, ..rest() },
            1,
            0,
        ),
        (
            "a pivot sags",
            Evidence { sag_m: 0.003, intent: Intent::Pivot, moves: true, ..rest() },
            1,
            flags::SAG | flags::UNEXPECTED,
        ),
        (
            "free motion",
            Evidence { sag_m: 0.003, rotation_rad: 0.06, intent: Intent::Free, slips: Some(true), ..rest() },
            1,
            SLIPS,
        ),
        ("about to slide by the plan", Evidence { slips: Some(true), moves: true, ..rest() }, 1, SLIPS),
        ("will slide as the plan will", Evidence { slip: soon, moves_ahead: true, ..rest() }, 5, AHEAD),
        (
            "slides before the plan will",
            Evidence { slips: Some(true), moves_ahead: true, ..rest() },
            5,
            SLIPS | flags::UNEXPECTED,
        ),
    ];
    for (what, evidence, samples, expected) in rows {
        let raised = after(*samples, evidence);
        assert_eq!(raised, *expected, "{what}: raised {raised:#b}, expected {expected:#b}");
    }
}

#[test]
fn slip_after_a_planned_slide_is_intended_for_a_tenth_of_a_second() {
    let (limits, params) = (Limits::default(), Params::default());
    let (_, mut alarms) = decide(&push(), &Alarms::default(), &limits, &params);
    let mut unexpected_s = 0.0;
    let slips = Evidence { slips: Some(true), ..rest() };
    loop {
        let (verdict, next) = decide(&slips, &alarms, &limits, &params);
        if verdict.flags & flags::UNEXPECTED != 0 {
            break;
        }
        (unexpected_s, alarms) = (unexpected_s + slips.dt_s, next);
    }
    assert!((0.09f32..0.105).contains(&unexpected_s), "{unexpected_s}");
}

#[test]
fn a_warning_stays_up_for_150_ms_after_its_cause() {
    let (limits, params) = (Limits::default(), Params::default());
    let warned = Evidence { limit_in_s: Some(0.1), ..rest() };
    let (_, mut alarms) = decide(&warned, &Alarms::default(), &limits, &params);
    let mut up = 0;
    loop {
        let (verdict, next) = decide(&rest(), &alarms, &limits, &params);
        if verdict.drop_in_s.is_none() {
            break;
        }
        (up, alarms) = (up + 1, next);
    }
    assert!((36..=38).contains(&up), "{up} samples");
}

#[test]
fn a_contact_that_opens_for_moments_is_still_a_pusher_at_rest() {
    let (limits, params) = (Limits::default(), Params::default());
    let mut alarms = Alarms::default();
    for k in 0..500 {
        let slip = [Slip::In(0.05); 2];
        let e = Evidence { slip, pushing: k % 20 == 0, ..rest() };
        let (verdict, next) = decide(&e, &alarms, &limits, &params);
        assert_eq!(verdict.flags & (AHEAD | flags::UNEXPECTED), 0, "sample {k}");
        alarms = next;
    }
}

#[test]
fn a_warning_before_a_planned_slide_is_not_raised_again_after_it() {
    let (limits, params) = (Limits::default(), Params::default());
    let warned = Evidence { limit_in_s: Some(0.1), ..rest() };
    let (_, alarms) = decide(&warned, &Alarms::default(), &limits, &params);
    let (_, alarms) = decide(&push(), &alarms, &limits, &params);
    let (verdict, _) = decide(&rest(), &alarms, &limits, &params);
    assert_eq!(verdict.flags, 0);
}
