//! The diagnosis as one page: the verdict in plain words, one picture of the misfit before and
//! after, the next command; then a card for each effect that is named or nearly so, and the
//! misfit of every channel in every phase.

use std::collections::BTreeMap;

use plotters::style::RGBColor;

use crate::html::{escape, heat, page};
use crate::plot::{Bar, Chart, Line, MEASURED, MODELS};
use crate::words::{interval, short};
use stickslip_analysis::channels::channel_words;
use stickslip_analysis::diagnose::RELEVANT;
use stickslip_analysis::diagnose::detection::UpperLimit;
use stickslip_analysis::diagnose::posterior::Weighed;
use stickslip_analysis::diagnose::report::{CandidateReport, Place, Report, Verdict};
use stickslip_analysis::diagnose::structure::Structure;
use stickslip_analysis::fit::phases::Phase;

/// Places of the first picture.
const DRAWN: usize = 8;
/// Cards of effects that are not named.
const NEAR: usize = 2;
/// Such an effect explains at least this share of the excess error.
const NEARLY: f64 = 0.5;
/// What is smaller is drawn as this, in run spreads.
const SMALLEST: f64 = 0.1;
const BEFORE: RGBColor = MODELS[0];
const AFTER: RGBColor = MODELS[1];

/// The page; `next` is the command that comes next.
pub fn html(report: &Report, name: &str, next: &str) -> String {
    let tone = match report.verdict {
        Verdict::NothingMissing => "good",
        Verdict::Effect | Verdict::Ambiguous | Verdict::Inconclusive => "fair",
        Verdict::Unexplained => "bad",
    };
    let e = &report.error;
    let mut body = format!(
        "<h1>stickslip diagnose: {}</h1>\n<p class=\"verdict {tone}\">{}</p>\n",
        escape(name),
        escape(&plain(report))
    );
    if let Some(would_tell) = &report.would_tell {
        body += &format!("<p><b>What would tell:</b> {}.</p>\n", escape(would_tell));
    }
    body += &misfit_bars(report);
    body += &format!("<p><b>Next:</b></p>\n<pre class=\"next\">{}</pre>\n", escape(next));
    body += &format!(
        "<div class=\"facts\"><span><b>{}</b> trials</span><span><b>{}</b> conditions</span><span>held-out error \
         before: <b>{:.2}</b> run spreads</span>",
        report.trials, report.conditions, e.before
    );
    if has_after(report) {
        body += &format!("<span>after: <b>{:.2}</b></span>", e.after);
    }
    body += &format!("<span>a perfect model: <b>{:.2}</b></span></div>\n", e.perfect_model);
    body += &cards(report);
    body += &credible_bars(report);
    body += &tried(report);
    body += &maps(report);
    body += &left(report);
    body += &parameters(report);
    if !has_after(report) {
        let rows = limits_on_effects(report).into_iter();
        let row = |[effect, name, upper, typical]: [String; 4]| {
            escape(&format!("{effect}, {name}: {upper} (typical: {typical})"))
        };
        body += &list("What may still be there (95 %)", rows.map(row));
    }
    let classes = report.classes.iter();
    body += &list("Effects that these trials cannot tell apart", classes.map(|c| escape(&c.join(", "))));
    body += &list("What cannot be concluded", report.limits.iter().map(|l| escape(l)));
    page(&format!("stickslip diagnose: {name}"), &body)
}

/// The verdict without identifiers in the lead.
fn plain(report: &Report) -> String {
    let what = |id: &&'static str| {
        let of = report.candidates.iter().find(|c| c.id == *id);
        of.map_or_else(|| (*id).to_owned(), |c| format!("{} ({id})", c.info.summary))
    };
    let set = |set: &[&'static str]| set.iter().map(what).collect::<Vec<_>>().join(", and ");
    let e = &report.error;
    let fall = format!("from {:.1} to {:.1} run spreads", e.before, e.after);
    match report.verdict {
        Verdict::Effect => format!(
            "The model lacks something: {}. With it the held-out error falls {fall}.",
            set(&report.effects)
        ),
        Verdict::Ambiguous => {
            let others: Vec<String> = report.ambiguous_with.iter().map(|s| set(s)).collect();
            format!(
                "The model lacks something that these data do not tell apart: {}; or {}. The held-out error falls {fall}.",
                set(&report.effects),
                others.join("; or ")
            )
        }
        Verdict::NothingMissing | Verdict::Unexplained | Verdict::Inconclusive => report.summary.clone(),
    }
}

