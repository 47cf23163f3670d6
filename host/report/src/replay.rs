//! The page of `stickslip replay`: predictions and flags over time.

use plotters::style::RGBColor;

use super::html::{escape, page as whole};
use super::plot::{Chart, Line, MEASURED, MODELS, thinned};
use stickslip_analysis::run::replay::FLAGS;
use stickslip_analysis::run::summary::Document;
use stickslip_shared::predictor::Prediction;

const SIZE: (u32, u32) = (360, 170);
const POINTS: usize = 300;

/// The whole page; `t_s` goes with `predictions`.
pub fn page(document: &Document, t_s: &[f64], predictions: &[Prediction]) -> String {
    let p = &document.prediction;
    let time = |t: Option<f64>| t.map_or_else(|| "never".to_owned(), |t| format!("at {t:.3} s"));
    let mut body = format!(
        "<h1>stickslip replay: {}</h1>\n<p class=\"verdict\">Slip warning {}, slip {}; sag at most {:.2} mm, \
         rotation {:.1} mrad.</p>\n<div class=\"facts\"><span><b>{}</b> ticks</span><span>hash <b>{}</b></span></div>\n",
        escape(&document.trial),
        time(p.first_warning_s),
        time(p.first_slip_s),
        p.peak_sag_m * 1e3,
        p.peak_rotation_rad * 1e3,
        document.ticks,
        document.hash
    );
    body += "<h2>Flags</h2>\n<div class=\"grid wide\">\n";
    body += &flags(document, t_s);
    body += "</div>\n<h2>Predictions</h2>\n<div class=\"legend\"><span><i class=\"swatch line measured\"></i>by the \
             sensors, or finger 2</span><span><i class=\"swatch line\" style=\"background:#d55e00\"></i>by the model, \
             finger 1</span><span><i class=\"swatch line\" style=\"background:#0072b2\"></i>ahead, at the \
             horizon</span></div>\n<div class=\"grid\">\n";
    let series = |f: &dyn Fn(&Prediction) -> f32| -> Vec<(f64, f64)> {
        let values: Vec<f64> = predictions.iter().map(|p| f64::from(f(p))).collect();
        thinned(t_s, &values, POINTS)
    };
    type Get = dyn Fn(&Prediction) -> f32;
    let mut add = |title: &str, unit: &str, lines: &[(&Get, RGBColor)], least: f64| {
        let chart = Chart {
            size: SIZE,
            x_label: "time, s".into(),
            x: ends(t_s),
            least_span: least,
            lines: lines
                .iter()
                .map(|(f, colour)| Line { points: series(f), colour: *colour, width: 2 })
                .collect(),
            ..Chart::default()
        };
        body += &figure(title, unit, &chart);
    };
    for k in 0..2 {
        add(
            &format!("finger {}: utilisation", k + 1),
            "",
            &[
                (&move |p: &Prediction| p.finger[k].measured_utilisation.unwrap_or(f32::NAN), MEASURED),
                (&move |p: &Prediction| p.finger[k].peak_utilisation, MODELS[1]),
                (&move |p: &Prediction| p.finger[k].model_utilisation, MODELS[0]),
            ],
            0.5,
        );
    }
    add(
        "slip speed",
        "mm/s",
        &[
            (&|p: &Prediction| p.finger[1].slip_speed_m_s * 1e3, MEASURED),
            (&|p: &Prediction| p.finger[0].slip_speed_m_s * 1e3, MODELS[0]),
        ],
        1.0,
    );
    add(
        "sag",
        "mm",
        &[(&|p: &Prediction| p.sag_ahead_m * 1e3, MODELS[1]), (&|p: &Prediction| p.sag_m * 1e3, MODELS[0])],
        0.2,
    );
    add("rotation in the grasp", "mrad", &[(&|p: &Prediction| p.rotation_rad * 1e3, MODELS[0])], 1.0);
    add("Newton steps a tick", "", &[(&|p: &Prediction| f32::from(p.solver_iterations), MODELS[0])], 5.0);
    body += "</div>\n";
    whole(&format!("stickslip replay: {}", document.trial), &body)
}

fn ends(t_s: &[f64]) -> (f64, f64) {
    (t_s.first().copied().unwrap_or(0.0), t_s.last().copied().unwrap_or(1.0))
}

/// A row for each flag that was ever up.
fn flags(document: &Document, t_s: &[f64]) -> String {
    let rows: Vec<&str> =
        FLAGS.iter().rev().copied().filter(|f| document.flags.iter().any(|s| s.flag == *f)).collect();
    if rows.is_empty() {
        return "<p>No flag rose.</p>\n".into();
    }
    let (_, end) = ends(t_s);
    let lines = document.flags.iter().filter_map(|s| {
        let row = rows.iter().position(|r| *r == s.flag)? as f64;
        let points = vec![(s.rises_s, row), (s.falls_s.unwrap_or(end), row)];
        Some(Line { points, colour: MODELS[0], width: 7 })
    });
    let chart = Chart {
        size: (1120, 60 + 26 * rows.len() as u32),
        x_label: "time, s".into(),
        x: ends(t_s),
        least_span: rows.len() as f64,
        lines: lines.collect(),
        y_names: rows.iter().map(|r| (*r).to_owned()).collect(),
        ..Chart::default()
    };
    figure("flags", "", &chart)
}

fn figure(title: &str, unit: &str, chart: &Chart) -> String {
    let (left, right) = chart.inside();
    format!(
        "<figure data-from=\"{}\" data-to=\"{}\" data-left=\"{left:.4}\" data-right=\"{right:.4}\" data-unit=\"{unit}\">\
         <figcaption>{title}<span>{unit}</span></figcaption>{}</figure>\n",
        chart.x.0,
        chart.x.1,
        chart.svg()
    )
}
