//! Signals over time that the page's script draws: the elements that hold them, and their numbers as
//! compact JSON. A reader zooms, reads values at a cursor that all plots share, and moves the bench with it.

use std::borrow::Cow;

use maud::{Markup, PreEscaped, html};
use serde::Serialize;

use crate::bench::{Course, Scenery};
use crate::packed::Packed;
use crate::plot::{Chart, Key, MEASURED, MODELS, thinned};
use plotters::style::RGBColor;

/// Most samples of a run in a page of few runs, and in one of many.
const SAMPLES: [usize; 2] = [1200, 500];
/// Points of a line in a drawing.
const POINTS: usize = 400;
/// A cursor reads less as 0.
const NOTHING: f64 = 5e-4;
/// A page of more runs has many.
const MANY: usize = 6;

/// A line of a plot.
#[derive(Clone, Debug, Serialize)]
pub struct Line {
    /// In the legend.
    pub label: String,
    /// Name of its colour in the style sheet: `measured`, `m0` to `m3`.
    pub ink: String,
    /// Dashed: the second finger.
    pub dash: bool,
}

/// Signals on common axes.
#[derive(Clone, Debug, Serialize)]
pub struct Plot {
    /// Where links lead.
    pub id: String,
    /// In words.
    pub title: String,
    /// Of all lines.
    pub unit: &'static str,
    /// The y axis spans at least this much.
    pub least: f64,
    /// The y axis ends here, where anything is beyond.
    pub most: Option<f64>,
    /// Of rows, from the lowest on, whose lines are at their number and higher where something is up; empty: the axis has
    /// numbers.
    pub names: Vec<&'static str>,
    /// In the order of [`Run::values`].
    pub lines: Vec<Line>,
    /// Whether it is shown at first; the rest unfolds.
    #[serde(skip)]
    pub first: bool,
}

/// A shaded span of time: class of its shade (empty: none), from, to, what it is.
pub type Span = (&'static str, f64, f64, Cow<'static, str>);

/// What is drawn of one trial.
pub struct Run {
    /// Of the trial.
    pub id: String,
    /// Why it is shown.
    pub role: String,
    /// Its conditions.
    pub words: String,
    /// Time stamps.
    pub t_s: Vec<f64>,
    /// By plot and line, one for each time stamp; empty: not known.
    pub values: Vec<Vec<Vec<f64>>>,
    /// Phases.
    pub spans: Vec<Span>,
    /// By plot: line, from, to, half width of its noise band.
    pub half: Vec<Vec<(usize, f64, f64, f64)>>,
    /// By plot: time and ends of the intervals of forces that are open, one row a line.
    pub open: Vec<Vec<Vec<[f64; 3]>>>,
    /// The bodies.
    pub scenery: Option<Scenery>,
}

#[derive(Serialize)]
struct Data<'a> {
    plots: &'a [Plot],
    runs: Vec<Packet>,
}

#[derive(Serialize)]
struct Packet {
    /// Which it is, in full.
    said: String,
    words: String,
    t: Packed,
    v: Vec<Vec<Option<Packed>>>,
    spans: Vec<Span>,
    half: Vec<Vec<(usize, f64, f64, f64)>>,
    open: Vec<Vec<Vec<[f64; 3]>>>,
    svg: Option<String>,
    course: Option<Course>,
}

