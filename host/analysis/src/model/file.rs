//! `model.toml`: contact law, friction and effects as the user writes them, with the
//! intervals that a fit found.
//!
//! Read with every value checked against the effect's description; written so that reading
//! gives the same model back. Intervals are optional sub-tables: `[friction.intervals]`
//! and `intervals = { excess = [0.1, 0.3] }` in an effect.

pub use crate::model::entry::{EffectEntry, FormulaEntry, FormulaParameter, Intervals};
use crate::model::entry::{
    Fault, Table, check_intervals, check_name, entry, quoted, write_formula, write_intervals,
};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use stickslip_shared::effects::{self, Effect, MAX_PARAMETERS, formula};
use stickslip_shared::model::{Base, Formulation, Friction, MAX_EFFECTS, MAX_FORMULAS, Model};
use toml::{Spanned, Value};

/// The one format there is.
pub const FORMAT: &str = "stickslip-model/1";

/// The model in the user's file, or the default model where none is named.
///
/// # Errors
/// Where the file cannot be read or is wrong.
pub fn model_or_default(path: Option<&Path>) -> Result<Model<f64>, ModelFileError> {
    path.map_or_else(|| Ok(default_model()), |path| ModelFile::read(path).map(|file| file.to_model()))
}

/// The hard model without effects, with the coefficients that a user most likely has: where
/// no model is given.
pub fn default_model() -> Model<f64> {
    Model::base(Base::Hard, Friction { finger: 0.4, pusher: 0.25, support: 0.3 })
}

/// A model as its file says it.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelFile {
    /// Base contact law.
    pub base: Base<f64>,
    /// How friction enters the step.
    pub formulation: Formulation,
    /// Whether the other formulation is a witness of each step.
    pub witness: bool,
    /// Coefficients.
    pub friction: Friction<f64>,
    /// Of `finger`, `pusher`, `support`, where known.
    pub friction_intervals: Intervals,
    /// In order of application.
    pub effects: Vec<EffectEntry>,
}

/// What is wrong with a file of a model, or of the predictor's numbers, and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{file}{}: {message}", place(*.line, *.column))]
pub struct ModelFileError {
    /// Path as given.
    pub file: String,
    /// Counted from 1; 0 where the file could not be read at all.
    pub line: usize,
    /// Counted from 1; 0 where the file could not be read at all.
    pub column: usize,
    /// What is wrong and what to do.
    pub message: String,
}

