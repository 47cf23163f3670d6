//! The bench of a trial from the side, to scale: object as measured and as modelled, fingers, pusher, forces.
//!
//! Seen in the carrier's axes along the fingers' normal (x to the right, z up); where nothing is grasped, from
//! above (x, y). What is measured is to scale; how far the model's object is from it may be drawn enlarged, as
//! a tenth of a millimetre decides.
//!
//! The drawing is one of a moment. The page's script moves its parts: each has the name that [`Course`] gives.

use maud::{Markup, html};
use nalgebra::Vector3;
use serde::Serialize;
use stickslip_analysis::channels::{PUSHER_FORCE, Signals};
use stickslip_analysis::run::bench::Bench;
use stickslip_shared::model::{FingerContact, PusherContact};

use crate::outline::{corners, hull};
use crate::packed::Packed;

/// Size of the drawing, px.
const SIZE: [f64; 2] = [640.0, 270.0];
/// Share of the drawing that the object takes at most, in each direction.
const SHARE: [f64; 2] = [0.55, 0.45];
/// The longest arrow, px.
const LONGEST: f64 = 85.0;
/// The largest deviation of a model is drawn this large at least, px, if an enlargement of [`ENLARGED`] does it.
const VISIBLE: f64 = 12.0;
/// And at most this large, px.
const TOO_LARGE: f64 = 60.0;
/// Enlargements of it.
const ENLARGED: [f64; 6] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0];
/// Room of the text at an arrow, px: of the larger letters of paper and phones. The script has the same.
const LABEL: [f64; 2] = [122.0, 18.0];
/// Half length of a plane pusher in the drawing, px.
const PLANE: f64 = 60.0;

/// Position, mm, to the right and up from the object's start; angle counter-clockwise, degrees.
type Placed = [f64; 3];

/// A part of the drawing over time.
#[derive(Clone)]
struct Part {
    name: String,
    at: Vec<Placed>,
}

/// A force on the object over time.
#[derive(Clone)]
struct Force {
    name: String,
    ink: String,
    /// Name of the part that it acts at, or `fingers` or `object`.
    at: &'static str,
    n: Vec<[f64; 2]>,
}

impl Force {
    /// Whether its size stands beside its arrow.
    fn is_told(&self) -> bool {
        self.ink == "measured"
    }
}

/// A trial's bench over time.
#[derive(Clone)]
pub struct Scenery {
    view: [usize; 2],
    outline: Vec<[f64; 2]>,
    finger: Option<(FingerContact<f64>, [f64; 2])>,
    pusher: Option<(PusherContact<f64>, [f64; 2])>,
    parts: Vec<Part>,
    forces: Vec<Force>,
    grip_n: Vec<f64>,
    t_s: Vec<f64>,
    px_per_mm: f64,
    px_per_n: f64,
    enlarged: f64,
}

