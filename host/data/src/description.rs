//! `dataset.toml`: read, checked, with the line and column of what is wrong.

use std::path::Path;

use toml::de::{DeTable, DeValue};

use super::error::{DatasetError, Line, Problem, Warning};
use super::{ContactSpec, Description, ObjectSpec, Sensors, WrenchSensor, schema};

/// The one format that this reader knows.
pub const FORMAT: &str = "stickslip-dataset/1";

/// Parses and checks the text of `file`. Keys that the format does not name are allowed and
/// listed in a warning.
///
/// # Errors
/// An unknown format, TOML that does not parse, and what [`check`] refuses.
pub fn parse(text: &str, file: &Path) -> Result<(Description, Vec<Warning>), DatasetError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let locate = |error: toml::de::Error| {
        let mut refusal = DatasetError::of_file(file, Problem::Toml(advice(error.message().trim())));
        if let Some(span) = error.span() {
            let (line, column) = line_and_column(text, span.start);
            refusal = refusal.at(Line::Text(line)).column(column.to_string());
        }
        refusal
    };
    let document = DeTable::parse(text).map_err(locate)?.into_inner();
    // The format first: under another one, every other complaint would mislead.
    match document.get("format").map(|format| (format.span(), format.get_ref().as_str())) {
        None => {
            let key = Problem::MissingKey(format!("every data set (format = \"{FORMAT}\")"));
            return Err(DatasetError::of_file(file, key).at(Line::Text(1)).column("format"));
        }
        Some((span, name)) if name != Some(FORMAT) => {
            let (line, _) = line_and_column(text, span.start);
            return Err(DatasetError::of_file(file, Problem::UnknownFormat)
                .at(Line::Text(line))
                .column("format")
                .value(text.get(span).unwrap_or_default().trim_matches('"')));
        }
        Some(_) => {}
    }
    let description: Description = toml::from_str(text).map_err(|error| {
        let mut refusal = locate(error);
        if let Problem::Toml(advice) = &mut refusal.problem {
            advice.push_str(&misspelt(&document, advice).unwrap_or_default());
        }
        refusal
    })?;
    check(&description).map_err(|finding| {
        let mut refusal = DatasetError::of_file(file, finding.problem);
        if let Some(span) = span_of(&document, &finding.path) {
            refusal = refusal.at(Line::Text(line_and_column(text, span.start).0));
            // The text of a value; a whole table is no help.
            if let Some(value) = text.get(span).filter(|value| !value.contains('\n'))
                && !value.starts_with('[')
                && finding.names_value
            {
                refusal = refusal.value(value.trim_matches('"'));
            }
        }
        refusal.column(display_path(&finding.path))
    })?;
    let warnings = unknown_keys(&document, &description)
        .map(|keys| Warning {
            file: file.to_owned(),
            files: 1,
            text: format!("keys that the format does not name are ignored: {keys}"),
        })
        .into_iter()
        .collect();
    Ok((description, warnings))
}

/// A step into a TOML document.
#[derive(Clone, Debug, PartialEq)]
enum Step {
    Key(String),
    Index(usize),
}

/// What [`check`] found, and at which key.
#[derive(Clone, Debug, PartialEq)]
struct Finding {
    path: Vec<Step>,
    problem: Problem,
    names_value: bool,
}

/// Refuses a description that breaks the format: for data made in memory before it is written.
///
/// # Errors
/// The key and what is wrong with it, against the name `dataset.toml` in `folder`.
pub fn check_description(description: &Description, folder: &Path) -> Result<(), DatasetError> {
    let file = folder.join("dataset.toml");
    if description.format != FORMAT {
        return Err(DatasetError::of_file(file, Problem::UnknownFormat)
            .column("format")
            .value(description.format.clone()));
    }
    check(description)
        .map_err(|finding| DatasetError::of_file(file, finding.problem).column(display_path(&finding.path)))
}

fn check(description: &Description) -> Result<(), Finding> {
    let top = |name: &str| vec![Step::Key(name.to_owned())];
    positive(description.sample_rate_hz, top("sample_rate_hz"), "a sample rate")?;
    for (axis, value) in description.gravity_m_s2.iter().enumerate() {
        finite(*value, with(&top("gravity_m_s2"), Step::Index(axis)))?;
    }
    for (index, object) in description.objects.iter().enumerate() {
        let path = with(&top("objects"), Step::Index(index));
        check_object(object, &path)?;
        if description.objects.iter().take(index).any(|other| other.id == object.id) {
            return refuse(key(&path, "id"), Problem::Duplicate);
        }
    }
    if let Some(fingers) = &description.fingers {
        check_contact(fingers, &top("fingers"), "disc, line, point")?;
    }
    for (table, contacts, allowed) in [
        ("pushers", &description.pushers, "plane, line, point"),
        ("supports", &description.supports, "patch, points"),
    ] {
        for (primitive, contact) in contacts {
            check_contact(contact, &key(&top(table), primitive), allowed)?;
        }
    }
    check_sensors(&description.sensors, &top("sensors"))
}

