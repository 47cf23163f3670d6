//! The prescribed motion without its measurement noise.
//!
//! A rigid contact answers a micrometre of backward motion with the whole contact force, so
//! a model driven by raw motion capture (30 um of noise at 250 Hz is 10 mm/s) shows nothing
//! but noise. Robots move in stretches of nearly constant velocity and rest exactly; so the
//! track is fitted by a continuous piecewise linear function of time: knots by top-down
//! splitting with a Bayesian information criterion, values by least squares on the hat
//! functions, and every component that does not move significantly in a stretch held still
//! in it. A curved path gets as many stretches as its noise can tell apart; a track without
//! noise is returned as it came.

use nalgebra::{DMatrix, DVector, UnitQuaternion, Vector3};
use stickslip_shared::track::Pose;

/// Position (m) and rotation vector since the first sample (rad).
const COMPONENTS: usize = 6;
/// Shortest stretch, samples.
const SHORTEST: usize = 4;
/// Below this a track counts as free of noise, m or rad.
const NOISELESS: f64 = 1e-7;
/// A slope counts as motion beyond this many standard deviations.
const MOVES: f64 = 4.0;

/// `poses` at the times `t_s` (s, rising) with the measurement noise removed. What is
/// shorter than eight samples is returned as it came.
pub fn denoised(t_s: &[f64], poses: &[Pose<f64>]) -> Vec<Pose<f64>> {
    let (Some(first), true) = (poses.first(), poses.len() >= 2 * SHORTEST && t_s.len() == poses.len()) else {
        return poses.to_vec();
    };
    let track: Vec<[f64; COMPONENTS]> = poses
        .iter()
        .map(|p| {
            let d = p.position_m - first.position_m;
            let r = (p.rotation * first.rotation.inverse()).scaled_axis();
            [d.x, d.y, d.z, r.x, r.y, r.z]
        })
        .collect();
    let noise = noise(&track);
    if noise.iter().all(|s| *s < NOISELESS) {
        return poses.to_vec();
    }
    let sums = Sums::of(t_s, &track, &noise);
    let mut knots = vec![0, track.len() - 1];
    split(&sums, 0, track.len(), &mut knots);
    knots.sort_unstable();
    knots.dedup();
    let columns: Vec<Vec<f64>> = (0..COMPONENTS)
        .map(|k| {
            if noise[k] < NOISELESS {
                track.iter().map(|x| x[k]).collect()
            } else {
                spline(t_s, &track, &knots, k, noise[k])
            }
        })
        .collect();
    (0..track.len())
        .map(|i| {
            let at = |k: usize| columns[k][i];
            Pose {
                position_m: first.position_m + Vector3::new(at(0), at(1), at(2)),
                rotation: UnitQuaternion::from_scaled_axis(Vector3::new(at(3), at(4), at(5)))
                    * first.rotation,
            }
        })
        .collect()
}

/// Standard deviation of white noise in each component, from second differences (robust:
/// median; a smooth motion does not enter).
fn noise(track: &[[f64; COMPONENTS]]) -> [f64; COMPONENTS] {
    std::array::from_fn(|k| {
        let mut d: Vec<f64> = track.windows(3).map(|w| (w[0][k] - 2.0 * w[1][k] + w[2][k]).abs()).collect();
        d.sort_by(f64::total_cmp);
        d[d.len() / 2] / 0.6745 / 6.0_f64.sqrt()
    })
}

/// Prefix sums: squared error of a straight line over any stretch in constant time.
struct Sums {
    t: Vec<f64>,
    tt: Vec<f64>,
    x: Vec<[f64; COMPONENTS]>,
    xx: Vec<[f64; COMPONENTS]>,
    tx: Vec<[f64; COMPONENTS]>,
}

impl Sums {
    fn of(t_s: &[f64], track: &[[f64; COMPONENTS]], noise: &[f64; COMPONENTS]) -> Self {
        let n = track.len();
        let zero = [0.0; COMPONENTS];
        let mut s = Sums {
            t: vec![0.0; n + 1],
            tt: vec![0.0; n + 1],
            x: vec![zero; n + 1],
            xx: vec![zero; n + 1],
            tx: vec![zero; n + 1],
        };
        for (i, row) in track.iter().enumerate() {
            let t = t_s[i] - t_s[0];
            s.t[i + 1] = s.t[i] + t;
            s.tt[i + 1] = s.tt[i] + t * t;
            for k in 0..COMPONENTS {
                let x = if noise[k] < NOISELESS { 0.0 } else { row[k] / noise[k] };
                s.x[i + 1][k] = s.x[i][k] + x;
                s.xx[i + 1][k] = s.xx[i][k] + x * x;
                s.tx[i + 1][k] = s.tx[i][k] + t * x;
            }
        }
        s
    }

    /// Squared error of the best lines over samples `a..b`, in units of the noise.
    fn error(&self, a: usize, b: usize) -> f64 {
        let n = (b - a) as f64;
        let t = self.t[b] - self.t[a];
        let tt = self.tt[b] - self.tt[a] - t * t / n;
        (0..COMPONENTS)
            .map(|k| {
                let x = self.x[b][k] - self.x[a][k];
                let xx = self.xx[b][k] - self.xx[a][k] - x * x / n;
                let tx = self.tx[b][k] - self.tx[a][k] - t * x / n;
                (xx - if tt > 0.0 { tx * tx / tt } else { 0.0 }).max(0.0)
            })
            .sum()
    }
}

