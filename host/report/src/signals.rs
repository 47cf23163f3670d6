//! Signals and frames of a data set as they were understood, so that swapped fingers, millimetres and wrong signs
//! are seen: the page of `stickslip check`, and what that of `import` shows below its own.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use nalgebra::{UnitQuaternion, Vector3};
use plotters::style::RGBColor;
use stickslip_analysis::channels;
use stickslip_analysis::check::Report;
use stickslip_analysis::run::scene::scene;
use stickslip_data::import::recording::SensorFrame;
use stickslip_data::{Description, Index, Pose, Sample, Trial, Wrench};
use stickslip_shared::model::Shape;
use stickslip_shared::track;

use maud::{Markup, html};

use super::html::{Tone, figure, first_screen, left_out, list, page as whole, swatch, unfold};
use super::outline::{corners, hull};
use super::plot::MODELS;
use super::viewer::{self, Plot, Run};

/// Side of a drawing, pixels.
const VIEW: f64 = 340.0;
/// Room above and below what is drawn, px.
const ROOM: f64 = 44.0;
/// Room of a force's text, px.
const TEXT: [f64; 2] = [46.0, 14.0];
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

/// The first of each primitive and object, as [`examples`].
#[must_use]
pub fn first_of_each(trials: &[Trial]) -> Vec<Trial> {
    let mut seen = BTreeSet::new();
    let new = trials.iter().filter(|trial| seen.insert((&trial.info.primitive, &trial.info.object)));
    new.take(SHOWN).cloned().collect()
}

/// The whole page: what `report` found, then each of `trials`; `next` is the command that comes next.
#[must_use]
pub fn page(report: &Report, description: &Description, trials: &[Trial], next: &str) -> String {
    let (tone, sentence) = verdict(report);
    let seen = html! {
        (left_out(&report.left_out, &report.errors, report.trials))
        (picture(description, &[], trials))
    };
    let body = html! {
        (first_screen(("check", &report.name), (tone, &sentence), &seen, next))
        div class="facts" {
            span { b { (report.trials) } " trials" }
            span { b { (report.samples) } " samples" }
        }
        (list("Physics errors", &findings(report)))
        (suspects(report))
        (understood(description, &[], trials))
    };
    whole(&format!("stickslip check: {}", report.name), body)
}

/// Sensors that explain why the forces do not balance, and what to do.
pub(crate) fn suspects(report: &Report) -> Markup {
    html! { @for text in report.warnings.iter().filter(|_| !report.suspects.is_empty()) {
        @if text.text.contains("do not balance") { p { (text.text) } }
    } }
}

/// What cannot be in the data.
pub(crate) fn findings(report: &Report) -> Vec<String> {
    report.findings.iter().map(ToString::to_string).collect()
}

/// What physics says of the data, in a sentence.
#[must_use]
pub fn verdict(report: &Report) -> (Tone, String) {
    let count = report.findings.len();
    match (count, report.errors.len(), report.balance.failing) {
        (1.., ..) => {
            (Tone::Bad, format!("{}: the data contradict physics.", counted(count, "physics error")))
        }
        (0, 1.., _) => {
            (Tone::Bad, format!("{} refused; the rest was read.", counted(report.errors.len(), "error")))
        }
        (0, 0, 1..) => (
            Tone::Fair,
            format!(
                "Forces do not balance in {} of {}{}",
                report.balance.failing,
                counted(report.balance.checked, "trial"),
                match report.suspects.as_slice() {
                    [] => ".".to_owned(),
                    suspects => {
                        let all: Vec<String> = suspects.iter().map(ToString::to_string).collect();
                        format!("; {} would explain it.", all.join(", or "))
                    }
                }
            ),
        ),
        _ => (Tone::Good, format!("No physics error in these {}.", counted(report.trials, "trial"))),
    }
}

/// '3 trials', '1 trial'.
pub(crate) fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// The first trial from three sides, with the `sensors` that are placed or turned.
pub(crate) fn picture(description: &Description, sensors: &[SensorFrame], trials: &[Trial]) -> Markup {
    html! { @if let Some(trial) = trials.first() { (views(description, sensors, trial)) } }
}

/// Bench and signals of `trials` as they were understood.
pub(crate) fn understood(description: &Description, sensors: &[SensorFrame], trials: &[Trial]) -> Markup {
    html! {
        @if let Some((_, others)) = trials.split_first() {
            p class="soft" {
                "Arrows are mean forces on the object over the loaded part of the trial: finger 1 presses towards -y of \
                 the gripper, finger 2 towards +y, a pusher away from itself. Thin lines are the axes of world, gripper and \
                 object at the start (a dot: along the line of sight), and of a sensor that the mapping turns or sets off \
                 from the contact, to which a dashed line leads."
            }
            @if !others.is_empty() {
                (unfold("Other primitives and objects", &html! { @for trial in others { (views(description, sensors, trial)) } }))
            }
            (courses(trials))
        }
    }
}

