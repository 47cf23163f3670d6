//! What the search of a diagnosis found, before it is put into words.

use stickslip_shared::model::Model;

use crate::diagnose::misfit::Place;
use crate::diagnose::posterior::Posterior;
use crate::diagnose::select::{Candidate, Held};
use crate::diagnose::swing::Swing;
use crate::diagnose::verdict::{Doubt, Verdict};

/// Everything that a diagnosis found; [`crate::diagnose::report::Report`] is its public form.
#[derive(Debug)]
pub struct Findings {
    /// Base model, refitted.
    pub base: Held,
    /// The same with the pads as they give way, as long as they are no finding: what effects explain and what is not
    /// explained is what this one misses.
    pub start: Held,
    /// What stood in the model before the search.
    pub found: Vec<Candidate>,
    /// Candidates of the first stage.
    pub first: Vec<Candidate>,
    /// Chosen effects in the order in which they were chosen.
    pub chosen: Vec<Candidate>,
    /// Where nothing is worth a name: effects that predict held-out conditions better all the same.
    pub weaker: Vec<Candidate>,
    /// All of it fitted together (with the compliance of the pads, where that shows).
    pub last: Option<Held>,
    /// Sets that explain the data as well.
    pub equal: Vec<Vec<&'static str>>,
    /// How probable each set that was fitted is.
    pub posterior: Posterior,
    /// Effects that change nothing in these data.
    pub invisible: Vec<&'static str>,
    /// What swings while the object slides, and not in the model.
    pub swing: Option<Swing>,
    /// Where nothing explains the data: the model around which to go through them once more.
    pub again: Option<Model<f64>>,
    /// What came out.
    pub verdict: Verdict,
    /// What is missing beside the effects that are named, where no effect explains it: its worst place.
    pub beside: Option<Place>,
    /// Why nothing can be concluded, where that came out.
    pub doubt: Option<Doubt>,
    /// Model with the chosen effects (the base model where none is chosen).
    pub model: Model<f64>,
}
