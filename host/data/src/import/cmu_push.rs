//! Planar pushes of the CMU Manipulation Lab (Zhou, Paolini, Bagnell, Mason, "A convex
//! polynomial force-motion model for planar sliding", ICRA 2016) as `planar_push` trials.
//!
//! Raw: object pose (mocap) before and after each push, two force components in sensor axes
//! at 100 Hz, robot pose at 33 Hz. The force is `F = Rz(yaw) (-R) (f - f_first)` with the robot's
//! yaw and `R = [[c, c], [c, -c]], c = sqrt(1/2)`: the authors' sensor mount, carried along by the
//! wrist. [`Verification`] holds the physics that this choice must pass.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::{Quaternion, UnitQuaternion, Vector2, Vector3};
use serde::Serialize;

use super::{BadRow, numbers, quantile, sorted};
use crate::{
    ContactSpec, Dataset, Description, FORMAT, ObjectSpec, Pose, PoseSensor, Sample, Sensors, Trial,
    TrialInfo, Wrench, WrenchSensor,
};

const MASS_KG: f64 = 1.518;
/// 1.518 kg of aluminium (2,700 kg/m^3) over the triangle's 0.01125 m^2; the authors do not give it.
const HEIGHT_M: f64 = 0.05;
/// Right corner and the ends of both 150 mm legs, about the centre of mass.
const CORNERS_M: [[f64; 2]; 3] = [[-0.05, -0.05], [0.1, -0.05], [-0.05, 0.1]];
/// Mocap origin to centre of mass, object axes.
const CENTRE_OF_MASS_M: [f64; 3] = [0.05, 0.05, 0.0];
/// A robot pose this much older or younger than a force sample still stands for it.
const HOLD_S: f64 = 0.05;
/// The authors' sliding friction of this block on the black board, for [`Verification`] only.
const BOARD_FRICTION: f64 = 0.282;

/// How the block stood on the board.
#[derive(Clone, Debug, PartialEq)]
pub enum Support {
    /// On its whole face.
    Patch,
    /// On three points, object axes about the centre of mass.
    Points(Vec<[f64; 2]>),
}

impl Support {
    /// From the name of the file or of its folder in the authors' repository: `patch`, or
    /// `a_b_c_d_e_f` with x = a, b, c and y = d, e, f in mm from the right corner.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        let set = name.split("__").next().unwrap_or(name);
        if set.starts_with("patch") {
            return Some(Support::Patch);
        }
        let set = set.trim_end_matches(".txt");
        let mm = set.split('_').map(str::parse).collect::<Result<Vec<f64>, _>>().ok()?;
        let &[x1, x2, x3, y1, y2, y3] = mm.as_slice() else { return None };
        let point = |x: f64, y: f64| [(x - 50.0) / 1000.0, (y - 50.0) / 1000.0];
        Some(Support::Points(vec![point(x1, y1), point(x2, y2), point(x3, y3)]))
    }
}

/// Choices of an import.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// How the block stood.
    pub support: Support,
    /// Radius of the rod about the recorded robot point.
    pub tip_radius_m: f64,
}

/// What the import checked against physics.
#[derive(Clone, Debug, PartialEq, schemars::JsonSchema, Serialize)]
pub struct Verification {
    /// Pushes.
    pub pushes: usize,
    /// Pushes in which the pusher does positive work on the object.
    pub positive_work: usize,
    /// Pushes whose first recorded robot point is outside the object.
    pub start_outside: usize,
    /// Distance of the robot point outside the edge at the first sample: median.
    pub start_distance_m: f64,
    /// Median, and root mean square about it, of the same distance at the last sample, where
    /// pusher and object must touch: what it is beyond the tip radius is misalignment.
    pub end_distance_m: [f64; 2],
    /// Angle between force and inward normal over samples above 1 N: median, 95 % of absolute
    /// values, greatest. All must lie in one friction cone.
    pub force_angle_rad: [f64; 3],
    /// Mean force over the last 70 % of each push: least, median, greatest.
    pub sliding_force_n: [f64; 3],
    /// The same median over 0.282 m g, the authors' sliding friction: below 1 where the object turns.
    pub sliding_force_share: f64,
    /// Greatest force over mean sliding force: median (break-away).
    pub peak_share: f64,
    /// White noise of the force, from differences of neighbours in the first 0.3 s: median.
    pub force_noise_n: f64,
    /// Pushes with more than 0.5 N within the first 0.3 s: in contact early.
    pub early_contact: usize,
    /// Greatest tilt of the recorded object poses, which is dropped (the board is level).
    pub tilt_rad: f64,
}

