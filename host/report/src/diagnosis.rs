//! A diagnosis in words: what page and terminal both say.

use crate::words::{effects_in_words, identifier_words as words};
use stickslip_analysis::channels::channel_words;
use stickslip_analysis::diagnose::posterior::Weighed;
use stickslip_analysis::diagnose::report::{Place, Report, Verdict};
use stickslip_analysis::diagnose::structure::Structure;

/// The verdict: what the model lacks in the lead, then what is won by it.
#[must_use]
pub fn sentence(report: &Report) -> String {
    let what = |id: &&'static str| {
        let of = report.candidates.iter().find(|c| c.id == *id);
        of.map_or_else(|| (*id).to_owned(), |c| format!("{} ({id})", c.info.summary))
    };
    let set = |set: &[&'static str]| set.iter().map(what).collect::<Vec<_>>().join(", and ");
    let e = &report.error;
    // What depends on the order of runs shows between repetitions, and may leave the mean error as it was.
    let named = report.candidates.iter().filter(|c| report.effects.contains(&c.id));
    // What shows in one channel alone may not move the mean of all: then that one is said.
    let worst = report.places.iter().max_by(|a, b| a.before.total_cmp(&b.before));
    let fall = |with: &str| match worst.filter(|w| shown(w.after) < shown(w.before)) {
        _ if shown(e.after) < shown(e.before) => {
            format!("{with} held-out error falls from {:.1} to {:.1} run spreads.", e.before, e.after)
        }
        Some(Place { channel, phase, before, after }) => format!(
            "{with} misfit of {} ({phase}) falls from {before:.1} to {after:.1} run spreads.",
            channel_words(channel)
        ),
        None => format!(
            "It is seen beyond chance (p = {:.1e}), though not in the mean held-out error.",
            named.clone().map(|c| c.p_value).fold(1.0, f64::min)
        ),
    };
    let also =
        report.also_missing.as_ref().map_or(String::new(), |text| format!(" {}", effects_in_words(text)));
    match report.verdict {
        Verdict::Effect => format!(
            "The model lacks: {}. {}{also}",
            set(&report.effects),
            fall(if report.effects.len() == 1 { "With it the" } else { "With them the" })
        ),
        Verdict::Ambiguous => {
            let others: Vec<String> = report.ambiguous_with.iter().map(|s| set(s)).collect();
            format!(
                "The model lacks effects that these data do not separate: {}; or {}. {}{also}",
                set(&report.effects),
                others.join("; or "),
                fall("The")
            )
        }
        Verdict::NothingMissing | Verdict::Unexplained | Verdict::Inconclusive => {
            effects_in_words(&report.summary)
        }
    }
}

/// A misfit as it is shown: in tenths.
fn shown(run_spreads: f64) -> f64 {
    (10.0 * run_spreads).round()
}

/// Structure that is left, in words.
pub fn structure_words(s: &Structure) -> String {
    let on: Vec<String> =
        s.depends_on.iter().map(|(q, x)| format!("{} ({:.0} %)", quantity_words(q), 100.0 * x)).collect();
    let on = if on.is_empty() { "no named quantity".into() } else { on.join(", ") };
    format!("{} ({}), {:.1} run spreads, depends on {on}", channel_words(&s.channel), s.phase, s.size)
}

/// A quantity without its unit.
fn quantity_words(name: &str) -> String {
    let cut = ["_kg", "_rad", "_m", "_n"].iter().find_map(|unit| name.strip_suffix(unit));
    words(cut.unwrap_or(name))
}

/// Share of the excess error that an effect explains.
pub fn share(explained: f64) -> String {
    if explained < 0.0 { "none: worse".into() } else { format!("{:.0} %", 100.0 * explained) }
}

/// That in words, `of_what` being what it is a share of.
pub fn explains(explained: f64, of_what: &str) -> String {
    match explained {
        e if e < 0.0 => format!("explains none {of_what} and leaves more"),
        e => format!("explains {} {of_what}", share(e)),
    }
}

/// A probability in per cent; what is nearly none or all is said to be so.
pub fn percent(probability: f64) -> String {
    match probability {
        p if p < 0.005 => "below 1 %".into(),
        p if p > 0.995 => "above 99 %".into(),
        p => format!("{:.0} %", 100.0 * p),
    }
}

/// A set of effects in words.
pub(crate) fn set_words(s: &Weighed) -> String {
    match s.effects.as_slice() {
        [] => "nothing is missing".to_owned(),
        effects => effects.join(" + "),
    }
}

/// The credible sets in words, one a line, and what is none of them; nothing where nothing had to be explained.
pub fn credible(report: &Report) -> Vec<String> {
    let Some(d) = &report.discrepancy else { return Vec::new() };
    let each =
        report.credible_sets.iter().map(|s| format!("{}: {}", words(&set_words(s)), percent(s.probability)));
    let rest = [
        format!("none of the sets tried: {}", percent(d.probability)),
        format!(
            "something that is not listed beside one of them (counted with the set): {}",
            percent(d.beside)
        ),
    ];
    each.chain(rest).collect()
}

/// Effects that lower the error although nothing is worth a name, in a sentence.
pub fn weaker(report: &Report) -> Option<String> {
    let each = report.weaker.iter().map(|c| {
        let class = report.classes.iter().find(|class| class.contains(&c.id));
        let alike = class.into_iter().flatten().filter(|id| **id != c.id);
        let or: String = alike.map(|id| format!(" or {}", words(id))).collect();
        format!("{}{or} lowers it to {:.2} (p = {:.0e})", words(c.id), c.held_out_error, c.p_value)
    });
    let each: Vec<String> = each.collect();
    (!each.is_empty()).then(|| {
        format!(
            "Within the tolerances of contact, so not named: the held-out error is {:.2} run spreads, and {}.",
            report.error.after,
            each.join(", ")
        )
    })
}

/// Whether a model with effects stands beside the base model.
pub(crate) fn has_after(report: &Report) -> bool {
    matches!(report.verdict, Verdict::Effect | Verdict::Ambiguous)
}
