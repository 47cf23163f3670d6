//! Bringing a unit up, the same for the product's firmware and for the soak: only what is at the other ends of the lines
//! differs.

use embassy_executor::SendSpawner;
use stickslip_unit::control::Control;

use crate::board::current as board;
use crate::link::{self, Link};
use crate::state::{self, Started};
use crate::{post_mortem, stack};

/// Ends of lines, for the tasks below the tick.
pub struct Ends {
    /// What talks to the host.
    pub link: &'static mut Link,
    /// Line to the host, receiving.
    pub rx: board::Rx,
    /// Line to the host, sending.
    pub tx: board::Tx,
    /// Line of a sensor.
    #[cfg(feature = "nucleo-g474re")]
    pub sensor: (board::SensorRx, board::SensorTx),
    /// Bus of sensors and of the unit's state.
    #[cfg(feature = "nucleo-g474re")]
    pub can: board::CanBus,
}

#[embassy_executor::task]
async fn control(control: &'static mut Control<board::This>, watchdog: board::Watchdog) -> ! {
    crate::control::run(control, watchdog).await
}

#[embassy_executor::task]
async fn receive(link: &'static mut Link, rx: board::Rx) -> ! {
    link::receive(link, rx).await
}

#[embassy_executor::task]
async fn transmit(tx: board::Tx) -> ! {
    link::transmit(tx).await
}

/// Begins the tasks of the board's own line to the host, once.
pub fn host_line(link: &'static mut Link, rx: board::Rx, tx: board::Tx, lower: SendSpawner) {
    // Each task is spawned once, so its one place is free.
    if let Ok(token) = receive(link, rx) {
        lower.spawn(token);
    }
    if let Ok(token) = transmit(tx) {
        lower.spawn(token);
    }
}

/// Brings everything up and runs it for ever: guard of the stack, what a reset left, the board, what is stored; then the
/// tasks that `spawn` begins, and the tick.
pub fn run(spawn: impl FnOnce(Ends, SendSpawner)) -> ! {
    begin(spawn);
    loop {
        board::idle();
    }
}

/// Begins the tasks. Its frame stands under them until all have begun.
#[inline(never)]
fn begin(spawn: impl FnOnce(Ends, SendSpawner)) {
    let (app, ends) = prepare();
    let (upper, lower) = (board::control_executor(), board::communication_executor());
    spawn(ends, lower);
    // Spawned once, so its one place is free.
    if let Ok(token) = control(app, board::Watchdog::start()) {
        upper.spawn(token);
    }
}

/// Board and state.
// A function of its own: its stack is free again before the first task begins.
#[inline(never)]
fn prepare() -> (&'static mut Control<board::This>, Ends) {
    stack::guard();
    let (recorder, post_mortem, boots) = post_mortem::begin();
    let board = board::init(post_mortem.is_some());
    defmt::info!("stickslip on {=str}, start {=u32}", board::NAME, boots);
    let started = Started { cause: board.reset_cause, boots, post_mortem, recorder };
    let (app, link) = state::init(board.gauges, board.alarms, board.flash, started);
    let ends = Ends {
        link,
        rx: board.rx,
        tx: board.tx,
        #[cfg(feature = "nucleo-g474re")]
        sensor: board.sensor,
        #[cfg(feature = "nucleo-g474re")]
        can: board.can,
    };
    (app, ends)
}