fn place_words(p: &Place) -> String {
    format!("{}, {}", channel_words(&p.channel), p.phase)
}

/// Structure that is left, in words.
pub fn structure_words(s: &Structure) -> String {
    let on: Vec<String> = s.depends_on.iter().map(|(q, x)| format!("{q} ({:.0} %)", 100.0 * x)).collect();
    let on = if on.is_empty() { "no named quantity".into() } else { on.join(", ") };
    format!("{} ({}), {:.1} run spreads, depends on {on}", channel_words(&s.channel), s.phase, s.size)
}

/// Share of the excess error that an effect explains.
pub fn share(explained: f64) -> String {
    if explained < 0.0 { "none: worse".into() } else { format!("{:.0} %", 100.0 * explained) }
}

/// A probability in per cent; what is nearly none or all is said to be so.
pub fn percent(probability: f64) -> String {
    match probability {
        p if p < 0.005 => "below 1 %".into(),
        p if p > 0.995 => "above 99 %".into(),
        p => format!("{:.0} %", 100.0 * p),
    }
}

/// The credible sets in words, one a line, and what is none of them; nothing where nothing had to be explained.
pub fn credible(report: &Report) -> Vec<String> {
    let Some(d) = &report.discrepancy else { return Vec::new() };
    let set = |s: &Weighed| match s.effects.as_slice() {
        [] => "nothing is missing".to_owned(),
        effects => effects.join(" + "),
    };
    let each = report.credible_sets.iter().map(|s| format!("{}: {}", set(s), percent(s.probability)));
    each.chain([format!("none of the sets tried: {}", percent(d.probability))]).collect()
}

/// Probabilities of the credible sets as bars.
fn credible_bars(report: &Report) -> String {
    let lines = credible(report);
    let Some(d) = report.discrepancy.as_ref().filter(|_| has_after(report)) else { return String::new() };
    let rows = lines.len();
    let mut chart = Chart {
        size: (820, 60 + 24 * rows as u32),
        x_label: "probability, %".into(),
        x: (0.0, 104.0),
        ..Chart::default()
    };
    let values = report.credible_sets.iter().map(|s| s.probability).chain([d.probability]);
    for (k, value) in values.enumerate() {
        let y = (rows - 1 - k) as f64;
        let colour = if k + 1 == rows { MEASURED } else { AFTER };
        chart.bars.push(Bar { x: (0.0, 100.0 * value), y: (y - 0.3, y + 0.3), colour });
    }
    chart.y_names = lines.iter().rev().map(|l| l.split(": ").next().unwrap_or_default().to_owned()).collect();
    format!(
        "<h2>How probable</h2>\n<figure><figcaption>Sets of effects that were fitted<span></span></figcaption>{}</figure>\n\
         <p class=\"soft\">{} conditions count as {:.1} independent ones.</p>\n",
        chart.svg(),
        report.conditions,
        d.effective_conditions
    )
}

/// How strong each effect may be although it is not named: effect, parameter, upper limit, typical size.
pub fn limits_on_effects(report: &Report) -> Vec<[String; 4]> {
    let with_unit = |x: f64, unit: &str| match unit {
        "1" => short(x),
        unit => format!("{} {unit}", short(x)),
    };
    let each = |(id, strengths): (&&'static str, &BTreeMap<&'static str, UpperLimit>)| {
        let row = |(name, l): (&&'static str, &UpperLimit)| {
            let upper = l
                .upper
                .map_or("not limited by these data".into(), |x| format!("at most {}", with_unit(x, l.unit)));
            [(*id).to_owned(), (*name).to_owned(), upper, with_unit(l.plausible, l.unit)]
        };
        strengths.iter().map(row).collect::<Vec<_>>()
    };
    report.limits_on_effects.iter().flat_map(each).collect()
}

/// Whether a model with effects stands beside the base model.
fn has_after(report: &Report) -> bool {
    matches!(report.verdict, Verdict::Effect | Verdict::Ambiguous)
}

