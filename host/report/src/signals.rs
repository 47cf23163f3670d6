//! The page of `stickslip check`: the signals and frames of a data set as they were understood, so that
//! swapped fingers, millimetres and wrong signs are seen.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use nalgebra::Vector3;
use plotters::style::RGBColor;
use stickslip_analysis::channels;
use stickslip_analysis::check::Report;
use stickslip_analysis::run::simulate::scene;
use stickslip_data::{Description, Index, Pose, Sample, Trial, Wrench};
use stickslip_shared::model::Shape;
use stickslip_shared::track;

use maud::{Markup, html};

use super::html::{Tone, figure, first_screen, page as whole};
use super::outline::{corners, hull};
use super::plot::{Chart, Line, MEASURED, MODELS, thinned};

const SIZE: (u32, u32) = (360, 170);
const POINTS: usize = 300;
/// Side of a drawing, pixels.
const VIEW: f64 = 340.0;
/// Room about the bodies, as a share of their extent.
const MARGIN: f64 = 0.35;
/// Colours of finger 1, finger 2, pusher.
const BODIES: [RGBColor; 3] = [MODELS[0], MODELS[1], MODELS[2]];

/// Most trials that a page shows.
const SHOWN: usize = 6;

/// Trials for a page: the first good one of each primitive and object.
#[must_use]
pub fn examples(index: &Index) -> Vec<Trial> {
    let mut seen = BTreeSet::new();
    let mut trials = Vec::new();
    for info in &index.trials {
        let kind = (&info.primitive, &info.object);
        if trials.len() < SHOWN && !seen.contains(&kind) {
            let read = index.read_trial_lenient(info).trial;
            if let Some(trial) = read {
                seen.insert(kind);
                trials.push(trial);
            }
        }
    }
    trials
}

/// The whole page: what `report` found, then each of `trials`.
#[must_use]
pub fn page(report: &Report, description: &Description, trials: &[Trial]) -> String {
    let findings: Vec<String> = report.findings.iter().map(ToString::to_string).collect();
    let verdict = match findings.len() {
        0 => "No physics errors.".to_owned(),
        1 => "1 physics error: the data cannot be as they stand.".to_owned(),
        count => format!("{count} physics errors: the data cannot be as they stand."),
    };
    let tone = if findings.is_empty() { Tone::Good } else { Tone::Bad };
    let explained = "One trial of each primitive as it was understood. The arrows are mean forces on the object over the \
                     loaded part of the trial: finger 1 presses towards -Y of the gripper, finger 2 towards +Y, a pusher \
                     away from itself.";
    let body = html! {
        (first_screen(("check", &report.name), (tone, &verdict), &html! {}, ""))
        div class="facts" {
            span { b { (report.trials) } " trials" }
            span { b { (report.samples) } " samples" }
        }
        @for finding in &findings { p { (finding) } }
        h2 { "What was understood" }
        p { (explained) }
        div class="legend" {
            @for (k, name) in ["finger 1", "finger 2", "pusher"].into_iter().enumerate() {
                (super::html::swatch(&format!("line m{k}"), name))
            }
        }
        @for trial in trials { (section(description, trial)) }
    };
    whole(&format!("stickslip check: {}", report.name), body)
}

