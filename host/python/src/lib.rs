//! The analyses for Python: the native part of the package `stickslip` (`host/python/python/stickslip`).
//!
//! Here: data sets, models, the predictor over samples as they come and the facade's functions, their reports as
//! the JSON documents of the commands, and what runs them ([`run`]) without the interpreter's lock and so that
//! Ctrl-C stops them. The package in Python gives reports attributes, takes pandas tables, and has the docstrings
//! that users read.

mod analyses;
mod dataset;
mod errors;
mod live;
mod model;
mod recording;
mod report;
mod run;

use std::ffi::OsString;
use std::process::ExitCode;

use pyo3::prelude::*;

/// The command `stickslip` with these words; its exit code.
#[pyfunction]
fn command(py: Python<'_>, words: Vec<OsString>) -> u8 {
    let words = std::iter::once("stickslip".into()).chain(words);
    py.detach(|| u8::from(stickslip_cli::commands::main_of(words) != ExitCode::SUCCESS))
}

/// The native part of `stickslip`.
#[pymodule]
mod _stickslip {
    #[pymodule_export]
    use crate::analyses::{
        add, calibrate, check, compare, diagnose, effect_names, refit, replay, score, simulate, suggest,
    };
    #[pymodule_export]
    use crate::dataset::Dataset;
    #[pymodule_export]
    use crate::errors::{AnalysisError, DataError, ModelError, StickslipError};
    #[pymodule_export]
    use crate::live::{FingerPrediction, Prediction, Predictor};
    #[pymodule_export]
    use crate::model::Model;
    #[pymodule_export]
    use crate::recording::import_recording;
    #[pymodule_export]
    use crate::report::Report;

    #[pymodule_export]
    use super::command;
    use super::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
