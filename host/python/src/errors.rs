//! Exceptions, with the text of the commands: what is wrong, where, and what to do.

use anyhow::Error;
use pyo3::prelude::*;
use pyo3::{PyErr, create_exception, exceptions::PyException};
use stickslip_analysis::model::file::ModelFileError;
use stickslip_analysis::model::names::UnknownEffect;
use stickslip_data::DatasetError;
use stickslip_data::import::recording::RecordingError;
use stickslip_report::terminal::chain;

create_exception!(
    stickslip,
    StickslipError,
    PyException,
    "What stickslip refuses; the text says what to do."
);
create_exception!(
    stickslip,
    DataError,
    StickslipError,
    "A data set or a recording that cannot be read or made."
);
create_exception!(
    stickslip,
    ModelError,
    StickslipError,
    "A model, formula or effect that is wrong or unknown."
);
create_exception!(stickslip, AnalysisError, StickslipError, "An analysis that cannot be made of these data.");

/// The exception of an error, by what caused it.
pub fn raised(error: &Error) -> PyErr {
    let text = chain(error).join(": ");
    // What Python raised itself (a progress callback) stays what it is.
    if let Some(raised) = error.downcast_ref::<PyErr>() {
        return Python::attach(|py| raised.clone_ref(py));
    }
    let any = |of: fn(&(dyn std::error::Error + 'static)) -> bool| error.chain().any(of);
    if any(|e| e.is::<DatasetError>() || e.is::<RecordingError>()) {
        DataError::new_err(text)
    } else if any(|e| e.is::<ModelFileError>() || e.is::<UnknownEffect>()) {
        ModelError::new_err(text)
    } else {
        AnalysisError::new_err(text)
    }
}
