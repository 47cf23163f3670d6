//! The page of `stickslip score`: which events were warned of in time, the table, how lead times are spread.

use maud::{Markup, html};

use super::bars::{Bars, shares};
use super::figures::Figure;
use super::html::{Tone, figure, first_screen, page as whole, swatch, tuned, unfold};
use super::plot::{Chart, Key, Line, MEASURED, MODELS};
pub use super::warned::MOST;
use super::warned::{self, section};
use super::words::how_early;
use stickslip_analysis::score::ObjectPose;
use stickslip_analysis::score::calibration::Calibration;
use stickslip_analysis::score::document::Document;
use stickslip_analysis::score::figures::{Class, Row};
use stickslip_analysis::score::rate::Rate;
use stickslip_analysis::score::traces::Drawn;
use stickslip_data::Description;

const SIZE: (u32, u32) = (400, 220);

/// What the page draws of trials, and what dataset.toml says of the sensors.
pub struct Seen<'a> {
    /// Of the data set.
    pub description: &'a Description,
    /// Cases and traces, at most [`MOST`] of these.
    pub drawn: &'a Drawn,
}

/// The whole page; `next` is the command that comes next, `replay` that which shows a trial.
pub fn page(d: &Document, seen: &Seen, next: &str, replay: &dyn Fn(&str) -> String) -> String {
    let picture = match in_time_chart(d) {
        Some(chart) => {
            figure("Events that were warned of in time", "", "share of events in time", &chart.markup().0)
        }
        None => html! {},
    };
    let name = d.data.display().to_string();
    let (tone, sentence) = verdict(d);
    let facts = html! {
        div class="facts" {
            span { b { (d.trials) } " trials" }
            span { b { (time(d.hours)) } }
            span {
                "object's pose: "
                b { (match d.object_pose { ObjectPose::Every => "in every sample", ObjectPose::Start => "at the start only" }) }
            }
            @if !d.passed_over.is_empty() { span { "not scored: " b { (d.passed_over.len()) } " trials" } }
            span { "sample not trusted: " b { (format!("{:.2} %", d.doubtful_share * 100.0)) } " of the ticks" }
            (tuned(&d.tuned))
        }
    };
    let leads: Vec<Markup> = lead_charts(d)
        .iter()
        .map(|Leads { title, rows, chart }| {
            html! {
                div {
                    div class="legend" {
                        @for (k, r) in rows.iter().enumerate() { (swatch(&format!("line m{k}"), &r.method)) }
                    }
                    (figure(title, "", &lead_words(title, rows), &chart.svg()))
                }
            }
        })
        .collect();
    let stated: Vec<Markup> = stated_charts(d)
        .iter()
        .map(|(title, chart)| figure(title, "", &format!("{title}: stated against actual"), &chart.svg()))
        .collect();
    let body = html! {
        (first_screen(("score", &name), (tone, &sentence), &picture, next))
        (facts)
        (section(seen.description, seen.drawn, replay))
        h2 { "Events and alarms" }
        (table(d))
        @if !leads.is_empty() {
            h2 { "Lead times: share of events warned at least this long ahead" }
            div class="grid charts" { @for one in &leads { (one) } }
        }
        @if !stated.is_empty() {
            (unfold("Stated against actual values", &html! { div class="grid charts" { @for one in &stated { (one) } } }))
        }
    };
    whole("stickslip score", body)
}

/// The predictor's rows of events that there were.
fn ours(d: &Document) -> impl Iterator<Item = &Row> {
    d.rows.iter().filter(|r| r.events > 0 && d.is_own(r))
}

/// The predictor's false alarms of each kind: classes of one kind share them.
fn in_vain(d: &Document) -> Vec<(&'static str, Rate)> {
    let mut kinds: Vec<(&str, Rate)> = Vec::new();
    for r in d.rows.iter().filter(|r| d.is_own(r)) {
        let kind = r.class.kind().name();
        if let Some(rate) = r.false_alarm_rate.filter(|_| kinds.iter().all(|(known, _)| *known != kind)) {
            kinds.push((kind, rate));
        }
    }
    kinds
}

