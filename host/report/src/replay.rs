//! The page of `stickslip replay`: when flags are up, the bench, and the predictions over time.

use maud::{Markup, html};

use super::bench::Scenery;
use super::figures::Figure;
use super::html::{Tone, figure, first_screen, page as whole, swatch, tuned, unfold};
use super::overlay::spans;
use super::plot::{Chart, Line, MODELS};
use super::predicted::{Courses, Seen, courses as courses_of, lines};
use super::viewer::{Plot, Run, Span, chart_of, viewer};
use stickslip_analysis::compare::noise::sensor_noise;
use stickslip_analysis::evidence::phases::split;
use stickslip_analysis::run::bench::Bench;
use stickslip_analysis::run::replay::FLAGS;
use stickslip_analysis::run::simulate::{Prepared, Simulated};
use stickslip_analysis::run::summary::Document;
use stickslip_data::{Description, Sample};
use stickslip_shared::predictor::Prediction;

/// What a page shows beside the document.
pub struct Shown<'a> {
    /// What dataset.toml says of the sensors.
    pub description: &'a Description,
    /// Time stamps of the predictions.
    pub t_s: &'a [f64],
    /// What was measured, one for each time stamp.
    pub samples: &'a [Sample],
    /// One for each time stamp.
    pub predictions: &'a [Prediction],
    /// The bodies; `None`: not drawn.
    pub scenery: Option<Scenery>,
    /// Phases of the trial.
    pub spans: Vec<Span>,
    /// The command that comes next.
    pub next: &'a str,
}

/// The bodies and the phases of a trial with the model run along it.
#[must_use]
pub fn drawn(
    description: &Description,
    prepared: &Prepared,
    simulated: &Simulated,
) -> (Option<Scenery>, Vec<Span>) {
    let phases = split(prepared, simulated, &sensor_noise(description));
    let modelled = std::slice::from_ref(&simulated.signals);
    let bench = Bench::of(prepared);
    let scenery = Scenery::new(&bench, &prepared.t_s, &prepared.measured, modelled);
    (Some(scenery), spans(&phases, &prepared.t_s))
}

/// The whole page.
pub fn page(document: &Document, shown: &Shown) -> String {
    let sentence = sentence(document);
    let warned = document.prediction.first_slip_s.is_some() || document.prediction.first_warning_s.is_some();
    let tone = if warned { Tone::Fair } else { Tone::Good };
    let flags = flag_chart(document, shown.t_s);
    let picture = match &flags {
        Some(chart) => figure("Flags", "", &flags_in_words(document), &chart.svg()),
        None => html! { p { "No flag rose." } },
    };
    let body = html! {
        (first_screen(("replay", &document.trial), (tone, &sentence), &picture, shown.next))
        div class="facts" {
            span { b { (document.ticks) } " ticks" }
            span { "hash " b { (document.hash) } }
            (tuned(&document.tuned))
        }
        (flag_table(document))
        (predictions(document, shown))
    };
    whole(&format!("stickslip replay: {}", document.trial), body)
}

/// Spans of flags that a drawing's words have; the table has all.
const SPANS_SAID: usize = 8;

fn flags_in_words(document: &Document) -> String {
    let span = |s: &stickslip_analysis::run::replay::Span| match s.falls_s {
        Some(falls_s) => format!("{} from {:.3} to {falls_s:.3} s", s.flag, s.rises_s),
        None => format!("{} from {:.3} s on", s.flag, s.rises_s),
    };
    let said: Vec<String> = document.flags.iter().take(SPANS_SAID).map(span).collect();
    let more = document.flags.len().saturating_sub(SPANS_SAID);
    let more = if more > 0 { format!("; {more} more in the table") } else { String::new() };
    format!("when each flag of the prediction is up: {}{more}", said.join("; "))
}

/// When each flag was up: what the drawing shows, for those who cannot see it.
fn flag_table(document: &Document) -> Markup {
    let spans = || document.flags.iter().chain(&document.doubts);
    let rows = html! {
        div class="scroll" {
            table {
                caption { "When each flag is up" }
                thead { tr { th scope="col" { "flag" } th scope="col" { "rises, s" } th scope="col" { "falls, s" } } }
                tbody {
                    @for span in spans() {
                        tr {
                            th scope="row" { (span.flag) }
                            td { (format!("{:.3}", span.rises_s)) }
                            td { @match span.falls_s { Some(s) => { (format!("{s:.3}")) } None => "–" } }
                        }
                    }
                }
            }
        }
    };
    html! { @if spans().next().is_some() { (unfold("Flags as a table", &rows)) } }
}

