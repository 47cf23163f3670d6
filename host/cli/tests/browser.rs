//! The pages in a real browser: every kind of thing that can be clicked is, and nothing is written to its console.
//!
//! Needs Chromium or Chrome, which `make test-host-rest` installs and runs these with.

#[allow(dead_code)]
#[path = "it/common.rs"]
mod common;
#[path = "browser/devtools.rs"]
mod devtools;

use std::path::{Path, PathBuf};
use std::process::Command;

use libtest_mimic::{Arguments, Trial};

/// Widths of a phone, a tablet and a large screen, px.
const WIDTHS: [u32; 3] = [390, 768, 1600];

/// Clicks what can be clicked, moves all sliders, and leaves what happened in the document.
const VISIT: &str = r#"<script>
const wrong = [];
// Numbers that stand beside the y axis of each drawing.
const beside = new Map();
const {fillText, clearRect} = CanvasRenderingContext2D.prototype;
CanvasRenderingContext2D.prototype.clearRect = function (...all) { beside.set(this.canvas, []); return clearRect.apply(this, all); };
CanvasRenderingContext2D.prototype.fillText = function (text, ...all) {
  if (this.textAlign === 'right') { beside.get(this.canvas)?.push(text); }
  return fillText.call(this, text, ...all);
};
addEventListener('error', e => wrong.push('error: ' + e.message));
addEventListener('unhandledrejection', e => wrong.push('rejected: ' + e.reason));
const said = console.error;
console.error = (...words) => { wrong.push('console: ' + words.join(' ')); said(...words); };
addEventListener('load', () => setTimeout(() => {
  let clicked = 0;
  for (const details of document.querySelectorAll('details')) { details.open = true; }
  // Of the cells of tables that lead to traces, which are hundreds of one kind, some.
  const leads = document.querySelectorAll('button[data-goto]');
  const some = new Set([...leads].filter((_, k) => k % Math.ceil(leads.length / 30) === 0));
  for (const element of document.querySelectorAll('button, summary')) {
    if (!element.dataset.goto || some.has(element)) { element.click(); clicked++; }
  }
  for (const details of document.querySelectorAll('details')) { details.open = true; }
  for (const slider of document.querySelectorAll('input[type=range]')) {
    for (const share of [0, 0.3, 1]) {
      slider.value = Math.round(share * slider.max);
      slider.dispatchEvent(new Event('input'));
      clicked++;
    }
  }
  for (const select of document.querySelectorAll('select')) {
    for (const option of select.options) {
      select.value = option.value;
      select.dispatchEvent(new Event('change'));
      clicked++;
    }
  }
  dispatchEvent(new Event('beforeprint'));
  dispatchEvent(new Event('afterprint'));
  setTimeout(() => {
    const figures = [...document.querySelectorAll('figure[data-plot]')].filter(f => !f.hidden);
    const empty = figures.filter(f => !f.querySelector('canvas')).length;
    // What a screen reader is told: names of pictures, of controls and of tables, headings in order, times of sliders.
    const unsaid = [], switched = [];
    const named = e => (e.getAttribute('aria-label') || e.getAttribute('title') || e.textContent || '').trim()
      || [...(e.labels || [])].some(l => l.textContent.trim());
    const seen = e => e.getClientRects().length && !e.closest('[aria-hidden=true]');
    for (const e of document.querySelectorAll('svg, canvas, img')) {
      const says = e.closest('[role=img]')?.getAttribute('aria-label');
      if (seen(e) && !says) { unsaid.push('picture without words: ' + e.outerHTML.slice(0, 80)); }
    }
    for (const e of document.querySelectorAll('button, select, input, summary, a')) {
      if (seen(e) && !named(e)) { unsaid.push('control without a name: ' + e.outerHTML.slice(0, 80)); }
    }
    for (const e of document.querySelectorAll('table')) {
      if (seen(e) && !e.caption && !e.getAttribute('aria-label')) { unsaid.push('table without a name: ' + e.textContent.slice(0, 80)); }
    }
    for (const e of document.querySelectorAll('tbody tr')) {
      if (!e.querySelector('th')) { unsaid.push('row without a heading: ' + e.textContent.slice(0, 80)); }
    }
    for (const e of document.querySelectorAll('button[data-run]')) {
      const says = e.getAttribute('aria-label');
      if (seen(e) && says !== null && !/[a-z]/.test(says.replace(/noise floors/, ''))) { unsaid.push('a cell without its condition: ' + says); }
    }
    for (const e of document.querySelectorAll('.plot canvas')) {
      const says = e.getAttribute('aria-label') || '';
      if (seen(e) && !/ from .+ to .+\. At [0-9.-]+ s: ./.test(says)) { unsaid.push('a plot that says no values: ' + says); }
    }
    for (const e of document.querySelectorAll('.plot canvas')) {
      const ticks = beside.get(e) || [];
      if (seen(e) && (ticks.length < 2 || new Set(ticks).size < ticks.length)) {
        unsaid.push('numbers beside an axis that are none, or alike: ' + ticks.join(' '));
      }
    }
    // A cell leads to the plot of its channel in a trial that has it, which is said.
    const cells = [...document.querySelectorAll('button[data-goto]')].filter(seen);
    const runs = document.querySelector('.viewer script') && JSON.parse(document.querySelector('.viewer script').textContent).runs;
    const maps = cells.filter(cell => cell.dataset.run && cell.closest('table.heat'));
    for (const cell of [...cells.slice(0, 8), ...maps.slice(0, 8)]) {
      cell.click();
      const there = document.activeElement.getAttribute('aria-label') || '';
      if (!/ At [0-9.-]+ s: /.test(there)) {
        unsaid.push('a cell that leads to a place without words: ' + document.activeElement.outerHTML.slice(0, 80));
      }
      if (cell.dataset.run && document.querySelector('.chosen').textContent !== runs[+cell.dataset.run].said) {
        unsaid.push('a cell that leads to another trial: ' + cell.outerHTML.slice(0, 80));
      }
    }
    for (const e of document.querySelectorAll('.fails')) {
      if (!/fails/.test(e.textContent)) { unsaid.push('fails by its looks alone: ' + e.textContent.slice(0, 80)); }
    }
    for (const e of document.querySelectorAll('.of')) {
      const bars = [...e.querySelectorAll('.bar')];
      if (bars.length > 1 && bars.some(bar => !/[a-z]/.test(bar.textContent))) {
        unsaid.push('bars told apart by colour alone: ' + e.textContent);
      }
    }
    let level = 0;
    for (const e of document.querySelectorAll('h1, h2, h3, h4')) {
      const own = +e.tagName[1];
      if (own > level + 1) { unsaid.push('heading of level ' + own + ' after ' + level + ': ' + e.textContent); }
      level = own;
    }
    for (const slider of document.querySelectorAll('input[type=range]')) {
      const says = slider.getAttribute('aria-valuetext') || '';
      if (!/^t = [0-9.-]+ s, .+/.test(says)) { unsaid.push('a slider that says no time, or not what is there: ' + says); }
      const drawing = slider.closest('.viewer').querySelector('.bench svg');
      if (drawing && !drawing.getAttribute('aria-label').includes(says)) {
        unsaid.push('a bench whose words are not those of its slider: ' + says);
      }
    }
    for (const legend of [...document.querySelectorAll('.u-legend')].filter(seen)) {
      const lines = [...legend.querySelectorAll('[role=button]')];
      const press = (line, key) => line.dispatchEvent(new KeyboardEvent('keydown', {key, bubbles: true}));
      if (lines.filter(line => line.tabIndex === 0).length !== 1) { unsaid.push('a legend that is not one stop of the Tab key'); }
      press(lines[0], 'ArrowLeft');
      const last = lines[lines.length - 1];
      if (document.activeElement !== last || last.tabIndex !== 0) { unsaid.push('a legend whose lines no arrow reaches'); }
      press(last, 'Enter');
      switched.push(last);
    }
    const over = document.documentElement.scrollWidth - innerWidth;
    setTimeout(() => {
      for (const line of switched) {
        if (line.getAttribute('aria-pressed') !== 'false') { unsaid.push('a line that no key switches off: ' + line.textContent); }
      }
      const report = document.createElement('pre');
      report.id = 'visit';
      report.textContent = JSON.stringify({clicked, wrong, empty, over, unsaid, maps: maps.length, cells: cells.length});
      document.body.append(report);
    }, 100);
  }, 300);
}, 300));
</script>"#;

