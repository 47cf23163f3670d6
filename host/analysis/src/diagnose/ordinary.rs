//! What any rig has, and is no finding: pads that give way a little, a pusher that is mounted as square as it was set up.
//!
//! It stays in the model beside what is found, so that nothing else has to stand in for it, and is not named.

use stickslip_shared::effects::contact_compliance::tangential_m_n;
use stickslip_shared::effects::{Role, find as find_effect};

use crate::diagnose::select::Held;
use crate::fit::problem::Problem;
use crate::fit::{self, Free};

/// What any rig has, in a fit.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ordinary {
    /// Pads that give way a little.
    pub pads: bool,
    /// A pusher that is not quite square.
    pub mounting: bool,
}

/// Whether effect `id` of the fit `held` is no more than any rig has of it.
pub fn is_ordinary_in(problem: &Problem, held: &Held, id: &str) -> bool {
    match find_effect(id).map(|info| info.role) {
        Some(Role::Compliance { normal_m }) => gives_way_less(problem, held, normal_m),
        Some(Role::Mounting { square_rad }) => is_square(problem, held, id, square_rad),
        _ => false,
    }
}

/// What stands in `held` because no pusher is quite square, in words; none where nothing does, or it is a finding.
pub fn mounted(problem: &Problem, held: &Held) -> Option<String> {
    let angle = |f: &Free| {
        let Free::Effect { effect, .. } = f else { return None };
        let Role::Mounting { square_rad } = find_effect(effect)?.role else { return None };
        Some((f.get(&held.solution.model).abs(), *effect, square_rad))
    };
    let (most_rad, id, square_rad) = held.free.iter().filter_map(angle).max_by(|a, b| a.0.total_cmp(&b.0))?;
    is_ordinary_in(problem, held, id).then(|| format!(
        "{id} of up to {:.2} mrad stands in the fit and is no finding: a pusher may be off square by {:.1} mrad, and by what the data \
         leave open",
        1e3 * most_rad,
        1e3 * square_rad
    ))
}

/// Whether no angle is larger than `square_rad` beyond what the data leave open.
fn is_square(problem: &Problem, held: &Held, id: &str, square_rad: f64) -> bool {
    let Held { solution, free, .. } = held;
    let covariance = fit::clustered_covariance(&solution.grams, &problem.priors(free, 0), free.len());
    let of_it = |f: &Free| matches!(f, Free::Effect { effect, .. } if *effect == id);
    let angles = free.iter().enumerate().filter(|(_, f)| of_it(f));
    angles
        .map(|(k, f)| (f.get(&solution.model).abs(), covariance[(k, k)].sqrt()))
        .all(|(angle_rad, sd_rad)| angle_rad < square_rad + 2.0 * sd_rad)
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
