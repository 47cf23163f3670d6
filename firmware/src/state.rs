//! The state of the tasks, each in a place of its own: a task that held it would have it in its
//! future, and move it there over the stack.

use static_cell::StaticCell;
use stickslip_shared::predictor::Predictor;
use stickslip_shared::wire::{PostMortem, ResetCause};

use stickslip_unit::control::Control;
use stickslip_unit::post_mortem::Recorder;
use stickslip_unit::slot::Slot;

use crate::board::current::{AlarmLines, Channels, Flash, This};
use crate::link::Link;
use crate::queues::{BETWEEN, SENSORS};

/// What the processor's start tells.
pub struct Started {
    /// Why.
    pub cause: ResetCause,
    /// Starts since power-on.
    pub boots: u32,
    /// What went before.
    pub post_mortem: Option<PostMortem>,
    /// The next record.
    pub recorder: Recorder<'static>,
}

/// State of the control task and of the link after a start of the processor, with what was stored taken over.
/// To be called once.
#[inline]
pub fn init(
    gauges: Channels,
    lines: AlarmLines,
    flash: Option<Flash>,
    started: Started,
) -> (&'static mut Control<This>, &'static mut Link) {
    static SLOT: StaticCell<Slot> = StaticCell::new();
    static PREDICTOR: StaticCell<Option<Predictor<f32>>> = StaticCell::new();
    static CONTROL: StaticCell<Control<This>> = StaticCell::new();
    static LINK: StaticCell<Link> = StaticCell::new();
    let Started { cause, boots, post_mortem, recorder } = started;
    let slot = SLOT.init(Slot::new());
    let control = CONTROL.init(Control::new(&BETWEEN, PREDICTOR.init(None), gauges, lines, recorder));
    let link = LINK.init(Link::new((&BETWEEN, &SENSORS), (cause, boots, post_mortem), flash));
    let recalled = link.recall(slot);
    control.recall(link.settings(), slot, recalled);
    (control, link)
}