/// The bench of a trial from three sides.
fn views(description: &Description, sensors: &[SensorFrame], trial: &Trial) -> Markup {
    let shape = scene(description, trial).ok().map(|scene| scene.object.shape);
    let sides = [("from the side: x, z", 0, 2), ("from above: x, y", 0, 1), ("from the end: y, z", 1, 2)];
    html! {
        h2 { (trial.info.trial) ": " (trial.info.primitive.replace('_', " ")) ", " (trial.info.object) }
        div class="legend" {
            @for (k, name) in ["finger 1", "finger 2", "pusher"].into_iter().enumerate() {
                (swatch(&format!("line m{k}"), name))
            }
        }
        div class="views" {
            @for (title, right, up) in sides {
                @let drawn = drawing(shape.as_ref(), sensors, trial, right, up);
                (figure(title, "world, mm", &format!("the bench {title}"), &drawn))
            }
        }
    }
}

/// Every signal over time.
fn courses(trials: &[Trial]) -> Markup {
    let mut plots = Vec::new();
    let mut values: Vec<Vec<Vec<Vec<f64>>>> = vec![Vec::new(); trials.len()];
    let mut add = |title: String, unit: &'static str, lines: &[(&str, &str, Column)]| {
        let of = |trial: &Trial| -> Vec<Vec<f64>> {
            lines
                .iter()
                .map(|(.., get)| trial.samples.iter().map(|s| get(s).unwrap_or(f64::NAN)).collect())
                .collect()
        };
        let columns: Vec<_> = trials.iter().map(of).collect();
        if !columns.iter().flatten().flatten().any(|x| x.is_finite()) {
            return;
        }
        let line = |(label, ink, _): &(&str, &str, Column)| viewer::Line {
            label: (*label).to_owned(),
            ink: (*ink).to_owned(),
            dash: false,
        };
        plots.push(Plot {
            id: title.replace(' ', "-"),
            title,
            unit,
            least: 0.0,
            most: None,
            names: Vec::new(),
            lines: lines.iter().map(line).collect(),
            first: true,
        });
        values.iter_mut().zip(columns).for_each(|(all, columns)| all.push(columns));
    };
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let place = |body: fn(&Sample) -> Option<Pose>| -> Column {
            Box::new(move |sample| Some(body(sample)?.position_m[axis] * 1e3))
        };
        let gripper = place(|sample| sample.gripper);
        let (object, pusher) = (place(|sample| sample.object), place(|sample| sample.pusher));
        add(
            format!("position {name}"),
            "mm",
            &[("gripper", "measured", gripper), ("object", "m3", object), ("pusher", "m2", pusher)],
        );
    }
    for (what, unit, scale, pick) in [
        ("force", "N", 1.0, (|wrench: Wrench| wrench.force_n) as fn(Wrench) -> [f64; 3]),
        ("torque", "N mm", 1e3, |wrench: Wrench| wrench.torque_nm),
    ] {
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let line = |wrench: fn(&Sample) -> Option<Wrench>| -> Column {
                Box::new(move |sample| Some(pick(wrench(sample)?)[axis] * scale))
            };
            let fingers = [line(|sample| sample.finger[0]), line(|sample| sample.finger[1])];
            let [one, two] = fingers;
            add(
                format!("{what} {name}"),
                unit,
                &[
                    ("finger 1", "m0", one),
                    ("finger 2", "m1", two),
                    ("pusher", "m2", line(|s| s.pusher_wrench)),
                ],
            );
        }
    }
    let runs: Vec<Run> = trials
        .iter()
        .zip(values)
        .map(|(trial, values)| Run {
            id: trial.info.trial.clone(),
            role: String::new(),
            words: format!("{}, {}", trial.info.primitive.replace('_', " "), trial.info.object),
            t_s: trial.samples.iter().map(|sample| sample.t_s).collect(),
            half: vec![Vec::new(); values.len()],
            open: vec![Vec::new(); values.len()],
            values,
            spans: Vec::new(),
            scenery: None,
        })
        .collect();
    let legend = html! {
        div class="legend" {
            (swatch("line measured", "gripper")) (swatch("line m3", "object"))
            (swatch("line m0", "finger 1")) (swatch("line m1", "finger 2")) (swatch("line m2", "pusher"))
        }
    };
    let chooser = html! {
        @if trials.len() > 1 {
            div class="flow" {
                @for (k, trial) in trials.iter().enumerate() {
                    button type="button" class="plain" data-run=(k) aria-pressed="false" { (trial.info.trial) }
                }
            }
        }
    };
    viewer::viewer("Signals as they were understood", &legend, &chooser, &plots, &runs)
}

