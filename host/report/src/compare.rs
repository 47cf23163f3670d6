//! The page of `stickslip compare`: the verdict, its worst places as bars, the bench and the traces, and the
//! channels and phases that fail; all else unfolds.

use maud::{Markup, html};

use super::bars::{Bars, multiples};
use super::conditions;
use super::figures::Figure;
use super::html::{Tone, figure, first_screen, heat, left_out, page as whole, unfold};
use super::overlay::{chart, plot_id, section, trace_figures, worst as worst_trace};
use super::plot::Chart;
use super::words::{first_sentence, identifier_words, probability, times};
use stickslip_analysis::channels::{COUNT, channel_words};
use stickslip_analysis::compare::document::{Change, Comparison, ErrorRow, Fate, ModelReport, Size, Trace};
use stickslip_analysis::compare::noise::Source;
use stickslip_analysis::compare::rows::{SUSTAINED_S, many_primitives};
use stickslip_analysis::compare::verdict::{place_words, readable, scale};
use stickslip_analysis::evidence::conditions::trimmed;
use stickslip_analysis::evidence::phases::PHASES;

/// Most trials whose signals a page shows; [`stickslip_analysis::compare::Options::drawn`].
pub const DRAWN: usize = 36;
/// Most trials in the table.
const TRIALS: usize = 100;
/// Most bars of the first picture.
const BARS: usize = 6;

/// Which part of the errors a table shows.
type Part<'a> = &'a dyn Fn(&ErrorRow) -> Size;

/// The whole page; `next` is the command that comes next.
pub fn page(comparison: &Comparison, next: &str) -> String {
    let c = comparison;
    let (lead, rest) = first_sentence(&c.summary);
    let names: Vec<&str> = c.models.iter().map(|m| m.name.as_str()).collect();
    let last = c.models.last();
    let seen = html! { (left_out(&c.skipped, &c.refused, c.data.trials + c.skipped.len())) (picture(c)) };
    let body = html! {
        (first_screen(("compare", &c.data.name), (tone(c), lead), &seen, next))
        @if !rest.is_empty() { p { (rest) } }
        (facts(c))
        @if let Some(report) = last {
            (section(&c.traces, &names, &report.errors, None))
            (tables(c))
            @if !c.changes.is_empty() { (changes(c)) }
            (conditions::regions(c))
            (conditions::trends(report))
            (ranking(report))
            (offsets(report))
            (trials(report))
        }
        (unfold("Notes: how to read the figures", &html! { ul { @for note in &c.notes { li { (note) } } } }))
    };
    whole(&format!("stickslip compare: {}", c.data.name), body)
}

fn tone(c: &Comparison) -> Tone {
    match c.models.last().and_then(|m| m.errors.first()) {
        Some(r) if r.fails && r.error.multiples.unwrap_or(0.0) >= 1.5 => Tone::Bad,
        Some(r)
            if r.fails
                || r.noise_source != Source::Repetitions
                || r.error.multiples.is_some_and(|m| m >= 2.0) =>
        {
            Tone::Fair
        }
        Some(_) => Tone::Good,
        None => Tone::Fair,
    }
}

/// Largest errors as bars; where there is no noise floor, the worst channel's course.
fn picture(c: &Comparison) -> Markup {
    let Some(report) = c.models.last() else { return html! {} };
    if let Some(drawn) = worst_bars(c) {
        let two = c.models.len() > 1;
        let words = "largest errors beyond the tolerance, in noise floors";
        return html! {
            @if two {
                div class="legend" {
                    @for (k, m) in [&c.models[0], report].into_iter().enumerate() {
                        (super::html::swatch(&format!("m{k}"), &format!("model {}", m.name)))
                    }
                }
            }
            (figure("Where the model misses most", "", words, &drawn.markup().0))
        };
    }
    let Some((title, unit, drawn)) = worst_course(c) else { return html! {} };
    figure(&title, unit, &title, &drawn.svg())
}