/// The section: the trial that is shown, `chooser`, the bench, the plots.
pub fn viewer(title: &str, legend: &Markup, chooser: &Markup, plots: &[Plot], runs: &[Run]) -> Markup {
    let Some(first) = runs.first() else { return html! {} };
    let most = SAMPLES[usize::from(runs.len() > MANY)];
    let data = Data { plots, runs: runs.iter().map(|r| packet(r, most)).collect() };
    let json = serde_json::to_string(&data).unwrap_or_else(|_| "{\"plots\":[],\"runs\":[]}".to_owned());
    // Inside an element a page's reader must see no tag.
    let json = json.replace('&', "\\u0026").replace('<', "\\u003c").replace('>', "\\u003e");
    let shown = |k: usize| {
        html! {
            figure data-plot=(k) {
                figcaption { (plots[k].title) span { (unit(&plots[k])) } }
                div class="plot" {}
            }
        }
    };
    let (at_first, folded): (Vec<usize>, Vec<usize>) = (0..plots.len()).partition(|k| plots[*k].first);
    let bench = first.scenery.as_ref().filter(|s| s.is_seen());
    html! {
        section class="viewer" aria-label=(title) {
            h2 { (title) }
            (chooser)
            p class="chosen" aria-live="polite" { (first.said()) }
            @if let Some(scenery) = bench { div class="bench" { (scenery.svg(scenery.farthest())) } }
            div class="controls" {}
            (legend)
            noscript { "The traces are drawn by the script of this page; with --figures they are files." }
            div class="grid" { @for k in &at_first { (shown(*k)) } }
            @if !folded.is_empty() {
                details {
                    summary { (folded.len()) " more" }
                    div class="grid" { @for k in &folded { (shown(*k)) } }
                }
            }
            @if runs.len() > 1 && !plots.is_empty() {
                details { summary { "One channel in all of these trials" } div class="small" {} }
            }
            script type="application/json" { (PreEscaped(json)) }
        }
        "\n"
    }
}

impl Run {
    /// Why it is shown, which it is, and its conditions.
    fn said(&self) -> String {
        let space = if self.role.is_empty() { "" } else { " " };
        format!("{}{space}{}: {}", self.role, self.id, self.words)
    }
}

fn packet(run: &Run, most: usize) -> Packet {
    let at = slots(run.t_s.len(), most);
    let t: Vec<f64> = at.iter().map(|i| run.t_s[*i]).collect();
    let bench = run.scenery.as_ref().filter(|s| s.is_seen());
    Packet {
        said: run.said(),
        words: run.words.clone(),
        t: Packed::of(&t),
        v: run.values.iter().map(|lines| columns(lines, &at)).collect(),
        spans: run.spans.clone(),
        half: run.half.clone(),
        open: run.open.clone(),
        svg: bench.map(|s| s.svg(s.farthest()).into_string()),
        course: bench.map(|s| s.course(&at)),
    }
}

/// What stands beside a plot's title: nothing where it is a ratio.
fn unit(plot: &Plot) -> &str {
    if plot.unit == "1" { "" } else { plot.unit }
}

/// Shades of spans in drawings: class, colour, opacity, meaning. On the page the style sheet has them.
const SHADES: [(&str, RGBColor, f64, &str); 5] = [
    ("rest", RGBColor(0x99, 0x99, 0x99), 0.18, "before contact, end"),
    ("onset", RGBColor(0xe6, 0x9f, 0x00), 0.22, "onset"),
    ("sliding", RGBColor(0x56, 0xb4, 0xe9), 0.14, "sliding"),
    ("event", RGBColor(0xe6, 0x9f, 0x00), 0.25, "what happened, by the measured motion"),
    ("vain", RGBColor(0xcc, 0x79, 0xa7), 0.25, "false alarm"),
];

/// Shades the spans of a drawing, each from one time to another.
pub(crate) fn shade<'a>(chart: &mut Chart, spans: impl IntoIterator<Item = (&'a str, f64, f64)>) {
    for (class, from, to) in spans {
        let of_class = SHADES.iter().find(|(known, ..)| *known == class);
        chart.spans.extend(of_class.map(|(_, colour, opacity, _)| (from, to, *colour, *opacity)));
    }
}

/// Says in the legend of a drawing what its shades mean.
pub(crate) fn explain_shades(chart: &mut Chart) {
    for (_, colour, opacity, what) in SHADES {
        if chart.spans.iter().any(|span| (span.2, span.3) == (colour, opacity)) {
            chart.legend.push(Key::Span(what.to_owned(), colour, opacity));
        }
    }
}