/// An imported file.
#[derive(Clone, Debug)]
pub struct Import {
    /// In our format, folder not set.
    pub dataset: Dataset,
    /// Physics checks.
    pub verification: Verification,
    /// Rows that could not be used.
    pub bad_rows: Vec<BadRow>,
}

/// What makes a file unusable.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CmuError {
    /// The counts that give the file its structure.
    #[error("line {line}: {text:?} is no count of {what}; is this a file of MLab_EXP/PushExp?")]
    Count {
        /// From 1.
        line: usize,
        /// The line.
        text: String,
        /// What is counted.
        what: &'static str,
    },
    /// No push survived.
    #[error("no complete push in the file; see the rows reported")]
    NoPush,
}

/// One push as recorded, millimetres turned to metres.
struct RawPush {
    before: UnitPose,
    after: UnitPose,
    /// Unix time, sensor axes.
    forces: Vec<[f64; 3]>,
    /// Unix time, position, quaternion.
    robot: Vec<(f64, UnitPose)>,
}

#[derive(Clone, Copy)]
struct UnitPose {
    position_m: Vector3<f64>,
    rotation: UnitQuaternion<f64>,
}

impl UnitPose {
    fn yaw_rad(&self) -> f64 {
        let q = self.rotation.quaternion();
        2.0 * q.k.atan2(q.w)
    }

    fn tilt_rad(&self) -> f64 {
        (self.rotation * Vector3::z()).angle(&Vector3::z())
    }
}

/// Reads `text`, the content of the file `name`.
///
/// # Errors
/// A file without its counts. Rows that cannot be parsed, and pushes that are cut, are
/// reported in [`Import::bad_rows`].
pub fn import(text: &str, name: &str, options: &Options) -> Result<Import, CmuError> {
    let mut bad_rows = Vec::new();
    let pushes = parse(text, &mut bad_rows)?;
    if pushes.is_empty() {
        return Err(CmuError::NoPush);
    }
    let converted: Vec<Converted> =
        pushes.iter().enumerate().map(|(index, push)| convert(push, index)).collect();
    let verification = verify(&converted);
    let description = describe(name, options, &verification);
    let trials = converted.into_iter().map(|converted| converted.trial).collect();
    let dataset = Dataset { folder: Default::default(), description, trials };
    Ok(Import { dataset, verification, bad_rows })
}

/// Lines with their numbers, from 1.
type Lines<'t> = std::iter::Peekable<std::iter::Zip<std::ops::RangeFrom<usize>, std::str::Lines<'t>>>;