/// A signal of a sample, in the unit that is shown.
type Column = Box<dyn Fn(&Sample) -> Option<f64>>;

/// Axes of a frame.
struct Triad {
    name: &'static str,
    at: Vector3<f64>,
    rotation: UnitQuaternion<f64>,
    /// Length of an axis, px.
    reach: f64,
    colour: String,
    /// Where a line leads to.
    to: Option<Vector3<f64>>,
}

/// Lengths of axes: the object's often begin where the gripper's do, px.
const REACH: [f64; 2] = [30.0, 17.0];
/// Of what is no force.
const PLAIN: &str = "#555555";

/// What a body exerts, drawn as an arrow.
struct Arrow {
    from: Vector3<f64>,
    force_n: Vector3<f64>,
    colour: RGBColor,
}

/// The bench at the trial's start, seen along the axis that is neither `right` nor `up`.
fn drawing(
    object: Option<&Shape<f64>>,
    sensors: &[SensorFrame],
    trial: &Trial,
    right: usize,
    up: usize,
) -> String {
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
    let mut triads = vec![Triad {
        name: "object",
        at: at.position_m,
        rotation: at.rotation,
        reach: REACH[1],
        colour: PLAIN.to_owned(),
        to: None,
    }];
    let sensor = |k: usize, contact: Vector3<f64>, ours: UnitQuaternion<f64>| {
        let found = sensors.iter().find(|sensor| sensor.signal == ["finger1", "finger2", "pusher"][k])?;
        Some(Triad {
            name: "sensor",
            at: contact + ours * found.origin_m,
            rotation: ours * found.rotation,
            reach: REACH[1],
            colour: hex(BODIES[k]),
            to: Some(contact),
        })
    };
    if let Some(gripper) = first(|sample| sample.gripper) {
        triads.push(Triad {
            name: "gripper",
            at: gripper.position_m,
            rotation: gripper.rotation,
            reach: REACH[0],
            colour: PLAIN.to_owned(),
            to: None,
        });
        let half = corners(shape).iter().map(|c| c.y).fold(0.0, f64::max);
        for (finger, side) in [1.0, -1.0].into_iter().enumerate() {
            let from = place(&gripper, Vector3::new(0.0, side * half, 0.0));
            points.push([from[right], from[up]]);
            triads.extend(sensor(finger, from, gripper.rotation));
            let force = mean(trial, |sample| sample.finger[finger]).map(|force| gripper.rotation * force);
            arrows.extend(force.map(|force_n| Arrow { from, force_n, colour: BODIES[finger] }));
        }
    }
    let pusher = first(|sample| sample.pusher).or(trial.info.pusher.as_ref().map(channels::pose));
    if let Some(pusher) = pusher {
        let from = pusher.position_m;
        points.push([from[right], from[up]]);
        triads.extend(sensor(2, from, UnitQuaternion::identity()));
        let force = mean(trial, |sample| sample.pusher_wrench);
        arrows.extend(force.map(|force_n| Arrow { from, force_n, colour: BODIES[2] }));
    }
    points.extend(triads.iter().map(|triad| [triad.at[right], triad.at[up]]));
    let low = [0, 1].map(|k| points.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min));
    let high = [0, 1].map(|k| points.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max));
    let extent = (high[0] - low[0]).max(high[1] - low[1]).max(1e-3);
    let scale = VIEW / (extent * (1.0 + 2.0 * MARGIN));
    let centre = [0, 1].map(|k| 0.5 * (low[k] + high[k]));
    let most = arrows.iter().map(|arrow| arrow.force_n.norm()).fold(1e-9, f64::max);
    let reach = VIEW * 0.22 / most;
    // As high as object, arrows and their texts need.
    let tips = arrows.iter().map(|a| a.from[up] + a.force_n[up] * reach / scale);
    let ends = points.iter().map(|p| p[1]).chain(tips).map(|y| ((y - centre[1]) * scale).abs());
    let high = (2.0 * (ends.fold(0.0, f64::max) + ROOM)).min(VIEW);
    let pixel =
        |p: [f64; 2]| [VIEW / 2.0 + (p[0] - centre[0]) * scale, high / 2.0 - (p[1] - centre[1]) * scale];
    let mut svg = String::new();
    let corners: Vec<String> =
        outline.iter().map(|p| pixel(*p)).map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    let _ = writeln!(
        svg,
        "<polygon points=\"{}\" fill=\"#888888\" fill-opacity=\"0.18\" stroke=\"#888888\" stroke-width=\"1.5\"/>",
        corners.join(" ")
    );
    let mut placed: Vec<[f64; 2]> = Vec::new();
    for Triad { name, at, rotation, reach, colour, to } in &triads {
        let [x, y] = pixel([at[right], at[up]]);
        if let Some([tx, ty]) = to.map(|to| pixel([to[right], to[up]])) {
            let _ = writeln!(
                svg,
                "<path d=\"M{x:.1} {y:.1}L{tx:.1} {ty:.1}\" stroke=\"{colour}\" stroke-dasharray=\"3 3\"/>"
            );
        }
        axes(&mut svg, [x, y], rotation, [right, up], *reach, colour);
        name_at(&mut svg, &mut placed, [x - TEXT[0], y + TEXT[1]], high, name, colour);
    }
    let corner = [VIEW - REACH[0] - TEXT[1], high - TEXT[1]];
    axes(&mut svg, corner, &UnitQuaternion::identity(), [right, up], REACH[0], PLAIN);
    name_at(&mut svg, &mut placed, [corner[0] - TEXT[0], high - 4.0], high, "world", PLAIN);
    for Arrow { from, force_n, colour } in &arrows {
        let [x, y] = pixel([from[right], from[up]]);
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
            // Beyond the tip, none over another.
            let (lies, ends) = (dx.abs() >= dy.abs(), dx < 0.0);
            let x = x + dx + if ends { -TEXT[0] } else { 4.0 };
            let y = y + dy + if lies { 4.0 } else { 4.0 + 8.0 * dy.signum() };
            let at = free(&mut placed, [x, y], high);
            let _ = writeln!(
                svg,
                "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"12\" fill=\"#222222\">{:.1} N</text>",
                at[0],
                at[1],
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
        high - 10.0,
        high - 15.0
    );
    // Texts that had no room lie below.
    let tall = placed.iter().map(|at| at[1] + 4.0).fold(high, f64::max);
    format!("<svg role=\"img\" viewBox=\"0 0 {VIEW} {tall:.0}\">\n{svg}")
}

