//! What was chosen, not derived, on the way from sampled poses to a drive: each with its unit, why it has this value,
//! and what happens if it is doubled. They belong to poses within 30 micrometres at 250 Hz.

use crate::real::Real;

/// Set with [`Predictor::with_track`](crate::predictor::Predictor::with_track).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params<R: Real> {
    /// A pose within this of the pads' own is one of an object flush between them, measured with noise, m: far beyond
    /// what motion capture errs by, far below what a hand would place. Doubled: objects 2 mm off are drawn into the middle.
    pub flush_m: R,
    /// The same of its direction, rad.
    pub flush_rad: R,
    /// Noise of measured paths.
    pub path: PathParams<R>,
    /// The gripper's measured acceleration.
    pub acceleration: AccelerationParams<R>,
    /// An object that settles on what carries it.
    pub settling: SettlingParams<R>,
}

impl<R: Real> Default for Params<R> {
    fn default() -> Self {
        Self {
            flush_m: R::of(1.0e-3),
            flush_rad: R::of(0.01),
            path: PathParams::default(),
            acceleration: AccelerationParams::default(),
            settling: SettlingParams::default(),
        }
    }
}

/// Of a path freed from noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathParams<R: Real> {
    /// Noise below which a path passes unchanged, m: that of a robot's encoders. Doubled: good cameras are not filtered.
    pub quiet_m: R,
    /// Distance from the tracked path that is a jump and no noise, m. Doubled: jumps of a millimetre are smoothed over 20 ms.
    pub jump_m: R,
    /// Share with which a sample enters the mean noise: 0.13 s. Doubled: in half of it.
    pub noise_share: R,
    /// How much more than the noise so far one sample counts, in squares. Doubled: starts and stops count as noise.
    pub noise_most: R,
    /// Gains of place and velocity about a planned motion: what departs from a plan does so slowly. Doubled: 1.4 times the
    /// noise, half the lag.
    pub planned_gains: [R; 2],
    /// The same without a plan.
    pub free_gains: [R; 2],
}

impl<R: Real> Default for PathParams<R> {
    fn default() -> Self {
        Self {
            quiet_m: R::of(2.0e-6),
            jump_m: R::of(1.0e-3),
            noise_share: R::of(0.03),
            noise_most: R::of(9.0),
            planned_gains: [R::of(0.05), R::of(0.0015)],
            free_gains: [R::of(0.2), R::of(0.02)],
        }
    }
}

/// Of the gripper's measured acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelerationParams<R: Real> {
    /// Acceleration that moves the load by more than friction's doubt, m/s2: 4 % of gravity. Doubled: slow moves end
    /// trends later.
    pub least_m_s2: R,
    /// Standard deviations of the poses' noise that it must stand out by. Doubled: the same with bad cameras.
    pub sigmas: R,
}

impl<R: Real> Default for AccelerationParams<R> {
    fn default() -> Self {
        Self { least_m_s2: R::of(0.4), sigmas: R::of(5.0) }
    }
}

/// Of an object that settles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SettlingParams<R: Real> {
    /// Steps until it has settled: 48 ms. Doubled: the first prediction comes later.
    pub steps: u8,
    /// A pusher closer than this at the start touches the object, m: the noise of a pose. Doubled: objects that hang free
    /// begin with their weight on the pusher.
    pub touching_m: R,
    /// What lies on something settles by no more than poses err, m: farther, it would fall or topple from what it touches,
    /// and hangs in the grasp. Doubled: objects that hang tilt before the first sample.
    pub settled_m: R,
    /// The same of its direction, rad.
    pub settled_rad: R,
}

impl<R: Real> Default for SettlingParams<R> {
    fn default() -> Self {
        Self { steps: 12, touching_m: R::of(5.0e-5), settled_m: R::of(1.5e-4), settled_rad: R::of(3.0e-3) }
    }
}