/// What was predicted, in a sentence.
#[must_use]
pub fn sentence(document: &Document) -> String {
    let p = &document.prediction;
    let slip = match (p.first_warning_s, p.first_slip_s) {
        (Some(warning), Some(slip)) if warning < slip => {
            format!("Slip is announced at {warning:.3} s and begins at {slip:.3} s")
        }
        (_, Some(slip)) => format!("Slip begins at {slip:.3} s without a warning before it"),
        (Some(warning), None) => format!("Slip is announced at {warning:.3} s and does not come"),
        (None, None) => "No slip is predicted".to_owned(),
    };
    format!(
        "{slip}; the object sags by at most {:.2} mm and turns by at most {:.1} mrad in the grasp.",
        p.peak_sag_m * 1e3,
        p.peak_rotation_rad * 1e3
    )
}

/// The plots, and the trial's values.
fn courses(document: &Document, shown: &Shown) -> (Vec<Plot>, Run) {
    let seen = Seen {
        description: shown.description,
        t_s: shown.t_s,
        samples: shown.samples,
        predictions: shown.predictions,
        spans: &shown.spans,
    };
    let mut all = courses_of(&seen);
    all.keep(&all.known.clone());
    let Courses { mut plots, values, half, moves, .. } = all;
    // A row of zeros says nothing at first.
    plots.iter_mut().zip(&moves).for_each(|(plot, moves)| plot.first &= moves);
    let run = Run {
        id: document.trial.clone(),
        role: String::new(),
        words: format!("{} ticks", document.ticks),
        t_s: shown.t_s.to_vec(),
        half,
        open: vec![Vec::new(); values.len()],
        values,
        spans: shown.spans.clone(),
        scenery: shown.scenery.clone(),
    };
    (plots, run)
}

fn predictions(document: &Document, shown: &Shown) -> Markup {
    let (plots, run) = courses(document, shown);
    let legend = html! {
        div class="legend" {
            (lines())
            (swatch("dash", "dashed: finger 2; in the drawing the model"))
            @if !run.spans.is_empty() {
                (swatch("rest", "before contact, end"))
                (swatch("onset", "onset"))
                (swatch("sliding", "sliding"))
            }
        }
    };
    viewer("Predictions", &legend, &html! {}, &plots, &[run])
}

/// A row for each flag that was ever up; `None` where none was.
fn flag_chart(document: &Document, t_s: &[f64]) -> Option<Chart> {
    let up = |f: &&str| document.flags.iter().any(|s| s.flag == *f);
    let rows: Vec<&str> = FLAGS.iter().rev().copied().filter(up).collect();
    if rows.is_empty() {
        return None;
    }
    let ends = (t_s.first().copied().unwrap_or(0.0), t_s.last().copied().unwrap_or(1.0));
    let lines = document.flags.iter().filter_map(|s| {
        let row = rows.iter().position(|r| *r == s.flag)? as f64;
        let points = vec![(s.rises_s, row), (s.falls_s.unwrap_or(ends.1), row)];
        Some(Line { points, colour: MODELS[0], width: 7 })
    });
    Some(Chart {
        size: (640, 60 + 26 * rows.len() as u32),
        x_label: "time, s".into(),
        x: ends,
        least_span: rows.len() as f64,
        lines: lines.collect(),
        y_names: rows.iter().map(|r| (*r).to_owned()).collect(),
        ..Chart::default()
    })
}

/// Every plot of the page.
#[must_use]
pub fn figures(document: &Document, shown: &Shown) -> Vec<Figure> {
    let mut out: Vec<Figure> =
        flag_chart(document, shown.t_s).iter().map(|c| Figure::of("flags", c)).collect();
    let (plots, run) = courses(document, shown);
    out.extend(
        run.scenery
            .iter()
            .filter(|s| s.is_seen())
            .map(|s| Figure::new("bench", s.svg(s.farthest()).into_string())),
    );
    out.extend(plots.iter().enumerate().map(|(k, plot)| Figure::of(&plot.id, &chart_of(plot, &run, k))));
    out
}
