//! The firmware in QEMU's `mps2-an386`, its line through shared memory.

use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use stickslip_shared::wire::mailbox::MEMORY_BYTES;

use super::mailbox::{Offer, Reading, Writing};
use crate::error::DeviceError;

/// The emulated clock advances 8 ns an instruction, about what a 168 MHz Cortex-M4F needs,
/// and waits for this machine's clock where it is ahead of it.
const ICOUNT: &str = "shift=3,align=on,sleep=on";
/// How long the board may take to come up on a busy machine.
const START: Duration = Duration::from_secs(20);

/// A running emulator; dropped, it ends.
pub struct Qemu {
    child: Child,
}

/// A program for the emulated board: what the environment's `variable` names, or `name` where
/// the Makefile puts it, under the current folder or the workspace this program was built from.
#[must_use]
pub fn built(variable: &str, name: &str) -> PathBuf {
    if let Some(path) = std::env::var_os(variable) {
        return path.into();
    }
    let built = Path::new("target/thumbv7em-none-eabihf/firmware").join(name);
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(&built);
    if built.is_file() || !workspace.is_file() { built } else { workspace }
}

/// What the emulator has said so far, and whether it has ended.
struct Said {
    ended: Arc<AtomicBool>,
    errors: std::thread::JoinHandle<String>,
}

impl Qemu {
    /// Starts `firmware` and waits until it is at its line.
    ///
    /// # Errors
    /// Where the firmware or QEMU is not there, or the board does not come up.
    pub fn start(firmware: &Path) -> Result<(Self, Reading, Writing), DeviceError> {
        if !firmware.is_file() {
            return Err(DeviceError::NoFirmware { path: firmware.to_owned() });
        }
        let failed = |output: String| DeviceError::QemuFailed { output };
        let offer = Offer::new().map_err(|error| failed(format!("no memory to share: {error}")))?;
        let memory = format!(
            "memory-backend-file,id=line,size={MEMORY_BYTES},share=on,mem-path={}",
            offer.path().display()
        );
        let mut command = Command::new("qemu-system-arm");
        end_with_this_process(&mut command);
        let child = command
            .args(["-machine", "mps2-an386,memory-backend=line", "-object", &memory])
            .args(["-display", "none", "-monitor", "none", "-serial", "null"])
            .args(["-icount", ICOUNT, "-semihosting-config", "enable=on,target=native", "-kernel"])
            .arg(firmware)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|source| DeviceError::NoQemu { source })?;
        let mut qemu = Self { child };
        qemu.prefer();
        let Some(said) = qemu.listen() else { return Err(failed("no output".into())) };
        let began = Instant::now();
        loop {
            match offer.taken() {
                Ok(true) => break,
                Ok(false) if said.ended.load(Ordering::Acquire) => {
                    return Err(failed(said.errors.join().unwrap_or_default()));
                }
                Ok(false) if began.elapsed() < START => std::thread::sleep(Duration::from_millis(2)),
                Ok(false) => return Err(failed("the firmware did not start".into())),
                Err(error) => return Err(failed(error.to_string())),
            }
        }
        let (reading, writing) = offer.into_halves(&said.ended);
        Ok((qemu, reading, writing))
    }

    /// Before other programs where that is allowed, else as any: a busy machine holds the
    /// emulator up.
    fn prefer(&self) {
        let process = self.child.id().to_string();
        let mut renice = Command::new("renice");
        renice.args(["-n", "-5", "-p", &process]).stdout(Stdio::null()).stderr(Stdio::null());
        // Only a help: without the right to it, or without the program, all goes on as it is.
        let _ = renice.status();
    }

    /// Reads what the emulator prints: a full pipe would stop it. On stdout is the firmware's
    /// log as defmt bytes.
    fn listen(&mut self) -> Option<Said> {
        let (mut stdout, mut stderr) = (self.child.stdout.take()?, self.child.stderr.take()?);
        let ended = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&ended);
        std::thread::spawn(move || {
            let _ = io::copy(&mut stdout, &mut io::sink());
            flag.store(true, Ordering::Release);
        });
        let errors = std::thread::spawn(move || {
            let mut text = Vec::new();
            let _ = stderr.by_ref().take(4096).read_to_end(&mut text);
            let _ = io::copy(&mut stderr, &mut io::sink());
            String::from_utf8_lossy(&text).trim().to_owned()
        });
        Some(Said { ended, errors })
    }

    /// Number of its process.
    pub(super) fn process(&self) -> u32 {
        self.child.id()
    }
}

/// Also where this process is killed the emulator must not run on: its board never idles.
#[cfg(target_os = "linux")]
fn end_with_this_process(command: &mut Command) {
    use rustix::process::{Signal, set_parent_process_death_signal};
    use std::os::unix::process::CommandExt;
    // SAFETY: between fork and exec, one system call and nothing else.
    unsafe { command.pre_exec(|| Ok(set_parent_process_death_signal(Some(Signal::KILL))?)) };
}

#[cfg(not(target_os = "linux"))]
fn end_with_this_process(_: &mut Command) {}

impl Drop for Qemu {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
