//! Alarms held against events.

use stickslip_analysis::score::alarms::*;
use stickslip_analysis::score::truth::Event;
use stickslip_analysis::score::truth::{Cause, Kind};

fn event(onset_s: f64) -> Event {
    let (kind, cause) = (Kind::Slip, Cause::Sudden);
    Event { kind, onset_s, end_s: onset_s + 0.3, intended: false, cause, finger_s: [None; 2] }
}

#[test]
fn an_early_alarm_leads_a_late_one_lags_and_a_lonely_one_is_false() {
    let t: Vec<f64> = (0..2500).map(|i| f64::from(i) * 0.004).collect();
    let up = |t: &f64| (1.5..2.1).contains(t) || (5.05..5.2).contains(t) || (8.0..8.1).contains(t);
    let alarms = episodes(&t, t.iter().map(up), 10.0);
    let (a, b, c) = (event(2.0), event(5.0), event(7.0));
    let leads = leads(&[&a, &b, &c], &alarms);
    assert!((leads[0].unwrap() - 0.5).abs() < 0.005);
    assert!((leads[1].unwrap() + 0.05).abs() < 0.005);
    assert_eq!(leads[2], None);
    let (near, wrong) = unmet(&[&a, &b, &c], &[], &alarms);
    assert_eq!((near.len(), wrong.len()), (0, 1));
    let (near, wrong) = unmet(&[&a, &b, &c], &[(8.0, 8.05)], &alarms);
    assert_eq!((near.len(), wrong.len()), (1, 0));
}

#[test]
fn pauses_of_a_few_ticks_do_not_split_an_alarm() {
    let t: Vec<f64> = (0..250).map(|i| f64::from(i) * 0.004).collect();
    let alarms = episodes(&t, (0..250).map(|i| i % 10 < 5), 0.5);
    assert_eq!(alarms.len(), 1);
    assert!(alarms[0].to_s <= 0.5);
}
