//! What was chosen, not derived, on the way from sampled poses to a drive: each with its unit, why it has this value,
//! and what happens if it is doubled. They belong to poses within 30 micrometres at 250 Hz.

use crate::tuning::tuned;

tuned! {
    /// The table `track` of a [`Tuning`](crate::predictor::Tuning).
    pub struct Params<R> {
        /// A pose within this of the pads' own is one of an object flush between them, measured with noise, m: far beyond
        /// what motion capture errs by, far below what hands err by. Doubled: objects 2 mm off are drawn into the middle.
        flush_m: R = R::of(1.0e-3), 0.0 to 0.1;
        /// The same of its direction, rad. Doubled: objects that lie askew by 20 mrad are turned flush.
        flush_rad: R = R::of(0.01), 0.0 to 1.0;
        /// Noise of measured paths.
        path: PathParams<R> = PathParams::default();
        /// The gripper's measured acceleration.
        acceleration: AccelerationParams<R> = AccelerationParams::default();
        /// An object that settles on what carries it.
        settling: SettlingParams<R> = SettlingParams::default();
    }
}

tuned! {
    /// Of a path freed from noise.
    pub struct PathParams<R> {
        /// Noise below which a path passes unchanged, m: that of a robot's encoders. Doubled: good cameras are not filtered.
        quiet_m: R = R::of(2.0e-6), 0.0 to 0.01;
        /// Distance from the tracked path that is a jump and no noise, m. Doubled: jumps of a millimetre are smoothed over 20 ms.
        jump_m: R = R::of(1.0e-3), 1e-6 to 1.0;
        /// Share with which a sample enters the mean noise: 0.13 s. Doubled: in half of it.
        noise_share: R = R::of(0.03), 1e-4 to 1.0;
        /// How much more than the noise so far one sample counts, in squares. Doubled: starts and stops count as noise.
        noise_most: R = R::of(9.0), 1.0 to 1000.0;
        /// Gains of position and velocity about a planned motion: what departs from a plan does so slowly. Doubled: 1.4 times the
        /// noise, half the lag.
        planned_gains: [R; 2] = [R::of(0.05), R::of(0.0015)], 0.0 to 1.0;
        /// The same without a plan. Doubled: 1.4 times the noise, 0.4 of the lag while the speed changes.
        free_gains: [R; 2] = [R::of(0.2), R::of(0.02)], 0.0 to 1.0;
    }
}

tuned! {
    /// Of the gripper's measured acceleration.
    pub struct AccelerationParams<R> {
        /// Acceleration that moves the load by more than friction's doubt, m/s2: 4 % of gravity. Doubled: slow moves end
        /// trends later.
        least_m_s2: R = R::of(0.4), 0.0 to 100.0;
        /// Standard deviations of the poses' noise that it must stand out by. Doubled: the same with bad cameras.
        sigmas: R = R::of(5.0), 0.0 to 100.0;
    }
}

tuned! {
    /// Of an object that settles.
    pub struct SettlingParams<R> {
        /// Steps until it has settled: 48 ms. Doubled: the first prediction comes later.
        steps: u8 = 12, 1.0 to 250.0;
        /// A pusher closer than this at the start touches the object, m: the noise of a pose. Doubled: objects that hang free
        /// begin with their weight on the pusher.
        touching_m: R = R::of(5.0e-5), 0.0 to 0.01;
        /// What lies on something settles by no more than poses err, m: farther, it would fall or topple from what it touches,
        /// and hangs in the grasp. Doubled: objects that hang tilt before the first sample.
        settled_m: R = R::of(1.5e-4), 0.0 to 0.01;
        /// The same of its direction, rad. Doubled: objects that hang may turn by 6 mrad before the first sample.
        settled_rad: R = R::of(3.0e-3), 0.0 to 0.5;
    }
}
