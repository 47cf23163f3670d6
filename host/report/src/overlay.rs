//! Measured and modelled signals of trials: as plots of a page, and as drawings.

use std::collections::{BTreeMap, BTreeSet};

use maud::{Markup, html};
use plotters::style::RGBColor;

use crate::bench::Scenery;
use crate::figures::Figure;
use crate::html::{heat, swatch};
use crate::plot::{self, Chart, Key, MEASURED, MODELS, thinned};
use crate::viewer::{self, Plot, Run, Span};
use crate::words::times;
use stickslip_analysis::channels::{COUNT, NAMES, Signals, channel_words, quantity};
use stickslip_analysis::compare::document::{ErrorRow, Trace};
use stickslip_analysis::compare::verdict::scale;
use stickslip_analysis::evidence::conditions::Variable;
use stickslip_analysis::evidence::phases::{PHASES, Phase, Phases};

/// Shading of the phases, as classes; contact before motion stays white.
const SHADE_CLASSES: [&str; 5] = ["rest", "", "onset", "sliding", "rest"];
/// Forces that are not determined.
const OPEN: RGBColor = RGBColor(0x00, 0x9e, 0x73);
const SIZE: (u32, u32) = (360, 170);
const POINTS: usize = 260;
/// What a plot spans at least, in the unit that it shows: less is nothing to a reader.
const LEAST: f64 = 0.02;
/// Plots that are shown at first where none fails.
const FEWEST: usize = 3;
/// And at most.
const MOST: usize = 6;

/// The channels that share axes with `channel`: those of both fingers.
fn together(channel: usize) -> Vec<usize> {
    match channel {
        6..=11 => vec![channel, channel + 6],
        12..=17 => vec![channel - 6, channel],
        _ => vec![channel],
    }
}

/// The plot that shows a channel.
#[must_use]
pub fn plot_id(channel: usize) -> String {
    NAMES[together(channel)[0]].replace('_', "-").replace("finger1", "fingers")
}

/// Traces of a comparison with the trials to choose from; `errors` say which channels fail. Errors `after` are those
/// of a better model: what it mends most comes first.
#[must_use]
pub fn section(traces: &[Trace], models: &[&str], errors: &[ErrorRow], after: Option<&[ErrorRow]>) -> Markup {
    let groups = groups(traces, errors, after);
    let plots: Vec<Plot> =
        groups.iter().map(|(channels, first)| one_plot(channels, *first, models)).collect();
    let runs: Vec<Run> = traces.iter().map(|t| run(t, &groups)).collect();
    let open = traces.iter().any(|t| !t.force_bands.is_empty());
    viewer::viewer("How the model goes wrong", &legend(models, open), &chooser(traces), &plots, &runs)
}

/// Channels that are drawn together, and whether one fails; failing ones first, the worst of them ahead.
fn groups(traces: &[Trace], errors: &[ErrorRow], after: Option<&[ErrorRow]>) -> Vec<(Vec<usize>, bool)> {
    let measured = |c: &usize| traces.iter().any(|t| t.measured.iter().any(|s| s[*c].is_finite()));
    let mut out: Vec<(Vec<usize>, bool, f64)> = (0..COUNT)
        .map(together)
        .collect::<BTreeSet<_>>()
        .into_iter()
        .map(|channels| channels.into_iter().filter(measured).collect::<Vec<_>>())
        .filter(|channels| !channels.is_empty())
        .map(|channels| {
            let rows = || errors.iter().filter(|r| channels.contains(&r.index));
            let left = |r: &ErrorRow| {
                let same = after.into_iter().flatten().find(|a| a.place == r.place);
                same.and_then(|a| a.error.multiples).unwrap_or(0.0)
            };
            // Of what fails: a place that may be chance is no reason to be the first.
            let size = |r: &ErrorRow| Some(r.error.multiples? - left(r));
            let of = |failing: bool| {
                rows().filter(|r| r.fails == failing).filter_map(size).fold(f64::NEG_INFINITY, f64::max)
            };
            let worst = if rows().any(|r| r.fails) { of(true) } else { of(false) };
            (channels.clone(), rows().any(|r| r.fails || r.sustained == Some(true)), worst)
        })
        .collect();
    out.sort_by(|a, b| b.1.cmp(&a.1).then(b.2.total_cmp(&a.2)));
    // What a better model does not mend is not what it is shown for.
    let failing = out
        .iter()
        .filter(|g| g.1 && (after.is_none() || g.2 > 0.0))
        .count()
        .max(if after.is_some() && out.iter().any(|g| g.1) { FEWEST } else { 0 });
    let shown = if failing == 0 { FEWEST } else { failing.min(MOST) };
    out.into_iter().enumerate().map(|(k, (channels, ..))| (channels, k < shown)).collect()
}