/// Where a browser is, if there is one.
fn browser() -> Option<PathBuf> {
    let names = ["chromium", "chromium-browser", "google-chrome", "chrome"];
    let folders: Vec<PathBuf> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
    let found = names.iter().flat_map(|n| folders.iter().map(move |f| f.join(n)));
    found.into_iter().find(|p| p.is_file())
}

/// A page that is visited.
struct Page {
    /// The command, and what it is of.
    name: &'static str,
    /// Whether cells of its tables lead to traces, and whether those of a heat map over conditions or phases do.
    cells: [bool; 2],
    /// Made by.
    made: fn(&Path) -> Command,
}

/// Opens the page `html` in a window of `width` pixels and clicks through it.
fn visit(browser: &Path, page: &Page, html: &str, width: u32) {
    let name = page.name;
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("page.html");
    let (before, after) = html.split_once("</title>").expect("a title");
    std::fs::write(&path, format!("{before}</title>{VISIT}{after}")).expect("written");
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--dump-dom", "--virtual-time-budget=20000"])
        .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
        .arg(format!("--window-size={width},900"))
        .arg(format!("file://{}", path.display()))
        .output()
        .expect("the browser runs");
    let dom = String::from_utf8_lossy(&output.stdout);
    let report = dom.split_once("<pre id=\"visit\">").and_then(|(_, rest)| rest.split_once("</pre>"));
    let report = report
        .unwrap_or_else(|| {
            panic!("{name}: the visit did not end: {}", String::from_utf8_lossy(&output.stderr))
        })
        .0;
    let report: serde_json::Value =
        serde_json::from_str(&report.replace("&gt;", ">").replace("&amp;", "&").replace("&lt;", "<"))
            .expect("JSON");
    assert_eq!(report["wrong"], serde_json::json!([]), "{name}");
    assert_eq!(report["unsaid"], serde_json::json!([]), "{name}: what a screen reader misses");
    assert_eq!(report["empty"], 0, "{name}: a plot without a drawing");
    assert!(name == "check" || report["clicked"].as_u64().is_some_and(|n| n > 0), "{name}: nothing to click");
    for (key, expected) in ["cells", "maps"].into_iter().zip(page.cells) {
        let found = report[key].as_u64().is_some_and(|n| n > 0);
        assert_eq!(found, expected, "{name}: {key} that lead to traces: {}", report[key]);
    }
    assert!(
        report["over"].as_i64().is_some_and(|n| n <= 0),
        "{name}: wider than {width} px by {}",
        report["over"]
    );
}

