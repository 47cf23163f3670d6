//! A first mapping for recordings that nobody described: columns grouped by their names, units from
//! names and sizes. What is a guess says so; the user corrects it.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use super::error::RecordingError;
use super::guess_head::{conditions_in, head, whole};
use super::guess_names::{Kind, meaning, unit};
use super::source::recording_at;
use super::units::Quantity;
use crate::csv_text::CsvText;

/// Rows looked at.
const ROWS: usize = 20_000;
/// A hand-held bench in metres has no coordinate beyond this; in millimetres nearly all are.
const METRES: f64 = 5.0;
/// Torques of a fingertip are forces times less than this lever, m; beyond it the unit is not N m.
const LEVER_M: f64 = 0.5;
/// Angles in radians are within a turn.
const TURN_RAD: f64 = std::f64::consts::TAU;

/// Columns of one body by kind and axis.
#[derive(Clone, Debug, Default)]
struct Group {
    columns: BTreeMap<(Kind, char), usize>,
}

/// The first rows of a file, or of a topic of it.
#[derive(Default)]
struct Look {
    /// As the mapping names it.
    file: String,
    /// Of the stream.
    name: String,
    /// Of an MCAP file.
    topic: Option<String>,
    /// Child frame of transforms.
    frame: Option<String>,
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
    /// Its times never meet those of the first file.
    own_clock: bool,
}

/// From and to, s.
type Span = (f64, f64);

/// When a recording runs, by its own clock; what was not looked at has no end.
fn span_s(look: &Look) -> Option<Span> {
    let (at, unit) = time_column(look)?;
    let factor = Quantity::Time.factor(&unit).ok()?;
    let column = &look.columns[at];
    let end = if column.len() < ROWS { column.last()? * factor } else { f64::INFINITY };
    Some((column.first()? * factor, end))
}

/// Text of a mapping for `files`: each where it is, and how the mapping names it.
///
/// # Errors
/// A file that cannot be read.
pub fn guess(files: &[(&Path, &Path)]) -> Result<String, RecordingError> {
    let mut looks = Vec::new();
    for (file, named) in files {
        looks.extend(look(file, named)?);
    }
    let trial = common_name(&looks);
    let named = trial.as_deref().map(conditions_in).unwrap_or_default();
    let text = format!("{}\n", head(&named));
    let first = looks.first().and_then(span_s);
    for look in looks.iter_mut().skip(1) {
        let apart = |(a, b): (Span, Span)| a.0 > b.1 || b.0 > a.1;
        look.own_clock = look.topic.is_none() && first.zip(span_s(look)).is_some_and(apart);
    }
    let mut used = Vec::new();
    let mut streams = Vec::new();
    for look in &mut looks {
        if let Some(trial) = &trial {
            look.name = stem(&look.file)[trial.len()..].trim_matches(JOINTS).to_owned();
            let at = look.file.rfind(trial.as_str()).unwrap_or(0);
            look.file.replace_range(at..at + trial.len(), "{trial}");
        }
        let mut block = String::new();
        stream(look, &mut used, &mut block);
        streams.push(block);
    }
    Ok(whole(&text, &streams))
}

fn stem(file: &str) -> String {
    Path::new(file).file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
}

/// What stands between the parts of a file's name.
const JOINTS: &[char] = &['_', '-', '.', ' '];

/// How the names of all files begin, up to a joint: the trial's name, where there are several files and
/// something is left of each.
fn common_name(looks: &[Look]) -> Option<String> {
    let mut stems: Vec<String> = looks.iter().map(|look| stem(&look.file)).collect();
    stems.dedup();
    let (first, others) = stems.split_first()?;
    let common = others.iter().map(|other| {
        first
            .char_indices()
            .zip(other.chars())
            .take_while(|((_, a), b)| a == b)
            .map(|((at, a), _)| at + a.len_utf8())
            .last()
    });
    let length = common.collect::<Option<Vec<usize>>>()?.into_iter().min()?;
    let at = first[..length].rfind(JOINTS)?;
    let name = &first[..at];
    let rest = |stem: &String| stem.len() > at + 1;
    (!name.is_empty() && stems.iter().all(rest)).then(|| name.to_owned())
}

