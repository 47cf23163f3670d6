//! Pads that reach over an edge: what hangs over bears nothing.
//!
//! A pad that is fixed in a stiff jaw then presses on the rest of it, about another point than its middle, and its finger's
//! sensor shows the moment. How much of that a real pad does (one that turns about its middle does nothing of it) the model
//! does not know and these data need not tell: for each finger one direction of the features' covariance, the moment of an
//! even pressure on what lies on the face. Faces are parallel, so that the moments of both fingers cancel on the object and
//! do not move it.

use nalgebra::Vector3;

use crate::fit::campaign::Run;
use crate::fit::features::Features;
use crate::run::simulate::Simulated;

/// First channel of each finger's force and torque.
const FINGERS: [[usize; 2]; 2] = [[6, 9], [12, 15]];

/// A direction of one standard deviation for each finger, of the features `here` of the model's signals `simulated` along `run`;
/// none where both pads lie on their faces, or as good as.
#[must_use]
pub fn directions(run: &Run, simulated: &Simulated, here: &Features) -> Vec<Features> {
    let Some(shifts_m) = &run.over_edges_m else { return Vec::new() };
    let of_finger = |finger: usize| {
        let [force, torque] = FINGERS[finger];
        let mut with = simulated.signals.clone();
        for (row, shift_m) in with.iter_mut().zip(shifts_m) {
            let moment_nm = shift_m[finger].cross(&Vector3::new(0.0, row[force + 1], 0.0));
            for (to, more) in row[torque..torque + 3].iter_mut().zip(moment_nm.iter()) {
                *to += more;
            }
        }
        run.bins.reduce(&with).iter().zip(here).map(|(w, h)| w - h).collect()
    };
    (0..2).map(of_finger).collect()
}
