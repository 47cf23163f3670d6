//! The layout that every page shares: head, style sheet, first screen, tables that unfold.
//!
//! Pages are made with maud, which escapes text. Nothing is fetched: style, script and data are inside.
//! Elements in `<main>` are all closed, so that a page can be read as XML.

use maud::{DOCTYPE, Markup, PreEscaped, html};
use stickslip_analysis::left_out::{self, LeftOut};
use stickslip_analysis::tuning::{Changed, in_words};

const STYLE: &str = include_str!("../assets/page.css");
const SCRIPT: &str = include_str!("../assets/page.js");
const UPLOT: &str = include_str!("../assets/uplot.min.js");
const UPLOT_STYLE: &str = include_str!("../assets/uplot.min.css");
const UPLOT_LICENCE: &str = include_str!("../assets/uplot-LICENSE.txt");

/// Text made safe for HTML.
pub fn escape(text: &str) -> String {
    html! { (text) }.into_string()
}

/// A whole page around the content of its `<main>`.
#[allow(clippy::needless_pass_by_value)]
pub fn page(title: &str, body: Markup) -> String {
    // Only pages with traces carry the plotting script.
    let plots = body.0.contains(VIEWER);
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                @if plots { style { (PreEscaped(UPLOT_STYLE)) } }
                style { (PreEscaped(STYLE)) }
            }
            body {
                a class="skip" href="#content" { "Skip to the content" }
                main { div id="content" tabindex="-1" { (body) } }
                footer { "Made by stickslip " (env!("CARGO_PKG_VERSION")) ". This page needs no network." }
                @if plots {
                    script { (PreEscaped(format!("/*\nuPlot 1.6.32\n{UPLOT_LICENCE}*/\n{}", uplot()))) }
                }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
    .into_string()
}

/// Class of an element in which the script draws traces.
pub const VIEWER: &str = "class=\"viewer\"";

/// The script without the address in its first line: a page names nothing outside.
fn uplot() -> String {
    UPLOT.replace("https://", "")
}

/// How a verdict is coloured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// Nothing to do.
    Good,
    /// To be looked at.
    Fair,
    /// Wrong.
    Bad,
    /// Neither.
    Plain,
}

impl Tone {
    fn class(self) -> &'static str {
        match self {
            Tone::Good => "verdict good",
            Tone::Fair => "verdict fair",
            Tone::Bad => "verdict bad",
            Tone::Plain => "verdict",
        }
    }
}

/// What a reader sees first: the verdict in a sentence, a picture of it, the command that comes next.
pub fn first_screen(
    (command, name): (&str, &str),
    (tone, sentence): (Tone, &str),
    picture: &Markup,
    next: &str,
) -> Markup {
    html! {
        h1 { "stickslip " (command) ": " (name) }
        p class=(tone.class()) { (sentence) }
        (picture)
        @if !next.is_empty() {
            div class="next" {
                b { "Next:" }
                pre { (next) }
                button type="button" class="plain copy" { "Copy" }
                span class="said" aria-live="polite" {}
            }
        }
        "\n"
    }
}

/// Among the facts: which numbers of the predictor are not a board's.
#[must_use]
pub fn tuned(changed: &[Changed]) -> Markup {
    html! { @if !changed.is_empty() { span { "predictor: " b { (in_words(changed)) } } } }
}

/// On the first screen, how many trials of how many a result leaves out, and why; which they are, and what of
/// the data was `refused`, unfolds.
pub fn left_out(trials: &[LeftOut], refused: &[String], all: usize) -> Markup {
    html! {
        @if let Some(sentence) = left_out::sentence(trials, all) {
            details class="left-out" {
                summary { (sentence) }
                ul { @for one in trials { li { (one) } } }
            }
        }
        @if !refused.is_empty() {
            details class="left-out" {
                summary { (refused.len()) " refused in the data; the rest was used" }
                ul { @for one in refused { li { (one) } } }
            }
        }
    }
}

/// Wider drawings are scrolled on a phone, px.
const WIDE: f64 = 420.0;

/// A caption, a unit and a drawing; `words` say to those who cannot see it what it shows.
pub fn figure(caption: &str, unit: &str, words: &str, drawing: &str) -> Markup {
    // Its text would be too small on a phone.
    let width =
        drawing.split_once("viewBox=\"0 0 ").and_then(|(_, rest)| rest.split(' ').next()?.parse().ok());
    let class = if width.is_some_and(|px: f64| px > WIDE) { "chart wide" } else { "chart" };
    let named = format!("role=\"img\" aria-label=\"{}\"", escape(words));
    html! {
        figure {
            figcaption { (caption) span { (unit) } }
            div class=(class) { (PreEscaped(drawing.replacen("role=\"img\"", &named, 1))) }
        }
    }
}

/// What unfolds.
pub fn unfold(summary: &str, body: &Markup) -> Markup {
    html! { details { summary { (summary) } (body) } "\n" }
}

/// A heading and a list; nothing of nothing.
pub fn list(title: &str, items: &[String]) -> Markup {
    html! {
        @if !items.is_empty() {
            h2 { (title) }
            ul { @for item in items { li { (item) } } }
        }
    }
}

/// A line or an area of a legend: the classes of its swatch, and what it means.
pub fn swatch(class: &str, what: &str) -> Markup {
    html! { span { i class=(format!("swatch {class}")) {} (what) } }
}

/// Of a heat map's colour: more would make the numbers on it hard to read.
const STRONGEST: f64 = 0.6;

/// Background of a heat map's cell: the more noise floors, the stronger; none up to 1.
pub fn heat(multiples: f64) -> String {
    // Logarithmic from 1 (nothing) to 30 (full).
    let share = (multiples.max(1.0).ln() / 30f64.ln()).min(1.0);
    format!("background:rgb(213 94 0/{:.2})", STRONGEST * share)
}

/// A page of a sentence, a legend (classes of a swatch, meaning) and figures.
pub fn figures_page(title: &str, sentence: &str, legend: &[(&str, &str)], figures: &[Markup]) -> String {
    page(
        title,
        html! {
            h1 { (title) }
            p class="verdict" { (sentence) }
            div class="legend" { @for (class, what) in legend { (swatch(class, what)) } }
            div class="grid" { @for one in figures { (one) } }
        },
    )
}