/// The course of the worst channel, with title and unit: the first picture where there is no noise floor.
fn worst_course(c: &Comparison) -> Option<(String, &'static str, Chart)> {
    let (trace, row) = c.traces.first().zip(c.models.last()?.errors.first())?;
    let mut drawn = chart(trace, row.index);
    drawn.size = (820, 220);
    let title = format!("{} in trial {}", channel_words(row.place.channel), trace.trial);
    Some((title, scale(row.unit).1, drawn))
}

fn worst_bars(c: &Comparison) -> Option<Bars> {
    let bars = multiples(worst(c), "error beyond the tolerance, in noise floors", 1.0);
    // Before and after are the first and the last model.
    let ends = c.models.first().zip(c.models.last()).filter(|_| c.models.len() > 1);
    bars.map(|bars| bars.of_series(ends.into_iter().flat_map(|(a, b)| [a.name.clone(), b.name.clone()])))
}

/// The worst channels and phases with their errors in noise floors, before and after where there are two models.
fn worst(c: &Comparison) -> Vec<(String, Vec<f64>)> {
    let Some(report) = c.models.last() else { return Vec::new() };
    let many = !report.errors.is_empty() && many_primitives(&report.errors);
    let mut rows: Vec<(String, Vec<f64>)> = if c.models.len() > 1 {
        let both = |x: &Change| Some(vec![x.before.multiples?, x.after.multiples?]);
        c.changes.iter().filter_map(|x| Some((place_words(&x.place, many), both(x)?))).collect()
    } else {
        // As the verdict names the worst: what fails, worst first; where nothing does, what lasts, then what is a
        // matter of a few samples of timing.
        let of = |r: &&ErrorRow| {
            let brief = r.duration_s < SUSTAINED_S;
            let time = if brief { format!(" (for {:.0} ms)", 1e3 * r.duration_s) } else { String::new() };
            Some((format!("{}{time}", place_words(&r.place, many)), vec![r.error.multiples?]))
        };
        let some = report.errors.iter().any(|r| r.fails);
        let mut rows: Vec<&ErrorRow> = report.errors.iter().filter(|r| r.fails || !some).collect();
        if !some {
            rows.sort_by_key(|r| r.duration_s < SUSTAINED_S);
        }
        rows.iter().filter_map(of).collect()
    };
    if c.models.len() > 1 {
        let most = |v: &[f64]| v.iter().copied().fold(0.0, f64::max);
        rows.sort_by(|a, b| most(&b.1).total_cmp(&most(&a.1)));
    }
    rows.truncate(BARS);
    rows
}

fn facts(c: &Comparison) -> Markup {
    let d = &c.data;
    let floor = match d.noise_floor {
        Source::Repetitions => "scatter of repetitions",
        Source::SensorNoise => "sensor noise only (no repetitions)",
        Source::Unknown => "not known",
    };
    html! {
        div class="facts" {
            span { b { (d.trials) } " trials" }
            span { b { (d.conditions) } " conditions, " (d.repeated_conditions) " repeated" }
            span { "noise floor: " b { (floor) } }
            @if d.held_out { span { b { "held out" } " from calibration" } }
        }
        @for m in &c.models { div class="soft" { "model " b { (m.name) } ": " (describe(m)) } }
    }
}

/// Errors and residuals by channel and phase: the failing channels, the rest folded.
fn tables(c: &Comparison) -> Markup {
    let repeated = c.data.noise_floor == Source::Repetitions;
    let explained = match repeated {
        true => {
            "RMS error beyond the tolerance, in multiples of the noise floor and in units. Bold and coloured: fails. Pale: as \
             chance may give it, or within the floor. A cell leads to its traces in the trial where it is worst."
        }
        false => {
            "RMS error beyond the tolerance, in units: without repetitions there is no noise floor. Bold: beyond the sensors' uncertainty for 0.1 s or longer. A cell leads to its traces in the trial where it is worst."
        }
    };
    html! {
        h2 { "Channels and phases" }
        p class="soft" { (explained) }
        @for (k, m) in c.models.iter().enumerate().rev() {
            @if k + 1 == c.models.len() { (failing(c, k, repeated)) }
            @else {
                (unfold(&format!("Error of model {}", m.name), &matrix(c, k, repeated, &|r| r.error, &|_| true)))
            }
            (unfold(
                &format!("Whole residual of model {}: model minus measurement, noise included (a perfect model: 1\u{d7})", m.name),
                &matrix(c, k, repeated, &|r| r.residual, &|_| true)
            ))
        }
    }
}

