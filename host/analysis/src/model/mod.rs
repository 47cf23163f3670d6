//! The model that a user writes: file, formulas, and effects that may be added to it.

pub mod candidate;
pub mod entry;
pub mod expression;
pub mod file;
pub mod names;