/// What the script needs to move the drawing.
#[derive(Serialize)]
pub struct Course {
    mm: f64,
    n: f64,
    k: f64,
    centre: [f64; 2],
    start: usize,
    fingers: [f64; 2],
    parts: Vec<(String, [Packed; 3])>,
    forces: Vec<(String, &'static str, [Packed; 2])>,
    grip: Packed,
}

impl Scenery {
    /// Of a trial as measured and as each model has it.
    #[must_use]
    pub fn new(bench: &Bench, t_s: &[f64], measured: &[Signals], modelled: &[Vec<Signals>]) -> Self {
        let view = if bench.scene.fingers.is_some() { [0, 2] } else { [0, 1] };
        let flat = |p: &Vector3<f64>| view.map(|k| p[k]);
        let start = bench.start;
        let origin = flat(&start.position_m);
        let outline = corners(&bench.scene.object.shape)
            .into_iter()
            .map(|c| flat(&(start.rotation * c)).map(|x| 1e3 * x))
            .collect();
        let outline = hull(outline);
        let axis = Vector3::from_fn(|k, _| f64::from(u8::from(k == view[0])));
        let object = |rows: &[Signals]| -> Vec<Placed> {
            let mut last = [0.0; 3];
            rows.iter()
                .map(|s| {
                    if s[..6].iter().all(|x| x.is_finite()) {
                        let turned =
                            nalgebra::Rotation3::from_scaled_axis(Vector3::new(s[3], s[4], s[5])) * axis;
                        let [x, y] = flat(&turned);
                        let at = view.map(|k| s[k]);
                        last =
                            [1e3 * (at[0] - origin[0]), 1e3 * (at[1] - origin[1]), y.atan2(x).to_degrees()];
                    }
                    last
                })
                .collect()
        };
        let mut parts = vec![Part { name: "measured".into(), at: object(measured) }];
        let mut forces = Vec::new();
        let weight = bench.scene.object.mass_kg * Vector3::from(bench.scene.gravity_m_s2);
        let local: Vec<_> = bench.poses.iter().map(|p| p.pusher.map(|q| p.carrier.to_local(&q))).collect();
        for (k, rows) in modelled.iter().enumerate() {
            parts.push(Part { name: format!("m{k}"), at: object(rows) });
        }
        let mut signals = vec![("measured".to_owned(), measured)];
        signals.extend(modelled.iter().enumerate().map(|(k, rows)| (format!("m{k}"), rows.as_slice())));
        for (ink, rows) in &signals {
            let each = |of: &dyn Fn(usize, &Signals) -> Vector3<f64>| -> Vec<[f64; 2]> {
                rows.iter().enumerate().map(|(i, s)| flat(&of(i, s))).collect()
            };
            if bench.scene.fingers.is_some() {
                let n = each(&|_, s| Vector3::from_fn(|k, _| s[6 + k] + s[12 + k]));
                forces.push(Force { name: "fingers".into(), ink: ink.clone(), at: "fingers", n });
            }
            if bench.scene.pusher.is_some() {
                let n = each(&|i, s| {
                    let world = Vector3::from_fn(|k, _| s[PUSHER_FORCE + k]);
                    bench.poses.get(i).map_or(world, |p| p.carrier.rotation.inverse() * world)
                });
                forces.push(Force { name: "pusher".into(), ink: ink.clone(), at: "pusher", n });
            }
        }
        let n = bench.poses.iter().map(|p| flat(&(p.carrier.rotation.inverse() * weight))).collect();
        forces.push(Force { name: "weight".into(), ink: "measured".into(), at: "measured", n });
        forces.retain(|f| f.n.iter().flatten().any(|x| x.is_finite() && x.abs() > 1e-3));
        let pusher = bench.scene.pusher.zip(local.first().copied().flatten()).map(|(contact, first)| {
            // Which way its edge runs in the view.
            (contact, flat(&(first.rotation * Vector3::y())))
        });
        if pusher.is_some() {
            let mut last = [0.0; 3];
            let at = local.iter().map(|p| {
                if let Some(p) = p {
                    let [x, y] = flat(&p.position_m);
                    let [a, b] = flat(&(p.rotation * Vector3::x()));
                    last = [1e3 * (x - origin[0]), 1e3 * (y - origin[1]), b.atan2(a).to_degrees()];
                }
                last
            });
            parts.push(Part { name: "pusher".into(), at: at.collect() });
        }
        let size = |k: usize| {
            let of = |pick: fn(f64, f64) -> f64, from: f64| outline.iter().map(|p| p[k]).fold(from, pick);
            (of(f64::max, f64::NEG_INFINITY) - of(f64::min, f64::INFINITY)).max(1.0)
        };
        let px_per_mm = (SHARE[0] * SIZE[0] / size(0)).min(SHARE[1] * SIZE[1] / size(1));
        let strongest = forces
            .iter()
            .flat_map(|f| &f.n)
            .map(|n| n[0].hypot(n[1]))
            .filter(|n| n.is_finite())
            .fold(0.1, f64::max);
        let reach = 0.5 * size(0).max(size(1)) * px_per_mm;
        let (of_measured, of_models) = parts.split_at(1);
        let off = of_models
            .iter()
            .filter(|p| p.name != "pusher")
            .flat_map(|p| p.at.iter().zip(&of_measured[0].at))
            .map(|(p, q)| {
                let shift = (p[0] - q[0]).hypot(p[1] - q[1]) * px_per_mm;
                shift.max((p[2] - q[2]).to_radians().abs() * reach)
            })
            .fold(0.0, f64::max);
        let fits = |k: &f64| k * off <= TOO_LARGE;
        let enough = |k: &f64| k * off >= VISIBLE && fits(k);
        let largest = ENLARGED.into_iter().rev().find(fits).unwrap_or(1.0);
        let enlarged = ENLARGED.into_iter().find(enough).unwrap_or(largest);
        let grip = |s: &Signals| 0.5 * (s[7].abs() + s[13].abs());
        Scenery {
            view,
            outline,
            finger: bench.scene.fingers.map(|f| (f, origin.map(|x| -1e3 * x))),
            pusher,
            parts,
            forces,
            grip_n: measured.iter().map(grip).collect(),
            t_s: t_s.to_vec(),
            px_per_mm,
            px_per_n: LONGEST / strongest,
            enlarged,
        }
    }

