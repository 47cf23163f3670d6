//! The experiment that a diagnosis suggests: what the two models predict for one run of it.

use maud::{Markup, html};

use crate::html::{figure, swatch};
use crate::plot::{Chart, Key, Line, MODELS};
use crate::words::identifier_words as words;
use stickslip_analysis::channels::channel_words;
use stickslip_analysis::compare::verdict::scale;
use stickslip_analysis::diagnose::experiment::Experiment;
use stickslip_analysis::diagnose::report::Report;

/// Two predictions of a run as bells, as far apart as the experiment tells them.
fn experiment_chart(e: &Experiment) -> Chart {
    // In the channel's unit, from the first model's prediction.
    let apart = e.standard_deviations.clamp(0.0, 12.0);
    let (factor, unit) = scale(e.unit);
    let one = e.difference.abs() * factor / e.standard_deviations.max(f64::MIN_POSITIVE);
    let bell = |centre: f64| -> Vec<(f64, f64)> {
        let x = (0..=160).map(|k| -4.0 + (apart + 8.0) * f64::from(k) / 160.0);
        x.map(|x| (x * one, (-0.5 * (x - centre).powi(2)).exp())).collect()
    };
    Chart {
        size: (480, 200),
        x_label: format!("{} ({}), {unit} from the first prediction", channel_words(&e.channel), e.phase),
        y_label: "likely".into(),
        lines: vec![
            Line { points: bell(0.0), colour: MODELS[0], width: 2 },
            Line { points: bell(apart), colour: MODELS[1], width: 2 },
        ],
        ..Chart::default()
    }
}

/// The same as a file, with a legend.
pub fn experiment_file(report: &Report, e: &Experiment) -> Chart {
    let key = |(name, colour)| Key::Line(name, colour);
    Chart { legend: rivals(report).into_iter().zip(MODELS).map(key).collect(), ..experiment_chart(e) }
}

/// The two models whose predictions the suggested experiment compares.
fn rivals(report: &Report) -> [String; 2] {
    // Of two sets that do as well, what one has and the other has not.
    let set = report.ambiguous_with.first();
    let chosen = report.effects.iter().find(|id| set.is_some_and(|set| !set.contains(id)));
    let other = set.and_then(|set| set.iter().find(|id| !report.effects.contains(id)));
    match (chosen, other) {
        (Some(chosen), Some(other)) => [chosen, other].map(|id| format!("if it is {}", words(id))),
        _ => {
            let best = report.candidates.first().map_or_else(String::new, |best| words(best.id));
            ["if nothing is added to the model".to_owned(), format!("if it is {best}")]
        }
    }
}

/// The experiment in words, its conditions and its picture.
pub fn drawn_experiment(report: &Report, e: &Experiment) -> Markup {
    let [one, other] = rivals(report);
    let words = format!("the two models' predictions {:.1} standard deviations apart", e.standard_deviations);
    let conditions = [
        e.grip_n.map(|n| ("grip", format!("{n:.1} N"))),
        e.slope_rad.map(|s| ("slope", format!("{:.1} deg", s.to_degrees()))),
        e.pusher_offset_m.map(|m| ("pusher off the middle", format!("{:.1} mm", m * 1e3))),
        Some(("runs", e.runs.to_string())),
    ];
    html! {
        h2 { "What to measure next" }
        p { (e.summary) }
        div class="facts" {
            @for (what, value) in conditions.iter().flatten() { span { (what) " " b { (value) } } }
        }
        div class="legend" {
            (swatch("line m0", &format!("where a run lies {one}")))
            (swatch("line m1", &other))
        }
        (figure("What each of the two models predicts for one run", "", &words, &experiment_chart(e).svg()))
        p class="soft" { "Repeat the motion of trial " (e.like_trial) ". The less the two distributions overlap, the fewer runs are needed." }
    }
}
