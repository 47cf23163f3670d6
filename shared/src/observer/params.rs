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
use crate::tuning::tuned;

tuned! {
    /// The table `observer` of a [`Tuning`](crate::predictor::Tuning).
    pub struct Params<R> {
        /// Samples of the tare: 0.13 s at 250 Hz. Doubled: constant errors are taken off with 0.7 of the noise, 0.13 s later.
        tare_samples: u8 = 32, 0.0 to 250.0;
        /// Largest constant error of a force that is taken off, N. Doubled: a load that is there at the start is.
        tare_n: R = R::of(0.4), 0.0 to 100.0;
        /// The same of a torque, N m. Doubled: the torque of a load of 0.4 N at 25 mm that is there at the start is.
        tare_nm: R = R::of(0.005), 0.0 to 10.0;
        /// So many times as much is no constant error, and the sensor is in doubt: noise may exceed the bound. Doubled: a load of
        /// 2 N that is there at the start is taken for an error of 0.4 N without a doubt.
        tare_beyond: R = R::of(3.0), 1.0 to 1000.0;
        /// Smoothing of the ratio that is shown: three samples. Doubled: its noise is 1.6 times as large.
        smoothing: R = R::of(0.3), 0.01 to 1.0;
        /// Noise of it over a sample's: 0.42 where noise is white, 0.65 where it is filtered. Doubled: ramps under noise pass for
        /// held.
        smoothed_noise: R = R::of(0.75), 0.0 to 10.0;
        /// Share of the estimated limit that counts as slip there. Above 1, ratios that are clipped at the limit are no slip.
        slipping_share: R = R::of(0.98), 0.1 to 1.5;
        /// Share of the least limit from which less motion is slip. Above 1, sudden slips are seen some 4 ms later.
        at_limit_share: R = R::of(0.9), 0.1 to 2.0;
        /// A ratio is more than what has been held where it is so many standard deviations above it. Doubled: slips without a pose
        /// at the load that was held are not seen under noise.
        held_sigmas: R = R::of(3.0), 0.0 to 100.0;
        /// The same where the pose is measured, and less motion is slip. Doubled: sudden slips at the load that was held are seen
        /// some 4 ms later.
        borne_sigmas: R = R::of(2.0), 0.0 to 100.0;
        /// Below this share of the limit a trend is no threat yet, and mostly that of a lift-off. Above 1, none is.
        threat_share: R = R::of(0.5), 0.0 to 2.0;
        /// A trend that reaches the limit within this is a threat, s. Doubled: more ramps that stop short are.
        threat_s: R = R::of(0.25), 0.0 to 5.0;
        /// It has ended where the ratio is below this share of what it was then. Above 1, every threat ends at once.
        ended_share: R = R::of(0.97), 0.0 to 2.0;
        /// First guess of the ratio's noise, standard deviation. Doubled: slopes in the first second are proven later.
        noise: R = R::of(0.005), 1e-6 to 1.0;
        /// Fingers that let the object fall for so many samples, which the pose does not show, contradict it: 24 ms, in which half of
        /// gravity moves it by 1.4 mm. Doubled: poses that are late by less than 60 ms are not found out.
        unseen_samples: u8 = 6, 1.0 to 250.0;
        /// Noise of the load.
        load: LoadParams<R> = LoadParams::default();
        /// Friction, learnt.
        friction: FrictionParams<R> = FrictionParams::default();
        /// Motion by the pose.
        motion: MotionParams<R> = MotionParams::default();
        /// Elastic shear of the pads.
        shear: ShearParams<R> = ShearParams::default();
        /// Trends of 0.12 s.
        trend: TrendParams<R> = TrendParams::default();
        /// Slow ramps: 0.6 s.
        ramp: TrendParams<R> = TrendParams { per_block: LONG, ..TrendParams::default() };
        /// Clipped loads.
        plateau: PlateauParams<R> = PlateauParams::default();
        /// Fingers that no longer bear the weight.
        bearing: BearingParams<R> = BearingParams::default();
        /// The grip command.
        grip: GripParams<R> = GripParams::default();
    }
}
