//! What the predictor said over time beside what was measured, as plots: those of a replay and of a score.

use maud::{Markup, html};
use nalgebra::Vector3;

use crate::html::swatch;
use crate::viewer::{self, Plot, Span};
use stickslip_analysis::channels::pose;
use stickslip_data::signal::white_noise;
use stickslip_data::{Description, Sample, Wrench};
use stickslip_shared::predictor::{Prediction, flags};

/// Some time of a trial.
pub struct Seen<'a> {
    /// What dataset.toml says of the sensors.
    pub description: &'a Description,
    /// Time stamps.
    pub t_s: &'a [f64],
    /// One for each time stamp.
    pub samples: &'a [Sample],
    /// One for each time stamp.
    pub predictions: &'a [Prediction],
    /// Phases: the noise of each is found by itself. Empty: all is one.
    pub spans: &'a [Span],
}

/// Plots, and what of a trial they show.
pub struct Courses {
    /// Alike for all trials.
    pub plots: Vec<Plot>,
    /// As in [`viewer::Run`].
    pub values: Vec<Vec<Vec<f64>>>,
    /// As in [`viewer::Run`].
    pub half: Vec<Vec<(usize, f64, f64, f64)>>,
    /// By plot, whether anything is known of it.
    pub known: Vec<bool>,
    /// By plot, whether anything but zero is in it.
    pub moves: Vec<bool>,
}

/// Flags that are drawn: the lowest first.
const ALARMS: [(&str, u32); 7] = [
    ("unsure", flags::UNSURE),
    ("drop", flags::DROP),
    ("sag or rotation", flags::SAG | flags::ROTATION),
    ("slip ahead, finger 2", flags::SLIP_AHEAD_2),
    ("slip ahead, finger 1", flags::SLIP_AHEAD_1),
    ("slip, finger 2", flags::SLIP_2),
    ("slip, finger 1", flags::SLIP_1),
];
/// How far a flag that is up stands above one that is not, of the distance of two.
const UP: f64 = 0.6;
/// More than the friction there is twice over says no more: of a finger without load the sensors show noise over noise.
const MOST_USED: f64 = 2.0;
/// Where the plot that the others explain is.
pub const UTILISATION: &str = "utilisation";

/// A line: label, ink, dashed, values, and where it is measured the noise that is stated of it.
struct Drawn<'a>(&'a str, &'a str, bool, Vec<f64>, Option<f64>);

/// What the colours mean.
pub fn lines() -> Markup {
    html! {
        (swatch("line measured", "measured, with its noise (one standard deviation)"))
        (swatch("line m0", "by the model"))
        (swatch("line m1", "ahead, at the horizon"))
    }
}

/// All of them.
pub fn courses(seen: &Seen) -> Courses {
    let mut out = Courses {
        plots: Vec::new(),
        values: Vec::new(),
        half: Vec::new(),
        known: Vec::new(),
        moves: Vec::new(),
    };
    let p = |get: &dyn Fn(&Prediction) -> f32| -> Vec<f64> {
        seen.predictions.iter().map(|p| f64::from(get(p))).collect()
    };
    let wrench = |k: usize, get: &dyn Fn(&Wrench) -> f64| -> Vec<f64> {
        seen.samples.iter().map(|s| s.finger[k].as_ref().map_or(f64::NAN, get)).collect()
    };
    let measured = |k: usize| p(&move |p| p.finger[k].measured_utilisation.unwrap_or(f32::NAN));
    out.add(
        seen,
        (UTILISATION, "friction used, fingers 1 and 2"),
        ("1", 0.5),
        vec![
            Drawn("by the sensors, finger 1", "measured", false, measured(0), Some(0.0)),
            Drawn("model, finger 1", "m0", false, p(&|p| p.finger[0].model_utilisation), None),
            Drawn("ahead, finger 1", "m1", false, p(&|p| p.finger[0].peak_utilisation), None),
            Drawn("by the sensors, finger 2", "measured", true, measured(1), Some(0.0)),
            Drawn("model, finger 2", "m0", true, p(&|p| p.finger[1].model_utilisation), None),
            Drawn("ahead, finger 2", "m1", true, p(&|p| p.finger[1].peak_utilisation), None),
        ],
    );
    let alarm = |row: usize, bits: u32| -> Vec<f64> {
        let up = |p: &Prediction| if p.flags & bits == 0 { 0.0 } else { UP };
        seen.predictions.iter().map(|p| row as f64 + up(p)).collect()
    };
    let rows = ALARMS.iter().enumerate();
    let ink = |row: usize| if ALARMS[row].0.contains("ahead") { "m1" } else { "m0" };
    out.add(
        seen,
        ("alarms", "flags"),
        ("1", ALARMS.len() as f64),
        rows.map(|(row, (name, bits))| Drawn(name, ink(row), false, alarm(row, *bits), None)).collect(),
    );
    if let Some(plot) = out.plots.last_mut() {
        plot.names = ALARMS.iter().map(|(name, _)| *name).collect();
    }
    let stated = seen.description.sensors.finger.force_noise_n;
    let across = |w: &Wrench| w.force_n[0].hypot(w.force_n[2]);
    for (id, title, get) in [
        (
            "normal-force",
            "normal force, fingers 1 and 2",
            &(|w: &Wrench| w.force_n[1].abs()) as &dyn Fn(&_) -> _,
        ),
        ("tangential-force", "tangential force, fingers 1 and 2", &across),
    ] {
        let line = |k: usize, label| Drawn(label, "measured", k > 0, wrench(k, get), Some(stated));
        let both = vec![line(0, "measured, finger 1"), line(1, "measured, finger 2")];
        out.add(seen, (id, title), ("N", 0.5), both);
    }
    let slip = |k: usize| p(&move |p| p.finger[k].slip_speed_m_s * 1e3);
    out.add(
        seen,
        ("slip", "slip speed"),
        ("mm/s", 1.0),
        vec![Drawn("finger 1", "m0", false, slip(0), None), Drawn("finger 2", "m0", true, slip(1), None)],
    );
    out.add(
        seen,
        ("sag", "way of the object in the grasp"),
        ("mm", 0.2),
        vec![
            Drawn(
                "measured, from the first sample drawn",
                "measured",
                false,
                way_mm(seen.samples),
                Some(0.0),
            ),
            Drawn("sag", "m0", false, p(&|p| p.sag_m * 1e3), None),
            Drawn("sag ahead", "m1", false, p(&|p| p.sag_ahead_m * 1e3), None),
        ],
    );
    out.add(
        seen,
        ("rotation", "rotation in the grasp"),
        ("mrad", 1.0),
        vec![Drawn("now", "m0", false, p(&|p| p.rotation_rad * 1e3), None)],
    );
    out.add(
        seen,
        ("steps", "Newton steps a tick"),
        ("1", 5.0),
        vec![Drawn("steps", "m0", false, p(&|p| f32::from(p.solver_iterations)), None)],
    );
    if let Some(plot) = out.plots.last_mut() {
        plot.first = false;
    }
    out
}

