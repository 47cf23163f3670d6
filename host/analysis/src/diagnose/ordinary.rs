//! What any rig has, and is no finding: pads that give way a little, and press off their middle by as little as they are mounted to; a
//! pusher that is mounted as square as it was set up.
//!
//! It stays in the model beside what is found, so that nothing else has to stand in for it, and is not named.

use stickslip_shared::effects::contact_compliance::tangential_m_n;
use stickslip_shared::effects::{Role, find as find_effect};
use stickslip_shared::model::FingerContact;

use crate::diagnose::select::Held;
use crate::fit::campaign::Run;
use crate::fit::problem::Problem;
use crate::fit::{self, Free};

/// What any rig has, in a fit.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ordinary {
    /// Pads that give way a little.
    pub pads: bool,
    /// A pusher that is not quite square, or pads that press not quite in their middle.
    pub mounting: bool,
}

/// Whether effect `id` of the fit `held` is no more than any rig has of it.
pub fn is_ordinary_in(problem: &Problem, held: &Held, id: &str) -> bool {
    match find_effect(id).map(|info| info.role) {
        Some(Role::Compliance { normal_m }) => gives_way_less(problem, held, normal_m),
        Some(role) => mounted_within(problem, role).is_some_and(|most| is_within(problem, held, id, most)),
        None => false,
    }
}

/// How far off something may be set up, rad or m, where that is what an effect is about.
fn mounted_within(problem: &Problem, role: Role) -> Option<f64> {
    match role {
        Role::Mounting { square_rad } => Some(square_rad),
        Role::Pressing { of_diameter } => {
            let diameter = |run: &Run| match run.prepared.scene.fingers {
                Some(FingerContact::Disc { diameter_m }) => Some(diameter_m),
                _ => None,
            };
            let least_m = problem.campaign.runs.iter().filter_map(diameter).reduce(f64::min)?;
            Some(of_diameter * least_m)
        }
        _ => None,
    }
}

/// What stands in `held` because nothing is mounted exactly, in words, one for each effect; none where it is a finding.
pub fn mounted(problem: &Problem, held: &Held) -> Vec<String> {
    let given = |f: &Free| {
        let Free::Effect { effect, .. } = f else { return None };
        Some((*effect, find_effect(effect)?.role))
    };
    let mut out: Vec<(&str, String)> = Vec::new();
    for (id, role) in held.free.iter().filter_map(given) {
        let Some(most) = mounted_within(problem, role) else { continue };
        if out.iter().any(|(known, _)| *known == id) || !is_within(problem, held, id, most) {
            continue;
        }
        let of_it = |f: &&Free| matches!(f, Free::Effect { effect, .. } if *effect == id);
        let sizes = held.free.iter().filter(of_it).map(|f| f.get(&held.solution.model).abs());
        let [here, most] = [sizes.fold(0.0, f64::max), most].map(|x| 1e3 * x);
        let (unit, may) = match role {
            Role::Pressing { .. } => ("mm", format!("pads may press off their middle by {most:.2} mm")),
            _ => ("mrad", format!("a pusher may be off square by {most:.1} mrad")),
        };
        out.push((id, format!(
            "{id} of up to {here:.2} {unit} stands in the fit and is no finding: {may}, and by what the data leave open"
        )));
    }
    out.into_iter().map(|(_, words)| words).collect()
}

/// Whether none of its parameters is larger than `most` beyond what the data leave open.
fn is_within(problem: &Problem, held: &Held, id: &str, most: f64) -> bool {
    let Held { solution, free, .. } = held;
    let covariance = fit::clustered_covariance(&solution.grams, &problem.priors(free, 0), free.len());
    let of_it = |f: &Free| matches!(f, Free::Effect { effect, .. } if *effect == id);
    let sizes = free.iter().enumerate().filter(|(_, f)| of_it(f));
    sizes
        .map(|(k, f)| (f.get(&solution.model).abs(), covariance[(k, k)].sqrt()))
        .all(|(size, sd)| size < most + 2.0 * sd)
}

/// Whether the pads move the object by less than `normal_m` at the largest grip, or by no more than that beyond what the data
/// leave open.
fn gives_way_less(problem: &Problem, held: &Held, normal_m: f64) -> bool {
    let grip_n = problem.campaign.runs.iter().map(|r| r.prepared.grip_n()).fold(0.0, f64::max);
    let Held { solution, free, .. } = held;
    let covariance = fit::clustered_covariance(&solution.grams, &problem.priors(free, 0), free.len());
    // Along the face: pressed in they give way less than that, and a fit that says otherwise has taken something
    // else for it. How gradually they let go is another matter, and the pusher is no pad.
    let pads = |(k, f): (usize, &Free)| match f {
        Free::Effect { slot, .. } if f.is_read_off() => Some((k, *slot)),
        _ => None,
    };
    let Some((k, slot)) = free.iter().enumerate().find_map(pads) else { return true };
    let mut least = solution.model.clone();
    free[k].set(&mut least, free[k].get(&solution.model) - 2.0 * covariance[(k, k)].sqrt());
    let compliance_m_n = least.effects.get(slot).map_or(0.0, |e| tangential_m_n(&e.parameters, grip_n));
    compliance_m_n * grip_n < normal_m
}
