//! Units: sizes, speeds, densities, torques and steps that no hand-held object has.

use stickslip_data::{ContactSpec, Description, ObjectSpec, Pose, Sample, Trial};

use super::breach::{Breach, Cause, norm, short, values};
use crate::channels;
use crate::evidence::statistics::quantile;

/// The densest element has 22,600 kg/m^3, the lightest foams some.
const DENSITY_KG_M3: [f64; 2] = [1.0, 23_000.0];
/// No object that a gripper holds is longer.
const LONGEST_M: f64 = 3.0;
/// The object may lie off the grasp by its own size and this much.
const REACH_M: f64 = 0.05;
/// Measured and stated speeds may differ so far: ramps, short motions, slip.
const SPEED_FACTOR: f64 = 5.0;
/// No friction of a dry pad is above this.
const FRICTION: f64 = 2.0;
/// Speeds are taken over this time, s: noise of 30 um is 0.4 mm/s then.
const SPEED_S: f64 = 0.1;

fn breach(cause: Cause, columns: &str, text: String) -> Option<Breach> {
    Some(Breach { cause, columns: columns.to_owned(), text })
}

/// Volume, where the description has its sizes.
fn volume_m3(object: &ObjectSpec) -> Option<f64> {
    match object.shape.as_str() {
        "prism" => Some(object.length_m? * object.side_m?.powi(2)),
        "cylinder" => Some(object.length_m? * object.side_m?.powi(2) * std::f64::consts::PI / 4.0),
        _ => {
            let corners = object.vertices_m.as_deref()?;
            let next = corners.iter().cycle().skip(1);
            let twice: f64 = corners.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
            Some(object.height_m? * twice.abs() / 2.0)
        }
    }
}

/// Distance from the centre of mass to the farthest corner.
fn half_diagonal_m(object: &ObjectSpec) -> f64 {
    let side = object.side_m.unwrap_or(0.0);
    let corner = object.vertices_m.iter().flatten().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max);
    norm([object.length_m.unwrap_or(0.0) / 2.0, side / 2.0, side / 2.0])
        .max(corner.hypot(object.height_m.unwrap_or(0.0) / 2.0))
}

fn object<'d>(description: &'d Description, trial: &Trial) -> Option<&'d ObjectSpec> {
    description.objects.iter().find(|object| object.id == trial.info.object)
}

/// Mass over volume lies between foam and osmium; no object is longer than [`LONGEST_M`]; its
/// inertia is below mass times (half diagonal)^2, all mass in the farthest corner. Without gravity a
/// mass is nominal (a specimen held by a tribometer), and not judged.
pub fn objects(description: &Description) -> Vec<Breach> {
    let mut found = Vec::new();
    for object in &description.objects {
        let size_m = half_diagonal_m(object);
        let key = |name: &str| format!("key {name} of object {}", object.id);
        if 2.0 * size_m > LONGEST_M {
            let text = format!(
                "the object is {} m long, more than a gripper holds; lengths in mm? write metres",
                short(2.0 * size_m)
            );
            found.extend(breach(Cause::LengthUnit, &key("length_m, side_m, vertices_m, height_m"), text));
            continue;
        }
        if description.gravity_m_s2 == [0.0; 3] {
            continue;
        }
        let Some(volume_m3) = volume_m3(object).filter(|volume| *volume > 0.0) else { continue };
        let density = object.mass_kg / volume_m3;
        if !(DENSITY_KG_M3[0]..=DENSITY_KG_M3[1]).contains(&density) {
            let grams = density / 1000.0;
            let likely = match (DENSITY_KG_M3[0]..=DENSITY_KG_M3[1]).contains(&grams) {
                true => format!("the mass in grams? write {} kg", short(object.mass_kg / 1000.0)),
                false => "a mass or a length in another unit? write kilograms and metres".to_owned(),
            };
            let text = format!(
                "{} kg in {} cm3 is {} kg/m3, denser or lighter than any solid; {likely}",
                short(object.mass_kg),
                short(volume_m3 * 1e6),
                short(density)
            );
            found.extend(breach(Cause::MassUnit, &key("mass_kg"), text));
            continue;
        }
        let most = object.mass_kg * size_m * size_m;
        let diagonal =
            object.inertia_kg_m2.map(|inertia| inertia[0][0].max(inertia[1][1]).max(inertia[2][2]));
        if let Some(largest) = diagonal.filter(|largest| *largest > 1.01 * most) {
            let text = format!(
                "{} kg m2, but with all its mass in the farthest corner the object has {}; in kg mm2 or g cm2? \
                 write kg m2, or leave the key out",
                short(largest),
                short(most)
            );
            found.extend(breach(Cause::MassUnit, &key("inertia_kg_m2"), text));
        }
    }
    found
}

