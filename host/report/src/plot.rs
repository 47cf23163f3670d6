//! One small chart as inline SVG: shaded spans, a band, lines, points, a zero line; in a file with a legend.
//!
//! plotters draws it; the style sheet recolours its fixed colours in dark mode by
//! attribute selectors, so the colours here and there must agree.

use plotters::prelude::*;

/// Axis text.
const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
/// Axes and the zero line.
const AXIS: RGBColor = RGBColor(0x88, 0x88, 0x88);
const GRID: RGBColor = RGBColor(0xe2, 0xe2, 0xe2);
/// Measured signals.
pub const MEASURED: RGBColor = RGBColor(0x4a, 0x4a, 0x4a);
/// Colours of the models (Okabe and Ito 2008: told apart by the colour-blind).
pub const MODELS: [RGBColor; 4] = [
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
];

/// Room for the labels, in the chart's pixels.
const LEFT: i32 = 50;
const BOTTOM: i32 = 34;
const MARGIN: i32 = 6;
/// Width of a character of a name.
const CHARACTER: i32 = 6;
/// Height of a row of the legend, width of its samples, and room behind a name in it.
const ROW: i32 = 17;
const SAMPLE: i32 = 22;
const APART: i32 = 20;
/// A dash and the gap behind it.
const DASH: (i32, i32) = (6, 4);
/// Opacity of bands.
const BAND: f64 = 0.22;

/// A line through points.
#[derive(Clone, Debug)]
pub struct Line {
    /// In order of x.
    pub points: Vec<(f64, f64)>,
    /// Of the line.
    pub colour: RGBColor,
    /// Pixels.
    pub width: u32,
}

/// What a legend explains, and by which sample.
#[derive(Clone, Debug)]
pub enum Key {
    /// A line.
    Line(String, RGBColor),
    /// A dashed line.
    Dashed(String, RGBColor),
    /// A band about a line.
    Band(String, RGBColor),
    /// A shaded span, and its opacity.
    Span(String, RGBColor, f64),
}

impl Key {
    /// Of a line, as it is drawn.
    #[must_use]
    pub fn of_line(name: String, colour: RGBColor, dashed: bool) -> Self {
        if dashed { Key::Dashed(name, colour) } else { Key::Line(name, colour) }
    }

    fn name(&self) -> &str {
        match self {
            Key::Line(name, _) | Key::Dashed(name, _) | Key::Band(name, _) | Key::Span(name, ..) => name,
        }
    }

    /// With its sample, px.
    fn width(&self) -> i32 {
        SAMPLE + MARGIN + self.name().chars().count() as i32 * CHARACTER + APART
    }
}

/// Abscissa, lower and upper edge.
pub type Band = Vec<(f64, f64, f64)>;

/// A horizontal bar.
#[derive(Clone, Debug)]
pub struct Bar {
    /// From, to.
    pub x: (f64, f64),
    /// Lower and upper edge.
    pub y: (f64, f64),
    /// Filled with it.
    pub colour: RGBColor,
}

/// What a chart shows.
#[derive(Clone, Debug, Default)]
pub struct Chart {
    /// Pixels, without the legend.
    pub size: (u32, u32),
    /// Under the x axis.
    pub x_label: String,
    /// Beside the y axis.
    pub y_label: String,
    /// x range; empty: that of the lines and dots.
    pub x: (f64, f64),
    /// The y axis spans at least this much.
    pub least_span: f64,
    /// From, to, colour, opacity.
    pub spans: Vec<(f64, f64, RGBColor, f64)>,
    /// x is the decimal logarithm of what is shown; whole decades are marked.
    pub x_decades: bool,
    /// Horizontal bars.
    pub bars: Vec<Bar>,
    /// Pieces of a band: x, low, high.
    pub bands: Vec<(Band, RGBColor)>,
    /// Drawn in order.
    pub lines: Vec<Line>,
    /// Drawn over them, dashed.
    pub dashed: Vec<Line>,
    /// Dots.
    pub dots: Vec<(f64, f64, RGBColor)>,
    /// Text beside the ticks of the y axis instead of numbers.
    pub y_names: Vec<String>,
    /// Above the plot; a page has its own.
    pub legend: Vec<Key>,
}