fn parse(text: &str, bad_rows: &mut Vec<BadRow>) -> Result<Vec<RawPush>, CmuError> {
    let mut lines: Lines<'_> = (1..).zip(text.lines()).peekable();
    let expected = count(&mut lines, "pushes")?;
    let mut pushes = Vec::new();
    for push in 1..=expected {
        let (Some(before), Some(after)) = (lines.next(), lines.next()) else {
            let reason = format!("the file ends before push {push} of {expected}");
            bad_rows.push(BadRow::new(text.lines().count(), "", reason));
            break;
        };
        let mut object = |(line, text): (usize, &str)| match numbers(text).map(|row| pose(&row)) {
            Ok(Some(pose)) => Some(pose),
            failed => {
                let reason = failed.err().unwrap_or_else(|| "no unit quaternion".to_owned());
                let reason = format!("object pose of push {push}: {reason}; the push is left out");
                bad_rows.push(BadRow::new(line, text, reason));
                None
            }
        };
        let (before, after) = (object(before), object(after));
        let expected_forces = count(&mut lines, "force rows")?;
        let forces = rows(&mut lines, expected_forces, bad_rows, |row: [f64; 3]| Some(row));
        let expected_robot = count(&mut lines, "robot rows")?;
        let robot = rows(&mut lines, expected_robot, bad_rows, |row: [f64; 8]| {
            let [t_s, rest @ ..] = row;
            pose(&rest).map(|pose| (t_s, pose))
        });
        if let (Some(before), Some(after)) = (before, after)
            && forces.len() > 1
            && !robot.is_empty()
        {
            pushes.push(RawPush { before, after, forces, robot });
        }
    }
    Ok(pushes)
}

fn count(lines: &mut Lines<'_>, what: &'static str) -> Result<usize, CmuError> {
    let (line, text) = lines.next().unwrap_or((0, "the file ends here"));
    text.trim().parse().map_err(|_| CmuError::Count { line, text: text.chars().take(60).collect(), what })
}

/// Reads `expected` rows; bad ones, and rows whose time does not rise, are reported.
fn rows<const N: usize, T>(
    lines: &mut Lines<'_>,
    expected: usize,
    bad_rows: &mut Vec<BadRow>,
    convert: impl Fn([f64; N]) -> Option<T>,
) -> Vec<T> {
    let mut rows = Vec::new();
    let mut latest_s = f64::NEG_INFINITY;
    for done in 0..expected {
        let Some((line, text)) = lines.next() else {
            let reason = format!("the file ends {} rows early", expected - done);
            bad_rows.push(BadRow::new(0, "", reason));
            break;
        };
        match numbers::<N>(text) {
            Ok(row) if row[0] <= latest_s => {
                bad_rows.push(BadRow::new(line, text, "time does not rise"));
            }
            Ok(row) => match convert(row) {
                Some(converted) => {
                    latest_s = row[0];
                    rows.push(converted);
                }
                None => bad_rows.push(BadRow::new(line, text, "no unit quaternion")),
            },
            Err(reason) => bad_rows.push(BadRow::new(line, text, reason)),
        }
    }
    rows
}

/// `x, y, z` in mm and a quaternion (rounded to three digits for the robot).
fn pose(row: &[f64; 7]) -> Option<UnitPose> {
    let [x, y, z, w, i, j, k] = *row;
    let quaternion = Quaternion::new(w, i, j, k);
    ((quaternion.norm() - 1.0).abs() < 0.01).then(|| UnitPose {
        position_m: Vector3::new(x, y, z) / 1000.0,
        rotation: UnitQuaternion::from_quaternion(quaternion),
    })
}

/// A push in our format, with what [`verify`] needs of it.
struct Converted {
    trial: Trial,
    start_distance_m: f64,
    end_distance_m: f64,
    work_j: f64,
    angles_rad: Vec<f64>,
    sliding_force_n: f64,
    peak_n: f64,
    early_peak_n: f64,
    noise_n: f64,
    tilt_rad: f64,
}

