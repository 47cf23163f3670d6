//! Friction that only grows or falls along the path of all trials, and what else does so.
//!
//! A part of a wave is no wave ([`super::select`] does not take it for one): an eighth of its length from where it is zero a sine
//! departs from a line by a tenth, as much as any law may be wrong by. So where all that an effect shows of itself is a line of friction over
//! the place on the object, not the forces that a slope of the face brings with it, a wave longer than the path does as well, and
//! trials over a longer part of the object would show which it is.

use stickslip_shared::effects::Info;

use crate::diagnose::choice::{SAME_LOSS, without_parameters};
use crate::diagnose::select::{Candidate, Held, WAVE, total};
use crate::fit::Free;
use crate::fit::problem::Problem;
use crate::model::candidate::CandidateEffect;

/// The parameter of an effect that is a line of friction.
const LINE: &str = "friction_gradient_1_m";

fn has(info: &Info, name: &str) -> bool {
    info.parameters.iter().any(|p| p.name == name)
}

/// To what does as well as each of `chosen`, which stand in the model from `first_slot` on, adds waves of `trials` where a line of
/// friction does as well as the whole effect.
pub fn with_waves(
    problem: &Problem,
    (chosen, first_slot): (&[Candidate], usize),
    trials: &[CandidateEffect],
    equal: &mut [Vec<&'static str>],
) {
    let Some(last) = chosen.last() else { return };
    let waves = trials.iter().map(|t| t.info).filter(|info| has(info, WAVE));
    let waves: Vec<&'static str> =
        waves.map(|info| info.id).filter(|id| chosen.iter().all(|c| c.info.id != *id)).collect();
    for (k, (c, equal)) in chosen.iter().zip(equal).enumerate() {
        let news = waves.iter().filter(|id| !equal.contains(id)).copied().collect::<Vec<_>>();
        if has(c.info, LINE) && !news.is_empty() && is_a_line(problem, &last.held, first_slot + k) {
            equal.extend(news);
        }
    }
}

/// Whether the line of friction of the effect in `slot` does as well, on held-out conditions, as all of the effect.
fn is_a_line(problem: &Problem, held: &Held, slot: usize) -> bool {
    let beside_it = |f: &Free| matches!(f, Free::Effect { slot: s, of, .. } if *s == slot && of.name != LINE);
    let line = without_parameters(problem, held, beside_it);
    total(&line) < SAME_LOSS * total(held)
}
