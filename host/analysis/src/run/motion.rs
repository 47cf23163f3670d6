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
//!
//! Poses often come at a lower rate than forces (motion capture at 120 Hz beside forces at 250 Hz
//! or 1 kHz) and are interpolated to theirs. Their noise is then equal in part from sample to
//! sample: taken for white it looks far too small, and every wiggle of it becomes a motion. So the
//! lag from which samples differ by the whole noise is found first, and only every so many enter.

use nalgebra::{DMatrix, DVector, UnitQuaternion, Vector3};
use stickslip_shared::track::Pose;

/// Position (m) and rotation vector since the first sample (rad).
const COMPONENTS: usize = 6;
/// Shortest stretch, samples.
const SHORTEST: usize = 4;
/// Poses of at least 60 Hz: samples this far apart are independent, s.
const INDEPENDENT_S: f64 = 0.025;
/// Share of the noise between far samples from which on samples count as independent.
const WHOLE: f64 = 0.75;
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
    let lag = independent(t_s, &track);
    let noise = noise(&track, lag);
    if noise.iter().all(|s| *s < NOISELESS) {
        return poses.to_vec();
    }
    let every: Vec<usize> = (0..track.len()).step_by(lag).collect();
    let thin = |k: &usize| (t_s[*k], track[*k]);
    let (thin_t_s, thin_track): (Vec<f64>, Vec<_>) = every.iter().map(thin).unzip();
    let sums = Sums::of(&thin_t_s, &thin_track, &noise);
    let mut knots = vec![0, thin_track.len() - 1];
    split(&sums, 0, thin_track.len(), &mut knots);
    let mut knots: Vec<usize> = knots.into_iter().filter_map(|k| every.get(k).copied()).collect();
    // The last stretch ends with the track, not with the last sample taken.
    knots.retain(|k| *k + lag < track.len());
    knots.extend([0, track.len() - 1]);
    knots.sort_unstable();
    knots.dedup();
    let columns: Vec<Vec<f64>> = (0..COMPONENTS)
        .map(|k| {
            if noise[k] < NOISELESS {
                track.iter().map(|x| x[k]).collect()
            } else {
                spline((t_s, &track), &knots, (k, lag), noise[k])
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

/// Poses at all times `t_s`, straight between those that are known, the nearest beyond; `None`
/// where none is.
pub fn interpolated(t_s: &[f64], known: &[Option<Pose<f64>>]) -> Option<Vec<Pose<f64>>> {
    let at: Vec<(f64, Pose<f64>)> = t_s.iter().zip(known).filter_map(|(t, p)| Some((*t, (*p)?))).collect();
    let (first, last) = (at.first()?.1, at.last()?.1);
    let mut next = 0;
    let pose = |t: &f64| {
        while at.get(next).is_some_and(|(other, _)| other < t) {
            next += 1;
        }
        match (next.checked_sub(1).and_then(|k| at.get(k)), at.get(next)) {
            (_, Some((t1, b))) if t1 == t => *b,
            (Some((t0, a)), Some((t1, b))) => {
                let share = (t - t0) / (t1 - t0);
                Pose {
                    position_m: a.position_m + (b.position_m - a.position_m) * share,
                    rotation: UnitQuaternion::from_scaled_axis(
                        (b.rotation * a.rotation.inverse()).scaled_axis() * share,
                    ) * a.rotation,
                }
            }
            (None, _) => first,
            (_, None) => last,
        }
    };
    Some(t_s.iter().map(pose).collect())
}

/// Standard deviation of white noise in each component, from second differences of samples `lag`
/// apart (robust: median; a smooth motion does not enter).
fn noise(track: &[[f64; COMPONENTS]], lag: usize) -> [f64; COMPONENTS] {
    std::array::from_fn(|k| {
        let d =
            track.windows(2 * lag + 1).map(|w| (w[0][k] - 2.0 * w[lag][k] + w[2 * lag][k]).abs()).collect();
        middle(d) / 0.6745 / 6.0_f64.sqrt()
    })
}

/// The median; zero of none.
fn middle(mut values: Vec<f64>) -> f64 {
    let half = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(half, f64::total_cmp).1 }
}

/// Samples from one to the next that is independent of it: the least lag at which third
/// differences (those of a bent path vanish) are as large as at [`INDEPENDENT_S`], in the component
/// that needs the largest. One where the noise is white, or where there is none.
fn independent(t_s: &[f64], track: &[[f64; COMPONENTS]]) -> usize {
    let steps = t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let most =
        ((INDEPENDENT_S / middle(steps).max(1e-6)).ceil() as usize).clamp(1, track.len() / (4 * SHORTEST));
    let third = |k: usize, lag: usize| {
        let bent = |w: &[[f64; COMPONENTS]]| w[0][k] - 3.0 * w[lag][k] + 3.0 * w[2 * lag][k] - w[3 * lag][k];
        middle(track.windows(3 * lag + 1).map(|w| bent(w).abs()).collect())
    };
    (0..COMPONENTS)
        .map(|k| {
            let whole = third(k, most.max(1));
            if whole < NOISELESS {
                return 1;
            }
            // A jerk that large would grow eightfold from half the lag: motion, not noise.
            if most >= 4 && whole > 4.0 * third(k, most / 2) {
                return 1;
            }
            (1..most).find(|lag| third(k, *lag) > WHOLE * whole).unwrap_or(most.max(1))
        })
        .max()
        .unwrap_or(1)
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
fn spline(
    (t_s, track): (&[f64], &[[f64; COMPONENTS]]),
    knots: &[usize],
    (k, lag): (usize, usize),
    noise: f64,
) -> Vec<f64> {
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
        // Of `lag` samples only one tells something new.
        let moves = tx.abs() > MOVES * noise * (tt * lag as f64).sqrt();
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

    /// The push as a motion capture of `rate_hz` sees it, interpolated to 250 Hz.
    fn captured(rate_hz: f64) -> (Vec<f64>, Vec<Option<Pose<f64>>>, Vec<f64>) {
        let (t, _, truth) = push(0.0);
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(2);
        let n = Normal::new(0.0, 3e-5).expect("noise");
        let frames = (0..(2.1 * rate_hz) as usize).map(|i| i as f64 / rate_hz);
        let times: Vec<f64> = frames.collect();
        let seen: Vec<Option<Pose<f64>>> = times
            .iter()
            .map(|t| {
                let x = -0.01 * (t - 0.4).clamp(0.0, 1.2);
                let position_m = Vector3::new(x + n.sample(&mut rng), n.sample(&mut rng), n.sample(&mut rng));
                Some(Pose { position_m, rotation: UnitQuaternion::identity() })
            })
            .collect();
        let poses = t
            .iter()
            .map(|t| {
                let k = ((t * rate_hz) as usize).min(times.len() - 2);
                let two = interpolated(&[times[k], *t, times[k + 1]], &[seen[k], None, seen[k + 1]]);
                two.map(|two| if *t == times[k] { two[0] } else { two[1] })
            })
            .collect();
        (t, poses, truth)
    }

    #[test]
    fn a_push_captured_at_100_hz_or_more_is_recovered_like_one_at_the_full_rate_and_at_60_hz_never_goes_back()
    {
        for rate_hz in [60.0, 100.0, 120.0, 125.0, 200.0] {
            let (t, poses, truth) = captured(rate_hz);
            let clean = denoised(&t, &interpolated(&t, &poses).expect("poses"));
            for (i, x) in truth.iter().enumerate() {
                let off = (clean[i].position_m.x - x).abs();
                // Onset and end are known to the travel of a frame, beside the noise.
                let bound = 0.01 / rate_hz + 3e-5;
                assert!(off < bound, "{rate_hz} Hz, sample {i}: {off}");
            }
            // What loses friction is a motion that goes back and forth: none of it.
            let speed = |i: usize| (clean[i + 1].position_m.x - clean[i].position_m.x) / 0.004;
            let worst = (130..370).map(|i| (speed(i) + 0.01).abs()).fold(0.0, f64::max);
            let most = if rate_hz < 100.0 { 3e-3 } else { 1e-3 };
            assert!(worst < most, "{rate_hz} Hz: {worst} m/s");
            let rest = (0..80).map(|i| speed(i).abs()).fold(0.0, f64::max);
            assert!(rest < 1e-9, "{rate_hz} Hz: {rest} m/s at rest");
        }
    }

    #[test]
    fn poses_known_at_every_other_sample_only_lie_on_the_line_between() {
        let (t, poses, truth) = push(0.0);
        let known: Vec<_> = poses.iter().enumerate().map(|(i, p)| (i % 2 == 0).then_some(*p)).collect();
        let filled = interpolated(&t, &known).expect("poses");
        for (x, pose) in truth.iter().zip(&filled).take(499) {
            assert!((pose.position_m.x - x).abs() < 2.1e-5, "{x}");
        }
        assert_eq!(interpolated(&t, &vec![None; t.len()]), None);
    }

    #[test]
    fn a_track_without_noise_is_returned_as_it_came() {
        let (t, poses, _) = push(0.0);
        assert_eq!(denoised(&t, &poses)[333], poses[333]);
    }
}
