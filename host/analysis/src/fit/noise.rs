//! What chance does: the covariance of features from run to run, from the repetitions.
//!
//! A run's residual is `J delta + L z + e`: friction of each contact differs from run to run
//! (`J` the sensitivity to it, `delta` relative), a few directions `L` in which runs differ
//! together (how the fingers share a load, where pressure is centred), and independent
//! noise `e`. Beside it stands a floor that no repetition can show: what separates any two
//! sound descriptions of the same contact (a sensor's noise, a tenth of its uncertainty, a
//! share of how much the signal changes within the bin). Effects below it are not called so.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::channels::{COUNT, Quantity};
use crate::evidence::tolerance::RIGID;
use crate::fit::campaign::Campaign;
use crate::fit::features::{FEATURES, Features, quantity};
use crate::fit::phases::{BINS, PEAK};
use stickslip_data::Sensors;

/// Friction of conditions differs by at least this (relative), beside repetitions.
pub const CONDITION_FRICTION: f64 = 0.004;
/// Standard deviation of the prior of friction about the model as given (relative, at least
/// 0.1): nothing where data tell, but what they do not tell stays where it was.
pub const FRICTION_PRIOR: f64 = 0.5;
/// Run-to-run friction where there are no repetitions (relative).
pub const DEFAULT_FRICTION: f64 = 0.02;
/// Most common directions.
const MOST_DIRECTIONS: usize = 5;
/// Weight of the channel's mean variance in each bin's, degrees of freedom.
const PRIOR_FREEDOM: f64 = 4.0;

/// Share of the spread of `feature`'s signal within its bin that counts as floor.
pub fn floor_of_range(feature: usize) -> f64 {
    match quantity(feature) {
        Quantity::Position | Quantity::Rotation => RIGID.of_pose_range,
        _ if feature % BINS == PEAK => RIGID.of_peak,
        Quantity::Force | Quantity::Torque => RIGID.of_range,
    }
}

/// See the module.
#[derive(Clone, Debug)]
pub struct Noise {
    /// Standard deviation of the floor, each feature.
    pub floor: Features,
    /// Independent noise of one run, each feature.
    pub spread: Features,
    /// Common directions of one run, each a feature vector of one standard deviation.
    pub directions: Vec<Features>,
    /// Relative standard deviation of friction from run to run: finger, pusher, support.
    pub friction: [f64; 3],
    /// Degrees of freedom of the repetitions.
    pub freedom: usize,
    /// Change of the fingers' friction with the order of trials, as repetitions show it.
    pub drift: Drift,
    /// Where it is taken from what the model leaves ([`crate::fit::unrepeated`]), not from repetitions: the
    /// weight of each run.
    pub of_misfit: Option<Vec<f64>>,
}

/// Change of friction with the order of trials.
#[derive(Clone, Copy, Debug, Default)]
pub struct Drift {
    /// Relative change from the first trial to the last.
    pub change: f64,
    /// The same from one trial to the next.
    pub per_trial: f64,
    /// Student's t of it.
    pub t: f64,
}

/// Noise and uncertainty of each channel as combined in the features.
pub fn channel_noise(sensors: &Sensors) -> [(f64, f64); COUNT] {
    std::array::from_fn(|k| {
        let sensor = if k < 18 { &sensors.finger } else { &sensors.pusher };
        let factor = if k < 18 { std::f64::consts::SQRT_2 } else { 1.0 };
        match quantity(k * BINS) {
            Quantity::Position => (sensors.pose.position_noise_m.max(1e-6), 0.0),
            Quantity::Rotation => (sensors.pose.rotation_noise_rad.max(1e-5), 0.0),
            Quantity::Force => (factor * sensor.force_noise_n.max(1e-4), factor * sensor.force_uncertainty_n),
            Quantity::Torque => {
                (factor * sensor.torque_noise_nm.max(1e-6), factor * sensor.torque_uncertainty_nm)
            }
        }
    })
}

