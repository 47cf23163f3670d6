//! What the format has: every key of `dataset.toml` and every column of the tables, with unit,
//! default and who needs it. The manual's tables are made from this list ([`markdown`]), and a
//! test holds it equal to what the reader reads.

use super::columns;
use super::trials;

pub use super::spelling::{did_you_mean, with_hint};

/// One key, or columns that share a meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Name; `{a,b}` stands for each of them. Keys in their table: `objects.mass_kg`.
    pub name: &'static str,
    /// SI unit; empty for text.
    pub unit: &'static str,
    /// Meaning.
    pub content: &'static str,
    /// What holds where it is absent.
    pub absent: &'static str,
    /// Commands that cannot do without.
    pub needed_by: &'static str,
}

const fn entry(
    name: &'static str,
    unit: &'static str,
    content: &'static str,
    absent: &'static str,
    needed_by: &'static str,
) -> Entry {
    Entry { name, unit, content, absent, needed_by }
}

const REFUSED: &str = "refused";
const ALL: &str = "all";
/// Commands that run the model along a trial.
const MODEL: &str = "calibrate, compare, diagnose, add, suggest, replay, score, stream";
/// Commands that compare with measurements.
const FITTED: &str = "calibrate, compare, diagnose, add, suggest";

/// Keys of `dataset.toml`.
pub const KEYS: &[Entry] = &[
    entry("format", "", "`stickslip-dataset/1`", REFUSED, ALL),
    entry("name", "", "name of the data set", REFUSED, ALL),
    entry("sample_rate_hz", "Hz", "nominal rate; the time stamps count", REFUSED, ALL),
    entry("gravity_m_s2", "m/s²", "three numbers, world axes", REFUSED, ALL),
    entry("objects.id", "", "name used in `trials.csv`", REFUSED, ALL),
    entry("objects.shape", "", "`prism`, `cylinder` (axis X), `polygon`", REFUSED, ALL),
    entry("objects.length_m", "m", "prism, cylinder: length along X", "refused for these", MODEL),
    entry(
        "objects.side_m",
        "m",
        "side of the prism's square, diameter of the cylinder",
        "refused for these",
        MODEL,
    ),
    entry(
        "objects.across_flats_m",
        "m",
        "cylinder: distance between two flat faces at +Y and -Y",
        "no flats",
        "-",
    ),
    entry(
        "objects.vertices_m",
        "m",
        "polygon: `[[x, y], ...]` about the centre of mass",
        "refused for a polygon",
        MODEL,
    ),
    entry("objects.height_m", "m", "polygon: extrusion along Z", "refused for a polygon", MODEL),
    entry("objects.mass_kg", "kg", "mass", REFUSED, ALL),
    entry(
        "objects.inertia_kg_m2",
        "kg m²",
        "3 x 3 about the centre of mass",
        "that of a homogeneous body",
        "-",
    ),
    entry("fingers.contact", "", "`disc`, `line`, `point`", "no `[fingers]`: nothing is grasped", MODEL),
    entry("fingers.diameter_m", "m", "of a disc", "refused for a disc", MODEL),
    entry("fingers.length_m", "m", "of a line", "refused for a line", MODEL),
    entry(
        "pushers.<primitive>.contact",
        "",
        "`plane`, `line`, `point`",
        "no pusher in that primitive",
        MODEL,
    ),
    entry("pushers.<primitive>.length_m", "m", "of a line", "refused for a line", MODEL),
    entry(
        "pushers.<primitive>.tip_radius_m",
        "m",
        "of a point; 0 is a point without size",
        "refused for a point",
        MODEL,
    ),
    entry(
        "supports.<primitive>.contact",
        "",
        "`patch` (the whole face), `points`",
        "no support in that primitive",
        MODEL,
    ),
    entry("supports.<primitive>.points_m", "m", "`[[x, y], ...]`, object axes", "refused for points", MODEL),
    entry(
        "sensors.{finger,pusher}.force_noise_n",
        "N",
        "standard deviation from sample to sample",
        "estimated, with a warning",
        FITTED,
    ),
    entry(
        "sensors.{finger,pusher}.force_uncertainty_n",
        "N",
        "bound on a constant error",
        "1 % of the largest force, with a warning",
        FITTED,
    ),
    entry(
        "sensors.{finger,pusher}.torque_noise_nm",
        "N m",
        "standard deviation from sample to sample",
        "estimated, with a warning",
        FITTED,
    ),
    entry(
        "sensors.{finger,pusher}.torque_uncertainty_nm",
        "N m",
        "bound on a constant error",
        "1 % of the largest torque, with a warning",
        FITTED,
    ),
    entry(
        "sensors.pose.position_noise_m",
        "m",
        "standard deviation from sample to sample",
        "estimated, with a warning",
        FITTED,
    ),
    entry(
        "sensors.pose.rotation_noise_rad",
        "rad",
        "standard deviation from sample to sample",
        "estimated, with a warning",
        FITTED,
    ),
];

