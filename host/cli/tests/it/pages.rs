//! Every command that writes a page: the page is whole, and needs nothing from elsewhere.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use clap::CommandFactory;
use stickslip_cli::commands::Cli;
use stickslip_report::words::first_sentence;

use crate::common::push;
use crate::diagnose_command::{weak_grip, weak_grip_diagnosed};
use crate::documents::stickslip;

/// Commands with a page, those below others too.
fn with_a_page(command: &clap::Command, above: &str, found: &mut Vec<String>) {
    for sub in command.get_subcommands() {
        let name = format!("{above} {}", sub.get_name()).trim().to_owned();
        if sub.get_arguments().any(|a| a.get_id() == "html") {
            found.push(name.clone());
        }
        with_a_page(sub, &name, found);
    }
}

fn demo() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo")
}

#[test]
fn every_command_with_a_page_writes_one_that_is_whole_and_needs_no_network() {
    let (folder, data) = push(|text| text);
    let at = |name: &str| folder.path().join(name);
    let index = stickslip_data::Index::open(&data).expect("a data set");
    let recording = data.join(&index.trials[0].file);
    let mut commands = Vec::new();
    with_a_page(&Cli::command(), "", &mut commands);
    for name in &commands {
        let path = at(&format!("{name}.html"));
        let mut run = stickslip();
        run.args(name.split(' '));
        match name.as_str() {
            // Of a recording, not of a data set.
            "new" => run.arg(&recording).arg("--out").arg(at("mapping.toml")),
            "import recording" => {
                let mapping = at("corrected.toml");
                stickslip().arg("new").arg(&recording).arg("--out").arg(&mapping).assert().success();
                let text = std::fs::read_to_string(&mapping).expect("written");
                let place = "[fixed.pusher]\nposition_m = [";
                let text = text.replace(&format!("{place}0.0,"), &format!("{place}-0.0503,"));
                std::fs::write(&mapping, text).expect("written");
                run.arg(&mapping).arg("--out").arg(at("imported"))
            }
            _ => run.arg(&data),
        };
        run.arg("--html").arg(&path).assert().success();
        let page = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{name}: {e}"));
        check(name, &page);
    }
    let known = ["check", "compare", "diagnose", "import recording", "new", "replay", "score"];
    commands.sort_unstable();
    assert_eq!(commands, known);
}

/// What stands between `from` and `to`, as a browser shows it.
fn shown(page: &str, from: &str, to: &str) -> String {
    let found = page.split_once(from).and_then(|(_, rest)| rest.split_once(to));
    let text = found.unwrap_or_else(|| panic!("no {from}")).0;
    let text = text.split_once('>').map_or(text, |(_, text)| text);
    text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&")
}

/// Lines that are not empty, the two of the next command among them: `check` of the demonstration has two on each of its
/// three primitives.
const LINES: usize = 14;

/// What a command wrote of some data.
struct Written {
    text: String,
    page: String,
    figures: PathBuf,
    _folder: Option<tempfile::TempDir>,
}

fn written(name: &str, data: &Path) -> Written {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, figures) = (folder.path().join("page.html"), folder.path().join("figures"));
    let mut run = stickslip();
    run.arg(name).arg(data).arg("--html").arg(&path);
    // `check` has none.
    if name != "check" {
        run.arg("--figures").arg(&figures);
    }
    let output = run.output().expect("run");
    let text = String::from_utf8(output.stdout).expect("text");
    assert!(output.status.success(), "{name}: {text}");
    Written { text, page: std::fs::read_to_string(&path).expect("the page"), figures, _folder: Some(folder) }
}

/// Each command of one push; a diagnosis that names an effect.
fn all_written() -> &'static [(&'static str, Written)] {
    static ALL: OnceLock<Vec<(&str, Written)>> = OnceLock::new();
    ALL.get_or_init(|| {
        let (_folder, one) = push(|text| text);
        let mut all: Vec<_> = ["check", "replay", "score", "compare", "diagnose"]
            .into_iter()
            .map(|name| (name, written(name, &one)))
            .collect();
        all.push(("check", written("check", &demo())));
        let text = weak_grip_diagnosed().to_owned();
        let page = std::fs::read_to_string(weak_grip().join("page.html")).expect("the page");
        all.push(("diagnose", Written { text, page, figures: weak_grip().join("figures"), _folder: None }));
        all
    })
}