/// How early the predictor warns and how often in vain, in a sentence.
#[must_use]
pub fn verdict(d: &Document) -> (Tone, String) {
    let class = |r: &Row| {
        let ahead = r.lead_s.map_or_else(String::new, |[_, middle, _]| format!(" ({})", how_early(middle)));
        format!("{}: {} of {}{ahead}", r.class.name(), r.in_time, r.events)
    };
    let classes: Vec<String> = ours(d).map(class).collect();
    let in_vain: usize = in_vain(d).iter().map(|(_, rate)| rate.count).sum();
    let late = ours(d).any(|r| 10 * r.in_time < 9 * r.events);
    match classes.as_slice() {
        [] => {
            let tone = if in_vain > 0 { Tone::Fair } else { Tone::Plain };
            let (trials, time) = (d.trials, time(d.hours));
            (tone, format!("No event to be warned of in {trials} trials, {time}; false alarms: {in_vain}."))
        }
        some => {
            let tone = if late || in_vain > 0 { Tone::Fair } else { Tone::Good };
            (tone, format!("Warned in time: {}; false alarms: {in_vain}.", some.join("; ")))
        }
    }
}

/// Share of the events that each method warned of in time.
fn in_time_chart(d: &Document) -> Option<Bars> {
    let of = d.rows.iter().filter(|r| r.events > 0);
    let row = |r: &Row| {
        let share = r.in_time as f64 / r.events as f64;
        (format!("{}: {}", r.class.name(), r.method), share, d.is_own(r))
    };
    let rows: Vec<(String, f64, bool)> = of.map(row).collect();
    shares(rows, "share of the events warned of in time")
}

