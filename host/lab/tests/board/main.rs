//! Tests of built firmware: each needs a program that the Makefile builds and names in the
//! environment (`make hil`, `make size`, `make no-panic`), so `cargo test` alone ignores them.

mod code;
mod device;
mod late;
mod memory_map;
mod no_panic;
#[path = "../../../cli/tests/it/port.rs"]
mod port;
mod post_mortem;
mod stack_depth;

/// What the environment's `variable` names.
///
/// # Panics
/// Where it is not set: a test that did nothing must not pass.
fn named(variable: &str, target: &str) -> std::ffi::OsString {
    std::env::var_os(variable).unwrap_or_else(|| panic!("{variable} is not set; run `make {target}`"))
}