    /// The sample at which the last model's object is farthest from the measured one; the last sample where
    /// no pose is measured.
    #[must_use]
    pub fn farthest(&self) -> usize {
        let models = self.parts.iter().rev().find(|p| p.name.starts_with('m') && p.name != "measured");
        let Some((model, measured)) = models.zip(self.parts.first()) else { return self.t_s.len() / 2 };
        let off = |i: &usize| {
            let (a, b) = (model.at[*i], measured.at[*i]);
            (a[0] - b[0]).hypot(a[1] - b[1]) + 0.3 * (a[2] - b[2]).abs()
        };
        let all = 0..model.at.len().min(measured.at.len());
        all.max_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0)
    }

    /// Whether it can be drawn: something is measured of the object.
    #[must_use]
    pub fn is_seen(&self) -> bool {
        self.outline.len() > 2 && !self.t_s.is_empty()
    }

    /// In words, for those who cannot see it.
    fn words(&self) -> String {
        let from = if self.view == [0, 2] { "from the side" } else { "from above" };
        format!(
            "The bench {from}: object as measured and as modelled, fingers, pusher and forces on the object"
        )
    }

    fn place(&self, part: &Part, i: usize) -> Placed {
        let of = |part: &Part| part.at.get(i).copied().unwrap_or_default();
        let (p, q) = (of(part), self.parts.first().map_or([0.0; 3], of));
        if part.name == "pusher" { p } else { [0, 1, 2].map(|k| q[k] + self.enlarged * (p[k] - q[k])) }
    }

    fn px(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [SIZE[0] / 2.0 + x * self.px_per_mm, SIZE[1] / 2.0 - y * self.px_per_mm]
    }

    fn anchor(&self, at: &str, i: usize) -> [f64; 2] {
        if at == "fingers" {
            return self.px(self.finger.map_or([0.0; 2], |f| f.1));
        }
        let part = self.parts.iter().find(|p| p.name == at);
        let [x, y, _] = part.map_or([0.0; 3], |p| self.place(p, i));
        self.px([x, y])
    }

    /// The drawing at sample `i`.
    #[must_use]
    pub fn svg(&self, i: usize) -> Markup {
        let points: Vec<String> = self
            .outline
            .iter()
            .map(|[x, y]| format!("{:.1},{:.1}", x * self.px_per_mm, -y * self.px_per_mm))
            .collect();
        let points = points.join(" ");
        let transform = |part: &Part| {
            let [x, y, a] = self.place(part, i);
            let [x, y] = self.px([x, y]);
            format!("translate({x:.2} {y:.2}) rotate({:.3})", -a)
        };
        let bar = 20.0 * self.px_per_mm;
        html! {
            svg viewBox=(format!("0 0 {} {}", SIZE[0], SIZE[1])) role="img" aria-label=(self.words()) {
                g aria-hidden="true" {
                    @for part in &self.parts {
                        g data-part=(part.name) transform=(transform(part)) {
                            @if part.name == "pusher" { (self.pusher_shape()) }
                            @else if part.name == "measured" {
                                polygon points=(points) fill="#888888" fill-opacity="0.20" stroke="#4A4A4A" stroke-width="1.5" {}
                            } @else {
                                polygon points=(points) fill="none" stroke=(colour(&part.name)) stroke-width="2" stroke-dasharray="6 4" {}
                            }
                        }
                    }
                    (self.finger_shape())
                    // Texts over all arrows: their pale outline keeps them readable.
                    @for force in &self.forces { (self.arrow(force, i)) }
                    @for (force, label) in self.forces.iter().zip(self.labels(i)) { (Self::label(force, i, label)) }
                    text x="10" y="20" font-size="13" fill="#222222" data-note="time" {
                        (format!("t = {:.3} s", self.t_s.get(i).copied().unwrap_or_default()))
                    }
                    @if self.enlarged > 1.0 {
                        text x="10" y="38" font-size="13" fill="#222222" data-note="enlarged" {
                            (format!("deviation of the model's object drawn {} times larger", self.enlarged))
                        }
                    }
                    @if let Some(grip) = self.grip_n.get(i).filter(|g| g.is_finite() && self.finger.is_some()) {
                        text x="64" y=(SIZE[1] - 10.0) font-size="13" fill="#222222" data-note="grip" { (format!("grip {grip:.1} N")) }
                    }
                    (self.axes())
                    path d=(format!("M{:.1} {}h{bar:.1}", SIZE[0] - 10.0 - bar, SIZE[1] - 10.0)) stroke="#888888" stroke-width="2" {}
                    text x=(SIZE[0] - 10.0) y=(SIZE[1] - 16.0) font-size="13" text-anchor="end" fill="#222222" { "20 mm" }
                }
            }
        }
    }

