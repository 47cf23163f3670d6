//! Runs an analysis without the interpreter's lock, tells how far it is, and stops it by Ctrl-C.
//!
//! The work has a thread of its own (and those of rayon under it); the thread that called waits and looks for
//! signals, which Python shows to its main thread only. A call that is given up returns at once. Its work ends
//! when it next tells of a step, by unwinding: no engine knows of it.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::Builder;
use std::time::Duration;

use anyhow::anyhow;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use stickslip_analysis::Progress;

use crate::errors::raised;

/// Between two looks at signals.
const LOOK: Duration = Duration::from_millis(50);
/// As the main thread of a command has: the fits recurse.
const STACK_BYTES: usize = 8 << 20;

/// How far a call is, and whether it was given up.
#[derive(Default)]
struct Watched {
    given_up: AtomicBool,
    stage: Mutex<(&'static str, usize)>,
    done: AtomicUsize,
}

/// Unwinds through work that was given up.
struct GivenUp;

impl Watched {
    fn leave_if_given_up(&self) {
        if self.given_up.load(Ordering::Relaxed) {
            // Not `panic!`: nobody shall read of it.
            resume_unwind(Box::new(GivenUp));
        }
    }

    fn now(&self) -> (&'static str, usize, usize) {
        let (stage, steps) = *self.stage.lock().unwrap_or_else(PoisonError::into_inner);
        (stage, self.done.load(Ordering::Relaxed).min(steps), steps)
    }
}

impl Progress for Watched {
    fn begin(&self, stage: &'static str, steps: usize) {
        self.leave_if_given_up();
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner) = (stage, steps);
        self.done.store(0, Ordering::Relaxed);
    }

    fn step(&self, steps: usize) {
        self.leave_if_given_up();
        self.done.fetch_add(steps, Ordering::Relaxed);
    }
}

/// What `work` returns; `told` is called with stage, steps done and steps in all whenever these change.
///
/// # Errors
/// The exception of what `work` answers, a signal's (`KeyboardInterrupt`), or what `told` raises.
pub fn watched<T: Send + 'static>(
    py: Python<'_>,
    told: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&dyn Progress) -> anyhow::Result<T> + Send + 'static,
) -> PyResult<T> {
    let watched = Arc::new(Watched::default());
    let (sender, receiver) = sync_channel(1);
    let inside = Arc::clone(&watched);
    let run = move || {
        // Nobody listens any more where it was given up.
        let _ = sender.send(catch_unwind(AssertUnwindSafe(|| work(&*inside))));
    };
    Builder::new().name("stickslip".into()).stack_size(STACK_BYTES).spawn(run)?;
    let receiver = Mutex::new(receiver);
    let mut last = ("", 0, 0);
    loop {
        let next = py.detach(|| receiver.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(LOOK));
        match next {
            Ok(Ok(result)) => return result.map_err(|error| raised(&error)),
            Ok(Err(panic)) => return Err(bug(&*panic)),
            Err(RecvTimeoutError::Disconnected) => {
                return Err(raised(&anyhow!("the work ended without a result")));
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
        let seen = py.check_signals().and_then(|()| {
            let now = watched.now();
            match told {
                Some(told) if now != last => {
                    last = now;
                    told.call1(now).map(|_| ())
                }
                _ => Ok(()),
            }
        });
        if let Err(raised) = seen {
            watched.given_up.store(true, Ordering::Relaxed);
            return Err(raised);
        }
    }
}

/// A panic is ours, not the user's.
fn bug(panic: &(dyn Any + Send)) -> PyErr {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no text");
    PyRuntimeError::new_err(format!("a mistake in stickslip, please report it: {text}"))
}
