//! The files of every crate import each other in one direction: no import cycle, between files and
//! so between folders. Read from the sources: `use` declarations and paths that begin with `crate`,
//! `super`, `self` or a declared child.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

type Module = Vec<String>;
type Graph = BTreeMap<Module, BTreeSet<Module>>;

fn sources(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a source folder").map(|e| e.expect("an entry").path()) {
        match entry.is_dir() {
            true => sources(&entry, out),
            false if entry.extension().is_some_and(|e| e == "rs") => out.push(entry),
            false => {}
        }
    }
}

fn module(folder: &Path, file: &Path) -> Module {
    let inside = file.strip_prefix(folder).expect("inside").with_extension("");
    let mut parts: Module = inside.iter().map(|p| p.to_string_lossy().into_owned()).collect();
    if parts.last().is_some_and(|p| matches!(p.as_str(), "mod" | "lib" | "main")) {
        parts.pop();
    }
    parts
}

/// The text without comments and without tests at its end.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
    text.lines().map(|l| l.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// `a::{b, c::{d}}` as `a::b`, `a::c::d`.
fn expand(tree: &str) -> Vec<String> {
    let tree = tree.trim();
    let Some((before, inner)) = tree.split_once('{') else {
        return vec![tree.split(" as ").next().unwrap_or_default().trim().to_owned()];
    };
    let inner = inner.strip_suffix('}').unwrap_or(inner);
    let (mut parts, mut depth) = (vec![String::new()], 0);
    for c in inner.chars() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        match c {
            ',' if depth == 0 => parts.push(String::new()),
            c => parts.last_mut().expect("one").push(c),
        }
    }
    let each = parts.iter().filter(|p| !p.trim().is_empty()).flat_map(|p| expand(p));
    each.map(|p| if p == "self" { before.trim_end_matches(':').to_owned() } else { format!("{before}{p}") })
        .collect()
}

/// Words joined by `::` in `code`.
fn paths(code: &str) -> Vec<String> {
    let part = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    code.split(|c| !part(c)).filter(|w| w.contains("::")).map(str::to_owned).collect()
}

fn imports(of: &Module, text: &str, all: &BTreeSet<Module>) -> BTreeSet<Module> {
    let code = code(text);
    let mut found = Vec::new();
    let mut rest = String::new();
    for statement in code.split_inclusive(';') {
        let at = statement.rfind("use ").filter(|at| {
            let before = statement[..*at].trim_end();
            before.is_empty() || before.ends_with(['}', '{', ';', ']', ')']) || before.ends_with("pub")
        });
        match at {
            // A re-export only gives another name.
            Some(at) if statement[..at].trim_end().ends_with("pub") => {}
            Some(at) => found.extend(expand(statement[at + 4..].trim_end_matches(';'))),
            None => rest.push_str(statement),
        }
    }
    found.extend(paths(&rest));
    let mut out = BTreeSet::new();
    for path in found {
        let mut parts: Vec<&str> = path.split("::").map(str::trim).collect();
        let mut here: Module = match parts[0] {
            "crate" => Vec::new(),
            "super" => {
                let ups = parts.iter().take_while(|p| **p == "super").count();
                parts.drain(..ups - 1);
                of[..of.len().saturating_sub(ups)].to_vec()
            }
            "self" => of.clone(),
            child => {
                let inside = [of.as_slice(), &[child.to_owned()]].concat();
                if !all.contains(&inside) {
                    continue;
                }
                parts.insert(0, "self");
                of.clone()
            }
        };
        for part in &parts[1..] {
            let inside = [here.as_slice(), &[(*part).to_owned()]].concat();
            if !all.contains(&inside) {
                break;
            }
            here = inside;
        }
        if here != *of {
            out.insert(here);
        }
    }
    out
}

fn graph(folder: &Path) -> Graph {
    let mut files = Vec::new();
    sources(folder, &mut files);
    let all: BTreeSet<Module> = files.iter().map(|f| module(folder, f)).collect();
    files
        .iter()
        .map(|file| {
            let of = module(folder, file);
            let text = fs::read_to_string(file).expect("a source");
            let to = imports(&of, &text, &all);
            (of, to)
        })
        .collect()
}