fn check_object(object: &ObjectSpec, path: &[Step]) -> Result<(), Finding> {
    positive(object.mass_kg, key(path, "mass_kg"), "a mass")?;
    let lengths = [
        ("length_m", object.length_m),
        ("side_m", object.side_m),
        ("across_flats_m", object.across_flats_m),
        ("height_m", object.height_m),
    ];
    for (name, length) in lengths {
        if let Some(length) = length {
            positive(length, key(path, name), "a length")?;
        }
    }
    let needed: &[&str] = match object.shape.as_str() {
        "prism" | "cylinder" => &["length_m", "side_m"],
        "polygon" => &["height_m"],
        _ => {
            let allowed = "prism, cylinder, polygon";
            return refuse(key(path, "shape"), Problem::UnknownName { what: "shape", allowed });
        }
    };
    for name in needed {
        if lengths.iter().any(|(other, length)| other == name && length.is_none()) {
            let problem = Problem::MissingKey(format!("shape \"{}\"", object.shape));
            return refuse(key(path, name), problem);
        }
    }
    if object.shape == "polygon" {
        let vertices = object.vertices_m.as_deref().unwrap_or_default();
        if vertices.is_empty() {
            let problem = Problem::MissingKey("shape \"polygon\"".to_owned());
            return refuse(key(path, "vertices_m"), problem);
        }
        if vertices.len() < 3 {
            let problem = Problem::Geometry("a polygon needs at least three corners");
            return refuse(key(path, "vertices_m"), problem);
        }
    }
    points_finite(object.vertices_m.as_deref(), &key(path, "vertices_m"))?;
    for (row, values) in object.inertia_kg_m2.iter().flatten().enumerate() {
        for (column, value) in values.iter().enumerate() {
            let entry = with(&with(&key(path, "inertia_kg_m2"), Step::Index(row)), Step::Index(column));
            finite(*value, entry.clone())?;
            if row == column && *value <= 0.0 {
                return refuse(entry, Problem::NotPositive("a principal diagonal of the inertia"));
            }
        }
    }
    Ok(())
}

fn check_contact(contact: &ContactSpec, path: &[Step], allowed: &'static str) -> Result<(), Finding> {
    let kind = contact.contact.as_str();
    if !allowed.split(", ").any(|name| name == kind) {
        return refuse(key(path, "contact"), Problem::UnknownName { what: "contact", allowed });
    }
    for (name, length) in [("diameter_m", contact.diameter_m), ("length_m", contact.length_m)] {
        if let Some(length) = length {
            positive(length, key(path, name), "a length")?;
        }
    }
    if let Some(radius) = contact.tip_radius_m {
        // Zero is a point that has no size.
        not_negative(radius, key(path, "tip_radius_m"), "a radius")?;
    }
    let missing = match kind {
        "disc" if contact.diameter_m.is_none() => Some("diameter_m"),
        "line" if contact.length_m.is_none() => Some("length_m"),
        "point" if allowed.contains("plane") && contact.tip_radius_m.is_none() => Some("tip_radius_m"),
        "points" if contact.points_m.as_ref().is_none_or(Vec::is_empty) => Some("points_m"),
        _ => None,
    };
    if let Some(name) = missing {
        return refuse(key(path, name), Problem::MissingKey(format!("contact \"{kind}\"")));
    }
    points_finite(contact.points_m.as_deref(), &key(path, "points_m"))
}

fn check_sensors(sensors: &Sensors, path: &[Step]) -> Result<(), Finding> {
    let wrench = |sensor: &WrenchSensor| {
        [
            ("force_noise_n", sensor.force_noise_n),
            ("force_uncertainty_n", sensor.force_uncertainty_n),
            ("torque_noise_nm", sensor.torque_noise_nm),
            ("torque_uncertainty_nm", sensor.torque_uncertainty_nm),
        ]
    };
    for (table, sensor) in [("finger", &sensors.finger), ("pusher", &sensors.pusher)] {
        for (name, value) in wrench(sensor) {
            not_negative(value, key(&key(path, table), name), "noise or uncertainty")?;
        }
    }
    for (name, value) in [
        ("position_noise_m", sensors.pose.position_noise_m),
        ("rotation_noise_rad", sensors.pose.rotation_noise_rad),
    ] {
        not_negative(value, key(&key(path, "pose"), name), "noise")?;
    }
    Ok(())
}

fn points_finite(points: Option<&[[f64; 2]]>, path: &[Step]) -> Result<(), Finding> {
    for (index, point) in points.unwrap_or_default().iter().enumerate() {
        for (axis, value) in point.iter().enumerate() {
            finite(*value, with(&with(path, Step::Index(index)), Step::Index(axis)))?;
        }
    }
    Ok(())
}

fn refuse(path: Vec<Step>, problem: Problem) -> Result<(), Finding> {
    let names_value = !matches!(problem, Problem::MissingKey(_));
    Err(Finding { path, problem, names_value })
}

fn finite(value: f64, path: Vec<Step>) -> Result<(), Finding> {
    if value.is_finite() { Ok(()) } else { refuse(path, Problem::NonFinite) }
}

