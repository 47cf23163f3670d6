//! What the errors of a comparison depend on: heat maps over pairs of conditions, and trends.

use maud::{Markup, html};

use crate::figures::Figure;
use crate::html::{figure, heat, unfold};
use crate::overlay::{plot_id, worst as worst_trace};
use crate::plot::{Chart, Line, MEASURED, MODELS};
use crate::words::{probability, times};
use stickslip_analysis::channels::NAMES;
use stickslip_analysis::compare::document::{Comparison, ModelReport, Region, Trace, Trend};
use stickslip_analysis::compare::rows::many_primitives;
use stickslip_analysis::compare::verdict::{place_words, scale};
use stickslip_analysis::evidence::conditions::Variable;

/// Most trends that are drawn.
const TRENDS: usize = 9;

/// Heat maps of the worst places over pairs of conditions; a cell leads to its traces.
pub(crate) fn regions(c: &Comparison) -> Markup {
    let Some(report) = c.models.last() else { return html! {} };
    let many = !report.errors.is_empty() && many_primitives(&report.errors);
    let mut places: Vec<(String, Vec<&Region>)> = Vec::new();
    for region in &report.regions {
        let label = place_words(&region.place, many);
        match places.last_mut().filter(|p| p.0 == label) {
            Some(place) => place.1.push(region),
            None => places.push((label, vec![region])),
        }
    }
    let maps =
        |regions: &[&Region]| html! { div class="flow" { @for r in regions { (heat_map(r, &c.traces)) } } };
    html! {
        @if let Some(((label, regions), folded)) = places.split_first() {
            h2 { "Where in the conditions" }
            p class="soft" { "RMS error beyond the tolerance, in noise floors, over pairs of conditions. Worst: " b { (label) } ". A cell leads to its traces." }
            (maps(regions))
            @for (label, regions) in folded { (unfold(label, &maps(regions))) }
        }
    }
}

fn heat_map(region: &Region, traces: &[Trace]) -> Markup {
    let channel = NAMES.iter().position(|name| *name == region.place.channel);
    // Of the trials that are drawn under both conditions the one in which the last model misses most.
    let run = |x: &str, y: &str| {
        let (channel, model) = (channel?, traces.first()?.modelled.len().checked_sub(1)?);
        let level = |t: &Trace, v: Variable, level: &str| t.levels.iter().any(|(k, l)| *k == v && l == level);
        let here = |t: &Trace| {
            t.primitive == region.place.primitive && level(t, region.x, x) && level(t, region.y, y)
        };
        worst_trace(traces, model, region.place.phase, &|s| s[channel], &here)
    };
    let phase = region.place.phase.label();
    html! {
        div class="scroll" {
            table class="heat" {
                caption { (region.x.label()) " across" }
                thead {
                    tr {
                        th scope="col" class="level" { (region.y.label()) }
                        @for x in &region.x_levels { th scope="col" { (if x.is_empty() { "–" } else { x }) } }
                    }
                }
                tbody {
                    @for (y, row) in region.y_levels.iter().zip(&region.multiples) {
                        tr {
                            th scope="row" class="level" { (y) }
                            @for (x, m) in region.x_levels.iter().zip(row) {
                                @match (m, run(x, y)) {
                                    (None, _) => { td class="soft" { "–" } }
                                    (Some(m), None) => { td style=(heat(*m)) { (times(*m)) } }
                                    (Some(m), Some(run)) => { td style=(heat(*m)) {
                                        button type="button" data-run=(run) data-goto=[channel.map(plot_id)] data-phase=(phase) {
                                            (times(*m))
                                        }
                                    } }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Trends of the mean error with a condition.
pub(crate) fn trends(report: &ModelReport) -> Markup {
    let many = !report.errors.is_empty() && many_primitives(&report.errors);
    let words = format!(
        "{} of {} trends are significant (corrected p below 0.05). Dots: mean error of each condition (order: of each \
         run, less the mean of its repetitions).",
        report.trends.len(),
        report.trends_tested
    );
    let drawn: Vec<Markup> = report.trends.iter().take(TRENDS).map(|t| trend(t, report, many)).collect();
    let (at_first, folded) = drawn.split_at(drawn.len().min(3));
    let grid = |some: &[Markup]| html! { div class="grid charts" { @for one in some { (one) } } };
    html! {
        @if !report.trends.is_empty() {
            h2 { "What the mean error depends on" }
            p class="soft" { (words) }
            (grid(at_first))
            @if !folded.is_empty() { (unfold(&format!("{} more", folded.len()), &grid(folded))) }
        }
    }
}

/// A trend as a chart.
fn trend_chart(t: &Trend, report: &ModelReport) -> Chart {
    let unit = report.errors.iter().find(|r| r.place == t.place).map_or("N", |r| r.unit);
    let (factor, shown) = scale(unit);
    let x = |v: f64| if t.variable == Variable::Order { v } else { t.variable.shown(v) };
    let ends = [f64::INFINITY, f64::NEG_INFINITY];
    let low = t.points.iter().map(|p| p.0).fold(ends[0], f64::min);
    let high = t.points.iter().map(|p| p.0).fold(ends[1], f64::max);
    let on_line = |v: f64| (x(v), (t.intercept + t.slope * v) * factor);
    Chart {
        size: (360, 190),
        x_label: t.variable.label().into(),
        y_label: format!("mean error, {shown}"),
        lines: vec![Line { points: vec![on_line(low), on_line(high)], colour: MODELS[0], width: 2 }],
        dots: t.points.iter().map(|p| (x(p.0), p.1 * factor, MEASURED)).collect(),
        ..Chart::default()
    }
}

fn trend(t: &Trend, report: &ModelReport, many: bool) -> Markup {
    let span = t.span_multiples.map_or_else(String::new, |m| format!("{} over the range, ", times(m.abs())));
    let title = place_words(&t.place, many);
    let way = t.span_multiples.map_or_else(String::new, |m| {
        format!(": {} by {:.1} noise floors over the range", if m < 0.0 { "falls" } else { "rises" }, m.abs())
    });
    let words = format!("{title} against {}{way}", t.variable.label());
    figure(&title, &format!("{span}p {}", probability(t.p_corrected)), &words, &trend_chart(t, report).svg())
}

/// Each trend that the page draws.
pub(crate) fn figures(report: &ModelReport) -> Vec<Figure> {
    let each = report.trends.iter().take(TRENDS).enumerate().map(|(k, t)| {
        let name = format!("trend-{}-{}-{}", k + 1, place_words(&t.place, false), t.variable.label());
        Figure::of(&name, &trend_chart(t, report))
    });
    each.collect()
}
