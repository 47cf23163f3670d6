//! The page of `stickslip compare`.

use super::html::{escape, heat, page as whole, tabs};
use super::overlay::panel;
use super::plot::{Chart, Line, MEASURED, MODELS};
use stickslip_analysis::channels::{COUNT, channel_words};
use stickslip_analysis::compare::document::{Comparison, ErrorRow, Fate, ModelReport, Region, Size, Trend};
use stickslip_analysis::compare::noise::Source;
use stickslip_analysis::compare::rows::many_primitives;
use stickslip_analysis::compare::verdict::{place_words, readable, scale};
use stickslip_analysis::evidence::conditions::{Variable, trimmed};
use stickslip_analysis::evidence::phases::PHASES;

/// Most trends that are drawn.
const TRENDS: usize = 9;
/// Most trials in the table.
const TRIALS: usize = 100;

/// The whole page.
pub fn page(comparison: &Comparison) -> String {
    let mut body = header(comparison);
    if let Some(report) = comparison.models.last() {
        let repeated = comparison.data.noise_floor == Source::Repetitions;
        body += "<h2>Residuals and errors by channel and phase</h2>\n<p class=\"soft\">Residual: RMS of model minus \
                 measurement, noise included. Error: the part of it beyond the tolerance.";
        body += match repeated {
            true => {
                " In multiples of the noise floor (residual of a perfect model: 1), and in units. Bold: fails.</p>\n"
            }
            false => {
                " In units: without repetitions there is no noise floor. Bold: beyond the sensors' uncertainty for \
                 0.1 s or longer.</p>\n"
            }
        };
        let mut panes: Vec<(String, String)> = Vec::new();
        for m in comparison.models.iter().rev() {
            panes.push((format!("error, model {}", m.name), matrix(m, repeated, &|r| r.error)));
            panes.push((format!("residual, model {}", m.name), matrix(m, repeated, &|r| r.residual)));
        }
        body += &tabs("matrix", &panes);
        if !comparison.changes.is_empty() {
            body += &changes(comparison);
        }
        let names: Vec<&str> = comparison.models.iter().map(|m| m.name.as_str()).collect();
        body += "<h2>Signals</h2>\n";
        let panes: Vec<(String, String)> =
            comparison.traces.iter().map(|t| (t.role.to_owned(), panel(t, &names))).collect();
        body += &tabs("signals", &panes);
        body += &regions(report);
        body += &trends(report);
        body += &ranking(report);
        body += &offsets(report);
        body += &trials(report);
    }
    body += "<h2>Notes</h2>\n<ul>\n";
    for note in &comparison.notes {
        body += &format!("<li>{}</li>\n", escape(note));
    }
    body += "</ul>\n";
    if !comparison.skipped.is_empty() {
        body += "<details><summary>Trials that could not be compared</summary><ul>\n";
        for s in &comparison.skipped {
            body += &format!("<li>{}: {}</li>\n", escape(&s.trial), escape(&s.reason));
        }
        body += "</ul></details>\n";
    }
    whole(&format!("stickslip compare: {}", comparison.data.name), &body)
}

fn header(c: &Comparison) -> String {
    let worst = c.models.last().and_then(|m| m.errors.first());
    let tone = match worst {
        Some(r) if r.fails && r.error.multiples.unwrap_or(0.0) >= 1.5 => "bad",
        Some(r)
            if r.fails
                || r.noise_source != Source::Repetitions
                || r.error.multiples.is_some_and(|m| m >= 2.0) =>
        {
            "fair"
        }
        Some(_) => "good",
        None => "fair",
    };
    let d = &c.data;
    let floor = match d.noise_floor {
        Source::Repetitions => "scatter of repetitions",
        Source::SensorNoise => "sensor noise only (no repetitions)",
        Source::Unknown => "not known",
    };
    let mut out = format!(
        "<h1>stickslip compare: {}</h1>\n<p class=\"verdict {tone}\">{}</p>\n<div class=\"facts\"><span><b>{}</b> \
         trials</span><span><b>{}</b> conditions, {} repeated</span><span>noise floor: <b>{floor}</b></span>",
        escape(&d.name),
        escape(&c.summary),
        d.trials,
        d.conditions,
        d.repeated_conditions
    );
    if d.held_out {
        out += "<span><b>held out</b> from calibration</span>";
    }
    out += "</div>\n";
    for m in &c.models {
        out += &format!(
            "<div class=\"soft\">model <b>{}</b>: {}</div>\n",
            escape(&m.name),
            escape(&describe(m))
        );
    }
    out
}

