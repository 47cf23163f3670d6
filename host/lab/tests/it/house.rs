//! How the house is built: which crate may know which, and how long a file may be.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Crates and what each may depend on among ours, in order: a crate only knows those above it.
const ALLOWED: [(&str, &[&str]); 19] = [
    ("shared/sqrt", &[]),
    ("shared", &["sqrt"]),
    // What boards and hosts must agree on; for tests alone.
    ("shared/selftest", &["shared"]),
    ("firmware/unit", &["shared"]),
    ("host/data", &[]),
    ("host/rig", &["data"]),
    ("host/lcp", &["shared"]),
    // Seen while the rest is built: nothing but what the board runs.
    ("host/first", &["shared"]),
    // The unit: what of a host's sample is young enough for it.
    ("host/device", &["shared", "unit"]),
    ("host/analysis", &["shared", "data"]),
    // The unit: its frames on the bus. The analyses: names of flags and doubts.
    ("host/live", &["shared", "unit", "device", "analysis"]),
    ("host/report", &["shared", "data", "analysis"]),
    // The unit: the grip that it advises closes the loop in `stickslip demo`.
    ("host/cli", &["shared", "unit", "data", "rig", "lcp", "device", "analysis", "live", "report"]),
    // The analyses for Python; its wheel brings the command too.
    ("host/python", &["shared", "data", "analysis", "report", "cli"]),
    // The command line: the study of that loop runs the same one.
    ("host/lab", &["shared", "data", "rig", "lcp", "device", "analysis", "report", "cli"]),
    ("host/lab/second-rig", &[]),
    ("host/lab/fuzz", &["shared", "selftest", "data", "analysis", "device"]),
    ("firmware", &["shared", "selftest", "unit"]),
    ("hil-tests", &["shared", "selftest", "unit", "firmware"]),
];

/// Lines beyond which a file gives the reason at its head.
const LONG: usize = 600;
/// How such a file gives it.
const REASON: &str = "Above 600 lines:";

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Our crates among the dependencies of a manifest, dev-dependencies apart.
fn dependencies(manifest: &str) -> BTreeSet<String> {
    let table: toml::Table = manifest.parse().expect("a manifest");
    let names = table.get("dependencies").and_then(|d| d.as_table()).into_iter().flatten();
    names.filter_map(|(name, _)| name.strip_prefix("stickslip-").map(str::to_owned)).collect()
}

#[test]
fn every_crate_depends_only_on_crates_above_it() {
    let workspace: toml::Table = std::fs::read_to_string(repository().join("Cargo.toml"))
        .expect("the workspace")
        .parse()
        .expect("TOML");
    let members: BTreeSet<&str> = workspace["workspace"]["members"]
        .as_array()
        .expect("members")
        .iter()
        .filter_map(|m| m.as_str())
        .collect();
    let listed: BTreeMap<&str, &[&str]> = ALLOWED.into_iter().collect();
    assert_eq!(members, listed.keys().copied().collect(), "members of the workspace and the list here");
    let mut above: Vec<&str> = Vec::new();
    for (path, allowed) in ALLOWED {
        assert!(allowed.iter().all(|a| above.contains(a)), "{path}: its list names a crate below it");
        above.push(path.rsplit('/').next().unwrap_or(path));
        let manifest =
            std::fs::read_to_string(repository().join(path).join("Cargo.toml")).expect("a manifest");
        for name in dependencies(&manifest) {
            assert!(
                allowed.contains(&name.as_str()),
                "{path} depends on stickslip-{name}, which is not allowed"
            );
        }
    }
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
        let path = entry.path();
        if path.is_dir() {
            if path.file_name().is_none_or(|n| n != "target") {
                sources(&path, found);
            }
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// Targets that `cargo test` does not build as a test save minutes; a test inside would not run.
#[test]
fn no_unit_test_is_in_a_target_that_is_not_built_as_a_test() {
    for (path, _) in ALLOWED {
        let folder = repository().join(path);
        let manifest: toml::Table =
            std::fs::read_to_string(folder.join("Cargo.toml")).expect("a manifest").parse().expect("TOML");
        let untested =
            |target: &toml::Value| target.get("test").and_then(toml::Value::as_bool) == Some(false);
        let bins = manifest.get("bin").and_then(toml::Value::as_array).into_iter().flatten();
        let bins: Vec<PathBuf> = bins
            .filter(|bin| untested(bin))
            .filter_map(|bin| Some(folder.join(bin.get("path")?.as_str()?)))
            .collect();
        let mut files = Vec::new();
        sources(&folder.join("src"), &mut files);
        let in_lib = |file: &PathBuf| {
            let rest = file.strip_prefix(folder.join("src")).unwrap_or(file);
            rest != Path::new("main.rs") && !rest.starts_with("bin")
        };
        let lib = manifest.get("lib").is_some_and(untested);
        for file in files.iter().filter(|file| (lib && in_lib(file)) || bins.contains(file)) {
            let text = std::fs::read_to_string(file).expect("a source");
            assert!(!text.contains("#[test]"), "{} has a test that never runs", file.display());
        }
    }
}

/// A test that no target runs guards nothing.
#[test]
fn every_ignored_test_names_a_target_that_runs_it() {
    let makefile = std::fs::read_to_string(repository().join("Makefile")).expect("the Makefile");
    let mut files = Vec::new();
    for (path, _) in ALLOWED {
        sources(&repository().join(path), &mut files);
    }
    let mut ignored = 0;
    for path in files {
        let text = std::fs::read_to_string(&path).expect("a source");
        for line in text.lines().map(str::trim).filter(|line| line.starts_with("#[ignore")) {
            let target = line.split_once("make ").and_then(|(_, rest)| rest.split('"').next());
            let there = target.is_some_and(|target| makefile.contains(&format!("\n{target}:")));
            assert!(there, "{}: {line}", path.display());
            ignored += 1;
        }
    }
    assert!(ignored > 20, "{ignored}");
}

#[test]
fn a_file_above_600_lines_says_why_at_its_head() {
    let mut files = Vec::new();
    for (path, _) in ALLOWED {
        sources(&repository().join(path), &mut files);
    }
    let silent: BTreeSet<String> = files
        .iter()
        .filter_map(|path| {
            let text = std::fs::read_to_string(path).ok()?;
            let head: String = text.lines().take_while(|l| l.starts_with("//!")).collect();
            let lines = text.lines().count();
            (lines > LONG && !head.contains(REASON)).then(|| format!("{} ({lines} lines)", path.display()))
        })
        .collect();
    assert!(silent.is_empty(), "say why, after `{REASON}`, in the module's head: {silent:?}");
}