fn one_plot(channels: &[usize], first: bool, models: &[&str]) -> Plot {
    let (_, unit) = scale(quantity(channels[0]).unit());
    let both = channels.len() > 1;
    let words = channel_words(NAMES[channels[0]]);
    let mut lines = Vec::new();
    for (k, _) in channels.iter().enumerate() {
        let of = |what: &str| if both { format!("{what}, finger {}", k + 1) } else { what.to_owned() };
        lines.push(viewer::Line { label: of("measured"), ink: "measured".into(), dash: k > 0 });
        for (m, name) in models.iter().enumerate().take(MODELS.len()) {
            lines.push(viewer::Line { label: of(name), ink: format!("m{m}"), dash: k > 0 });
        }
    }
    Plot {
        id: plot_id(channels[0]),
        title: if both { words.replace("finger 1", "fingers 1 and 2,") } else { words },
        unit,
        least: LEAST,
        most: None,
        names: Vec::new(),
        lines,
        first,
    }
}

fn run(trace: &Trace, groups: &[(Vec<usize>, bool)]) -> Run {
    let models = trace.modelled.len().min(MODELS.len());
    let at = |i: usize| trace.t_s.get(i).or(trace.t_s.last()).copied().unwrap_or(0.0);
    let factor = |c: usize| scale(quantity(c).unit()).0;
    let column = |rows: &[Signals], c: usize| -> Vec<f64> { rows.iter().map(|s| s[c] * factor(c)).collect() };
    let mut values = Vec::new();
    let mut half = Vec::new();
    let mut open = Vec::new();
    for (channels, _) in groups {
        let mut lines = Vec::new();
        let mut bands = Vec::new();
        let mut gaps = Vec::new();
        for c in channels {
            for (phase, width) in PHASES.iter().zip(&trace.band[*c]) {
                let r = trace.phases.range(*phase);
                if !r.is_empty() && width.is_finite() {
                    bands.push((lines.len(), at(r.start), at(r.end), width * factor(*c)));
                }
            }
            lines.push(column(&trace.measured, *c));
            lines.extend(trace.modelled.iter().take(models).map(|rows| column(rows, *c)));
            let ends: Vec<[f64; 3]> = ends(trace, *c).into_iter().map(|(t, a, b)| [t, a, b]).collect();
            if ends.len() > 1 {
                gaps.push(ends);
            }
        }
        values.push(lines);
        half.push(bands);
        open.push(gaps);
    }
    Run {
        id: trace.trial.clone(),
        role: trace.role.to_owned(),
        words: trace.conditions.clone(),
        t_s: trace.t_s.clone(),
        values,
        spans: spans(&trace.phases, &trace.t_s),
        half,
        open,
        scenery: Some(scenery(trace)),
    }
}

/// The phases of a trial as spans of time.
pub(crate) fn spans(phases: &Phases, t_s: &[f64]) -> Vec<Span> {
    let at = |i: usize| t_s.get(i).or(t_s.last()).copied().unwrap_or(0.0);
    let each = PHASES.iter().zip(SHADE_CLASSES).map(|(p, class)| (phases.range(*p), class, p.label()));
    each.filter(|(r, ..)| !r.is_empty())
        .map(|(r, class, label)| (class, at(r.start), at(r.end), label.into()))
        .collect()
}

