//! What an effect changes beside what the data show that the model lacks: as bars by channel and phase over all
//! conditions, and over one run in the channel where the named effects explain most.

use maud::{Markup, html};
use stickslip_analysis::channels::{COUNT, NAMES, Signals, channel_words, quantity};
use stickslip_analysis::compare::document::{Comparison, Trace};
use stickslip_analysis::compare::verdict::{readable, scale};
use stickslip_analysis::diagnose::signature::Mark;
use stickslip_analysis::evidence::phases::{PHASES, Phase};

use crate::bars::{Bars, multiples};
use crate::html::{figure, swatch};
use crate::plot::{Chart, Key, Line, MODELS, thinned};

/// Places on a card.
const MARKS: usize = 5;
/// Width of a drawing, px.
const WIDE: u32 = 360;
/// Points of a line.
const POINTS: usize = 300;
/// What the two bars of each row are of.
const SERIES: [&str; 2] = ["what the data show that the model lacks", "what the effect changes"];

/// The places that are drawn: where the effect changes most or most is left.
fn largest(marks: &[Mark]) -> Vec<&Mark> {
    let mut shown: Vec<&Mark> = marks.iter().collect();
    shown.sort_by(|a, b| b.left.max(b.change).total_cmp(&a.left.max(a.change)));
    shown.truncate(MARKS);
    shown
}

/// What an effect changes beside what the data show, by channel and phase.
pub fn bars(marks: &[Mark]) -> Option<Bars> {
    let name = |m: &Mark| format!("{}, {}", channel_words(&m.channel), m.phase);
    multiples(largest(marks).iter().map(|m| (name(m), vec![m.left, m.change])).collect(), "run spreads", 1.0)
        .map(|bars| bars.of_series(SERIES))
}

/// The pictures of a card; `run` where the effect is named.
pub fn signature(marks: &[Mark], run: Option<&Run>) -> Markup {
    let Some(chart) = bars(marks) else { return html! {} };
    let mut largest: Vec<String> = Vec::new();
    for m in marks {
        let text = format!("{} by {}", channel_words(&m.channel), readable(m.change_si, m.unit));
        if largest.len() < 3 && !largest.iter().any(|l| l.starts_with(&channel_words(&m.channel))) {
            largest.push(text);
        }
    }
    html! {
        div class="legend" {
            (swatch("m0", SERIES[0]))
            (swatch("m1", SERIES[1]))
        }
        div class="pair" {
            (figure("Its signature", "", "what the effect changes beside what the model lacks", &chart.markup().0))
            @if let Some(run) = run { (figure(&run.title, run.unit, &run.words, &run.chart.svg())) }
        }
        p { "On this bench it changes " (largest.join("; ")) " (root mean square)." }
    }
}

/// The signature over one run.
pub struct Run {
    /// Channel and trial.
    pub title: String,
    /// Of the channel.
    pub unit: &'static str,
    /// What it shows.
    pub words: String,
    /// The drawing.
    pub chart: Chart,
}

impl Run {
    /// The drawing as a file, with a legend.
    #[must_use]
    pub fn file(self) -> Chart {
        let key = |(name, colour): (&str, _)| Key::Line(name.to_owned(), colour);
        Chart {
            size: (2 * WIDE, 260),
            legend: SERIES.into_iter().zip(MODELS).map(key).collect(),
            ..self.chart
        }
    }
}

/// Measurement less the first model, and last model less the first, in the trial and the channel
/// that the last model explains better by most noise floors: of the channels of the bars, where it explains one of them.
#[must_use]
pub fn over_a_run(traces: &Comparison, marks: &[Mark]) -> Option<Run> {
    let shown = largest(marks);
    let drawn = |c: usize| {
        // Both fingers of what is together or of one less the other.
        let plain =
            |m: &&Mark| m.channel.replace("finger_sum", "finger").replace("finger_difference", "finger");
        let name = NAMES[c].replace("finger1", "finger").replace("finger2", "finger");
        shown.iter().any(|m| m.change > 1.0 && (m.channel == NAMES[c] || plain(m) == name))
    };
    let of = |t| (0..COUNT).filter_map(move |c| Some((explained(t, c)?, c, t)));
    let all = traces.traces.iter().flat_map(of);
    let (_, channel, trace) = all.max_by(|a, b| drawn(a.1).cmp(&drawn(b.1)).then(a.0.total_cmp(&b.0)))?;
    let (given, named) = (trace.modelled.first()?, trace.modelled.last()?);
    let (factor, unit) = scale(quantity(channel).unit());
    let less = |rows: &[Signals]| -> Vec<f64> {
        rows.iter().zip(given).map(|(a, b)| (a[channel] - b[channel]) * factor).collect()
    };
    let line = |values: Vec<f64>, colour, width| Line {
        points: thinned(&trace.t_s, &values, POINTS),
        colour,
        width,
    };
    let words = channel_words(NAMES[channel]);
    Some(Run {
        title: format!("The same in one run: {words}, {}", trace.conditions),
        unit,
        words: format!(
            "{words} over time: measurement less the model as given, and what the named effects change"
        ),
        chart: Chart {
            size: (WIDE, 190),
            x_label: "time, s".into(),
            y_label: format!("less the model as given, {unit}"),
            lines: vec![line(less(&trace.measured), MODELS[0], 1), line(less(named), MODELS[1], 2)],
            ..Chart::default()
        },
    })
}

/// How much of the measurement the last model explains beyond the first in a channel after contact: root of the mean
/// square that goes, in noise floors, times the share of the square that goes; `None` where nothing goes.
fn explained(trace: &Trace, channel: usize) -> Option<f64> {
    let (given, named) = (trace.modelled.first()?, trace.modelled.last()?);
    let (mut gone, mut before, mut count) = (0.0, 0.0, 0.0);
    for phase in PHASES.into_iter().filter(|p| *p != Phase::BeforeContact) {
        let floor = trace.band[channel][phase as usize];
        let both = given.iter().zip(named).zip(&trace.measured);
        let range = trace.phases.range(phase);
        for ((a, b), m) in both.take(range.end).skip(range.start) {
            let left = |model: &Signals| ((m[channel] - model[channel]) / floor).powi(2);
            let (first, last) = (left(a), left(b));
            if first.is_finite() && last.is_finite() {
                gone += first - last;
                before += first;
                count += 1.0;
            }
        }
    }
    (gone > 0.0).then(|| f64::sqrt(gone / count) * gone / before)
}
