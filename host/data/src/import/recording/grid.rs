//! Signals of several rates on one base of time, without inventing data.
//!
//! Of a stream that is faster than the base, a tick takes the straight line through the samples of its interval
//! (least squares, which keeps out what the base cannot show and shifts no ramp in time). Another is interpolated between the two samples about a tick:
//! at every tick where they are at most one and a half intervals apart, otherwise only at the tick
//! next to each sample, so that no value is further from a measurement than half an interval. All
//! other cells stay empty.

/// Greatest distance of neighbours, in intervals of the base, between which every tick is filled.
const NEIGHBOURS: f64 = 1.5;
/// From this many samples in an interval on, they are averaged.
const AVERAGED: f64 = 1.9;

/// What a tick takes of a stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tick {
    /// Nothing.
    Empty,
    /// The line through samples `from..to`, at the tick's time.
    Line {
        /// First.
        from: usize,
        /// One after the last.
        to: usize,
        /// The tick's time, s.
        at_s: f64,
    },
    /// Between sample `left` and the next, `share` of the way.
    Between {
        /// Sample before.
        left: usize,
        /// 0 at the left, 1 at the next.
        share: f64,
    },
}

/// For each tick `start_s + k step_s`, `k` from 0 to `ticks - 1`, what it takes of samples at `t_s`
/// (rising), whose median step is `period_s`.
#[must_use]
pub fn ticks(t_s: &[f64], period_s: f64, start_s: f64, step_s: f64, ticks: usize) -> Vec<Tick> {
    let averaged = step_s / period_s >= AVERAGED;
    (0..ticks)
        .map(|tick| {
            let t = start_s + tick as f64 * step_s;
            if averaged {
                let from = t_s.partition_point(|stamp| *stamp <= t - step_s / 2.0);
                let to = t_s.partition_point(|stamp| *stamp <= t + step_s / 2.0);
                return if to > from { Tick::Line { from, to, at_s: t } } else { Tick::Empty };
            }
            between(t_s, t, step_s)
        })
        .collect()
}

fn between(t_s: &[f64], t: f64, step_s: f64) -> Tick {
    let right = t_s.partition_point(|stamp| *stamp < t);
    // A stamp that is the tick's but for rounding needs no neighbour.
    let tiny = step_s * 1e-6;
    for at in [right, right.wrapping_sub(1)] {
        if t_s.get(at).is_some_and(|stamp| (stamp - t).abs() <= tiny) {
            return Tick::Line { from: at, to: at + 1, at_s: t };
        }
    }
    let (Some(before), Some(after)) = (right.checked_sub(1).and_then(|left| t_s.get(left)), t_s.get(right))
    else {
        return Tick::Empty;
    };
    // One midway between two ticks is the later one's alone, however the times are rounded.
    let near = t - before <= step_s / 2.0 + tiny || after - t < step_s / 2.0 - tiny;
    if after - before <= NEIGHBOURS * step_s || near {
        Tick::Between { left: right - 1, share: (t - before) / (after - before) }
    } else {
        Tick::Empty
    }
}

/// Weights of samples at `t_s` with which their least-squares line has its value at `at_s`.
#[must_use]
pub fn weights(t_s: &[f64], at_s: f64) -> Vec<f64> {
    let share = 1.0 / t_s.len() as f64;
    let middle = t_s.iter().map(|t| t * share).sum::<f64>();
    let spread: f64 = t_s.iter().map(|t| (t - middle).powi(2)).sum();
    let slope = if spread > 0.0 { (at_s - middle) / spread } else { 0.0 };
    t_s.iter().map(|t| share + slope * (t - middle)).collect()
}

/// A column on the base; NaN where a tick is empty or the samples that it needs are.
#[must_use]
pub fn column(ticks: &[Tick], t_s: &[f64], cells: &[f64]) -> Vec<f64> {
    let value = |tick: &Tick| match *tick {
        Tick::Empty => f64::NAN,
        Tick::Line { from, to, at_s } => {
            let measured = || (from..to).filter(|at| !cells[*at].is_nan());
            let times: Vec<f64> = measured().map(|at| t_s[at]).collect();
            if times.is_empty() {
                return f64::NAN;
            }
            weights(&times, at_s).iter().zip(measured()).map(|(weight, at)| weight * cells[at]).sum()
        }
        Tick::Between { left, share } => cells[left] + share * (cells[left + 1] - cells[left]),
    };
    ticks.iter().map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(t_s: &[f64]) -> Vec<f64> {
        t_s.iter().map(|t| 3.0 * t + 1.0).collect()
    }

    #[test]
    fn a_straight_line_stays_one_at_every_rate_and_phase() {
        for period in [0.000_5, 0.001, 0.003_9, 0.004, 0.004_1, 0.008_3, 0.02, 0.1] {
            for phase in [0.0, 0.000_7, 0.003] {
                let t_s: Vec<f64> = (0..400).map(|k| phase + f64::from(k) * period).collect();
                let base = ticks(&t_s, period, 0.0, 0.004, 300);
                let filled = column(&base, &t_s, &line(&t_s));
                assert!(filled.iter().any(|cell| !cell.is_nan()), "{period} {phase}");
                for (k, cell) in filled.iter().enumerate().filter(|(_, cell)| !cell.is_nan()) {
                    let t = k as f64 * 0.004;
                    // Samples on one side only of a tick at an end: the nearest value.
                    let edge = t < t_s[0] || t > t_s[399];
                    let bound = if edge { 3.0 * 0.004 } else { 1e-9 };
                    assert!((cell - (3.0 * t + 1.0)).abs() <= bound, "{period} {phase} {k}: {cell}");
                }
            }
        }
    }

    #[test]
    fn a_slow_stream_fills_as_many_cells_as_it_has_samples_and_none_far_from_one() {
        let t_s: Vec<f64> = (0..100).map(|k| 0.001 + f64::from(k) / 60.0).collect();
        let base = ticks(&t_s, 1.0 / 60.0, 0.0, 0.004, 400);
        let filled: Vec<usize> = (0..400).filter(|k| base[*k] != Tick::Empty).collect();
        assert!((90..=100).contains(&filled.len()), "{}", filled.len());
        for k in filled {
            let t = k as f64 * 0.004;
            let nearest = t_s.iter().map(|stamp| (stamp - t).abs()).fold(f64::INFINITY, f64::min);
            assert!(nearest <= 0.002 + 1e-12, "{t}: {nearest}");
        }
    }

    #[test]
    fn a_gap_stays_a_gap() {
        let t_s: Vec<f64> =
            (0..100).filter(|k| !(40..60).contains(k)).map(|k| f64::from(k) * 0.004).collect();
        let base = ticks(&t_s, 0.004, 0.0, 0.004, 100);
        for (k, tick) in base.iter().enumerate() {
            assert_eq!(*tick == Tick::Empty, (40..60).contains(&k), "{k}");
        }
    }

    #[test]
    fn averaging_a_fast_stream_lowers_white_noise_and_keeps_out_what_the_base_cannot_show() {
        // 500 Hz at a rate of 4 kHz is gone on a base of 250 Hz, where sampling would show it as constant.
        let t_s: Vec<f64> = (0..4000).map(|k| f64::from(k) / 4000.0).collect();
        let wave: Vec<f64> = t_s.iter().map(|t| (std::f64::consts::TAU * 500.0 * t).cos()).collect();
        let base = ticks(&t_s, 1.0 / 4000.0, 0.1, 0.004, 200);
        assert!(column(&base, &t_s, &wave).iter().all(|cell| cell.abs() < 0.1));
    }
}