fn look(file: &Path, named: &Path) -> Result<Vec<Look>, RecordingError> {
    let file = &*recording_at(file)?;
    #[cfg(feature = "mcap")]
    if file.extension().is_some_and(|extension| extension == "mcap") {
        return bag(file, named);
    }
    let io = |error: std::io::Error| RecordingError::Io { file: file.to_owned(), error: error.to_string() };
    let shown = named.display().to_string();
    #[cfg(feature = "parquet")]
    if file.extension().is_some_and(|extension| extension == "parquet") {
        let bytes = std::fs::read(file).map_err(io)?;
        let names = crate::parquet_table::columns(bytes.clone(), file, &[])?.names;
        let wanted: Vec<&str> = names.iter().map(String::as_str).collect();
        let found = crate::parquet_table::columns(bytes, file, &wanted)?.found;
        let mut columns: Vec<Vec<f64>> = found.into_iter().flatten().collect();
        columns.iter_mut().for_each(|column| column.truncate(ROWS));
        return Ok(vec![Look { name: stem(&shown), file: shown, names, columns, ..Look::default() }]);
    }
    // Of a long file only its beginning is read.
    let open = || std::fs::File::open(file).map_err(io);
    let names: Vec<String> = CsvText::over(open()?, file, &[])?.unknown().map(str::to_owned).collect();
    let wanted: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut text = CsvText::over(open()?, file, &wanted)?;
    let mut columns = vec![Vec::new(); names.len()];
    while let Some(next) = text.next_row() {
        if next.is_ok() {
            for (at, column) in columns.iter_mut().enumerate() {
                column.push(text.number(at).unwrap_or(f64::NAN));
            }
        }
        if columns.first().is_some_and(|column| column.len() >= ROWS) {
            break;
        }
    }
    if !columns.iter().flatten().any(|number| number.is_finite()) {
        let bad_rows = columns.first().map_or(0, Vec::len);
        let first = Some(format!("no cell below {} is a number", names.join(", ")));
        return Err(RecordingError::Empty { file: file.to_owned(), bad_rows, first });
    }
    Ok(vec![Look { name: stem(&shown), file: shown, names, columns, ..Look::default() }])
}

/// Each topic, and each frame of transforms, is a stream.
#[cfg(feature = "mcap")]
fn bag(file: &Path, named: &Path) -> Result<Vec<Look>, RecordingError> {
    let look = |(topic, frame, table): (String, Option<String>, super::bag::Table)| Look {
        file: named.display().to_string(),
        name: frame.clone().unwrap_or_else(|| topic.clone()),
        topic: Some(topic),
        frame,
        columns: (0..table.names.len())
            .map(|at| table.rows.iter().filter_map(|row| row.get(at).copied()).collect())
            .collect(),
        names: table.names,
        own_clock: false,
    };
    Ok(super::bag::beginnings(file, ROWS)?.into_iter().map(look).collect())
}

impl Look {
    /// Devices give one unit for all of a kind: is any group of the file beyond SI?
    fn any(&self, groups: &BTreeMap<String, Group>, of: impl Fn(&Look, &Group) -> bool) -> bool {
        groups.values().any(|group| of(self, group))
    }
}

/// Torques of a fingertip in N m are smaller.
fn millimetre_torques(look: &Look, group: &Group) -> bool {
    largest(look, group, Kind::Torque) > LEVER_M * largest(look, group, Kind::Force)
}

/// Coordinates of a bench in metres are smaller.
fn millimetres(look: &Look, group: &Group) -> bool {
    !has(group, Kind::Force, "xyz")
        && [Kind::Position, Kind::Torque].iter().any(|kind| largest(look, group, *kind) > METRES)
}

fn has(group: &Group, kind: Kind, axes: &str) -> bool {
    axes.chars().all(|axis| group.columns.contains_key(&(kind, axis)))
}

