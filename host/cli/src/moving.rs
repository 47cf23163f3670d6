//! A lift as a moving picture: with the planned grip beside the advised one, seen from the side.
//!
//! SVG with SMIL: it moves wherever a picture does, in a README too, without a script.

use std::fmt::Write as _;

use stickslip_rig::Exact;

use crate::grip_loop::Trial;

/// Of one panel, pixels.
const PANEL: (f64, f64) = (360.0, 300.0);
/// Of the grip's course below it.
const COURSE: f64 = 70.0;
/// Pixels a metre.
const SCALE: f64 = 1500.0;
/// Pictures in the course of the trial, and held at its end.
const PICTURES: (usize, usize) = (72, 14);
/// Prism of the rig's `obj4`, m.
const PRISM: (f64, f64) = (0.1, 0.025);
/// The pad, m.
const PAD_M: f64 = 0.02;
/// Beyond this from where it was held the object is lost, m.
const LOST_M: f64 = 0.03;

/// What is shown of a moment: places in pixels from the panel's corner, degrees.
struct Moment {
    gripper: [f64; 2],
    object: [f64; 2],
    turned: f64,
    lost: bool,
}

/// Both lifts of `trial`, in its own time, again and again.
#[must_use]
pub fn picture(trial: &Trial) -> String {
    let end_s = trial.exact.iter().filter_map(|exact| exact.last()).map(|e| e.t_s).fold(0.0, f64::max);
    let most_n = trial.exact.iter().flatten().map(|e| e.grip_n).fold(0.0, f64::max);
    let shown_s = end_s * (PICTURES.0 + PICTURES.1) as f64 / PICTURES.0 as f64;
    let (width, height) = (2.0 * PANEL.0, PANEL.1 + COURSE);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"sans-serif\" \
         font-size=\"13\">\n<title>A lift, {}: lost with the planned grip, kept with the grip that the prediction \
         advises</title>\n<rect width=\"{width:.0}\" height=\"{height:.0}\" rx=\"6\" fill=\"#fbfbf9\"/>\n",
        trial.pair.scenario
    );
    let names = ["grip as planned", "grip as advised"];
    let colours = ["#555555", "#0072b2"];
    for (panel, ((exact, name), colour)) in trial.exact.iter().zip(names).zip(colours).enumerate() {
        let left = panel as f64 * PANEL.0;
        let _ = write!(
            svg,
            "<svg x=\"{left:.0}\" width=\"{:.0}\" height=\"{height:.0}\">\n<text x=\"16\" y=\"24\" fill=\"{colour}\" \
             font-weight=\"bold\">{name}</text>\n",
            PANEL.0
        );
        side(&mut svg, &moments(exact, end_s), shown_s);
        course(&mut svg, exact, [end_s, most_n], colour, shown_s);
        svg.push_str("</svg>\n");
    }
    svg.push_str("</svg>\n");
    svg
}

/// The moments that are shown; the last is held.
fn moments(exact: &[Exact], end_s: f64) -> Vec<Moment> {
    let Some(start) = exact.first() else { return Vec::new() };
    let held = |e: &Exact| e.object.0[2] - e.gripper.0[2];
    let floor_m = start.object.0[2] - PRISM.1 / 2.0;
    let place = |[x, _, z]: [f64; 3]| {
        [0.44 * PANEL.0 + (x - start.object.0[0]) * SCALE, PANEL.1 - 24.0 - (z - floor_m) * SCALE]
    };
    let last = PICTURES.0 - 1;
    (0..PICTURES.0 + PICTURES.1)
        .filter_map(|k| {
            let t_s = end_s * k.min(last) as f64 / last as f64;
            let at = exact.partition_point(|e| e.t_s < t_s).min(exact.len() - 1);
            let e = exact.get(at)?;
            let [w, x, y, z] = e.object.1;
            Some(Moment {
                gripper: place(e.gripper.0),
                object: place(e.object.0),
                // About world y, which points away from the reader: clockwise, as SVG turns.
                turned: (2.0 * (w * y + x * z)).atan2(1.0 - 2.0 * (y * y + z * z)).to_degrees(),
                lost: (held(e) - held(start)).abs() > LOST_M,
            })
        })
        .collect()
}

