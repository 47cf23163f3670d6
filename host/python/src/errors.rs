//! Exceptions, with the text of the commands: what is wrong, where, and what to do.

use anyhow::Error;
use clap::ValueEnum;
use pyo3::exceptions::{PyException, PyValueError};
use pyo3::prelude::*;
use pyo3::{PyErr, create_exception};
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

/// A word of a list, as on the command line.
pub fn choice<T: ValueEnum>(option: &str, word: &str) -> PyResult<T> {
    T::from_str(word, false).map_err(|_| {
        let names = T::value_variants().iter().filter_map(ValueEnum::to_possible_value);
        let names: Vec<String> = names.map(|value| value.get_name().to_owned()).collect();
        PyValueError::new_err(format!("{option} is {word:?}; give one of {}", names.join(", ")))
    })
}
