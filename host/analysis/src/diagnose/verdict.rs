//! The verdict of a diagnosis: a function of a few numbers that the search found, and of nothing else.

use schemars::JsonSchema;
use serde::Serialize;

use crate::diagnose::misfit::{Misfit, Place};

/// Systematic misfit of a channel in a phase beyond this many run spreads is worth a name.
pub const RELEVANT: f64 = 2.5;
/// Systematic misfit that no effect explains is reported beyond this many run spreads.
pub const UNEXPLAINED: f64 = 4.0;
/// Least share of the excess misfit that effects must explain.
pub const EXPLAINS: f64 = 0.8;
/// Share of the excess that is enough where nothing relevant is left.
pub const EXPLAINS_RELEVANT: f64 = 0.6;
/// An effect that explains this share is named whatever is left; the report says what is.
pub const CERTAIN: f64 = 0.95;
/// Beyond this share a fit counts as adequate whatever error is left.
const ADEQUATE_SHARE: f64 = 0.85;
/// Otherwise the error after may be this many run spreads.
const ADEQUATE_ERROR: f64 = 1.3;
/// ... but never when the error is beyond this many run spreads and a place misses by
/// [`FAR`] of them: something else stands behind it.
const POOR_ERROR: f64 = 1.75;
const FAR: f64 = 8.0;
/// An effect acts where it lowers a misfit by more than this share of it.
const ACTS: f64 = 0.1;
/// Fewest conditions for a verdict.
pub const FEWEST_CONDITIONS: usize = 4;

/// What came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The model agrees with the data within the run spread.
    NothingMissing,
    /// The named effects are missing.
    Effect,
    /// One of several effects is missing; these data do not distinguish them.
    Ambiguous,
    /// Something is missing that none of the effects explains.
    Unexplained,
    /// These data do not show whether something is missing; the report says why, and what to measure.
    Inconclusive,
}

/// Why neither an effect nor its absence can be concluded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Doubt {
    /// Fewer than [`FEWEST_CONDITIONS`].
    FewConditions,
    /// A misfit that is worth a name ([`RELEVANT`]) but not large enough to say that something
    /// unknown is missing ([`UNEXPLAINED`]), and no effect explains it.
    Small(Place),
    /// The same where effects would explain it. What a model may leave once effects are named
    /// ([`Left::near`]) is no reason to name one: tolerances of rigid contact have the shape of some effect too, but not
    /// such a size in all features together ([`Misfit::is_beyond_perfect`]).
    Weak(Place),
    /// No channel misses by that much in any phase, but in so many conditions, of so many, all together clearly do
    /// ([`Misfit::clear_conditions`]), and no effect explains it.
    Together(usize, usize),
    /// A misfit that mostly one condition shows, also where the model is fitted to it: it may be the model's way of contact
    /// there.
    OneCondition(Place),
    /// No trial was repeated, and no effect predicts held-out trials better than chance could: the best of
    /// them, and that chance.
    Unrepeated(Option<(&'static str, f64)>),
}

/// What a model leaves of the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Left {
    /// Root mean square error over that of a perfect model.
    pub error: f64,
    /// Largest systematic misfit of a channel in a phase that is beyond chance, in run spreads.
    pub worst: f64,
}

impl Left {
    /// Of a misfit.
    #[must_use]
    pub fn of(misfit: &Misfit) -> Self {
        let beyond_chance = misfit.places.iter().filter(|p| p.at_least > 1.0);
        let worst = beyond_chance.map(|p| p.size).fold(0.0, f64::max);
        Self { error: misfit.error / misfit.perfect_model, worst }
    }

    /// Is nothing left that is worth a name?
    #[must_use]
    pub fn settled(&self) -> bool {
        self.worst <= RELEVANT
    }

    /// Is what is left small enough for a model that holds all that matters?
    #[must_use]
    pub fn near(&self) -> bool {
        self.error <= ADEQUATE_ERROR && self.worst <= UNEXPLAINED
    }

    /// Does something else stand behind what is left, however much was explained?
    #[must_use]
    pub fn poor(&self) -> bool {
        self.error > POOR_ERROR && self.worst > FAR
    }
}

/// Whether effects that together explain `share` of the excess misfit and leave `left` explain the data.
#[must_use]
pub fn explains(share: f64, left: &Left) -> bool {
    let adequate =
        left.settled() || left.near() || share >= CERTAIN || (share >= ADEQUATE_SHARE && !left.poor());
    adequate && share >= if left.settled() { EXPLAINS_RELEVANT } else { EXPLAINS }
}

/// Verdict on a search for effects: whether those it chose `explain` the data, how many of them are
/// `named` (not so the compliance that any pad has), and what is left without those that are.
#[must_use]
pub fn of_search(explain: bool, named: usize, left: &Left) -> Verdict {
    match explain {
        true if named > 0 => Verdict::Effect,
        false if left.worst > UNEXPLAINED => Verdict::Unexplained,
        _ => Verdict::NothingMissing,
    }
}

/// What else has a say.
#[derive(Clone, Copy, Debug)]
pub struct Signs {
    /// Other effects explain the data as well.
    pub equal: bool,
    /// Friction drifts with the order of trials or the object is seen late, which is measured by itself, and no other effect was
    /// chosen.
    pub only_measured: bool,
    /// Pads are measured to be softer than any fingertip may be without a word, no effect was chosen, and nothing
    /// large is left or the pads explain enough.
    pub only_pads: bool,
    /// Effects that were chosen leave half of the held-out loss, or less, beyond chance.
    pub clear: bool,
    /// Forces swing while the object slides, and not in the model.
    pub swings: bool,
    /// Fitted to all conditions, none held out, the model leaves nothing that is worth a name: what one condition is off by when
    /// it is held out is what it alone tells of the parameters.
    pub fits: bool,
    /// Different conditions.
    pub conditions: usize,
}