/// Columns of `trials.csv`, in the reader's order.
pub const TRIALS: &[Entry] = &[
    entry("trial", "", "name", REFUSED, ALL),
    entry(
        "file",
        "",
        "table of the trial",
        "`trials/<trial>.csv`, or `.parquet` where only that exists",
        "-",
    ),
    entry("object", "", "id in `dataset.toml`", REFUSED, ALL),
    entry(
        "primitive",
        "",
        "`linear_push`, `pivot`, `roll`, `planar_push`, `lift`, or your own",
        REFUSED,
        ALL,
    ),
    entry(
        "grip_n",
        "N",
        "normal force of each finger",
        "nothing is gripped",
        "every command where there are fingers",
    ),
    entry("speed_m_s", "m/s", "speed of the drive", "not applicable", "-"),
    entry("speed_rad_s", "rad/s", "speed of the drive", "not applicable", "-"),
    entry(
        "slope_rad",
        "rad",
        "direction in which the gripper is driven, above the horizontal (planar push: from the normal of the edge). A label of the condition; the motion is that of the poses",
        "not applicable",
        "-",
    ),
    entry(
        "pusher_offset_m",
        "m",
        "where the pusher touches: from the object's centre along its X (planar push: from the middle of the edge). A label of the condition; where the pusher is, its pose says",
        "not applicable",
        "-",
    ),
    entry(
        "run",
        "",
        "whole number; trials of equal condition and different run are repetitions",
        "no repetition",
        "the noise floor of check, compare, diagnose",
    ),
    entry(
        "pusher_{x,y,z}_m",
        "m",
        "position of a fixed pusher",
        "the table has it",
        "where the pusher is not in the table",
    ),
    entry(
        "pusher_q{w,x,y,z}",
        "1",
        "its rotation",
        "the table has it",
        "where the pusher is not in the table",
    ),
];

/// Columns of a trial's table, in the reader's order.
pub const TABLE: &[Entry] = &[
    entry("t_s", "s", "rises strictly", REFUSED, ALL),
    entry("grip_cmd_n", "N", "commanded normal force of each finger", "`grip_n` of `trials.csv`", "-"),
    entry("gripper_{x,y,z}_m", "m", "position", "not grasped", "every command where there are fingers"),
    entry("gripper_q{w,x,y,z}", "1", "rotation", "not grasped", "every command where there are fingers"),
    entry(
        "object_{x,y,z}_m",
        "m",
        "position; may be known at some samples only",
        "not measured",
        "at the start: all with a model; throughout: compare, diagnose",
    ),
    entry(
        "object_q{w,x,y,z}",
        "1",
        "rotation; as the position",
        "not measured",
        "at the start: all with a model; throughout: compare, diagnose",
    ),
    entry(
        "pusher_{x,y,z}_m",
        "m",
        "position, where the pusher moves",
        "fixed: as in `trials.csv`",
        "where the pusher moves",
    ),
    entry(
        "pusher_q{w,x,y,z}",
        "1",
        "rotation, where the pusher moves",
        "fixed: as in `trials.csv`",
        "where the pusher moves",
    ),
    entry("finger1_f{x,y,z}_n", "N", "force of finger 1", "not measured", FITTED),
    entry("finger1_t{x,y,z}_nm", "N m", "torque of finger 1", "not measured", "-"),
    entry("finger2_f{x,y,z}_n", "N", "force of finger 2", "not measured", FITTED),
    entry("finger2_t{x,y,z}_nm", "N m", "torque of finger 2", "not measured", "-"),
    entry(
        "pusher_f{x,y,z}_n",
        "N",
        "force of the pusher",
        "not measured",
        "balance of check; pusher friction",
    ),
    entry("pusher_t{x,y,z}_nm", "N m", "torque of the pusher", "not measured", "-"),
];

/// Names that `pattern` stands for: each choice of each `{a,b}`, in order.
#[must_use]
pub fn expand(pattern: &str) -> Vec<String> {
    let Some((before, rest)) = pattern.split_once('{') else { return vec![pattern.to_owned()] };
    let Some((choices, after)) = rest.split_once('}') else { return vec![pattern.to_owned()] };
    choices
        .split(',')
        .flat_map(|choice| expand(after).into_iter().map(move |after| format!("{before}{choice}{after}")))
        .collect()
}

/// Last parts of all keys of `dataset.toml`, and its tables.
#[must_use]
pub fn key_names() -> Vec<&'static str> {
    let mut names: Vec<&str> = KEYS
        .iter()
        .flat_map(|entry| entry.name.split('.'))
        .filter(|part| !part.contains(['<', '{']))
        .chain(["finger", "pusher"])
        .collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// The manual's table of `entries`, `what` ('key', 'column') as its first heading.
#[must_use]
pub fn markdown(what: &str, entries: &[Entry]) -> String {
    let mut text = format!("| {what} | unit | content | where absent | needed by |\n|---|---|---|---|---|\n");
    for Entry { name, unit, content, absent, needed_by } in entries {
        text.push_str(&format!("| `{name}` | {unit} | {content} | {absent} | {needed_by} |\n"));
    }
    text
}

/// Are [`TRIALS`] and [`TABLE`] the columns that the reader reads?
#[must_use]
pub fn is_what_the_reader_reads() -> bool {
    let names =
        |entries: &[Entry]| -> Vec<String> { entries.iter().flat_map(|entry| expand(entry.name)).collect() };
    names(TRIALS) == trials::COLUMNS && names(TABLE) == columns::COLUMNS
}
