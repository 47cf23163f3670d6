//! What can go wrong with a board, and what to do about it.

use std::io;
use std::path::PathBuf;

use stickslip_shared::wire::Refusal;
use thiserror::Error;

/// Why a board could not be used.
#[derive(Debug, Error)]
pub enum DeviceError {
    /// Not a device name.
    #[error(
        "`{name}` is no device: use `qemu`, `qemu:FIRMWARE` or `serial:PORT` (for example serial:/dev/ttyACM0)"
    )]
    Name {
        /// As given.
        name: String,
    },
    /// The port cannot be opened.
    #[error("no device at {port}: check the cable and the name, and that no other program has it open")]
    NotThere {
        /// Path of the port.
        port: String,
        /// What the system says.
        source: serialport::Error,
    },
    /// The emulator cannot be started.
    #[error("qemu-system-arm cannot be started: `make setup` installs it")]
    NoQemu {
        /// What the system says.
        source: io::Error,
    },
    /// The firmware for the emulator was not built.
    #[error("no firmware at {path}: build it with `make firmware`, or name one with `qemu:PATH`")]
    NoFirmware {
        /// Where it was looked for.
        path: PathBuf,
    },
    /// The emulator ended or gave no serial line.
    #[error("QEMU gave no serial line: {output}")]
    QemuFailed {
        /// What it printed.
        output: String,
    },
    /// The line was there and is gone.
    #[error("the line to the board was cut: {cause}")]
    Cut {
        /// What the system says.
        cause: String,
    },
    /// Silence.
    #[error(
        "the board did not answer `{request}`: is the stickslip firmware on it, and the line at 1 Mbaud?"
    )]
    NoAnswer {
        /// Path of the request.
        request: &'static str,
    },
    /// No telemetry in a run.
    #[error("the board fell silent after sample {last:?} of {count}")]
    Silent {
        /// The last sample that it reported.
        last: Option<u32>,
        /// Samples in the run.
        count: usize,
    },
    /// The board restarted in a run.
    #[error("the board restarted in the middle of the run (after sample {last:?}); it is in its safe state")]
    Restarted {
        /// The last sample that it reported.
        last: Option<u32>,
    },
    /// The answer's bytes are not one.
    #[error("the board's answer to `{request}` cannot be read: firmware and host are of different versions")]
    Undecodable {
        /// Path of the request.
        request: &'static str,
    },
    /// The firmware lacks the request.
    #[error("the firmware does not know `{request}`: firmware and host are of different versions")]
    UnknownRequest {
        /// Path of the request.
        request: &'static str,
    },
    /// Another protocol.
    #[error("the board uses protocol {board}, this program {host}: flash the matching firmware")]
    Protocol {
        /// Of the firmware.
        board: u16,
        /// Of this program.
        host: u16,
    },
    /// Longer than a frame.
    #[error("`{request}` does not fit a frame")]
    TooLong {
        /// Path of the request.
        request: &'static str,
    },
    /// Longer than the board's memory for it.
    #[error("the model does not fit the board: {bytes} bytes, room for {room}; use fewer effects")]
    ModelTooLong {
        /// Of the model.
        bytes: usize,
        /// On the board.
        room: u16,
    },
    /// Refused with a reason.
    #[error("the board refused `{request}`: {}", reason(.refusal))]
    Refused {
        /// Path of the request.
        request: &'static str,
        /// Why.
        refusal: Refusal,
    },
}

/// Why, in words.
pub fn reason(refusal: &Refusal) -> String {
    match refusal {
        Refusal::TooLarge { limit } => format!("it is longer than {limit} bytes"),
        Refusal::Offset { expected } => format!("it waits for the piece at byte {expected}"),
        Refusal::Length { received } => format!("{received} bytes arrived, not the announced number"),
        Refusal::Crc { received } => {
            format!("the checksum of what arrived is {received:#010x}, not the announced")
        }
        Refusal::Undecodable => "the bytes are not a model of this firmware's version".into(),
        Refusal::Model(fault) => format!("the predictor cannot run the model ({fault:?})"),
        Refusal::OutOfRange { field, value, low, high } => {
            format!("{field:?} is {value}, allowed is {low} to {high}")
        }
        Refusal::Busy => "a run is going on, or too many commands wait".into(),
        Refusal::NoModel => "no model is loaded".into(),
        Refusal::NoPort => "it has no such port for a sensor".into(),
        Refusal::RoleTaken { finger } => format!("two sensors for finger {}: name one", finger + 1),
        Refusal::PortTaken { port } => format!("{port:?} is one sensor: it cannot measure both fingers"),
        Refusal::BaseTaken { base } => {
            format!("base identifier {base} has the unit's own frames on CAN: set the sensor to another")
        }
        Refusal::ClassicBus => {
            "an ATI sensor knows classic CAN frames only, `can` sends CAN-FD: they cannot share the bus"
                .into()
        }
        Refusal::NoSensor { finger } => {
            format!("finger {} has no sensor: `stickslip board sensors` assigns one", finger + 1)
        }
        Refusal::Singular { finger } => {
            format!(
                "the matrix of finger {} is singular: six readings would not give six components",
                finger + 1
            )
        }
        Refusal::NotCalibrated { finger } => {
            format!(
                "the sensor of finger {} has no matrix: send one first (`stickslip board calibrate`)",
                finger + 1
            )
        }
        Refusal::OtherScene => {
            "the model is of another scene than the run that goes on (object, pads, pusher, table): stop \
                                the run first"
                .into()
        }
        Refusal::NoMemory => "it has no memory for settings".into(),
        Refusal::NotStored => {
            "its memory could not be written: what was stored before may still be there; or a model was \
                                refused after the one in use: load that again, then store"
                .into()
        }
    }
}