/// `:line:column`, nothing where there is none.
fn place(line: usize, column: usize) -> String {
    if line == 0 { String::new() } else { format!(":{line}:{column}") }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    format: Spanned<String>,
    base: Option<Spanned<String>>,
    formulation: Option<Spanned<String>>,
    #[serde(default)]
    witness: bool,
    soft: Option<Spanned<RawSoft>>,
    friction: Spanned<RawFriction>,
    #[serde(default)]
    effects: Vec<Spanned<BTreeMap<String, Spanned<Value>>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSoft {
    normal_n_m: f64,
    tangential_n_m: f64,
    damping_s: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFriction {
    finger: Spanned<f64>,
    pusher: Spanned<f64>,
    support: Spanned<f64>,
    #[serde(default)]
    intervals: Intervals,
}

/// That of [`default_model`].
impl Default for ModelFile {
    fn default() -> Self {
        let model = default_model();
        Self::new(model.base, model.friction)
    }
}

impl ModelFile {
    /// A model without effects.
    pub fn new(base: Base<f64>, friction: Friction<f64>) -> Self {
        let formulation = Formulation::default();
        Self {
            base,
            formulation,
            witness: false,
            friction,
            friction_intervals: Intervals::new(),
            effects: Vec::new(),
        }
    }

    /// Reads and checks the file.
    pub fn read(path: &Path) -> Result<Self, ModelFileError> {
        let (file, text) = read_text(path)?;
        Self::parse(&text, &file)
    }

    /// The formulas in a file: a model file, or only their `[[effects]]` tables.
    ///
    /// # Errors
    /// Where the file cannot be read or is wrong, or has no formula.
    pub fn read_formulas(path: &Path) -> Result<Vec<EffectEntry>, ModelFileError> {
        #[derive(Deserialize)]
        struct Tables {
            #[serde(default)]
            effects: Vec<Spanned<Table>>,
        }
        let (file, text) = read_text(path)?;
        let locate = |fault| locate(&text, &file, fault);
        let tables: Tables =
            toml::from_str(&text).map_err(|e| locate((e.span().unwrap_or(0..0), e.message().into())))?;
        let mut formulas = Vec::new();
        for table in tables.effects {
            let span = table.span();
            let entry = entry(table.into_inner(), span.clone()).map_err(locate)?;
            check_name(&formulas, &entry).map_err(|m| locate((span, m)))?;
            formulas.extend(entry.formula.is_some().then_some(entry));
        }
        if formulas.is_empty() {
            let message = "no formula in it: an [[effects]] table with id = \"formula\" is expected";
            return Err(ModelFileError { file, line: 0, column: 0, message: message.into() });
        }
        Ok(formulas)
    }

    /// Checks the text; `file` is what errors call it.
    pub fn parse(text: &str, file: &str) -> Result<Self, ModelFileError> {
        let locate = |fault| locate(text, file, fault);
        let raw: Raw =
            toml::from_str(text).map_err(|e| locate((e.span().unwrap_or(0..0), e.message().to_string())))?;
        Self::check(raw).map_err(locate)
    }

    fn check(raw: Raw) -> Result<Self, Fault> {
        if raw.format.get_ref() != FORMAT {
            let message = format!("format '{}' is not known; it must be '{FORMAT}'", raw.format.get_ref());
            return Err((raw.format.span(), message));
        }
        let f = raw.friction.get_ref();
        for (name, mu) in [("finger", &f.finger), ("pusher", &f.pusher), ("support", &f.support)] {
            if !(0.0..=10.0).contains(mu.get_ref()) {
                let message = format!("friction.{name} = {} must lie between 0 and 10", mu.get_ref());
                return Err((mu.span(), message));
            }
        }
        let mut file = Self::new(
            base(&raw)?,
            Friction {
                finger: *f.finger.get_ref(),
                pusher: *f.pusher.get_ref(),
                support: *f.support.get_ref(),
            },
        );
        file.formulation = formulation(&raw)?;
        file.witness = raw.witness;
        check_intervals(&f.intervals, ["finger", "pusher", "support"].into_iter())
            .map_err(|m| (raw.friction.span(), m))?;
        file.friction_intervals = f.intervals.clone();
        if raw.effects.len() > MAX_EFFECTS {
            let span = raw.effects[MAX_EFFECTS].span();
            return Err((span, format!("a model has at most {MAX_EFFECTS} effects")));
        }
        for effect in raw.effects {
            let span = effect.span();
            let entry = entry(effect.into_inner(), span.clone())?;
            check_name(&file.effects, &entry).map_err(|m| (span.clone(), m))?;
            file.effects.push(entry);
            if file.effects.iter().filter(|e| e.formula.is_some()).count() > MAX_FORMULAS {
                return Err((span, format!("a model has at most {MAX_FORMULAS} formulas")));
            }
        }
        Ok(file)
    }

    /// What the predictor runs.
    pub fn to_model(&self) -> Model<f64> {
        let (formulation, witness) = (self.formulation, self.witness);
        let mut model = Model { formulation, witness, ..Model::base(self.base, self.friction) };
        for e in self.effects.iter().take(MAX_EFFECTS) {
            let mut parameters = [0.0; MAX_PARAMETERS];
            for (to, v) in parameters.iter_mut().zip(&e.values) {
                *to = *v;
            }
            let code = match &e.formula {
                Some(f) if model.formulas.push(f.program.clone()).is_ok() => formula::CODE,
                Some(_) => continue,
                None => match effects::find(&e.id) {
                    Some(info) => info.code,
                    None => continue,
                },
            };
            let _ = model.effects.push(Effect { code, parameters });
        }
        model
    }

    /// The model without the formulas that are only proposed, and those.
    pub fn without_proposals(&self) -> (Self, Vec<EffectEntry>) {
        let (proposed, effects) = self.effects.iter().cloned().partition(EffectEntry::is_proposal);
        (Self { effects, ..self.clone() }, proposed)
    }

    /// The same with the formulas of the file `more`, where it is given.
    ///
    /// # Errors
    /// Where `more` cannot be read, or has a formula of a name that the model has.
    pub fn proposals(&self, more: Option<&Path>) -> Result<(Self, Vec<EffectEntry>), ModelFileError> {
        let (file, mut formulas) = self.without_proposals();
        for formula in more.map(Self::read_formulas).transpose()?.into_iter().flatten() {
            if self.effects.iter().any(|e| e.name() == formula.name()) {
                let message =
                    format!("the model has a formula {} too; give one of them another name", formula.name());
                let file = more.map(|path| path.display().to_string()).unwrap_or_default();
                return Err(ModelFileError { file, line: 0, column: 0, message });
            }
            formulas.push(formula);
        }
        Ok((file, formulas))
    }

    /// The file of `model`, whose effects are those of the list and `formulas`.
    pub fn of_model(model: &Model<f64>, formulas: &[EffectEntry]) -> Self {
        let mut programs = model.formulas.iter();
        let entry = |e: &Effect<f64>| -> Option<EffectEntry> {
            if e.code != formula::CODE {
                return e.info().map(EffectEntry::typical);
            }
            let program = programs.next()?;
            let own = formulas.iter().find(|f| f.formula.as_ref().is_some_and(|f| f.program == *program))?;
            Some(EffectEntry { intervals: Intervals::new(), ..own.clone() })
        };
        let mut file = Self::new(model.base, model.friction);
        file.effects = model.effects.iter().filter_map(entry).collect();
        file.set_values(model);
        file
    }

    /// Takes over base, formulation, friction and effect parameters of a fitted model of the same effects.
    pub fn set_values(&mut self, model: &Model<f64>) {
        self.base = model.base;
        self.formulation = model.formulation;
        self.witness = model.witness;
        self.friction = model.friction;
        for (entry, effect) in self.effects.iter_mut().zip(&model.effects) {
            for (to, v) in entry.values.iter_mut().zip(&effect.parameters) {
                *to = *v;
            }
        }
    }

    /// Takes over the intervals of a fit, by [`crate::fit::Free::name`], in place of those it has.
    pub fn set_intervals<'a>(&mut self, of: impl IntoIterator<Item = (&'a str, [f64; 2])>) {
        self.friction_intervals.clear();
        for (name, range) in of {
            let Some((owner, parameter)) = name.split_once('.') else { continue };
            if !range.iter().all(|x| x.is_finite()) {
                continue;
            }
            if owner == "friction" {
                self.friction_intervals.insert(parameter.into(), range);
            } else if let Some(entry) = self.effects.iter_mut().find(|e| e.name() == owner) {
                entry.intervals.insert(parameter.into(), range);
            }
        }
        // Too few conditions give no interval: a formula that is part of the model has its bounds.
        for entry in self.effects.iter_mut().filter(|e| e.is_proposal()) {
            let parameters = entry.formula.iter().flat_map(|f| &f.parameters);
            entry.intervals = parameters.map(|p| (p.name.clone(), [p.low, p.high])).collect();
        }
    }

    /// The file's text; reading it gives `self` back.
    pub fn write(&self) -> String {
        let mut s = format!("format = {}\n", quoted(FORMAT));
        // Writing to a String cannot fail.
        s.push_str(match self.base {
            Base::Hard => "base = \"hard\"\n",
            Base::Soft { .. } => "base = \"soft\"\n",
        });
        if self.formulation == Formulation::Lcp {
            s.push_str("formulation = \"lcp\"\n");
        }
        if self.witness {
            s.push_str("witness = true\n");
        }
        match self.base {
            Base::Hard => {}
            Base::Soft { normal_n_m, tangential_n_m, damping_s } => {
                let _ = writeln!(
                    s,
                    "\n[soft]\nnormal_n_m = {normal_n_m:?}\ntangential_n_m = {tangential_n_m:?}\ndamping_s = {damping_s:?}"
                );
            }
        }
        let Friction { finger, pusher, support } = self.friction;
        let _ = writeln!(s, "\n[friction]\nfinger = {finger:?}\npusher = {pusher:?}\nsupport = {support:?}");
        write_intervals(&mut s, &self.friction_intervals);
        for e in &self.effects {
            let _ = writeln!(s, "\n[[effects]]\nid = {}", quoted(&e.id));
            match &e.formula {
                Some(f) => write_formula(&mut s, f, &e.values),
                None => {
                    let names = effects::find(&e.id).into_iter().flat_map(|i| i.parameters);
                    for (p, v) in names.zip(&e.values) {
                        let _ = writeln!(s, "{} = {v:?}", p.name);
                    }
                }
            }
            write_intervals(&mut s, &e.intervals);
        }
        s
    }
}

