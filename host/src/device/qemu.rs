//! The firmware in QEMU's `mps2-an386`, its UART on a pseudo terminal.

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use super::DeviceError;

/// The emulated clock advances 8 ns an instruction, about what a 168 MHz Cortex-M4F needs,
/// and while the board idles it keeps to the real one.
const ICOUNT: &str = "shift=3,align=off,sleep=on";

/// A running emulator; dropped, it ends.
pub struct Qemu {
    child: Child,
    port: String,
}

/// `STICKSLIP_FIRMWARE`, or where `make firmware` puts it: under the current folder, or
/// the workspace this program was built from.
#[must_use]
pub fn default_firmware() -> PathBuf {
    if let Some(path) = std::env::var_os("STICKSLIP_FIRMWARE") {
        return path.into();
    }
    let built = Path::new("target/thumbv7em-none-eabihf/firmware/stickslip-mps2-an386");
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(built);
    if built.is_file() || !workspace.is_file() { built.to_owned() } else { workspace }
}

impl Qemu {
    /// Starts `firmware` and finds its serial line.
    ///
    /// # Errors
    /// Where the firmware or QEMU is not there, or QEMU does not come up.
    pub fn start(firmware: &Path) -> Result<Self, DeviceError> {
        if !firmware.is_file() {
            return Err(DeviceError::NoFirmware { path: firmware.to_owned() });
        }
        Command::new("qemu-system-arm")
            .arg("--version")
            .stdout(Stdio::null())
            .status()
            .map_err(|source| DeviceError::NoQemu { source })?;
        // Before other programs where that is allowed, else as any: a machine that holds the
        // emulator up while its board idles makes it wake late.
        let mut child = Command::new("nice")
            .args(["-n", "-5", "qemu-system-arm"])
            .args(["-machine", "mps2-an386", "-display", "none", "-monitor", "none"])
            .args(["-icount", ICOUNT])
            .args(["-semihosting-config", "enable=on,target=native", "-serial", "pty", "-kernel"])
            .arg(firmware)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|source| DeviceError::NoQemu { source })?;
        let (Some(stdout), Some(stderr)) = (child.stdout.take(), child.stderr.take()) else {
            return Err(DeviceError::QemuFailed { output: "no output".into() });
        };
        // "char device redirected to /dev/pts/3 (label serial0)": on stdout, before the
        // firmware's log, which follows there as defmt bytes.
        let mut stdout = BufReader::new(stdout);
        let mut said = Vec::new();
        let mut port = None;
        while port.is_none() {
            said.clear();
            match stdout.read_until(b'\n', &mut said) {
                Ok(0) | Err(_) => break,
                Ok(_) => port = find_port(&String::from_utf8_lossy(&said)),
            }
        }
        let Some(port) = port else {
            let _ = child.kill();
            let mut output = String::new();
            let _ = BufReader::new(stderr).read_to_string(&mut output);
            let _ = child.wait();
            return Err(DeviceError::QemuFailed { output: output.trim().to_owned() });
        };
        // A full pipe would stop the emulator.
        std::thread::spawn(move || std::io::copy(&mut stdout, &mut std::io::sink()));
        std::thread::spawn(move || std::io::copy(&mut BufReader::new(stderr), &mut std::io::sink()));
        Ok(Self { child, port })
    }

    /// Number of its process.
    pub(super) fn process(&self) -> u32 {
        self.child.id()
    }

    /// The line's path, and the emulator to keep.
    pub(super) fn split(self) -> (String, Option<Self>) {
        (self.port.clone(), Some(self))
    }
}

fn find_port(line: &str) -> Option<String> {
    line.split_whitespace().find(|word| word.starts_with("/dev/")).map(str::to_owned)
}

impl Drop for Qemu {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
