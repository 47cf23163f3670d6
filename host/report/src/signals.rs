//! The page of `stickslip check`: the signals and frames of a data set as they were understood, so that
//! swapped fingers, millimetres and wrong signs are seen.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use nalgebra::Vector3;
use plotters::style::RGBColor;
use stickslip_analysis::channels;
use stickslip_analysis::check::Report;
use stickslip_data::{Description, Index, ObjectSpec, Pose, Sample, Trial, Wrench};
use stickslip_shared::track;

use super::html::{escape, page as whole};
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
    let mut body = format!(
        "<h1>stickslip check: {}</h1>\n<p class=\"verdict\">{verdict}</p>\n<div class=\"facts\"><span><b>{}</b> \
         trials</span><span><b>{}</b> samples</span></div>\n",
        escape(&report.name),
        report.trials,
        report.samples
    );
    for finding in &findings {
        let _ = writeln!(body, "<p>{}</p>", escape(finding));
    }
    body += "<p>Below, one trial of each primitive as it was understood. The arrows are mean forces on the object over \
             the loaded part of the trial: finger 1 presses towards -Y of the gripper, finger 2 towards +Y, a pusher \
             away from itself.</p>\n<div class=\"legend\">";
    for (name, colour) in ["finger 1", "finger 2", "pusher"].into_iter().zip(BODIES) {
        let _ = write!(
            body,
            "<span><i class=\"swatch line\" style=\"background:{}\"></i>{name}</span>",
            hex(colour).to_lowercase()
        );
    }
    body += "</div>\n";
    for trial in trials {
        body += &section(description, trial);
    }
    whole(&format!("stickslip check: {}", report.name), &body)
}

fn section(description: &Description, trial: &Trial) -> String {
    let mut text = format!(
        "<h2>{}</h2>\n<p>{}, {}</p>\n<div class=\"grid\">\n",
        escape(&trial.info.trial),
        escape(&trial.info.primitive),
        escape(&trial.info.object)
    );
    let object = description.objects.iter().find(|object| object.id == trial.info.object);
    for (title, right, up) in
        [("from the side: x, z", 0, 2), ("from above: x, y", 0, 1), ("from the end: y, z", 1, 2)]
    {
        let _ = writeln!(
            text,
            "<figure><figcaption>{title}<span>world, mm</span></figcaption>{}</figure>",
            drawing(object, trial, right, up)
        );
    }
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
        let _ = writeln!(
            text,
            "<figure><figcaption>{title}<span>{unit}</span></figcaption>{}</figure>",
            chart.svg()
        );
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
    text + "</div>\n"
}

/// The cells that were measured, thinned: an empty cell is no gap in the line of a slower sensor.
fn measured(times: &[f64], values: &[f64]) -> Vec<(f64, f64)> {
    let (t, v): (Vec<f64>, Vec<f64>) =
        times.iter().zip(values).filter(|(_, value)| value.is_finite()).unzip();
    thinned(&t, &v, POINTS)
}

/// Corners of the object about its centre, object axes.
fn corners(object: &ObjectSpec) -> Vec<Vector3<f64>> {
    let both = [-0.5, 0.5];
    if let Some(vertices) = &object.vertices_m {
        let height = object.height_m.unwrap_or_default();
        return both
            .iter()
            .flat_map(|z| vertices.iter().map(move |[x, y]| Vector3::new(*x, *y, z * height)))
            .collect();
    }
    let (length, side) = (object.length_m.unwrap_or_default(), object.side_m.unwrap_or_default());
    let ring: Vec<[f64; 2]> = if object.shape == "cylinder" {
        (0..24)
            .map(|k| f64::from(k) * std::f64::consts::TAU / 24.0)
            .map(|angle| [angle.cos() * side / 2.0, angle.sin() * side / 2.0])
            .collect()
    } else {
        both.iter().flat_map(|y| both.map(|z| [y * side, z * side])).collect()
    };
    both.iter().flat_map(|x| ring.iter().map(move |[y, z]| Vector3::new(x * length, *y, *z))).collect()
}

/// What a body exerts, drawn as an arrow.
struct Arrow {
    from: Vector3<f64>,
    force_n: Vector3<f64>,
    colour: RGBColor,
}

/// The bench at the trial's start, seen along the axis that is neither `right` nor `up`.
fn drawing(object: Option<&ObjectSpec>, trial: &Trial, right: usize, up: usize) -> String {
    let first = |measured: fn(&Sample) -> Option<Pose>| {
        trial.samples.iter().find_map(measured).as_ref().map(channels::pose)
    };
    let (Some(spec), Some(at)) = (object, first(|sample| sample.object)) else {
        return "<p>The object's pose is not measured.</p>".to_owned();
    };
    let place = |at: &track::Pose<f64>, local: Vector3<f64>| at.position_m + at.rotation * local;
    let outline: Vec<[f64; 2]> =
        hull(corners(spec).into_iter().map(|corner| place(&at, corner)).map(|p| [p[right], p[up]]).collect());
    let mut arrows = Vec::new();
    let mut points = outline.clone();
    if let Some(gripper) = first(|sample| sample.gripper) {
        let half = spec.side_m.unwrap_or(0.02) / 2.0;
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

/// Convex outline of points, counter-clockwise (Andrew's monotone chain).
fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let turn =
        |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && turn(a, b, point) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut outline = half(&mut points.iter().copied());
    outline.extend(half(&mut points.iter().rev().copied()));
    outline
}

fn hex(colour: RGBColor) -> String {
    let RGBColor(r, g, b) = colour;
    format!("#{r:02X}{g:02X}{b:02X}")
}

#[cfg(test)]
mod tests {
    use super::hull;

    #[test]
    fn the_outline_of_a_square_with_points_inside_is_the_square() {
        let points = vec![[0.0, 0.0], [1.0, 1.0], [0.5, 0.5], [1.0, 0.0], [0.2, 0.7], [0.0, 1.0]];
        assert_eq!(hull(points), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    }
}
