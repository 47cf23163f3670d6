//! Ctrl-C while a log is written: what was recorded is closed with its index, as some viewers need it.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::SIGINT;
use signal_hook::flag;

/// Whether Ctrl-C was pressed. Pressed again it ends the program at once.
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// From now on Ctrl-C is only noted.
    ///
    /// # Errors
    /// What the operating system answers.
    pub fn noted() -> std::io::Result<Self> {
        let came = Arc::new(AtomicBool::new(false));
        // The second one finds the first noted.
        flag::register_conditional_shutdown(SIGINT, 130, Arc::clone(&came))?;
        flag::register(SIGINT, Arc::clone(&came))?;
        Ok(Self(came))
    }

    /// An error once it came.
    ///
    /// # Errors
    /// [`std::io::ErrorKind::Interrupted`].
    pub fn check(&self) -> std::io::Result<()> {
        if self.came() { Err(std::io::ErrorKind::Interrupted.into()) } else { Ok(()) }
    }

    /// `result` as it is, or what to say where it is an error and Ctrl-C came before.
    ///
    /// # Errors
    /// That of `result`, in other words where Ctrl-C came.
    pub fn explain<T>(&self, result: anyhow::Result<T>, log: &Path) -> anyhow::Result<T> {
        result.map_err(|error| match self.came() {
            true => anyhow::anyhow!("interrupted; {} holds what came until then", log.display()),
            false => error,
        })
    }

    fn came(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