/// The bench of a trace.
#[must_use]
pub fn scenery(trace: &Trace) -> Scenery {
    Scenery::new(&trace.bench, &trace.t_s, &trace.measured, &trace.modelled)
}

/// Time and ends of the intervals of an undetermined force, in the unit that is shown.
fn ends(trace: &Trace, channel: usize) -> Vec<(f64, f64, f64)> {
    if channel < 6 {
        return Vec::new();
    }
    let (factor, _) = scale(quantity(channel).unit());
    let all = trace.force_bands.iter();
    all.map(|(t, band)| (*t, band[channel].0 * factor, band[channel].1 * factor))
        .filter(|p| p.1.is_finite() && p.2.is_finite())
        .collect()
}

fn legend(models: &[&str], open: bool) -> Markup {
    html! {
        div class="legend" {
            (swatch("line measured", "measured (sensor offset removed), with its noise floor"))
            @for (k, name) in models.iter().enumerate().take(MODELS.len()) {
                (swatch(&format!("line m{k}"), &format!("model {name}")))
            }
            (swatch("dash", "dashed: finger 2; in the drawing the model"))
            @if open { (swatch("m2", "forces that rigid contact leaves undetermined")) }
            (swatch("rest", "before contact, end"))
            (swatch("none", "sticking"))
            (swatch("onset", "onset"))
            (swatch("sliding", "sliding"))
        }
    }
}

/// The trials to choose from, as a matrix of their conditions.
fn chooser(traces: &[Trace]) -> Markup {
    if traces.len() < 2 {
        return html! {};
    }
    let primitives: BTreeSet<&str> = traces.iter().map(|t| t.primitive.as_str()).collect();
    html! {
        p class="soft" { "Choose a trial: the error of each in noise floors." }
        div class="flow" { @for p in primitives { (matrix(traces, p)) } }
    }
}