/// Estimates the noise from residuals (one for each run) and the sensitivities of each
/// run's features to the relative change of finger, pusher and support friction.
pub fn estimate(campaign: &Campaign, residuals: &[Features], friction: &[[Features; 3]]) -> Noise {
    let channels = channel_noise(&campaign.description.sensors);
    let floor: Features = (0..FEATURES)
        .map(|f| {
            let (noise, uncertainty) = channels[f / BINS];
            let compliance = match quantity(f) {
                Quantity::Position => RIGID.position_m,
                Quantity::Rotation => RIGID.rotation_rad,
                Quantity::Force | Quantity::Torque => 0.0,
            };
            let noise = if f % BINS == PEAK { RIGID.largest_of_noise * noise } else { noise };
            noise.hypot(RIGID.of_uncertainty * uncertainty).hypot(compliance)
        })
        .collect();
    let (mut deviations, runs, freedom) = deviations(campaign, residuals);
    if freedom == 0 {
        return Noise {
            spread: floor.clone(),
            floor,
            directions: Vec::new(),
            friction: [DEFAULT_FRICTION; 3],
            freedom,
            drift: Drift::default(),
            of_misfit: None,
        };
    }
    let mut spread = pooled(&deviations, freedom, &floor);
    let mut sd = [0.0; 3];
    let mut drift = Drift::default();
    let last = campaign.runs.iter().map(|r| r.prepared.ordinal).fold(0.0, f64::max);
    let raw = deviations.clone();
    for _ in 0..2 {
        deviations.clone_from(&raw);
        let deltas: Vec<[f64; 3]> = deviations
            .iter_mut()
            .zip(&runs)
            .map(|(d, run)| explain(d, &friction[run.0], &spread, &floor))
            .collect();
        sd = std::array::from_fn(|k| {
            // A drift with the order of trials is no chance.
            let (xx, xy) = runs
                .iter()
                .zip(&deltas)
                .fold((1e-9, 0.0), |(xx, xy), (r, d)| (xx + r.1 * r.1, xy + r.1 * d[k]));
            let left: f64 = runs.iter().zip(&deltas).map(|(r, d)| (d[k] - xy / xx * r.1).powi(2)).sum();
            let sd = (left / freedom as f64).sqrt();
            if k == 0 && sd > 0.0 {
                drift = Drift { change: xy / xx * last, per_trial: xy / xx, t: xy / xx.sqrt() / sd };
            }
            sd.min(0.5)
        });
        spread = pooled(&deviations, freedom, &floor);
    }
    let directions = directions(&deviations, freedom, &mut spread, &floor);
    Noise { floor, spread, directions, friction: sd, freedom, drift, of_misfit: None }
}

/// Deviation of each repeated run from the mean of its condition; which run, and how much
/// later than the condition's mean it was made; degrees of freedom.
fn deviations(campaign: &Campaign, residuals: &[Features]) -> (Vec<Features>, Vec<(usize, f64)>, usize) {
    let (mut out, mut runs, mut freedom) = (Vec::new(), Vec::new(), 0);
    for c in 0..campaign.conditions {
        // Runs that are struck out tell nothing of chance.
        let of: Vec<usize> = (0..campaign.runs.len())
            .filter(|r| campaign.runs[*r].condition == c && is_used(&residuals[*r]))
            .collect();
        if of.len() < 2 {
            continue;
        }
        freedom += of.len() - 1;
        let mean = mean(of.iter().map(|r| &residuals[*r]));
        let order = |r: usize| campaign.runs[r].prepared.ordinal;
        let middle = of.iter().map(|r| order(*r)).sum::<f64>() / of.len() as f64;
        for r in of {
            out.push(residuals[r].iter().zip(&mean).map(|(x, m)| x - m).collect());
            runs.push((r, order(r) - middle));
        }
    }
    (out, runs, freedom)
}

/// Whether anything of a run is left to fit to.
pub fn is_used(residual: &Features) -> bool {
    residual.iter().any(|e| e.is_finite())
}

/// Mean over what is finite.
pub fn mean<'a>(rows: impl Iterator<Item = &'a Features>) -> Features {
    let mut sum = vec![0.0; FEATURES];
    let mut count = vec![0.0; FEATURES];
    for row in rows {
        for (f, x) in row.iter().enumerate() {
            if x.is_finite() {
                sum[f] += x;
                count[f] += 1.0;
            }
        }
    }
    sum.iter().zip(&count).map(|(s, n)| if *n > 0.0 { s / n } else { f64::NAN }).collect()
}

