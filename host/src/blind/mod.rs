//! The blind test of the diagnosis: `generate` draws what is hidden and makes the data,
//! `score` opens the key. The diagnosis between them sees a data set and nothing else.

pub mod generate;
pub mod score;