/// Trials of one primitive: the variable of most levels across, the others down.
fn matrix(traces: &[Trace], primitive: &str) -> Markup {
    let of: Vec<(usize, &Trace)> =
        traces.iter().enumerate().filter(|(_, t)| t.primitive == primitive).collect();
    let mut levels: BTreeMap<Variable, Vec<String>> = BTreeMap::new();
    for (variable, level) in of.iter().flat_map(|(_, t)| &t.levels) {
        let all = levels.entry(*variable).or_default();
        if !all.contains(level) {
            all.push(level.clone());
        }
    }
    let number = |text: &str| text.parse::<f64>().unwrap_or(f64::NAN);
    for all in levels.values_mut() {
        all.sort_by(|a, b| number(a).total_cmp(&number(b)).then(a.cmp(b)));
    }
    levels.retain(|_, all| all.len() > 1);
    let across = levels.iter().max_by_key(|(_, all)| all.len()).map(|(v, all)| (*v, all.clone()));
    let level = |t: &Trace, v: Variable| {
        t.levels.iter().find(|(k, _)| *k == v).map_or_else(String::new, |(_, l)| l.clone())
    };
    let down: Vec<Variable> =
        levels.keys().copied().filter(|v| Some(*v) != across.as_ref().map(|a| a.0)).collect();
    let row = |t: &Trace| down.iter().map(|v| level(t, *v)).collect::<Vec<_>>();
    let mut rows: Vec<Vec<String>> = of.iter().map(|(_, t)| row(t)).collect();
    rows.sort_by(|a, b| {
        let pairs = a.iter().zip(b);
        pairs
            .map(|(a, b)| number(a).total_cmp(&number(b)).then(a.cmp(b)))
            .find(|o| o.is_ne())
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    rows.dedup();
    let columns = across.as_ref().map_or_else(|| vec![String::new()], |a| a.1.clone());
    let cells = |r: &[String], c: &str| -> Vec<(usize, &Trace)> {
        let here = |t: &Trace| row(t) == r && across.as_ref().is_none_or(|(v, _)| level(t, *v) == *c);
        of.iter().copied().filter(|(_, t)| here(t)).collect()
    };
    html! {
        div class="scroll" {
            table class="heat" {
                caption { (primitive.replace('_', " ")) @if let Some((v, _)) = &across { ": " (v.label()) " across" } }
                thead {
                    tr {
                        @for v in &down { th scope="col" class="level" { (v.label()) } }
                        @if down.is_empty() { th scope="col" class="level" { "condition" } }
                        @for c in &columns { th scope="col" { (if c.is_empty() { "–" } else { c }) } }
                    }
                }
                tbody {
                    @for r in &rows {
                        tr {
                            @for l in r { th scope="row" class="level" { (l) } }
                            @if r.is_empty() { th scope="row" class="level" { "all" } }
                            @for c in &columns { (cell(&cells(r, c))) }
                        }
                    }
                }
            }
        }
    }
}

fn cell(trials: &[(usize, &Trace)]) -> Markup {
    let worst = trials.iter().filter_map(|(_, t)| t.multiples).fold(0.0, f64::max);
    html! {
        @if trials.is_empty() { td class="soft" { "–" } }
        @else {
            td style=(heat(worst)) {
                @for (k, t) in trials {
                    button type="button" data-run=(k) aria-pressed="false" aria-label=(cell_words(t)) {
                        (t.multiples.map_or_else(|| "show".to_owned(), times))
                    }
                }
            }
        }
    }
}

/// A cell without its rows' and columns' headings.
fn cell_words(t: &Trace) -> String {
    let error = t.multiples.map_or_else(String::new, |m| format!("{m:.1} noise floors, "));
    format!("{error}{}{}{}", t.role, if t.role.is_empty() { "" } else { ": " }, t.conditions)
}

/// The bench and the plots of each trace as files, as the page has them: both fingers on the same axes.
#[must_use]
pub fn trace_figures(traces: &[Trace], models: &[&str]) -> Vec<Figure> {
    let groups = groups(traces, &[], None);
    let of = |trace: &Trace| {
        let name = |what: &str| format!("{} {what}", trace.trial);
        let scenery = scenery(trace);
        let bench = scenery
            .is_seen()
            .then(|| Figure::new(&name("bench"), scenery.svg(scenery.farthest()).into_string()));
        let each = groups.iter().map(|(channels, first)| {
            let plot = one_plot(channels, *first, models);
            Figure::of(&name(&plot.title), &figure_of(trace, &plot, channels))
        });
        bench.into_iter().chain(each).collect::<Vec<_>>()
    };
    traces.iter().flat_map(of).collect()
}

/// A plot of a trace as a file, with a legend; the second finger's lines are dashed.
fn figure_of(trace: &Trace, plot: &Plot, channels: &[usize]) -> Chart {
    let mut drawn = chart(trace, channels[0]);
    (drawn.size, drawn.y_label) = ((560, 260), format!("{}, {}", plot.title, plot.unit));
    for channel in &channels[1..] {
        let other = chart(trace, *channel);
        drawn.dashed.extend(other.lines);
        drawn.bands.extend(other.bands);
        drawn.least_span = drawn.least_span.max(other.least_span);
    }
    let lines = drawn.lines.iter().chain(&drawn.dashed).zip(&plot.lines);
    let key = |(drawn, line): (&plot::Line, &viewer::Line)| {
        Key::of_line(line.label.clone(), drawn.colour, line.dash)
    };
    drawn.legend = lines.map(key).collect();
    let last = MODELS.into_iter().take(trace.modelled.len()).next_back();
    for (colour, what) in [(last, "noise floor"), (Some(OPEN), "left undetermined by rigid contact")] {
        if let Some(colour) = colour.filter(|colour| drawn.bands.iter().any(|band| band.1 == *colour)) {
            drawn.legend.push(Key::Band(what.to_owned(), colour));
        }
    }
    viewer::explain_shades(&mut drawn);
    drawn
}

/// Of traces `of` which something holds, the place of that in which model `model` misses `value` most in a phase,
/// forces that rigid contact leaves open included.
pub(crate) fn worst(
    traces: &[Trace],
    model: usize,
    phase: Phase,
    value: &dyn Fn(&Signals) -> f64,
    of: &dyn Fn(&Trace) -> bool,
) -> Option<usize> {
    let missed = |trace: &Trace| {
        let range = trace.phases.range(phase);
        let both = trace.modelled.get(model)?.iter().zip(&trace.measured).take(range.end).skip(range.start);
        let squares: Vec<f64> =
            both.map(|(a, b)| (value(a) - value(b)).powi(2)).filter(|x| x.is_finite()).collect();
        let count = squares.len() as f64;
        (count > 0.0).then(|| squares.iter().sum::<f64>() / count)
    };
    let all = traces.iter().enumerate().filter(|(_, t)| of(t));
    let all = all.filter_map(|(k, t)| Some((k, missed(t)?)));
    all.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k)
}

/// Charts of `channels` in two columns, as one SVG on white: for documents that are no page of ours.
pub fn picture(trace: &Trace, channels: &[usize]) -> String {
    const TITLE: u32 = 22;
    let (wide, high) = (SIZE.0 + 10, SIZE.1 + TITLE);
    let rows = u32::try_from(channels.len().div_ceil(2)).unwrap_or(1);
    let (width, height) = (2 * wide, rows * high);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
    );
    for (place, channel) in (0u32..).zip(channels) {
        let (x, y) = ((place % 2) * wide, (place / 2) * high);
        let (_, unit) = scale(quantity(*channel).unit());
        out += &format!(
            "<text x=\"{}\" y=\"{}\" font-family=\"sans-serif\" font-size=\"13\">{}, {unit}</text>\n<svg x=\"{x}\" y=\"{}\" width=\"{}\" height=\"{}\" {}\n",
            x + 12,
            y + 16,
            channel_words(NAMES[*channel]),
            y + TITLE,
            SIZE.0,
            SIZE.1,
            chart(trace, *channel).svg().trim_start_matches("<svg ")
        );
    }
    out + "</svg>\n"
}