fn section(description: &Description, trial: &Trial) -> Markup {
    let shape = scene(description, trial).ok().map(|scene| scene.object.shape);
    let mut figures: Vec<Markup> =
        [("from the side: x, z", 0, 2), ("from above: x, y", 0, 1), ("from the end: y, z", 1, 2)]
            .into_iter()
            .map(|(title, right, up)| {
                let drawn = drawing(shape.as_ref(), trial, right, up);
                figure(title, "world, mm", &format!("the bench {title}"), &drawn)
            })
            .collect();
    let times: Vec<f64> = trial.samples.iter().map(|sample| sample.t_s).collect();
    let mut chart = |title: &str, unit: &str, lines: Vec<(Vec<f64>, RGBColor)>| {
        if lines.iter().all(|(values, _)| values.iter().all(|value| !value.is_finite())) {
            return;
        }
        let chart = Chart {
            size: SIZE,
            x_label: "time, s".into(),
            lines: lines
                .into_iter()
                .map(|(values, colour)| Line { points: measured(&times, &values), colour, width: 2 })
                .collect(),
            ..Chart::default()
        };
        figures.push(figure(title, unit, &format!("{title} over time"), &chart.svg()));
    };
    let of = |get: &dyn Fn(&Sample) -> Option<f64>| -> Vec<f64> {
        trial.samples.iter().map(|sample| get(sample).unwrap_or(f64::NAN)).collect()
    };
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let place =
            |body: fn(&Sample) -> Option<Pose>| of(&|sample| Some(body(sample)?.position_m[axis] * 1e3));
        chart(
            &format!("position {name}: object, gripper (grey)"),
            "mm",
            vec![(place(|sample| sample.gripper), MEASURED), (place(|sample| sample.object), MODELS[3])],
        );
    }
    for (what, unit, scale, pick) in [
        ("force", "N", 1.0, (|wrench: Wrench| wrench.force_n) as fn(Wrench) -> [f64; 3]),
        ("torque", "N mm", 1e3, |wrench: Wrench| wrench.torque_nm),
    ] {
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let line = |wrench: fn(&Sample) -> Option<Wrench>| {
                of(&|sample| Some(pick(wrench(sample)?)[axis] * scale))
            };
            chart(
                &format!("{what} {name}"),
                unit,
                vec![
                    (line(|sample| sample.finger[0]), BODIES[0]),
                    (line(|sample| sample.finger[1]), BODIES[1]),
                    (line(|sample| sample.pusher_wrench), BODIES[2]),
                ],
            );
        }
    }
    html! {
        h2 { (trial.info.trial) }
        p { (trial.info.primitive.replace('_', " ")) ", " (trial.info.object) }
        div class="grid" { @for one in &figures { (one) } }
    }
}

/// The cells that were measured, thinned: an empty cell is no gap in the line of a slower sensor.
fn measured(times: &[f64], values: &[f64]) -> Vec<(f64, f64)> {
    let (t, v): (Vec<f64>, Vec<f64>) =
        times.iter().zip(values).filter(|(_, value)| value.is_finite()).unzip();
    thinned(&t, &v, POINTS)
}

/// What a body exerts, drawn as an arrow.
struct Arrow {
    from: Vector3<f64>,
    force_n: Vector3<f64>,
    colour: RGBColor,
}