/// One recorded push.
fn push(command: &str, folder: &Path) -> Command {
    let (made, data) = common::push(|text| text);
    // As long as the test.
    let data = folder.join(data.strip_prefix(made.path()).expect("inside"));
    std::fs::rename(made.path().join("push"), &data).expect("moved");
    of(&[command], &data)
}

/// Pushes under six conditions by a gripper that loses three tenths of its grip: an effect is named.
fn weak_grip(command: &str, folder: &Path) -> Command {
    let data = folder.join("weak");
    let rig = [
        "rig",
        "--hidden",
        "grip_force_loss=0.3",
        "--seed",
        "11",
        "--runs",
        "2",
        "--objects",
        "obj4",
        "--out",
    ];
    assert!(of(&rig, &data).status().expect("the rig runs").success());
    // Three grips at two speeds, each twice.
    let rows = std::fs::read_to_string(data.join("trials.csv")).expect("written");
    let some = rows.lines().enumerate().filter(|(k, _)| *k == 0 || k % 3 == 2).map(|(_, row)| row);
    std::fs::write(data.join("trials.csv"), some.collect::<Vec<_>>().join("\n") + "\n").expect("written");
    of(&[command], &data)
}

/// A recording of a laboratory, and the mapping that `new` begins.
fn recording(command: &str, folder: &Path) -> Command {
    let recording = demo().join("trials/linear_push-obj4-g20-v10-s0-r1.csv");
    let mapping = folder.join("mapping.toml");
    let mut new = of(&["new"], &recording);
    new.arg("--out").arg(&mapping);
    if command == "new" {
        return new;
    }
    assert!(new.status().expect("it runs").success());
    let text = std::fs::read_to_string(&mapping).expect("written");
    let place = "[fixed.pusher]\nposition_m = [";
    std::fs::write(&mapping, text.replace(&format!("{place}0.0,"), &format!("{place}-0.0503,")))
        .expect("written");
    let mut import = of(&["import", "recording"], &mapping);
    import.arg("--out").arg(folder.join("data"));
    import
}