/// Channels by phases.
fn matrix(report: &ModelReport, repeated: bool, of: &dyn Fn(&ErrorRow) -> Size) -> String {
    let many = report.errors.first().is_some_and(|_| many_primitives(&report.errors));
    let mut primitives: Vec<&str> = report.errors.iter().map(|r| r.place.primitive.as_str()).collect();
    primitives.sort_unstable();
    primitives.dedup();
    let mut out =
        String::from("<div class=\"scroll\"><table class=\"matrix\"><tr><th class=\"left\">channel</th>");
    for phase in PHASES {
        out += &format!("<th>{}</th>", phase.label());
    }
    out += "</tr>\n";
    for primitive in primitives {
        for channel in 0..COUNT {
            let rows: Vec<&ErrorRow> = report
                .errors
                .iter()
                .filter(|r| r.index == channel && r.place.primitive == primitive)
                .collect();
            let Some(first) = rows.first() else { continue };
            let name = channel_words(first.place.channel);
            let name = if many { format!("{}: {name}", primitive.replace('_', " ")) } else { name };
            out += &format!("<tr><td class=\"left\">{}</td>", escape(&name));
            for phase in PHASES {
                match rows.iter().find(|r| r.place.phase == phase) {
                    None => out += "<td class=\"soft\">-</td>",
                    Some(r) => {
                        let bold = if repeated { r.fails } else { r.sustained == Some(true) };
                        let class = if bold { " class=\"fails\"" } else { "" };
                        let size = readable(of(r).rms, r.unit);
                        out += &match of(r).multiples.filter(|_| repeated) {
                            Some(m) => format!(
                                "<td{class} style=\"{}\">{}\u{d7}<small>{size}</small></td>",
                                heat(m),
                                short(m)
                            ),
                            None => format!("<td{class}>{size}</td>"),
                        };
                    }
                }
            }
            out += "</tr>\n";
        }
    }
    out + "</table></div>\n"
}

fn short(m: f64) -> String {
    if m >= 10.0 { format!("{m:.0}") } else { format!("{m:.1}") }
}

fn changes(c: &Comparison) -> String {
    let many = c.models.first().is_some_and(|m| !m.errors.is_empty() && many_primitives(&m.errors));
    let (first, last) = (&c.models[0].name, &c.models[c.models.len() - 1].name);
    let repeated = c.data.noise_floor == Source::Repetitions;
    let mut out = format!(
        "<h2>Before and after</h2>\n<p class=\"soft\">Errors beyond the tolerance of {0}, for both models alike; and \
         the whole residuals.</p>\n<div class=\"scroll\"><table><tr><th class=\"left\">channel and phase</th><th>{0}\
         </th><th>{1}</th><th class=\"left\">failure</th><th>residual, {0}</th><th>residual, {1}</th></tr>\n",
        escape(first),
        escape(last)
    );
    let shown = c.changes.iter().filter(|c| {
        c.fate != Fate::Fits || c.before.multiples.unwrap_or(0.0).max(c.after.multiples.unwrap_or(0.0)) > 2.0
    });
    for change in shown {
        let cell = |s: &Size| {
            let m = s.multiples.filter(|_| repeated);
            let style = m.map_or_else(String::new, |m| format!(" style=\"{}\"", heat(m)));
            let multiples = m.map_or_else(String::new, |m| format!("{}\u{d7}", short(m)));
            format!("<td{style}>{multiples}<small>{}</small></td>", readable(s.rms, change.unit))
        };
        out += &format!(
            "<tr><td class=\"left\">{}</td>{}{}<td class=\"left\">{}</td>{}{}</tr>\n",
            escape(&place_words(&change.place, many)),
            cell(&change.before),
            cell(&change.after),
            fate_words(change.fate),
            cell(&change.residual_before),
            cell(&change.residual_after),
        );
    }
    out + "</table></div>\n"
}

