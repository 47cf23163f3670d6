//! What is missed, and why nothing can be concluded of it, in words.

use crate::channels::channel_words;
use crate::diagnose::misfit::Place;
use crate::diagnose::verdict::{Doubt, FEWEST_CONDITIONS, RELEVANT, UNEXPLAINED};
use crate::fit::features::channel_name;
use crate::fit::problem::Problem;

/// Which channel misses in which phase, and by how much.
pub fn off_by(place: &Place) -> String {
    let words = channel_words(&channel_name(place.channel));
    format!("{words} ({}) is off by {:.1} run spreads", place.phase.name(), place.size)
}

/// Why nothing can be concluded, and what would tell; `sets` of effects would explain what is missed, and there may be an
/// experiment to suggest.
pub fn doubtful(doubt: &Doubt, problem: &Problem, sets: &[Vec<&str>], suggested: bool) -> (String, String) {
    let trial = |p: &Place| &problem.campaign.runs[p.run].info.trial;
    match doubt {
        Doubt::FewConditions => {
            let n = problem.campaign.conditions;
            (
                format!(
                    "the data have {n} different condition(s), at least {FEWEST_CONDITIONS} are needed to \
                     separate an effect from a wrong friction coefficient"
                ),
                format!(
                    "run {} more condition(s) with another grip, speed or slope, each at least twice",
                    FEWEST_CONDITIONS.saturating_sub(n)
                ),
            )
        }
        Doubt::Small(p) | Doubt::Weak(p) => (
            format!(
                "{}, more than a model that lacks nothing ({RELEVANT}) and less than a clear misfit \
                 ({UNEXPLAINED:.1}), and {}",
                off_by(p),
                match sets {
                    [] => "no effect explains it".to_owned(),
                    some => format!(
                        "{} would explain it, as may the tolerances of rigid contact",
                        some.iter().map(|set| set.join(" with ")).collect::<Vec<_>>().join(" or ")
                    ),
                }
            ),
            match sets {
                // Repetitions do not lower the tolerances.
                [_, ..] if suggested => {
                    "make the experiment suggested, in which the model with it and the model without it differ most"
                        .to_owned()
                }
                _ => format!(
                    "repeat the condition of trial {}, where it is largest, to lower the run spread",
                    trial(p)
                ),
            },
        ),
        Doubt::Unrepeated(best) => (
            format!(
                "no trial was repeated, so that chance is known only as what the model leaves, and no effect \
                 predicts trials that it was not fitted to better than chance could{}",
                best.map_or(String::new(), |(id, p)| format!(" (the best, {id}: p = {p:.1e})"))
            ),
            "repeat some of the trials at the same place, or run more trials where the candidates differ"
                .to_owned(),
        ),
        Doubt::Together(clear, of) => (
            format!(
                "no channel in a phase is off by more than {RELEVANT} run spreads, but in {clear} of {of} conditions all of them \
                 together are by more than twice what noise and tolerances make (in each of them the scatter of friction from run to \
                 run hides it), and no effect explains that"
            ),
            format!(
                "run more conditions (another grip, speed or slope), and lower the scatter of friction from run to run ({:.1} % of the \
                 fingers' now): clean the surfaces",
                100.0 * problem.noise.friction[0]
            ),
        ),
        Doubt::OneCondition(p) => (
            format!("{}, but mostly in one condition (that of trial {})", off_by(p), trial(p)),
            format!("repeat the condition of trial {} and run conditions near it", trial(p)),
        ),
    }
}
