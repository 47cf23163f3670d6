//! A unit on CAN-FD as its gripper's controller hears it: one state a tick, and its fingers' wrenches where sensors
//! put them on the bus (`docs/stickslip.dbc`). Nothing is sent.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Context, anyhow};
use socketcan::embedded_can::{Frame, Id};
use socketcan::errors::CanError;
use socketcan::{CanAnyFrame, CanFdSocket, CanFilter, ShouldRetry, Socket, SocketOptions};
use stickslip_unit::bus::{CLASSIC_STATE_ID, OWN_IDS, STATE_ID, State, WRENCH_ID, Wrench};

use crate::NAP;
use crate::event::Happened;

/// A unit sends 250 states a second: after so long without one that is said.
const SILENT: Duration = Duration::from_secs(1);
/// All bits of a standard identifier.
const WHOLE_ID: u32 = 0x7ff;

/// Listens on a CAN interface, to the frames of a unit and to errors of the bus.
///
/// # Errors
/// A kernel without CAN, an interface that there is not or that is down: the text says what to do.
pub fn open(interface: &str) -> anyhow::Result<CanFdSocket> {
    let up = format!(
        "bring it up by `ip link set {interface} up type can bitrate 1000000 dbitrate 2000000 fd on`, with the bit rates \
         of your bus"
    );
    let opened = || -> io::Result<CanFdSocket> {
        let socket = CanFdSocket::open(interface)?;
        socket.set_filters(&OWN_IDS.map(|id| CanFilter::new(id.into(), WHOLE_ID)))?;
        socket.set_error_filter_accept_all()?;
        Ok(socket)
    };
    opened().map_err(|error| match rustix::io::Errno::from_io_error(&error) {
        Some(rustix::io::Errno::NODEV) => {
            anyhow!("there is no CAN interface `{interface}`: `ip -br link` lists those there are; {up}")
        }
        Some(rustix::io::Errno::AFNOSUPPORT | rustix::io::Errno::PROTONOSUPPORT) => anyhow!(
            "this machine's kernel has no CAN sockets, so that `{interface}` cannot be opened: load them by \
             `modprobe can-raw`, or connect the board by `serial:PORT`"
        ),
        _ => anyhow!(error).context(format!("cannot listen on the CAN interface `{interface}`; {up}")),
    })
}

/// Tells what comes over `socket`, which is that of `interface`, until `stop` is set.
///
/// # Errors
/// An interface that goes down.
pub fn watch(
    socket: &CanFdSocket,
    interface: &str,
    stop: &AtomicBool,
    tell: &mut dyn FnMut(Happened),
) -> anyhow::Result<()> {
    socket.set_read_timeout(NAP)?;
    let mut damaged = 0;
    let mut heard = Instant::now();
    let mut silent = false;
    while !stop.load(Ordering::Relaxed) {
        match socket.read_frame() {
            Ok(CanAnyFrame::Error(frame)) => {
                tell(Happened::Note(format!("{interface}: {}", CanError::from(frame))));
            }
            Ok(frame) => match take(&frame) {
                Ok(Some(what)) => {
                    if matches!(what, Happened::Heard(_)) {
                        (heard, silent) = (Instant::now(), false);
                    }
                    tell(what);
                }
                Ok(None) => {}
                Err(Damaged) => {
                    damaged += 1;
                    tell(Happened::Damaged(damaged));
                }
            },
            Err(error) if error.should_retry() => {}
            Err(error) => {
                return Err(error).with_context(|| format!("the CAN interface `{interface}` fails"));
            }
        }
        if !silent && heard.elapsed() >= SILENT {
            silent = true;
            let remark = format!(
                "{interface}: no state of a unit (identifier {STATE_ID:#x} or {CLASSIC_STATE_ID:#x}) for {} s: is the unit on, and do bit rates \
                 and termination of the bus fit?",
                SILENT.as_secs()
            );
            tell(Happened::Note(remark));
        }
    }
    Ok(())
}

/// A frame of the unit or of its sensors of another length, or with a value that there is not.
struct Damaged;

fn take(frame: &CanAnyFrame) -> Result<Option<Happened>, Damaged> {
    let (id, data) = match frame {
        CanAnyFrame::Fd(frame) => (frame.id(), frame.data()),
        CanAnyFrame::Normal(frame) => (frame.id(), frame.data()),
        CanAnyFrame::Remote(_) | CanAnyFrame::Error(_) => return Ok(None),
    };
    let Id::Standard(id) = id else { return Ok(None) };
    let state = match id.as_raw() {
        STATE_ID => Some(State::decode(data)),
        CLASSIC_STATE_ID => Some(State::decode_classic(data)),
        _ => None,
    };
    if let Some(state) = state {
        return state.map(|state| Some(Happened::Heard(Box::new(state)))).ok_or(Damaged);
    }
    let Some(finger) = id.as_raw().checked_sub(WRENCH_ID).filter(|finger| *finger < 2) else {
        return Ok(None);
    };
    let wrench = Wrench::decode(data).ok_or(Damaged)?;
    Ok(Some(Happened::Wrench(usize::from(finger), wrench.valid.then_some(wrench.values))))
}