fn convert(push: &RawPush, index: usize) -> Converted {
    let start_s = push.forces.first().map_or(0.0, |row| row[0]);
    let [before, after] = [push.before, push.after].map(|raw| level(&raw));
    let robot_start = push.robot.first().map_or(Vector3::zeros(), |(_, pose)| pose.position_m);
    let robot_end = push.robot.last().map_or(Vector3::zeros(), |(_, pose)| pose.position_m);
    let (start_distance_m, edge) = distance(&before, &robot_start, None);
    let (end_distance_m, _) = distance(&after, &robot_end, Some(edge));
    let yaws = [yaw(&before), yaw(&after)];
    let turn = Vector2::new(0.0, angle_between(yaws[0], yaws[1]));
    let first = push.forces.first().map_or([0.0; 2], |row| [row[1], row[2]]);
    let normal_pose = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaws[0] + edge_angle(edge));

    let mut samples: Vec<Sample> = Vec::with_capacity(push.forces.len());
    let mut work_j = 0.0;
    let mut angles_rad = Vec::new();
    let mut magnitudes: Vec<f64> = Vec::new();
    let mut cursor = 0;
    let mut previous: Option<(Vector2<f64>, Vector2<f64>)> = None;
    for &[time_s, fx, fy] in &push.forces {
        let robot = interpolate(&push.robot, time_s, &mut cursor);
        let yaw_rad =
            robot.as_ref().or(push.robot.first().map(|(_, pose)| pose)).map_or(0.0, UnitPose::yaw_rad);
        let force = world_force([fx - first[0], fy - first[1]], yaw_rad);
        magnitudes.push(force.norm());
        if let Some(robot) = &robot {
            let at = robot.position_m.xy();
            if let Some((last_at, last_force)) = previous {
                work_j += 0.5 * (force + last_force).dot(&(at - last_at));
            }
            previous = Some((at, force));
        }
        if force.norm() > 1.0 {
            // The object's yaw between its two known poses, with the progress of the push.
            let progress = samples.len() as f64 / push.forces.len() as f64;
            let normal = yaws[0] + turn.y * progress + edge_angle(edge);
            angles_rad.push(angle_between(normal, force.y.atan2(force.x)));
        }
        samples.push(Sample {
            t_s: time_s - start_s,
            pusher: robot.map(|robot| {
                Pose::of(&Vector3::new(robot.position_m.x, robot.position_m.y, HEIGHT_M / 2.0), &normal_pose)
            }),
            pusher_wrench: Some(Wrench { force_n: [force.x, force.y, f64::NAN], torque_nm: [f64::NAN; 3] }),
            ..Sample::default()
        });
    }
    if let Some(sample) = samples.first_mut() {
        sample.object = Some(before);
    }
    if let Some(sample) = samples.last_mut() {
        sample.object = Some(after);
    }
    let early: Vec<f64> = magnitudes
        .iter()
        .zip(&samples)
        .filter(|(_, sample)| sample.t_s < 0.3)
        .map(|(magnitude, _)| *magnitude)
        .collect();
    let late = magnitudes.get(magnitudes.len() * 3 / 10..).unwrap_or_default();
    let duration_s = samples.last().map_or(f64::NAN, |sample| sample.t_s);
    let direction = (robot_end - robot_start).xy();
    let info = TrialInfo {
        trial: format!("push{:02}", index + 1),
        file: format!("trials/push{:02}.csv", index + 1),
        object: "triangle".to_owned(),
        primitive: "planar_push".to_owned(),
        speed_m_s: Some(direction.norm() / duration_s).filter(|speed| speed.is_finite()),
        extra: BTreeMap::from([
            ("edge".to_owned(), EDGES[edge].to_owned()),
            ("push_direction_rad".to_owned(), format!("{:.4}", direction.y.atan2(direction.x))),
        ]),
        ..TrialInfo::default()
    };
    Converted {
        trial: Trial { info, samples },
        start_distance_m,
        end_distance_m,
        work_j,
        angles_rad,
        sliding_force_n: late.iter().sum::<f64>() / late.len().max(1) as f64,
        peak_n: magnitudes.iter().copied().fold(0.0, f64::max),
        early_peak_n: early.iter().copied().fold(0.0, f64::max),
        noise_n: white_noise(&push.forces, start_s),
        tilt_rad: push.before.tilt_rad().max(push.after.tilt_rad()),
    }
}