/// The axes of a frame from `from`, px; one along the line of sight is a dot.
fn axes(
    svg: &mut String,
    [x, y]: [f64; 2],
    rotation: &UnitQuaternion<f64>,
    [right, up]: [usize; 2],
    reach: f64,
    colour: &str,
) {
    let units = [("x", Vector3::x()), ("y", Vector3::y()), ("z", Vector3::z())];
    for (letter, axis) in units.map(|(letter, unit)| (letter, rotation * unit)) {
        let (dx, dy) = (axis[right] * reach, -axis[up] * reach);
        let length = dx.hypot(dy);
        if length < 0.3 * reach {
            let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2\" fill=\"{colour}\"/>");
            continue;
        }
        let beyond = 1.0 + 5.0 / length;
        let _ = writeln!(
            svg,
            "<path d=\"M{x:.1} {y:.1}l{dx:.1} {dy:.1}\" stroke=\"{colour}\"/><text x=\"{:.1}\" y=\"{:.1}\" font-size=\"9\" \
             text-anchor=\"middle\" fill=\"{colour}\">{letter}</text>",
            x + dx * beyond,
            y + dy * beyond + 3.0
        );
    }
}

/// A frame's name at `at`, px, or below what stands there.
fn name_at(svg: &mut String, placed: &mut Vec<[f64; 2]>, at: [f64; 2], high: f64, name: &str, colour: &str) {
    let at = free(placed, at, high);
    let _ = writeln!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"10\" fill=\"{colour}\">{name}</text>",
        at[0], at[1]
    );
}

/// Where a text for `at`, px, has room: there within the drawing, or below what stands there; taken from now on.
fn free(placed: &mut Vec<[f64; 2]>, at: [f64; 2], high: f64) -> [f64; 2] {
    let mut at = [at[0].clamp(4.0, VIEW - TEXT[0]), at[1].clamp(12.0, high - 4.0)];
    while let Some(p) = placed.iter().find(|p| covers(p, &at)) {
        at[1] = p[1] + TEXT[1];
    }
    placed.push(at);
    at
}

/// Would a text at one of two places lie over that at the other?
fn covers(a: &[f64; 2], b: &[f64; 2]) -> bool {
    // Less what rounding does to a text that was moved by as much.
    (a[0] - b[0]).abs() < TEXT[0] && (a[1] - b[1]).abs() < TEXT[1] - 1e-6
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
