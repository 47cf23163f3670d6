//! What the data of a diagnosis cannot show, in words.

use crate::diagnose::verdict::FEWEST_CONDITIONS;
use crate::evidence::overhang::overhang_m;
use crate::fit::campaign::{Campaign, Run};
use crate::fit::problem::Problem;

/// Where pads reach over the edges of the faces that they press.
fn overhanging(campaign: &Campaign) -> Option<String> {
    let radius_m = 0.5 * campaign.description.fingers.as_ref()?.diameter_m?;
    let over = campaign.runs.iter().filter(|r| r.over_edges_m.is_some());
    let over: Vec<(f64, &Run)> = over.filter_map(|r| Some((overhang_m(&r.prepared)?, r))).collect();
    let (most_m, worst) = over.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(format!(
        "in {} of {} trials a finger's pad of {:.0} mm reaches over the edge of the object's face, by {:.1} mm at most (trial \
         {}): what hangs over bears nothing, which the model does not have; what that does to a finger's torques is not relied on",
        over.len(),
        campaign.runs.len(),
        2e3 * radius_m,
        1e3 * most_m,
        worst.info.trial
    ))
}

/// What the data cannot show.
pub fn limits(problem: &Problem, invisible: &[&'static str]) -> Vec<String> {
    let campaign = problem.campaign;
    let mut out = Vec::new();
    if !campaign.assumed.is_empty() {
        out.push(format!(
            "sensor uncertainty not stated in dataset.toml; taken: {}. What lies within that is not named",
            campaign.assumed.join("; ")
        ));
    }
    if campaign.conditions < FEWEST_CONDITIONS {
        out.push(format!(
            "only {} different condition(s): an effect cannot be separated from a wrong friction coefficient; at least {} conditions are needed",
            campaign.conditions,
            FEWEST_CONDITIONS
        ));
    }
    if problem.noise.of_misfit.is_some() {
        out.push(
            "no repetitions, and the object's pose is known now and then only: noise is taken from what the model leaves, \
             the frames of object and pusher from where they touch; run spreads are those of the stated sensors"
                .into(),
        );
    } else if problem.noise.freedom == 0 {
        out.push(
            "no repetitions: noise is assumed from the stated sensor noise and 2 % of friction, and small effects cannot be separated from run-to-run variation; repeat at least some conditions"
                .into(),
        );
    } else if problem.noise.freedom < 6 {
        out.push(format!(
            "only {} degrees of freedom from repetitions: the run spread is uncertain",
            problem.noise.freedom
        ));
    }
    let seen = |from: usize| {
        campaign.runs.iter().any(|r| {
            r.measured[from * crate::fit::phases::BINS..(from + 6) * crate::fit::phases::BINS]
                .iter()
                .any(|x| x.is_finite())
        })
    };
    for (from, what) in [(0, "the object's pose"), (6, "the fingers' forces"), (18, "the pusher's forces")] {
        if !seen(from) {
            out.push(format!("{what}: not measured (or only where it has no information); effects that are visible only there cannot be found"));
        }
    }
    out.extend(overhanging(campaign));
    if !invisible.is_empty() {
        out.push(format!("not visible in these data: {}", invisible.join(", ")));
    }
    out
}
