//! Measured and modelled signals of one trial, one chart for each channel.

use plotters::style::RGBColor;

use super::html::escape;
use super::plot::{Chart, Line, MEASURED, MODELS, thinned};
use stickslip_analysis::channels::{COUNT, NAMES, channel_words, quantity};
use stickslip_analysis::compare::document::Trace;
use stickslip_analysis::compare::verdict::scale;
use stickslip_analysis::evidence::phases::PHASES;

/// Shading of the phases; contact before motion stays white.
pub const SHADES: [Option<(RGBColor, f64)>; 5] = [
    Some((RGBColor(0x99, 0x99, 0x99), 0.18)),
    None,
    Some((RGBColor(0xe6, 0x9f, 0x00), 0.22)),
    Some((RGBColor(0x56, 0xb4, 0xe9), 0.14)),
    Some((RGBColor(0x99, 0x99, 0x99), 0.18)),
];
/// Forces that are not determined.
const OPEN: RGBColor = RGBColor(0x00, 0x9e, 0x73);
const SIZE: (u32, u32) = (360, 170);
const POINTS: usize = 260;

/// Legend and charts of a trace; `models` are their names.
pub fn panel(trace: &Trace, models: &[&str]) -> String {
    let mut out =
        format!("<p>{} <b>{}</b>: {}</p>\n", trace.role, escape(&trace.trial), escape(&trace.conditions));
    out += &legend(models, !trace.force_bands.is_empty());
    out += "<div class=\"grid\">\n";
    for channel in (0..COUNT).filter(|k| trace.measured.iter().any(|s| s[*k].is_finite())) {
        out += &figure(trace, channel);
    }
    let unmeasured: Vec<&str> = (0..COUNT)
        .filter(|k| trace.measured.iter().all(|s| !s[*k].is_finite()))
        .filter(|k| trace.modelled.iter().flatten().any(|s| s[*k].is_finite()))
        .map(|k| NAMES[k])
        .collect();
    out += "</div>\n";
    if !unmeasured.is_empty() {
        out += &format!("<p class=\"soft\">Not measured: {}.</p>\n", unmeasured.join(", "));
    }
    out
}

fn hex(c: RGBColor) -> String {
    format!("#{:02x}{:02x}{:02x}", c.0, c.1, c.2)
}

fn legend(models: &[&str], open: bool) -> String {
    let mut out = String::from(
        "<div class=\"legend\"><span><i class=\"swatch line measured\"></i>measured, sensor offset removed</span>",
    );
    for (name, colour) in models.iter().zip(MODELS) {
        out += &format!(
            "<span><i class=\"swatch line\" style=\"background:{}\"></i>model {}</span>",
            hex(colour),
            escape(name)
        );
    }
    if let Some((name, colour)) = models.iter().zip(MODELS).next_back() {
        let RGBColor(r, g, b) = colour;
        out += &format!(
            "<span><i class=\"swatch\" style=\"background:rgb({r} {g} {b}/.22)\"></i>{} \u{b1} noise floor</span>",
            escape(name)
        );
    }
    if open {
        let RGBColor(r, g, b) = OPEN;
        out += &format!(
            "<span><i class=\"swatch\" style=\"background:rgb({r} {g} {b}/.22)\"></i>forces that rigid contact leaves \
             undetermined</span>"
        );
    }
    for (phase, shade) in PHASES.iter().zip(SHADES) {
        let style = shade.map_or_else(
            || "border:1px solid var(--line)".to_owned(),
            |(RGBColor(r, g, b), opacity)| format!("background:rgb({r} {g} {b}/{})", 1.6 * opacity),
        );
        out += &format!("<span><i class=\"swatch\" style=\"{style}\"></i>{}</span>", phase.label());
    }
    out + "</div>\n"
}

