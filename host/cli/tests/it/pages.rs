//! Every command that writes a page: the page is whole, and needs nothing from elsewhere.

use assert_cmd::Command;
use clap::CommandFactory;
use stickslip_cli::commands::Cli;

use crate::common::push;

#[test]
fn every_command_with_a_page_writes_one_that_is_whole_and_needs_no_network() {
    let (folder, data) = push(|text| text);
    let mut commands = 0;
    let command = Cli::command();
    for sub in command.get_subcommands().filter(|s| s.get_arguments().any(|a| a.get_id() == "html")) {
        let name = sub.get_name();
        let path = folder.path().join(format!("{name}.html"));
        let mut run = Command::cargo_bin("stickslip").expect("the binary");
        match name {
            // Of a recording, not of a data set.
            "new" => {
                let index = stickslip_data::Index::open(&data).expect("a data set");
                let recording = data.join(&index.trials[0].file);
                run.arg(name).arg(recording).arg("--out").arg(folder.path().join("mapping.toml"));
            }
            _ => {
                run.arg(name).arg(&data);
            }
        }
        run.arg("--html").arg(&path).assert().success();
        let page = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{name}: {e}"));
        check(name, &page);
        commands += 1;
    }
    assert!(commands >= 4, "compare, diagnose, replay and score, not {commands}");
}

/// Three conditions, three runs each: nothing is significant, and the largest errors last 12 ms.
#[test]
fn the_first_bar_is_what_the_verdict_names_and_what_lasts_a_few_samples_is_said_apart() {
    let folder = tempfile::tempdir().expect("a folder");
    let demo = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo");
    let path = folder.path().join("compare.html");
    let mut run = Command::cargo_bin("stickslip").expect("the binary");
    run.arg("compare").arg(&demo).arg("--html").arg(&path).assert().success();
    let page = std::fs::read_to_string(&path).expect("the page");
    let after =
        |from: &str| page.split_once(from).and_then(|(_, rest)| rest.split_once('<')).expect("there").0;
    let (verdict, first) = (after("<p class=\"verdict fair\">"), after("<div class=\"name\">"));
    assert!(verdict.contains(first), "{verdict}: {first}");
    assert!(page.contains("Where a phase lasts less than 0.1 s") && page.contains("With so few repetitions"));
}

#[test]
fn figures_are_whole_drawings_in_a_folder_of_their_own_and_none_is_overwritten() {
    let (folder, data) = push(|text| text);
    for name in ["compare", "diagnose", "replay", "score"] {
        let out = folder.path().join(format!("{name}-figures"));
        let figures = || {
            let mut run = Command::cargo_bin("stickslip").expect("the binary");
            run.arg(name).arg(&data).arg("--figures").arg(&out);
            run.assert()
        };
        figures().success();
        let mut drawn = 0;
        for entry in std::fs::read_dir(&out).expect("the folder") {
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
            drawn += 1;
        }
        assert!(drawn > 0, "{name}");
        figures().failure();
    }
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
