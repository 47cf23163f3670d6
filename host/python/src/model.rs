//! Models for Python: a model file in memory.

use std::path::PathBuf;

use pyo3::prelude::*;
use stickslip_analysis::compare::NamedModel;
use stickslip_analysis::model::candidate::CandidateEffect;
use stickslip_analysis::model::file::{EffectEntry, ModelFile};

use crate::errors::raised;

/// A contact model as its file has it; does not change.
#[pyclass(frozen, module = "stickslip._stickslip")]
pub struct Model {
    pub(crate) file: ModelFile,
    name: String,
    origin: String,
}

impl Model {
    /// Made by an analysis.
    pub(crate) fn made(file: ModelFile, name: &str) -> Self {
        Self { file, name: name.to_owned(), origin: "made by stickslip".to_owned() }
    }

    /// As `compare` takes it.
    pub(crate) fn named(&self) -> NamedModel {
        NamedModel::own(self.name.clone(), self.origin.clone(), self.file.to_model())
    }
}

/// The file of `model`, or the default one.
pub(crate) fn file_of(model: Option<&Model>) -> ModelFile {
    model.map_or_else(ModelFile::default, |model| model.file.clone())
}

/// Formulas as candidates.
pub(crate) fn candidates(formulas: &[EffectEntry]) -> Vec<CandidateEffect> {
    formulas.iter().filter_map(CandidateEffect::of).collect()
}

#[pymethods]
impl Model {
    /// The default model: hard contact, friction 0.40 (fingers), 0.25 (pusher), 0.30 (support).
    #[staticmethod]
    fn default() -> Self {
        Self { file: file_of(None), name: "default".into(), origin: "default".into() }
    }

    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Self> {
        let file = ModelFile::read(&path).map_err(|error| raised(&error.into()))?;
        let name = path.file_stem().map_or_else(|| "model".into(), |s| s.to_string_lossy().into_owned());
        Ok(Self { file, name, origin: path.display().to_string() })
    }

    #[staticmethod]
    fn parse(text: &str, name: &str) -> PyResult<Self> {
        let file = ModelFile::parse(text, name).map_err(|error| raised(&error.into()))?;
        Ok(Self { file, name: name.to_owned(), origin: "text".into() })
    }

    fn called(&self, name: &str) -> Self {
        Self { file: self.file.clone(), name: name.to_owned(), origin: self.origin.clone() }
    }

    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// Coefficients by contact.
    #[getter]
    fn friction(&self) -> [(&'static str, f64); 3] {
        let f = self.file.friction;
        [("finger", f.finger), ("pusher", f.pusher), ("support", f.support)]
    }

    /// Intervals of the coefficients, where known.
    #[getter]
    fn friction_intervals(&self) -> Vec<(String, [f64; 2])> {
        self.file.friction_intervals.iter().map(|(name, interval)| (name.clone(), *interval)).collect()
    }

    /// Effects in order of application, each with its parameters.
    #[getter]
    fn effects(&self) -> Vec<(String, Vec<(String, f64)>)> {
        let parameters = |entry: &EffectEntry| {
            let named = entry.info().map(|info| info.parameters).unwrap_or_default();
            named.iter().zip(&entry.values).map(|(p, value)| (p.name.to_owned(), *value)).collect()
        };
        self.file.effects.iter().map(|entry| (entry.name().to_owned(), parameters(entry))).collect()
    }

    /// The text of its file.
    fn text(&self) -> String {
        self.file.write()
    }
}
