//! Inputs that once broke something, and some from which `make fuzz` begins.

use std::path::{Path, PathBuf};

fn kept(target: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("kept").join(target);
    let files = std::fs::read_dir(&folder).expect("the folder of kept inputs");
    let mut all: Vec<_> = files
        .map(|entry| entry.expect("an entry").path())
        .map(|path| (path.clone(), std::fs::read(&path).expect("a kept input")))
        .collect();
    all.sort();
    assert!(!all.is_empty(), "{} is empty", folder.display());
    all
}

#[test]
fn kept_bytes_on_the_line_leave_the_reader_in_step() {
    for (path, bytes) in kept("line") {
        println!("{}", path.display());
        stickslip_fuzz::line(&bytes);
    }
}

#[test]
fn kept_models_and_samples_run_without_panic_and_the_same_twice() {
    for (path, bytes) in kept("predictor") {
        println!("{}", path.display());
        stickslip_fuzz::predictor(&bytes);
    }
}

#[test]
fn kept_files_are_read_or_refused_with_their_name() {
    for (path, bytes) in kept("files") {
        println!("{}", path.display());
        stickslip_fuzz::files::read(&bytes);
    }
}