fn regions(report: &ModelReport) -> String {
    if report.regions.is_empty() {
        return String::new();
    }
    let many = many_primitives(&report.errors);
    let mut panes: Vec<(String, String)> = Vec::new();
    for region in &report.regions {
        let label = place_words(&region.place, many);
        if panes.last().is_none_or(|p| p.0 != label) {
            panes.push((label, "<div class=\"flow\">\n".into()));
        }
        if let Some(pane) = panes.last_mut() {
            pane.1 += &heat_map(region);
        }
    }
    for pane in &mut panes {
        pane.1 += "</div>\n";
    }
    format!(
        "<h2>Where in the conditions</h2>\n<p class=\"soft\">RMS error beyond the tolerance, in multiples of the noise floor, over pairs of \
         conditions.</p>\n{}",
        tabs("regions", &panes)
    )
}

fn heat_map(region: &Region) -> String {
    let mut out = format!(
        "<figure><div class=\"scroll\"><table class=\"heat\"><tr><th></th><th colspan=\"{}\">{}</th></tr><tr><th \
         class=\"level\">{}</th>",
        region.x_levels.len(),
        region.x.label(),
        region.y.label()
    );
    for x in &region.x_levels {
        out += &format!("<th>{}</th>", escape(x));
    }
    out += "</tr>\n";
    for (y, row) in region.y_levels.iter().zip(&region.multiples) {
        out += &format!("<tr><th class=\"level\">{}</th>", escape(y));
        for m in row {
            out += &m.map_or_else(
                || "<td class=\"soft\">-</td>".to_owned(),
                |m| format!("<td style=\"{}\">{}</td>", heat(m), short(m)),
            );
        }
        out += "</tr>\n";
    }
    out + "</table></div></figure>\n"
}

fn trends(report: &ModelReport) -> String {
    if report.trends_tested == 0 {
        return String::new();
    }
    let many = report.errors.first().is_some_and(|_| many_primitives(&report.errors));
    let mut out = format!(
        "<h2>What the mean error depends on</h2>\n<p class=\"soft\">{} of {} trends are significant (corrected p below \
         0.05){}. Dots: mean error of each condition (order: of each run, less the mean of its repetitions).</p>\n",
        report.trends.len(),
        report.trends_tested,
        if report.trends.len() > TRENDS {
            format!("; the {TRENDS} largest are drawn")
        } else {
            String::new()
        }
    );
    out += "<div class=\"grid\">\n";
    for t in report.trends.iter().take(TRENDS) {
        out += &trend(t, report, many);
    }
    out + "</div>\n"
}

fn trend(t: &Trend, report: &ModelReport, many: bool) -> String {
    let unit = report.errors.iter().find(|r| r.place == t.place).map_or("N", |r| r.unit);
    let (factor, shown) = scale(unit);
    let x = |v: f64| if t.variable == Variable::Order { v } else { t.variable.shown(v) };
    let dots: Vec<(f64, f64)> = t.points.iter().map(|p| (x(p.0), p.1 * factor)).collect();
    let ends = [f64::INFINITY, f64::NEG_INFINITY];
    let low = t.points.iter().map(|p| p.0).fold(ends[0], f64::min);
    let high = t.points.iter().map(|p| p.0).fold(ends[1], f64::max);
    let on_line = |v: f64| (x(v), (t.intercept + t.slope * v) * factor);
    let chart = Chart {
        size: (360, 190),
        x_label: t.variable.label().into(),
        y_label: format!("mean error, {shown}"),
        lines: vec![Line { points: vec![on_line(low), on_line(high)], colour: MODELS[0], width: 2 }],
        dots: dots.into_iter().map(|(x, y)| (x, y, MEASURED)).collect(),
        ..Chart::default()
    };
    let span =
        t.span_multiples.map_or_else(String::new, |m| format!("{}\u{d7} over the range, ", short(m.abs())));
    format!(
        "<figure><figcaption>{}<span>{span}p {}</span></figcaption>{}</figure>\n",
        escape(&place_words(&t.place, many)),
        probability(t.p_corrected),
        chart.svg()
    )
}

fn probability(p: f64) -> String {
    if p < 1e-4 { "&lt; 0.0001".into() } else { format!("= {p:.4}") }
}

