//! Opens the key: compares what was hidden with what was named.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::blind::generate::{Class, Key};
use stickslip_analysis::diagnose::posterior::Weighed;
use stickslip_analysis::diagnose::report::{CandidateReport, Report, Verdict};
use stickslip_analysis::score::warnings::Share;

/// A single effect counts as strong if the error before exceeds this many run spreads.
const STRONG: f64 = 2.0;
/// An answer may name so many possibilities.
const LARGEST_SET: usize = 3;
/// What is said with this probability is said for sure.
const SURE: f64 = 0.95;
/// Upper ends of the bins of probability over which the calibration error is summed.
const BINS: [f64; 5] = [0.5, 0.7, 0.85, SURE, f64::INFINITY];

/// What was hidden in a data set, whoever made it.
#[derive(Clone, Debug, Serialize)]
pub struct Truth {
    /// How many of which kind.
    pub class: Class,
    /// Identifiers.
    pub effects: Vec<String>,
    /// The same with their strengths.
    pub strengths: Vec<String>,
    /// What is there but no hidden effect, such as soft pads: naming it is not wrong.
    pub also_true: Vec<&'static str>,
    /// Plan, or the family that it was drawn from.
    pub family: String,
    /// Trials made.
    pub trials: usize,
}

/// What is not in the list under this name, and is an `external_force` all the same.
const PULLS: [&str; 3] = ["u_lateral_pull", "x_cable_force", "x_magnet_pull"];

/// The name that one of `effects` has in the list, if it pulls at the object from outside.
pub fn pulled(effects: &[String]) -> Option<&'static str> {
    effects.iter().any(|id| PULLS.contains(&id.as_str())).then_some("external_force")
}

impl From<&Key> for Truth {
    fn from(key: &Key) -> Self {
        let effects: Vec<String> = key.effects.iter().map(|e| e.kind.name().to_owned()).collect();
        Self {
            class: key.class,
            also_true: pulled(&effects).into_iter().collect(),
            effects,
            strengths: key.effects.iter().map(ToString::to_string).collect(),
            family: format!("{:?}", key.plan).to_lowercase(),
            trials: key.trials,
        }
    }
}

/// One run with what was hidden.
#[derive(Clone, Debug, Serialize)]
pub struct Opened {
    /// What was hidden.
    pub truth: Truth,
    /// Verdict.
    pub verdict: Verdict,
    /// Effects named.
    pub named: Vec<&'static str>,
    /// As good as those.
    pub ambiguous_with: Vec<Vec<&'static str>>,
    /// Held-out error before and after, and what a perfect model shows.
    pub error: [f64; 3],
    /// Worst systematic misfit of a channel in a phase, in run spreads.
    pub worst: f64,
    /// The same after.
    pub worst_after: f64,
    /// Where it is.
    pub worst_place: String,
    /// How the hidden effects, and the first of all, did as candidates of the first stage.
    pub candidates: Vec<CandidateReport>,
    /// Where two are hidden: error of the base model and what a perfect model shows with each of them alone.
    pub each_alone: Vec<[f64; 2]>,
    /// Credible sets, where there was something to explain.
    pub credible_sets: Vec<Weighed>,
    /// Probability that it is none of the sets that were fitted.
    pub unlisted: f64,
    /// Time of the diagnosis, s.
    pub seconds: f64,
}

/// In per cent, with its interval; `-` where there was nothing to count.
#[must_use]
pub fn text(share: &Share) -> String {
    let Some([low, high]) = share.interval() else { return "- (0)".into() };
    let percent = 100.0 * share.found as f64 / share.of as f64;
    format!("{percent:.1} % ({} of {}; {:.0} to {:.0})", share.found, share.of, 100.0 * low, 100.0 * high)
}

/// Figures of the study.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Figures {
    /// Single strong effect named alone or in an ambiguous set of at most three.
    pub strong_named: Share,
    /// Single strong effect named alone.
    pub strong_alone: Share,
    /// Single effect of any strength named, alone or in a set of at most three.
    pub single_named: Share,
    /// Single effect of any strength given a wrong name.
    pub single_wrong: Share,
    /// Where nothing was hidden: `nothing_missing`, or what is there all the same is named (soft pads).
    pub nothing_right: Share,
    /// Unknown effects not given a wrong name (a formula of their name is right).
    pub unknown_not_named: Share,
    /// Two effects, both named, alone or in one of at most three sets.
    pub both_named: Share,
    /// The same where each of them alone would be strong.
    pub both_strong_named: Share,
    /// Two effects, at least one named and none wrong.
    pub one_of_two: Share,
    /// Held-out error after adding at most 1.3 run spreads, where rightly named.
    pub error_fell: Share,
    /// Of what is most probable with 95 % or more: right.
    pub sure_right: Share,
    /// One of the credible sets is what was hidden (of listed effects, where there was something to explain).
    pub credible_holds: Share,
    /// Expected calibration error of the probability of what is most probable.
    pub calibration_error: f64,
    /// Mean size of ambiguous sets.
    pub mean_set: f64,
    /// Strong single effects rightly named, by family.
    pub families: BTreeMap<String, Share>,
    /// Hidden against named.
    pub confusion: BTreeMap<String, BTreeMap<String, usize>>,
    /// Longest diagnosis, s.
    pub slowest_s: f64,
}

