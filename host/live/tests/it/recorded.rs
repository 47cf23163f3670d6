//! A recorded push as a board reports it: the log of its run.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

use stickslip_analysis::model::file::default_model;
use stickslip_analysis::run::replay::{feed, run};
use stickslip_device::log::{Entry, Header, Writer};
use stickslip_live::event::Event;
use stickslip_live::source::{Source, follow};
use stickslip_shared::predictor::Limits;
use stickslip_shared::wire::{Mode, TelemetryReport};

/// Counts a second of the timer of the board in the log.
pub const TIMER_HZ: u32 = 1_000_000;
/// What each tick of it cost.
pub const COST: u32 = 1500;
/// The report that the line lost.
pub const LOST: u32 = 100;

/// Writes the log of a push of the demonstration: samples, and a report on each but one.
pub fn write(path: &Path) {
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo");
    let dataset = stickslip_data::read(&demo).expect("data/demo");
    let feed = feed(&dataset.description, &dataset.trials[0]).expect("a scene");
    let replayed = run(&feed, &default_model(), Limits::default(), 0, |_| ()).expect("accepted");
    let scene = postcard::to_allocvec(&feed.scene).expect("bytes");
    let meta = serde_json::json!({ "trial": dataset.trials[0].info.trial, "timer_hz": TIMER_HZ });
    let mut writer = Writer::create(path, &Header { scene, model: vec![], meta }).expect("created");
    for (at, (sample, prediction)) in (0..).zip(feed.samples.iter().zip(&replayed.predictions)) {
        let ns = u64::from(sample.t_us) * 1000;
        writer.record(ns, Entry::Sample(sample)).expect("written");
        let report = TelemetryReport {
            seq: at,
            tick: at,
            mode: Mode::Running,
            sample_seq: Some(sample.seq),
            taken: at + 1,
            prediction: *prediction,
            cost: COST,
            ..TelemetryReport::default()
        };
        if at != LOST {
            writer.record(ns, Entry::Telemetry(&report)).expect("written");
        }
    }
}

/// All events of the log at `path`, as fast as they can be told.
pub fn events_of(path: PathBuf) -> anyhow::Result<Vec<Event>> {
    let mut events = Vec::new();
    follow(&Source::Log(path), None, 1e6, &AtomicBool::new(false), &mut |event| events.push(event))?;
    Ok(events)
}

/// The events of the push.
pub fn events() -> &'static [Event] {
    static EVENTS: OnceLock<Vec<Event>> = OnceLock::new();
    EVENTS.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("run.mcap");
        write(&path);
        events_of(path).expect("played")
    })
}
