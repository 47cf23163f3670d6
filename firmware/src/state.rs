//! The state of the tasks, each in a place of its own: a task that held it would have it in its
//! future, and move it there over the stack.

use static_cell::StaticCell;
use stickslip_shared::predictor::Predictor;
use stickslip_shared::wire::ResetCause;

use crate::board::current::Channels;
use crate::control::Control;
use crate::link::Link;
use crate::queues::SPARE;
use crate::slot::Slot;

/// State of the control task and of the link after a start of the processor, the slot of the next
/// model spare. To be called once.
#[inline]
pub fn init(
    gauges: Channels,
    reset_cause: ResetCause,
    boots: u32,
) -> (&'static mut Control<Channels>, &'static mut Link) {
    static SLOT: StaticCell<Slot> = StaticCell::new();
    static PREDICTOR: StaticCell<Option<Predictor<f32>>> = StaticCell::new();
    static CONTROL: StaticCell<Control<Channels>> = StaticCell::new();
    static LINK: StaticCell<Link> = StaticCell::new();
    let _ = SPARE.try_send(SLOT.init(Slot::new()));
    let control = CONTROL.init(Control::new(PREDICTOR.init(None), gauges));
    (control, LINK.init(Link::new(reset_cause, boots)))
}
