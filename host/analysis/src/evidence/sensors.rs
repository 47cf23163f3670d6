//! What the sensors may be off by: as stated in `dataset.toml`, and where nothing is stated, as
//! the data and a physical bound give it.
//!
//! A sensor without noise and without error does not exist, so a value of zero is one that nobody
//! stated. Noise is then taken from sample to sample (`crate::evidence::noise::white_noise`,
//! median over the trials). A constant error does not show in any record of one sensor: the bound
//! is [`SHARE_OF_LARGEST`] of the largest force or torque that the sensor read, which is what a
//! well kept strain-gauge sensor keeps of its range. Whatever is found below it is not found.

use schemars::JsonSchema;
use serde::Serialize;
use stickslip_data::{Description, Sample, Sensors, Trial, Wrench, WrenchSensor};

use crate::channels;
use crate::evidence::noise::white_noise;
use crate::evidence::statistics::median;

/// Uncertainty of a sensor about which nothing is stated, over its largest reading.
pub const SHARE_OF_LARGEST: f64 = 0.01;
/// Share of a trial's samples above which a reading counts as its largest: peaks of one sample do
/// not.
const LARGEST: f64 = 0.99;

/// Keys of `[sensors]` that state nothing though the data have such a sensor.
#[derive(Clone, Debug, Default, PartialEq, Eq, JsonSchema, Serialize)]
pub struct Unstated {
    /// Keys of the noise, like `finger.force_noise_n`.
    pub noise: Vec<&'static str>,
    /// Keys of the constant error, like `finger.force_uncertainty_n`.
    pub uncertainty: Vec<&'static str>,
}

impl Unstated {
    /// Is all stated?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.noise.is_empty() && self.uncertainty.is_empty()
    }

    /// The warning; `None` where all is stated.
    #[must_use]
    pub fn sentence(&self) -> Option<String> {
        let keys: Vec<&str> = self.uncertainty.iter().chain(&self.noise).copied().collect();
        (!keys.is_empty()).then(|| {
            format!(
                "SENSOR UNCERTAINTY NOT STATED: [sensors] lacks {} (or has 0). No sensor is perfect: noise is taken \
                 from sample to sample, and as uncertainty 1 % of the largest reading; results below that mean \
                 nothing. State them from the sensors' data sheets",
                keys.join(", ")
            )
        })
    }
}

/// Which keys state nothing. Fingers count where the description has any, pushers likewise.
#[must_use]
pub fn unstated(description: &Description) -> Unstated {
    let Sensors { finger, pusher, pose } = &description.sensors;
    let mut found = Unstated::default();
    let has = [description.fingers.is_some(), !description.pushers.is_empty()];
    let keys = [
        [
            "finger.force_noise_n",
            "finger.torque_noise_nm",
            "finger.force_uncertainty_n",
            "finger.torque_uncertainty_nm",
        ],
        [
            "pusher.force_noise_n",
            "pusher.torque_noise_nm",
            "pusher.force_uncertainty_n",
            "pusher.torque_uncertainty_nm",
        ],
    ];
    for ((sensor, keys), _) in [finger, pusher].into_iter().zip(keys).zip(has).filter(|(_, has)| *has) {
        let values = [
            sensor.force_noise_n,
            sensor.torque_noise_nm,
            sensor.force_uncertainty_n,
            sensor.torque_uncertainty_nm,
        ];
        let missing = |range: std::ops::Range<usize>| {
            range
                .filter(|k| values.get(*k) == Some(&0.0))
                .filter_map(|k| keys.get(k).copied())
                .collect::<Vec<_>>()
        };
        found.noise.extend(missing(0..2));
        found.uncertainty.extend(missing(2..4));
    }
    let poses = [
        ("pose.position_noise_m", pose.position_noise_m),
        ("pose.rotation_noise_rad", pose.rotation_noise_rad),
    ];
    found.noise.extend(poses.into_iter().filter(|(_, value)| *value == 0.0).map(|(key, _)| key));
    found
}

/// Sensors with what nobody stated filled in.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize)]
pub struct SensorsUsed {
    /// To work with.
    #[serde(skip)]
    pub sensors: Sensors,
    /// Keys that were filled in; `uncertainty` not empty: the least that an effect must exceed was
    /// stated by nobody.
    pub unstated: Unstated,
    /// What was taken, in words; empty where all was stated.
    pub taken: Vec<String>,
}

/// What one trial shows of the sensors: force or position first, torque or rotation second.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// Noise from sample to sample of each finger.
    finger_noise: [[Option<f64>; 2]; 2],
    pusher_noise: [Option<f64>; 2],
    pose_noise: [Option<f64>; 2],
    /// Largest reading of either finger.
    finger_largest: [Option<f64>; 2],
    pusher_largest: [Option<f64>; 2],
}

impl Seen {
    /// Of a trial.
    #[must_use]
    pub fn of(trial: &Trial) -> Self {
        let fingers: [Read; 2] = [|s| s.finger[0], |s| s.finger[1]];
        let pusher: [Read; 1] = [|s| s.pusher_wrench];
        let noise = |of: Read| PARTS.map(|part| white(trial, &|s: &Sample| of(s).map(part)));
        let first = trial.samples.iter().find_map(|s| s.object).map(|pose| channels::pose(&pose).rotation);
        let turn = |s: &Sample| {
            let rotation = channels::pose(&s.object?).rotation;
            Some((rotation * first?.inverse()).scaled_axis().into())
        };
        Self {
            finger_noise: fingers.map(noise),
            pusher_noise: noise(pusher[0]),
            pose_noise: [white(trial, &|s| s.object.map(|pose| pose.position_m)), white(trial, &turn)],
            finger_largest: PARTS.map(|part| largest(trial, &fingers, part)),
            pusher_largest: PARTS.map(|part| largest(trial, &pusher, part)),
        }
    }
}