/// The channel as measured and as modelled, with bands and phases.
pub fn chart(trace: &Trace, channel: usize) -> Chart {
    let (factor, _) = scale(quantity(channel).unit());
    let t = &trace.t_s;
    let column = |rows: &[Signals]| -> Vec<f64> { rows.iter().map(|s| s[channel] * factor).collect() };
    let at = |i: usize| t.get(i).or(t.last()).copied().unwrap_or(0.0);
    let mut chart =
        Chart { size: SIZE, x_label: "time, s".into(), x: (at(0), at(usize::MAX)), ..Chart::default() };
    let measured = column(&trace.measured);
    chart.lines.push(plot::Line { points: thinned(t, &measured, POINTS), colour: MEASURED, width: 1 });
    let open = ends(trace, channel);
    if open.len() > 1 {
        chart.bands.push((open, OPEN));
    }
    let mut widest = 0.0f64;
    for (k, (rows, colour)) in trace.modelled.iter().zip(MODELS).enumerate() {
        let values = column(rows);
        let points = thinned(t, &values, POINTS);
        if k + 1 == trace.modelled.len() {
            for phase in PHASES {
                let r = trace.phases.range(phase);
                let half = trace.band[channel][phase as usize] * factor;
                if r.is_empty() || !half.is_finite() {
                    continue;
                }
                widest = widest.max(half);
                let (from, to) = (at(r.start), at(r.end));
                let piece: Vec<(f64, f64, f64)> = points
                    .iter()
                    .filter(|p| p.0 >= from && p.0 <= to && p.1.is_finite())
                    .map(|p| (p.0, p.1 - half, p.1 + half))
                    .collect();
                if piece.len() > 1 {
                    chart.bands.push((piece, colour));
                }
            }
        }
        chart.lines.push(plot::Line { points, colour, width: 2 });
    }
    // Noise alone shall not fill the chart.
    chart.least_span = 6.0 * widest;
    let phases = PHASES.iter().zip(SHADE_CLASSES).map(|(phase, class)| (trace.phases.range(*phase), class));
    viewer::shade(
        &mut chart,
        phases.filter(|(r, _)| !r.is_empty()).map(|(r, class)| (class, at(r.start), at(r.end))),
    );
    chart
}
