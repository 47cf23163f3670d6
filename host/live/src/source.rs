//! Where events come from: a board, a board that is sent a recorded trial, what a board puts on a bus, or a log played
//! again in its own time.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Context, bail, ensure};
use stickslip_device::package::Package;
use stickslip_device::records::{PREDICTION_RECORD, SAMPLE_RECORD, TELEMETRY_RECORD};
use stickslip_device::{Device, log, session};
use stickslip_shared::model::Scene;

use crate::NAP;
use crate::event::{Event, Happened};

/// Where events come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// A board, by the name that [`Device::open`] takes.
    Board(String),
    /// A board by what it puts on this CAN interface.
    Bus(String),
    /// A log that `stream`, `replay` or `board log` wrote.
    Log(PathBuf),
}

impl Source {
    /// `can:INTERFACE`, `replay:FILE`, or a board.
    ///
    /// # Errors
    /// Neither interface nor file named.
    pub fn named(name: &str) -> anyhow::Result<Self> {
        match name.split_once(':') {
            Some(("replay", "")) => bail!("replay: names no file: `replay:run.mcap`"),
            Some(("replay", file)) => Ok(Self::Log(file.into())),
            Some(("can", "")) => bail!("can: names no interface: `can:can0`"),
            Some(("can", interface)) => Ok(Self::Bus(interface.to_owned())),
            _ => Ok(Self::Board(name.to_owned())),
        }
    }

    /// Whether a recorded trial can be sent there.
    ///
    /// # Errors
    /// It cannot: the text says why, and what to do.
    pub fn takes_a_trial(&self) -> anyhow::Result<()> {
        match self {
            Self::Board(_) => Ok(()),
            Self::Bus(_) => bail!(
                "--data is for a board on a line: a bus takes no trial; connect the board by `serial:PORT` to send it one"
            ),
            Self::Log(_) => bail!("--data is for a board; a log holds the trial that it is of"),
        }
    }
}

/// How often the board is asked for its counts.
const COUNTS: Duration = Duration::from_secs(1);

/// Follows `source` until it ends or `stop` is set. A board gets the trial in `package`, where there is one; a log is
/// played `speed` times as fast as it was written.
///
/// # Errors
/// A board that is not there, refuses, falls silent or is cut off; a log that cannot be read or holds no prediction.
pub fn follow(
    source: &Source,
    package: Option<(&Package, &str)>,
    speed: f64,
    stop: &AtomicBool,
    tell: &mut dyn FnMut(Event),
) -> anyhow::Result<()> {
    if package.is_some() {
        source.takes_a_trial()?;
    }
    match source {
        Source::Log(file) => play(file, speed, stop, tell),
        Source::Bus(interface) => listen(interface, stop, tell),
        Source::Board(name) => {
            let mut device = Device::open(name)?;
            let began = Instant::now();
            let mut tell = |what| tell(Event { at_s: began.elapsed().as_secs_f64(), what });
            tell(Happened::Board(Box::new(device.info().clone())));
            match package {
                Some((package, trial)) => stream(&mut device, package, trial, stop, &mut tell),
                None => watch(&mut device, stop, &mut tell),
            }
        }
    }
}

#[cfg(target_os = "linux")]
fn listen(interface: &str, stop: &AtomicBool, tell: &mut dyn FnMut(Event)) -> anyhow::Result<()> {
    let socket = crate::bus::open(interface)?;
    let began = Instant::now();
    crate::bus::watch(&socket, interface, stop, &mut |what| {
        tell(Event { at_s: began.elapsed().as_secs_f64(), what });
    })
}

#[cfg(not(target_os = "linux"))]
fn listen(interface: &str, _stop: &AtomicBool, _tell: &mut dyn FnMut(Event)) -> anyhow::Result<()> {
    bail!(
        "`can:{interface}` needs Linux, whose CAN interfaces programs can read: connect the board by `serial:PORT`"
    )
}