type Read = fn(&Sample) -> Option<Wrench>;
type Part = fn(Wrench) -> [f64; 3];
const PARTS: [Part; 2] = [|w| w.force_n, |w| w.torque_nm];

fn largest(trial: &Trial, of: &[Read], part: Part) -> Option<f64> {
    let read = |s: &Sample| of.iter().filter_map(|of| of(s)).map(|w| size(part(w))).reduce(f64::max);
    let mut sizes: Vec<f64> = trial.samples.iter().filter_map(read).filter(|x| x.is_finite()).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.get((LARGEST * sizes.len() as f64) as usize).or(sizes.last()).copied()
}

/// The sensors of `description`, completed from `trials`.
#[must_use]
pub fn sensors_or_estimated<'t>(
    description: &Description,
    trials: impl Iterator<Item = &'t Trial>,
) -> SensorsUsed {
    let seen: Vec<Seen> = match unstated(description).is_empty() {
        true => Vec::new(),
        false => trials.map(Seen::of).collect(),
    };
    completed(description, &seen)
}

/// The sensors of `description`, completed from what each trial of the data set has shown.
#[must_use]
pub fn completed(description: &Description, seen: &[Seen]) -> SensorsUsed {
    let unstated = unstated(description);
    let mut used = SensorsUsed { sensors: description.sensors.clone(), unstated, taken: Vec::new() };
    let Sensors { finger, pusher, pose } = &mut used.sensors;
    let noise = |of: &dyn Fn(&Seen) -> Option<f64>| median(seen.iter().filter_map(of));
    let most = |of: &dyn Fn(&Seen) -> Option<f64>| seen.iter().filter_map(of).reduce(f64::max);
    let mut take = |key: &str, unit, value: &mut f64, found: Option<f64>, how: &str| {
        if let (0.0, Some(found)) = (*value, found.filter(|found| *found > 0.0)) {
            *value = found;
            used.taken.push(format!("{key} = {found:.2e} {unit}{how}"));
        }
    };
    let (measured, share) = (" as measured from sample to sample", ", 1 % of the largest reading");
    let of_fingers =
        |part: usize| (0..2).filter_map(|k| noise(&|seen| seen.finger_noise[k][part])).reduce(f64::max);
    if description.fingers.is_some() {
        take("finger.force_noise_n", "N", &mut finger.force_noise_n, of_fingers(0), measured);
        take("finger.torque_noise_nm", "N m", &mut finger.torque_noise_nm, of_fingers(1), measured);
        let bound = |part: usize| most(&|seen| seen.finger_largest[part]).map(|x| SHARE_OF_LARGEST * x);
        take("finger.force_uncertainty_n", "N", &mut finger.force_uncertainty_n, bound(0), share);
        take("finger.torque_uncertainty_nm", "N m", &mut finger.torque_uncertainty_nm, bound(1), share);
    }
    if !description.pushers.is_empty() {
        let of = |part: usize| noise(&|seen| seen.pusher_noise[part]);
        take("pusher.force_noise_n", "N", &mut pusher.force_noise_n, of(0), measured);
        take("pusher.torque_noise_nm", "N m", &mut pusher.torque_noise_nm, of(1), measured);
        let bound = |part: usize| most(&|seen| seen.pusher_largest[part]).map(|x| SHARE_OF_LARGEST * x);
        take("pusher.force_uncertainty_n", "N", &mut pusher.force_uncertainty_n, bound(0), share);
        take("pusher.torque_uncertainty_nm", "N m", &mut pusher.torque_uncertainty_nm, bound(1), share);
    }
    let of = |part: usize| noise(&|seen| seen.pose_noise[part]);
    take("pose.position_noise_m", "m", &mut pose.position_noise_m, of(0), measured);
    take("pose.rotation_noise_rad", "rad", &mut pose.rotation_noise_rad, of(1), measured);
    used
}

/// Noise from sample to sample, root mean square over the axes.
fn white(trial: &Trial, of: &dyn Fn(&Sample) -> Option<[f64; 3]>) -> Option<f64> {
    let axis = |k: usize| white_noise(trial.samples.iter().map(move |s| of(s).map_or(f64::NAN, |x| x[k])));
    let found: Vec<f64> = (0..3).filter_map(axis).collect();
    (!found.is_empty()).then(|| (found.iter().map(|x| x * x).sum::<f64>() / found.len() as f64).sqrt())
}

fn size(x: [f64; 3]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The largest constant error of a force channel (N), or of a torque channel (N m), that counts as what is stated of its sensor: a
/// tenth beyond the uncertainty, and the noise.
#[must_use]
pub fn most_error(sensor: &WrenchSensor, torque: bool) -> f64 {
    match torque {
        true => 1.1 * sensor.torque_uncertainty_nm + 3.0 * sensor.torque_noise_nm.max(1e-6),
        false => 1.1 * sensor.force_uncertainty_n + 3.0 * sensor.force_noise_n.max(1e-4),
    }
}
