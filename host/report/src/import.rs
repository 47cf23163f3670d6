//! The page of `stickslip import recording` and `stickslip new`: what physics says of a recording as its mapping
//! explains it, what was assumed of each signal, the clocks that were estimated, and the signals themselves.

use maud::{Markup, html};
use stickslip_analysis::check::Report;
use stickslip_analysis::compare::verdict::readable;
use stickslip_data::Dataset;
use stickslip_data::import::recording::{Import, Offset, Signal};

use crate::html::{Tone, figure, first_screen, list, page as whole, swatch, unfold};
use crate::plot::{Chart, Line, MEASURED, MODELS};
use crate::signals;

/// Trials whose clock is listed or drawn.
const SHOWN: usize = 6;
/// Refused trials and rows that are listed at first.
const LISTED: usize = 6;
/// Time about a contact that is drawn, to each side, s.
const ABOUT_S: f64 = 0.3;
/// A narrower interval would be less than a pixel, s.
const VISIBLE_S: f64 = 4e-4;

/// The whole page of `command`: `next` is what comes next.
#[must_use]
pub fn page(command: &str, import: &Import, report: &Report, next: &str) -> String {
    let Dataset { description, trials, .. } = &import.dataset;
    let shown = signals::first_of_each(trials);
    let (tone, said) = signals::verdict(report);
    let left_out = import.refused.len() + import.bad_rows.len();
    let tone = if tone == Tone::Good && left_out > 0 { Tone::Fair } else { tone };
    let sentence = match tone {
        Tone::Bad => format!("{said} Correct units, axes, signs or clocks in the mapping, and import again."),
        _ => format!(
            "{said} Compare the pictures with your bench: the physics checks do not detect every wrong axis."
        ),
    };
    let refused = |k: &dyn Fn(usize) -> bool| -> Vec<String> {
        let rows = import.bad_rows.iter().map(|(file, row)| {
            let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy();
            format!("{name} line {}: {}", row.line, row.reason)
        });
        let all = import.refused.iter().cloned().chain(rows);
        all.enumerate().filter(|(at, _)| k(*at)).map(|(_, text)| text).collect()
    };
    let body = html! {
        (first_screen((command, &report.name), (tone, &sentence), &signals::picture(description, &import.sensors, &shown), next))
        div class="facts" {
            span { b { (report.trials) } " trials" }
            span { b { (report.samples) } " samples" }
            @if left_out > 0 { span { b { (left_out) } " trials or rows left out" } }
        }
        (list("Physics errors", &signals::findings(report)))
        (signals::suspects(report))
        (assumed(&import.signals))
        @if let Some(line) = noise_line(&import.noise) { p { (line) } }
        p { (order_line(import.in_time_order)) }
        (list("Left out", &refused(&|k| k < LISTED)))
        @if left_out > LISTED {
            (unfold(&format!("{} more", left_out - LISTED), &html! {
                ul { @for text in refused(&|k| k >= LISTED) { li { (text) } } }
            }))
        }
        (tares(import))
        (clocks(&import.offsets))
        (signals::understood(description, &import.sensors, &shown))
    };
    whole(&format!("stickslip {command}: {}", report.name), body)
}

/// What was assumed of each signal.
fn assumed(signals: &[Signal]) -> Markup {
    html! {
        h2 { "What was assumed" }
        div class="scroll" {
            table {
                caption { "Each signal, its columns, and how it came to the base of time" }
                thead {
                    tr {
                        @for h in ["signal", "stream", "columns", "units", "frame", "on the base of time"] {
                            th scope="col" class="left" { (h) }
                        }
                        th scope="col" { "rate" }
                        th scope="col" { "rows with it" }
                    }
                }
                tbody {
                    @for s in signals {
                        tr {
                            th scope="row" { (signal_words(&s.signal)) }
                            td class="left" { (s.stream) }
                            td class="left text" { (s.named_columns()) }
                            td class="left" { (s.units) }
                            td class="left text" { (s.frame) }
                            td class="left text" { (s.base) }
                            td { (format!("{:.0} Hz", s.rate_hz)) }
                            td { (format!("{:.0} %", 100.0 * s.filled)) }
                        }
                    }
                }
            }
        }
    }
}

/// A signal of a mapping, for people.
fn signal_words(signal: &str) -> String {
    match signal {
        "finger1" => "force on finger 1".to_owned(),
        "finger2" => "force on finger 2".to_owned(),
        "pusher" => "force of the pusher".to_owned(),
        "pusher_pose" => "pose of the pusher".to_owned(),
        "object" | "gripper" => format!("pose of the {signal}"),
        other => other.replace('_', " "),
    }
}

/// What `tare_s` took off.
fn tares(import: &Import) -> Markup {
    html! {
        @if !import.tares.is_empty() {
            (unfold(&format!("Tares of {}", signals::counted(import.tares.len(), "signal")), &html! {
                div class="scroll" {
                    table {
                        caption { "Means that were subtracted: force, N, and torque, N mm, along x, y, z" }
                        tbody {
                            @for (trial, signal, [fx, fy, fz, tx, ty, tz]) in &import.tares {
                                tr {
                                    th scope="row" { (trial) ", " (signal_words(signal)) }
                                    @for force in [fx, fy, fz] { td { (format!("{force:.3}")) } }
                                    @for torque in [tx, ty, tz] { td { (format!("{:.2}", 1e3 * torque)) } }
                                }
                            }
                        }
                    }
                }
            }))
        }
    }
}