fn watch(device: &mut Device, stop: &AtomicBool, tell: &mut dyn FnMut(Happened)) -> anyhow::Result<()> {
    let mut asked: Option<Instant> = None;
    while !stop.load(Ordering::Relaxed) {
        if asked.is_none_or(|at| at.elapsed() >= COUNTS) {
            asked = Some(Instant::now());
            let counts = device.statistics()?;
            tell(Happened::Counts(Box::new(counts), device.damaged_frames()));
        }
        if let Some(report) = device.report(NAP)? {
            tell(Happened::Report(Box::new(report)));
        }
    }
    Ok(())
}

fn stream(
    device: &mut Device,
    package: &Package,
    trial: &str,
    stop: &AtomicBool,
    tell: &mut dyn FnMut(Happened),
) -> anyhow::Result<()> {
    tell(Happened::Scene(Box::new(package.model.0.clone()), trial.to_owned()));
    let outcome = session::stream(device, package, session::Pace::Board, None, &mut |event| {
        if stop.load(Ordering::Relaxed) {
            return Err(std::io::ErrorKind::Interrupted.into());
        }
        tell(match event {
            session::Event::Sent(sample) => Happened::Sample(*sample),
            session::Event::Report(report) => Happened::Report(Box::new(*report)),
        });
        Ok(())
    });
    if stop.load(Ordering::Relaxed) {
        return Ok(());
    }
    let outcome = outcome?;
    tell(Happened::Counts(Box::new(outcome.statistics), outcome.frames_damaged));
    tell(Happened::Note(format!(
        "trial finished: {} of {} predictions equal this host's bit for bit",
        outcome.equal, outcome.compared
    )));
    Ok(())
}

fn play(file: &Path, speed: f64, stop: &AtomicBool, tell: &mut dyn FnMut(Event)) -> anyhow::Result<()> {
    let named = || file.display().to_string();
    let contents = log::read(file)?;
    if let Some(header) = &contents.header {
        if let Some(hz) = header.meta.get("timer_hz").and_then(serde_json::Value::as_u64) {
            tell(Event { at_s: 0.0, what: Happened::Timer(u32::try_from(hz).unwrap_or_default()) });
        }
        // `board log` knows no scene.
        if let Ok((scene, [])) = postcard::take_from_bytes::<Scene<f32>>(&header.scene) {
            let trial = header.meta.get("trial").and_then(|name| name.as_str()).unwrap_or_default();
            tell(Event { at_s: 0.0, what: Happened::Scene(Box::new(scene), trial.to_owned()) });
        }
    }
    if let Some(lost) = contents.loss() {
        tell(Event { at_s: 0.0, what: Happened::Note(format!("{}: {lost}", named())) });
    }
    let began = Instant::now();
    let mut predictions = 0;
    for record in &contents.records {
        let at_s = record.host_ns as f64 * 1e-9;
        let unreadable = || format!("{}: a record in it cannot be read: it is of another version", named());
        let what = match record.kind {
            TELEMETRY_RECORD => {
                Happened::Report(postcard::from_bytes(&record.payload).with_context(unreadable)?)
            }
            PREDICTION_RECORD => {
                Happened::Prediction(postcard::from_bytes(&record.payload).with_context(unreadable)?)
            }
            SAMPLE_RECORD => {
                Happened::Sample(postcard::from_bytes(&record.payload).with_context(unreadable)?)
            }
            _ => continue,
        };
        predictions += usize::from(!matches!(what, Happened::Sample(_)));
        loop {
            if stop.load(Ordering::Relaxed) {
                return Ok(());
            }
            let wait_s = at_s / speed - began.elapsed().as_secs_f64();
            if wait_s <= 0.0 {
                break;
            }
            std::thread::sleep(Duration::from_secs_f64(wait_s).min(NAP));
        }
        tell(Event { at_s, what });
    }
    ensure!(predictions > 0, "{}: the log holds no predictions", named());
    Ok(())
}
