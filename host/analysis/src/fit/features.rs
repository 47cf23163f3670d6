//! A trial as a short vector: the mean of every channel in every phase bin.
//!
//! Twenty-four channels in sixteen bins. Finger wrenches enter as their sum and their
//! difference: the sum follows from balance, the difference is how two rigid fingers share
//! a load, which is statically indeterminate and varies from run to run. Positions and
//! rotations enter as change since the rest before.

use crate::channels::{self, COUNT, Quantity, Signals};
use crate::fit::phases::{BINS, PEAK};
use crate::run::simulate::{Prepared, Simulated};

/// Length of a feature vector: `channel * BINS + bin`.
pub const FEATURES: usize = COUNT * BINS;

/// Feature vector, SI units; NaN where not measured.
pub type Features = Vec<f64>;

/// Which samples a trial's features average over.
#[derive(Clone, Debug)]
pub struct Bins {
    /// Bin of each sample.
    bin: Vec<Option<u8>>,
    /// Samples among which the onset's peak lies.
    peak: std::ops::Range<usize>,
    /// For each sample and channel: measured.
    seen: Vec<u32>,
}

/// Name of the channel of a feature.
pub fn channel_name(channel: usize) -> String {
    match channel {
        6..=11 => channels::NAMES[channel].replace("finger1", "finger_sum"),
        12..=17 => channels::NAMES[channel].replace("finger2", "finger_difference"),
        _ => channels::NAMES[channel].to_string(),
    }
}

/// Sum and difference in place of finger 1 and finger 2.
fn combined(s: &Signals) -> Signals {
    let mut out = *s;
    for k in 6..12 {
        out[k] = s[k] + s[k + 6];
        out[k + 6] = s[k] - s[k + 6];
    }
    out
}

impl Bins {
    /// Bins of a trial, with the samples that were measured.
    pub fn new(prepared: &Prepared, (bin, peak): (Vec<Option<u8>>, std::ops::Range<usize>)) -> Self {
        let seen = prepared
            .measured
            .iter()
            .map(|s| combined(s).iter().enumerate().fold(0, |m, (k, x)| m | (u32::from(x.is_finite()) << k)))
            .collect();
        Self { bin, peak, seen }
    }

    /// Features of the measurement.
    pub fn measured(&self, prepared: &Prepared) -> Features {
        self.reduce(&prepared.measured)
    }

    /// Features of the model over the same samples.
    pub fn modelled(&self, simulated: &Simulated) -> Features {
        self.reduce(&simulated.signals)
    }

    /// The samples that belong to a bin, fingers as sum and difference.
    pub fn each(&self, signals: &[Signals], mut take: impl FnMut(usize, &Signals)) {
        for (s, bin) in signals.iter().zip(&self.bin) {
            if let Some(b) = bin {
                take(usize::from(*b), &combined(s));
            }
        }
    }

    /// Spread (largest less smallest value) of the model's channels within each bin.
    pub fn ranges(&self, simulated: &Simulated) -> Features {
        let mut low = vec![f64::INFINITY; FEATURES];
        let mut high = vec![f64::NEG_INFINITY; FEATURES];
        self.each(&simulated.signals, |b, x| {
            for k in 0..COUNT {
                let f = k * BINS + b;
                low[f] = low[f].min(x[k]);
                high[f] = high[f].max(x[k]);
            }
        });
        let mut out: Features =
            low.iter().zip(&high).map(|(l, h)| if h >= l { h - l } else { 0.0 }).collect();
        for k in 0..COUNT {
            out[k * BINS + PEAK] = (1..=4).map(|b| out[k * BINS + b]).fold(0.0, f64::max);
        }
        out
    }

    /// Largest departure of each force and torque beyond its mean at the beginning of the
    /// sliding path.
    fn peaks(&self, signals: &[Signals], out: &mut Features) {
        let mut most = [f64::NAN; COUNT];
        for i in self.peak.clone() {
            let (Some(s), Some(seen)) = (signals.get(i), self.seen.get(i)) else { continue };
            let x = combined(s);
            for k in (6..COUNT).filter(|k| seen >> k & 1 == 1) {
                let level = out[k * BINS + 5];
                // Beyond the level, as seen from the rest before: an overshoot.
                let side = (level - out[k * BINS]).signum();
                let d = side * (x[k] - level);
                if !(most[k] >= d) {
                    most[k] = d;
                }
            }
        }
        for k in 6..COUNT {
            let side = (out[k * BINS + 5] - out[k * BINS]).signum();
            out[k * BINS + PEAK] = side * most[k];
        }
    }

    /// Features of any signals over the same samples.
    pub fn reduce(&self, signals: &[Signals]) -> Features {
        let mut sum = vec![0.0; FEATURES];
        let mut count = vec![0.0; FEATURES];
        let mut first = [f64::NAN; 6];
        for ((s, bin), seen) in signals.iter().zip(&self.bin).zip(&self.seen) {
            let x = combined(s);
            for k in 0..6 {
                if first[k].is_nan() && seen >> k & 1 == 1 {
                    first[k] = x[k];
                }
            }
            let Some(b) = bin else { continue };
            for (k, x) in x.iter().enumerate() {
                if seen >> k & 1 == 1 {
                    sum[k * BINS + usize::from(*b)] += x;
                    count[k * BINS + usize::from(*b)] += 1.0;
                }
            }
        }
        let mut out: Features =
            sum.iter().zip(&count).map(|(s, n)| if *n > 0.0 { s / n } else { f64::NAN }).collect();
        for k in 0..6 {
            let rest = out[k * BINS];
            let origin = if rest.is_finite() { rest } else { first[k] };
            for f in &mut out[k * BINS..(k + 1) * BINS] {
                *f -= origin;
            }
            // Zero by definition: it says nothing.
            out[k * BINS] = f64::NAN;
        }
        self.peaks(signals, &mut out);
        out
    }
}

/// What the channel of a feature measures.
pub fn quantity(feature: usize) -> Quantity {
    channels::quantity(feature / BINS)
}
