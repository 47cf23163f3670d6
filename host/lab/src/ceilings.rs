//! What any detector could see of a slip in the object's pose: a limit of the data, beside what the predictor sees.
//!
//! An oracle knows when a slip begins and how the object then moves, and asks whether the noisy poses up to `within_s`
//! after the beginning show that motion: a matched filter. With white noise of standard deviation `sigma` on each axis it
//! sees the true departure `s(t)` as `d^2 = sum |s|^2 / sigma^2`, and finds it with the probability `Phi(d - h)`
//! (Neyman and Pearson 1933). The bar `h` allows a given rate of false alarms in as many independent tests as spans fit
//! into an hour. What sees less knows less: a detector must find out the beginning and the form itself. The true
//! departure counts from the beginning of the gross slip ([`From::Onset`]), or from 0.1 s before, with what sheared and
//! slid until then ([`From::Before`]): the forces may explain a part of that. Delays and colour of the sensors are left out.

use anyhow::{Context, ensure};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};
use std::path::Path;

use stickslip_analysis::score::warnings::{SLIPPED_M, TrialKey};

/// From where on the motion counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum From {
    /// The beginning of the gross slip.
    Onset,
    /// As long before as the key tells.
    Before,
}

/// How the object's pose is measured in the grasp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Noise on each axis, standard deviation, m.
    pub sigma_m: f64,
    /// Independent poses over samples.
    pub share: f64,
}

#[derive(Deserialize)]
struct Told {
    reality: Rig,
}

#[derive(Deserialize)]
struct Rig {
    sensors: Sensors,
}

#[derive(Deserialize)]
struct Sensors {
    rate_hz: f64,
    position_noise_m: f64,
    gripper_noisy: bool,
    pose_rate: Rate,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum Rate {
    Full,
    Interpolated(f64),
    Gaps(f64),
}

impl Sight {
    /// Of the rig that a key tells of.
    ///
    /// # Errors
    /// Where the key cannot be read, or does not tell the sensors.
    pub fn told(key: &Path) -> anyhow::Result<Self> {
        let text =
            std::fs::read(key).with_context(|| format!("{}: cannot be read; state --key", key.display()))?;
        let told: Told = serde_json::from_slice(&text).with_context(|| {
            format!("{}: does not state the sensors; take a set of stickslip-second-rig draw", key.display())
        })?;
        let s = told.reality.sensors;
        let hz = match s.pose_rate {
            Rate::Full => s.rate_hz,
            Rate::Interpolated(hz) | Rate::Gaps(hz) => hz,
        };
        // Gripper and object are each measured.
        let poses = if s.gripper_noisy { 2.0 } else { 1.0 };
        ensure!(s.position_noise_m > 0.0, "{}: poses without noise have no limit", key.display());
        Ok(Self { sigma_m: s.position_noise_m * f64::sqrt(poses), share: f64::min(hz / s.rate_hz, 1.0) })
    }

    /// How far the motion about a slip stands out of the noise `within_s` after its beginning, in standard deviations;
    /// `None` where the key does not tell it.
    #[must_use]
    pub fn stands_out(&self, truth: &TrialKey, within_s: f64, from: From) -> Option<f64> {
        let judged = truth.episodes.iter().position(|[.., m]| *m > SLIPPED_M)?;
        let [begins_s, ..] = *truth.episodes.get(judged)?;
        let path = truth.about_slips.get(judged)?;
        let [_, x0, z0] = match from {
            From::Onset => *path.iter().rfind(|[t, ..]| *t <= begins_s)?,
            From::Before => *path.first()?,
        };
        let counts = |t: f64| t <= begins_s + within_s && (from == From::Before || t > begins_s);
        let squares =
            path.iter().filter(|[t, ..]| counts(*t)).map(|[_, x, z]| (x - x0).powi(2) + (z - z0).powi(2));
        Some((self.share * squares.sum::<f64>()).sqrt() / self.sigma_m)
    }
}

/// Probability that an oracle finds what stands out by `sigmas`, with `per_hour` false alarms an hour in tests of `within_s`.
#[must_use]
pub fn found(sigmas: f64, within_s: f64, per_hour: f64) -> f64 {
    let tests = 3600.0 / within_s;
    Normal::new(0.0, 1.0)
        .map_or(f64::NAN, |n| n.cdf(sigmas - n.inverse_cdf(1.0 - (per_hour / tests).min(0.5))))
}
