//! The slip warning's states as a table: what is shown, tick by tick, and where the warning stands after it.

use stickslip_shared::predictor::Params;
use stickslip_shared::predictor::alarm::{Alarm, Cause, Signs, State};

const DT: f32 = 0.004;

/// Nothing is shown of an object that is seen.
fn quiet() -> Signs {
    Signs { seen: true, used: 0.5, dt_s: DT, ..Signs::default() }
}

fn ahead(cause: Cause) -> Signs {
    Signs { ahead: Some((cause, 0.1)), ..quiet() }
}

fn slides() -> Signs {
    Signs { slides: Some(Cause::Motion), ..quiet() }
}

/// The alarm after each of these for so many ticks.
fn after(course: &[(Signs, u32)]) -> Alarm {
    let params = Params::default();
    course
        .iter()
        .flat_map(|(signs, ticks)| (0..*ticks).map(move |_| signs))
        .fold(Alarm::default(), |alarm, signs| alarm.next(signs, &params))
}

/// Ticks of the 0.15 s for which a warning stays without its cause, and one more.
const HELD: u32 = 39;

/// What it is; signs, each for so many ticks; the state after them, and whether the warning is up.
type Row = (&'static str, Vec<(Signs, u32)>, State, bool);

#[test]
fn each_course_of_signs_ends_in_its_state_with_the_warning_up_or_not() {
    use Cause::{Clipped, Foresight, Grip, Inertia, Load, Motion};
    let over = Signs { over: true, ..quiet() };
    let suspects = Signs { suspects: true, ..quiet() };
    let more = Signs { used: 0.6, ..ahead(Foresight) };
    let unseen = |s: Signs| Signs { seen: false, ..s };
    let rows: &[Row] = &[
        ("nothing", vec![(quiet(), 10)], State::Clear, false),
        ("a suspicion", vec![(suspects, 4)], State::Watching, false),
        ("a suspicion that ends", vec![(suspects, 4), (quiet(), 1)], State::Clear, false),
        ("the grip falls", vec![(ahead(Grip), 1)], State::Warned(Grip), true),
        ("a cause that persists", vec![(ahead(Load), 5000)], State::Warned(Load), true),
        (
            "a cause that is not seen for a moment",
            vec![(ahead(Load), 1), (quiet(), 30)],
            State::Warned(Load),
            true,
        ),
        ("a cause that is seen no more", vec![(ahead(Load), 1), (quiet(), HELD)], State::Clear, false),
        ("the load came down", vec![(ahead(Load), 1), (over, 1)], State::Ended(Load), false),
        (
            "a cause that is over and seen",
            vec![(ahead(Grip), 1), (Signs { over: true, ..ahead(Grip) }, 1)],
            State::Warned(Grip),
            true,
        ),
        ("what was announced comes", vec![(ahead(Inertia), 1), (slides(), 1)], State::Sliding(Motion), true),
        ("sudden slip", vec![(slides(), 1)], State::Sliding(Motion), false),
        ("slip that ends", vec![(slides(), 9), (quiet(), 1)], State::Ended(Motion), false),
        (
            "slip that ends under a warning",
            vec![(ahead(Load), 1), (slides(), 9), (quiet(), 1)],
            State::Warned(Motion),
            true,
        ),
        (
            "clipped",
            vec![(Signs { slides: Some(Clipped), ..unseen(quiet()) }, 1)],
            State::Sliding(Clipped),
            false,
        ),
        ("the plan has passed", vec![(ahead(Inertia), 9), (over, 1)], State::Ended(Inertia), false),
        (
            "the same again",
            vec![(ahead(Inertia), 9), (over, 9), (ahead(Inertia), 9)],
            State::Ended(Inertia),
            false,
        ),
        (
            "the same, long after",
            vec![(ahead(Inertia), 9), (over, 900), (ahead(Inertia), 9)],
            State::Warned(Inertia),
            true,
        ),
        (
            "more than was borne",
            vec![(ahead(Inertia), 9), (over, 9), (more, 1)],
            State::Warned(Foresight),
            true,
        ),
        ("another cause", vec![(ahead(Inertia), 9), (over, 9), (ahead(Load), 1)], State::Warned(Load), true),
        (
            "the same after a slip",
            vec![(ahead(Inertia), 9), (over, 9), (slides(), 9), (quiet(), HELD), (ahead(Inertia), 1)],
            State::Warned(Inertia),
            true,
        ),
        (
            "the same where nobody sees the object",
            vec![(unseen(ahead(Inertia)), 9), (unseen(over), 9), (unseen(ahead(Inertia)), 1)],
            State::Warned(Inertia),
            true,
        ),
    ];
    for (what, course, state, up) in rows {
        let alarm = after(course);
        assert_eq!((alarm.state, alarm.ahead_s().is_some()), (*state, *up), "{what}");
    }
}

#[test]
fn a_warning_whose_cause_persists_stays_until_the_slip_that_it_announced() {
    let params = Params::default();
    let mut alarm = Alarm::default();
    for tick in 0..2500u32 {
        // The load climbs with its noise; the trend is seen in two ticks of three.
        let used = 0.5 + 0.0002 * tick as f32 - if tick % 7 == 0 { 0.02 } else { 0.0 };
        let seen = if tick % 3 == 0 { quiet() } else { ahead(Cause::Load) };
        alarm = alarm.next(&Signs { used, ..seen }, &params);
        assert!(tick == 0 || alarm.ahead_s().is_some(), "withdrawn at tick {tick}");
    }
    alarm = alarm.next(&slides(), &params);
    assert_eq!(alarm.state, State::Sliding(Cause::Motion));
}
