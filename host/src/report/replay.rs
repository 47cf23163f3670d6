//! Pages of predictions.
