//! A contact model against measurements: what the data show, what the model predicts, where the
//! two part, and which physical effect is missing.
//!
//! From the ground up: [`channels`] (the signals that both share), [`model`] (the model file),
//! [`run`] (a model along a recorded trial), [`evidence`] (conditions, phases, noise, balance),
//! [`fit`] (least squares on features of all trials), and on top [`mod@check`],
//! [`mod@calibrate`], [`mod@compare`], [`mod@diagnose`] and [`score`].

pub mod add;
pub mod calibrate;
pub mod channels;
pub mod check;
pub mod compare;
pub mod diagnose;
pub mod evidence;
pub mod fit;
pub mod model;
pub mod run;
pub mod score;
