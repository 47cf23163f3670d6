//! What a predictor missed, was late for or warned of in vain: a table whose rows lead to the traces about each.

use maud::{Markup, html};

use super::figures::Figure;
use super::html::{swatch, unfold};
use super::predicted::{Courses, Seen, UTILISATION, courses, lines};
use super::viewer::{Plot, Run, Span, chart_of, viewer};
use super::words::how_early;
use stickslip_analysis::evidence::conditions::in_words;
use stickslip_analysis::score::figures::Outcome;
use stickslip_analysis::score::traces::{Drawn, Shown, Trace};
use stickslip_data::Description;

/// Pieces of trials that a page draws at most, 60 kB each.
pub const MOST: usize = 24;
/// Rows that are shown at first.
const ROWS: usize = 12;

/// The section; nothing where nothing happened. `replay` is the command that shows a trial.
pub fn section(description: &Description, drawn: &Drawn, replay: &dyn Fn(&str) -> String) -> Markup {
    if drawn.shown.is_empty() {
        return html! {};
    }
    let title = match drawn.shown.iter().any(|s| s.case.fails()) {
        true => "What was missed, late or in vain",
        false => "Nothing was missed, late or in vain: examples",
    };
    let (first, more) = drawn.shown.split_at(ROWS.min(drawn.shown.len()));
    let chooser = html! {
        (table(first, replay))
        @if !more.is_empty() { (unfold(&format!("{} more", more.len()), &table(more, replay))) }
    };
    let legend = html! {
        div class="legend" {
            (lines())
            (swatch("dash", "dashed: finger 2"))
            (swatch("event", "what happened, by the measured motion"))
            (swatch("vain", "false alarm"))
        }
    };
    let (plots, runs) = runs(description, drawn);
    if runs.is_empty() {
        return html! { h2 { (title) } (chooser) };
    }
    viewer(title, &legend, &chooser, &plots, &runs)
}

fn table(shown: &[Shown], replay: &dyn Fn(&str) -> String) -> Markup {
    html! {
        div class="scroll" {
            table {
                caption { "Choose one to see it; the command shows the whole trial" }
                thead {
                    tr {
                        th scope="col" { "trial" }
                        @for h in ["warning", "event"] { th scope="col" class="left" { (h) } }
                        th scope="col" { "at, s" }
                        th scope="col" class="left" { "the whole trial" }
                    }
                }
                tbody {
                    @for one in shown {
                        tr {
                            th scope="row" { (one.case.trial) }
                            td class="left" {
                                @match one.trace {
                                    Some(k) => {
                                        button type="button" data-run=(k) data-goto=(UTILISATION) data-at=(format!("{:.3}", one.case.at_s))
                                            aria-pressed="false" aria-label=(format!("{}: {}, {}", one.case.trial, event(one), warning(one))) {
                                            (warning(one))
                                        }
                                    }
                                    None => (warning(one)),
                                }
                            }
                            td class="left" { (event(one)) }
                            td { (format!("{:.3}", one.case.at_s)) }
                            td class="left" { code { (replay(&one.case.trial)) } }
                        }
                    }
                }
            }
        }
    }
}

fn event(one: &Shown) -> String {
    match one.case.outcome {
        Outcome::FalseAlarm => format!("no {}", one.class.kind().name()),
        _ => one.class.name().to_owned(),
    }
}

fn warning(one: &Shown) -> String {
    match one.case.outcome {
        Outcome::InTime(lead) => format!("in time, {}", how_early(lead)),
        Outcome::Late(lead) => format!("late, {}", how_early(lead)),
        Outcome::Missed => "missed".to_owned(),
        Outcome::FalseAlarm => "false alarm".to_owned(),
    }
}

/// The plots, alike for all traces, and each trace's values.
fn runs(description: &Description, drawn: &Drawn) -> (Vec<Plot>, Vec<Run>) {
    let of = |trace: &Trace| {
        let (t_s, samples, predictions) = (&trace.t_s, &trace.samples, &trace.predictions);
        courses(&Seen { description, t_s, samples, predictions, spans: &[] })
    };
    let mut all: Vec<Courses> = drawn.traces.iter().map(of).collect();
    let count = all.first().map_or(0, |c| c.plots.len());
    let in_any = |of: fn(&Courses) -> &Vec<bool>| -> Vec<bool> {
        (0..count).map(|k| all.iter().any(|c| of(c).get(k) == Some(&true))).collect()
    };
    let (known, moves) = (in_any(|c| &c.known), in_any(|c| &c.moves));
    if let Some(first) = all.first_mut() {
        first.plots.iter_mut().zip(&moves).for_each(|(plot, moves)| plot.first &= moves);
    }
    all.iter_mut().for_each(|c| c.keep(&known));
    let plots = all.first().map_or_else(Vec::new, |c| c.plots.clone());
    let runs = all.into_iter().zip(&drawn.traces).enumerate();
    (plots, runs.map(|(k, (courses, trace))| run(trace, spans(drawn, k, trace), courses)).collect())
}

fn run(trace: &Trace, spans: Vec<Span>, courses: Courses) -> Run {
    let [from, to] = [trace.t_s.first(), trace.t_s.last()].map(|t| t.copied().unwrap_or(0.0));
    Run {
        id: trace.info.trial.clone(),
        role: String::new(),
        words: format!("{from:.1} to {to:.1} s; {}", in_words(&trace.info)),
        t_s: trace.t_s.clone(),
        open: vec![Vec::new(); courses.values.len()],
        half: courses.half,
        values: courses.values,
        spans,
        scenery: None,
    }
}

/// What happened in the time of trace `k`, and its false alarms.
fn spans(drawn: &Drawn, k: usize, trace: &Trace) -> Vec<Span> {
    let [from, to] = [trace.t_s.first(), trace.t_s.last()].map(|t| t.copied().unwrap_or(0.0));
    let events = trace.events.iter().filter(|e| e.onset_s <= to && e.end_s >= from).map(|e| {
        let name = format!("{} at {:.3} s", e.kind.name(), e.onset_s);
        ("event", e.onset_s.max(from), e.end_s.min(to), name.into())
    });
    let own = |s: &&Shown| s.trace == Some(k) && s.case.outcome == Outcome::FalseAlarm;
    let vain = drawn.shown.iter().filter(own).map(|s| {
        let name = format!("false alarm of {} at {:.3} s", s.class.kind().name(), s.case.at_s);
        ("vain", s.case.at_s.max(from), s.case.until_s.min(to), name.into())
    });
    events.chain(vain).collect()
}

/// The plots of each trace as files.
pub fn figures(description: &Description, drawn: &Drawn) -> Vec<Figure> {
    let (plots, runs) = runs(description, drawn);
    let of = |(place, run): (usize, &Run)| {
        let each = plots.iter().enumerate();
        each.map(|(k, plot)| {
            Figure::of(&format!("{} {} {}", place + 1, run.id, plot.id), &chart_of(plot, run, k))
        })
        .collect::<Vec<_>>()
    };
    runs.iter().enumerate().flat_map(of).collect()
}
