//! Data sets for Python: from a folder, from a recording by its mapping, from arrays.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stickslip_analysis::Progress;
use stickslip_analysis::evidence::sensors;
use stickslip_data::error::{DatasetError, Problem, join_warnings};
use stickslip_data::memory::{Columns, filled, from_memory, rig};
use stickslip_data::{Dataset as Data, Index, Stage, TrialInfo, Warning, write_as};

use crate::errors::{choice, raised};
use crate::run::watched;

/// A data set; does not change. Of a folder, trials are read when they are needed.
#[pyclass(frozen, module = "stickslip._stickslip")]
pub struct Dataset {
    pub(crate) index: Arc<Index>,
    notes: Vec<String>,
    /// All trials, once an analysis needed them at once, and what was refused of them.
    whole: Whole,
}

/// All good trials, and what was refused.
type Whole = Arc<Mutex<Option<(Arc<Data>, Vec<String>)>>>;

/// A column of a table: its name, its values.
type Column<'py> = (String, PyReadonlyArray1<'py, f64>);

impl Dataset {
    pub(crate) fn of(index: Index, warnings: Vec<Warning>) -> Self {
        let warnings = warnings.into_iter().chain(index.warnings.iter().cloned());
        let mut notes: Vec<String> = join_warnings(warnings).iter().map(ToString::to_string).collect();
        notes.extend(sensors::unstated(&index.description).sentence());
        Self { index: Arc::new(index), notes, whole: Whole::default() }
    }

    /// A rig without trials. Nothing is measured against its sensors: what is stated of them does not matter.
    fn of_rig(text: &str, file: &str) -> PyResult<Self> {
        let (index, warnings) = rig(text, Path::new(file)).map_err(|error| raised(&error.into()))?;
        let notes = join_warnings(warnings).iter().map(ToString::to_string).collect();
        Ok(Self { index: Arc::new(index), notes, whole: Whole::default() })
    }

    /// All good trials, read once.
    pub(crate) fn whole(&self) -> impl FnOnce(&dyn Progress) -> Arc<Data> + Send + 'static {
        let (index, kept) = (Arc::clone(&self.index), Arc::clone(&self.whole));
        move |progress| {
            if let Some((data, _)) = &*kept.lock().unwrap_or_else(PoisonError::into_inner) {
                return Arc::clone(data);
            }
            progress.begin("reading", index.trials.len());
            let mut refused = Vec::new();
            let mut trials = Vec::with_capacity(index.trials.len());
            for info in &index.trials {
                let reading = index.read_trial_lenient(info);
                refused.extend(reading.refusal());
                trials.extend(reading.trial);
                progress.step(1);
            }
            let (folder, description) = (index.folder.clone(), index.description.clone());
            let data = Arc::new(Data { folder, description, trials });
            *kept.lock().unwrap_or_else(PoisonError::into_inner) = Some((Arc::clone(&data), refused));
            data
        }
    }
}

#[pymethods]
impl Dataset {
    #[staticmethod]
    fn open(py: Python<'_>, folder: PathBuf) -> PyResult<Self> {
        let index = watched(py, None, move |_| Ok(Index::open(&folder)?))?;
        Ok(Self::of(index, Vec::new()))
    }