    /// Which way the axes of the forces run.
    fn axes(&self) -> Markup {
        let corner = [14.0, SIZE[1] - 14.0];
        let [right, up] = if self.view == [0, 2] { ["x", "z"] } else { ["x", "y"] };
        let text = |at: [f64; 2], name: &str| {
            html! { text x=(at[0]) y=(at[1]) font-size="12" fill="#222222" { (name) } }
        };
        html! {
            path d=(arrow_path(corner, [28.0, 0.0])) fill="none" stroke="#888888" stroke-width="1.5" {}
            path d=(arrow_path(corner, [0.0, -28.0])) fill="none" stroke="#888888" stroke-width="1.5" {}
            (text([corner[0] + 32.0, corner[1] + 4.0], right))
            (text([corner[0] - 3.0, corner[1] - 33.0], up))
        }
    }

    fn pusher_shape(&self) -> Markup {
        let shape = match &self.pusher {
            Some((PusherContact::Plane, _)) => format!("M0 {}V{PLANE}M0 0H-14", -PLANE),
            Some((PusherContact::Line { length_m }, edge)) => {
                let half = 500.0 * length_m * self.px_per_mm * edge[0].hypot(edge[1]);
                format!("M0 {:.1}V{half:.1}M0 0H-14M-4 0a4 4 0 1 0 8 0a4 4 0 1 0 -8 0", -half)
            }
            Some((PusherContact::Point { tip_radius_m }, _)) => {
                let r = (1e3 * tip_radius_m * self.px_per_mm).max(4.0);
                format!(
                    "M{:.1} 0a{r:.1} {r:.1} 0 1 0 {:.1} 0a{r:.1} {r:.1} 0 1 0 {:.1} 0",
                    -r,
                    2.0 * r,
                    -2.0 * r
                )
            }
            None => String::new(),
        };
        html! { path d=(shape) fill="none" stroke="#888888" stroke-width="4" {} }
    }

    fn finger_shape(&self) -> Markup {
        let Some((finger, at)) = &self.finger else { return html! {} };
        let [x, y] = self.px(*at);
        let r = match finger {
            FingerContact::Disc { diameter_m } => 500.0 * diameter_m * self.px_per_mm,
            FingerContact::Line { length_m } => {
                let half = 500.0 * length_m * self.px_per_mm;
                return html! { path d=(format!("M{:.1} {y:.1}h{:.1}", x - half, 2.0 * half)) stroke="#888888" stroke-width="4" {} };
            }
            FingerContact::Point => 4.0,
        };
        html! { circle cx=(format!("{x:.1}")) cy=(format!("{y:.1}")) r=(format!("{r:.1}")) fill="#888888" fill-opacity="0.25" stroke="#888888" {} }
    }

    /// Where a force's arrow begins, and how far it goes, px.
    fn reach(&self, force: &Force, i: usize) -> ([f64; 2], [f64; 2]) {
        let [fx, fy] = force.n.get(i).copied().unwrap_or([0.0; 2]);
        (self.anchor(force.at, i), [fx * self.px_per_n, -fy * self.px_per_n])
    }

    /// Where the text at each force's arrow stands, px, and whether it ends there; none over another.
    fn labels(&self, i: usize) -> Vec<Label> {
        let mut placed: Vec<Label> = Vec::new();
        let one = |force: &Force| {
            let (from, along) = self.reach(force, i);
            let mut label = beyond(from, along);
            if force.is_told() {
                while let Some(other) = placed.iter().find(|p| label.meets(p)) {
                    label.at[1] = other.at[1] + LABEL[1];
                }
                placed.push(label);
            }
            label
        };
        self.forces.iter().map(one).collect()
    }

    fn arrow(&self, force: &Force, i: usize) -> Markup {
        let (from, along) = self.reach(force, i);
        html! {
            path data-force=(format!("{} {}", force.name, force.ink)) d=(arrow_path(from, along)) fill="none"
                stroke=(colour(&force.ink)) stroke-width=(if force.is_told() { "2.5" } else { "1.8" }) {}
        }
    }