/// Standard deviation of each feature, drawn towards the mean of its channel.
pub fn pooled(deviations: &[Features], freedom: usize, floor: &Features) -> Features {
    let nu = freedom as f64;
    let mut variance = vec![0.0; FEATURES];
    let mut seen = vec![false; FEATURES];
    for row in deviations {
        for (f, x) in row.iter().enumerate() {
            if x.is_finite() {
                variance[f] += x * x / nu;
                seen[f] = true;
            }
        }
    }
    for channel in 0..COUNT {
        let range = channel * BINS..(channel + 1) * BINS;
        let present: Vec<usize> = range.filter(|f| seen[*f]).collect();
        if present.is_empty() {
            continue;
        }
        let mean = present.iter().map(|f| variance[*f]).sum::<f64>() / present.len() as f64;
        for f in present {
            variance[f] = (nu * variance[f] + PRIOR_FREEDOM * mean) / (nu + PRIOR_FREEDOM);
        }
    }
    variance.iter().zip(floor).map(|(v, fl)| v.sqrt().max(0.05 * fl)).collect()
}

/// Removes the best fitting change of friction from a deviation; returns it.
fn explain(
    deviation: &mut Features,
    friction: &[Features; 3],
    spread: &Features,
    floor: &Features,
) -> [f64; 3] {
    let weight = |f: usize| 1.0 / (spread[f] * spread[f] + floor[f] * floor[f]);
    let mut a = nalgebra::Matrix3::<f64>::zeros();
    let mut b = nalgebra::Vector3::<f64>::zeros();
    for (f, d) in deviation.iter().enumerate().filter(|(_, d)| d.is_finite()) {
        for p in 0..3 {
            let jp = friction[p][f];
            if jp.is_finite() {
                b[p] += weight(f) * jp * d;
                for q in 0..3 {
                    let jq = friction[q][f];
                    if jq.is_finite() {
                        a[(p, q)] += weight(f) * jp * jq;
                    }
                }
            }
        }
    }
    // A prior of 5 % keeps what cannot be seen at zero.
    for p in 0..3 {
        a[(p, p)] += 400.0;
    }
    let Some(delta) = a.cholesky().map(|c| c.solve(&b)) else { return [0.0; 3] };
    for (f, d) in deviation.iter_mut().enumerate() {
        for p in 0..3 {
            if friction[p][f].is_finite() {
                *d -= delta[p] * friction[p][f];
            }
        }
    }
    delta.into()
}

/// Leading principal directions of the deviations; their share is taken out of `spread`.
fn directions(
    deviations: &[Features],
    freedom: usize,
    spread: &mut Features,
    floor: &Features,
) -> Vec<Features> {
    let scale: Vec<f64> = spread.iter().zip(floor).map(|(s, f)| s.hypot(*f)).collect();
    let n = deviations.len();
    let z: Vec<Vec<f64>> = deviations
        .iter()
        .map(|d| d.iter().zip(&scale).map(|(x, s)| if x.is_finite() { x / s } else { 0.0 }).collect())
        .collect();
    let gram =
        DMatrix::from_fn(
            n,
            n,
            |i, j| if j > i { 0.0 } else { z[i].iter().zip(&z[j]).map(|(a, b)| a * b).sum() },
        );
    let gram = &gram + gram.transpose() - DMatrix::from_diagonal(&gram.diagonal());
    let eigen = SymmetricEigen::new(gram);
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let typical = eigen.eigenvalues.sum() / freedom as f64;
    let most = MOST_DIRECTIONS.min(freedom / 3);
    let mut out = Vec::new();
    for k in order.into_iter().take(most) {
        let value = eigen.eigenvalues[k];
        if value < 2.5 * typical {
            break;
        }
        // Direction of one standard deviation: Z^T u / sqrt(freedom).
        let direction: Features = (0..FEATURES)
            .map(|f| {
                let x: f64 = (0..n).map(|i| eigen.eigenvectors[(i, k)] * z[i][f]).sum();
                x / (freedom as f64).sqrt() * scale[f]
            })
            .collect();
        for f in 0..FEATURES {
            let left = spread[f] * spread[f] - direction[f] * direction[f];
            spread[f] = left.max(0.1 * spread[f] * spread[f]).sqrt();
        }
        out.push(direction);
    }
    out
}