fn table(d: &Document) -> Markup {
    let header = [
        "event",
        "method",
        "events",
        "found",
        "in time",
        "lead 5/50/95 %, ms",
        "false alarms",
        "near alarms",
        "onset error, ms",
    ];
    html! {
        div class="scroll" {
            table class="tight" {
                caption { "Events found, and alarms without one" }
                thead { tr { @for (k, h) in header.iter().enumerate() { th scope="col" class=(if k < 2 { "left" } else { "number" }) { (h) } } } }
                tbody {
                    @for r in shown(&d.rows) {
                        tr {
                            @for (k, cell) in cells(r).iter().enumerate() {
                                @if k == 0 { th scope="row" { (cell) } }
                                @else if k == 1 { td class="left" { (cell) } }
                                @else {
                                    // The interval on a line of its own: the table fits the page.
                                    @match cell.split_once(" (") {
                                        Some((count, rate)) => { td { (count) div class="soft" { "(" (rate) } } }
                                        None => { td { (cell) } }
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
        (unfold("What the columns mean", &html! { p { (LEGEND) } }))
    }
}

/// Lead times of one class of events: a row and a curve of each method.
struct Leads<'a> {
    title: &'static str,
    rows: Vec<&'a Row>,
    chart: Chart,
}

/// One of each class that there were events of.
fn lead_charts(d: &Document) -> Vec<Leads<'_>> {
    let mut out = Vec::new();
    for class in Class::ALL {
        let rows: Vec<&Row> = d.rows.iter().filter(|r| r.class == class && r.events > 0).collect();
        if rows.is_empty() {
            continue;
        }
        let lines = rows.iter().zip(MODELS).map(|(r, colour)| Line {
            // A step down at each event's lead: also one event alone is a line.
            points: r
                .leads
                .iter()
                .enumerate()
                .flat_map(|(i, lead)| {
                    let share = |left: usize| (lead.min(2.0), 100.0 * left as f64 / r.events as f64);
                    [share(r.leads.len() - i), share(r.leads.len() - i - 1)]
                })
                .collect(),
            colour,
            width: 2,
        });
        let chart = Chart {
            size: SIZE,
            x_label: "lead, s (beyond 2 s drawn at 2)".into(),
            y_label: "events, %".into(),
            lines: lines.collect(),
            least_span: 100.0,
            ..Chart::default()
        };
        out.push(Leads { title: class.name(), rows, chart });
    }
    out
}

/// What the curves show, in words.
fn lead_words(title: &str, rows: &[&Row]) -> String {
    let of_method = |r: &&Row| {
        let middle = r.lead_s.map_or_else(String::new, |[_, middle, _]| {
            format!(", half of those at least {:.0} ms ahead", 1e3 * middle)
        });
        format!("{}: {} of {} with an alarm{middle}", r.method, r.leads.len(), r.events)
    };
    let methods: Vec<String> = rows.iter().map(of_method).collect();
    format!("{title}, share warned at least so long ahead: {}", methods.join("; "))
}

/// Stated against actual values: title and chart.
fn stated_charts(d: &Document) -> Vec<(String, Chart)> {
    let mut out = Vec::new();
    for (c, colour) in d.calibration.iter().zip(MODELS) {
        if !c.utilisation.is_empty() {
            let points =
                c.utilisation.iter().map(|b| (0.5 * (b.stated[0] + b.stated[1]), 100.0 * b.actual[0]));
            let chart = Chart {
                size: SIZE,
                x_label: "stated utilisation".into(),
                y_label: "slip within 0.1 s, %".into(),
                lines: vec![Line { points: points.collect(), colour, width: 2 }],
                least_span: 10.0,
                ..Chart::default()
            };
            out.push((format!("{}: utilisation", c.method), chart));
        }
        if !c.time_left.is_empty() {
            let of = |k: usize| {
                let point = |b: &stickslip_analysis::score::calibration::Bin| {
                    (500.0 * (b.stated[0] + b.stated[1]), b.actual.get(k).map_or(f64::NAN, |s| 1e3 * s))
                };
                c.time_left.iter().map(point).collect::<Vec<_>>()
            };
            let exact = Line { points: vec![(0.0, 0.0), (250.0, 250.0)], colour: MEASURED, width: 1 };
            let lines = [(0, 1), (1, 3), (2, 1)].map(|(k, width)| Line { points: of(k), colour, width });
            let chart = Chart {
                size: SIZE,
                x_label: "stated time left, ms".into(),
                y_label: "actual, 5/50/95 %, ms".into(),
                lines: lines.into_iter().chain([exact]).collect(),
                ..Chart::default()
            };
            out.push((format!("{}: time left until slip", c.method), chart));
        }
    }
    out
}

/// What the table's columns mean.
pub const LEGEND: &str = "found: an alarm was up at onset or began at most 0.1 s later; in time: slip that builds up (the required friction \
     rose steadily over 0.2 s or more of the last second) 100 ms ahead, sudden or \
     intended slip at most 20 ms after its onset, sag and rotation and drop before they happen, a foreseeable drop \
     360 ms ahead; lead: onset minus the alarm's beginning, negative where it is late; false: alarms \
     without an event of the kind (slip: in trials that are meant to hold); near: alarms with a smaller event (a motion short of a slip; for sag, a slip; for a \
     drop, a slip that ended in time); of both the count, the time watched, and the 95 % interval of the rate that a Poisson count leaves";

/// Stated utilisation and how often slip followed within 0.1 s.
pub fn utilisation(c: &Calibration) -> Vec<String> {
    c.utilisation
        .iter()
        .map(|b| format!("{:.1}-{:.1} {:.2} %", b.stated[0], b.stated[1], 100.0 * b.actual[0]))
        .collect()
}

/// Stated time left and the actual one.
pub fn time_left(c: &Calibration) -> Vec<String> {
    let ms = |s: &f64| format!("{:.0}", s * 1e3);
    c.time_left
        .iter()
        .map(|b| {
            let actual: Vec<String> = b.actual.iter().map(ms).collect();
            format!("{}-{} ms stated, {} ms", ms(&b.stated[0]), ms(&b.stated[1]), actual.join("/"))
        })
        .collect()
}

/// Rows that say something: those of events that there were; and alarms without any, which are those
/// of a whole kind, once.
pub fn shown(rows: &[Row]) -> impl Iterator<Item = &Row> {
    let alarms = |rate: Option<Rate>| rate.is_some_and(|rate| rate.count > 0);
    rows.iter().enumerate().filter_map(move |(at, row)| {
        let same = |other: &&Row| {
            other.class.kind() == row.class.kind()
                && other.method == row.method
                && other.false_alarm_rate.is_some()
        };
        let told = rows.iter().filter(same).any(|other| other.events > 0)
            || rows.iter().take(at).filter(same).count() > 0;
        let some = alarms(row.false_alarm_rate) || alarms(row.near_alarm_rate);
        (row.events > 0 || some && !told).then_some(row)
    })
}

/// A line for each kind of event that there was, and one for the predictor's false alarms: how many each method
/// warned of in time.
#[must_use]
pub fn summary(d: &Document) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for class in Class::ALL {
        let rows: Vec<&Row> = d.rows.iter().filter(|r| r.class == class && r.events > 0).collect();
        let Some(first) = rows.first() else { continue };
        let lead = |r: &Row| match r.lead_s {
            Some([low, middle, high]) if d.is_own(r) => {
                let [low, middle, high] = [low, middle, high].map(|x| 1e3 * x);
                format!(", {middle:.0} ms ahead (nine of ten {low:.0} to {high:.0})")
            }
            _ => String::new(),
        };
        let each: Vec<String> =
            rows.iter().map(|r| format!("{}: {}{}", r.method, r.in_time, lead(r))).collect();
        lines.push(format!("{}, {} in all, in time by {}", class.name(), first.events, each.join("; ")));
    }
    let alarms: Vec<String> =
        in_vain(d).iter().map(|(kind, of_kind)| format!("{kind} {}", rate(of_kind))).collect();
    if !alarms.is_empty() {
        lines.push(format!("false alarms: {}", alarms.join("; ")));
    }
    lines
}

/// A count and its time, and the interval of the rate: '2 in 73 s (12 to 356 an hour)'.
pub fn rate(r: &Rate) -> String {
    let [low, high] = r.interval_per_hour.map(three_digits);
    format!("{} in {} ({low} to {high} an hour)", r.count, time(r.hours))
}

/// A time in the unit that suits it.
pub fn time(hours: f64) -> String {
    let s = hours * 3600.0;
    match s {
        s if s < 100.0 => format!("{s:.0} s"),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        _ => format!("{hours:.1} h"),
    }
}

/// No more digits than a count gives.
fn three_digits(rate: f64) -> String {
    let decimals = match rate {
        r if r == 0.0 || r >= 10.0 => 0,
        r if r >= 1.0 => 1,
        _ => 2,
    };
    format!("{rate:.decimals$}")
}

/// A row as text.
pub fn cells(r: &Row) -> [String; 9] {
    let percent = |n: usize| match r.events {
        0 => "-".into(),
        events => format!("{:.1} %", 100.0 * n as f64 / events as f64),
    };
    let alarms = |r: Option<Rate>| r.map_or_else(|| "-".into(), |r| rate(&r));
    let ms = |q: Option<[f64; 3]>| {
        q.map_or_else(|| "-".into(), |q| q.map(|x| format!("{:.0}", x * 1e3)).join(" / "))
    };
    [
        r.class.name().into(),
        r.method.clone(),
        r.events.to_string(),
        percent(r.found),
        percent(r.in_time),
        ms(r.lead_s),
        alarms(r.false_alarm_rate),
        alarms(r.near_alarm_rate),
        ms(r.onset_error_s),
    ]
}

/// Every plot of the page.
#[must_use]
pub fn figures(d: &Document, seen: &Seen) -> Vec<Figure> {
    let mut out: Vec<Figure> =
        in_time_chart(d).iter().map(|b| Figure::of("warned-in-time", &b.chart())).collect();
    let key = |name: &str, colour| Key::Line(name.to_owned(), colour);
    out.extend(lead_charts(d).into_iter().map(|l| {
        let legend = l.rows.iter().zip(MODELS).map(|(r, colour)| key(&r.method, colour)).collect();
        Figure::of(&format!("lead {}", l.title), &Chart { legend, ..l.chart })
    }));
    out.extend(stated_charts(d).into_iter().map(|(title, chart)| {
        let mut legend: Vec<Key> =
            chart.lines.first().iter().map(|line| key("as it was", line.colour)).collect();
        if chart.lines.len() > 1 {
            legend.push(key("if what is stated were exact", MEASURED));
        }
        Figure::of(&format!("stated {title}"), &Chart { legend, ..chart })
    }));
    out.extend(warned::figures(seen.description, seen.drawn));
    out
}