impl Chart {
    /// Where the plot area begins and ends, as shares of the chart's width.
    pub fn inside(&self) -> (f64, f64) {
        let w = f64::from(self.size.0);
        (f64::from(self.left() + MARGIN) / w, 1.0 - f64::from(MARGIN) / w)
    }

    /// Names need more room than numbers.
    fn left(&self) -> i32 {
        let longest = self.y_names.iter().map(|n| n.chars().count()).max().unwrap_or(0);
        if self.y_names.is_empty() { LEFT } else { (3 * LEFT).max(longest as i32 * CHARACTER + 2 * MARGIN) }
    }

    /// Where each entry of the legend stands, and the height of all rows.
    fn legend_places(&self) -> (Vec<(i32, i32)>, i32) {
        let (mut x, mut y) = (self.left(), MARGIN);
        let mut places = Vec::new();
        for key in &self.legend {
            if x > self.left() && x + key.width() > self.size.0 as i32 {
                (x, y) = (self.left(), y + ROW);
            }
            places.push((x, y));
            x += key.width();
        }
        (places, if self.legend.is_empty() { 0 } else { y + ROW - MARGIN })
    }

    /// Both the lines and the dashed ones.
    fn all_lines(&self) -> impl Iterator<Item = &Line> {
        self.lines.iter().chain(&self.dashed)
    }

    fn x_range(&self) -> (f64, f64) {
        if self.x.1 > self.x.0 {
            return self.x;
        }
        let all = self.all_lines().flat_map(|l| l.points.iter().map(|p| p.0));
        let all = all.chain(self.bars.iter().flat_map(|b| [b.x.0, b.x.1]));
        // Stamps since 1970 differ by little of themselves.
        range(all.chain(self.dots.iter().map(|d| d.0)), 0.0, 0.05, 1e-12)
    }

    fn y_range(&self) -> (f64, f64) {
        let all = self.all_lines().flat_map(|l| l.points.iter().map(|p| p.1));
        let bars = self.bars.iter().flat_map(|b| [b.y.0, b.y.1]);
        let share = if self.bars.is_empty() { 0.07 } else { 0.01 };
        range(all.chain(bars).chain(self.dots.iter().map(|d| d.1)), self.least_span, share, CONSTANT)
    }

    /// The chart as an `<svg>` element.
    pub fn svg(&self) -> String {
        let mut text = String::new();
        let (w, h) = (self.size.0, self.size.1 + self.legend_places().1 as u32);
        let drawn = {
            let area = SVGBackend::with_string(&mut text, (w, h)).into_drawing_area();
            self.draw(&area).and_then(|()| area.present().map_err(|e| e.to_string()))
        };
        if let Err(why) = drawn {
            return format!("<p>This plot could not be drawn: {}</p>", super::html::escape(&why));
        }
        // Inline SVG needs no namespace, and its size is the style sheet's.
        let text = text.replace(" xmlns=\"http://www.w3.org/2000/svg\"", "");
        let text = text.replacen(&format!("<svg width=\"{w}\" height=\"{h}\""), "<svg role=\"img\"", 1);
        // Its label says what it shows: some screen readers read the numbers of the axes after it.
        let Some((head, inside)) = text.split_once('>') else { return text };
        match inside.rsplit_once("</svg>") {
            Some((inside, after)) => format!("{head}><g aria-hidden=\"true\">{inside}</g></svg>{after}"),
            None => text,
        }
    }

