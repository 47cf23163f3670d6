//! Misfits as horizontal bars on a logarithmic axis: the picture of a verdict.

use plotters::style::RGBColor;

use crate::plot::{Bar, Chart, Line, MEASURED, MODELS};

/// What is smaller is drawn as this.
const SMALLEST: f64 = 0.1;

/// Bars of `rows` (name, one value or before and after), worst first; a line at `limit`.
#[must_use]
pub fn bars(rows: &[(String, Vec<f64>)], x_label: &str, limit: f64) -> Chart {
    let log = |x: f64| x.max(SMALLEST).log10();
    let count = rows.len();
    let mut chart = Chart {
        size: (820, 60 + 34 * count as u32),
        x_label: x_label.to_owned(),
        x_decades: true,
        y_names: rows.iter().rev().map(|(name, _)| name.clone()).collect(),
        ..Chart::default()
    };
    for (k, (_, values)) in rows.iter().enumerate() {
        let middle = (count - 1 - k) as f64;
        let high = 0.72 / values.len().max(1) as f64;
        for (j, (value, colour)) in values.iter().zip(MODELS).enumerate() {
            let top = middle + 0.36 - j as f64 * high;
            chart.bars.push(Bar { x: (log(0.0), log(*value)), y: (top - high, top), colour });
        }
    }
    let largest = rows.iter().flat_map(|r| &r.1).copied().map(log).fold(log(limit), f64::max);
    chart.x = (log(0.0), largest.ceil().max(1.0) + 0.1);
    let ends = [-0.5, count as f64 - 0.5];
    chart.lines.push(Line { points: ends.map(|y| (log(limit), y)).to_vec(), colour: MEASURED, width: 1 });
    chart
}

/// Bars of shares from 0 to 1, in per cent; those of `strong` rows stand out.
#[must_use]
pub fn shares(rows: &[(String, f64, bool)], x_label: &str) -> Chart {
    let count = rows.len();
    let mut chart = Chart {
        size: (820, 60 + 24 * count as u32),
        x_label: x_label.to_owned(),
        x: (0.0, 104.0),
        y_names: rows.iter().rev().map(|r| r.0.clone()).collect(),
        ..Chart::default()
    };
    for (k, (_, share, strong)) in rows.iter().enumerate() {
        let y = (count - 1 - k) as f64;
        let colour: RGBColor = if *strong { MODELS[1] } else { MEASURED };
        chart.bars.push(Bar { x: (0.0, (100.0 * share).clamp(0.0, 100.0)), y: (y - 0.3, y + 0.3), colour });
    }
    chart
}