/// Sensor axes to world: the mount `-R`, then the wrist's yaw.
fn world_force(sensor_n: [f64; 2], yaw_rad: f64) -> Vector2<f64> {
    let c = std::f64::consts::FRAC_1_SQRT_2;
    let [fx, fy] = sensor_n;
    let wrist = Vector2::new(-c * (fx + fy), -c * (fx - fy));
    nalgebra::Rotation2::new(yaw_rad) * wrist
}

/// Mocap pose to the pose of the centre of mass on a level board whose surface is z = 0.
fn level(raw: &UnitPose) -> Pose {
    let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), raw.yaw_rad());
    let centre = raw.position_m + raw.rotation * Vector3::from(CENTRE_OF_MASS_M);
    Pose::of(&Vector3::new(centre.x, centre.y, HEIGHT_M / 2.0), &rotation)
}

fn yaw(pose: &Pose) -> f64 {
    let [w, _, _, k] = pose.quaternion;
    2.0 * k.atan2(w)
}

/// `to - from`, within half a turn.
fn angle_between(from: f64, to: f64) -> f64 {
    let turn = to - from;
    turn.sin().atan2(turn.cos())
}

/// Names of the edges, each from its corner of [`CORNERS_M`] to the next.
const EDGES: [&str; 3] = ["leg_x", "hypotenuse", "leg_y"];

/// Direction of an edge's inward normal, object axes.
fn edge_angle(edge: usize) -> f64 {
    let [a, b] = [CORNERS_M[edge % 3], CORNERS_M[(edge + 1) % 3]];
    // Counter-clockwise corners: inward is a quarter turn left of the edge.
    (b[0] - a[0]).atan2(-(b[1] - a[1]))
}

/// Distance of a world point outside an edge (negative: inside the body), and the edge: the
/// given one, or the one that the point is farthest outside of.
fn distance(object: &Pose, point: &Vector3<f64>, edge: Option<usize>) -> (f64, usize) {
    let offset = point.xy() - Vector2::new(object.position_m[0], object.position_m[1]);
    let local = nalgebra::Rotation2::new(-yaw(object)) * offset;
    let outside = |edge: usize| {
        let (sin, cos) = edge_angle(edge).sin_cos();
        let corner = CORNERS_M[edge % 3];
        -(cos * (local.x - corner[0]) + sin * (local.y - corner[1]))
    };
    match edge {
        Some(edge) => (outside(edge), edge),
        None => (0..3)
            .map(|edge| (outside(edge), edge))
            .fold((f64::NEG_INFINITY, 0), |best, next| if next.0 > best.0 { next } else { best }),
    }
}

/// Robot position at a force sample: linear between its neighbours (the robot is sampled at
/// 33 Hz and moves 0.07 mm between samples); held for [`HOLD_S`] beyond the ends, then unknown.
fn interpolate(robot: &[(f64, UnitPose)], time_s: f64, cursor: &mut usize) -> Option<UnitPose> {
    while robot.get(*cursor + 1).is_some_and(|(next_s, _)| *next_s <= time_s) {
        *cursor += 1;
    }
    let (from_s, from) = *robot.get(*cursor)?;
    if time_s < from_s {
        return (from_s - time_s <= HOLD_S).then_some(from);
    }
    match robot.get(*cursor + 1) {
        Some((to_s, to)) => {
            let share = (time_s - from_s) / (to_s - from_s);
            let position_m = from.position_m.lerp(&to.position_m, share);
            Some(UnitPose { position_m, ..from })
        }
        None => (time_s - from_s <= HOLD_S).then_some(from),
    }
}

/// Standard deviation from differences of neighbours in the first 0.3 s: a slow trend cancels.
fn white_noise(forces: &[[f64; 3]], start_s: f64) -> f64 {
    let early: Vec<_> = forces.iter().take_while(|row| row[0] - start_s < 0.3).collect();
    let pairs = early.windows(2).filter_map(|pair| match pair {
        [a, b] => Some((a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)),
        _ => None,
    });
    // Two axes, and a difference holds the noise of two samples.
    (pairs.sum::<f64>() / (4.0 * early.len().saturating_sub(1).max(1) as f64)).sqrt()
}