/// Plot `k` of a run as a drawing with a legend; the second finger's lines are dashed, noise and spans are shaded, as on the
/// page.
#[must_use]
pub fn chart_of(plot: &Plot, run: &Run, k: usize) -> Chart {
    let (t_s, none) = (&run.t_s, Vec::new());
    let (values, half) = (run.values.get(k).unwrap_or(&none), run.half.get(k).map_or(&[][..], Vec::as_slice));
    let colour = |ink: &str| match ink.strip_prefix('m').and_then(|k| k.parse::<usize>().ok()) {
        Some(k) => MODELS[k.min(MODELS.len() - 1)],
        None => MEASURED,
    };
    let mut chart = Chart {
        size: (560, 260),
        x_label: "time, s".into(),
        y_label: match unit(plot) {
            "" => plot.title.clone(),
            unit => format!("{}, {unit}", plot.title),
        },
        least_span: plot.least,
        y_names: plot.names.iter().map(|name| (*name).to_owned()).collect(),
        x: [t_s.first(), t_s.last()].map(|t| t.copied().unwrap_or(0.0)).into(),
        ..Chart::default()
    };
    for (index, (line, values)) in plot.lines.iter().zip(values).enumerate() {
        if !values.iter().any(|x| x.is_finite()) {
            continue;
        }
        let colour = colour(&line.ink);
        let mut points = thinned(t_s, values, POINTS);
        if let Some(most) = plot.most {
            // NaN stays.
            points.iter_mut().filter(|p| p.1 > most).for_each(|p| p.1 = most);
        }
        let drawn = crate::plot::Line { points, colour, width: 2 };
        for (_, from, to, half) in half.iter().filter(|(of, ..)| *of == index) {
            let inside = drawn.points.iter().filter(|p| p.0 >= *from && p.0 <= *to && p.1.is_finite());
            let band: Vec<(f64, f64, f64)> = inside.map(|p| (p.0, p.1 - half, p.1 + half)).collect();
            if band.len() > 1 {
                chart.bands.push((band, colour));
            }
        }
        if line.dash { &mut chart.dashed } else { &mut chart.lines }.push(drawn);
        // Rows have their names beside them.
        if plot.names.is_empty() {
            chart.legend.push(Key::of_line(line.label.clone(), colour, line.dash));
        }
    }
    if let Some((_, colour)) = chart.bands.first() {
        chart.legend.push(Key::Band("noise, one standard deviation".into(), *colour));
    }
    let (from, to) = chart.x;
    let seen = run.spans.iter().filter(|s| s.2 >= from && s.1 <= to);
    shade(&mut chart, seen.map(|(class, from, to, _)| (*class, *from, *to)));
    explain_shades(&mut chart);
    chart
}

/// Samples that stand for all: every one, or two of each stretch.
fn slots(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        return (0..count).collect();
    }
    let stretches = most / 2;
    (0..stretches).flat_map(|k| [k * count / stretches, (2 * k + 1) * count / (2 * stretches)]).collect()
}

/// Lines of a plot; none of them where all are zero throughout: there is nothing to see.
fn columns(lines: &[Vec<f64>], at: &[usize]) -> Vec<Option<Packed>> {
    let seen = lines.iter().flatten().any(|x| x.is_finite() && x.abs() > NOTHING);
    lines.iter().map(|line| column(line, at).filter(|_| seen)).collect()
}

/// The smallest and the largest value of each stretch in the order in which they come, so that peaks stay.
fn column(values: &[f64], at: &[usize]) -> Option<Packed> {
    if !values.iter().any(|x| x.is_finite()) {
        return None;
    }
    if at.len() == values.len() {
        return Some(Packed::of(values));
    }
    let mut out = Vec::with_capacity(at.len());
    for k in (0..at.len()).step_by(2) {
        let end = at.get(k + 2).copied().unwrap_or(values.len());
        let stretch = at[k]..end;
        let known = || stretch.clone().filter(|i| values[*i].is_finite());
        let by = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
        match (known().min_by(by), known().max_by(by)) {
            (Some(a), Some(b)) => out.extend([values[a.min(b)], values[a.max(b)]]),
            _ => out.extend([f64::NAN; 2]),
        }
    }
    Some(Packed::of(&out))
}
