//! The page of `stickslip score`: the table, and how lead times are spread.

use super::html::{escape, page as whole};
use super::plot::{Chart, Line, MODELS};
use crate::commands::score::{Document, cells};
use crate::score::figures::Class;

const SIZE: (u32, u32) = (560, 240);

/// The whole page.
pub fn page(d: &Document) -> String {
    let mut body = format!(
        "<h1>stickslip score: {}</h1>\n<div class=\"facts\"><span><b>{}</b> trials</span><span><b>{:.2}</b> h</span></div>\n\
         <table><tr><th>event<th>method<th>events<th>found<th>in time<th>lead 5/50/95 %, ms<th>false/h<th>onset error, ms</tr>\n",
        escape(&d.data.display().to_string()),
        d.trials,
        d.hours
    );
    for r in d.rows.iter().filter(|r| r.events > 0) {
        let row: Vec<String> = cells(r).iter().map(|c| format!("<td>{}", escape(c))).collect();
        body += &format!("<tr>{}</tr>\n", row.concat());
    }
    body += "</table>\n<h2>Events warned at least so far ahead</h2>\n<div class=\"grid\">\n";
    for class in Class::ALL {
        let of = || d.rows.iter().filter(move |r| r.class == class && r.events > 0);
        if of().next().is_none() {
            continue;
        }
        let names: Vec<String> = of().map(|r| r.method.clone()).collect();
        let lines = of().zip(MODELS).map(|(r, colour)| Line {
            points: r
                .leads
                .iter()
                .enumerate()
                .map(|(i, lead)| (lead.min(2.0), 100.0 * (r.leads.len() - i) as f64 / r.events as f64))
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
        let caption = format!("{}: {}", class.name(), escape(&names.join(", ")));
        body += &format!("<figure><figcaption>{caption}</figcaption>{}</figure>\n", chart.svg());
    }
    body += "</div>\n";
    whole("stickslip score", &body)
}