/// The file's name and text.
pub(crate) fn read_text(path: &Path) -> Result<(String, String), ModelFileError> {
    let file = path.display().to_string();
    match std::fs::read_to_string(path) {
        Ok(text) => Ok((file, text)),
        Err(e) => Err(ModelFileError { file, line: 0, column: 0, message: format!("cannot be read: {e}") }),
    }
}

/// A fault with its place in the text.
pub(crate) fn locate(text: &str, file: &str, (span, message): Fault) -> ModelFileError {
    let before = text.get(..span.start).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
    ModelFileError { file: file.into(), line, column, message: in_words(message) }
}

/// What a user of the file can do with a message of the parser; ours are as they are.
fn in_words(message: String) -> String {
    if message.starts_with("string values must be quoted") {
        return "neither a number nor a text in quotes: write a number, as 0.4, or \"...\"".into();
    }
    let not_a_number = message.strip_prefix("invalid type: ").and_then(|m| m.strip_suffix(", expected f64"));
    match not_a_number {
        Some(found) => format!("a number is expected, as 0.4, and this is a {found}"),
        None => message,
    }
}

fn formulation(raw: &Raw) -> Result<Formulation, Fault> {
    let Some(name) = &raw.formulation else { return Ok(Formulation::default()) };
    match name.get_ref().as_str() {
        "cone" => Ok(Formulation::Cone),
        "lcp" => Ok(Formulation::Lcp),
        other => {
            let message = format!("formulation '{other}' is not known; it is \"cone\" or \"lcp\"");
            Err((name.span(), message))
        }
    }
}

