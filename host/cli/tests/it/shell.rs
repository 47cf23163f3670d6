//! Completions and man pages come from the command line that there is.

use std::process::Command;

use clap::CommandFactory;
use stickslip_cli::commands::Cli;

use crate::documents::{document, stickslip};

#[test]
fn bash_completes_commands_and_options() {
    let script = stickslip().args(["completions", "bash"]).output().expect("run");
    assert!(script.status.success());
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("stickslip.bash");
    std::fs::write(&file, script.stdout).expect("written");
    for (words, expected) in
        [("diag", "diagnose"), ("diagnose --ht", "--html"), ("score --object-pose st", "start")]
    {
        let words: Vec<&str> = ["stickslip"].into_iter().chain(words.split(' ')).collect();
        let (current, before) = (words[words.len() - 1], words[words.len() - 2]);
        let line = format!(
            "source '{}'; COMP_WORDS=({}); COMP_CWORD={}; _stickslip stickslip '{current}' '{before}'; echo \
             \"${{COMPREPLY[@]}}\"",
            file.display(),
            words.join(" "),
            words.len() - 1
        );
        let shell = Command::new("bash").args(["--norc", "-c", &line]).output().expect("bash");
        let replies = String::from_utf8_lossy(&shell.stdout);
        assert!(replies.split_whitespace().any(|reply| reply == expected), "{words:?}: {replies}");
    }
}

#[test]
fn every_shell_gets_a_script_and_json_is_refused() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let output = stickslip().args(["completions", shell]).output().expect("run");
        assert!(output.status.success() && output.stdout.len() > 1000, "{shell}");
    }
    stickslip().args(["--json", "completions", "bash"]).assert().failure();
}

#[test]
fn man_has_a_page_of_each_command_with_its_example() {
    fn leaves(command: &clap::Command, name: &str, found: &mut Vec<String>) {
        let below: Vec<_> = command.get_subcommands().filter(|c| c.get_name() != "help").collect();
        if below.is_empty() {
            found.push(name.to_owned());
        }
        for command in below {
            leaves(command, &format!("{name}-{}", command.get_name()), found);
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("man1");
    let output = stickslip().args(["--json", "man"]).arg(&out).output().expect("run");
    let told = document("man", &output.stdout);
    let mut commands = Vec::new();
    leaves(&Cli::command(), "stickslip", &mut commands);
    assert!(commands.iter().any(|name| name == "stickslip-board-info"), "{commands:?}");
    for name in commands {
        let file = format!("{name}.1");
        let page = std::fs::read_to_string(out.join(&file)).unwrap_or_else(|_| panic!("no page {file}"));
        assert!(page.contains("Example"), "{file}");
        // As they are typed: not filled, and no word of them hyphenated.
        let (_, after) = page.split_once("Example").expect("examples");
        assert!(after.lines().nth(1) == Some(".nf") && after.contains("\n.fi\n"), "{file}: {after}");
        assert!(page.contains(&name.replace('-', "\\-")), "{file}: its name");
        assert!(told["pages"].as_array().expect("pages").iter().any(|page| *page == *file), "{file}");
    }
}
