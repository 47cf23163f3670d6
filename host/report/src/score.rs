//! The page of `stickslip score`: the table, and how lead times are spread.

use super::html::{escape, page as whole};
use super::plot::{Chart, Line, MEASURED, MODELS};
use stickslip_analysis::score::ObjectPose;
use stickslip_analysis::score::calibration::Calibration;
use stickslip_analysis::score::document::Document;
use stickslip_analysis::score::figures::{Class, Row};
use stickslip_analysis::score::rate::Rate;

const SIZE: (u32, u32) = (560, 240);

/// The whole page.
pub fn page(d: &Document) -> String {
    let mut body = format!(
        "<h1>stickslip score: {}</h1>\n<div class=\"facts\"><span><b>{}</b> trials</span><span><b>{}</b></span><span>object's pose: <b>{}</b></span>\
         <span>not scored: <b>{}</b> trials</span><span>sample not trusted: <b>{:.2} %</b> of the ticks</span></div>\n\
         <div class=\"scroll\"><table><tr><th>event</th><th class=\"left\">method</th><th>events</th><th>found</th><th>in time</th><th>lead<br/>5/50/95 %, ms</th>\
         <th>false</th><th>near</th><th>onset<br/>error, ms</th></tr>\n",
        escape(&d.data.display().to_string()),
        d.trials,
        time(d.hours),
        match d.object_pose {
            ObjectPose::Every => "in every sample",
            ObjectPose::Start => "at the start only",
        },
        d.passed_over.len(),
        d.doubtful_share * 100.0
    );
    for r in shown(&d.rows) {
        // The interval on a line of its own: the table fits the page.
        let cell = |(k, c): (usize, &String)| {
            let text = escape(c).replace(" (", "<br/>(").replace(" an hour)", "/h)");
            format!("<td{}>{text}</td>", if k < 2 { " class=\"left\"" } else { "" })
        };
        let row: Vec<String> = cells(r).iter().enumerate().map(cell).collect();
        body += &format!("<tr>{}</tr>\n", row.concat());
    }
    body += &format!("</table></div>\n<p>{}</p>\n", escape(LEGEND));
    body += "<h2>Lead times: share of events warned at least this long ahead</h2>\n<div class=\"grid\">\n";
    for class in Class::ALL {
        let of = || d.rows.iter().filter(move |r| r.class == class && r.events > 0);
        if of().next().is_none() {
            continue;
        }
        let names: Vec<String> = of()
            .zip(MODELS)
            .map(|(r, c)| {
                format!("<b style=\"color:rgb({},{},{})\">{}</b>", c.0, c.1, c.2, escape(&r.method))
            })
            .collect();
        let lines = of().zip(MODELS).map(|(r, colour)| Line {
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
        // One item: the caption lays its items out side by side.
        let caption = format!("<span>{}: {}</span>", class.name(), names.join(", "));
        body += &figure(&caption, &chart);
    }
    body += "</div>\n<h2>Stated against actual values</h2>\n<div class=\"grid\">\n";
    for (c, colour) in d.calibration.iter().zip(MODELS) {
        let name = escape(&c.method);
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
            body += &figure(&format!("{name}: utilisation"), &chart);
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
            body += &figure(&format!("{name}: time left until slip"), &chart);
        }
    }
    body += "</div>\n";
    whole("stickslip score", &body)
}

fn figure(caption: &str, chart: &Chart) -> String {
    format!("<figure><figcaption>{caption}</figcaption>{}</figure>\n", chart.svg())
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
