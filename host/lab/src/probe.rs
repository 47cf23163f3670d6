//! Runs one embedded-test on a board behind a debug probe: flash, start, answer its
//! semihosting calls, take its exit for the verdict. The same file and the same protocol as
//! under QEMU, which answers these calls itself.

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use probe_rs::flashing::{ElfLoader, ElfOptions, download_file};
use probe_rs::semihosting::SemihostingCommand;
use probe_rs::{BreakpointCause, CoreStatus, HaltReason, Session, SessionConfig};

/// Between two looks at the core.
const POLL: Duration = Duration::from_millis(10);
/// For reset and halt.
const HALT: Duration = Duration::from_secs(1);

/// A board with the tests flashed.
pub struct Board {
    session: Session,
}

impl Board {
    /// Attaches to the only probe that is connected and flashes `elf` onto `chip` (probe-rs'
    /// name, for example `STM32G474RETx`).
    ///
    /// # Errors
    /// No probe or several, another chip, flash that cannot be written.
    pub fn flash(chip: &str, elf: &Path) -> anyhow::Result<Self> {
        let mut session = Session::auto_attach(chip, SessionConfig::default())
            .with_context(|| format!("no {chip} behind a debug probe: is it connected, and only one?"))?;
        download_file(&mut session, elf, ElfLoader(ElfOptions::default()))
            .with_context(|| format!("{} cannot be flashed", elf.display()))?;
        Ok(Self { session })
    }

    /// Runs the test at `address`.
    ///
    /// # Errors
    /// The test failed, stopped elsewhere, or did not end within `patience`.
    pub fn run(&mut self, address: u32, patience: Duration) -> anyhow::Result<()> {
        let mut core = self.session.core(0)?;
        core.reset_and_halt(HALT)?;
        core.run()?;
        let began = Instant::now();
        loop {
            let call = match core.status()? {
                CoreStatus::Halted(HaltReason::Breakpoint(BreakpointCause::Semihosting(call))) => call,
                CoreStatus::Halted(reason) => bail!("the board stopped: {reason:?}"),
                _ if began.elapsed() > patience => bail!("no end after {} s", patience.as_secs()),
                _ => {
                    std::thread::sleep(POLL);
                    continue;
                }
            };
            match call {
                SemihostingCommand::ExitSuccess => return Ok(()),
                SemihostingCommand::ExitError(details) => bail!("on the board: {details}"),
                SemihostingCommand::GetCommandLine(request) => {
                    request.write_command_line_to_target(&mut core, &format!("run_addr {address}"))?;
                }
                SemihostingCommand::WriteConsole(request) => eprint!("{}", request.read(&mut core)?),
                // Nothing else is needed by the tests; the board sees the call refused.
                _ => {}
            }
            core.run()?;
        }
    }
}
