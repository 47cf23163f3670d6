//! Linker scripts: the memory map of the board and defmt's log sections.
use std::path::PathBuf;
use std::{env, fs};

/// Features and their maps in `memory/`.
const BOARDS: [(&str, &str); 2] =
    [("CARGO_FEATURE_MPS2_AN386", "mps2-an386.x"), ("CARGO_FEATURE_NUCLEO_G474RE", "nucleo-g474re.x")];

fn main() {
    let here = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it")).join("memory");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    for (feature, map) in BOARDS {
        if env::var_os(feature).is_some() {
            // The workspace's memory.x includes them by this name.
            let parts = [map, "fast.x"].map(|part| {
                println!("cargo:rerun-if-changed={}", here.join(part).display());
                fs::read_to_string(here.join(part)).expect("the board has a memory map")
            });
            fs::write(out.join("board-memory.x"), parts.concat()).expect("OUT_DIR can be written");
            println!("cargo:rustc-link-search={}", out.display());
        }
    }
    println!("cargo:rustc-link-arg-bins=--nmagic");
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
}
