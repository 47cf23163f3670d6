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

/// The sensors of `description`, completed from `trials`.
#[must_use]
pub fn sensors_or_estimated<'t>(
    description: &Description,
    trials: impl Iterator<Item = &'t Trial> + Clone,
) -> SensorsUsed {
    let unstated = unstated(description);
    let mut used = SensorsUsed { sensors: description.sensors.clone(), unstated, taken: Vec::new() };
    if used.unstated.is_empty() {
        return used;
    }
    let fingers: [fn(&Sample) -> Option<Wrench>; 2] = [|s| s.finger[0], |s| s.finger[1]];
    let pusher: [fn(&Sample) -> Option<Wrench>; 1] = [|s| s.pusher_wrench];
    let mut taken = Vec::new();
    complete(
        "finger",
        &mut used.sensors.finger,
        description.fingers.is_some(),
        &fingers,
        trials.clone(),
        &mut taken,
    );
    complete(
        "pusher",
        &mut used.sensors.pusher,
        !description.pushers.is_empty(),
        &pusher,
        trials.clone(),
        &mut taken,
    );
    let position = |s: &Sample| s.object.map(|pose| pose.position_m);
    let first = |trial: &Trial| {
        trial.samples.iter().find_map(|s| s.object).map(|pose| channels::pose(&pose).rotation)
    };
    for (key, unit, value, found) in [
        (
            "pose.position_noise_m",
            "m",
            &mut used.sensors.pose.position_noise_m,
            median(trials.clone().filter_map(|trial| white(trial, &position))),
        ),
        (
            "pose.rotation_noise_rad",
            "rad",
            &mut used.sensors.pose.rotation_noise_rad,
            median(trials.clone().filter_map(|trial| {
                let start = first(trial)?;
                let turn = |s: &Sample| {
                    let pose = channels::pose(&s.object?);
                    Some((pose.rotation * start.inverse()).scaled_axis().into())
                };
                white(trial, &turn)
            })),
        ),
    ] {
        if let (0.0, Some(found)) = (*value, found.filter(|found| *found > 0.0)) {
            *value = found;
            taken.push(format!("{key} = {found:.2e} {unit} as measured from sample to sample"));
        }
    }
    used.taken = taken;
    used
}

/// Fills in what `sensor` lacks from the wrenches that `of` finds.
fn complete<'t>(
    name: &str,
    sensor: &mut WrenchSensor,
    there: bool,
    of: &[fn(&Sample) -> Option<Wrench>],
    trials: impl Iterator<Item = &'t Trial> + Clone,
    taken: &mut Vec<String>,
) {
    if !there {
        return;
    }
    type Part = fn(Wrench) -> [f64; 3];
    let (force, torque): (Part, Part) = (|w| w.force_n, |w| w.torque_nm);
    let noise = |part: Part| {
        let each = |of: &fn(&Sample) -> Option<Wrench>| {
            let of = *of;
            let read = move |s: &Sample| of(s).map(part);
            median(trials.clone().filter_map(|trial| white(trial, &read)))
        };
        of.iter().filter_map(each).reduce(f64::max)
    };
    let largest = |part: Part| {
        let of_trial = |trial: &Trial| {
            let read = |s: &Sample| of.iter().filter_map(|of| of(s)).map(|w| size(part(w))).reduce(f64::max);
            let mut sizes: Vec<f64> =
                trial.samples.iter().filter_map(read).filter(|x| x.is_finite()).collect();
            sizes.sort_by(f64::total_cmp);
            sizes.get((LARGEST * sizes.len() as f64) as usize).or(sizes.last()).copied()
        };
        trials.clone().filter_map(of_trial).reduce(f64::max)
    };
    for (key, unit, value, part) in [
        ("force_noise_n", "N", &mut sensor.force_noise_n, force),
        ("torque_noise_nm", "N m", &mut sensor.torque_noise_nm, torque),
    ] {
        if let (0.0, Some(found)) = (*value, noise(part).filter(|found| *found > 0.0)) {
            *value = found;
            taken.push(format!("{name}.{key} = {found:.2e} {unit} as measured from sample to sample"));
        }
    }
    for (key, unit, value, part) in [
        ("force_uncertainty_n", "N", &mut sensor.force_uncertainty_n, force),
        ("torque_uncertainty_nm", "N m", &mut sensor.torque_uncertainty_nm, torque),
    ] {
        if let (0.0, Some(largest)) = (*value, largest(part).filter(|largest| *largest > 0.0)) {
            *value = SHARE_OF_LARGEST * largest;
            taken.push(format!("{name}.{key} = {:.2e} {unit}, 1 % of the largest reading", *value));
        }
    }
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