fn stream(look: &Look, used: &mut Vec<&'static str>, text: &mut String) {
    let time = time_column(look);
    let mut groups: BTreeMap<String, Group> = BTreeMap::new();
    for (at, name) in look.names.iter().enumerate() {
        if Some(at) == time.as_ref().map(|(at, _)| *at) {
            continue;
        }
        if let Some((body, kind, axis)) = meaning(name) {
            groups.entry(body).or_default().columns.insert((kind, axis), at);
        }
    }
    let _ = writeln!(text, "\n[[streams]]\nname = {:?}", look.name);
    let trial = if look.file.contains("{trial}") { "CHECK: {trial}" } else { "write {trial}" };
    let _ = writeln!(text, "file = {:?}   # {trial} where the trial's name stands", look.file);
    for (key, value) in [("topic", &look.topic), ("child_frame", &look.frame)] {
        if let Some(value) = value {
            let _ = writeln!(text, "{key} = {value:?}");
        }
    }
    match &time {
        Some((at, unit)) => {
            let clock = match look.own_clock {
                true => {
                    ", clock = \"estimated\" }   # CHECK: its times never meet those of the first file; \
                     \"starts_together\" where both began at one moment"
                }
                false => " }",
            };
            let _ = writeln!(text, "time = {{ column = {:?}, unit = {unit:?}{clock}", look.names[*at]);
        }
        None => {
            text.push_str("time = { column = \"?\", unit = \"s\" }   # CHECK: no column rises throughout\n")
        }
    }
    text.push_str(
        "# time.clock = \"estimated\", \"starts_together\" or time.offset_s where this device has its own clock\n",
    );
    let mut left = Vec::new();
    // Whose name tells what it is comes first: the others get what is left.
    let mut ordered: Vec<(&String, &Group)> = groups.iter().collect();
    ordered.sort_by_key(|(body, _)| !tells(body));
    for (body, group) in ordered {
        // A topic's columns do not name their body.
        let label = if look.topic.is_some() {
            format!("{} {body}", look.name).trim().to_owned()
        } else {
            body.clone()
        };
        let body = &label;
        let has = |kind: Kind, axes: &str| has(group, kind, axes);
        // Transforms are often written tx, ty, tz beside a quaternion: these are no torques.
        let moved = has(Kind::Quaternion, "wxyz") && has(Kind::Torque, "xyz") && !has(Kind::Force, "xyz");
        if has(Kind::Force, "xyz") {
            let guess = if look.any(&groups, millimetre_torques) { "N mm" } else { "N m" };
            wrench(look, body, group, guess, used, text);
        } else if has(Kind::Position, "xyz") || moved {
            let guess = if look.any(&groups, millimetres) { "mm" } else { "m" };
            let kind = if moved { Kind::Torque } else { Kind::Position };
            pose(look, (body, group), kind, guess, used, text);
        } else {
            left.extend(group.columns.values().map(|at| look.names[*at].as_str()));
        }
    }
    let grouped: Vec<&str> =
        groups.values().flat_map(|g| g.columns.values()).map(|at| look.names[*at].as_str()).collect();
    let time = time.map(|(at, _)| look.names[at].as_str());
    left.extend(
        look.names.iter().map(String::as_str).filter(|name| !grouped.contains(name) && Some(*name) != time),
    );
    // A topic's column does not name what it is.
    let of_grip = look.topic.as_ref().is_some_and(|topic| topic.to_lowercase().contains("grip"));
    let grip =
        left.iter().position(|name| name.to_lowercase().contains("grip") || (of_grip && *name == "data"));
    if let Some(name) = grip.map(|at| left.remove(at)) {
        let unit = unit(name).1.filter(|unit| Quantity::Force.factor(unit).is_ok());
        let of = unit.as_deref().unwrap_or("N");
        let _ = writeln!(text, "\n[streams.grip]   # CHECK: the commanded normal force of each finger?");
        let _ = writeln!(text, "column = {name:?}\nunit = {of:?}{}", checked(&unit));
    }
    if !left.is_empty() {
        let _ = writeln!(text, "# not used: {}", left.join(", "));
    }
}

/// The time stamps' column and unit.
fn time_column(look: &Look) -> Option<(usize, String)> {
    let rises = |column: &[f64]| column.len() > 1 && column.windows(2).all(|pair| pair[1] > pair[0]);
    let named = |name: &str| {
        let name = unit(name).0.to_lowercase();
        ["t", "time", "timestamp", "clock"].iter().any(|word| name == *word)
            || name.contains("time")
            || name.contains("stamp")
    };
    let rising: Vec<usize> = (0..look.names.len()).filter(|at| rises(&look.columns[*at])).collect();
    let at = rising.iter().copied().find(|at| named(&look.names[*at])).or_else(|| rising.first().copied())?;
    if look.topic.is_some() {
        return Some((at, "s".to_owned()));
    }
    if let Some(named) = unit(&look.names[at]).1
        && Quantity::Time.factor(&named).is_ok()
    {
        return Some((at, named));
    }
    // Devices sample between 10 Hz and 10 kHz.
    let steps = super::super::sorted(look.columns[at].windows(2).map(|pair| pair[1] - pair[0]));
    let step = super::super::quantile(&steps, 0.5);
    let unit = match step {
        step if step < 0.1 => "s",
        step if step < 100.0 => "ms",
        step if step < 1e5 => "us",
        _ => "ns",
    };
    Some((at, unit.to_owned()))
}