#[test]
fn a_page_opens_with_the_sentence_that_the_terminal_says_first_and_the_terminal_says_little_more() {
    for (name, Written { text, page, .. }) in all_written() {
        let said = first_sentence(text.lines().next().expect("a line")).0;
        assert_eq!(said, shown(page, "<p class=\"verdict", "</p>"), "{name}");
        let lines = text.lines().filter(|line| !line.trim().is_empty()).count();
        assert!(lines <= LINES, "{name}: {lines} lines\n{text}");
    }
    assert!(all_written().iter().any(|(_, w)| w.text.starts_with("The model lacks: ")), "an effect is named");
}

/// Three conditions, three runs each: nothing is significant, and the largest errors last 12 ms.
#[test]
fn the_first_bar_is_what_the_verdict_names_and_what_lasts_a_few_samples_is_said_apart() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("compare.html");
    stickslip().arg("compare").arg(demo()).arg("--html").arg(&path).assert().success();
    let page = std::fs::read_to_string(&path).expect("the page");
    let after =
        |from: &str| page.split_once(from).and_then(|(_, rest)| rest.split_once('<')).expect("there").0;
    let (verdict, first) = (after("<p class=\"verdict fair\">"), after("<div class=\"name\">"));
    assert!(verdict.contains(first), "{verdict}: {first}");
    assert!(page.contains("Where a phase lasts less than 0.1 s") && page.contains("With so few repetitions"));
}

/// Drawings of a page: those that stand in it, and for each of its trials the bench and the plots of the script.
fn drawings(page: &str) -> usize {
    let count = |what: &str| page.matches(what).count();
    let plots = count("<figure data-plot");
    let still = count("<figure") - plots;
    still + count("\"said\":") * (plots + count("class=\"bench\""))
}

