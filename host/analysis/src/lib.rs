//! A contact model against measurements: what the data show, what the model predicts, where the
//! two part, and which physical effect is missing.
//!
//! From the ground up: [`channels`] (the signals that both share), [`model`] (the model file), [`tuning`] (the predictor's numbers),
//! [`run`] (a model along a recorded trial), [`left_out`] (trials that it cannot run along), [`evidence`] (conditions, phases, noise, balance),
//! [`fit`] (least squares on features of all trials), and on top the analyses.
//!
//! An analysis is one function: [`check()`], [`calibrate()`], [`compare()`], [`diagnose()`], [`suggest()`],
//! [`add()`], [`refit()`], [`score()`], [`simulate()`]. It takes a data set, a model, its options and a [`Progress`], and
//! returns a report that serialises, or an error that says what to do. Those that read a data set trial by
//! trial take an [`Index`](stickslip_data::Index), from a folder or from memory, and say in their report
//! what of it was refused; those that need all trials at once take a
//! [`Dataset`](stickslip_data::Dataset). Commands, pages and tests call these. [`run::live::Live`] is the predictor for samples
//! that come one by one.

pub mod add;
pub mod calibrate;
pub mod channels;
pub mod check;
pub mod compare;
pub mod diagnose;
pub mod evidence;
pub mod fit;
pub mod left_out;
pub mod model;
pub mod progress;
pub mod run;
pub mod score;
pub mod simulate;
pub mod suggest;
pub mod tuning;

pub use add::{add, refit};
pub use calibrate::calibrate;
pub use check::check;
pub use compare::compare;
pub use diagnose::diagnose;
pub use left_out::LeftOut;
pub use progress::Progress;
pub use score::document::score;
pub use simulate::simulate;
pub use suggest::suggest;