/// What was taken as the sensors' noise where the mapping states none.
#[must_use]
pub fn noise_line(noise: &[(&str, f64)]) -> Option<String> {
    let units = [("_nm", "N m"), ("_n", "N"), ("_rad", "rad"), ("_m", "m")];
    let each = |(key, value): &(&str, f64)| {
        let (name, unit) = units.iter().find_map(|(end, unit)| Some((key.strip_suffix(end)?, *unit)))?;
        Some(format!("{} {}", name.replace(['_', '.'], " ").replace(" noise", ""), readable(*value, unit)))
    };
    let values: Vec<String> = noise.iter().filter_map(each).collect();
    (!values.is_empty()).then(|| format!("noise, from the data: {}", values.join(", ")))
}

/// In which order the trials are.
#[must_use]
pub fn order_line(in_time_order: bool) -> &'static str {
    if in_time_order {
        "trials in the order of their time stamps"
    } else {
        "trials in the order of their names or of the table, as their time stamps start again: what wears from trial to trial \
         is found only if that is the order of the runs"
    }
}

/// One line for a clock that all trials share, otherwise one for each trial.
#[must_use]
pub fn clock_lines(offsets: &[Offset]) -> Vec<String> {
    let mut streams: Vec<&str> = offsets.iter().map(|offset| offset.stream.as_str()).collect();
    streams.dedup();
    let mut lines = Vec::new();
    for stream in streams {
        let of: Vec<&Offset> = offsets.iter().filter(|offset| offset.stream == stream).collect();
        match of.iter().find(|offset| offset.trials > 1) {
            Some(one) => lines.push(format!(
                "clock of {stream}: {} added, by the contact in {} trials that agree{}",
                interval(one.offset_s, one.uncertainty_s),
                one.trials,
                blurred(one)
            )),
            None => {
                lines.extend(of.iter().take(SHOWN).map(|offset| {
                    let added = interval(offset.offset_s, offset.uncertainty_s);
                    format!(
                        "clock of {stream} in {}: {added} added, by its contact{}",
                        offset.trial,
                        blurred(offset)
                    )
                }));
                if of.len() > SHOWN {
                    lines.push(format!("and {} more trials; --json lists all", of.len() - SHOWN));
                }
            }
        }
    }
    lines
}

/// What correlated noise of the force means for its onset.
fn blurred(offset: &Offset) -> String {
    match 1e3 * offset.blurred_s {
        ms if ms > 0.0 => format!(
            "; the noise of the force is correlated over {ms:.0} ms (interpolated or filtered), so its onset may be early or late by as much"
        ),
        _ => String::new(),
    }
}

fn interval(offset_s: f64, half_s: f64) -> String {
    format!("{offset_s:.4} s \u{b1} {:.1} ms (95 %)", half_s * 1e3)
}

/// Force and way of the object about the contact, by one clock: their corners lie at one time.
fn clocks(offsets: &[Offset]) -> Markup {
    let drawn: Vec<Markup> = offsets
        .iter()
        .filter_map(|offset| Some((offset, offset.contact_s?)))
        .take(SHOWN)
        .map(|(offset, contact_s)| {
            html! {
                (about("force, N", offset, (&offset.force, 1.0), contact_s))
                (about("way in the gripper, mm", offset, (&offset.way, 1e3), contact_s))
            }
        })
        .collect();
    let (at_first, folded) = drawn.split_at(drawn.len().min(1));
    let grid = |some: &[Markup]| html! { div class="grid charts" { @for one in some { (one) } } };
    html! {
        @if !offsets.is_empty() {
            h2 { "Clocks" }
            p {
                "When the object touches, the force rises and the object begins to move in the gripper at one instant: \
                 the corners of both curves lie where the contact is."
            }
            @for line in clock_lines(offsets) { p { (line) "." } }
            div class="legend" {
                (swatch("line measured", "distance from the rest before, by the first stream's clock"))
                (swatch("line m1", "the contact, with the 95 % interval of the clock"))
            }
            (grid(at_first))
            @if !folded.is_empty() {
                (unfold(&signals::counted(folded.len(), "more trial"), &grid(folded)))
            }
        }
    }
}

fn about(name: &str, offset: &Offset, (rows, scale): (&[[f64; 2]], f64), contact_s: f64) -> Markup {
    let half_s = offset.uncertainty_s.max(VISIBLE_S);
    let chart = Chart {
        size: (400, 200),
        x_label: "time, s".to_owned(),
        y_label: name.to_owned(),
        x: (contact_s - ABOUT_S, contact_s + ABOUT_S),
        spans: vec![(contact_s - half_s, contact_s + half_s, MODELS[1], 0.5)],
        lines: vec![Line {
            points: rows.iter().map(|[t, x]| (*t, x * scale)).collect(),
            colour: MEASURED,
            width: 2,
        }],
        ..Chart::default()
    };
    let words = format!("{name}, of {}, about the contact", offset.trial);
    figure(&format!("{}: {name}", offset.trial), "", &words, &chart.svg())
}