fn verify(pushes: &[Converted]) -> Verification {
    let median = |value: fn(&Converted) -> f64| quantile(&sorted(pushes.iter().map(value)), 0.5);
    let angles = sorted(pushes.iter().flat_map(|push| push.angles_rad.iter().copied()));
    let wide = sorted(angles.iter().map(|angle| angle.abs()));
    let sliding = sorted(pushes.iter().map(|push| push.sliding_force_n));
    let end_m = median(|push| push.end_distance_m);
    let spread = pushes.iter().map(|push| (push.end_distance_m - end_m).powi(2)).sum::<f64>();
    let sliding_force_n = [0.0, 0.5, 1.0].map(|share| quantile(&sliding, share));
    Verification {
        pushes: pushes.len(),
        positive_work: pushes.iter().filter(|push| push.work_j > 0.0).count(),
        start_outside: pushes.iter().filter(|push| push.start_distance_m > 0.0).count(),
        start_distance_m: median(|push| push.start_distance_m),
        end_distance_m: [end_m, (spread / pushes.len().max(1) as f64).sqrt()],
        force_angle_rad: [quantile(&angles, 0.5), quantile(&wide, 0.95), quantile(&wide, 1.0)],
        sliding_force_n,
        sliding_force_share: sliding_force_n[1] / (BOARD_FRICTION * MASS_KG * 9.81),
        peak_share: median(|push| push.peak_n / push.sliding_force_n),
        force_noise_n: median(|push| push.noise_n),
        early_contact: pushes.iter().filter(|push| push.early_peak_n > 0.5).count(),
        tilt_rad: pushes.iter().map(|push| push.tilt_rad).fold(0.0, f64::max),
    }
}

fn describe(name: &str, options: &Options, verification: &Verification) -> Description {
    let support = match &options.support {
        Support::Patch => ContactSpec { contact: "patch".to_owned(), ..ContactSpec::default() },
        Support::Points(points) => ContactSpec {
            contact: "points".to_owned(),
            points_m: Some(points.clone()),
            ..ContactSpec::default()
        },
    };
    let pusher = ContactSpec {
        contact: "point".to_owned(),
        tip_radius_m: Some(options.tip_radius_m),
        ..ContactSpec::default()
    };
    // Rounded: the estimates carry two digits.
    let round = |value: f64, step: f64| (value / step).round() * step;
    Description {
        format: FORMAT.to_owned(),
        name: format!("CMU planar push, aluminium triangle on black board: {name}"),
        sample_rate_hz: 100.0,
        gravity_m_s2: [0.0, 0.0, -9.81],
        objects: vec![ObjectSpec {
            id: "triangle".to_owned(),
            shape: "polygon".to_owned(),
            length_m: None,
            side_m: None,
            across_flats_m: None,
            vertices_m: Some(CORNERS_M.to_vec()),
            height_m: Some(HEIGHT_M),
            mass_kg: MASS_KG,
            inertia_kg_m2: None,
        }],
        fingers: None,
        pushers: BTreeMap::from([("planar_push".to_owned(), pusher)]),
        supports: BTreeMap::from([("planar_push".to_owned(), support)]),
        sensors: Sensors {
            pusher: WrenchSensor {
                force_noise_n: round(verification.force_noise_n, 1e-4),
                ..WrenchSensor::default()
            },
            pose: PoseSensor {
                // Robot against mocap, from the pushes themselves: a constant error of each push.
                position_noise_m: round(verification.end_distance_m[1], 1e-5),
                ..PoseSensor::default()
            },
            ..Sensors::default()
        },
    }
}

/// The support that a file's name tells; see [`Support::from_name`].
#[must_use]
pub fn support_of(file: &Path) -> Option<Support> {
    let name = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
    name(file)
        .and_then(|name| Support::from_name(&name))
        .or_else(|| file.parent().and_then(name).and_then(|name| Support::from_name(&name)))
}
