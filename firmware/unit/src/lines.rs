//! The tasks at the unit's serial line and bus: bytes and frames of sensors in, readings to the control task, the unit's state
//! out.

use embassy_futures::select::{Either3, select3};
use embassy_futures::yield_now;
use embassy_time::{Duration, Instant, Ticker, Timer, with_timeout};
use embedded_io_async::{Read, Write};
use stickslip_shared::wire::TICK_US;

use crate::between::{Between, SensorLines};
use crate::bus::{CLASSIC_STATE_ID, STATE_ID};
use crate::source::ft300::{STOP, STOP_COUNT, start_stream};

/// For how long a frame may wait for the bus: a tick, then there is a newer one.
const WAITS: Duration = Duration::from_micros(TICK_US as u64);

/// Silence on the serial line after which its sensor is asked again to stream: ten of its frames.
const SILENCE: Duration = Duration::from_millis(100);

// Programs of the host, which have no driver of the time, never meet it.
#[inline]
fn now_us() -> u32 {
    Instant::now().as_micros() as u32
}

/// A sensor that streams on the serial line, for ever: asks it to stream whenever it is silent.
pub async fn serial<R: Read, W: Write>(between: &Between, sensors: &SensorLines, mut rx: R, mut tx: W) -> ! {
    let mut bytes = [0; 32];
    loop {
        if !sensors.with(|hub| hub.has_serial()).unwrap_or(false) {
            Timer::after(SILENCE).await;
            continue;
        }
        match with_timeout(SILENCE, rx.read(&mut bytes)).await {
            Ok(Ok(count)) => {
                let at_us = now_us();
                sensors.bytes(between, bytes.get(..count).unwrap_or_default(), at_us);
            }
            Ok(Err(_)) => between.counters.readings_damaged.add(1),
            Err(_) => {
                // A stream that was begun and is not understood must end before it can begin.
                let _ = tx.write_all(&[STOP; STOP_COUNT]).await;
                let _ = tx.write_all(&start_stream()).await;
            }
        }
    }
}

/// A CAN-FD controller.
// One executor runs it, on one core: no future need be `Send`.
#[allow(async_fn_in_trait)]
pub trait Bus {
    /// The next frame with a standard identifier, into `data`: identifier and length; `None`: the bus is disturbed,
    /// and may say so again at once.
    async fn read(&mut self, data: &mut [u8; 64]) -> Option<(u16, usize)>;
    /// Sends a frame; with more than 8 bytes as CAN-FD. Waits while the bus takes none.
    async fn write(&mut self, id: u16, data: &[u8]);
}

async fn send<B: Bus>(between: &Between, bus: &mut B, id: u16, data: &[u8]) {
    // A bus that is off, or where nobody else is, takes none: reading must go on.
    if with_timeout(WAITS, bus.write(id, data)).await.is_err() {
        between.counters.frames_unsent.add(1);
    }
}

/// Sensors and the unit's state on the bus, for ever.
pub async fn bus<B: Bus>(between: &Between, sensors: &SensorLines, mut bus: B) -> ! {
    let mut ticker = Ticker::every(Duration::from_micros(u64::from(TICK_US)));
    let mut data = [0; 64];
    let mut disturbed = false;
    loop {
        match select3(bus.read(&mut data), between.states.receive(), ticker.next()).await {
            Either3::First(Some((id, length))) => {
                disturbed = false;
                let at_us = now_us();
                sensors.take(between, |hub| hub.frame(id, data.get(..length)?, at_us));
            }
            Either3::First(None) => {
                if !core::mem::replace(&mut disturbed, true) {
                    between.counters.readings_damaged.add(1);
                }
                // What could not be asked meanwhile is not asked all at once; the host's link runs on the same executor.
                ticker.reset();
                yield_now().await;
            }
            Either3::Second(state) => {
                // One place that waits: a second one would take 0.3 KB of flash.
                let (whole, classic) = (state.encode(), state.encode_classic());
                let (id, frame): (_, &[u8]) = if sensors.with(|hub| hub.is_classic()).unwrap_or(true) {
                    (CLASSIC_STATE_ID, &classic)
                } else {
                    (STATE_ID, &whole)
                };
                send(between, &mut bus, id, frame).await;
            }
            Either3::Third(()) => {
                let now_us = now_us();
                let mut asked = heapless::Vec::<_, 2>::new();
                sensors.with(|hub| asked.extend(hub.requests(now_us)));
                for request in asked {
                    let row = request.row.map(|row| [row]);
                    send(between, &mut bus, request.id.as_raw(), row.as_ref().map_or(&[], |row| row)).await;
                }
            }
        }
    }
}