fn ranking(report: &ModelReport) -> String {
    let many = report.errors.first().is_some_and(|_| many_primitives(&report.errors));
    let mut out = String::from(
        "<details><summary>All errors, worst first</summary>\n<div class=\"scroll\"><table><tr><th \
         class=\"left\">channel and phase</th><th>trials</th><th>residual RMS</th><th>mean</th><th>largest</th><th>RMS with \
         offset</th><th>mean with offset</th><th>error beyond tolerance, RMS</th><th>mean</th><th>noise \
         floor</th><th>residual / floor</th><th>error / floor</th><th>F</th><th>p, \
         corrected</th></tr>\n",
    );
    for r in &report.errors {
        let size = |x: f64| readable(x, r.unit);
        let floor = r.noise_floor.map_or_else(|| "-".into(), size);
        let multiples = |s: Size| s.multiples.map_or_else(|| "-".into(), short);
        let (f, p) = r.lack_of_fit.map_or_else(
            || ("-".into(), "-".into()),
            |t| (trimmed(t.f, 3), probability(t.p_corrected).trim_start_matches("= ").to_owned()),
        );
        let class = if r.fails { " class=\"fails\"" } else { "" };
        out += &format!(
            "<tr{class}><td class=\"left\">{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>\
             {floor}</td><td>{}</td><td>{}</td><td>{f}</td><td>{p}</td></tr>\n",
            escape(&place_words(&r.place, many)),
            r.trials,
            size(r.residual.rms),
            size(r.residual.mean),
            size(r.residual.largest),
            size(r.rms_with_offset),
            size(r.bias_with_offset),
            size(r.error.rms),
            size(r.error.mean),
            multiples(r.residual),
            multiples(r.error)
        );
    }
    out + "</table></div></details>\n"
}

fn offsets(report: &ModelReport) -> String {
    if report.offsets.channels.is_empty() {
        return String::new();
    }
    let mut out = String::from(
        "<details><summary>Sensor offsets</summary>\n<p class=\"soft\">Measurement minus model before \
         contact.</p>\n<div class=\"scroll\"><table><tr><th class=\"left\">channel</th><th>mean</th><th>from trial to \
         trial</th><th>stated bound</th></tr>\n",
    );
    for o in &report.offsets.channels {
        let class = if o.beyond_bound { " class=\"fails\"" } else { "" };
        let bound = if o.stated_bound > 0.0 { readable(o.stated_bound, o.unit) } else { "-".into() };
        out += &format!(
            "<tr{class}><td class=\"left\">{}</td><td>{}</td><td>{}</td><td>{bound}</td></tr>\n",
            channel_words(o.channel),
            readable(o.mean, o.unit),
            readable(o.deviation, o.unit)
        );
    }
    out + "</table></div></details>\n"
}

fn trials(report: &ModelReport) -> String {
    let mut rows: Vec<_> = report.trials.iter().collect();
    rows.sort_by(|a, b| b.multiples.unwrap_or(0.0).total_cmp(&a.multiples.unwrap_or(0.0)));
    let mut out = format!(
        "<details><summary>Trials, worst first{}</summary>\n<div class=\"scroll\"><table><tr><th \
         class=\"left\">trial</th><th>error / floor</th><th class=\"left\">worst in</th><th>contact, s</th><th>sliding, \
         s</th><th>unsolved steps</th></tr>\n",
        if rows.len() > TRIALS { format!(" (the worst {TRIALS} of {})", rows.len()) } else { String::new() }
    );
    for t in rows.into_iter().take(TRIALS) {
        let time = |phase: &str| {
            t.phases.get(phase).filter(|p| p[1] > p[0]).map_or_else(|| "-".into(), |p| format!("{:.3}", p[0]))
        };
        out += &format!(
            "<tr><td class=\"left\">{}</td><td>{}</td><td class=\"left\">{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
            escape(&t.trial),
            t.multiples.map_or_else(|| "-".into(), short),
            t.worst.as_ref().map_or_else(|| "-".into(), |w| escape(&place_words(w, false))),
            time("sticking"),
            time("sliding"),
            t.unsolved_steps
        );
    }
    out + "</table></div></details>\n"
}

/// Origin and parameters of a model.
pub fn describe(report: &ModelReport) -> String {
    let friction: Vec<String> = report.friction.iter().map(|(k, v)| format!("{k} {v:.3}")).collect();
    let effects = if report.effects.is_empty() { "no effects".to_owned() } else { report.effects.join(", ") };
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
