//! `stickslip monitor`: what a board predicts, as it happens.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use anyhow::ensure;
use ratatui::crossterm::event::{self, Event as Input, KeyCode, KeyModifiers};
use schemars::JsonSchema;
use serde::Serialize;
use stickslip_live::FOXGLOVE_ADDRESS;
use stickslip_live::event::{Event, Happened};
use stickslip_live::foxglove::Server;
use stickslip_live::source::{Source, follow};
use stickslip_live::state::{Alarm, Line, State};
use stickslip_live::{plain, view};
use stickslip_report::terminal::{Output, Style};

use super::package::of_trial;

/// Command line of `stickslip monitor`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip monitor --device serial:/dev/ttyACM0
  stickslip monitor --device qemu --data data/demo --foxglove
  stickslip monitor --device replay:run.mcap --speed 0.5
  stickslip monitor --device replay:run.mcap --plain
  stickslip monitor --device can:can0

Draws in the terminal: share of the friction limit used, friction, probability to hold, sag, alarms with how much \
they came ahead, the grip that holds with reserve, health of the line. q ends it. Without a terminal, or with --plain, it prints a line a \
second and one for each alarm. --foxglove serves the same to viewers (in Foxglove: Open connection, Foxglove WebSocket, ws://ADDRESS); a log is played when the first one has connected.")]
pub struct Args {
    /// `qemu`, `qemu:FIRMWARE`, `serial:PORT`, `can:INTERFACE` (what a board sends its controller), or `replay:FILE`: a log of
    /// stream, replay or board log
    #[arg(long, default_value = "qemu", value_name = "DEVICE")]
    pub device: String,
    /// Stream a trial of this data set to the board and watch that; without it the board is only watched
    #[arg(long, value_name = "DATA")]
    pub data: Option<PathBuf>,
    /// Trial to stream [default: the first]
    #[arg(long, value_name = "ID", requires = "data")]
    pub trial: Option<String>,
    /// Contact model [default: hard contact, friction 0.40 (fingers), 0.25 (pusher), 0.30 (support)]
    #[arg(long, value_name = "MODEL.toml", requires = "data")]
    pub model: Option<PathBuf>,
    /// Playback speed of a log; 1 is real time
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR")]
    pub speed: f64,
    /// Stop after this time [default: at q, or at the end of the log or trial]
    #[arg(long, value_name = "S")]
    pub seconds: Option<f64>,
    /// Print lines instead of drawing
    #[arg(long)]
    pub plain: bool,
    /// Serve viewers by WebSocket at this address
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = FOXGLOVE_ADDRESS)]
    pub foxglove: Option<String>,
}

impl Args {
    /// Only to watch a device, for `seconds`.
    pub(super) fn watching(device: &str, seconds: f64) -> Self {
        Self {
            device: device.to_owned(),
            data: None,
            trial: None,
            model: None,
            speed: 1.0,
            seconds: Some(seconds),
            plain: false,
            foxglove: None,
        }
    }
}

/// What was watched.
#[derive(JsonSchema, Serialize)]
pub(super) struct Summary {
    /// Device as given.
    device: String,
    /// From the first event to the last, s.
    seconds: f64,
    /// Predictions received.
    predictions: u64,
    /// Health of the line at the end.
    line: Line,
    /// The last 200 alarms, the newest last.
    alarms: Vec<Alarm>,
    /// All alarms.
    alarms_counted: usize,
}

/// Time from one picture to the next.
const FRAME: Duration = Duration::from_millis(50);