    /// What a force is and how large; of a model's only the arrow is drawn.
    fn label(force: &Force, i: usize, text: Label) -> Markup {
        let [fx, fy] = force.n.get(i).copied().unwrap_or([0.0; 2]);
        html! {
            @if force.is_told() {
                text data-label=(force.name) x=(format!("{:.1}", text.at[0])) y=(format!("{:.1}", text.at[1])) font-size="13"
                    text-anchor=(if text.ends { "end" } else { "start" }) fill="#222222" {
                    (format!("{} {:.1} N", force.name, fx.hypot(fy)))
                }
            }
        }
    }

    /// What the script needs, at the samples `at`.
    #[must_use]
    pub fn course(&self, at: &[usize]) -> Course {
        let column = |of: &dyn Fn(usize) -> f64| Packed::of(&at.iter().map(|i| of(*i)).collect::<Vec<_>>());
        let near = |i: usize| at.iter().position(|k| *k >= i).unwrap_or(at.len().saturating_sub(1));
        Course {
            mm: self.px_per_mm,
            n: self.px_per_n,
            k: self.enlarged,
            centre: [SIZE[0] / 2.0, SIZE[1] / 2.0],
            start: near(self.farthest()),
            fingers: self.finger.map_or([0.0; 2], |f| f.1),
            parts: self
                .parts
                .iter()
                .map(|p| {
                    (p.name.clone(), [0, 1, 2].map(|k| column(&|i| p.at.get(i).map_or(f64::NAN, |q| q[k]))))
                })
                .collect(),
            forces: self
                .forces
                .iter()
                .map(|f| {
                    let name = format!("{} {}", f.name, f.ink);
                    (name, f.at, [0, 1].map(|k| column(&|i| f.n.get(i).map_or(f64::NAN, |q| q[k]))))
                })
                .collect(),
            grip: column(&|i| self.grip_n.get(i).copied().unwrap_or(f64::NAN)),
        }
    }
}

/// A text at an arrow.
#[derive(Clone, Copy)]
struct Label {
    at: [f64; 2],
    /// It ends there; otherwise it begins there.
    ends: bool,
}

impl Label {
    /// Its left end, px.
    fn left(&self) -> f64 {
        if self.ends { self.at[0] - LABEL[0] } else { self.at[0] }
    }

    fn meets(&self, other: &Label) -> bool {
        // One that was moved below another is a label's height from it but for rounding.
        let beside = (self.left() - other.left()).abs() >= LABEL[0];
        !beside && (self.at[1] - other.at[1]).abs() < LABEL[1] - 1e-6
    }
}

/// Beyond the tip of an arrow: on along one that lies, above or below one that stands. The script does the same.
fn beyond([x, y]: [f64; 2], [dx, dy]: [f64; 2]) -> Label {
    let lies = dx.abs() >= dy.abs();
    let ends = lies && dx < 0.0;
    let x = x + dx + if ends { -6.0 } else { 6.0 };
    let x = if ends { x.clamp(LABEL[0], SIZE[0]) } else { x.clamp(5.0, SIZE[0] - LABEL[0]) };
    let y = y + dy + if lies { 4.0 } else { 4.0 + 10.0 * dy.signum() };
    Label { at: [x, y.clamp(52.0, SIZE[1] - 36.0)], ends }
}

/// A line with a head; too short a one is nothing.
fn arrow_path([x, y]: [f64; 2], [dx, dy]: [f64; 2]) -> String {
    let length = dx.hypot(dy);
    if length.is_nan() || length <= 4.0 {
        return "M0 0".into();
    }
    let (ux, uy) = (dx / length, dy / length);
    let (tx, ty) = (x + dx, y + dy);
    format!(
        "M{x:.1} {y:.1}L{tx:.1} {ty:.1}M{:.1} {:.1}L{tx:.1} {ty:.1}L{:.1} {:.1}",
        tx - 8.0 * ux - 5.0 * uy,
        ty - 8.0 * uy + 5.0 * ux,
        tx - 8.0 * ux + 5.0 * uy,
        ty - 8.0 * uy - 5.0 * ux
    )
}

fn colour(ink: &str) -> &'static str {
    match ink {
        "measured" => "#4A4A4A",
        "m0" => "#D55E00",
        "m1" => "#0072B2",
        _ => "#009E73",
    }
}