/// `["a", "b", "c"]` of the columns of a kind.
fn names(look: &Look, group: &Group, kind: Kind, axes: &str) -> Option<String> {
    let names: Option<Vec<String>> = axes
        .chars()
        .map(|axis| group.columns.get(&(kind, axis)).map(|at| format!("{:?}", look.names[*at])))
        .collect();
    Some(format!("[{}]", names?.join(", ")))
}

/// Greatest magnitude in the columns of a kind.
fn largest(look: &Look, group: &Group, kind: Kind) -> f64 {
    let of_kind = group.columns.iter().filter(|((other, _), _)| *other == kind);
    of_kind.flat_map(|(_, at)| &look.columns[*at]).fold(0.0, |most, cell| cell.abs().max(most))
}

fn stated(look: &Look, group: &Group, kind: Kind, quantity: Quantity) -> Option<String> {
    let at = group.columns.iter().find(|((other, _), _)| *other == kind).map(|(_, at)| *at)?;
    unit(&look.names[at]).1.filter(|unit| quantity.factor(unit).is_ok())
}

/// What measures a wrench, and words that its columns are named by.
const WRENCHES: [(&str, &[&str]); 3] = [
    ("pusher", &["push", "tip", "plate", "probe", "wall", "rod", "anvil", "environment"]),
    ("finger1", &["1", "left"]),
    ("finger2", &["2", "right"]),
];

/// Whether a name says which wrench it is.
fn tells(body: &str) -> bool {
    let body = body.to_lowercase();
    WRENCHES.iter().flat_map(|(_, words)| *words).any(|word| body.contains(word))
}

