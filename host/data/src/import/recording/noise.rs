//! Noise of sensors of which the mapping states none: that of the samples on the data set's base of time.
//!
//! From second differences of neighbouring measured samples, which a steady motion does not enter; median over
//! axes and trials. What a sensor is off by throughout no recording shows: that stays to be stated.

use crate::{Dataset, Pose, Sample, Wrench};

/// What was taken from the data: key of `[sensors]`, value in SI.
pub type Found = Vec<(&'static str, f64)>;

/// Fewer second differences tell no noise.
const FEWEST: usize = 20;
/// Standard deviation of a second difference over that of white noise, times the median of a standard normal
/// distribution's magnitude.
const MEDIAN: f64 = 0.674_489_75 * 2.449_489_743;

/// Fills in what is zero.
pub fn fill(data: &mut Dataset) -> Found {
    let mut found = Found::new();
    let wrench = |of: fn(&Sample) -> Option<Wrench>, part: fn(&Wrench) -> [f64; 3]| {
        median(data, &|s: &Sample| of(s).map(|w| part(&w)))
    };
    let pose = |part: fn(&Pose) -> [f64; 3]| median(data, &|s: &Sample| s.object.map(|p| part(&p)));
    let (force, torque): (fn(&Wrench) -> [f64; 3], fn(&Wrench) -> [f64; 3]) =
        (|w| w.force_n, |w| w.torque_nm);
    let finger: fn(&Sample) -> Option<Wrench> = |s| s.finger[0];
    let pusher: fn(&Sample) -> Option<Wrench> = |s| s.pusher_wrench;
    let values = [
        wrench(finger, force),
        wrench(finger, torque),
        wrench(pusher, force),
        wrench(pusher, torque),
        pose(|p| p.position_m),
        // Twice the vector part of the quaternion, where it turns little.
        pose(|p| [1, 2, 3].map(|k| 2.0 * p.quaternion[k])),
    ];
    let sensors = &mut data.description.sensors;
    let keys = [
        ("finger.force_noise_n", &mut sensors.finger.force_noise_n),
        ("finger.torque_noise_nm", &mut sensors.finger.torque_noise_nm),
        ("pusher.force_noise_n", &mut sensors.pusher.force_noise_n),
        ("pusher.torque_noise_nm", &mut sensors.pusher.torque_noise_nm),
        ("pose.position_noise_m", &mut sensors.pose.position_noise_m),
        ("pose.rotation_noise_rad", &mut sensors.pose.rotation_noise_rad),
    ];
    for ((key, stated), value) in keys.into_iter().zip(values) {
        if let Some(value) = value.filter(|value| *stated == 0.0 && *value > 0.0) {
            // Three digits are more than it is known to.
            *stated = format!("{value:.2e}").parse().unwrap_or(value);
            found.push((key, *stated));
        }
    }
    found
}

/// Median over trials and axes; `None` where nothing is measured.
fn median(data: &Dataset, of: &dyn Fn(&Sample) -> Option<[f64; 3]>) -> Option<f64> {
    let trials = data.trials.iter();
    let each = trials.flat_map(|trial| {
        let measured: Vec<[f64; 3]> = trial.samples.iter().filter_map(of).collect();
        [0, 1, 2].map(|axis| {
            let values = measured.iter().map(|x| x[axis]).filter(|x| x.is_finite()).collect::<Vec<f64>>();
            white(&values)
        })
    });
    let all = super::super::sorted(each.flatten());
    (!all.is_empty()).then(|| super::super::quantile(&all, 0.5))
}

fn white(values: &[f64]) -> Option<f64> {
    let bends = values.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs());
    let bends = super::super::sorted(bends);
    (bends.len() >= FEWEST).then(|| super::super::quantile(&bends, 0.5) / MEDIAN)
}

#[cfg(test)]
mod tests {
    use super::white;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn noise_is_found_beside_a_steady_motion_and_a_jump() {
        let mut random = ChaCha8Rng::seed_from_u64(11);
        let mut noise = || -> f64 { (0..12).map(|_| random.random_range(-0.5..0.5)).sum() };
        let values: Vec<f64> =
            (0..2000).map(|k| 3e-4 * f64::from(k) + f64::from(u8::from(k > 900)) + 1e-3 * noise()).collect();
        let found = white(&values).expect("enough");
        assert!((found / 1e-3 - 1.0).abs() < 0.1, "{found}");
        assert_eq!(white(&values[..5]), None);
    }
}
