//! Rows that a logger filled in: what a slow sensor measured, taken out of a file of a higher rate.
//!
//! A logger that asks a sensor more often than it measures writes its last value again, or a line from value to value.
//! Such rows say nothing new, and a line begins to rise up to one true sample before the force does: an onset on it is
//! early in every trial alike. Rows that say something new (they differ from the row before, or bend the line) come at
//! a regular distance then, and only they are kept.

/// Rows of a signal of up to six components.
pub(super) type Rows = Vec<(f64, [f64; 6])>;

/// Fewer rows tell nothing.
const LEAST: usize = 32;
/// Bends below this share of the largest ones (noise at the sensor's samples) are rounding of the file.
const ROUNDING: f64 = 0.05;
/// Sensors that are slower by more are not looked for.
const SLOWEST: f64 = 40.0;
/// Share of the rows that may say something new: a sensor at half the file's rate, and some more.
const NEW: f64 = 0.55;
/// Share of the rows that may be off the line between their neighbours: two for each sample that lies between rows.
const STRAIGHT: f64 = 0.75;
/// Share of the distances between such rows that must be the usual one, to a row.
const REGULAR: f64 = 0.8;

/// The rows that a sensor measured; `None`: all of them, as far as can be told.
pub(super) fn measured(rows: &Rows) -> Option<Rows> {
    if rows.len() < LEAST {
        return None;
    }
    let keep = regular(&steps(rows), rows.len()).or_else(|| regular(&bends(rows), rows.len()))?;
    Some(keep.into_iter().filter_map(|k| rows.get(k).copied()).collect())
}

/// Rows that differ from the one before.
fn steps(rows: &Rows) -> Vec<usize> {
    let pairs = rows.iter().zip(rows.iter().skip(1)).enumerate();
    pairs.filter(|(_, ((_, before), (_, x)))| before != x).map(|(k, _)| k + 1).collect()
}

/// Rows off the line between their neighbours; of two in a row, between which the line bends, the first.
fn bends(rows: &Rows) -> Vec<usize> {
    let bend = |three: &[(f64, [f64; 6])]| match three {
        [(t0, a), (t, x), (t1, b)] => {
            let share = (t - t0) / (t1 - t0);
            (0..6).map(|k| (x[k] - a[k] - share * (b[k] - a[k])).powi(2)).sum::<f64>().sqrt()
        }
        _ => 0.0,
    };
    let all: Vec<f64> = rows.windows(3).map(bend).collect();
    let limit =
        ROUNDING * super::super::quantile(&super::super::sorted(all.iter().copied()), 1.0 - 1.0 / SLOWEST);
    let bent: Vec<usize> = (0..all.len()).filter(|k| all[*k] > limit).collect();
    // Noise bends every row: lines have straight ones.
    if bent.len() as f64 > STRAIGHT * all.len() as f64 {
        return Vec::new();
    }
    let mut found: Vec<usize> = Vec::new();
    for k in bent {
        // Of three in a row the third is the next one's.
        if found.last() != Some(&k) {
            found.push(k + 1);
        }
    }
    found
}

/// The rows `new`, where they come at a regular distance of two rows or more; and, where nothing new came for longer
/// (a sensor that reads the same), rows at this distance.
fn regular(new: &[usize], count: usize) -> Option<Vec<usize>> {
    if new.len() < LEAST / 4 || new.len() as f64 > NEW * count as f64 {
        return None;
    }
    let mut gaps: Vec<usize> = new.iter().zip(new.iter().skip(1)).map(|(a, b)| b - a).collect();
    let usual = gaps.iter().filter(|gap| **gap > 1).count();
    let all = gaps.len();
    gaps.sort_unstable();
    let gap = gaps[all / 2];
    let near = gaps.iter().filter(|other| other.abs_diff(gap) <= 1).count();
    // A distance of two is one of three at times; of ones there are none.
    if gap < 2 || (near as f64) < REGULAR * all as f64 || (usual as f64) < REGULAR * all as f64 {
        return None;
    }
    let mut keep: Vec<usize> = Vec::with_capacity(new.len() + 2);
    let first = new.first().copied()?;
    keep.extend((1..=first / gap).rev().map(|k| first - k * gap));
    for k in new {
        while let Some(last) = keep.last().filter(|last| 2 * (k - **last) > 3 * gap) {
            keep.push(last + gap);
        }
        keep.push(*k);
    }
    let last = new.last().copied()?;
    keep.extend((1..).map(|k| last + k * gap).take_while(|row| *row < count));
    Some(keep)
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::{Rows, measured};

    /// A force of a sensor at `sensor_hz`, noise of 20 mN, from 0.5 s on 5 N; the unrounded samples.
    fn sensor(sensor_hz: f64, seed: u64) -> Rows {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut noise = || 0.02 * (0..12).map(|_| rng.random::<f64>() - 0.5).sum::<f64>();
        let of = |k: i32| {
            let t = f64::from(k) / sensor_hz;
            let n = if t > 0.5 { 5.0 } else { 0.0 };
            (t, [n + noise(), noise(), noise(), 0.0, 0.0, 0.0])
        };
        (0..).map(of).take_while(|(t, _)| *t < 1.2).collect()
    }

    /// As a logger at 1 kHz writes it, to a tenth of a millinewton.
    fn logged(of: &Rows, line: bool) -> Rows {
        let row = |k: i32| {
            let t = 1e-3 * f64::from(k);
            let next = of.partition_point(|(at, _)| *at <= t + 1e-9);
            let ((t0, a), (t1, b)) = (of[next - 1], of[next.min(of.len() - 1)]);
            let share = if line && t1 > t0 { (t - t0) / (t1 - t0) } else { 0.0 };
            (t, std::array::from_fn(|j| (1e4 * (a[j] + share * (b[j] - a[j]))).round() / 1e4))
        };
        (0..1100).map(row).collect()
    }

    #[test]
    fn of_a_force_that_a_logger_filled_up_only_what_the_sensor_measured_is_kept() {
        for sensor_hz in [100.0, 250.0, 300.0, 500.0] {
            for line in [false, true] {
                let file = logged(&sensor(sensor_hz, 1), line);
                let kept = measured(&file).unwrap_or_else(|| panic!("{sensor_hz} Hz, line {line}: not seen"));
                let rate_hz = (kept.len() - 1) as f64 / (kept[kept.len() - 1].0 - kept[0].0);
                assert!((rate_hz / sensor_hz - 1.0).abs() < 0.05, "{sensor_hz} Hz, line {line}: {rate_hz}");
            }
        }
        // Each row kept is a sample of the sensor, to the file's rounding.
        let own = sensor(250.0, 2);
        for (t, x) in measured(&logged(&own, true)).expect("seen") {
            let (_, sample) = own.iter().find(|(at, _)| (at - t).abs() < 1e-6).expect("a time of the sensor");
            assert!((x[0] - sample[0]).abs() < 1e-4, "at {t} s");
        }
    }

    #[test]
    fn nothing_is_taken_out_of_a_force_at_the_rate_of_its_sensor_even_where_it_is_rounded_or_at_rest() {
        let own = sensor(1000.0, 3);
        assert!(measured(&own).is_none());
        for resolution_n in [1e-3, 0.02, 0.05, 0.2] {
            let rounded = |x: f64| (x / resolution_n).round() * resolution_n;
            let file: Rows = own.iter().map(|(t, x)| (*t, x.map(rounded))).collect();
            assert!(measured(&file).is_none(), "{resolution_n} N");
        }
        let still: Rows = (0..500).map(|k| (1e-3 * f64::from(k), [1.0; 6])).collect();
        assert!(measured(&still).is_none());
    }
}