/// The first of `roles` that is not taken, by the words in `body`.
fn role(
    body: &str,
    file: &str,
    words: &[(&'static str, &[&str])],
    used: &mut Vec<&'static str>,
) -> Option<&'static str> {
    let free = |role: &str| !used.contains(&role);
    let by = |text: &str| {
        let text = text.to_lowercase();
        words
            .iter()
            .find(|(role, words)| free(role) && words.iter().any(|word| text.contains(word)))
            .map(|(r, _)| *r)
    };
    let found =
        by(body).or_else(|| by(file)).or_else(|| words.iter().map(|(role, _)| *role).find(|r| free(r)))?;
    used.push(found);
    Some(found)
}

fn wrench(
    look: &Look,
    body: &str,
    group: &Group,
    guess: &str,
    used: &mut Vec<&'static str>,
    text: &mut String,
) {
    let [pusher, one, two] = WRENCHES;
    // Fingers come first where the name tells nothing.
    let words = if tells(body) { [pusher, one, two] } else { [one, two, pusher] };
    let Some(role) = role(body, &look.file, &words, used) else {
        let _ = writeln!(text, "# not used: a fourth wrench, {body:?}");
        return;
    };
    let _ = writeln!(text, "\n[streams.{role}]   # CHECK: from the columns {body:?}");
    let _ = writeln!(text, "force = {}", names(look, group, Kind::Force, "xyz").unwrap_or_default());
    let torque = names(look, group, Kind::Torque, "xyz");
    let force_unit = stated(look, group, Kind::Force, Quantity::Force);
    let _ = writeln!(text, "force_unit = {:?}{}", force_unit.as_deref().unwrap_or("N"), checked(&force_unit));
    if let Some(torque) = torque {
        let unit = stated(look, group, Kind::Torque, Quantity::Torque);
        let _ = writeln!(text, "torque = {torque}");
        let _ = writeln!(text, "torque_unit = {:?}{}", unit.as_deref().unwrap_or(guess), checked(&unit));
    }
    let mean: Vec<String> = "xyz"
        .chars()
        .filter_map(|axis| group.columns.get(&(Kind::Force, axis)))
        .map(|at| {
            let measured: Vec<f64> =
                look.columns[*at].iter().copied().filter(|cell| !cell.is_nan()).collect();
            format!("{:.3}", measured.iter().sum::<f64>() / measured.len().max(1) as f64)
        })
        .collect();
    let grip = if role == "pusher" { "" } else { "; the grip is its largest part" };
    let _ = writeln!(text, "# its mean force is [{}]{grip}", mean.join(", "));
    let (reaction, advice) = match role {
        "finger1" => ("finger", "finger 1 sits at +Y and presses the object towards -Y"),
        "finger2" => ("finger", "finger 2 sits at -Y and presses the object towards +Y"),
        _ => ("pusher", "world axes; it pushes the object along its +X"),
    };
    let _ = writeln!(
        text,
        "acts_on = \"object\"   # CHECK: or \"{reaction}\" where the sensor reads the reaction"
    );
    let _ =
        writeln!(text, "axes = [\"x\", \"y\", \"z\"]   # CHECK: our x, y, z in the sensor's axes; {advice}");
    text.push_str(
        "# origin_m = [0.0, 0.0, 0.0]   # the sensor's origin from the middle of the contact, our axes\n",
    );
    text.push_str(
        "# tare_s = [0.0, 0.2]   # subtract the mean over this time, where nothing is touched yet\n",
    );
}

fn pose(
    look: &Look,
    (body, group): (&str, &Group),
    kind: Kind,
    guess: &str,
    used: &mut Vec<&'static str>,
    text: &mut String,
) {
    let words: [(&str, &[&str]); 3] = [
        ("pusher_pose", &["push", "tip"]),
        ("gripper", &["grip", "hand", "tool", "tcp", "ee", "robot"]),
        ("object", &["obj", "body", "part", "block"]),
    ];
    let fallback = [words[2], words[1], words[0]];
    let tells = words.iter().any(|(_, list)| list.iter().any(|word| body.contains(word)));
    let Some(role) = role(body, "", if tells { &words } else { &fallback }, used) else {
        let _ = writeln!(text, "# not used: a fourth pose, {body:?}");
        return;
    };
    let _ = writeln!(text, "\n[streams.{role}]   # CHECK: from the columns {body:?}");
    let _ = writeln!(text, "position = {}", names(look, group, kind, "xyz").unwrap_or_default());
    let unit = stated(look, group, kind, Quantity::Length);
    let _ = writeln!(text, "unit = {:?}{}", unit.as_deref().unwrap_or(guess), checked(&unit));
    let quaternion = names(look, group, Kind::Quaternion, "wxyz");
    match (quaternion, names(look, group, Kind::Angle, "xyz")) {
        (Some(names), _) => {
            let _ = writeln!(text, "quaternion_wxyz = {names}   # columns in the order w, x, y, z");
        }
        (None, Some(names)) => {
            let unit = stated(look, group, Kind::Angle, Quantity::Angle);
            let guess = if largest(look, group, Kind::Angle) > TURN_RAD { "deg" } else { "rad" };
            let _ = writeln!(
                text,
                "roll_pitch_yaw = {names}   # CHECK: about the fixed axes x, then y, then z\nangle_unit = {:?}{}",
                unit.as_deref().unwrap_or(guess),
                checked(&unit)
            );
        }
        (None, None) => text.push_str(
            "roll_pitch_yaw = [\"\", \"\", \"\"]   # CHECK: neither a quaternion nor angles found\nangle_unit = \"deg\"\n",
        ),
    }
    text.push_str("world_axes = [\"x\", \"y\", \"z\"]   # CHECK: our x, y, z (z up) in its world; [\"x\", \"-z\", \"y\"] for y up\n");
    text.push_str(
        "# body_axes = [\"x\", \"y\", \"z\"]   # our body axes in the tracked body's; often as world_axes\n",
    );
    text.push_str("# body_origin_m = [0.0, 0.0, 0.0]   # our body's origin in the tracked body's axes\n");
}

fn checked(stated: &Option<String>) -> &'static str {
    if stated.is_some() { "" } else { "   # CHECK: guessed" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plate_is_pushed_against_and_what_a_name_does_not_tell_comes_after_what_others_tell() {
        assert!(tells("plate") && tells("Left") && !tells("ft"));
    }
}
