//! How often something happens, from how often it was seen: a count, the time, and an interval.
//!
//! A rate from seconds of data says little, and nothing seen is not a rate of zero. The interval is
//! the exact one for a Poisson count (F. Garwood, Biometrika 28, 1936): its ends are quantiles of
//! chi-square with `2 n` and `2 n + 2` degrees of freedom over twice the time.

use schemars::JsonSchema;
use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Chance that the interval holds the rate, or more.
pub const CONFIDENCE: f64 = 0.95;

/// A count over a time, and the rates that it allows.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Rate {
    /// How often it was seen.
    pub count: usize,
    /// In this time, h.
    pub hours: f64,
    /// Count over time.
    pub per_hour: f64,
    /// Rates that have a count so low, or so high, with 2.5 % chance each: a 95 % interval.
    pub interval_per_hour: [f64; 2],
}

impl Rate {
    /// Of `count` in `time_s`; `None` without any time.
    #[must_use]
    pub fn of(count: usize, time_s: f64) -> Option<Self> {
        if !(time_s > 0.0 && time_s.is_finite()) {
            return None;
        }
        let hours = time_s / 3600.0;
        let tail = 0.5 * (1.0 - CONFIDENCE);
        let n = count as f64;
        let chi_square = |freedom: f64, share: f64| {
            ChiSquared::new(freedom).map_or(f64::NAN, |law| law.inverse_cdf(share))
        };
        let low = if count == 0 { 0.0 } else { 0.5 * chi_square(2.0 * n, tail) };
        let high = 0.5 * chi_square(2.0 * n + 2.0, 1.0 - tail);
        Some(Rate { count, hours, per_hour: n / hours, interval_per_hour: [low / hours, high / hours] })
    }
}
