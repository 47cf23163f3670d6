//! What an analysis returns: the document of the command of its name, and what is made of it when asked for.

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;
use stickslip_analysis::model::file::ModelFile;
use stickslip_data::Dataset as Data;
use stickslip_data::series::{Series, Values};
use stickslip_report::terminal::with_schema;

use crate::dataset::Dataset;
use crate::model::Model;
use crate::run::watched;

/// Makes something of a report when it is asked for.
pub(crate) type Later<T> = Box<dyn Fn() -> T + Send + Sync>;

/// What an analysis returns.
#[pyclass(frozen, module = "stickslip._stickslip")]
pub struct Report {
    document: String,
    page: Option<std::sync::Arc<Later<String>>>,
    series: Option<std::sync::Arc<Later<anyhow::Result<Series>>>>,
    models: Vec<(ModelFile, String)>,
    data: Option<std::sync::Mutex<Option<Data>>>,
}

impl Report {
    /// The document of the command `name`.
    pub(crate) fn new<T: Serialize + ?Sized>(name: &str, document: &T) -> anyhow::Result<Self> {
        Self::of(Some(&format!("stickslip-{name}/1")), document)
    }

    /// A document that no command prints as it is.
    pub(crate) fn untitled<T: Serialize + ?Sized>(document: &T) -> anyhow::Result<Self> {
        Self::of(None, document)
    }

    fn of<T: Serialize + ?Sized>(schema: Option<&str>, document: &T) -> anyhow::Result<Self> {
        let document = with_schema(schema, document)?;
        Ok(Self { document, page: None, series: None, models: Vec::new(), data: None })
    }

    /// With a page.
    pub(crate) fn page(self, page: impl Fn() -> String + Send + Sync + 'static) -> Self {
        Self { page: Some(std::sync::Arc::new(Box::new(page))), ..self }
    }

    /// With columns over time.
    pub(crate) fn series(self, series: impl Fn() -> anyhow::Result<Series> + Send + Sync + 'static) -> Self {
        Self { series: Some(std::sync::Arc::new(Box::new(series))), ..self }
    }

    /// With one more model, called `name`.
    pub(crate) fn model(mut self, model: ModelFile, name: &str) -> Self {
        self.models.push((model, name.to_owned()));
        self
    }

    /// With a data set that was made.
    pub(crate) fn data(self, data: Data) -> Self {
        Self { data: Some(std::sync::Mutex::new(Some(data))), ..self }
    }
}

#[pymethods]
impl Report {
    /// The JSON document.
    #[getter]
    fn json(&self) -> &str {
        &self.document
    }

    /// Has it a page?
    #[getter]
    fn has_page(&self) -> bool {
        self.page.is_some()
    }

    /// The page, HTML.
    fn html(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let Some(page) = self.page.clone() else { return Ok(None) };
        watched(py, None, move |_| Ok(page())).map(Some)
    }

    /// The models that were made.
    fn models(&self) -> Vec<Model> {
        self.models.iter().map(|(file, name)| Model::made(file.clone(), name)).collect()
    }

    /// The data set that was made; handed over once.
    fn take_data(&self) -> Option<Dataset> {
        let data = self.data.as_ref()?.lock().ok()?.take()?;
        Some(Dataset::of(data.into(), Vec::new()))
    }

    /// Columns over time as arrays of numbers or lists of words.
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(series) = self.series.clone() else { return Ok(None) };
        let series = watched(py, None, move |_| series())?;
        let columns = PyDict::new(py);
        for (name, values) in series.columns {
            match values {
                Values::Numbers(values) => columns.set_item(name, PyArray1::from_vec(py, values))?,
                Values::Words(words) => columns.set_item(name, words)?,
            }
        }
        Ok(Some(columns))
    }
}
