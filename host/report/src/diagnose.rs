//! The diagnosis as one page of HTML that needs no network.

use crate::html::{escape, heat, page};
use crate::words::short;
use stickslip_analysis::diagnose::report::Report;

/// The page.
pub fn html(report: &Report, name: &str) -> String {
    let mut body = format!("<h1>{}</h1><p><b>{}</b></p>", escape(name), escape(&report.summary));
    let e = &report.error;
    body += &format!(
        "<p>{} trials of {} conditions. Held-out error in run spreads: {:.2} before, {:.2} after; a perfect model: {:.2}.</p>",
        report.trials, report.conditions, e.before, e.after, e.perfect_model
    );
    body += "<h2>Effects tried</h2><table><tr><th>effect<th>explains<th><th>held-out error<th>p<th>parameters (95 %)</tr>";
    for c in &report.candidates {
        let share = (100.0 * c.explained).clamp(0.0, 100.0);
        let parameters: Vec<String> = c
            .parameters
            .iter()
            .map(|(n, v)| {
                let [value, low, high] = [v.value, v.low, v.high].map(short);
                format!("{} = {value} ({low} to {high}) {}", escape(n), escape(v.unit))
            })
            .collect();
        body += &format!(
            "<tr><td>{}<td>{share:.0} %<td><svg width=\"120\" height=\"12\"><rect width=\"{:.0}\" height=\"12\" fill=\"#47a\"/></svg><td>{:.2}<td>{:.1e}<td>{}</tr>",
            escape(c.id),
            1.2 * share,
            c.held_out_error,
            c.p_value,
            parameters.join("<br>")
        );
    }
    body += "</table><h2>Systematic misfit, in run spreads</h2><table><tr><th>channel<th>phase<th>before<th>after</tr>";
    for p in &report.places {
        body += &format!(
            "<tr><td>{}<td>{}<td style=\"background:{}\">{:.1}<td style=\"background:{}\">{:.1}</tr>",
            escape(&p.channel),
            escape(p.phase),
            heat(p.before),
            p.before,
            heat(p.after),
            p.after
        );
    }
    body += "</table>";
    if !report.unexplained.is_empty() {
        body += "<h2>Remaining misfit</h2><ul>";
        for u in &report.unexplained {
            let on: Vec<String> =
                u.depends_on.iter().map(|(q, s)| format!("{} ({:.0} %)", escape(q), 100.0 * s)).collect();
            body += &format!(
                "<li>{} in {}: {:.1}; depends on {}",
                escape(&u.channel),
                escape(u.phase),
                u.size,
                on.join(", ")
            );
        }
        body += "</ul>";
    }
    if !report.limits.is_empty() {
        body += "<h2>What cannot be concluded</h2><ul>";
        for l in &report.limits {
            body += &format!("<li>{}", escape(l));
        }
        body += "</ul>";
    }
    page(&format!("Diagnosis of {name}"), &body)
}