fn demo() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo")
}

fn of(words: &[&str], path: &Path) -> Command {
    let mut run = Command::new(env!("CARGO_BIN_EXE_stickslip"));
    run.args(words).arg(path);
    run
}

/// Two fingers zoom a plot on a phone, one moves it, two taps show all of it again; a finger on the slider moves the time.
fn touched(browser: &Path) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("page.html");
    let made = push("replay", folder.path()).arg("--html").arg(&file).output().expect("it runs");
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let mut page = devtools::Page::on_a_phone(browser, &file, (390, 844));
    page.wait("document.readyState === 'complete' && !!document.querySelector('.u-over')");
    page.value("document.querySelector('.u-over').scrollIntoView({block: 'center', behavior: 'instant'})");
    let at = |page: &mut devtools::Page, what: &str| -> [f64; 4] {
        let box_of = format!(
            "(() => {{ const r = document.querySelector('{what}').getBoundingClientRect(); \
             return [r.left, r.top, r.width, r.height]; }})()"
        );
        serde_json::from_value(page.value(&box_of)).expect("a box")
    };
    let shown = |page: &mut devtools::Page| -> [f64; 2] {
        // What is drawn is drawn in the next frame.
        std::thread::sleep(std::time::Duration::from_millis(200));
        let text = page.value("document.querySelector('figure[data-shown]').dataset.shown");
        let ends: Vec<f64> =
            text.as_str().expect("a text").split(' ').map(|s| s.parse().expect("a number")).collect();
        ends.try_into().expect("two")
    };
    let [left, top, width, height] = at(&mut page, ".u-over");
    let to = |share: f64| [left + share * width, top + 0.5 * height];
    let whole = shown(&mut page);
    // It opens where the model's object is farthest, not where a plot's own cursor begins.
    let start = "JSON.parse(document.querySelector('.viewer script').textContent).runs[0].course.start";
    let begun = page.value(&format!("+document.querySelector('input[type=range]').value === {start}"));
    assert_eq!(begun, true, "the page opens at another time");
    let wide = |[from, to]: [f64; 2]| to - from;

    page.fingers(&[&[to(0.4), to(0.6)], &[to(0.35), to(0.65)], &[to(0.3), to(0.7)]]);
    let zoomed = shown(&mut page);
    // Twice as far apart: half of the time, and what was in the middle still is.
    assert!((wide(zoomed) / wide(whole) - 0.5).abs() < 0.03, "{whole:?}: {zoomed:?}");
    let middle = |[from, to]: [f64; 2]| 0.5 * (from + to);
    assert!((middle(zoomed) - middle(whole)).abs() < 0.03 * wide(whole), "{whole:?}: {zoomed:?}");

    page.fingers(&[&[to(0.5)], &[to(0.4)], &[to(0.3)]]);
    let moved = shown(&mut page);
    let by = middle(moved) - middle(zoomed);
    assert!((wide(moved) - wide(zoomed)).abs() < 2e-3, "{zoomed:?}: {moved:?}");
    assert!((by - 0.2 * wide(zoomed)).abs() < 0.03 * wide(zoomed), "{zoomed:?}: {moved:?}");

    page.fingers(&[&[to(0.5)]]);
    page.fingers(&[&[to(0.5)]]);
    assert_eq!(shown(&mut page), whole);

    let time = |page: &mut devtools::Page| {
        page.value("+document.querySelector('input[type=range]').value").as_f64().expect("a number")
    };
    page.value(
        "document.querySelector('input[type=range]').scrollIntoView({block: 'center', behavior: 'instant'})",
    );
    let [left, top, width, height] = at(&mut page, "input[type=range]");
    assert!(height >= 36.0, "a slider that a finger hits is {height} px high");
    let on = |share: f64| [left + share * width, top + 0.5 * height];
    let before = time(&mut page);
    page.fingers(&[&[on(0.5)], &[on(0.7)], &[on(0.9)]]);
    let after = time(&mut page);
    assert!(after > before, "{before}: {after}");
}

