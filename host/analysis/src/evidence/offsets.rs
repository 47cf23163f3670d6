//! Constant errors of the sensors, from what they show before contact: one rule for every command.
//!
//! Before anything touches the object the fingers carry its weight and the pusher nothing. The mean
//! of measured less expected over those samples (clear of the contact, see
//! [`crate::evidence::contact::clear_of`]) is the offset of a force or torque channel in that trial. What is expected
//! is the weight alone ([`at_rest`]) or what a model shows there. Of the fingers only the sum is
//! determined: a squeeze from the grasping stays between them. [`over_trials`] gives the offsets of a
//! data set, which a trial that was touched at rest does not move: medians.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::Serialize;

use crate::channels::{COUNT, Quantity, Signals, quantity};
use crate::evidence::balance;
use crate::evidence::stages::Stages;
use crate::evidence::statistics::median;
use stickslip_data::{Description, Sample, Trial};

/// Fewer samples before contact than this give no offset.
pub const FEWEST_SAMPLES: usize = 5;

/// Mean of measured less expected, force and torque channels; NaN in the others and where fewer than
/// [`FEWEST_SAMPLES`] are known.
#[must_use]
pub fn of_samples<'a>(samples: impl Iterator<Item = (&'a Signals, &'a Signals)>) -> Signals {
    let mut sums = [(0.0, 0usize); COUNT];
    for (measured, expected) in samples {
        for (sum, (x, y)) in sums.iter_mut().zip(measured.iter().zip(expected)) {
            if (x - y).is_finite() {
                *sum = (sum.0 + x - y, sum.1 + 1);
            }
        }
    }
    std::array::from_fn(|k| match (quantity(k), sums[k]) {
        (Quantity::Force | Quantity::Torque, (sum, n)) if n >= FEWEST_SAMPLES => sum / n as f64,
        _ => f64::NAN,
    })
}

/// Sum of both fingers' offsets: force, torque, gripper axes.
#[must_use]
pub fn fingers_sum(offset: &Signals) -> [f64; 6] {
    std::array::from_fn(|k| offset[6 + k] + offset[12 + k])
}

/// Median over the trials of each channel, over those in which it is known; NaN where in none.
#[must_use]
pub fn over_trials(offsets: &[Signals]) -> Signals {
    let known = |k: usize| offsets.iter().map(move |o| o[k]).filter(|x| x.is_finite());
    std::array::from_fn(|k| median(known(k)).unwrap_or(f64::NAN))
}

/// Offsets as the weight alone shows them.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct AtRest {
    /// Of the sum of both fingers' forces, gripper axes: the balance against the weight determines
    /// only the sum.
    pub fingers_sum_n: [f64; 3],
    /// Of the pusher's force, world axes; `None` where it is not measured.
    pub pusher_n: Option<[f64; 3]>,
    /// Of the pusher's torque.
    pub pusher_nm: Option<[f64; 3]>,
}

/// Offsets from the phase before contact, in its slow part: there the fingers carry the weight alone,
/// and the pusher nothing. `None` where the trial has no such phase (nothing measured before contact,
/// contact not found, an object that stands on a table).
#[must_use]
pub fn at_rest(description: &Description, trial: &Trial, stages: &Stages) -> Option<AtRest> {
    let primitive = &trial.info.primitive;
    let unmeasured = description.pushers.contains_key(primitive) && !balance::pusher_measured(trial);
    if unmeasured || description.supports.contains_key(primitive) {
        return None;
    }
    let weight = balance::weight_n(description, trial);
    let slow = balance::slow(&trial.samples, balance::mass_kg(description, trial), weight.norm());
    let rows: Vec<(Signals, Signals)> = stages
        .rest()
        .filter(|at| slow.get(*at).copied().unwrap_or(false))
        .filter_map(|at| row(trial.samples.get(at)?, &weight))
        .collect();
    let offset = of_samples(rows.iter().map(|(measured, expected)| (measured, expected)));
    let three = |from: usize| {
        let values = [offset[from], offset[from + 1], offset[from + 2]];
        values.iter().all(|x| x.is_finite()).then_some(values)
    };
    let [x, y, z, ..] = fingers_sum(&offset);
    let fingers_sum_n = Some([x, y, z]).filter(|sum| sum.iter().all(|x| x.is_finite()))?;
    Some(AtRest { fingers_sum_n, pusher_n: three(18), pusher_nm: three(21) })
}

/// What is measured in a sample, and what the weight alone would show there.
fn row(sample: &Sample, weight: &Vector3<f64>) -> Option<(Signals, Signals)> {
    let each = balance::gripper(sample)?.inverse() * (-0.5 * weight);
    let origin = stickslip_shared::track::Pose::identity();
    let measured = crate::channels::measured(sample, &origin, &origin.rotation);
    let mut expected = [f64::NAN; COUNT];
    for (k, x) in each.iter().enumerate() {
        (expected[6 + k], expected[12 + k]) = (*x, *x);
    }
    expected[18..24].fill(0.0);
    Some((measured, expected))
}
