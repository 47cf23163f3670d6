//! What tests of commands share, those of `stickslip-lab` too: a recorded push, edited; pages read as a browser
//! would.

use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// A copy of one recorded push of the demonstration with its description, edited. The folder lives as
/// long as the first.
pub fn push(edit: impl Fn(String) -> String) -> (TempDir, PathBuf) {
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo");
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("push");
    fs::create_dir_all(data.join("trials")).expect("a folder");
    let read = |name: &str| fs::read_to_string(demo.join(name)).expect("the demo data");
    fs::write(data.join("dataset.toml"), edit(read("dataset.toml"))).expect("written");
    let trials: Vec<String> = read("trials.csv").lines().take(2).map(str::to_owned).collect();
    fs::write(data.join("trials.csv"), trials.join("\n") + "\n").expect("written");
    let name = "trials/linear_push-obj4-g20-v10-s0-r1.csv";
    fs::copy(demo.join(name), data.join(name)).expect("copied");
    (folder, data)
}

/// A command line that clap finds consistent and in which every command shows an example.
pub fn is_consistent(command: clap::Command) {
    fn visit(command: &clap::Command) {
        let below = || command.get_subcommands().filter(|sub| sub.get_name() != "help");
        below().for_each(visit);
        if below().count() == 0 {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            assert!(help.contains("Example"), "no example: {}", command.get_name());
        }
    }
    command.clone().debug_assert();
    visit(&command);
}