/// The largest misfits as bars, before and after.
fn misfit_bars(report: &Report) -> String {
    let places: Vec<&Place> = report.places.iter().take(DRAWN).collect();
    if places.is_empty() {
        return String::new();
    }
    let log = |x: f64| x.max(SMALLEST).log10();
    let after = has_after(report);
    let rows = places.len();
    let mut chart = Chart {
        size: (820, 60 + 34 * rows as u32),
        x_label: "systematic misfit, run spreads of one run (no bar: below 0.1)".into(),
        x_decades: true,
        ..Chart::default()
    };
    for (k, p) in places.iter().enumerate() {
        let y = (rows - 1 - k) as f64;
        let bar = |value: f64, y: (f64, f64), colour| Bar { x: (log(0.0), log(value)), y, colour };
        if after {
            chart.bars.push(bar(p.before, (y, y + 0.36), BEFORE));
            chart.bars.push(bar(p.after, (y - 0.36, y), AFTER));
        } else {
            chart.bars.push(bar(p.before, (y - 0.3, y + 0.3), BEFORE));
        }
    }
    chart.y_names = places.iter().rev().map(|p| place_words(p)).collect();
    let largest = places.iter().map(|p| log(p.before.max(p.after))).fold(log(RELEVANT), f64::max);
    chart.x = (log(0.0), largest.ceil().max(1.0) + 0.1);
    let (low, high) = (-0.5, rows as f64 - 0.5);
    chart.lines.push(Line {
        points: vec![(log(RELEVANT), low), (log(RELEVANT), high)],
        colour: MEASURED,
        width: 1,
    });
    let swatch = |RGBColor(r, g, b): RGBColor, what: &str| {
        format!("<span><i class=\"swatch\" style=\"background:rgb({r} {g} {b})\"></i>{what}</span>")
    };
    let mut legend = swatch(BEFORE, "the model as given, friction refitted");
    if after {
        legend += &swatch(AFTER, "with the named effects");
    }
    legend += &format!(
        "<span><i class=\"swatch line measured\"></i>{RELEVANT} run spreads: above, an effect is looked for</span>"
    );
    format!(
        "<div class=\"legend\">{legend}</div>\n<figure><figcaption>Where the model misses most<span></span></figcaption>{}</figure>\n",
        chart.svg()
    )
}

/// A card for each effect that is named, does as well, or nearly so.
fn cards(report: &Report) -> String {
    let named = |c: &&CandidateReport| has_after(report) && report.effects.contains(&c.id);
    let equal = |c: &&CandidateReport| report.ambiguous_with.iter().flatten().any(|id| *id == c.id);
    let near = |c: &&CandidateReport| !named(c) && !equal(c) && c.explained > NEARLY;
    let all = || report.candidates.iter();
    let mut out: Vec<String> =
        all().filter(named).map(|c| card(c, "named", &role(c, "named: the model lacks it"))).collect();
    let as_well = |c: &&CandidateReport| equal(c) && !named(c);
    out.extend(all().filter(as_well).map(|c| card(c, "named", &role(c, "explains the data as well"))));
    out.extend(all().filter(near).take(NEAR).map(|c| card(c, "", &role(c, "not named"))));
    if out.is_empty() || report.verdict == Verdict::NothingMissing {
        return String::new();
    }
    format!("<h2>What it is</h2>\n<div class=\"cards\">\n{}</div>\n", out.concat())
}

fn role(c: &CandidateReport, what: &str) -> String {
    format!(
        "{what}; on its own it explains {} of the excess error and leaves {:.2} run spreads",
        share(c.explained),
        c.held_out_error
    )
}

