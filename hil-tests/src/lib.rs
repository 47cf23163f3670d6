//! Results that the board must reproduce, computed by the build script on the host with
//! the same source.
#![no_std]

use stickslip_shared::model::Formulation;
use stickslip_shared::selftest::Digest;
use stickslip_shared::selftest::hostile::Answers;

include!(concat!(env!("OUT_DIR"), "/reference.rs"));
