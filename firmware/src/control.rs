//! Ticks every 4 ms: waits for the clock only, and it alone feeds the watchdog.

use embassy_time::{Instant, Timer};
use stickslip_shared::wire::TICK_US;
use stickslip_unit::board::Board;
use stickslip_unit::control::Control;
use stickslip_unit::deadline::Deadline;

use crate::board::current::{This, Watchdog, timer};
use crate::queues::BETWEEN;

/// Ticks for ever.
pub async fn run(control: &mut Control<This>, mut watchdog: Watchdog) -> ! {
    let mut deadline = Deadline::from(This::now_us(), TICK_US);
    loop {
        Timer::at(Instant::from_micros(deadline.next_us())).await;
        let (began, now_us) = (timer(), This::now_us());
        if deadline.missed(now_us) {
            BETWEEN.counters.ticks_missed.add(1);
            defmt::warn!("a tick began a period late");
        }
        control.tick(began, now_us as u32);
        watchdog.feed();
    }
}