    fn draw(&self, area: &DrawingArea<SVGBackend, plotters::coord::Shift>) -> Result<(), String> {
        let wrong = |e: &dyn std::fmt::Display| e.to_string();
        let ((x0, x1), (y0, y1)) = (self.x_range(), self.y_range());
        let mut chart = ChartBuilder::on(area)
            .margin(MARGIN)
            .margin_top(MARGIN + self.draw_legend(area)?)
            .x_label_area_size(BOTTOM)
            .y_label_area_size(self.left())
            .build_cartesian_2d(x0..x1, y0..y1)
            .map_err(|e| wrong(&e))?;
        let inside = |x: f64| x.clamp(x0, x1);
        chart
            .draw_series(self.spans.iter().map(|(a, b, colour, opacity)| {
                Rectangle::new([(inside(*a), y0), (inside(*b), y1)], colour.mix(*opacity).filled())
            }))
            .map_err(|e| wrong(&e))?;
        let step = tick_step(y0, y1, 5);
        let names = &self.y_names;
        let y_text = |y: &f64| match names.get(y.round().max(0.0) as usize) {
            Some(name) if (y - y.round()).abs() < 1e-9 && *y > -0.5 => name.clone(),
            _ if !names.is_empty() => String::new(),
            _ => number(*y, step),
        };
        let x_step = tick_step(x0, x1, 6);
        chart
            .configure_mesh()
            .disable_x_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(GRID)
            .axis_style(AXIS)
            .x_labels(if self.x_decades { (x1 - x0).ceil() as usize + 1 } else { 6 })
            .y_labels(if names.is_empty() { 5 } else { names.len() + 2 })
            .label_style(("sans-serif", 12).into_font().color(&INK))
            .axis_desc_style(("sans-serif", 12).into_font().color(&INK))
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .x_label_formatter(&|x| match self.x_decades {
                true if (x - x.round()).abs() < 1e-6 => number(10f64.powf(x.round()), 10f64.powf(x.round())),
                true => String::new(),
                false => number(*x, x_step),
            })
            .y_label_formatter(&y_text)
            .draw()
            .map_err(|e| wrong(&e))?;
        if y0 < 0.0 && y1 > 0.0 && names.is_empty() {
            chart.draw_series(LineSeries::new([(x0, 0.0), (x1, 0.0)], AXIS)).map_err(|e| wrong(&e))?;
        }
        chart
            .draw_series(
                self.bars.iter().map(|b| {
                    Rectangle::new([(inside(b.x.0), b.y.0), (inside(b.x.1), b.y.1)], b.colour.filled())
                }),
            )
            .map_err(|e| wrong(&e))?;
        for (band, colour) in &self.bands {
            let limit = |y: f64| y.clamp(y0, y1);
            let mut outline: Vec<(f64, f64)> = band.iter().map(|p| (inside(p.0), limit(p.2))).collect();
            outline.extend(band.iter().rev().map(|p| (inside(p.0), limit(p.1))));
            chart
                .draw_series(std::iter::once(Polygon::new(outline, colour.mix(BAND).filled())))
                .map_err(|e| wrong(&e))?;
        }
        for line in &self.lines {
            for piece in pieces(line) {
                let style = line.colour.stroke_width(line.width);
                chart.draw_series(LineSeries::new(piece.iter().copied(), style)).map_err(|e| wrong(&e))?;
            }
        }
        for line in &self.dashed {
            for piece in pieces(line) {
                let style = line.colour.stroke_width(line.width);
                let dashes = DashedLineSeries::new(piece.iter().copied(), DASH.0, DASH.1, style);
                chart.draw_series(dashes).map_err(|e| wrong(&e))?;
            }
        }
        chart
            .draw_series(self.dots.iter().map(|(x, y, c)| Circle::new((*x, *y), 3, c.filled())))
            .map_err(|e| wrong(&e))?;
        Ok(())
    }