/// The bench at the trial's start, seen along the axis that is neither `right` nor `up`.
fn drawing(object: Option<&Shape<f64>>, trial: &Trial, right: usize, up: usize) -> String {
    let first = |measured: fn(&Sample) -> Option<Pose>| {
        trial.samples.iter().find_map(measured).as_ref().map(channels::pose)
    };
    let (Some(shape), Some(at)) = (object, first(|sample| sample.object)) else {
        return "<p>The object's pose is not measured.</p>".to_owned();
    };
    let place = |at: &track::Pose<f64>, local: Vector3<f64>| at.position_m + at.rotation * local;
    let outline: Vec<[f64; 2]> = hull(
        corners(shape).into_iter().map(|corner| place(&at, corner)).map(|p| [p[right], p[up]]).collect(),
    );
    let mut arrows = Vec::new();
    let mut points = outline.clone();
    if let Some(gripper) = first(|sample| sample.gripper) {
        let half = corners(shape).iter().map(|c| c.y).fold(0.0, f64::max);
        for (finger, side) in [1.0, -1.0].into_iter().enumerate() {
            let from = place(&gripper, Vector3::new(0.0, side * half, 0.0));
            points.push([from[right], from[up]]);
            let force = mean(trial, |sample| sample.finger[finger]).map(|force| gripper.rotation * force);
            arrows.extend(force.map(|force_n| Arrow { from, force_n, colour: BODIES[finger] }));
        }
    }
    let pusher = first(|sample| sample.pusher).or(trial.info.pusher.as_ref().map(channels::pose));
    if let Some(pusher) = pusher {
        let from = pusher.position_m;
        points.push([from[right], from[up]]);
        let force = mean(trial, |sample| sample.pusher_wrench);
        arrows.extend(force.map(|force_n| Arrow { from, force_n, colour: BODIES[2] }));
    }
    let low = [0, 1].map(|k| points.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min));
    let high = [0, 1].map(|k| points.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max));
    let extent = (high[0] - low[0]).max(high[1] - low[1]).max(1e-3);
    let scale = VIEW / (extent * (1.0 + 2.0 * MARGIN));
    let centre = [0, 1].map(|k| 0.5 * (low[k] + high[k]));
    let pixel =
        |p: [f64; 2]| [VIEW / 2.0 + (p[0] - centre[0]) * scale, VIEW / 2.0 - (p[1] - centre[1]) * scale];
    let mut svg = format!("<svg role=\"img\" viewBox=\"0 0 {VIEW} {VIEW}\">\n");
    let corners: Vec<String> =
        outline.iter().map(|p| pixel(*p)).map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    let _ = writeln!(
        svg,
        "<polygon points=\"{}\" fill=\"#888888\" fill-opacity=\"0.18\" stroke=\"#888888\" stroke-width=\"1.5\"/>",
        corners.join(" ")
    );
    let most = arrows.iter().map(|arrow| arrow.force_n.norm()).fold(1e-9, f64::max);
    for Arrow { from, force_n, colour } in &arrows {
        let [x, y] = pixel([from[right], from[up]]);
        let reach = VIEW * 0.22 / most;
        let (dx, dy) = (force_n[right] * reach, -force_n[up] * reach);
        let colour = hex(*colour);
        let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"{colour}\"/>");
        let length = dx.hypot(dy);
        if length > 6.0 {
            let (ux, uy) = (dx / length, dy / length);
            let (tx, ty) = (x + dx, y + dy);
            let _ = writeln!(
                svg,
                "<path d=\"M{x:.1} {y:.1}L{tx:.1} {ty:.1}M{:.1} {:.1}L{tx:.1} {ty:.1}L{:.1} {:.1}\" fill=\"none\" \
                 stroke=\"{colour}\" stroke-width=\"2.5\"/>",
                tx - 8.0 * ux - 5.0 * uy,
                ty - 8.0 * uy + 5.0 * ux,
                tx - 8.0 * ux + 5.0 * uy,
                ty - 8.0 * uy - 5.0 * ux
            );
        }
        // A force along the line of sight is named in another view.
        if length > 0.4 * force_n.norm() * reach {
            let _ = writeln!(
                svg,
                "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"12\" fill=\"#222222\">{:.1} N</text>",
                (x + dx).clamp(4.0, VIEW - 50.0),
                (y + dy - 6.0).clamp(12.0, VIEW - 4.0),
                force_n.norm()
            );
        }
    }
    // A scale of 20 mm.
    let bar = 0.02 * scale;
    let _ = writeln!(
        svg,
        "<path d=\"M10 {0}h{bar:.1}\" stroke=\"#888888\" stroke-width=\"2\"/><text x=\"10\" y=\"{1}\" font-size=\"12\" \
         fill=\"#222222\">20 mm</text>\n</svg>",
        VIEW - 10.0,
        VIEW - 15.0
    );
    svg
}

/// Mean force over the half of the samples in which it is largest, N.
fn mean(trial: &Trial, of: impl Fn(&Sample) -> Option<Wrench>) -> Option<Vector3<f64>> {
    let mut forces: Vec<Vector3<f64>> = trial
        .samples
        .iter()
        .filter_map(|sample| Some(Vector3::from(of(sample)?.force_n)))
        .filter(|force| force.iter().all(|component| component.is_finite()))
        .collect();
    forces.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
    forces.truncate(forces.len().div_ceil(2));
    let count = forces.len() as f64;
    (!forces.is_empty()).then(|| forces.iter().sum::<Vector3<f64>>() / count)
}

fn hex(colour: RGBColor) -> String {
    let RGBColor(r, g, b) = colour;
    format!("#{r:02X}{g:02X}{b:02X}")
}
