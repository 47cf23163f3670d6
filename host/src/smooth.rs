//! Measured poses of gripper and pusher, freed of sensor noise before they drive a model.
//!
//! Motion capture errs by tens of micrometres from sample to sample; differentiated at
//! 250 Hz that is millimetres a second, as much as the push itself. Robots move in
//! stretches of nearly constant velocity, so each coordinate `x` is chosen to minimise
//!
//! ```text
//! sum (y_i - x_i)^2 / (2 s^2)  +  sum log(1 + (dv_i / e)^2) ,
//! ```
//!
//! `dv_i` the change of velocity at sample i, `s` the noise (estimated from second
//! differences), `e` a velocity change that is nothing. The logarithm leaves the few
//! sample at which the robot starts, stops or turns alone (no ringing, no lag) and
//! smooths all else: the re-weighted least-squares form of sparse trend filtering (Kim et
//! al. 2009, with the re-weighting of Candes et al. 2008). Each round solves a
//! five-diagonal system.

use nalgebra::{UnitQuaternion, Vector3};
use stickslip_shared::track::Pose;

/// Velocity change that counts as none, m/s.
const QUIET_M_S: f64 = 2.5e-5;
/// The same for rotation, rad/s: at the 50 mm of an object's half length.
const QUIET_RAD_S: f64 = 5e-4;
/// Noise below this is left alone: m, and rad.
const NEGLIGIBLE_M: f64 = 1e-6;
const NEGLIGIBLE_RAD: f64 = 1e-5;
/// Rounds of re-weighting.
const ROUNDS: usize = 12;

/// Smooths a path of poses in place. Times rise strictly. Returns the noise found, m and rad.
pub fn smooth(t_s: &[f64], path: &mut [Pose<f64>]) -> (f64, f64) {
    let n = path.len().min(t_s.len());
    if n < 8 {
        return (0.0, 0.0);
    }
    let first = path[0].rotation;
    let mut noise = [0.0f64; 2];
    let mut position = vec![Vector3::zeros(); n];
    let mut turn = position.clone();
    for (k, pose) in path.iter().enumerate().take(n) {
        position[k] = pose.position_m;
        turn[k] = (pose.rotation * first.inverse()).scaled_axis();
    }
    for axis in 0..3 {
        for (values, kind, quiet, negligible) in
            [(&mut position, 0, QUIET_M_S, NEGLIGIBLE_M), (&mut turn, 1, QUIET_RAD_S, NEGLIGIBLE_RAD)]
        {
            let y: Vec<f64> = values.iter().map(|v| v[axis]).collect();
            let s = noise_of(&y);
            noise[kind] = noise[kind].max(s);
            if s > negligible {
                for (v, x) in values.iter_mut().zip(trend(t_s, &y, s, quiet)) {
                    v[axis] = x;
                }
            }
        }
    }
    for (k, pose) in path.iter_mut().enumerate().take(n) {
        pose.position_m = position[k];
        pose.rotation = UnitQuaternion::from_scaled_axis(turn[k]) * first;
    }
    (noise[0], noise[1])
}

/// Standard deviation of white noise on a slow signal: the median of its third
/// differences (motion of constant acceleration leaves none).
pub fn noise_of(y: &[f64]) -> f64 {
    let mut d: Vec<f64> = y
        .windows(4)
        .map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs())
        .filter(|d| d.is_finite())
        .collect();
    if d.is_empty() {
        return 0.0;
    }
    let middle = d.len() / 2;
    let (_, median, _) = d.select_nth_unstable_by(middle, f64::total_cmp);
    // Median of |N(0, 1)| is 0.6745; the differences have variance 20.
    *median / 0.6745 / 20.0f64.sqrt()
}

fn trend(t_s: &[f64], y: &[f64], noise: f64, quiet: f64) -> Vec<f64> {
    let n = y.len();
    // Velocity change at i: a x[i-1] + b x[i] + c x[i+1].
    let stencil: Vec<[f64; 3]> = (1..n - 1)
        .map(|i| {
            let (h0, h1) = ((t_s[i] - t_s[i - 1]).max(1e-9), (t_s[i + 1] - t_s[i]).max(1e-9));
            [1.0 / h0, -1.0 / h0 - 1.0 / h1, 1.0 / h1]
        })
        .collect();
    // Begins from an even smoothing over some 20 samples.
    let spread = noise / (t_s[n - 1] - t_s[0]) * n as f64;
    let mut weight = vec![1.0 / (0.02 * spread + quiet).powi(2); n - 2];
    let mut x = y.to_vec();
    for _ in 0..ROUNDS {
        x = solve(y, noise, &stencil, &weight);
        for (i, w) in weight.iter_mut().enumerate() {
            let [a, b, c] = stencil[i];
            let d = a * x[i] + b * x[i + 1] + c * x[i + 2];
            *w = 2.0 / (quiet * quiet + d * d);
        }
    }
    x
}

