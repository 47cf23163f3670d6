//! Models along recorded trials: the contact model by itself, and the predictor as on the board.

pub mod bench;
mod gravity;
pub mod late;
pub mod live;
pub mod motion;
mod preload;
pub mod replay;
pub mod scene;
pub mod series;
pub mod simulate;
pub mod summary;
