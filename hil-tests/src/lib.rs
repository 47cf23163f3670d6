//! Results that the board must reproduce, computed by the build script on the host with
//! the same source.
#![no_std]

use stickslip_selftest::Digest;
use stickslip_selftest::hostile::Answers;
use stickslip_shared::model::Formulation;

include!(concat!(env!("OUT_DIR"), "/reference.rs"));