/// The median step is within a factor of two of what the rate says.
pub fn time_step(description: &Description, trial: &Trial) -> Option<Breach> {
    let steps = trial.samples.windows(2).map(|pair| pair[1].t_s - pair[0].t_s).collect();
    let step = quantile(steps, 0.5)?;
    let ratio = step * description.sample_rate_hz;
    if (0.5..=2.0).contains(&ratio) {
        return None;
    }
    let unit = [(1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds")]
        .into_iter()
        .find(|(factor, _)| (0.5..=2.0).contains(&(ratio / factor)));
    let likely = match unit {
        Some((_, unit)) => format!("time in {unit}? write seconds"),
        None => "correct sample_rate_hz in dataset.toml or the time stamps".to_owned(),
    };
    let text = format!(
        "the samples are {} apart, sample_rate_hz = {} says {}; {likely}",
        short(step),
        description.sample_rate_hz,
        short(1.0 / description.sample_rate_hz)
    );
    breach(Cause::TimeUnit, "column t_s", text)
}

/// What is grasped lies at the gripper: the distance of their origins is below half the object's
/// diagonal and [`REACH_M`]. In a quarter of the samples at least, as an object may be dropped.
pub fn reach(description: &Description, trial: &Trial) -> Option<Breach> {
    let size_m = half_diagonal_m(object(description, trial)?);
    let pad_m = description.fingers.as_ref().map_or(0.0, patch_m);
    let apart = |s: &Sample| {
        let (a, b) = (s.gripper?.position_m, s.object?.position_m);
        Some(norm([b[0] - a[0], b[1] - a[1], b[2] - a[2]]))
    };
    let apart = quantile(values(trial, apart), 0.25)?;
    let most = size_m + pad_m + REACH_M;
    let text = format!(
        "the object's centre is {} m from the gripper that holds it; its size allows {} m. Positions in mm? write \
         metres; or the poses are in different frames",
        short(apart),
        short(most)
    );
    (apart > most)
        .then(|| breach(Cause::LengthUnit, "columns gripper_{x,y,z}_m, object_{x,y,z}_m", text))
        .flatten()
}

/// Speed exceeded in a fiftieth of the windows.
fn fast(
    trial: &Trial,
    of: impl Fn(&Pose, &Pose) -> f64,
    body: impl Fn(&Sample) -> Option<Pose>,
) -> Option<f64> {
    let track: Vec<(f64, Pose)> = trial.samples.iter().filter_map(|s| Some((s.t_s, body(s)?))).collect();
    let (mut speeds, mut from) = (Vec::new(), 0);
    for (t, pose) in &track {
        while track.get(from + 1).is_some_and(|(other, _)| t - other >= SPEED_S) {
            from += 1;
        }
        let (t0, start) = track.get(from)?;
        if t - t0 >= SPEED_S {
            speeds.push(of(start, pose) / (t - t0));
        }
    }
    quantile(speeds, 0.98)
}

fn path(a: &Pose, b: &Pose) -> f64 {
    norm(std::array::from_fn(|k| b.position_m[k] - a.position_m[k]))
}

fn turn(a: &Pose, b: &Pose) -> f64 {
    channels::pose(a).rotation.angle_to(&channels::pose(b).rotation)
}

/// The drive (gripper or pusher) is about as fast as the trial states.
pub fn speed(trial: &Trial) -> Option<Breach> {
    let stated = trial.info.speed_m_s.filter(|speed| *speed > 0.0)?;
    let gripper = fast(trial, path, |s| s.gripper);
    let pusher = fast(trial, path, |s| s.pusher);
    let measured = gripper.into_iter().chain(pusher).reduce(f64::max)?;
    let ratio = measured / stated;
    if (1.0 / SPEED_FACTOR..=SPEED_FACTOR).contains(&ratio) {
        return None;
    }
    let likely = match ratio {
        500.0..2000.0 => "positions in mm? write metres",
        50.0..200.0 => "positions in cm? write metres",
        5e-4..2e-3 => "speed_m_s in mm/s? write m/s",
        5e-3..2e-2 => "speed_m_s in cm/s? write m/s",
        _ => "correct speed_m_s, the positions or the time stamps",
    };
    let text = format!(
        "gripper or pusher move at {} m/s, speed_m_s says {}; {likely}",
        short(measured),
        short(stated)
    );
    breach(Cause::LengthUnit, "columns gripper_{x,y,z}_m, pusher_{x,y,z}_m; trials.csv, speed_m_s", text)
}

/// The same of rotation.
pub fn rotation_speed(trial: &Trial) -> Option<Breach> {
    let stated = trial.info.speed_rad_s.filter(|speed| *speed > 0.0)?;
    let measured = fast(trial, turn, |s| s.gripper)?;
    let ratio = measured / stated;
    if (1.0 / SPEED_FACTOR..=SPEED_FACTOR).contains(&ratio) {
        return None;
    }
    let likely = match ratio {
        0.01..0.03 => "speed_rad_s in degrees per second? write rad/s",
        _ => "correct speed_rad_s or the gripper's quaternions",
    };
    let text = format!(
        "the gripper turns at {} rad/s, speed_rad_s says {}; {likely}",
        short(measured),
        short(stated)
    );
    breach(Cause::AngleUnit, "columns gripper_q{w,x,y,z}; trials.csv, speed_rad_s", text)
}

/// A slope is an angle below one turn.
pub fn slope(trial: &Trial) -> Option<Breach> {
    let slope = trial.info.slope_rad.filter(|slope| slope.abs() > std::f64::consts::TAU)?;
    let text = format!("slope_rad is {}, more than a turn; in degrees? write radians", short(slope));
    breach(Cause::AngleUnit, "trials.csv, slope_rad", text)
}

/// The largest normal forces (2 % of the samples are above) are within a factor of three of the
/// stated grip: it may decay, and what is dropped is not gripped any more.
pub fn grip(trial: &Trial) -> Option<Breach> {
    let stated = trial.info.grip_n.filter(|grip| *grip > 0.0)?;
    let normal = |finger: usize| {
        quantile(values(trial, |s| s.finger[finger].map(|wrench| wrench.force_n[1].abs())), 0.98)
    };
    let measured = normal(0).into_iter().chain(normal(1)).reduce(f64::max)?;
    let ratio = measured / stated;
    if (1.0 / 3.0..=3.0).contains(&ratio) {
        return None;
    }
    let text = format!(
        "the fingers press with {} N, grip_n says {} N for each; another unit (kgf, mN), or another axis than Y \
         across the grasp? write newtons in gripper axes",
        short(measured),
        short(stated)
    );
    breach(Cause::GripUnit, "columns finger{1,2}_fy_n; trials.csv, grip_n", text)
}

/// Farthest point of a contact from its centre, m.
fn patch_m(contact: &ContactSpec) -> f64 {
    contact.diameter_m.or(contact.length_m).map_or(0.0, |size| size / 2.0)
}

/// A pad only presses, and friction is at most [`FRICTION`] times that: the torque about the
/// patch's centre, `|integral of r x dF|`, is below `r sqrt(1 + mu^2) N`. Plus what the sensor may
/// be off by, and twice that for a patch that is not where it is thought to be.
pub fn finger_torques(description: &Description, trial: &Trial) -> Option<Breach> {
    let fingers = description.fingers.as_ref()?;
    let off =
        description.sensors.finger.torque_uncertainty_nm + 4.0 * description.sensors.finger.torque_noise_nm;
    // A point has some size: a fingertip of 10 mm.
    let lever = 2.0 * patch_m(fingers).max(0.005) * (1.0 + FRICTION * FRICTION).sqrt();
    for finger in 0..2 {
        let excess = |s: &Sample| {
            let wrench = s.finger[finger]?;
            Some(norm(wrench.torque_nm) - (lever * norm(wrench.force_n) + off))
        };
        let torque = |s: &Sample| Some(norm(s.finger[finger]?.torque_nm));
        let force = |s: &Sample| Some(norm(s.finger[finger]?.force_n));
        if quantile(values(trial, excess), 0.5).is_some_and(|excess| excess > 0.0) {
            let middle =
                |of: &dyn Fn(&Sample) -> Option<f64>| quantile(values(trial, of), 0.5).unwrap_or(0.0);
            let text = format!(
                "{} N m at {} N: no pad of this size can bear that at any friction. Torques in N mm? write N m; or \
                 about another point than the patch's centre",
                short(middle(&torque)),
                short(middle(&force))
            );
            return breach(Cause::TorqueUnit, &format!("columns finger{}_t{{x,y,z}}_nm", finger + 1), text);
        }
    }
    None
}

/// The pusher acts on the object: about the pusher's first origin its lever is at most the
/// object's diagonal and the paths of both since the start.
pub fn pusher_torques(description: &Description, trial: &Trial) -> Option<Breach> {
    let sensor = &description.sensors.pusher;
    let off = sensor.torque_uncertainty_nm + 4.0 * sensor.torque_noise_nm;
    let size_m = 2.0 * half_diagonal_m(object(description, trial)?);
    let start = trial.samples.iter().find_map(|s| s.object)?;
    let moved =
        trial.samples.iter().filter_map(|s| s.object).map(|pose| path(&start, &pose)).fold(0.0, f64::max);
    let lever = size_m + moved;
    let excess = |s: &Sample| {
        let wrench = s.pusher_wrench?;
        // Without force there is only the sensor's own error.
        let force = norm(wrench.force_n);
        (force > 1.0 + sensor.force_uncertainty_n).then(|| norm(wrench.torque_nm) - (lever * force + off))
    };
    let excess = quantile(values(trial, excess), 0.5).filter(|excess| *excess > 0.0)?;
    let text = format!(
        "the torque is {} N m above what the force can have at the object's size. Torques in N mm? write N m; or \
         about another point than the pusher's origin at the first sample",
        short(excess)
    );
    breach(Cause::TorqueUnit, "columns pusher_t{x,y,z}_nm", text)
}
