//! Clocks that `import` estimated: in lines, and drawn.

use stickslip_data::import::recording::Offset;
use stickslip_report::html;
use stickslip_report::plot::{Chart, Line, MEASURED, MODELS};

/// Trials that are listed or drawn.
const SHOWN: usize = 6;

/// One line for a clock that all trials share, otherwise one for each trial.
pub fn lines(offsets: &[Offset]) -> Vec<String> {
    let mut streams: Vec<&str> = offsets.iter().map(|offset| offset.stream.as_str()).collect();
    streams.dedup();
    let mut lines = Vec::new();
    for stream in streams {
        let of: Vec<&Offset> = offsets.iter().filter(|offset| offset.stream == stream).collect();
        match of.iter().find(|offset| offset.trials > 1) {
            Some(one) => lines.push(format!(
                "clock of {stream}: {} added, by the contact in {} trials that agree",
                interval(one.offset_s, one.uncertainty_s),
                one.trials
            )),
            None => {
                lines.extend(of.iter().take(SHOWN).map(|offset| {
                    let added = interval(offset.offset_s, offset.uncertainty_s);
                    format!("clock of {stream} in {}: {added} added, by its contact", offset.trial)
                }));
                if of.len() > SHOWN {
                    lines.push(format!("and {} more trials; --json lists all", of.len() - SHOWN));
                }
            }
        }
    }
    lines
}

fn interval(offset_s: f64, half_s: f64) -> String {
    format!("{offset_s:.4} s, give or take {:.1} ms (95 %)", half_s * 1e3)
}

/// Force and way of the object about the contact, by one clock: their corners lie at one time.
pub fn page(offsets: &[Offset]) -> String {
    let mut sentence = String::from(
        "When the object touches, the force rises and the object begins to move in the gripper at one instant: the \
         corners of both curves lie where the contact is.",
    );
    for line in lines(offsets) {
        sentence += &format!(" {line}.");
    }
    let mut figures = Vec::new();
    for offset in offsets.iter().filter(|offset| offset.contact_s.is_some()).take(SHOWN) {
        let contact_s = offset.contact_s.unwrap_or_default();
        // A line where the interval is narrower than a pixel.
        let half_s = offset.uncertainty_s.max(4e-4);
        for (name, rows, scale) in
            [("force, N", &offset.force, 1.0), ("way in the gripper, mm", &offset.way, 1e3)]
        {
            let points = rows.iter().map(|[t, x]| (*t, x * scale)).collect();
            let chart = Chart {
                size: (760, 200),
                x_label: "time, s".to_owned(),
                y_label: name.to_owned(),
                x: (contact_s - 0.3, contact_s + 0.3),
                spans: vec![(contact_s - half_s, contact_s + half_s, MODELS[1], 0.5)],
                lines: vec![Line { points, colour: MEASURED, width: 2 }],
                ..Chart::default()
            };
            let words = format!("{name}, of {}, about the contact", offset.trial);
            figures.push(html::figure(&format!("{}: {name}", offset.trial), "", &words, &chart.svg()));
        }
    }
    let legend = [
        ("line measured", "distance from the rest before, by the first stream's clock"),
        ("line m1", "the contact, with the 95 % interval of the clock"),
    ];
    html::figures_page("Clocks", &sentence, &legend, &figures)
}
