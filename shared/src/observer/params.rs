//! What was chosen, not derived, in the observer: each with its unit, why it has this value, and what happens if it is
//! doubled. Those that count samples or are times belong to 250 Hz; those in metres and newtons to poses within
//! 30 micrometres and forces within 0.02 N.

use super::bearing::BearingParams;
use super::friction::FrictionParams;
use super::grip::GripParams;
use super::load::LoadParams;
use super::motion::MotionParams;
use super::plateau::PlateauParams;
use super::shear::ShearParams;
use super::trend::{LONG, TrendParams};
use crate::real::Real;

/// Set with [`Predictor::with_observer`](crate::predictor::Predictor::with_observer).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params<R: Real> {
    /// Samples of the tare: 0.13 s at 250 Hz. Doubled: constant errors are taken off with 0.7 of the noise, 0.13 s later.
    pub tare_samples: u8,
    /// Largest constant error of a force that is taken off, N. Doubled: a load that is there at the start is.
    pub tare_n: R,
    /// The same of a torque, N m.
    pub tare_nm: R,
    /// Smoothing of the ratio that is shown: three samples. Doubled: its noise is 1.6 times as large.
    pub smoothing: R,
    /// Share of the estimated limit that counts as slip there. Above 1, ratios that are clipped at the limit are no slip.
    pub slipping_share: R,
    /// Share of the least limit from which less motion is slip. Above 1, sudden slips are seen some 4 ms later.
    pub at_limit_share: R,
    /// Below this share of the limit a trend is no threat yet, and mostly that of a lift-off. Above 1, none is.
    pub threat_share: R,
    /// A trend that reaches the limit within this is a threat, s. Doubled: more ramps that stop short are.
    pub threat_s: R,
    /// It has ended where the ratio is below this share of what it was then. Above 1, every threat ends at once.
    pub ended_share: R,
    /// First guess of the ratio's noise, standard deviation. Doubled: slopes in the first second are proven later.
    pub noise: R,
    /// Fingers that let the object fall for so many samples, which the pose does not show, contradict it: 24 ms, in which half of
    /// gravity moves it by 1.4 mm. Doubled: poses that are late by less than 60 ms are not found out.
    pub unseen_samples: u8,
    /// Noise of the load.
    pub load: LoadParams<R>,
    /// Friction, learnt.
    pub friction: FrictionParams<R>,
    /// Motion by the pose.
    pub motion: MotionParams<R>,
    /// Elastic shear of the pads.
    pub shear: ShearParams<R>,
    /// Trends of 0.12 s.
    pub trend: TrendParams<R>,
    /// Slow ramps: 0.6 s.
    pub ramp: TrendParams<R>,
    /// Clipped loads.
    pub plateau: PlateauParams<R>,
    /// Fingers that no longer bear the weight.
    pub bearing: BearingParams<R>,
    /// The grip command.
    pub grip: GripParams<R>,
}

impl<R: Real> Default for Params<R> {
    fn default() -> Self {
        Self {
            tare_samples: 32,
            tare_n: R::of(0.4),
            tare_nm: R::of(0.005),
            smoothing: R::of(0.3),
            slipping_share: R::of(0.98),
            at_limit_share: R::of(0.9),
            threat_share: R::of(0.5),
            threat_s: R::of(0.25),
            ended_share: R::of(0.97),
            noise: R::of(0.005),
            unseen_samples: 6,
            load: LoadParams::default(),
            friction: FrictionParams::default(),
            motion: MotionParams::default(),
            shear: ShearParams::default(),
            trend: TrendParams::default(),
            ramp: TrendParams { per_block: LONG, ..TrendParams::default() },
            plateau: PlateauParams::default(),
            bearing: BearingParams::default(),
            grip: GripParams::default(),
        }
    }
}