fn not_negative(value: f64, path: Vec<Step>, what: &'static str) -> Result<(), Finding> {
    finite(value, path.clone())?;
    if value < 0.0 { refuse(path, Problem::Negative(what)) } else { Ok(()) }
}

fn positive(value: f64, path: Vec<Step>, what: &'static str) -> Result<(), Finding> {
    not_negative(value, path.clone(), what)?;
    if value == 0.0 { refuse(path, Problem::NotPositive(what)) } else { Ok(()) }
}

fn with(path: &[Step], step: Step) -> Vec<Step> {
    path.iter().cloned().chain([step]).collect()
}

fn key(path: &[Step], name: &str) -> Vec<Step> {
    with(path, Step::Key(name.to_owned()))
}

fn display_path(path: &[Step]) -> String {
    let mut text = String::new();
    for step in path {
        match step {
            Step::Key(key) if text.is_empty() => text.push_str(key),
            Step::Key(key) => text.push_str(&format!(".{key}")),
            Step::Index(index) => text.push_str(&format!("[{index}]")),
        }
    }
    text
}

/// Where the key of `path` stands; where it is missing, its table.
fn span_of(document: &DeTable<'_>, path: &[Step]) -> Option<std::ops::Range<usize>> {
    let (first, rest) = path.split_first()?;
    let Step::Key(first) = first else { return None };
    let mut spanned = document.get(first.as_str())?;
    for step in rest {
        let next = match (step, spanned.get_ref()) {
            (Step::Key(key), DeValue::Table(table)) => table.get(key.as_str()),
            (Step::Index(index), DeValue::Array(array)) => array.get(*index),
            _ => None,
        };
        match next {
            Some(next) => spanned = next,
            None => break,
        }
    }
    Some(spanned.span())
}

/// Line and column, both from 1, of a byte offset.
fn line_and_column(text: &str, offset: usize) -> (u64, u64) {
    let before = text.get(..offset).unwrap_or(text);
    let line = before.matches('\n').count() as u64 + 1;
    let start = before.rfind('\n').map_or(0, |newline| newline + 1);
    let column = before.get(start..).map_or(0, |rest| rest.chars().count()) as u64 + 1;
    (line, column)
}

/// The parser's message and what to do.
fn advice(message: &str) -> String {
    let message = message.replace('\n', ", ");
    if let Some(rest) = message.strip_prefix("missing field ") {
        format!("the key {rest} is missing; add it")
    } else if message.starts_with("invalid type") || message.starts_with("invalid length") {
        format!("{message}; see docs/dataset.md for the key's type")
    } else {
        format!("not valid TOML: {message}")
    }
}

/// Where a key is missing and the document has one that looks like it: which, as a sentence.
fn misspelt(document: &DeTable<'_>, advice: &str) -> Option<String> {
    let missing = advice.strip_prefix("the key `")?.split('`').next()?;
    let mut keys = Vec::new();
    every_key(document, &mut keys);
    let known = schema::key_names();
    let strangers: Vec<&str> = keys.into_iter().filter(|key| !known.contains(key)).collect();
    let found = schema::did_you_mean(missing, &strangers)?;
    Some(format!("; the file has `{found}`: did you mean `{missing}`?"))
}

fn every_key<'d>(document: &'d DeTable<'_>, keys: &mut Vec<&'d str>) {
    for (key, value) in document {
        keys.push(key.get_ref());
        match value.get_ref() {
            DeValue::Table(table) => every_key(table, keys),
            DeValue::Array(array) => {
                for item in array.iter() {
                    if let DeValue::Table(table) = item.get_ref() {
                        every_key(table, keys);
                    }
                }
            }
            _ => {}
        }
    }
}

/// Keys of the file that the description does not hold, in one line; `None` where it has all.
fn unknown_keys(document: &DeTable<'_>, description: &Description) -> Option<String> {
    let known = toml::Table::try_from(description).ok()?;
    let mut unknown = Vec::new();
    collect_unknown(document, &known, "", &mut unknown);
    (!unknown.is_empty()).then(|| unknown.join(", "))
}

fn collect_unknown(document: &DeTable<'_>, known: &toml::Table, prefix: &str, unknown: &mut Vec<String>) {
    for (key, value) in document {
        let name = format!("{prefix}{}", key.get_ref());
        match (value.get_ref(), known.get(key.get_ref().as_ref())) {
            (_, None) => unknown.push(match schema::did_you_mean(key.get_ref(), &schema::key_names()) {
                Some(meant) => format!("{name} (did you mean {meant}?)"),
                None => name,
            }),
            (DeValue::Table(table), Some(toml::Value::Table(known))) => {
                collect_unknown(table, known, &format!("{name}."), unknown);
            }
            (DeValue::Array(array), Some(toml::Value::Array(known))) => {
                for (index, (value, known)) in array.iter().zip(known).enumerate() {
                    if let (DeValue::Table(table), toml::Value::Table(known)) = (value.get_ref(), known) {
                        collect_unknown(table, known, &format!("{name}[{index}]."), unknown);
                    }
                }
            }
            _ => {}
        }
    }
}
