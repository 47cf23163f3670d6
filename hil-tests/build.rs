//! Runs the self-test of the predictor on the machine that builds, as the reference for the
//! board, and names the linker scripts.
use std::path::PathBuf;
use std::{env, fs};

use stickslip_shared::selftest;

/// Seed, ticks, horizon: without look-ahead, and with it.
const RUNS: [(u32, u32, f32); 2] = [(1, 100_000, 0.0), (2, 3_000, 0.1)];

fn main() {
    let mut text = String::from("/// Seed, ticks, horizon and what the host got.\n");
    text += "pub const REFERENCE: [(u32, u32, f32, Digest); 2] = [\n";
    for (seed, ticks, horizon) in RUNS {
        let digest = selftest::run(seed, ticks, horizon);
        text += &format!("({seed}, {ticks}, {horizon:?}, {digest:?}),\n");
    }
    text += "];\n";
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    fs::write(out.join("reference.rs"), text).expect("OUT_DIR can be written");
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-link-arg-tests=--nmagic");
    println!("cargo:rustc-link-arg-tests=-Tlink.x");
    println!("cargo:rustc-link-arg-tests=-Tdefmt.x");
    println!("cargo:rustc-link-arg-tests=-Tembedded-test.x");
}