/// The verdict, and where nothing can be concluded why: `search` as [`of_search`] has it, `misfit` what the
/// model leaves, without the effects that the search chose.
#[must_use]
pub fn verdict(search: Verdict, signs: &Signs, misfit: &Misfit) -> (Verdict, Option<Doubt>) {
    let weak = || misfit.places.iter().find(|p| p.exceeds(RELEVANT)).copied();
    let verdict = match search {
        _ if signs.only_measured => Verdict::Effect,
        Verdict::NothingMissing | Verdict::Unexplained if signs.only_pads => Verdict::Effect,
        // No tolerance makes that much in all features together.
        Verdict::Effect
            if Left::of(misfit).near()
                && !signs.clear
                && !misfit.is_beyond_perfect()
                && signs.conditions >= FEWEST_CONDITIONS =>
        {
            // What swings is beyond doubt, and effects fitted to levels do not explain it.
            return if signs.swings {
                (Verdict::Unexplained, None)
            } else {
                (Verdict::Inconclusive, weak().map(Doubt::Weak))
            };
        }
        Verdict::Effect if signs.equal => Verdict::Ambiguous,
        other => other,
    };
    if verdict != Verdict::NothingMissing {
        return (verdict, None);
    }
    match doubt(signs, misfit) {
        Some(Doubt::FewConditions) => (Verdict::Inconclusive, Some(Doubt::FewConditions)),
        // What swings is beyond doubt.
        _ if signs.swings => (Verdict::Unexplained, None),
        Some(doubt) => (Verdict::Inconclusive, Some(doubt)),
        None => (verdict, None),
    }
}

/// The worst misfit elsewhere, where effects explain all that they act on. Two things may be missing that show in
/// different places, one of them not listed: shares of all that is missing then say little of the effects that explain
/// the other. `before` and `after` are what is missed without and with them. `None` unless, where they act, one misfit
/// was clear ([`UNEXPLAINED`]), none is worth a name any more ([`RELEVANT`]) and [`EXPLAINS`] of what was above the run
/// spread is gone, and unless something is left elsewhere that did not grow.
#[must_use]
pub fn apart(before: &Misfit, after: &Misfit) -> Option<Place> {
    let above = |p: &Place| (p.size * p.size - 1.0).max(0.0);
    let (mut had, mut left, mut clear) = (0.0, 0.0, false);
    let mut beside: Option<Place> = None;
    for now in &after.places {
        let Some(then) = before.at(now.channel, now.phase) else { continue };
        let still = now.exceeds(RELEVANT);
        if now.size < (1.0 - ACTS) * then.size {
            if still {
                return None;
            }
            had += above(then);
            left += above(now);
            clear |= then.exceeds(UNEXPLAINED);
        } else if still {
            if now.size > (1.0 + ACTS) * then.size {
                return None;
            }
            // The worst comes first.
            beside = beside.or(Some(*now));
        }
    }
    beside.filter(|_| clear && left <= (1.0 - EXPLAINS) * had)
}

/// Whether a clear misfit ([`UNEXPLAINED`]) is left where effects do not act: `before` and `after` are what is missed
/// without and with them.
#[must_use]
pub fn untouched(before: &Misfit, after: &Misfit) -> bool {
    after
        .places
        .iter()
        .filter(|now| now.exceeds(UNEXPLAINED))
        .any(|now| before.at(now.channel, now.phase).is_some_and(|then| now.size >= (1.0 - ACTS) * then.size))
}

/// Where effects are named and something else is missing all the same: drift is read off repetitions whatever
/// the search finds, and a `search` that ended without an explanation leaves a clear misfit. The worst of what
/// is `left` beyond chance.
#[must_use]
pub fn missing_beside(search: Verdict, signs: &Signs, left: &Misfit) -> Option<Place> {
    let worst = left.places.iter().find(|p| p.exceeds(UNEXPLAINED));
    worst.filter(|_| signs.only_measured && search == Verdict::Unexplained).copied()
}

/// The worst clear misfit ([`UNEXPLAINED`]) that named effects leave and the form of their laws does not excuse
/// ([`Misfit::beyond_form`]): `before` and `after` are what is missed without and with them.
#[must_use]
pub fn left_over(before: &Misfit, after: &Misfit) -> Option<Place> {
    let beyond = after.beyond_form(before);
    let worst = beyond.places.iter().find(|p| p.exceeds(UNEXPLAINED))?;
    after.at(worst.channel, worst.phase).copied()
}

/// The verdict where most trials' measured forces do not balance: something is missing whatever the model shows.
#[must_use]
pub fn unbalanced(verdict: Verdict, conditions: usize) -> Verdict {
    match verdict {
        Verdict::NothingMissing | Verdict::Inconclusive if conditions >= FEWEST_CONDITIONS => {
            Verdict::Unexplained
        }
        other => other,
    }
}

/// Why a model that lacks nothing worth a name may still lack something: `misfit` is what it leaves.
fn doubt(signs: &Signs, misfit: &Misfit) -> Option<Doubt> {
    if signs.conditions < FEWEST_CONDITIONS {
        return Some(Doubt::FewConditions);
    }
    match (misfit.places.iter().find(|p| p.exceeds(RELEVANT)), misfit.clear_conditions()) {
        (Some(place), _) => Some(Doubt::Small(*place)),
        (None, Some((clear, of))) => Some(Doubt::Together(clear, of)),
        (None, None) if signs.fits => None,
        (None, None) => {
            misfit.places.first().filter(|p| p.size > RELEVANT).map(|place| Doubt::OneCondition(*place))
        }
    }
}