    /// The text of dataset.toml as JSON, that of trials.csv, and the tables by trial.
    #[staticmethod]
    fn from_memory(
        py: Python<'_>,
        description: &str,
        rows: &str,
        tables: Vec<(String, Vec<Column<'_>>)>,
    ) -> PyResult<Self> {
        let description = as_toml(description)?;
        let mut views = Vec::with_capacity(tables.len());
        for (trial, columns) in &tables {
            let mut seen = Vec::with_capacity(columns.len());
            for (name, values) in columns {
                // Contiguous: the package sees to it.
                seen.push((name.as_str(), values.as_slice()?));
            }
            views.push(Columns { trial, columns: seen });
        }
        let (index, warnings) =
            py.detach(|| from_memory(&description, rows, &views)).map_err(|error| raised(&error.into()))?;
        Ok(Self::of(index, warnings))
    }

    /// The rig of a dataset.toml, without trials.
    #[staticmethod]
    fn rig_of_file(file: PathBuf) -> PyResult<Self> {
        let text = std::fs::read_to_string(&file)
            .map_err(|error| raised(&DatasetError::of_file(&file, Problem::Io(error.to_string())).into()))?;
        Self::of_rig(&text, &file.display().to_string())
    }

    /// The same of the text of dataset.toml as JSON.
    #[staticmethod]
    fn rig_of_description(description: &str) -> PyResult<Self> {
        Self::of_rig(&as_toml(description)?, "dataset.toml")
    }

    #[getter]
    fn name(&self) -> &str {
        &self.index.description.name
    }

    #[getter]
    fn folder(&self) -> PathBuf {
        self.index.folder.clone()
    }

    /// What is worth knowing of it.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// What was refused so far.
    #[getter]
    fn refused(&self) -> Vec<String> {
        let rows = self.index.errors.iter().map(ToString::to_string);
        let whole = self.whole.lock().unwrap_or_else(PoisonError::into_inner);
        rows.chain(whole.iter().flat_map(|(_, refused)| refused.clone())).collect()
    }

    /// dataset.toml as JSON.
    #[getter]
    fn description(&self) -> String {
        serde_json::to_string(&self.index.description).unwrap_or_default()
    }

    /// Trials with their conditions, in order.
    fn trials<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.index.trials.iter().map(|info| conditions(py, info)).collect()
    }

    /// Filled columns of a trial; NaN: not measured.
    fn columns<'py>(&self, py: Python<'py>, trial: Option<String>) -> PyResult<Bound<'py, PyDict>> {
        let index = Arc::clone(&self.index);
        let read = watched(py, None, move |_| {
            let (_, info) = index.find(trial.as_deref())?;
            Ok(filled(&index.read_trial(info)?))
        })?;
        let columns = PyDict::new(py);
        for (name, values) in read {
            columns.set_item(name, PyArray1::from_vec(py, values))?;
        }
        Ok(columns)
    }

    /// Writes it into a folder that is new or empty.
    fn write(&self, py: Python<'_>, folder: PathBuf, tables: &str) -> PyResult<()> {
        let tables = choice("tables", tables)?;
        let whole = self.whole();
        watched(py, None, move |progress| {
            let data = whole(progress);
            let stage = Stage::begin(&folder)?;
            write_as(&data, stage.folder(), tables)?;
            Ok(stage.finish()?)
        })
    }
}

/// The text of dataset.toml from its JSON.
fn as_toml(description: &str) -> PyResult<String> {
    let refuse = |error: anyhow::Error| raised(&error.context("the description cannot be written as TOML"));
    let value: toml::Value = serde_json::from_str(description).map_err(|e| refuse(e.into()))?;
    toml::to_string(&value).map_err(|e| refuse(e.into()))
}

fn conditions<'py>(py: Python<'py>, info: &TrialInfo) -> PyResult<Bound<'py, PyDict>> {
    let row = PyDict::new(py);
    row.set_item("trial", &info.trial)?;
    row.set_item("object", &info.object)?;
    row.set_item("primitive", &info.primitive)?;
    for (name, value) in [
        ("grip_n", info.grip_n),
        ("speed_m_s", info.speed_m_s),
        ("speed_rad_s", info.speed_rad_s),
        ("slope_rad", info.slope_rad),
        ("pusher_offset_m", info.pusher_offset_m),
    ] {
        row.set_item(name, value)?;
    }
    row.set_item("run", info.run)?;
    if let Some(pose) = info.pusher {
        let [x, y, z] = pose.position_m;
        let [qw, qx, qy, qz] = pose.quaternion;
        for (name, value) in
            ["x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"].iter().zip([x, y, z, qw, qx, qy, qz])
        {
            row.set_item(format!("pusher_{name}"), value)?;
        }
    }
    for (name, text) in &info.extra {
        row.set_item(name, text)?;
    }
    Ok(row)
}
