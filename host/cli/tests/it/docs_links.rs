//! Links of README.md, CHANGELOG.md and of the pages in docs/ lead to files that exist, in the repository and in the book.

use std::fs;
use std::path::{Path, PathBuf};

/// Top of the repository: the nearest folder above this crate that holds README.md and docs/.
fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .ancestors()
        .find(|folder| folder.join("README.md").is_file() && folder.join("docs").is_dir())
        .expect("a folder with README.md and docs/ above this crate")
        .to_owned()
}

/// Markdown files of `folder` and its subfolders.
fn pages(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("docs/ can be listed") {
        let path = entry.expect("an entry of docs/").path();
        if path.is_dir() {
            pages(&path, found);
        } else if path.extension().is_some_and(|e| e == "md") {
            found.push(path);
        }
    }
}

/// Targets of `[text](target)` with their line, code blocks left out.
fn links(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let mut code = false;
    for (line, words) in text.lines().enumerate() {
        if words.trim_start().starts_with("```") {
            code = !code;
        }
        if code {
            continue;
        }
        for (at, _) in words.match_indices("](") {
            let rest = &words[at + 2..];
            if let Some(end) = rest.find(')') {
                found.push((line + 1, rest[..end].to_owned()));
            }
        }
    }
    found
}

/// Names by which the headings of a page are linked, on GitHub and in the book.
fn anchors(text: &str) -> Vec<String> {
    let name = |heading: &str| {
        let kept = heading.trim().to_lowercase().replace(' ', "-");
        kept.chars().filter(|c| c.is_alphanumeric() || "-_".contains(*c)).collect()
    };
    let headings = text.lines().filter(|line| line.starts_with('#'));
    headings.map(|line| name(line.trim_start_matches('#'))).collect()
}

#[test]
fn every_relative_link_of_readme_changelog_and_docs_leads_to_a_file_and_to_a_heading_in_it() {
    let top = top();
    let mut files = vec![top.join("README.md"), top.join("CHANGELOG.md")];
    pages(&top.join("docs"), &mut files);
    let (mut seen, mut broken) = (0, Vec::new());
    for file in &files {
        let text = fs::read_to_string(file).expect("a page can be read");
        for (line, target) in links(&text) {
            let (path, anchor) = target.split_once('#').unwrap_or((&target, ""));
            if target.contains("://") {
                continue;
            }
            seen += 1;
            let to = match path {
                "" => file.clone(),
                path => file.parent().expect("a folder").join(path),
            };
            let known = || anchors(&fs::read_to_string(&to).unwrap_or_default()).iter().any(|a| a == anchor);
            if !to.exists() || !anchor.is_empty() && !known() {
                broken.push(format!("{}:{line}: {target}", file.display()));
            }
        }
    }
    assert!(seen > 50, "only {seen} links were found in {} pages", files.len());
    assert!(broken.is_empty(), "links to files that are not there:\n{}", broken.join("\n"));
}

#[test]
fn every_page_of_docs_is_in_a_table_of_contents() {
    let top = top();
    for (contents, folder) in [("docs/README.md", "docs"), ("docs/lab/README.md", "docs/lab")] {
        let text = fs::read_to_string(top.join(contents)).expect("a table of contents");
        for entry in fs::read_dir(top.join(folder)).expect("a folder of pages") {
            let name = entry.expect("an entry").file_name().to_string_lossy().into_owned();
            if name.ends_with(".md") && !["README.md", "SUMMARY.md"].contains(&name.as_str()) {
                assert!(text.contains(&format!("({name})")), "{contents} does not list {folder}/{name}");
            }
        }
    }
}

/// mdBook makes a page of each file that SUMMARY.md names, and of no other; links to pages become links to these.
#[test]
fn the_book_has_every_page_of_docs_and_no_link_to_a_page_outside() {
    let docs = top().join("docs");
    let summary = fs::read_to_string(docs.join("SUMMARY.md")).expect("docs/SUMMARY.md");
    let chapters: Vec<PathBuf> = links(&summary).into_iter().map(|(_, target)| docs.join(target)).collect();
    let mut files = Vec::new();
    pages(&docs, &mut files);
    files.retain(|file| !file.ends_with("SUMMARY.md"));
    let missing: Vec<&PathBuf> = files.iter().filter(|file| !chapters.contains(file)).collect();
    assert!(missing.is_empty(), "docs/SUMMARY.md does not name {missing:?}");
    let stray: Vec<&PathBuf> = chapters.iter().filter(|chapter| !files.contains(chapter)).collect();
    assert!(stray.is_empty(), "docs/SUMMARY.md names {stray:?}, which are not there");
    let book = docs.canonicalize().expect("docs/");
    let redirects = fs::read_to_string(top().join("book.toml")).expect("book.toml");
    let mut outside = Vec::new();
    for file in &files {
        for (line, target) in links(&fs::read_to_string(file).expect("a page")) {
            let path = target.split('#').next().unwrap_or_default();
            let there =
                file.parent().map(|folder| folder.join(path)).and_then(|path| path.canonicalize().ok());
            let page = there.as_ref().and_then(|there| there.strip_prefix(&book).ok());
            // mdBook makes index.html of README.md, and leaves links to README.md as they are.
            let made = page.is_some_and(|page| {
                let html = page.with_extension("html");
                !page.ends_with("README.md") || redirects.contains(&format!("\"/{}\" = ", html.display()))
            });
            if path.ends_with(".md") && !made {
                outside.push(format!("{}:{line}: {target}", file.display()));
            }
        }
    }
    assert!(outside.is_empty(), "mdBook makes pages of these links, which the book has not: {outside:?}");
}
