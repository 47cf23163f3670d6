//! What the names of columns in recordings tell: body, kind, axis and unit.

use std::sync::LazyLock;

use regex::Regex;

/// What a group of columns measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Of a wrench.
    Force,
    /// Of a wrench.
    Torque,
    /// Of a pose.
    Position,
    /// Under w, x, y, z.
    Quaternion,
    /// Roll, pitch, yaw under x, y, z.
    Angle,
}

/// A column's name without its unit, and the unit: `Fx [N]`, `Fx(N)`, `fx_n`.
pub fn unit(name: &str) -> (String, Option<String>) {
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some((head, rest)) = name.split_once(open)
            && let Some((unit, _)) = rest.split_once(close)
        {
            let unit = match unit.trim() {
                "°" | "degree" | "degrees" => "deg",
                unit => unit,
            };
            return (head.trim().to_owned(), Some(unit.to_owned()));
        }
    }
    let suffixes = [
        ("_nmm", "N mm"),
        ("_ncm", "N cm"),
        ("_nm", "N m"),
        ("_mm", "mm"),
        ("_cm", "cm"),
        ("_us", "us"),
        ("_ms", "ms"),
        ("_ns", "ns"),
        ("_deg", "deg"),
        ("_rad", "rad"),
        ("_kgf", "kgf"),
        ("_n", "N"),
        ("_m", "m"),
        ("_s", "s"),
    ];
    let lower = name.to_ascii_lowercase();
    for (suffix, unit) in suffixes {
        if let Some(head) = lower.strip_suffix(suffix) {
            return (name[..head.len()].to_owned(), Some(unit.to_owned()));
        }
    }
    (name.to_owned(), None)
}

/// Body, kind and axis that a column's name tells.
pub fn meaning(name: &str) -> Option<(String, Kind, char)> {
    let plain = words(&unit(name).0);
    // A body before the axis, after it (`fx_1`, `fx_left`), or a number in between (`F1x`).
    static PATTERNS: LazyLock<Vec<(Kind, Regex)>> = LazyLock::new(|| {
        [
            (
                Kind::Angle,
                r"^(?:(.*?)_)??(?:(?:euler|rpy|angle|rot|rotation|orientation)_+)?(roll|pitch|yaw)(_*[0-9]*)$",
            ),
            (
                Kind::Angle,
                r"^()(?:(?:euler|rpy|angle|rot|rotation|orientation)_+)?(roll|pitch|yaw)_+([a-z][a-z0-9_]*)$",
            ),
            (
                Kind::Quaternion,
                r"^(?:(.*?)_)??(?:q|quat|quaternion|rot|rotation|orientation)_*([wxyz])(_*[0-9]*)$",
            ),
            (Kind::Force, r"^(?:(.*?)_)??(?:f|force)_*([xyz])(_*[0-9]*)$"),
            (Kind::Torque, r"^(?:(.*?)_)??(?:t|m|torque|moment)_*([xyz])(_*[0-9]*)$"),
            (Kind::Position, r"^(?:(.*?)_)??(?:p|pos|position|translation)?_*([xyz])(_*[0-9]*)$"),
            (Kind::Force, r"^(?:(.*?)_)??f([0-9]+)_*([xyz])$"),
            (Kind::Torque, r"^(?:(.*?)_)??[tm]([0-9]+)_*([xyz])$"),
            (
                Kind::Quaternion,
                r"^()(?:q|quat|quaternion|rot|rotation|orientation)_*([wxyz])_+([a-z][a-z0-9_]*)$",
            ),
            (Kind::Force, r"^()(?:f|force)_*([xyz])_+([a-z][a-z0-9_]*)$"),
            (Kind::Torque, r"^()(?:t|m|torque|moment)_*([xyz])_+([a-z][a-z0-9_]*)$"),
            (Kind::Position, r"^()(?:p|pos|position|translation)?_*([xyz])_+([a-z][a-z0-9_]*)$"),
        ]
        .into_iter()
        .filter_map(|(kind, pattern)| Some((kind, Regex::new(pattern).ok()?)))
        .collect()
    });
    for (kind, pattern) in PATTERNS.iter() {
        let Some(found) = pattern.captures(&plain) else { continue };
        let part = |at: usize| found.get(at).map_or("", |part| part.as_str());
        let (axis, tail) = match part(2) {
            "roll" => ("x", part(3)),
            "pitch" => ("y", part(3)),
            "yaw" => ("z", part(3)),
            letter if letter.starts_with(['w', 'x', 'y', 'z']) => (letter, part(3)),
            number => (part(3), number),
        };
        // A speed is no place.
        if ["vel", "acc", "speed", "rate", "dot", "std", "cov"].iter().any(|other| tail.starts_with(other)) {
            return None;
        }
        let body = format!("{}_{}", part(1).trim_matches('_'), tail.trim_matches('_'));
        return Some((body.trim_matches('_').to_owned(), *kind, axis.chars().next()?));
    }
    None
}

/// Words of a name in lower case with `_` between: `Block.Position.X`, `blockPositionX`.
fn words(name: &str) -> String {
    let mut plain = String::new();
    let mut lower_before = false;
    for letter in name.chars() {
        if lower_before && letter.is_uppercase() {
            plain.push('_');
        }
        lower_before = letter.is_lowercase();
        plain.extend(if letter.is_alphanumeric() { letter } else { '_' }.to_lowercase());
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_laboratories_are_understood() {
        let of = |name: &str| meaning(name).map(|(body, kind, axis)| format!("{body} {kind:?} {axis}"));
        for (name, meant) in [
            ("finger1_fx_n", "finger1 Force x"),
            ("Fx [N]", " Force x"),
            ("F1x", "1 Force x"),
            ("Force.z", " Force z"),
            ("left/wrench/torque/y", "left_wrench Torque y"),
            ("T2z_Nmm", "2 Torque z"),
            ("Mx_1", "1 Torque x"),
            ("object_x_m", "object Position x"),
            ("Block.Position.X (mm)", "block Position x"),
            ("x", " Position x"),
            ("obj_qw", "obj Quaternion w"),
            ("Block Rotation W", "block Quaternion w"),
            ("Fx_left", "left Force x"),
            ("Tz_plate", "plate Torque z"),
            ("x_object_mm", "object Position x"),
            ("qw_hand", "hand Quaternion w"),
            ("roll", " Angle x"),
            ("object_pitch_deg", "object Angle y"),
            ("Block Rotation Yaw (°)", "block Angle z"),
            ("roll_hand", "hand Angle x"),
        ] {
            assert_eq!(of(name).as_deref(), Some(meant), "{name}");
        }
        assert_eq!(of("max"), None);
        assert_eq!(of("x_velocity"), None);
        assert_eq!(of("yaw_rate"), None);
        assert_eq!(of("status"), None);
    }
}
