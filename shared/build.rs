//! Fingerprint of this crate's sources (FNV-1a over paths and bytes): two sides built from the
//! same sources know it of each other.
use std::path::{Path, PathBuf};
use std::{env, fs};

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            sources(&path, found);
        } else {
            found.push(path);
        }
    }
}

fn main() {
    println!("cargo:rerun-if-changed=src");
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let mut found = Vec::new();
    sources(&root.join("src"), &mut found);
    found.sort();
    let mut hash = 0x811c_9dc5_u32;
    for path in &found {
        let name = path.strip_prefix(&root).unwrap_or(path).to_string_lossy().replace('\\', "/");
        let bytes = fs::read(path).unwrap_or_default();
        for byte in name.bytes().chain(bytes) {
            hash = (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193);
        }
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it")).join("source.rs");
    let text = format!("/// Fingerprint of the sources of this crate.\npub const SOURCE: u32 = {hash};\n");
    fs::write(out, text).expect("OUT_DIR can be written");
}
