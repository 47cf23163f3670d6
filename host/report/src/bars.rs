//! Horizontal bars: the picture of a verdict. On a page they are elements that fit any width and say their values;
//! as a file they are a chart.

use maud::{Markup, html};
use plotters::style::RGBColor;

use crate::plot::{Bar, Chart, Key, Line, MEASURED, MODELS};

/// What is smaller is drawn as this.
const SMALLEST: f64 = 0.1;
/// Longest bar, per cent of the room: the number stands behind it.
const LONGEST: f64 = 84.0;

/// Bars and what they are of.
#[derive(Clone, Debug)]
pub struct Bars {
    rows: Vec<Row>,
    label: String,
    scale: Scale,
    /// What the first, the second bar of each row is of, as a screen reader says it: colours tell others.
    series: Vec<String>,
}

#[derive(Clone, Debug)]
struct Row {
    name: String,
    values: Vec<f64>,
    /// It stands out.
    strong: bool,
}

#[derive(Clone, Copy, Debug)]
enum Scale {
    /// Logarithmic from [`SMALLEST`]; a line at this value.
    Multiples(f64),
    /// From nothing to all.
    Shares,
}

/// Multiples of `rows` (name, one value or before and after), worst first, on a logarithmic axis; a line at
/// `limit`. None: `None`.
#[must_use]
pub fn multiples(rows: Vec<(String, Vec<f64>)>, label: &str, limit: f64) -> Option<Bars> {
    let row = |(name, values)| Row { name, values, strong: false };
    of(rows.into_iter().map(row).collect(), label, Scale::Multiples(limit))
}

/// Shares from 0 to 1; `strong` rows stand out. None: `None`.
#[must_use]
pub fn shares(rows: Vec<(String, f64, bool)>, label: &str) -> Option<Bars> {
    let row = |(name, share, strong)| Row { name, values: vec![share], strong };
    of(rows.into_iter().map(row).collect(), label, Scale::Shares)
}

fn of(rows: Vec<Row>, label: &str, scale: Scale) -> Option<Bars> {
    (!rows.is_empty()).then(|| Bars { rows, label: label.to_owned(), scale, series: Vec::new() })
}

fn log(x: f64) -> f64 {
    x.max(SMALLEST).log10()
}

impl Bars {
    /// With names for the bars of each row, in order.
    #[must_use]
    pub fn of_series<T: Into<String>>(mut self, names: impl IntoIterator<Item = T>) -> Self {
        self.series = names.into_iter().map(Into::into).collect();
        self
    }

    /// Largest value of the axis, as it is drawn.
    fn end(&self) -> f64 {
        let values = || self.rows.iter().flat_map(|r| &r.values).copied();
        match self.scale {
            Scale::Multiples(limit) => values().map(log).fold(log(limit).max(1.0), f64::max),
            Scale::Shares => 1.0,
        }
    }

    /// Where a value is, per cent of the room.
    fn place(&self, value: f64) -> f64 {
        let share = match self.scale {
            Scale::Multiples(_) => (log(value) - log(0.0)) / (self.end() - log(0.0)),
            Scale::Shares => value,
        };
        LONGEST * share.clamp(0.0, 1.0)
    }

    fn words(&self, value: f64) -> String {
        match self.scale {
            Scale::Multiples(_) if value >= 10.0 => format!("{value:.0}"),
            Scale::Multiples(_) => format!("{value:.1}"),
            Scale::Shares => match value {
                v if v < 0.0 => "worse".to_owned(),
                v if v > 0.0 && v < 0.005 => "below 1 %".to_owned(),
                v if v > 0.995 && v < 1.0 => "above 99 %".to_owned(),
                v => format!("{:.0} %", 100.0 * v),
            },
        }
    }

    /// Class of a bar's colour.
    fn class(&self, row: &Row, place: usize) -> String {
        match self.scale {
            Scale::Multiples(_) => format!("m{}", place.min(MODELS.len() - 1)),
            Scale::Shares => if row.strong { "m1" } else { "measured" }.to_owned(),
        }
    }

    /// What stands behind the label of the axis.
    fn axis(&self) -> String {
        match self.scale {
            Scale::Multiples(limit) => format!(", logarithmic; the line is at {limit}"),
            Scale::Shares => String::new(),
        }
    }

    /// On a page.
    #[must_use]
    pub fn markup(&self) -> Markup {
        let limit = match self.scale {
            Scale::Multiples(limit) => format!("--limit:{:.1}%", self.place(limit)),
            Scale::Shares => "--limit:0%".to_owned(),
        };
        let axis = self.axis();
        html! {
            div class="bars" {
                @for row in &self.rows {
                    div class="name" { (row.name) }
                    div class="of" style=(limit) {
                        @for (k, value) in row.values.iter().enumerate() {
                            div class="bar" {
                                i class=(self.class(row, k)) style=(format!("width:{:.1}%", self.place(*value))) {}
                                @if let Some(series) = self.series.get(k) { span class="said" { (series) ": " } }
                                span { (self.words(*value)) }
                            }
                        }
                    }
                }
                div class="name" {}
                div class="soft" { (self.label) (axis) }
            }
        }
    }

    /// As a chart with a legend.
    #[must_use]
    pub fn chart(&self) -> Chart {
        let count = self.rows.len();
        let mut chart = Chart {
            size: (820, 60 + 34 * count as u32),
            x_label: self.label.clone() + &self.axis(),
            y_names: self.rows.iter().rev().map(|row| row.name.clone()).collect(),
            legend: self.series.iter().cloned().zip(MODELS).map(|(name, c)| Key::Line(name, c)).collect(),
            ..Chart::default()
        };
        for (k, row) in self.rows.iter().enumerate() {
            let middle = (count - 1 - k) as f64;
            let high = 0.72 / row.values.len().max(1) as f64;
            for (j, (value, model)) in row.values.iter().zip(MODELS).enumerate() {
                let (from, to, colour): (f64, f64, RGBColor) = match self.scale {
                    Scale::Multiples(_) => (log(0.0), log(*value), model),
                    Scale::Shares if row.strong => (0.0, 100.0 * value, MODELS[1]),
                    Scale::Shares => (0.0, 100.0 * value, MEASURED),
                };
                let top = middle + 0.36 - j as f64 * high;
                chart.bars.push(Bar { x: (from, to), y: (top - high, top), colour });
            }
        }
        match self.scale {
            Scale::Multiples(limit) => {
                chart.x_decades = true;
                chart.x = (log(0.0), self.end().ceil() + 0.1);
                let ends = [-0.5, count as f64 - 0.5].map(|y| (log(limit), y));
                chart.lines.push(Line { points: ends.to_vec(), colour: MEASURED, width: 1 });
            }
            Scale::Shares => {
                chart.x = (0.0, 104.0);
                chart.x_label += ", %";
            }
        }
        chart
    }
}
