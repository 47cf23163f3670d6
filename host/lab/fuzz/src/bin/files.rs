//! Files.
#![no_main]

use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::sync::Once;

/// libFuzzer's hook takes every panic for a finding, also one that the reader catches where the
/// Parquet library panics on a damaged file: only what leaves the reader is one.
static HOOK: Once = Once::new();

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    HOOK.call_once(|| set_hook(Box::new(|_| ())));
    if let Err(panic) = catch_unwind(AssertUnwindSafe(|| stickslip_fuzz::files::read(bytes))) {
        let text = panic.downcast_ref::<String>().cloned();
        let text = text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
        eprintln!("panic: {}", text.unwrap_or_default());
        std::process::abort();
    }
});
