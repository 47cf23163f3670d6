//! What any rig has, and is no finding: pads that give way a little, and press off their middle by as little as they are mounted to; a
//! pusher that is mounted as square as it was set up; an object that is seen a sample late; sensors that are turned a little, and show a little of one channel in another.
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
    /// A pusher that is not quite square, pads that press not quite in their middle, or sensors that are not quite as drawn.
    pub mounting: bool,
}

/// Whether effect `id` of the fit `held` is no more than any rig has of it.
pub fn is_ordinary_in(problem: &Problem, held: &Held, id: &str) -> bool {
    match find_effect(id).map(|info| info.role) {
        Some(Role::Compliance { normal_m }) => gives_way_less(problem, held, normal_m),
        Some(role) => Most::of(problem, role).is_some_and(|most| is_within(problem, held, id, most)),
        None => false,
    }
}

/// How much of an effect any rig may have, where something is mounted.
#[derive(Clone, Copy)]
enum Most {
    /// Each parameter, rad, m or s.
    Size(f64),
    /// Each as a share of its typical size.
    OfTypical(f64),
}

impl Most {
    fn of(problem: &Problem, role: Role) -> Option<Self> {
        match role {
            Role::Mounting { square_rad } => Some(Self::Size(square_rad)),
            Role::Pressing { of_diameter } => {
                Some(Self::Size(of_diameter * problem.campaign.pad_diameter_m()?))
            }
            Role::Delay => Some(Self::Size(problem.campaign.period_s())),
            Role::Sensing { of_typical } => Some(Self::OfTypical(of_typical)),
            _ => None,
        }
    }

    /// The size of `f` as this counts it, and the most of it.
    fn sized(self, f: &Free, size: f64) -> [f64; 2] {
        match (self, f) {
            (Self::OfTypical(most), Free::Effect { of, .. }) => [size / of.typical.abs(), most],
            (Self::Size(most) | Self::OfTypical(most), _) => [size, most],
        }
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
        let Some(most) = Most::of(problem, role) else { continue };
        if out.iter().any(|(known, _)| *known == id) || !is_within(problem, held, id, most) {
            continue;
        }
        let of_it = |f: &&Free| matches!(f, Free::Effect { effect, .. } if *effect == id);
        let sized = held.free.iter().filter(of_it).map(|f| most.sized(f, f.get(&held.solution.model).abs()));
        let [here, most] = sized.fold([0.0; 2], |[size, _], [here, most]| [f64::max(size, here), most]);
        let (here, unit, may) = match role {
            Role::Sensing { .. } => {
                let may = format!("any sensor may have {:.0} %", 1e2 * most);
                (1e2 * here, "% of its typical size", may)
            }
            Role::Delay => (1e3 * here, "ms", format!("a sample takes {:.1} ms", 1e3 * most)),
            Role::Pressing { .. } => {
                (1e3 * here, "mm", format!("pads may press off their middle by {:.2} mm", 1e3 * most))
            }
            _ => (1e3 * here, "mrad", format!("a pusher may be off square by {:.1} mrad", 1e3 * most)),
        };
        out.push((id, format!(
            "{id} of up to {here:.2} {unit} stands in the fit and is no finding: {may}, and by what the data leave open"
        )));
    }
    out.into_iter().map(|(_, words)| words).collect()
}

/// Whether none of its parameters is larger than `most` beyond what the data leave open.
fn is_within(problem: &Problem, held: &Held, id: &str, most: Most) -> bool {
    let Held { solution, free, .. } = held;
    let covariance = fit::clustered_covariance(&solution.grams, &problem.priors(free, 0), free.len());
    let of_it = |f: &Free| matches!(f, Free::Effect { effect, .. } if *effect == id);
    let sizes = free.iter().enumerate().filter(|(_, f)| of_it(f));
    sizes
        .map(|(k, f)| most.sized(f, f.get(&solution.model).abs() - 2.0 * covariance[(k, k)].sqrt()))
        .all(|[size, most]| size < most)
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
