//! What tests of commands share, those of `stickslip-lab` too: a recorded push, edited; pages read as a browser
//! would.

use std::collections::{BTreeMap, BTreeSet};
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

/// What a command writes or takes differs from one to the next, and so does the name of the value.
const OWN_VALUES: [&str; 3] = ["out", "data", "hidden"];

/// A command line that clap finds consistent, in which every command shows an example, and an option is the same wherever
/// it is: its short form, and the name of its value.
pub fn is_consistent(command: clap::Command) {
    fn visit(command: &clap::Command, options: &mut BTreeMap<String, BTreeSet<String>>) {
        for arg in command.get_arguments().filter(|arg| arg.get_action().takes_values()) {
            let Some(long) = arg.get_long().filter(|long| !OWN_VALUES.contains(long)) else { continue };
            options.entry(long.to_owned()).or_default().insert(format!("{:?}", arg.get_value_names()));
        }
        for arg in command.get_arguments() {
            let Some(long) = arg.get_long() else { continue };
            options.entry(format!("{long}, short")).or_default().insert(format!("{:?}", arg.get_short()));
        }
        let below = || command.get_subcommands().filter(|sub| sub.get_name() != "help");
        below().for_each(|sub| visit(sub, options));
        if below().count() == 0 {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            assert!(help.contains("Example"), "no example: {}", command.get_name());
        }
    }
    command.clone().debug_assert();
    let mut options = BTreeMap::new();
    visit(&command, &mut options);
    options.retain(|_, forms| forms.len() > 1);
    assert!(options.is_empty(), "one option in several forms: {options:#?}");
}