/// Opens one run.
pub fn open(truth: Truth, report: &Report, each_alone: Vec<[f64; 2]>) -> Opened {
    let hidden = |c: &CandidateReport| truth.effects.iter().any(|e| e == c.id);
    let candidates = report.candidates.iter().enumerate().filter(|(k, c)| *k == 0 || hidden(c));
    Opened {
        candidates: candidates.map(|(_, c)| c.clone()).collect(),
        truth,
        verdict: report.verdict,
        named: report.effects.clone(),
        ambiguous_with: report.ambiguous_with.clone(),
        error: [report.error.before, report.error.after, report.error.perfect_model],
        worst: report.error.worst_before,
        worst_after: report.error.worst_after,
        worst_place: report.places.first().map_or(String::new(), |p| format!("{} {}", p.channel, p.phase)),
        each_alone,
        credible_sets: report.credible_sets.clone(),
        unlisted: report.discrepancy.map_or(0.0, |d| d.probability),
        seconds: report.seconds,
    }
}

impl Opened {
    /// What may be missing: the effects named, and the sets that do as well.
    fn answers(&self) -> Vec<Vec<&'static str>> {
        match self.verdict {
            Verdict::Effect | Verdict::Ambiguous => {
                std::iter::once(&self.named).chain(&self.ambiguous_with).cloned().collect()
            }
            Verdict::NothingMissing | Verdict::Unexplained | Verdict::Inconclusive => Vec::new(),
        }
    }

    fn is_hidden(&self, id: &str) -> bool {
        self.truth.effects.iter().any(|h| h == id)
    }

    /// Something in `set` is not there.
    fn is_wrong(&self, set: &[&str]) -> bool {
        set.iter().any(|n| !self.is_hidden(n) && !self.truth.also_true.contains(n))
    }

    /// Whether a set of effects is what was hidden.
    fn is_truth(&self, set: &[&str]) -> bool {
        self.truth.effects.iter().all(|h| set.contains(&h.as_str())) && !self.is_wrong(set)
    }

    /// The truth is the only answer, or among at most three.
    fn right(&self) -> bool {
        let answers = self.answers();
        answers.len() <= LARGEST_SET && answers.iter().any(|set| self.is_truth(set))
    }

    /// Something that was not hidden is named, and no answer is free of that.
    fn wrong(&self) -> bool {
        let answers = self.answers();
        !answers.is_empty() && answers.iter().all(|set| self.is_wrong(set))
    }

    /// Probability of what is most probable, and whether it is right; none where nothing had to be explained.
    fn most_probable(&self) -> Option<(f64, bool)> {
        let best = self.credible_sets.first()?;
        Some(match best.probability > self.unlisted {
            true => (best.probability, self.is_truth(&best.effects)),
            false => (self.unlisted, self.truth.class == Class::Unknown),
        })
    }

    /// For the confusion matrix.
    fn answer(&self) -> String {
        match self.verdict {
            Verdict::NothingMissing => "nothing_missing".into(),
            Verdict::Unexplained => "unexplained".into(),
            Verdict::Inconclusive => "inconclusive".into(),
            Verdict::Effect => self.named.join("+"),
            Verdict::Ambiguous => {
                let others: Vec<String> = self.ambiguous_with.iter().map(|s| s.join("+")).collect();
                format!("{} ~ {}", self.named.join("+"), others.join(" ~ "))
            }
        }
    }
}

/// Sums up.
pub fn figures(runs: &[Opened]) -> Figures {
    let mut f = Figures::default();
    let (mut sets, mut size) = (0.0, 0.0);
    for r in runs {
        if let Some((probability, right)) = r.most_probable() {
            if probability >= SURE {
                f.sure_right.count(right);
            }
            if r.truth.class != Class::Unknown {
                f.credible_holds.count(r.credible_sets.iter().any(|s| r.is_truth(&s.effects)));
            }
        }
        let hidden = &r.truth.effects;
        let truth = if hidden.is_empty() { "nothing".into() } else { hidden.join("+") };
        *f.confusion.entry(truth).or_default().entry(r.answer()).or_default() += 1;
        f.slowest_s = f.slowest_s.max(r.seconds);
        if r.verdict == Verdict::Ambiguous {
            sets += 1.0;
            size += 1.0 + r.ambiguous_with.len() as f64;
        }
        match r.truth.class {
            Class::Nothing => f.nothing_right.count(r.verdict == Verdict::NothingMissing || r.right()),
            Class::One => {
                f.single_named.count(r.right());
                f.single_wrong.count(r.wrong());
                if r.error[0] > STRONG * r.error[2] {
                    f.strong_named.count(r.right());
                    f.families.entry(r.truth.family.clone()).or_default().count(r.right());
                    f.strong_alone.count(r.right() && r.verdict == Verdict::Effect);
                }
                if r.right() {
                    f.error_fell.count(r.error[1] <= 1.3 * r.error[2]);
                }
            }
            Class::Two => {
                f.both_named.count(r.right());
                let strong = |[error, floor]: &[f64; 2]| *error > STRONG * floor;
                if !r.each_alone.is_empty() && r.each_alone.iter().all(strong) {
                    f.both_strong_named.count(r.right());
                }
                f.one_of_two.count(!r.named.is_empty() && !r.wrong());
            }
            Class::Unknown => f.unknown_not_named.count(!r.wrong()),
        }
    }
    f.calibration_error = calibration_error(runs);
    f.mean_set = if sets > 0.0 { size / sets } else { 0.0 };
    f
}

/// Mean over the bins of probability, by how many runs are in each, of how far the share that is right is from
/// the mean probability; zero where there are none.
fn calibration_error(runs: &[Opened]) -> f64 {
    let said: Vec<(f64, bool)> = runs.iter().filter_map(Opened::most_probable).collect();
    let mut from = 0.0;
    let mut sum = 0.0;
    for to in BINS {
        let within = said.iter().filter(|(p, _)| *p >= from && *p < to);
        sum += within.map(|(p, right)| f64::from(u8::from(*right)) - p).sum::<f64>().abs();
        from = to;
    }
    sum / said.len().max(1) as f64
}
