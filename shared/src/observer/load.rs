//! The coefficient that a grasp needs, without what noise adds to its length.
//!
//! It is the length of a vector: load along X and Z and torsion at its arm, over the normal force. Noise makes the length
//! of a vector longer than its own (Rice 1945), and a fingertip's torque noise over a torsion arm of some millimetres is as
//! much as the weight of a light object. So each component counts as far as its power in the last samples exceeds that
//! of its noise (the gain of Wiener's filter, `1 - v / P`). The noise is that of samples three apart, by which filtered
//! noise has lost most of its memory, and which 50 and 60 Hz do not hide from; at first, what the rest of the tare shows.

use crate::real::{Real, Vec3, clamp, max, min, sqrt};
use crate::tuning::tuned;
use crate::window::shift_in;

/// Samples whose differences are noise.
const APART: usize = 3;

tuned! {
    /// What was chosen in it.
    pub struct LoadParams<R> {
        /// Share with which a sample enters the power: five samples. Doubled: noise passes for load for moments.
        power_share: R = R::of(0.3), 0.001 to 1.0;
        /// Share with which a difference enters the noise: 0.4 s. Doubled: known, and forgotten, in half of it.
        noise_share: R = R::of(0.01), 1e-4 to 1.0;
        /// One difference counts up to so many variances: a load that changes is no noise. Doubled: knocks count as noise.
        noise_most: R = R::of(4.0), 1.0 to 1000.0;
        /// First guess of the noise, standard deviation. Doubled: light loads count less in the first samples.
        noise: R = R::of(0.005), 1e-6 to 1.0;
    }
}

/// What a sample's load needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Needed<R: Real> {
    /// Coefficient, without what noise adds.
    pub ratio: R,
    /// Noise of it, standard deviation.
    pub noise: R,
}

/// State.
#[derive(Clone, Debug)]
pub struct LoadNoise<R: Real> {
    params: LoadParams<R>,
    /// The newest first; how many there have been.
    recent: [Vec3<R>; APART],
    seen: u8,
    power: Vec3<R>,
    variance: Vec3<R>,
}

impl<R: Real> LoadNoise<R> {
    /// No load yet.
    pub fn new(params: LoadParams<R>) -> Self {
        let v = params.noise * params.noise;
        Self {
            params,
            recent: [Vec3::zeros(); APART],
            seen: 0,
            power: Vec3::zeros(),
            variance: Vec3::new(v, v, v),
        }
    }

    /// One sample: load along X and Z and torsion at its arm over the normal force. `rests`: it is of the rest before the
    /// tare, in which every difference is noise.
    pub fn needed(&mut self, q: &Vec3<R>, rests: bool) -> Needed<R> {
        let [.., before] = self.recent;
        shift_in(&mut self.recent, *q);
        let differences = self.seen.saturating_sub(APART as u8 - 1);
        self.seen = self.seen.saturating_add(1);
        let first = R::one() / R::of(f64::from(differences.max(1)));
        let (gain, most) = if rests {
            (max(first, self.params.noise_share), R::of(1e6))
        } else {
            (self.params.noise_share, self.params.noise_most)
        };
        let (mut square, mut noise) = (R::zero(), R::zero());
        let components = q.iter().zip(before.iter()).zip(self.power.iter_mut()).zip(self.variance.iter_mut());
        for (((now, before), power), variance) in components {
            if differences > 0 {
                let change = *now - *before;
                *variance += (min(change * change * R::of(0.5), *variance * most) - *variance) * gain;
            }
            let share = if differences > 0 { self.params.power_share } else { R::one() };
            *power += (*now * *now - *power) * share;
            let counts = clamp(R::one() - *variance / max(*power, R::of(1e-12)), R::zero(), R::one());
            let part = *now * counts;
            square += part * part;
            noise += part * part * *variance;
        }
        let ratio = sqrt(square);
        Needed { ratio, noise: if square > R::of(1e-9) { sqrt(noise / square) } else { R::zero() } }
    }
}