/// # Errors
/// Where data or log cannot be read, the device is not there, refuses or falls silent, the address is taken.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let source = Source::named(&args.device)?;
    ensure!((0.01..=1000.0).contains(&args.speed), "--speed is {}; give 0.01 to 1000", args.speed);
    let most = match args.seconds {
        Some(s) => {
            ensure!((0.0..=86_400.0).contains(&s), "--seconds is {s}; give 0 to 86400");
            Duration::from_secs_f64(s)
        }
        None => Duration::MAX,
    };
    if args.data.is_some() {
        source.takes_a_trial()?;
    }
    let trial = |data| of_trial(data, args.trial.as_deref(), args.model.as_deref(), output);
    let package = args.data.as_deref().map(trial).transpose()?;
    if args.device.starts_with("qemu") && package.is_none() {
        output.note(
            "a board in QEMU starts afresh and runs nothing by itself: --data DATA streams a trial to it",
        );
    }
    let server = args.foxglove.as_deref().map(Server::start).transpose()?;
    if let Some(server) = &server {
        output.note(format_args!("viewers connect to ws://localhost:{}", server.port()));
    }
    let began = Instant::now();
    if let (Some(server), Source::Log(_)) = (&server, &source) {
        output.note("the log is played when the first viewer has connected; Ctrl-C ends this");
        // A log is over before somebody has started a viewer.
        while server.viewers() == 0 && began.elapsed() < most {
            std::thread::sleep(FRAME);
        }
    }
    let mut watch = Watch { state: State::default(), server, until: began.checked_add(most) };
    let stop = AtomicBool::new(false);
    let package = package.as_ref().map(|(package, trial)| (package, trial.as_str()));
    std::thread::scope(|scope| {
        let (sender, events) = channel();
        let (source, halt) = (&source, &stop);
        let following = scope.spawn(move || {
            // Where nobody listens any more, `stop` ends it.
            follow(source, package, args.speed, halt, &mut |event| {
                let _ = sender.send(event);
            })
        });
        let draws = !args.plain && output.style() == Style::Human && std::io::stdout().is_terminal();
        let watched = if draws { watch.draw(&events) } else { watch.print(&events, output) };
        stop.store(true, Ordering::Relaxed);
        let followed = following.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        watched.and(followed)
    })?;
    let state = watch.state;
    for note in &state.notes {
        output.note(note);
    }
    let line = state.line();
    output.text(format_args!(
        "{} predictions in {:.2} s, {} alarms, {} reports lost",
        state.predictions, state.now_s, state.alarms_counted, line.reports_lost
    ));
    output.document(&Summary {
        device: args.device.clone(),
        seconds: state.now_s,
        predictions: state.predictions,
        line,
        alarms: state.alarms.into(),
        alarms_counted: state.alarms_counted,
    })
}

struct Watch {
    state: State,
    server: Option<Server>,
    /// `None`: without end.
    until: Option<Instant>,
}

impl Watch {
    /// The alarms that rose.
    fn take(&mut self, event: &Event) -> anyhow::Result<Vec<Alarm>> {
        let raised = self.state.take(event);
        if let Some(server) = &mut self.server {
            server.publish(event, &self.state, &raised)?;
        }
        Ok(raised)
    }

    fn over(&self) -> bool {
        self.until.is_some_and(|until| Instant::now() >= until)
    }

    /// A line a second and one for each alarm.
    fn print(&mut self, events: &Receiver<Event>, output: &Output) -> anyhow::Result<()> {
        let mut said_s = f64::NEG_INFINITY;
        while !self.over() {
            let event = match events.recv_timeout(FRAME) {
                Ok(event) => event,
                Err(RecvTimeoutError::Timeout) => continue,
                Err(RecvTimeoutError::Disconnected) => break,
            };
            if let Happened::Note(text) = &event.what {
                output.note(text);
                continue;
            }
            for alarm in self.take(&event)? {
                output.text(format_args!("ALARM {}", plain::alarm(&alarm)));
            }
            let told =
                matches!(event.what, Happened::Report(_) | Happened::Prediction(_) | Happened::Heard(_));
            if told && event.at_s.floor() > said_s {
                said_s = event.at_s.floor();
                output.text(plain::line(&self.state));
            }
        }
        Ok(())
    }

    /// Pictures until q. What has ended stays to be looked at.
    fn draw(&mut self, events: &Receiver<Event>) -> anyhow::Result<()> {
        let mut terminal = ratatui::try_init()?;
        let shown = self.pictures(events, &mut terminal);
        ratatui::try_restore()?;
        shown
    }

    fn pictures(
        &mut self,
        events: &Receiver<Event>,
        terminal: &mut ratatui::DefaultTerminal,
    ) -> anyhow::Result<()> {
        let mut ended = false;
        loop {
            let next = Instant::now() + FRAME;
            while !ended {
                match events.recv_timeout(next.saturating_duration_since(Instant::now())) {
                    Ok(event) => drop(self.take(&event)?),
                    Err(RecvTimeoutError::Timeout) => break,
                    Err(RecvTimeoutError::Disconnected) => {
                        ended = true;
                        // Nothing came: the error is more worth than a picture of nothing.
                        if self.state.predictions == 0 {
                            return Ok(());
                        }
                        self.state.notes.push("it has ended".to_owned());
                    }
                }
            }
            terminal.draw(|frame| view::draw(frame, &self.state))?;
            let wait = if ended { FRAME } else { Duration::ZERO };
            while event::poll(wait)? {
                if ends(&event::read()?) {
                    return Ok(());
                }
            }
            if self.over() {
                return Ok(());
            }
        }
    }
}

/// q, escape, and what ends programs elsewhere.
fn ends(input: &Input) -> bool {
    let Input::Key(key) = input else { return false };
    let control = key.modifiers.contains(KeyModifiers::CONTROL);
    matches!(key.code, KeyCode::Char('q') | KeyCode::Esc) || control && key.code == KeyCode::Char('c')
}
