//! How a first mapping begins: what people correct by hand, and the conditions that the names of trials hold.

use super::mapping::FORMAT;

/// Conditions that the name of a trial holds.
#[derive(Default)]
pub struct InName {
    /// Regular expression over the name.
    pattern: String,
    /// Columns of trials.csv that it gives, each with the unit that people write, where there is one.
    columns: Vec<(&'static str, &'static str)>,
    /// The object.
    object: Option<String>,
}

/// What laboratories write before the number of a condition; the column of trials.csv, and the usual unit.
const LETTERS: [(&str, &str, &str); 9] = [
    ("g", "grip_n", ""),
    ("grip", "grip_n", ""),
    ("v", "speed_m_s", "mm/s"),
    ("w", "speed_rad_s", "deg/s"),
    ("s", "slope_rad", "deg"),
    ("o", "pusher_offset_m", "mm"),
    ("r", "run", ""),
    ("run", "run", ""),
    ("rep", "run", ""),
];

/// Conditions in `name`, as `obj4_g20_v10_r1`; nothing where no part tells.
pub fn conditions_in(name: &str) -> InName {
    let mut found = InName::default();
    let mut parts = Vec::new();
    for part in name.split('_') {
        let (word, number) = part.split_at(part.find(|c: char| !c.is_alphabetic()).unwrap_or(part.len()));
        let known = LETTERS.iter().find(|(letter, column, _)| {
            *letter == word.to_lowercase() && !found.columns.iter().any(|(other, _)| other == column)
        });
        match known.filter(|_| number.parse::<f64>().is_ok_and(f64::is_finite)) {
            Some((_, column, unit)) => {
                found.columns.push((column, unit));
                parts.push(format!(r"{word}(?<{column}>-?\d+(?:\.\d+)?)"));
            }
            None if found.object.is_none() && found.columns.is_empty() => {
                found.object = Some(part.to_owned());
                parts.push("(?<object>[^_]+)".to_owned());
            }
            None => parts.push("[^_]+".to_owned()),
        }
    }
    if found.columns.is_empty() {
        return InName::default();
    }
    found.pattern = parts.join("_");
    found
}

/// The mapping up to its streams.
pub fn head(named: &InName) -> String {
    let told = !named.columns.is_empty();
    let unit = |(column, unit): &(&str, &str)| (!unit.is_empty()).then(|| format!("{column} = \"{unit}\""));
    let units: Vec<String> = named.columns.iter().filter_map(unit).collect();
    let has = |column: &str| named.columns.iter().any(|(other, _)| *other == column);
    let object = named.object.as_deref().unwrap_or("object");
    let mut constants = Vec::new();
    if named.object.is_none() {
        constants.push("object = \"object\"");
    }
    constants.push("primitive = \"linear_push\"");
    if !has("grip_n") {
        constants.push("grip_n = 20.0");
    }
    HEAD.replace("{FORMAT}", FORMAT)
        .replace(
            "{PATTERN}",
            &match told {
                true => {
                    format!("pattern = '^{}$'   # CHECK: conditions in the names of trials", named.pattern)
                }
                false => NO_PATTERN.to_owned(),
            },
        )
        .replace(
            "{UNITS}",
            &match units.is_empty() {
                true => "# units = { speed_m_s = \"mm/s\" }".to_owned(),
                false => format!("units = {{ {} }}   # CHECK: of these numbers", units.join(", ")),
            },
        )
        .replace("{CONSTANTS}", &constants.join(", "))
        .replace("{OBJECT}", &format!("{object:?}"))
}

/// What a pattern looks like, where names hold no conditions.
const NO_PATTERN: &str = r"# pattern = '^(?<object>obj\d+)_g(?<grip_n>\d+)_v(?<speed_m_s>\d+)_r(?<run>\d+)$'   # conditions in names";

const HEAD: &str = r#"# Made by `stickslip new`. Lines with CHECK are guesses: correct them, then
#   stickslip import recording THIS_FILE --out DATA
# Keys: docs/import-recordings.md
format = "{FORMAT}"
# rate_hz = 250.0   # of the data set; faster streams are averaged, slower ones leave cells empty

[trials]
# table = "trials.csv"   # conditions as in docs/dataset.md; with start_s and end_s where one file holds all trials
{PATTERN}
{UNITS}
# cut_by = "trial_number"   # column of the first stream, where one file holds all trials
# cut_by_motion = { rest_s = 0.5 }   # or: each motion between rests of that length is a trial
constants = { {CONSTANTS} }   # CHECK

[dataset]   # as dataset.toml, docs/dataset.md
name = "my recordings"
sample_rate_hz = 250.0
gravity_m_s2 = [0.0, 0.0, -9.81]

[[dataset.objects]]
id = {OBJECT}
shape = "prism"
length_m = 0.1   # CHECK
side_m = 0.025   # CHECK
mass_kg = 0.2   # CHECK

[dataset.fingers]
contact = "disc"
diameter_m = 0.02   # CHECK

[dataset.pushers.linear_push]
contact = "plane"   # CHECK: plane, line (length_m), point (tip_radius_m)

# How far readings may be off throughout, offset included: from the data sheets. What is smaller is not found.
[dataset.sensors.finger]
force_uncertainty_n = 0.25   # CHECK
torque_uncertainty_nm = 0.003   # CHECK
[dataset.sensors.pusher]
force_uncertainty_n = 0.75   # CHECK
torque_uncertainty_nm = 0.037   # CHECK
# Noise (force_noise_n, torque_noise_nm; [dataset.sensors.pose] position_noise_m, rotation_noise_rad) is taken from
# the data where it is not stated.

# [fixed.gripper]   # where the gripper stands still and no stream has its pose
# position_m = [0.0, 0.0, 0.5]
{PUSHER}
# axes = ["x", "y", "z"]   # its x (towards the object), y, z in our world"#;

/// Where a stream has the pusher's pose.
const MOVING: &str =
    "# [fixed.pusher]   # where it stands still and no stream has its pose\n# position_m = [0.0, 0.0, 0.5]";

/// Where none has: without its place no model can be run along a push.
const STANDING: &str = "[fixed.pusher]\nposition_m = [0.0, 0.0, 0.0]   # CHECK: where it stands, our world: no stream has its pose";

/// How a signal of a stream begins.
const SIGNAL: &str = "\n[streams.";

/// The mapping of its `head` and its `streams`. A stream without a signal would be refused: it is a comment, so that what
/// a bag holds beside is seen and not in the way.
pub fn whole(head: &str, streams: &[String]) -> String {
    let understood = |block: &String| block.contains(SIGNAL);
    let moving = streams.iter().any(|block| block.contains("[streams.pusher_pose]"));
    let mut text = head.replacen("{PUSHER}", if moving { MOVING } else { STANDING }, 1);
    let any = streams.iter().any(understood);
    for block in streams {
        match any && !understood(block) {
            true => text.extend(block.lines().map(|line| match line {
                "" => "\n# No signal was found in this stream: it is left out.\n".to_owned(),
                line => format!("# {}\n", line.trim_start_matches("# ")),
            })),
            false => text.push_str(block),
        }
    }
    text
}