fn base(raw: &Raw) -> Result<Base<f64>, Fault> {
    let name = raw.base.as_ref().map_or("", |b| b.get_ref().as_str());
    let span = raw.base.as_ref().map_or(raw.format.span(), Spanned::span);
    match (name, &raw.soft) {
        ("hard", None) => Ok(Base::Hard),
        ("soft" | "", Some(soft)) => {
            let s = soft.get_ref();
            let positive = |x: f64| x.is_finite() && x > 0.0;
            let good = positive(s.normal_n_m)
                && positive(s.tangential_n_m)
                && s.damping_s >= 0.0
                && s.damping_s.is_finite();
            if !good {
                let message = "[soft]: stiffnesses must be above 0 and damping_s not negative";
                return Err((soft.span(), message.into()));
            }
            Ok(Base::Soft {
                normal_n_m: s.normal_n_m,
                tangential_n_m: s.tangential_n_m,
                damping_s: s.damping_s,
            })
        }
        ("hard", Some(soft)) => {
            Err((soft.span(), "base = \"hard\" and [soft] exclude each other; remove one".into()))
        }
        ("soft", None) => Err((
            span,
            "base = \"soft\" needs a [soft] table with normal_n_m, tangential_n_m and damping_s".into(),
        )),
        ("", None) => {
            Err((span, "the contact law is missing: write base = \"hard\" or a [soft] table".into()))
        }
        (other, _) => Err((span, format!("base '{other}' is not known; it is \"hard\" or \"soft\""))),
    }
}