/// Several trials to choose from where the page has a choice; else one.
const PAGES: [Page; 10] = [
    Page { name: "check", cells: [false, false], made: |at| push("check", at) },
    Page { name: "compare", cells: [true, true], made: |at| weak_grip("compare", at) },
    Page { name: "compare three conditions", cells: [true, false], made: |_| of(&["compare"], &demo()) },
    Page { name: "compare one push", cells: [true, false], made: |at| push("compare", at) },
    Page { name: "diagnose without a name", cells: [true, true], made: |_| of(&["diagnose"], &demo()) },
    Page { name: "diagnose with a name", cells: [true, true], made: |at| weak_grip("diagnose", at) },
    Page { name: "replay", cells: [false, false], made: |at| push("replay", at) },
    Page { name: "score", cells: [true, false], made: |at| push("score", at) },
    Page { name: "new", cells: [false, false], made: |at| recording("new", at) },
    Page { name: "import recording", cells: [false, false], made: |at| recording("import", at) },
];

fn main() {
    let browser = browser();
    if browser.is_none() {
        eprintln!("no Chromium or Chrome on the PATH: the pages are not clicked through");
    }
    let of_pages = browser.clone();
    let trials = PAGES.into_iter().map(|page| {
        let browser = of_pages.clone();
        let name = page.name.replace(' ', "_");
        Trial::test(format!("the_page_of_{name}_is_clicked_through_without_an_error"), move || {
            let folder = tempfile::tempdir().expect("a folder");
            let path = folder.path().join("page.html");
            let made = (page.made)(folder.path()).arg("--html").arg(&path).output().expect("it runs");
            assert!(made.status.success(), "{}: {}", page.name, String::from_utf8_lossy(&made.stderr));
            let html = std::fs::read_to_string(&path).expect("the page");
            for width in WIDTHS {
                visit(&browser.clone().expect("a browser"), &page, &html, width);
            }
            Ok(())
        })
        // Long: make test-host-rest.
        .with_ignored_flag(true)
    });
    let fingers = Trial::test("two_fingers_zoom_a_plot_one_moves_it_and_two_taps_show_all", move || {
        touched(&browser.expect("a browser"));
        Ok(())
    });
    let all = trials.chain([fingers.with_ignored_flag(true)]);
    libtest_mimic::run(&Arguments::from_args(), all.collect()).exit();
}
