//! Runs the self-test of the predictor on the machine that builds, as the reference for the
//! board, and names the linker scripts.
use std::path::PathBuf;
use std::{env, fs};

use stickslip_selftest::{self as selftest, hostile};
use stickslip_shared::model::Formulation;

/// Formulation, seed, ticks, horizon: without look-ahead, with it, and with friction pyramids.
const RUNS: [(Formulation, u32, u32, f32); 3] = [
    (Formulation::Cone, 1, 100_000, 0.0),
    (Formulation::Cone, 2, 3_000, 0.1),
    (Formulation::Lcp, 2, 3_000, 0.1),
];

/// Seed and rounds of the hostile problems.
const HOSTILE: (u32, u32) = (3, 400);

fn main() {
    let mut text = String::from("/// Formulation, seed, ticks, horizon and what the host got.\n");
    text += "pub const REFERENCE: [(Formulation, u32, u32, f32, Digest); 3] = [\n";
    let mut lines = String::new();
    for (by, seed, ticks, horizon) in RUNS {
        let digest = selftest::run(by, seed, ticks, horizon);
        lines += &format!("predictor {by:?} {seed} {ticks} {horizon:?} {digest:?}\n");
        text += &format!("(Formulation::{by:?}, {seed}, {ticks}, {horizon:?}, {digest:?}),\n");
    }
    text += "];\n";
    let (seed, rounds) = HOSTILE;
    let answers = hostile::run(seed, rounds);
    lines += &format!("hostile {seed} {rounds} {answers:?}\n");
    text += "/// Seed and rounds of the hostile problems, and what the host got.\n";
    text += &format!("pub const HOSTILE: (u32, u32, Answers) = ({seed}, {rounds}, {answers:?});\n");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    fs::write(out.join("reference.rs"), text).expect("OUT_DIR can be written");
    // A test on the host compares its own build, with debug assertions, with this one
    // (`host/lab/tests/hil.rs`).
    let built = out.ancestors().nth(3).expect("OUT_DIR lies below the profile's folder");
    fs::write(built.join("reference.txt"), lines).expect("the target folder can be written");
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-link-arg-tests=--nmagic");
    println!("cargo:rustc-link-arg-tests=-Tlink.x");
    println!("cargo:rustc-link-arg-tests=-Tdefmt.x");
    println!("cargo:rustc-link-arg-tests=-Tembedded-test.x");
}