fn card(c: &CandidateReport, class: &str, role: &str) -> String {
    let mut out = format!(
        "<div class=\"card {class}\">\n<h3>{}</h3>\n<p class=\"soft\">{}</p>\n<p>{}.</p>\n<p>In data: {}.</p>\n<p class=\"soft\">Source: {}.</p>\n",
        escape(c.id),
        escape(role),
        escape(&capital(c.info.summary)),
        escape(c.info.signature),
        escape(c.info.source)
    );
    out += "<table><tr><th>parameter</th><th>value</th><th>95 % interval</th><th>unit</th><th>typical</th><th class=\"left\">meaning</th></tr>\n";
    for p in c.info.parameters {
        let Some(v) = c.parameters.get(p.name) else { continue };
        out += &format!(
            "<tr><td class=\"left\">{}</td><td><b>{}</b></td><td>{}</td><td>{}</td><td>{}</td><td class=\"text\">{}</td></tr>\n",
            escape(p.name),
            short(v.value),
            interval(v.low, v.high),
            escape(p.unit),
            short(p.typical),
            escape(p.what)
        );
    }
    out + "</table>\n</div>\n"
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// All effects that were refitted, as bars and in a table.
fn tried(report: &Report) -> String {
    if report.candidates.is_empty() {
        return String::new();
    }
    let rows = report.candidates.len();
    let mut chart = Chart {
        size: (820, 60 + 24 * rows as u32),
        x_label: "share of the excess error explained, %".into(),
        x: (0.0, 104.0),
        ..Chart::default()
    };
    for (k, c) in report.candidates.iter().enumerate() {
        let y = (rows - 1 - k) as f64;
        let named = has_after(report) && report.effects.contains(&c.id);
        let colour = if named { AFTER } else { MEASURED };
        let share = (100.0 * c.explained).clamp(0.0, 100.0);
        chart.bars.push(Bar { x: (0.0, share), y: (y - 0.3, y + 0.3), colour });
    }
    chart.y_names = report.candidates.iter().rev().map(|c| c.id.to_owned()).collect();
    let mut out = format!(
        "<h2>Effects tried</h2>\n<figure><figcaption>Each added on its own to the model, judged on held-out \
         conditions<span></span></figcaption>{}</figure>\n",
        chart.svg()
    );
    out += "<details><summary>Figures of all effects tried</summary>\n<div class=\"scroll\"><table><tr><th>effect</th>\
            <th>probability</th><th>explains</th><th>held-out error</th><th>p</th><th class=\"left\">parameters (95 % interval)</th></tr>\n";
    for c in &report.candidates {
        let parameters: Vec<String> = c
            .parameters
            .iter()
            .map(|(n, v)| {
                format!("{} = {} ({}) {}", escape(n), short(v.value), interval(v.low, v.high), escape(v.unit))
            })
            .collect();
        out += &format!(
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{:.2}</td><td>{:.1e}</td><td class=\"left\">{}</td></tr>\n",
            escape(c.id),
            percent(c.probability),
            share(c.explained),
            c.held_out_error,
            c.p_value,
            parameters.join("<br/>")
        );
    }
    out + "</table></div></details>\n"
}

/// Misfit of each channel in each phase, before and after.
fn maps(report: &Report) -> String {
    if report.places.is_empty() {
        return String::new();
    }
    let mut channels: Vec<&str> = Vec::new();
    for p in report.places.iter().filter(|p| p.before.max(p.after) > 1.0) {
        if !channels.contains(&p.channel.as_str()) {
            channels.push(&p.channel);
        }
    }
    let mut out = String::from(
        "<h2>Systematic misfit by channel and phase</h2>\n<p class=\"soft\">Root mean square over the conditions, in \
         run spreads of one run. Channels within one run spread everywhere are left out.</p>\n<div class=\"flow\">\n",
    );
    let map = |title: &str, size: fn(&Place) -> f64| {
        let phases: Vec<&str> = Phase::ALL
            .iter()
            .map(|p| p.name())
            .filter(|name| report.places.iter().any(|p| p.phase == *name))
            .collect();
        let mut map = format!(
            "<div class=\"scroll\"><h3>{title}</h3><table class=\"heat\"><tr><th class=\"level\">channel</th>"
        );
        for phase in &phases {
            map += &format!("<th>{phase}</th>");
        }
        map += "</tr>\n";
        for channel in &channels {
            map += &format!("<tr><th class=\"level\">{}</th>", escape(&channel_words(channel)));
            for phase in &phases {
                match report.places.iter().find(|p| p.channel == *channel && p.phase == *phase) {
                    Some(p) => map += &format!("<td style=\"{}\">{:.1}</td>", heat(size(p)), size(p)),
                    None => map += "<td>-</td>",
                }
            }
            map += "</tr>\n";
        }
        map + "</table></div>\n"
    };
    out += &map("the model as given, friction refitted", |p| p.before);
    if has_after(report) {
        out += &map("with the named effects", |p| p.after);
    }
    out + "</div>\n"
}

fn left(report: &Report) -> String {
    list("Remaining misfit", report.unexplained.iter().map(|u| escape(&structure_words(u))))
}

/// Fitted parameters of the model that is judged.
fn parameters(report: &Report) -> String {
    let mut out = String::from(
        "<details><summary>All fitted parameters</summary>\n<table><tr><th>parameter</th><th>value</th><th>95 % \
         interval</th><th>unit</th></tr>\n",
    );
    for (name, v) in &report.parameters {
        out += &format!(
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
            escape(name),
            short(v.value),
            interval(v.low, v.high),
            escape(v.unit)
        );
    }
    out + "</table></details>\n"
}

fn list(title: &str, items: impl Iterator<Item = String>) -> String {
    let items: Vec<String> = items.map(|i| format!("<li>{i}</li>\n")).collect();
    if items.is_empty() {
        return String::new();
    }
    format!("<h2>{title}</h2>\n<ul>\n{}</ul>\n", items.concat())
}
