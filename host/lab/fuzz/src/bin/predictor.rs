//! Models and samples.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| stickslip_fuzz::predictor(bytes));