/// Solves `(1/s² + D' W D) x = y/s²` by banded Cholesky (LDL').
fn solve(y: &[f64], noise: f64, stencil: &[[f64; 3]], weight: &[f64]) -> Vec<f64> {
    let n = y.len();
    let data = 1.0 / (noise * noise);
    let (mut d0, mut d1, mut d2) = (vec![data; n], vec![0.0; n], vec![0.0; n]);
    for (i, ([a, b, c], w)) in stencil.iter().zip(weight).enumerate() {
        d0[i] += w * a * a;
        d0[i + 1] += w * b * b;
        d0[i + 2] += w * c * c;
        d1[i] += w * a * b;
        d1[i + 1] += w * b * c;
        d2[i] += w * a * c;
    }
    // LDL' in place: d0 becomes D, d1 and d2 the subdiagonals of L.
    for i in 0..n {
        if i >= 1 {
            d0[i] -= d1[i - 1] * d1[i - 1] * d0[i - 1];
        }
        if i >= 2 {
            d0[i] -= d2[i - 2] * d2[i - 2] * d0[i - 2];
        }
        if i + 1 < n {
            if i >= 1 {
                d1[i] -= d2[i - 1] * d1[i - 1] * d0[i - 1];
            }
            d1[i] /= d0[i];
        }
        if i + 2 < n {
            d2[i] /= d0[i];
        }
    }
    let mut x: Vec<f64> = y.iter().map(|v| v * data).collect();
    for i in 0..n {
        if i >= 1 {
            x[i] -= d1[i - 1] * x[i - 1];
        }
        if i >= 2 {
            x[i] -= d2[i - 2] * x[i - 2];
        }
    }
    for (v, d) in x.iter_mut().zip(&d0) {
        *v /= d;
    }
    for i in (0..n).rev() {
        if i + 1 < n {
            x[i] -= d1[i] * x[i + 1];
        }
        if i + 2 < n {
            x[i] -= d2[i] * x[i + 2];
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};

    /// A push: rest, 10 mm/s, rest; with noise.
    fn push(noise_m: f64) -> (Vec<f64>, Vec<Pose<f64>>, Vec<f64>) {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(4);
        let normal = Normal::new(0.0, noise_m.max(1e-12)).expect("a deviation");
        let t: Vec<f64> = (0..600).map(|k| f64::from(k) * 0.004).collect();
        let truth: Vec<f64> = t.iter().map(|t| 0.3 - 0.01 * (t - 0.4).clamp(0.0, 1.5)).collect();
        let path = truth
            .iter()
            .map(|x| Pose {
                position_m: Vector3::new(x + normal.sample(&mut rng), normal.sample(&mut rng), 0.0),
                rotation: UnitQuaternion::identity(),
            })
            .collect();
        (t, path, truth)
    }

    #[test]
    fn noise_is_estimated_and_velocity_recovered_within_three_per_cent() {
        let (t, mut path, truth) = push(3e-5);
        let (found, _) = smooth(&t, &mut path);
        assert!((found - 3e-5).abs() < 6e-6, "{found}");
        for k in 120..450 {
            let v = (path[k + 1].position_m.x - path[k].position_m.x) / 0.004;
            assert!((v + 0.01).abs() < 3e-4, "sample {k}: {v}");
        }
        let worst = path.iter().zip(&truth).map(|(p, x)| (p.position_m.x - x).abs()).fold(0.0, f64::max);
        assert!(worst < 4e-5, "{worst}");
    }

    #[test]
    fn a_path_without_noise_is_left_as_it_is() {
        let (t, mut path, truth) = push(0.0);
        smooth(&t, &mut path);
        assert!(path.iter().zip(&truth).all(|(p, x)| (p.position_m.x - x).abs() < 1e-9));
    }
}