/// Charts of `channels` in two columns, as one SVG on white: for documents that are no page of ours.
pub fn picture(trace: &Trace, channels: &[usize]) -> String {
    const TITLE: u32 = 22;
    let (wide, high) = (SIZE.0 + 10, SIZE.1 + TITLE);
    let rows = u32::try_from(channels.len().div_ceil(2)).unwrap_or(1);
    let (width, height) = (2 * wide, rows * high);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
    );
    for (place, channel) in (0u32..).zip(channels) {
        let (x, y) = ((place % 2) * wide, (place / 2) * high);
        let (_, unit) = scale(quantity(*channel).unit());
        out += &format!(
            "<text x=\"{}\" y=\"{}\" font-family=\"sans-serif\" font-size=\"13\">{}, {unit}</text>\n<svg x=\"{x}\" y=\"{}\" width=\"{}\" height=\"{}\" {}\n",
            x + 12,
            y + 16,
            channel_words(NAMES[*channel]),
            y + TITLE,
            SIZE.0,
            SIZE.1,
            chart(trace, *channel).svg().trim_start_matches("<svg ")
        );
    }
    out + "</svg>\n"
}

fn figure(trace: &Trace, channel: usize) -> String {
    let (_, unit) = scale(quantity(channel).unit());
    let chart = chart(trace, channel);
    let (left, right) = chart.inside();
    format!(
        "<figure data-from=\"{}\" data-to=\"{}\" data-left=\"{left:.4}\" data-right=\"{right:.4}\" data-unit=\"{unit}\">\
         <figcaption>{}<span>{unit}</span></figcaption>{}</figure>\n",
        chart.x.0,
        chart.x.1,
        channel_words(NAMES[channel]),
        chart.svg()
    )
}

/// The channel as measured and as modelled, with bands and phases.
fn chart(trace: &Trace, channel: usize) -> Chart {
    let (factor, _) = scale(quantity(channel).unit());
    let t = &trace.t_s;
    let column = |rows: &[stickslip_analysis::channels::Signals]| -> Vec<f64> {
        rows.iter().map(|s| s[channel] * factor).collect()
    };
    let at = |i: usize| t.get(i).or(t.last()).copied().unwrap_or(0.0);
    let mut chart =
        Chart { size: SIZE, x_label: "time, s".into(), x: (at(0), at(usize::MAX)), ..Chart::default() };
    let measured = column(&trace.measured);
    chart.lines.push(Line { points: thinned(t, &measured, POINTS), colour: MEASURED, width: 1 });
    if channel >= 6 && !trace.force_bands.is_empty() {
        let ends: Vec<(f64, f64, f64)> = trace
            .force_bands
            .iter()
            .map(|(t, band)| (*t, band[channel].0 * factor, band[channel].1 * factor))
            .filter(|p| p.1.is_finite() && p.2.is_finite())
            .collect();
        if ends.len() > 1 {
            chart.bands.push((ends, OPEN));
        }
    }
    let mut widest = 0.0f64;
    for (k, (rows, colour)) in trace.modelled.iter().zip(MODELS).enumerate() {
        let values = column(rows);
        let points = thinned(t, &values, POINTS);
        if k + 1 == trace.modelled.len() {
            for phase in PHASES {
                let r = trace.phases.range(phase);
                let half = trace.band[channel][phase as usize] * factor;
                if r.is_empty() || !half.is_finite() {
                    continue;
                }
                widest = widest.max(half);
                let (from, to) = (at(r.start), at(r.end));
                let piece: Vec<(f64, f64, f64)> = points
                    .iter()
                    .filter(|p| p.0 >= from && p.0 <= to && p.1.is_finite())
                    .map(|p| (p.0, p.1 - half, p.1 + half))
                    .collect();
                if piece.len() > 1 {
                    chart.bands.push((piece, colour));
                }
            }
        }
        chart.lines.push(Line { points, colour, width: 2 });
    }
    // Noise alone shall not fill the chart.
    chart.least_span = 6.0 * widest;
    for (phase, shade) in PHASES.iter().zip(SHADES) {
        let r = trace.phases.range(*phase);
        if let (Some((colour, opacity)), false) = (shade, r.is_empty()) {
            chart.spans.push((at(r.start), at(r.end), colour, opacity));
        }
    }
    chart
}