    /// Draws the legend; its height.
    fn draw_legend(&self, area: &DrawingArea<SVGBackend, plotters::coord::Shift>) -> Result<i32, String> {
        let wrong = |e: &dyn std::fmt::Display| e.to_string();
        let (places, height) = self.legend_places();
        for (key, (x, y)) in self.legend.iter().zip(places) {
            let (middle, end) = (y + ROW / 2, x + SAMPLE);
            let filled = |style: ShapeStyle| Rectangle::new([(x, y + 3), (end, y + ROW - 4)], style);
            let piece = |from: i32, to: i32, colour: RGBColor| {
                PathElement::new(vec![(from, middle), (to, middle)], colour.stroke_width(2))
            };
            match key {
                Key::Line(_, colour) => area.draw(&piece(x, end, *colour)),
                Key::Dashed(_, colour) => (x..end)
                    .step_by((DASH.0 + DASH.1) as usize)
                    .try_for_each(|from| area.draw(&piece(from, (from + DASH.0).min(end), *colour))),
                Key::Band(_, colour) => area.draw(&filled(colour.mix(BAND).filled())),
                Key::Span(_, colour, opacity) => area.draw(&filled(colour.mix(*opacity).filled())),
            }
            .map_err(|e| wrong(&e))?;
            let style = ("sans-serif", 12).into_font().color(&INK);
            area.draw(&Text::new(key.name().to_owned(), (end + MARGIN, y + 2), style))
                .map_err(|e| wrong(&e))?;
        }
        Ok(height)
    }
}

/// Parts of a line between gaps.
fn pieces(line: &Line) -> impl Iterator<Item = &[(f64, f64)]> {
    line.points.split(|p| !p.1.is_finite()).filter(|p| !p.is_empty())
}

/// What varies by less of its value to either side is constant to a reader. The script has the same.
const CONSTANT: f64 = 1e-5;

/// Range of finite values, widened by `share` on both sides and to `least` in all; what varies by less than `constant` of its
/// value is drawn as a constant.
fn range(values: impl Iterator<Item = f64>, least: f64, share: f64, constant: f64) -> (f64, f64) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for v in values.filter(|v| v.is_finite()) {
        low = low.min(v);
        high = high.max(v);
    }
    if low > high {
        return (0.0, 1.0);
    }
    let centre = 0.5 * (low + high);
    let half = (0.5 * (high - low)).max(0.5 * least);
    // A constant still gets an axis that its value can be read from: a twentieth to either side.
    let about = if centre == 0.0 { 1.0 } else { 0.05 * centre.abs() };
    let half = if half > constant * centre.abs() { half } else { about };
    let half = half * (1.0 + 2.0 * share);
    (centre - half, centre + half)
}

/// About the distance of `count` ticks.
fn tick_step(low: f64, high: f64, count: u32) -> f64 {
    let rough = (high - low) / f64::from(count);
    10f64.powf(rough.max(1e-12).log10().floor())
}

/// Decimals of a number beside a tick: those of a millionth part of a thousandth.
const MOST_DIGITS: f64 = 9.0;

/// As many decimals as the distance of the ticks needs.
fn number(x: f64, step: f64) -> String {
    let digits = (-step.log10().floor()).clamp(0.0, MOST_DIGITS) as usize;
    let text = format!("{x:.digits$}");
    if text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.') {
        text.trim_start_matches('-').to_owned()
    } else {
        text
    }
}

/// At most about `2 count` points: smallest and largest of each stretch, so that peaks stay.
pub fn thinned(t: &[f64], values: &[f64], count: usize) -> Vec<(f64, f64)> {
    let n = t.len().min(values.len());
    if n <= 2 * count {
        return t.iter().copied().zip(values.iter().copied()).collect();
    }
    let mut out = Vec::with_capacity(2 * count);
    for k in 0..count {
        let stretch = k * n / count..(k + 1) * n / count;
        let known = || stretch.clone().filter(|i| values[*i].is_finite());
        let by = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
        match (known().min_by(by), known().max_by(by)) {
            (Some(a), Some(b)) => {
                let (first, second) = (a.min(b), a.max(b));
                out.push((t[first], values[first]));
                if second != first {
                    out.push((t[second], values[second]));
                }
            }
            _ => out.push((t[stretch.start], f64::NAN)),
        }
    }
    out
}