/// All that can be reached from `from`.
fn reached(graph: &Graph, from: &Module) -> BTreeSet<Module> {
    let mut seen = BTreeSet::new();
    let mut open: Vec<&Module> = graph[from].iter().collect();
    while let Some(next) = open.pop() {
        if seen.insert(next.clone()) {
            open.extend(graph.get(next).into_iter().flatten());
        }
    }
    seen
}

/// Groups of files each of which imports all others of its group, directly or not.
fn cycles(graph: &Graph) -> BTreeSet<Vec<String>> {
    let reach: BTreeMap<&Module, BTreeSet<Module>> = graph.keys().map(|m| (m, reached(graph, m))).collect();
    let name = |m: &Module| if m.is_empty() { "lib".to_owned() } else { m.join("::") };
    graph
        .keys()
        .filter(|m| reach[m].contains(*m))
        .map(|m| graph.keys().filter(|o| reach[m].contains(*o) && reach[o].contains(m)).map(name).collect())
        .collect()
}

#[test]
fn no_crate_has_an_import_cycle_between_its_files() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let workspace: toml::Table =
        fs::read_to_string(root.join("Cargo.toml")).expect("the workspace").parse().expect("TOML");
    let members = workspace["workspace"]["members"].as_array().expect("members");
    let mut crates: Vec<(String, PathBuf)> = members
        .iter()
        .filter_map(|m| m.as_str())
        .map(|name| (name.to_owned(), root.join(name).join("src")))
        .collect();
    assert!(crates.len() >= 18, "{crates:?}");
    // A program of several files is a crate of its own.
    for (name, folder) in crates.clone() {
        let programs = fs::read_dir(folder.join("bin")).into_iter().flatten().flatten().map(|e| e.path());
        crates.extend(programs.filter(|p| p.is_dir()).map(|p| (format!("{name}: {}", p.display()), p)));
    }
    let mut found = BTreeSet::new();
    for (name, folder) in &crates {
        found.extend(cycles(&graph(folder)).into_iter().map(|c| (name.clone(), c)));
    }
    assert!(found.is_empty(), "import cycles between files: {found:#?}");
}

/// Folders of analysis from the ground up; those at one height may import each other as long as no
/// cycle of files comes of it.
const HEIGHTS: [(&str, u32); 14] = [
    ("channels", 0),
    ("model", 1),
    ("run", 1),
    ("tuning", 1),
    ("evidence", 2),
    ("left_out", 2),
    ("fit", 3),
    ("add", 4),
    ("calibrate", 4),
    ("check", 4),
    ("compare", 4),
    ("diagnose", 4),
    ("score", 4),
    ("lib", 5),
];

#[test]
fn analysis_is_built_from_channels_over_evidence_and_fit_to_what_users_call() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let room = |m: &Module| m.first().map_or("lib", String::as_str).to_owned();
    let height = |room: &str| HEIGHTS.iter().find(|h| h.0 == room).map_or(4, |h| h.1);
    for (from, to) in graph(&folder) {
        for to in to.iter().map(room).filter(|to| *to != room(&from)) {
            assert!(height(&to) <= height(&room(&from)), "{} must not import {to}", from.join("::"));
        }
    }
}

#[test]
fn a_cycle_is_found_whatever_the_form_of_the_import() {
    let all: BTreeSet<Module> =
        [vec![], vec!["a".to_owned()], vec!["b".to_owned()], vec!["b".to_owned(), "c".to_owned()]].into();
    let of = |m: &[&str], text: &str| {
        let m: Module = m.iter().map(|p| (*p).to_owned()).collect();
        imports(&m, text, &all).iter().map(|m| m.join("::")).collect::<Vec<_>>()
    };
    assert_eq!(of(&["a"], "use crate::b::{self, c::X};"), ["b", "b::c"]);
    assert_eq!(of(&["b", "c"], "fn f() { super::g() }"), ["b"]);
    assert_eq!(of(&["b"], "mod c;\nfn f() { c::g() }"), ["b::c"]);
    assert_eq!(of(&["b"], "// use crate::a::X;\npub use c::X;"), [""; 0]);
}
