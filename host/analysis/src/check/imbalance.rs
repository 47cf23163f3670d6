//! Forces that do not balance in most trials: what is wrong with the bench.

use super::facts::{Balance, TrialFacts};
use super::physics::{Breach, Cause, Finding};
use super::sensor_error::{Suspect, suspects};
use crate::evidence::balance::StageBalance;
use crate::evidence::statistics::median;
use stickslip_data::{Description, Warning};

/// The sensors whose turn or gain explains it, told as a warning; otherwise it is a finding.
pub(super) fn judge(
    trials: &[TrialFacts],
    balance: &Balance,
    description: &Description,
    findings: &mut Vec<Finding>,
    warnings: &mut Vec<Warning>,
) -> Vec<Suspect> {
    let Some(finding) = imbalance(trials, balance, findings) else { return Vec::new() };
    let stages: Vec<&[StageBalance]> =
        trials.iter().filter_map(|trial| trial.balance.as_deref().ok()).collect();
    let suspects = suspects(&stages, description);
    if suspects.is_empty() {
        findings.push(finding);
    } else {
        warnings.push(Warning { file: finding.file, files: 1, text: sentence(&suspects, balance) });
    }
    suspects
}

/// What the suspects are, and what to do about it.
fn sentence(suspects: &[Suspect], balance: &Balance) -> String {
    let all: Vec<String> = suspects.iter().map(ToString::to_string).collect();
    let (which, one) = match suspects {
        [_] => ("explains it", true),
        _ => ("explain it about as well", false),
    };
    let effect = suspects.first().map_or("", |best| best.effect);
    format!(
        "the measured forces and the weight do not balance in {} of {} trials; {} {which} (sums of {:.2} N become {:.2} N{}). \
         Where the sensor can be looked at, correct its axes or its gain in the mapping; otherwise go on: `diagnose` tries \
         this as {effect}",
        balance.failing,
        balance.checked,
        all.join(", or "),
        suspects.first().map_or(0.0, |best| best.sums_n[0]),
        suspects.first().map_or(0.0, |best| best.sums_n[1]),
        if one { "" } else { " by the first" },
    )
}

/// Forces that do not balance in more than half of the trials are a property of the bench, not an
/// event in some of them; said where no cause is known already.
fn imbalance(trials: &[TrialFacts], balance: &Balance, known: &[Finding]) -> Option<Finding> {
    let named = known.iter().any(|finding| !matches!(finding.cause, Cause::GripUnit | Cause::ClockOffset));
    if named || 2 * balance.failing <= balance.checked {
        return None;
    }
    // The multiple of the weight that the forces carry, where nothing but the weight is missing.
    let carried = trials.iter().filter_map(|trial| {
        let worst = trial.balance.as_ref().ok()?.iter().find(|stage| stage.fails())?;
        let weight_sq: f64 = trial.weight_n.iter().map(|w| w * w).sum();
        let along: f64 = trial.weight_n.iter().zip(worst.sum_n).map(|(w, s)| w * s).sum();
        let share = along / weight_sq;
        let across: f64 = trial.weight_n.iter().zip(worst.sum_n).map(|(w, s)| (s - share * w).powi(2)).sum();
        (weight_sq > 0.0 && across.sqrt() <= worst.bound_n + 3.0 * worst.standard_error_n)
            .then_some(1.0 - share)
    });
    let carried: Vec<f64> = carried.collect();
    let likely = match median(carried.iter().copied()) {
        Some(multiple) if 2 * carried.len() > balance.failing && multiple > 0.0 => format!(
            "what is left over is along gravity: a wrong mass (the forces carry {multiple:.2} times mass_kg), a \
             vertical force that is not measured (cable, table), or a sensor's offset"
        ),
        _ => "a sensor's offset or gain beyond what [sensors] states, a force that is not measured (cable, table, \
              stop), or wrong axes of a sensor"
            .to_owned(),
    };
    let (first, worst) = balance.worst.first()?;
    let file = trials.iter().find(|trial| trial.name == *first).map(|trial| trial.file.clone())?;
    let [x, y, z] = worst.sum_n;
    let breach = Breach {
        cause: Cause::Balance,
        columns: "columns finger{1,2}_f*, pusher_f*".to_owned(),
        text: format!(
            "the measured forces and the weight sum to [{x:.3}, {y:.3}, {z:.3}] N in the stage '{}', sensors may be off \
             by {:.3} N; {likely}",
            worst.stage.label(),
            worst.bound_n
        ),
    };
    Some(Finding {
        cause: breach.cause,
        file,
        columns: breach.columns,
        text: breach.text,
        trials: balance.failing,
        of: trials.len(),
    })
}