impl Courses {
    /// The plots for which `kept` holds, of several trials those that are alike.
    pub fn keep(&mut self, kept: &[bool]) {
        fn only<T>(all: &mut Vec<T>, kept: &[bool]) {
            let mut at = kept.iter();
            all.retain(|_| at.next().copied().unwrap_or(true));
        }
        only(&mut self.plots, kept);
        only(&mut self.values, kept);
        only(&mut self.half, kept);
        only(&mut self.known, kept);
        only(&mut self.moves, kept);
    }

    fn add(
        &mut self,
        seen: &Seen,
        (id, title): (&str, &str),
        (unit, least): (&'static str, f64),
        lines: Vec<Drawn>,
    ) {
        let whole = [seen.t_s.first(), seen.t_s.last()].map(|t| t.copied().unwrap_or(0.0));
        let pieces: Vec<(f64, f64)> = match seen.spans {
            [] => vec![(whole[0], whole[1])],
            spans => spans.iter().map(|(_, from, to, _)| (*from, *to)).collect(),
        };
        let mut half = Vec::new();
        for (k, Drawn(.., values, stated)) in lines.iter().enumerate() {
            let Some(stated) = stated else { continue };
            for (from, to) in &pieces {
                let inside =
                    seen.t_s.iter().zip(values).filter(|(t, _)| *t >= from && *t <= to).map(|(_, x)| *x);
                // Where less is stated than is seen, what is seen.
                let noise = white_noise(inside).unwrap_or(0.0).max(*stated);
                if noise > 0.0 {
                    half.push((k, *from, *to, noise));
                }
            }
        }
        let any = |is: fn(f64) -> bool| lines.iter().flat_map(|l| &l.3).any(|x| is(*x));
        self.known.push(any(f64::is_finite));
        self.moves.push(any(|x| x.is_finite() && x.abs() > 1e-3));
        let line = |l: &Drawn| viewer::Line { label: l.0.to_owned(), ink: l.1.to_owned(), dash: l.2 };
        self.plots.push(Plot {
            id: id.to_owned(),
            title: title.to_owned(),
            unit,
            least,
            most: (id == UTILISATION).then_some(MOST_USED),
            names: Vec::new(),
            lines: lines.iter().map(line).collect(),
            first: true,
        });
        self.values.push(lines.into_iter().map(|l| l.3).collect());
        self.half.push(half);
    }
}

/// How far the object is from where it was in the grasp at first, along the fingers' faces.
fn way_mm(samples: &[Sample]) -> Vec<f64> {
    let grasped = |s: &Sample| Some(pose(s.gripper.as_ref()?).to_local(&pose(s.object.as_ref()?)).position_m);
    let all: Vec<Option<Vector3<f64>>> = samples.iter().map(grasped).collect();
    let Some(first) = all.iter().flatten().next().copied() else { return vec![f64::NAN; all.len()] };
    let way = |p: &Option<Vector3<f64>>| p.map_or(f64::NAN, |p| 1e3 * (p.x - first.x).hypot(p.z - first.z));
    all.iter().map(way).collect()
}