/// An animated attribute: one value for each moment.
fn values(moments: &[Moment], of: impl Fn(&Moment) -> String) -> String {
    moments.iter().map(of).collect::<Vec<_>>().join(";")
}

fn side(svg: &mut String, moments: &[Moment], shown_s: f64) {
    let again = format!("dur=\"{shown_s:.2}s\" repeatCount=\"indefinite\"");
    let moved = |kind: &str, values: String| {
        format!("<animateTransform attributeName=\"transform\" type=\"{kind}\" values=\"{values}\" {again}/>")
    };
    let floor = PANEL.1 - 24.0;
    let (w, h, pad) = (PRISM.0 * SCALE, PRISM.1 * SCALE, PAD_M * SCALE / 2.0);
    let object = values(moments, |m| format!("{:.1},{:.1}", m.object[0], m.object[1]));
    let turned = values(moments, |m| format!("{:.1}", m.turned));
    let gripper = values(moments, |m| format!("{:.1},{:.1}", m.gripper[0], m.gripper[1]));
    let lost = values(moments, |m| u8::from(m.lost).to_string());
    let _ = write!(
        svg,
        "<line x1=\"10\" x2=\"{:.0}\" y1=\"{floor:.0}\" y2=\"{floor:.0}\" stroke=\"#999\" stroke-width=\"2\"/>\n\
         <g>{}<g>{}<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{w:.1}\" height=\"{h:.1}\" rx=\"2\" fill=\"#c9b37e\" \
         stroke=\"#7a6a3f\"/></g></g>\n\
         <g>{}<rect x=\"-7\" y=\"-400\" width=\"14\" height=\"400\" fill=\"#33383d\" opacity=\"0.75\"/><circle r=\"{pad:.1}\" \
         fill=\"#33383d\" opacity=\"0.75\"/></g>\n\
         <text x=\"{:.0}\" y=\"24\" fill=\"#c0392b\" font-weight=\"bold\" opacity=\"0\">lost<animate \
         attributeName=\"opacity\" calcMode=\"discrete\" values=\"{lost}\" {again}/></text>\n",
        PANEL.0 - 10.0,
        moved("translate", object),
        moved("rotate", turned),
        -w / 2.0,
        -h / 2.0,
        moved("translate", gripper),
        PANEL.0 - 60.0
    );
}

/// The grip's course with a line that runs along; `most`: s, N.
fn course(svg: &mut String, exact: &[Exact], [end_s, most_n]: [f64; 2], colour: &str, shown_s: f64) {
    let (left, right) = (16.0, PANEL.0 - 16.0);
    let x = |t_s: f64| left + (right - left) * t_s / end_s.max(f64::MIN_POSITIVE);
    let bottom = PANEL.1 + COURSE - 12.0;
    let y = |n: f64| bottom - (COURSE - 26.0) * n / most_n.max(f64::MIN_POSITIVE);
    let every = exact.len().div_ceil(150).max(1);
    let points: Vec<String> =
        exact.iter().step_by(every).map(|e| format!("{:.1},{:.1}", x(e.t_s), y(e.grip_n))).collect();
    let share = PICTURES.0 as f64 / (PICTURES.0 + PICTURES.1) as f64;
    let _ = write!(
        svg,
        "<text x=\"{left:.0}\" y=\"{:.0}\" fill=\"{colour}\" font-size=\"11\">grip commanded, up to {:.0} N</text>\n\
         <polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>\n\
         <line x1=\"{left:.0}\" x2=\"{left:.0}\" y1=\"{:.0}\" y2=\"{bottom:.0}\" stroke=\"#999\">{}{}</line>\n",
        PANEL.1 + 2.0,
        exact.iter().map(|e| e.grip_n).fold(0.0, f64::max),
        points.join(" "),
        PANEL.1 + 8.0,
        run(left, right, share, shown_s, "x1"),
        run(left, right, share, shown_s, "x2")
    );
}

fn run(left: f64, right: f64, share: f64, shown_s: f64, attribute: &str) -> String {
    format!(
        "<animate attributeName=\"{attribute}\" values=\"{left:.0};{right:.0};{right:.0}\" keyTimes=\"0;{share:.3};1\" \
         dur=\"{shown_s:.2}s\" repeatCount=\"indefinite\"/>"
    )
}
