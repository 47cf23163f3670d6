//! The command line as a whole.

use clap::CommandFactory;
use stickslip_cli::commands::Cli;

#[test]
fn the_command_line_is_consistent_and_every_command_shows_an_example() {
    crate::common::is_consistent(Cli::command());
}

#[test]
#[ignore = "long: make test-host-rest"]
fn every_example_of_help_that_needs_no_more_than_the_demo_runs() {
    fn examples(command: &clap::Command, found: &mut Vec<String>) {
        let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
        found.extend(help.lines().filter_map(|line| line.strip_prefix("  stickslip ")).map(str::to_owned));
        command.get_subcommands().for_each(|below| examples(below, found));
    }
    let mut lines = Vec::new();
    examples(&Cli::command(), &mut lines);
    let folder = tempfile::tempdir().expect("a folder");
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data");
    std::os::unix::fs::symlink(data, folder.path().join("data")).expect("a link");
    // These need nothing else; files of other options are those of earlier steps.
    let alone = ["check", "compare", "diagnose", "effects", "replay", "schema", "suggest"];
    let others = ["--model", "--against", "--formula", "--predictor"];
    let mut ran = Vec::new();
    for line in lines {
        let words: Vec<&str> = line.split_whitespace().collect();
        if !alone.contains(&words[0]) || words.iter().any(|word| others.contains(word)) {
            continue;
        }
        let output =
            crate::documents::stickslip().current_dir(folder.path()).args(&words).output().expect("run");
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        ran.push(words[0].to_owned());
    }
    for command in alone {
        assert!(ran.iter().any(|name| name == command), "no example of {command} was run: {ran:?}");
    }
}
