//! What a unit at the gripper needs beside the prediction.
//!
//! [`source`] decodes what sensors send, [`fingers`] makes the tick's sample of it, [`alarm`] and
//! [`grip`] tell a gripper's controller what to do, [`bus`] carries both over CAN-FD, [`memory`] keeps what was
//! set over a loss of power, [`post_mortem`] what went before a reset. [`control`] is the tick, [`lines`] are the tasks at sensors and bus, [`link`] what answers the host;
//! between them are queues of fixed size ([`between`]) whose losses are counted ([`counters`]). Everything is above the register level: bytes, frames,
//! pins and flash come through the traits of embedded-can, embedded-hal and embedded-storage, so
//! that the same code runs in tests on the host. No allocation, no panic on any input.
#![no_std]
#![forbid(unsafe_code)]

pub mod alarm;
pub mod between;
pub mod board;
pub mod bus;
pub mod control;
pub mod counters;
pub mod deadline;
pub mod fingers;
pub mod grip;
pub mod host_clock;
pub mod lines;
pub mod link;
pub mod link_source;
pub mod memory;
pub mod post_mortem;
pub mod queue;
pub mod slot;
pub mod source;
pub mod stored;
pub mod upload;
