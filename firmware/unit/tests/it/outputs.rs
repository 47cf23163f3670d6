//! Alarm lines and the advised grip force.

use core::convert::Infallible;

use embedded_hal::digital::{ErrorType, OutputPin};
use proptest::prelude::*;
use stickslip_shared::predictor::{Prediction, flags};
use stickslip_shared::wire::{GripLimits, check};
use stickslip_unit::alarm::{Alarms, LineFault, Lines};
use stickslip_unit::grip::GripAdvice;

#[derive(Default)]
struct Pin(bool);

impl ErrorType for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0 = false;
        Ok(())
    }
    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0 = true;
        Ok(())
    }
}

/// A pin whose driver fails.
struct Broken;

impl embedded_hal::digital::Error for Broken {
    fn kind(&self) -> embedded_hal::digital::ErrorKind {
        embedded_hal::digital::ErrorKind::Other
    }
}

impl core::fmt::Debug for Broken {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("broken")
    }
}

impl ErrorType for Broken {
    type Error = Broken;
}

impl OutputPin for Broken {
    fn set_low(&mut self) -> Result<(), Broken> {
        Err(Broken)
    }
    fn set_high(&mut self) -> Result<(), Broken> {
        Err(Broken)
    }
}

fn flagged(bits: u32) -> Prediction {
    Prediction { flags: bits, ..Prediction::default() }
}

#[test]
fn each_line_follows_its_flags_and_nothing_known_is_unsure() {
    let mut lines = Lines { slip: Pin(true), drop: Pin(true), sure: Pin(true) };
    let mut read = |alarms| {
        lines.set(alarms).unwrap();
        (lines.slip.0, lines.drop.0, lines.sure.0)
    };
    assert_eq!(read(Alarms::default()), (false, false, false));
    assert_eq!(read(Alarms::of(&flagged(0))), (false, false, true));
    assert_eq!(read(Alarms::of(&flagged(flags::UNEXPECTED))), (true, false, true));
    assert_eq!(read(Alarms::of(&flagged(flags::DROP | flags::UNSURE))), (false, true, false));
    // Slip that the plan means is no alarm.
    assert_eq!(read(Alarms::of(&flagged(flags::SLIP_1 | flags::PUSHING))), (false, false, true));
}

#[test]
fn a_line_that_fails_takes_the_sureness_of_the_others() {
    let mut lines = Lines { slip: Pin(false), drop: Broken, sure: Pin(true) };
    assert_eq!(lines.set(Alarms::of(&flagged(flags::UNEXPECTED))), Err(LineFault));
    assert!(lines.slip.0 && !lines.sure.0);
}

const LIMITS: GripLimits = GripLimits { least_n: 5.0, most_n: 40.0, rise_n_s: 100.0, fall_n_s: 10.0 };
const TICK_S: f32 = 0.004;

#[test]
fn the_advice_rises_while_the_object_slips_as_fast_as_the_gripper_follows_and_no_higher_than_allowed() {
    let slips = flagged(flags::UNEXPECTED | flags::SLIP_2);
    let mut advice = GripAdvice::new(LIMITS);
    assert_eq!(advice.follow(&flagged(0), f32::NAN, TICK_S), None);
    assert_eq!(advice.follow(&flagged(0), 10.0, TICK_S), Some(10.0));
    let first = advice.follow(&slips, 10.0, TICK_S).unwrap();
    assert!((first - 10.4).abs() < 1e-4, "{first}");
    for _ in 0..200 {
        advice.follow(&slips, 10.0, TICK_S);
    }
    assert_eq!(advice.follow(&slips, 10.0, TICK_S), Some(40.0));
}

