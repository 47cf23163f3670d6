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

use nalgebra::{UnitQuaternion, Vector3};
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
/// Knots are first looked for in blocks of so many samples: the search is in proportion to the
/// length of a record then, and not to its square.
const BLOCK: usize = 20_000;
/// Most times that all knots are put in their best place. They settle in two or three.
const ROUNDS: usize = 10;

/// `poses` at the times `t_s` (s, rising) with the measurement noise removed. What is
/// shorter than eight samples is returned as it came.
pub fn denoised(t_s: &[f64], poses: &[Pose<f64>]) -> Vec<Pose<f64>> {
    let (Some(first), true) = (poses.first(), poses.len() >= 2 * SHORTEST && t_s.len() == poses.len()) else {
        return poses.to_vec();
    };
    let track = track(first, poses);
    let lag = independent(t_s, &track);
    let noise = noise(&track, lag);
    if noise.iter().all(|s| *s < NOISELESS) {
        return poses.to_vec();
    }
    let every = (0..track.len()).step_by(lag);
    let (thin_t_s, thin_track): (Vec<f64>, Vec<_>) = every.map(|k| (t_s[k], track[k])).unzip();
    let sums = Sums::of(&thin_t_s, &thin_track, &noise);
    let corners = corners(&sums, &thin_t_s, &knots(&sums));
    let ends = [t_s[0], t_s[track.len() - 1]];
    // A corner within a sample of an end would leave nothing to fit there.
    let inside = corners.into_iter().filter(|t| *t > t_s[1] && *t < t_s[track.len() - 2]);
    let knots_s: Vec<f64> = [ends[0]].into_iter().chain(inside).chain([ends[1]]).collect();
    let columns: Vec<Vec<f64>> = (0..COMPONENTS)
        .map(|k| {
            if noise[k] < NOISELESS {
                track.iter().map(|x| x[k]).collect()
            } else {
                spline((t_s, &track), &knots_s, (k, lag), noise[k])
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

/// Samples from one pose that tells something new to the next: one where every pose was measured,
/// more where poses of a lower rate were interpolated to the samples' times (up to 25 ms, see the
/// module). One for what is too short to tell.
pub fn samples_a_pose(t_s: &[f64], poses: &[Pose<f64>]) -> usize {
    match poses.first() {
        Some(first) if poses.len() >= 8 * SHORTEST && t_s.len() == poses.len() => {
            independent(t_s, &track(first, poses))
        }
        _ => 1,
    }
}

/// Positions and rotation vectors since `first`.
fn track(first: &Pose<f64>, poses: &[Pose<f64>]) -> Vec<[f64; COMPONENTS]> {
    poses
        .iter()
        .map(|p| {
            let d = p.position_m - first.position_m;
            let r = (p.rotation * first.rotation.inverse()).scaled_axis();
            [d.x, d.y, d.z, r.x, r.y, r.z]
        })
        .collect()
}

/// Poses at all times `t_s`, straight between those that are known, the nearest beyond; `None`
/// where none is.
pub fn interpolated(t_s: &[f64], known: &[Option<Pose<f64>>]) -> Option<Vec<Pose<f64>>> {
    let at: Vec<(f64, Pose<f64>)> = t_s.iter().zip(known).filter_map(|(t, p)| Some((*t, (*p)?))).collect();
    between(&at, t_s.iter().copied())
}

/// The same at times that rise, between poses `at` known times that do.
pub fn between(at: &[(f64, Pose<f64>)], t_s: impl Iterator<Item = f64>) -> Option<Vec<Pose<f64>>> {
    let (first, last) = (at.first()?.1, at.last()?.1);
    let mut next = 0;
    let pose = |t: f64| {
        while at.get(next).is_some_and(|(other, _)| *other < t) {
            next += 1;
        }
        match (next.checked_sub(1).and_then(|k| at.get(k)), at.get(next)) {
            (_, Some((t1, b))) if *t1 == t => *b,
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
    Some(t_s.map(pose).collect())
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

    /// Sums over samples `a..b` about their means: of the times squared, and in component `k` of
    /// the values squared and of both.
    fn about_mean(&self, (a, b): (usize, usize), k: usize) -> (f64, f64, f64) {
        let n = (b - a) as f64;
        let (t, x) = (self.t[b] - self.t[a], self.x[b][k] - self.x[a][k]);
        let tt = self.tt[b] - self.tt[a] - t * t / n;
        (tt, self.xx[b][k] - self.xx[a][k] - x * x / n, self.tx[b][k] - self.tx[a][k] - t * x / n)
    }

    /// Squared error of the best lines over samples `a..b`, in units of the noise.
    fn error(&self, a: usize, b: usize) -> f64 {
        (0..COMPONENTS)
            .map(|k| {
                let (tt, xx, tx) = self.about_mean((a, b), k);
                (xx - if tt > 0.0 { tx * tx / tt } else { 0.0 }).max(0.0)
            })
            .sum()
    }

    /// The line of component `k` over samples `a..b`: value at the time `at_s` since the first
    /// sample, and slope, in units of the noise. A slope that is none is zero.
    fn line(&self, (a, b): (usize, usize), k: usize, at_s: f64) -> (f64, f64) {
        let n = (b - a) as f64;
        let (tt, _, tx) = self.about_mean((a, b), k);
        let slope = if tx.abs() > MOVES * tt.sqrt() { tx / tt } else { 0.0 };
        let (mean_t, mean_x) = ((self.t[b] - self.t[a]) / n, (self.x[b][k] - self.x[a][k]) / n);
        (mean_x + slope * (at_s - mean_t), slope)
    }
}

/// Places of the knots among the samples, with both ends: each is the first sample of its stretch.
fn knots(sums: &Sums) -> Vec<usize> {
    let n = sums.x.len() - 1;
    let mut knots: Vec<usize> = (0..n).step_by(BLOCK).chain([n]).collect();
    for pair in knots.clone().windows(2) {
        split(sums, pair[0], pair[1], &mut knots);
    }
    knots.sort_unstable();
    // The first cut of rest, motion, rest may lie anywhere in the motion: each knot is put where it
    // is best between its neighbours as they are now, or taken out.
    for _ in 0..ROUNDS {
        let mut next = Vec::with_capacity(knots.len());
        next.extend(knots.first());
        for pair in knots.windows(2).skip(1) {
            let before = next.last().copied().unwrap_or(0);
            next.extend(cut(sums, before, pair[1]));
        }
        next.push(n);
        let settled = next == knots;
        knots = next;
        if settled {
            break;
        }
    }
    knots
}

/// Splits `a..b` where two lines are better than one by more than chance.
fn split(sums: &Sums, a: usize, b: usize, knots: &mut Vec<usize>) {
    let mut open = vec![(a, b)];
    while let Some((a, b)) = open.pop() {
        if let Some(at) = cut(sums, a, b) {
            knots.push(at);
            open.extend([(a, at), (at, b)]);
        }
    }
}

/// Where two lines over `a..b` are best, if they are better than one by more than chance.
fn cut(sums: &Sums, a: usize, b: usize) -> Option<usize> {
    if b - a < 2 * SHORTEST {
        return None;
    }
    let (parts, at) = (a + SHORTEST..=b - SHORTEST)
        .map(|m| (sums.error(a, m) + sums.error(m, b), m))
        .min_by(|x, y| x.0.total_cmp(&y.0))?;
    // Seven more numbers (a slope in each component, and the place), BIC doubled for the search.
    let price = 14.0 * ((sums.x.len() - 1) as f64).ln();
    (sums.error(a, b) - parts > price).then_some(at)
}

/// When the track turns from one stretch to the next, s: the time at which the lines of both, held
/// where they do not move, come closest, in units of the noise. Samples tell a corner only to
/// their distance, which at 60 Hz is 0.2 mm of a push at 10 mm/s, and two lines that need not meet tell
/// it to a few of them; the crossing of lines of many samples tells it to the noise over the speed.
fn corners(sums: &Sums, t_s: &[f64], knots: &[usize]) -> Vec<f64> {
    let mut knots = knots.to_vec();
    let mut found = Vec::new();
    // The second time with the samples about each corner on the side to which they belong.
    for _ in 0..2 {
        found = knots.windows(3).map(|three| corner(sums, t_s, three)).collect();
        for (knot, at_s) in knots.iter_mut().skip(1).zip(&found) {
            *knot = t_s.partition_point(|t| t < at_s);
        }
    }
    found
}

/// The corner at the middle one of three knots, s.
fn corner(sums: &Sums, t_s: &[f64], three: &[usize]) -> f64 {
    let (a, m, b) = (three[0], three[1], three[2]);
    let between_s = 0.5 * (t_s[m] + t_s[m - 1]);
    let (mut across, mut square) = (0.0, 0.0);
    for k in 0..COMPONENTS {
        let (x, v) = sums.line((a, m), k, between_s - t_s[0]);
        let (y, w) = sums.line((m, b), k, between_s - t_s[0]);
        across -= (w - v) * (y - x);
        square += (w - v) * (w - v);
    }
    let shift_s = if square > 0.0 { across / square } else { 0.0 };
    // Lines that cross farther away do not meet here: the track jumps, or bends all along.
    let most_s = (t_s[m] - t_s[a]).min(t_s[b - 1] - t_s[m - 1]) / 3.0;
    if shift_s.abs() <= most_s { between_s + shift_s } else { between_s }
}

/// Least squares values of component `k` at every sample on hat functions at the times `knots_s`;
/// stretches without significant slope share one value.
fn spline(
    (t_s, track): (&[f64], &[[f64; COMPONENTS]]),
    knots_s: &[f64],
    (k, lag): (usize, usize),
    noise: f64,
) -> Vec<f64> {
    let stretches = knots_s.len() - 1;
    // The stretch of each sample.
    let mut owner = Vec::with_capacity(track.len());
    let mut s = 0;
    for t in t_s {
        while s + 1 < stretches && *t >= knots_s[s + 1] {
            s += 1;
        }
        owner.push(s);
    }
    let mut variable = vec![0; knots_s.len()];
    let mut from = 0;
    for (s, own) in owner.chunk_by(|a, b| a == b).map(|own| (own[0], own.len())) {
        let of = from..from + own;
        from += own;
        let n = own as f64;
        let mean_t = t_s[of.clone()].iter().sum::<f64>() / n;
        let mean_x = track[of.clone()].iter().map(|x| x[k]).sum::<f64>() / n;
        let (mut tt, mut tx) = (0.0, 0.0);
        for i in of {
            tt += (t_s[i] - mean_t) * (t_s[i] - mean_t);
            tx += (t_s[i] - mean_t) * (track[i][k] - mean_x);
        }
        // Of `lag` samples only one tells something new.
        variable[s + 1] = usize::from(tx.abs() > MOVES * noise * (tt * lag as f64).sqrt());
    }
    for s in 0..stretches {
        variable[s + 1] += variable[s];
    }
    let weights = |i: usize| {
        let s = owner[i];
        let (a, b) = (knots_s[s], knots_s[s + 1]);
        let u = if b > a { (t_s[i] - a) / (b - a) } else { 0.0 };
        [(variable[s], 1.0 - u), (variable[s + 1], u)]
    };
    let count = variable[stretches] + 1;
    let (mut diagonal, mut beside, mut right) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
    for i in 0..track.len() {
        let [(p, wp), (q, wq)] = weights(i);
        right[p] += wp * track[i][k];
        right[q] += wq * track[i][k];
        diagonal[p] += wp * wp;
        diagonal[q] += wq * wq;
        if p == q {
            diagonal[p] += 2.0 * wp * wq;
        } else {
            beside[p] += wp * wq;
        }
    }
    match tridiagonal(diagonal, &beside, right) {
        Some(values) => {
            (0..track.len()).map(|i| weights(i).iter().map(|(p, w)| w * values[*p]).sum()).collect()
        }
        None => track.iter().map(|x| x[k]).collect(),
    }
}

/// Solves a symmetric tridiagonal system; `beside[i]` couples `i` and `i + 1`. `None` where it is not
/// positive definite.
fn tridiagonal(mut diagonal: Vec<f64>, beside: &[f64], mut right: Vec<f64>) -> Option<Vec<f64>> {
    let n = right.len();
    for i in 0..n {
        if !(diagonal[i] > 0.0) {
            return None;
        }
        if i + 1 < n {
            let factor = beside[i] / diagonal[i];
            diagonal[i + 1] -= factor * beside[i];
            right[i + 1] -= factor * right[i];
        }
    }
    for i in (0..n).rev() {
        let later = if i + 1 < n { beside[i] * right[i + 1] } else { 0.0 };
        right[i] = (right[i] - later) / diagonal[i];
    }
    Some(right)
}
