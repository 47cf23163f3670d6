//! Signs: what presses does not pull, and what is carried weighs downwards.

use nalgebra::Vector3;
use stickslip_data::{Description, Sample, Trial};

use super::breach::{Breach, Cause, norm, short, values};
use crate::channels;
use crate::evidence::balance::{NotChecked, StageBalance};
use crate::evidence::stages::Stage;
use crate::evidence::statistics::quantile;

type Balances = Result<Vec<StageBalance>, NotChecked>;

/// Measured forces over the weight that they must carry: 1 where they balance it.
struct Carried {
    /// Along gravity.
    multiple: f64,
    /// What the sensors may be off by, over the weight.
    unsure: f64,
    /// Across gravity, N.
    across_n: f64,
    weight_n: f64,
    limit_n: f64,
}

/// From the stage before contact, where the fingers carry the weight alone, or that of most samples.
fn carried(description: &Description, trial: &Trial, balance: &Balances) -> Option<Carried> {
    let object = description.objects.iter().find(|object| object.id == trial.info.object)?;
    let weight = Vector3::from(description.gravity_m_s2) * object.mass_kg;
    let weight_n = weight.norm();
    let stage = balance.as_ref().ok()?.iter().max_by_key(|s| (s.stage == Stage::BeforeContact, s.samples))?;
    if !(weight_n > 0.0) || !stage.fails() {
        return None;
    }
    let down = weight / weight_n;
    let forces = Vector3::from(stage.sum_n) - weight;
    let along = forces.dot(&down);
    let limit_n = stage.bound_n + 3.0 * stage.standard_error_n;
    Some(Carried {
        multiple: -along / weight_n,
        unsure: limit_n / weight_n,
        across_n: (forces - down * along).norm(),
        weight_n,
        limit_n,
    })
}

impl Carried {
    /// All forces with the other sign would balance. It is known not to balance as it stands, and
    /// two weights are told from none where the sensors may be off by less than one.
    fn turned(&self) -> bool {
        self.unsure < 0.9 && (self.multiple + 1.0).abs() < 0.2 + self.unsure
    }
}

/// Finger 1 presses towards -Y, finger 2 towards +Y: a pad cannot pull.
pub fn fingers(trial: &Trial, balance: &Balances, description: &Description) -> Option<Breach> {
    let normal = |finger: usize| quantile(values(trial, |s| s.finger[finger].map(|w| w.force_n[1])), 0.5);
    let sensor = &description.sensors.finger;
    let clear = sensor.force_uncertainty_n.max(0.05) + 3.0 * sensor.force_noise_n;
    let wrong = [normal(0).filter(|f| *f > clear), normal(1).filter(|f| *f < -clear)];
    let text = |what: &str, likely: &str| {
        format!("{what}, but finger 1 is at +Y and can only press towards -Y, finger 2 towards +Y; {likely}")
    };
    let (cause, columns, text) = match wrong {
        [None, None] => return None,
        [Some(a), Some(b)] => {
            let what = format!("finger1_fy_n is {} N and finger2_fy_n {} N", short(a), short(b));
            let pulls = pusher_pulls(trial).is_some();
            let turned = carried(description, trial, balance).map(|c| c.turned());
            let (cause, likely) = match (pulls, turned) {
                (true, _) | (_, Some(true)) => (
                    Cause::SignsTurned,
                    "the wrenches are those on the fingers? write those on the object: turn all signs",
                ),
                _ if balance.is_ok() => (
                    Cause::FingersSwapped,
                    "finger 1 and finger 2 exchanged, or the gripper's axes turned by half a turn",
                ),
                _ => (
                    Cause::FingersSwapped,
                    "finger 1 and finger 2 exchanged, or all signs turned (wrenches on the fingers in place of \
                     those on the object)",
                ),
            };
            (cause, "columns finger{1,2}_fy_n", text(&what, likely))
        }
        [Some(a), None] => {
            let what = format!("finger1_fy_n is {} N", short(a));
            (
                Cause::SignsTurned,
                "column finger1_fy_n",
                text(&what, "the sign or axes of finger 1 alone are turned?"),
            )
        }
        [None, Some(b)] => {
            let what = format!("finger2_fy_n is {} N", short(b));
            (
                Cause::SignsTurned,
                "column finger2_fy_n",
                text(&what, "the sign or axes of finger 2 alone are turned?"),
            )
        }
    };
    Some(Breach { cause, columns: columns.to_owned(), text })
}

/// Force along the pusher's +X, median of the half of the samples in which it is largest;
/// `None` where it presses, or where it is small.
fn pusher_pulls(trial: &Trial) -> Option<f64> {
    let force = |s: &Sample| {
        let force = s.pusher_wrench?.force_n;
        force.iter().all(|f| f.is_finite()).then_some(force)
    };
    let largest = quantile(values(trial, |s| force(s).map(norm)), 0.95)?;
    let along = |s: &Sample| {
        let pose = s.pusher.or(trial.info.pusher)?;
        let force = force(s).filter(|force| norm(*force) > 0.5 * largest)?;
        Some((channels::pose(&pose).rotation.inverse() * Vector3::from(force)).x)
    };
    quantile(values(trial, along), 0.5).filter(|along| *along < -0.3 * largest && largest > 0.5)
}

/// The pusher presses along its +X, into the object.
pub fn pusher(trial: &Trial) -> Option<Breach> {
    let along = pusher_pulls(trial)?;
    let text = format!(
        "the pusher pulls with {} N along its +X, but it can only press into the object; the wrench is that on the \
         pusher? write that on the object: turn its sign. Or the pusher's axes are turned",
        short(-along)
    );
    Some(Breach { cause: Cause::SignsTurned, columns: "columns pusher_f{x,y,z}_n".to_owned(), text })
}

/// The forces carry the weight once: not minus once (signs), not a power of ten of it (units).
pub fn weight(description: &Description, trial: &Trial, balance: &Balances) -> Option<Breach> {
    let carried = carried(description, trial, balance)?;
    let Carried { multiple, unsure, across_n, weight_n, limit_n } = carried;
    if across_n > limit_n {
        return None;
    }
    let columns = "columns finger{1,2}_f{x,y,z}_n, pusher_f{x,y,z}_n";
    if carried.turned() {
        let text = format!(
            "forces and weight sum to {} N downwards, twice the weight, in place of zero; all signs turned? write \
             the wrenches on the object",
            short((1.0 - multiple) * weight_n)
        );
        return Some(Breach { cause: Cause::SignsTurned, columns: columns.to_owned(), text });
    }
    let units = [
        (1e-3, "the mass in grams, or forces in kN? write kilograms and newtons"),
        (1e3, "forces in mN, or the mass in tonnes? write newtons and kilograms"),
        (1.0 / 9.80665, "forces in kgf? write newtons"),
        (9.80665, "the weight in newtons in place of the mass? write kilograms"),
    ];
    let near = |factor: f64| (multiple / factor - 1.0).abs() < 0.15 + (unsure / factor).min(0.35);
    let (_, likely) = units.into_iter().find(|(factor, _)| near(*factor))?;
    let text = format!(
        "the measured forces carry {} times the weight of {} N that mass_kg gives; {likely}",
        short(multiple),
        short(weight_n)
    );
    let columns = format!("{columns}; dataset.toml, mass_kg");
    Some(Breach { cause: Cause::MassUnit, columns, text })
}