#[test]
fn a_drop_that_is_only_foreseen_doubles_the_grip_once() {
    let mut advice = GripAdvice::new(LIMITS);
    advice.follow(&flagged(0), 10.0, TICK_S);
    for _ in 0..500 {
        advice.follow(&flagged(flags::DROP), 10.0, TICK_S);
    }
    assert_eq!(advice.follow(&flagged(flags::DROP), 10.0, TICK_S), Some(20.0));
    // Another alarm, another doubling.
    advice.follow(&flagged(0), 10.0, TICK_S);
    for _ in 0..500 {
        advice.follow(&flagged(flags::DROP), 10.0, TICK_S);
    }
    assert_eq!(advice.follow(&flagged(flags::DROP), 10.0, TICK_S), Some(40.0));
}

#[test]
fn the_advice_falls_to_what_holds_only_after_it_was_quiet_and_not_in_doubt() {
    let holds = Prediction { holding_grip_n: Some(12.0), ..Prediction::default() };
    let mut advice = GripAdvice::new(LIMITS);
    advice.follow(&holds, 30.0, TICK_S);
    let after = |advice: &mut GripAdvice, p: &Prediction, ticks: u32| {
        (0..ticks).filter_map(|_| advice.follow(p, 30.0, TICK_S)).last().unwrap()
    };
    assert_eq!(after(&mut advice, &holds, 100), 30.0);
    let doubtful = Prediction { flags: flags::UNSURE, ..holds };
    assert_eq!(after(&mut advice, &doubtful, 500), 30.0);
    let falling = after(&mut advice, &holds, 225);
    assert!((falling - 26.7).abs() < 0.3, "0.4 s of falling after half a second: {falling}");
    assert!((after(&mut advice, &holds, 4000) - 12.0).abs() < 0.1);
    // More is needed: also in doubt.
    let heavier = Prediction { holding_grip_n: Some(20.0), ..doubtful };
    let rising = after(&mut advice, &heavier, 62);
    assert!((rising - 17.0).abs() < 0.5, "two thirds of the way in 0.25 s: {rising}");
    assert!((after(&mut advice, &heavier, 500) - 20.0).abs() < 0.1);
}

#[test]
fn the_advice_keeps_within_its_limits_where_the_command_does_not() {
    let limits = GripLimits { least_n: 5.0, most_n: 10.0, ..GripLimits::default() };
    for (commanded_n, expected_n) in [(20.0, 10.0), (1.0, 5.0), (7.0, 7.0)] {
        let mut advice = GripAdvice::new(limits);
        assert_eq!(advice.follow(&Prediction::default(), commanded_n, 0.004), Some(expected_n));
    }
}

#[test]
fn limits_that_are_none_are_refused() {
    assert_eq!(check::grip_limits(&LIMITS), Ok(()));
    assert_eq!(check::grip_limits(&GripLimits::default()), Ok(()));
    for bad in [
        GripLimits { least_n: -1.0, ..LIMITS },
        GripLimits { least_n: f32::NAN, ..LIMITS },
        GripLimits { most_n: 4.0, ..LIMITS },
        GripLimits { most_n: f32::INFINITY, ..LIMITS },
        GripLimits { rise_n_s: 0.0, ..LIMITS },
        GripLimits { fall_n_s: f32::NAN, ..LIMITS },
    ] {
        assert!(check::grip_limits(&bad).is_err(), "{bad:?}");
    }
}

proptest! {
    #[test]
    fn the_advice_keeps_within_its_limits_and_rates_whatever_is_predicted(
        start in 5.0f32..40.0,
        ticks in prop::collection::vec((any::<u32>(), any::<Option<f32>>(), any::<f32>()), 1..300),
    ) {
        let mut advice = GripAdvice::new(LIMITS);
        let mut before = start;
        advice.follow(&Prediction::default(), start, TICK_S);
        for (flags, holding_grip_n, commanded) in ticks {
            let p = Prediction { flags, holding_grip_n, ..Prediction::default() };
            let now = advice.follow(&p, commanded, TICK_S).unwrap();
            prop_assert!((5.0..=40.0).contains(&now));
            prop_assert!(now - before <= LIMITS.rise_n_s * TICK_S + 1e-4);
            prop_assert!(before - now <= LIMITS.fall_n_s * TICK_S + 1e-4);
            before = now;
        }
    }
}
