//! The line to the host: bytes to [`Link`], its answers and the tick's reports out.

use embassy_futures::select::{Either, select};
use embassy_time::Timer;
use embedded_io_async::{Read, Write};
use postcard_rpc::Topic;
use stickslip_shared::wire;
use stickslip_shared::wire::frame::{FrameReader, MAX_LINE, encode};
use stickslip_unit::link::Line;

use crate::board::current::{self as board, This};
use crate::queues::{ANSWERS, BETWEEN};

/// What talks to the host on this board.
pub type Link = stickslip_unit::link::Link<This>;

/// Receives for ever.
pub async fn receive<R: Read>(link: &mut Link, mut rx: R) -> ! {
    let mut reader = FrameReader::new();
    let mut bytes = [0; 64];
    loop {
        let Ok(count) = rx.read(&mut bytes).await else {
            BETWEEN.counters.frames_damaged.add(1);
            continue;
        };
        for byte in bytes.iter().take(count) {
            let mut line = Line::new();
            let restart = link.hear(&mut reader, *byte, &mut line);
            if !line.is_empty() {
                ANSWERS.send(line).await;
            }
            if restart {
                // Lets the answer out first.
                Timer::after_millis(20).await;
                board::reset();
            }
        }
    }
}

/// Sends for ever, answers before reports.
pub async fn transmit<W: Write>(mut tx: W) -> ! {
    // Ends whatever the line carried before.
    let _ = tx.write_all(&[0]).await;
    let mut line = [0; MAX_LINE];
    loop {
        match select(ANSWERS.receive(), BETWEEN.reports.receive()).await {
            Either::First(bytes) => {
                let _ = tx.write_all(&bytes).await;
            }
            Either::Second(report) => {
                let key = wire::Telemetry::TOPIC_KEY;
                if let Some(bytes) = encode(key, report.seq, &report, &mut line) {
                    let _ = tx.write_all(bytes).await;
                }
            }
        }
    }
}