fn is_bold(r: &ErrorRow, repeated: bool) -> bool {
    if repeated { r.fails } else { r.sustained == Some(true) }
}

fn failing(c: &Comparison, model: usize, repeated: bool) -> Markup {
    let report = &c.models[model];
    let bold = |index: usize| report.errors.iter().any(|r| r.index == index && is_bold(r, repeated));
    let (some, all) = ((0..COUNT).any(bold), (0..COUNT).all(bold));
    html! {
        @if some { (matrix(c, model, repeated, &|r| r.error, &bold)) } @else { p { "No channel fails." } }
        @if !all {
            (unfold("Channels that fit", &matrix(c, model, repeated, &|r| r.error, &|index| !bold(index))))
        }
    }
}

/// Channels by phases of a model, of the channels that are `wanted`.
fn matrix(c: &Comparison, model: usize, repeated: bool, of: Part, wanted: &dyn Fn(usize) -> bool) -> Markup {
    let report = &c.models[model];
    let worst_of = |r: &ErrorRow| {
        let primitive = |t: &Trace| t.primitive == r.place.primitive;
        worst_trace(&c.traces, model, r.place.phase, &|s| s[r.index], &primitive)
    };
    let many = !report.errors.is_empty() && many_primitives(&report.errors);
    let mut primitives: Vec<&str> = report.errors.iter().map(|r| r.place.primitive.as_str()).collect();
    primitives.sort_unstable();
    primitives.dedup();
    let row = |primitive: &str, channel: usize| -> Vec<&ErrorRow> {
        let of = |r: &&ErrorRow| r.index == channel && r.place.primitive == primitive;
        report.errors.iter().filter(of).collect()
    };
    html! {
        div class="scroll" {
            table class="matrix" {
                caption { "Model " (report.name) }
                thead {
                    tr {
                        th scope="col" class="left" { "channel" }
                        @for phase in PHASES { th scope="col" { (phase.label()) } }
                    }
                }
                tbody {
                    @for primitive in primitives {
                        @for rows in (0..COUNT).filter(|k| wanted(*k)).map(|k| row(primitive, k)) {
                            @if let Some(first) = rows.first() {
                                tr {
                                    th scope="row" {
                                        @if many { (primitive.replace('_', " ")) ": " }
                                        (channel_words(first.place.channel))
                                    }
                                    @for phase in PHASES {
                                        @match rows.iter().find(|r| r.place.phase == phase) {
                                            None => { td class="soft" { "–" } }
                                            Some(r) => { (cell(r, of(r), repeated, worst_of(r))) }
                                        }
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// `run` is the trial that it leads to.
fn cell(r: &ErrorRow, size: Size, repeated: bool, run: Option<usize>) -> Markup {
    let class = if is_bold(r, repeated) { "fails" } else { "fits" };
    let goto = plot_id(r.index);
    let multiples = size.multiples.filter(|_| repeated);
    let inner = html! {
        button type="button" data-run=[run] data-goto=(goto) data-phase=(r.place.phase.label()) {
            @match multiples {
                Some(m) => { (times(m)) small { (readable(size.rms, r.unit)) } }
                None => { (readable(size.rms, r.unit)) }
            }
            @if class == "fails" { span class="said" { " fails" } }
        }
    };
    let fits = class == "fits";
    // Nothing beyond the tolerance is no number.
    if fits && readable(size.rms, r.unit).starts_with("0 ") {
        return html! { td class="soft" { "0" } };
    }
    html! {
        @match multiples {
            // What does not fail does not shout.
            Some(m) => { td class=(class) style=(heat(if fits { m.min(PALE) } else { m })) { (inner) } }
            None => { td class=(class) { (inner) } }
        }
    }
}

/// Cells that do not fail are coloured as this many noise floors at most.
const PALE: f64 = 1.3;

fn changes(c: &Comparison) -> Markup {
    let many = c.models.first().is_some_and(|m| !m.errors.is_empty() && many_primitives(&m.errors));
    let (first, last) = (&c.models[0].name, &c.models[c.models.len() - 1].name);
    let repeated = c.data.noise_floor == Source::Repetitions;
    let cell = |s: &Size, unit: &str| {
        let m = s.multiples.filter(|_| repeated);
        html! {
            @match m {
                Some(m) => { td style=(heat(m)) { (times(m)) small { (readable(s.rms, unit)) } } }
                None => { td { small { (readable(s.rms, unit)) } } }
            }
        }
    };
    let table = |rows: &[&Change]| {
        html! {
            div class="scroll" {
                table {
                    caption { "Errors beyond the tolerance of " (first) ", for both models alike; and the whole residuals" }
                    thead {
                        tr {
                            th scope="col" class="left" { "channel and phase" }
                            th scope="col" { (first) } th scope="col" { (last) }
                            th scope="col" class="left" { "failure" }
                            th scope="col" { "residual, " (first) } th scope="col" { "residual, " (last) }
                        }
                    }
                    tbody {
                        @for x in rows {
                            tr {
                                th scope="row" { (place_words(&x.place, many)) }
                                (cell(&x.before, x.unit)) (cell(&x.after, x.unit))
                                td class="left" { (fate_words(x.fate)) }
                                (cell(&x.residual_before, x.unit)) (cell(&x.residual_after, x.unit))
                            }
                        }
                    }
                }
            }
        }
    };
    let noticed = |x: &&Change| {
        x.fate != Fate::Fits || x.before.multiples.unwrap_or(0.0).max(x.after.multiples.unwrap_or(0.0)) > 2.0
    };
    let shown: Vec<&Change> = c.changes.iter().filter(noticed).collect();
    let (at_first, folded) = shown.split_at(shown.len().min(8));
    html! {
        h2 { "Before and after" }
        (table(at_first))
        @if !folded.is_empty() { (unfold(&format!("{} more", folded.len()), &table(folded))) }
    }
}

/// A table with a heading for each column.
fn table(caption: &str, header: &[&str], rows: &[(bool, Vec<String>)]) -> Markup {
    html! {
        div class="scroll" {
            table {
                caption { (caption) }
                thead { tr { @for h in header { th scope="col" { (h) } } } }
                tbody {
                    @for (bold, cells) in rows {
                        tr class=(if *bold { "fails" } else { "fits" }) {
                            @for (k, cell) in cells.iter().enumerate() {
                                @if k == 0 {
                                    th scope="row" { (cell) @if *bold { span class="said" { " (fails)" } } }
                                } @else { td { (cell) } }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn ranking(report: &ModelReport) -> Markup {
    let many = !report.errors.is_empty() && many_primitives(&report.errors);
    let header = [
        "channel and phase",
        "trials",
        "residual RMS",
        "mean",
        "largest",
        "RMS with offset",
        "mean with offset",
        "error beyond tolerance, RMS",
        "mean",
        "noise floor",
        "residual / floor",
        "error / floor",
        "F",
        "p, corrected",
    ];
    let dash = || "–".to_owned();
    let row = |r: &ErrorRow| {
        let size = |x: f64| readable(x, r.unit);
        let multiples = |s: Size| s.multiples.map_or_else(dash, times);
        let (f, p) = r.lack_of_fit.map_or_else(
            || (dash(), dash()),
            |t| (trimmed(t.f, 3), probability(t.p_corrected).trim_start_matches("= ").to_owned()),
        );
        let cells = vec![
            place_words(&r.place, many),
            r.trials.to_string(),
            size(r.residual.rms),
            size(r.residual.mean),
            size(r.residual.largest),
            size(r.rms_with_offset),
            size(r.bias_with_offset),
            size(r.error.rms),
            size(r.error.mean),
            r.noise_floor.map_or_else(dash, size),
            multiples(r.residual),
            multiples(r.error),
            f,
            p,
        ];
        (r.fails, cells)
    };
    let rows: Vec<_> = report.errors.iter().map(row).collect();
    unfold("All errors, worst first", &table("Residuals and errors", &header, &rows))
}

fn offsets(report: &ModelReport) -> Markup {
    if report.offsets.channels.is_empty() {
        return html! {};
    }
    let rows = report.offsets.channels.iter().map(|o| {
        let bound = if o.stated_bound > 0.0 { readable(o.stated_bound, o.unit) } else { "–".into() };
        let cells =
            vec![channel_words(o.channel), readable(o.mean, o.unit), readable(o.deviation, o.unit), bound];
        (o.beyond_bound, cells)
    });
    let rows: Vec<_> = rows.collect();
    let header = ["channel", "mean", "from trial to trial", "stated bound"];
    unfold("Sensor offsets", &table("Measurement minus model before contact", &header, &rows))
}

fn trials(report: &ModelReport) -> Markup {
    let mut rows: Vec<_> = report.trials.iter().collect();
    rows.sort_by(|a, b| b.multiples.unwrap_or(0.0).total_cmp(&a.multiples.unwrap_or(0.0)));
    let title = match rows.len() {
        n if n > TRIALS => format!("Trials, worst first (the worst {TRIALS} of {n})"),
        _ => "Trials, worst first".to_owned(),
    };
    let rows: Vec<_> = rows
        .into_iter()
        .take(TRIALS)
        .map(|t| {
            let time = |phase: &str| {
                let known = t.phases.get(phase).filter(|p| p[1] > p[0]);
                known.map_or_else(|| "–".to_owned(), |p| format!("{:.3}", p[0]))
            };
            let cells = vec![
                t.trial.clone(),
                t.multiples.map_or_else(|| "–".into(), times),
                t.worst.as_ref().map_or_else(|| "–".into(), |w| place_words(w, false)),
                time("sticking"),
                time("sliding"),
                t.unsolved_steps.to_string(),
            ];
            (false, cells)
        })
        .collect();
    let header = ["trial", "error / floor", "worst in", "contact, s", "sliding, s", "unsolved steps"];
    unfold(&title, &table("Trials", &header, &rows))
}

/// Origin and parameters of a model.
pub fn describe(report: &ModelReport) -> String {
    let each = report.friction.iter().map(|(k, v)| {
        let open = if report.only_bounded.contains(k) { " (only bounded)" } else { "" };
        format!("{} {v:.3}{open}", k.replace(['_', '.'], " "))
    });
    let friction: Vec<String> = each.collect();
    let effects: Vec<String> = report.effects.iter().map(|id| identifier_words(id)).collect();
    let effects = if effects.is_empty() { "no effects".to_owned() } else { effects.join(", ") };
    let open = report
        .open_force_n
        .map_or_else(String::new, |n| format!("; leaves forces open by {} on average", readable(n, "N")));
    format!("{}; friction {}; {effects}{open}", report.origin, friction.join(", "))
}

/// What became of a failure, for people.
pub fn fate_words(fate: Fate) -> &'static str {
    match fate {
        Fate::Gone => "gone",
        Fate::Unclear => "same size, significant in one only",
        Fate::Smaller => "smaller, still fails",
        Fate::Remains => "still fails",
        Fate::Larger => "larger, still fails",
        Fate::New => "new failure",
        Fate::Fits => "",
    }
}

/// Every plot of the page.
#[must_use]
pub fn figures(c: &Comparison) -> Vec<Figure> {
    let mut out = Vec::new();
    match worst_bars(c) {
        Some(bars) => out.push(Figure::of("worst-places", &bars.chart())),
        None => out.extend(worst_course(c).map(|(_, _, chart)| Figure::of("worst-place", &chart))),
    }
    let names: Vec<&str> = c.models.iter().map(|m| m.name.as_str()).collect();
    out.extend(trace_figures(&c.traces, &names));
    out.extend(c.models.last().iter().flat_map(|report| conditions::figures(report)));
    out
}