/// Splits `a..b` where two lines are better than one by more than chance.
fn split(sums: &Sums, a: usize, b: usize, knots: &mut Vec<usize>) {
    if b - a < 2 * SHORTEST {
        return;
    }
    let whole = sums.error(a, b);
    let best = (a + SHORTEST..=b - SHORTEST)
        .map(|m| (sums.error(a, m) + sums.error(m, b), m))
        .min_by(|x, y| x.0.total_cmp(&y.0));
    let Some((parts, at)) = best else { return };
    // Seven more numbers (a slope in each component, and the place), BIC doubled for the search.
    let price = 14.0 * ((sums.x.len() - 1) as f64).ln();
    if whole - parts > price {
        knots.push(at);
        split(sums, a, at, knots);
        split(sums, at, b, knots);
    }
}

/// Least squares values of component `k` at every sample on hat functions at `knots`;
/// stretches without significant slope share one value.
fn spline(t_s: &[f64], track: &[[f64; COMPONENTS]], knots: &[usize], k: usize, noise: f64) -> Vec<f64> {
    let stretches = knots.len() - 1;
    let mut variable = vec![0; knots.len()];
    for s in 0..stretches {
        let (a, b) = (knots[s], knots[s + 1]);
        let n = (b - a + 1) as f64;
        let mean_t = t_s[a..=b].iter().sum::<f64>() / n;
        let mean_x = track[a..=b].iter().map(|x| x[k]).sum::<f64>() / n;
        let (mut tt, mut tx) = (0.0, 0.0);
        for i in a..=b {
            tt += (t_s[i] - mean_t) * (t_s[i] - mean_t);
            tx += (t_s[i] - mean_t) * (track[i][k] - mean_x);
        }
        let moves = tx.abs() > MOVES * noise * tt.sqrt();
        variable[s + 1] = variable[s] + usize::from(moves);
    }
    let count = variable[stretches] + 1;
    let mut normal = DMatrix::<f64>::zeros(count, count);
    let mut right = DVector::<f64>::zeros(count);
    let weights = |i: usize, s: usize| {
        let (a, b) = (t_s[knots[s]], t_s[knots[s + 1]]);
        let u = if b > a { (t_s[i] - a) / (b - a) } else { 0.0 };
        [(variable[s], 1.0 - u), (variable[s + 1], u)]
    };
    let mut owner = Vec::with_capacity(track.len());
    let mut s = 0;
    for i in 0..track.len() {
        while s + 1 < stretches && i >= knots[s + 1] {
            s += 1;
        }
        owner.push(s);
        let w = weights(i, s);
        for (p, wp) in w {
            right[p] += wp * track[i][k];
            for (q, wq) in w {
                normal[(p, q)] += wp * wq;
            }
        }
    }
    let values = match normal.cholesky() {
        Some(c) => c.solve(&right),
        None => return track.iter().map(|x| x[k]).collect(),
    };
    (0..track.len()).map(|i| weights(i, owner[i]).iter().map(|(p, w)| w * values[*p]).sum()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};

    fn push(noise_m: f64) -> (Vec<f64>, Vec<Pose<f64>>, Vec<f64>) {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let n = Normal::new(0.0, noise_m).expect("noise");
        let t: Vec<f64> = (0..500).map(|i| i as f64 * 0.004).collect();
        let x: Vec<f64> = t.iter().map(|t| -0.01 * (t - 0.4).clamp(0.0, 1.2)).collect();
        let poses = x
            .iter()
            .map(|x| Pose {
                position_m: Vector3::new(*x + n.sample(&mut rng), n.sample(&mut rng), n.sample(&mut rng)),
                rotation: UnitQuaternion::identity(),
            })
            .collect();
        (t, poses, x)
    }

    /// Rounding of a held coordinate.
    const REST_M: f64 = 1e-15;

    #[test]
    fn a_noisy_push_is_recovered_to_a_few_micrometres_and_rests_exactly() {
        let (t, poses, truth) = push(3e-5);
        let clean = denoised(&t, &poses);
        for (i, x) in truth.iter().enumerate() {
            assert!((clean[i].position_m.x - x).abs() < 4e-5, "sample {i}");
            assert!((clean[i].position_m.y - clean[0].position_m.y).abs() < REST_M);
        }
        assert!((clean[5].position_m - clean[60].position_m).norm() < REST_M);
        assert!((clean[420].position_m - clean[499].position_m).norm() < REST_M);
        let slope = (clean[300].position_m.x - clean[200].position_m.x) / 0.4;
        assert!((slope + 0.01).abs() < 1e-4, "{slope}");
    }

    #[test]
    fn a_track_without_noise_is_returned_as_it_came() {
        let (t, poses, _) = push(0.0);
        assert_eq!(denoised(&t, &poses)[333], poses[333]);
    }
}
