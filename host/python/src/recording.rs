//! A recording of any laboratory, imported by its mapping.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use serde_json::json;
use stickslip_analysis::check;
use stickslip_data::Dataset as Data;
use stickslip_data::import::recording;
use stickslip_report::import::page;
use stickslip_report::signals::first_of_each;

use crate::dataset::Dataset;
use crate::errors::raised;
use crate::report::Report;
use crate::run::watched;

/// A recording by its mapping file, and what was assumed of it; its page is that of `import recording`.
#[pyfunction]
pub fn import_recording(py: Python<'_>, mapping: PathBuf) -> PyResult<(Dataset, Report)> {
    let mut import = watched(py, None, move |_| Ok(recording::import(&mapping)?))?;
    let recording::Import { signals, refused, bad_rows, tares, offsets, noise, in_time_order, .. } = &import;
    let report = Report::untitled(&json!({
        "signals": signals, "refused": refused, "bad_rows": bad_rows, "tares": tares, "offsets": offsets,
        "noise": noise, "in_time_order": in_time_order
    }))
    .map_err(|error| raised(&error))?;
    // The page shows some trials; the data set has them all.
    let some = first_of_each(&import.dataset.trials);
    let trials = std::mem::replace(&mut import.dataset.trials, some);
    let dataset = Data {
        folder: import.dataset.folder.clone(),
        description: import.dataset.description.clone(),
        trials,
    };
    let data = Dataset::of(dataset.into(), Vec::new());
    let index = Arc::clone(&data.index);
    let report =
        report.page(move || page("import", &import, &check(&index, &()), "stickslip.calibrate(data)"));
    Ok((data, report))
}
