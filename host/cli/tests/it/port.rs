//! An emulated board at a serial port.

use std::ffi::OsStr;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

/// QEMU with its UART on a pseudo terminal; ends when dropped.
pub struct Port(Child);

impl Port {
    /// Starts `firmware`; and the device to name to who opens it.
    pub fn open(firmware: impl AsRef<OsStr>) -> (Self, String) {
        let mut child = Command::new("qemu-system-arm")
            .args(["-machine", "mps2-an386", "-display", "none", "-monitor", "none", "-serial", "pty"])
            .args(["-icount", "shift=3,align=off,sleep=on", "-kernel"])
            .arg(firmware)
            .args(["-semihosting-config", "enable=on,target=native"])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .expect("QEMU");
        // "char device redirected to /dev/pts/3 (label serial0)", then the firmware's log.
        let mut stdout = BufReader::new(child.stdout.take().expect("piped"));
        let mut line = Vec::new();
        let name = loop {
            line.clear();
            assert!(stdout.read_until(b'\n', &mut line).expect("its output") > 0, "QEMU names no port");
            let text = String::from_utf8_lossy(&line).into_owned();
            if let Some(name) = text.split_whitespace().find(|word| word.starts_with("/dev/")) {
                break name.to_owned();
            }
        };
        std::thread::spawn(move || std::io::copy(&mut stdout, &mut std::io::sink()));
        (Self(child), format!("serial:{name}"))
    }
}

impl Drop for Port {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