#[test]
fn figures_are_all_that_the_page_draws_each_whole_and_said_by_itself() {
    for (name, Written { page, figures, .. }) in all_written().iter().filter(|(name, _)| *name != "check") {
        let (mut drawn, mut dashed) = (0, 0);
        for entry in std::fs::read_dir(figures).expect("the folder") {
            let path = entry.expect("a file").path();
            if path.extension().is_some_and(|e| e == "png") {
                assert!(path.with_extension("svg").exists(), "{}", path.display());
                continue;
            }
            assert_eq!(path.extension().and_then(|e| e.to_str()), Some("svg"), "{}", path.display());
            let pixels = std::fs::read(path.with_extension("png"));
            // Without the feature there is none.
            assert_eq!(pixels.is_ok(), cfg!(feature = "png"), "{}", path.display());
            assert!(pixels.is_ok_and(|p| p.starts_with(b"\x89PNG\r\n")) == cfg!(feature = "png"));
            let text = std::fs::read_to_string(&path).expect("text");
            roxmltree::Document::parse(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            // No page around it says which line is which.
            if path.display().to_string().contains("fingers-1-and-2") {
                assert!(text.contains("measured, finger 2"), "{}", path.display());
                dashed += 1;
            }
            drawn += 1;
        }
        assert_eq!(drawn, drawings(page), "{name}");
        assert!(dashed > 0 || !matches!(*name, "compare" | "diagnose"), "{name}: no plot of both fingers");
    }
}

#[test]
fn figures_are_not_written_over() {
    let (folder, data) = push(|text| text);
    std::fs::create_dir(folder.path().join("figures")).expect("a folder");
    std::fs::write(folder.path().join("figures/mine.svg"), "mine").expect("written");
    let mut run = stickslip();
    run.arg("replay").arg(&data).arg("--figures").arg(folder.path().join("figures")).assert().failure();
    assert_eq!(std::fs::read_dir(folder.path().join("figures")).expect("the folder").count(), 1);
}

/// The page without the numbers of its traces, which are letters that may spell anything, and without scripts.
pub fn words(page: &str) -> String {
    let mut out = String::new();
    for (k, piece) in page.split("<script").enumerate() {
        out += if k == 0 { piece } else { piece.split_once("</script>").expect("an end").1 };
    }
    out
}

/// The page's body is well-formed, has headings without a gap between their levels, a name for each drawing and each
/// column, no number that is none, and every style is made of properties with values that a browser takes. Number of
/// cells with a colour of their own.
pub fn check(name: &str, page: &str) -> usize {
    for outside in ["http:", "https:", "src=", "@import", "url("] {
        let own = page.replace("http://www.w3.org/2000/svg", "");
        assert!(!own.contains(outside), "{name}: {outside}");
    }
    let body = page.split_once("<main>").and_then(|(_, rest)| rest.split_once("</main>")).expect("a body").0;
    let xml = format!("<main>{body}</main>");
    let document = roxmltree::Document::parse(&xml).unwrap_or_else(|e| {
        let line = xml.lines().nth(e.pos().row as usize - 1).unwrap_or_default();
        panic!("{name}: {e}: {line}")
    });
    assert!(
        document.descendants().any(|n| n.has_tag_name("h1") || n.has_tag_name("h2")),
        "{name}: a heading"
    );
    // What lies under an arrow cannot be read.
    for bench in document.descendants().filter(|n| n.attribute("class") == Some("bench")) {
        let with = |name: &'static str| bench.descendants().filter(move |n| n.attribute(name).is_some());
        let (arrows, texts) =
            (with("data-force").map(|n| n.range().start), with("data-label").map(|n| n.range().start));
        assert!(arrows.max() < texts.min(), "{name}: an arrow over a text");
    }
    let (mut coloured, mut level) = (0, 0);
    for node in document.descendants() {
        let tag = node.tag_name().name();
        if let Some(below) = tag.strip_prefix('h').and_then(|level| level.parse::<u32>().ok()) {
            assert!(below <= level + 1, "{name}: {tag} below level {level}");
            level = below;
        }
        let named = node.attribute("aria-label").is_some_and(|words| !words.is_empty());
        assert!(node.attribute("role") != Some("img") || named, "{name}: a drawing without a name");
        // Where the script has other words it writes them, and they are spoken before the title.
        if node.attribute("class") == Some("chosen") {
            let said = serde_json::Value::from(node.text().unwrap_or_default());
            assert!(page.contains(&format!("\"said\":{said}")), "{name}: {said}");
        }
        let words = || node.descendants().any(|n| n.text().is_some_and(|text| !text.trim().is_empty()));
        assert!(tag != "th" || words(), "{name}: a heading of a table without words");
        let text = node.text().filter(|_| !node.has_tag_name("script")).unwrap_or_default();
        assert!(!text.split(|c: char| !c.is_alphanumeric()).any(|w| w == "NaN"), "{name}: {text}");
        for declaration in node.attribute("style").into_iter().flat_map(|s| s.split(';')) {
            let (property, value) = declaration.split_once(':').expect("property: value");
            assert!(!value.contains(':'), "{name}: {declaration}");
            if property.ends_with("background") || property.ends_with("color") {
                coloured += 1;
                assert!(is_colour(value), "{name}: {declaration}");
            }
        }
        for attribute in ["fill", "stroke"] {
            if let Some(value) = node.attribute(attribute) {
                assert!(value == "none" || is_colour(value), "{name}: {attribute}={value}");
            }
        }
    }
    coloured
}

/// `#rgb`, `#rrggbb`, `rgb(r g b/alpha)` or `rgb(r,g,b)`.
fn is_colour(value: &str) -> bool {
    if let Some(hex) = value.strip_prefix('#') {
        return matches!(hex.len(), 3 | 6) && hex.chars().all(|c| c.is_ascii_hexdigit());
    }
    let Some(inside) = value.strip_prefix("rgb(").and_then(|v| v.strip_suffix(')')) else { return false };
    let (rgb, alpha) = inside.split_once('/').unwrap_or((inside, "1"));
    let parts: Vec<&str> = rgb.split([' ', ',']).collect();
    parts.len() == 3
        && parts.iter().all(|p| p.parse::<u8>().is_ok())
        && alpha.parse::<f64>().is_ok_and(|a| (0.0..=1.0).contains(&a))
}
