//! Where events come from.

use stickslip_live::event::Happened;
use stickslip_live::source::Source;

use crate::recorded::{events, events_of, write};

#[test]
fn a_log_is_told_as_it_happened_and_at_its_own_times() {
    let events = events();
    assert!(matches!(events[0].what, Happened::Timer(_)) && matches!(events[1].what, Happened::Scene(..)));
    let mut sample = None;
    for pair in events.windows(2) {
        assert!(pair[0].at_s <= pair[1].at_s);
    }
    for event in events {
        match &event.what {
            Happened::Sample(taken) => sample = Some((taken.seq, event.at_s)),
            Happened::Report(report) => assert_eq!(sample, Some((report.sample_seq.unwrap(), event.at_s))),
            _ => {}
        }
    }
    assert!(events[events.len() - 1].at_s > 1.9);
}

#[test]
fn what_cannot_be_watched_is_refused_with_a_way_out() {
    assert!(Source::named("can:").is_err());
    assert_eq!(Source::named("can:can0").unwrap(), Source::Bus("can0".to_owned()));
    assert!(Source::named("replay:").is_err());
    assert_eq!(Source::named("qemu").unwrap(), Source::Board("qemu".to_owned()));
    let missing = events_of("no/such.mcap".into()).expect_err("no file").to_string();
    assert!(missing.contains("no/such.mcap"), "{missing}");
}

#[test]
fn a_log_that_was_cut_is_played_as_far_as_it_goes_and_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.mcap");
    write(&path);
    let bytes = std::fs::read(&path).expect("read");
    std::fs::write(&path, &bytes[..bytes.len() / 2]).expect("written");
    let played = events_of(path).expect("played");
    assert!(played.iter().any(|event| matches!(event.what, Happened::Note(_))));
    let reports = played.iter().filter(|event| matches!(event.what, Happened::Report(_))).count();
    assert!(reports > 100 && reports < 400, "{reports}");
}
