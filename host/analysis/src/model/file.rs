//! `model.toml`: contact law, friction and effects as the user writes them, with the
//! intervals that a fit found.
//!
//! Read with every value checked against the effect's description; written so that reading
//! gives the same model back. Intervals are optional sub-tables: `[friction.intervals]`
//! and `intervals = { excess = [0.1, 0.3] }` in an effect.
//!
//! Above 600 lines: reading, checking and writing of one format, which must agree key by key.

use crate::model::expression;
use crate::model::names;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::ops::Range;
use std::path::Path;
use stickslip_shared::effects::formula::{
    FORMULA_PARAMETERS, Formula, FormulaError, MAX_OPS, MAX_STACK, Op, Target, Variable,
};
use stickslip_shared::effects::{self, Effect, Info, MAX_PARAMETERS, Parameter, formula};
use stickslip_shared::model::{Base, Friction, MAX_EFFECTS, MAX_FORMULAS, Model};
use toml::{Spanned, Value};

/// The one format there is.
pub const FORMAT: &str = "stickslip-model/1";

/// Lowest and highest value that the data allow, by parameter name.
pub type Intervals = BTreeMap<String, [f64; 2]>;

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
    /// Coefficients.
    pub friction: Friction<f64>,
    /// Of `finger`, `pusher`, `support`, where known.
    pub friction_intervals: Intervals,
    /// In order of application.
    pub effects: Vec<EffectEntry>,
}

/// One `[[effects]]` table.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectEntry {
    /// Identifier of the registry, or `formula`.
    pub id: String,
    /// In the order of the effect's description, or of the formula's own.
    pub values: Vec<f64>,
    /// Where known.
    pub intervals: Intervals,
    /// For `formula` only.
    pub formula: Option<FormulaEntry>,
}

impl EffectEntry {
    /// An effect of the list with its typical parameters.
    pub fn typical(info: &Info) -> Self {
        let values = info.parameters.iter().map(|p| p.typical).collect();
        Self { id: info.id.into(), values, intervals: Intervals::new(), formula: None }
    }

    /// What people call it: the identifier of a listed effect, the user's name of a formula.
    pub fn name(&self) -> &str {
        self.formula.as_ref().map_or(&self.id, |f| &f.name)
    }

    /// A formula that was never fitted (its parameters have no intervals) is a proposal: `diagnose`
    /// tries it, `add` makes it part of the model.
    pub fn is_proposal(&self) -> bool {
        self.intervals.is_empty() && self.formula.as_ref().is_some_and(|f| !f.parameters.is_empty())
    }

    /// Description of the effect: of the list, or of the user's formula (its first parameter
    /// taken as the strength, zero where that is allowed as its absence; kept for the rest of
    /// the program).
    pub fn info(&self) -> Option<&'static Info> {
        let Some(f) = &self.formula else { return effects::find(&self.id) };
        let keep = |text: &str| -> &'static str { Box::leak(text.to_string().into_boxed_str()) };
        let each = f.parameters.iter().zip(&self.values).enumerate();
        let parameters: Vec<Parameter> = each
            .map(|(k, (p, value))| {
                let neutral = if k == 0 { 0.0_f64.clamp(p.low, p.high) } else { *value };
                let typical = if k == 0 && *value == neutral { 0.5 * (neutral + p.high) } else { *value };
                let bounds = [p.low, p.high];
                Parameter::new(
                    keep(&p.name),
                    keep(&p.unit),
                    typical,
                    neutral,
                    bounds,
                    "of the user's formula",
                )
            })
            .collect();
        Some(Box::leak(Box::new(Info {
            id: keep(&f.name),
            summary: keep(&format!("the user's formula for {}: {}", target_name(f), f.expression)),
            signature: "as the formula says",
            parameters: Box::leak(parameters.into_boxed_slice()),
            ..formula::INFO
        })))
    }
}

/// The user's own effect.
#[derive(Clone, Debug, PartialEq)]
pub struct FormulaEntry {
    /// The user's name for it.
    pub name: String,
    /// As written.
    pub expression: String,
    /// The next value of its memory, as written.
    pub state: Option<String>,
    /// Names, bounds and units, in the order of `EffectEntry::values`.
    pub parameters: Vec<FormulaParameter>,
    /// What runs.
    pub program: Formula<f64>,
}

/// A parameter of a formula; its value is in `EffectEntry::values`.
#[derive(Clone, Debug, PartialEq)]
pub struct FormulaParameter {
    /// Name in the expression.
    pub name: String,
    /// Smallest value a fit may try.
    pub low: f64,
    /// Largest.
    pub high: f64,
    /// As people write it.
    pub unit: String,
}

/// What is wrong with a model file and where.
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

/// Where in the text, and what.
type Fault = (Range<usize>, String);

const TARGETS: [(&str, Target); 5] = [
    ("friction", Target::Friction),
    ("grip", Target::Grip),
    ("force_x", Target::ForceX),
    ("force_y", Target::ForceY),
    ("force_z", Target::ForceZ),
];
const BODIES: [&str; 4] = ["finger1", "finger2", "pusher", "support"];

impl ModelFile {
    /// A model without effects.
    pub fn new(base: Base<f64>, friction: Friction<f64>) -> Self {
        Self { base, friction, friction_intervals: Intervals::new(), effects: Vec::new() }
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
        let mut model = Model::base(self.base, self.friction);
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

    /// Takes over base, friction and effect parameters of a fitted model of the same effects.
    pub fn set_values(&mut self, model: &Model<f64>) {
        self.base = model.base;
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
        match self.base {
            Base::Hard => s.push_str("base = \"hard\"\n"),
            Base::Soft { normal_n_m, tangential_n_m, damping_s } => {
                let _ = writeln!(
                    s,
                    "base = \"soft\"\n\n[soft]\nnormal_n_m = {normal_n_m:?}\ntangential_n_m = {tangential_n_m:?}\ndamping_s = {damping_s:?}"
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

fn read_text(path: &Path) -> Result<(String, String), ModelFileError> {
    let file = path.display().to_string();
    match std::fs::read_to_string(path) {
        Ok(text) => Ok((file, text)),
        Err(e) => Err(ModelFileError { file, line: 0, column: 0, message: format!("cannot be read: {e}") }),
    }
}

fn locate(text: &str, file: &str, (span, message): Fault) -> ModelFileError {
    let before = text.get(..span.start).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
    ModelFileError { file: file.into(), line, column, message }
}

fn quoted(text: &str) -> String {
    Value::String(text.into()).to_string()
}

fn write_intervals(s: &mut String, intervals: &Intervals) {
    if !intervals.is_empty() {
        let each: Vec<String> =
            intervals.iter().map(|(n, [l, h])| format!("{} = [{l:?}, {h:?}]", quoted(n))).collect();
        let _ = writeln!(s, "intervals = {{ {} }}", each.join(", "));
    }
}

fn target_name(f: &FormulaEntry) -> &'static str {
    TARGETS.iter().find(|(_, t)| *t == f.program.target).map_or("friction", |(name, _)| name)
}

fn write_formula(s: &mut String, f: &FormulaEntry, values: &[f64]) {
    let _ = writeln!(s, "name = {}\ntarget = {}", quoted(&f.name), quoted(target_name(f)));
    if f.program.bodies != Formula::<f64>::ALL_BODIES {
        let bodies = BODIES.iter().enumerate().filter(|(k, _)| f.program.bodies & (1 << k) != 0);
        let bodies: Vec<String> = bodies.map(|(_, b)| quoted(b)).collect();
        let _ = writeln!(s, "bodies = [{}]", bodies.join(", "));
    }
    let _ = writeln!(s, "expression = {}", quoted(&f.expression));
    if let Some(state) = &f.state {
        let _ = writeln!(s, "state = {}", quoted(state));
    }
    let each: Vec<String> = f
        .parameters
        .iter()
        .zip(values)
        .map(|(p, v)| {
            let (name, unit) = (quoted(&p.name), quoted(&p.unit));
            format!("{name} = {{ value = {v:?}, low = {:?}, high = {:?}, unit = {unit} }}", p.low, p.high)
        })
        .collect();
    let _ = writeln!(s, "parameters = {{ {} }}", each.join(", "));
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

fn check_intervals<'a>(
    intervals: &Intervals,
    names: impl Iterator<Item = &'a str> + Clone,
) -> Result<(), String> {
    for (name, [low, high]) in intervals {
        if !names.clone().any(|n| n == name) {
            return Err(format!("intervals: no parameter '{name}' here"));
        }
        if !(low.is_finite() && high.is_finite() && low <= high) {
            return Err(format!("intervals: {name} = [{low}, {high}] must be two finite numbers in order"));
        }
    }
    Ok(())
}

/// Effects are called by name on the command line: a formula's must be its own.
fn check_name(before: &[EffectEntry], entry: &EffectEntry) -> Result<(), String> {
    if entry.formula.is_none() {
        return Ok(());
    }
    let name = entry.name();
    if effects::find(name).is_some() {
        return Err(format!("name = '{name}' is that of a listed effect; give the formula another"));
    }
    if before.iter().any(|e| e.name() == name) {
        return Err(format!("name = '{name}' is given to two formulas; give one of them another"));
    }
    Ok(())
}

type Table = BTreeMap<String, Spanned<Value>>;

fn number(value: &Spanned<Value>, name: &str) -> Result<f64, Fault> {
    match value.get_ref() {
        Value::Float(x) if x.is_finite() => Ok(*x),
        Value::Integer(x) => Ok(*x as f64),
        other => Err((value.span(), format!("{name} = {other} must be a finite number"))),
    }
}

fn text(table: &mut Table, key: &str, span: &Range<usize>) -> Result<(String, Range<usize>), Fault> {
    let value = table.remove(key).ok_or_else(|| (span.clone(), format!("the effect lacks '{key}'")))?;
    let at = value.span();
    match value.into_inner() {
        Value::String(s) => Ok((s, at)),
        other => Err((at, format!("{key} = {other} must be a string"))),
    }
}

fn entry(mut table: Table, span: Range<usize>) -> Result<EffectEntry, Fault> {
    let (id, id_span) = text(&mut table, "id", &span)?;
    let intervals = match table.remove("intervals") {
        None => Intervals::new(),
        Some(v) => {
            let at = v.span();
            v.into_inner()
                .try_into()
                .map_err(|e| (at, format!("intervals must be name = [low, high]: {e}")))?
        }
    };
    let names: Vec<String>;
    let (values, formula) = if id == "formula" {
        let (entry, values) = formula_entry(&mut table, &span)?;
        names = entry.parameters.iter().map(|p| p.name.clone()).collect();
        (values, Some(entry))
    } else {
        let info = effects::find(&id)
            .ok_or_else(|| (id_span, names::unknown(&id, names::listed().chain(["formula"]))))?;
        let mut values = Vec::new();
        for p in info.parameters {
            let value = table.remove(p.name).ok_or_else(|| {
                (
                    span.clone(),
                    format!("effect '{id}' lacks its parameter {} ({}; {})", p.name, p.unit, p.what),
                )
            })?;
            let x = number(&value, p.name)?;
            if !(p.low..=p.high).contains(&x) {
                let message =
                    format!("{} = {x} {} must lie between {} and {}", p.name, p.unit, p.low, p.high);
                return Err((value.span(), message));
            }
            values.push(x);
        }
        names = info.parameters.iter().map(|p| p.name.to_string()).collect();
        (values, None)
    };
    if let Some((key, value)) = table.iter().next() {
        let message = format!("effect '{id}' has no parameter '{key}'; it has {}", names.join(", "));
        return Err((value.span(), message));
    }
    check_intervals(&intervals, names.iter().map(String::as_str)).map_err(|m| (span, m))?;
    Ok(EffectEntry { id, values, intervals, formula })
}

fn formula_entry(table: &mut Table, span: &Range<usize>) -> Result<(FormulaEntry, Vec<f64>), Fault> {
    let (name, _) = text(table, "name", span)?;
    let (target, at) = text(table, "target", span)?;
    let target = TARGETS.iter().find(|(n, _)| *n == target).map(|(_, t)| *t).ok_or_else(|| {
        let known = TARGETS.map(|(n, _)| n).join(", ");
        (at, format!("target '{target}' is not known; it is one of {known}"))
    })?;
    let bodies = match table.remove("bodies") {
        None => Formula::<f64>::ALL_BODIES,
        Some(list) => bodies(&list)?,
    };
    let (parameters, values) = match table.remove("parameters") {
        None => (Vec::new(), Vec::new()),
        Some(p) => formula_parameters(&p)?,
    };
    let names: Vec<String> = parameters.iter().map(|p| p.name.clone()).collect();
    let (expression, at) = text(table, "expression", span)?;
    let ops = operations("expression", &expression, &at, &names)?;
    let mut program = Formula::new(target, bodies, &ops)
        .map_err(|e| (at.clone(), refused("expression", &expression, &ops, e)))?;
    let mut state = None;
    if table.contains_key("state") {
        let (next, at) = text(table, "state", span)?;
        let ops = operations("state", &next, &at, &names)?;
        program = program.with_state(&ops).map_err(|e| (at, refused("state", &next, &ops, e)))?;
        state = Some(next);
    } else if program.program.reads(Variable::State) {
        let help = "add state = \"...\", the next value of what the formula remembers (it begins at 0)";
        return Err((
            at,
            format!("expression \"{expression}\" reads state, which the formula lacks; {help}"),
        ));
    }
    // The first step of any trial: nothing has moved, no load is known yet.
    let mut first = [0.0; Variable::NAMES.len()];
    first[Variable::Step as usize] = 0.004;
    let mut parameters_now = [0.0; MAX_PARAMETERS];
    parameters_now.iter_mut().zip(&values).for_each(|(to, v)| *to = *v);
    if program.remembers() {
        first[Variable::State as usize] = program
            .state
            .evaluate(&parameters_now, &first)
            .map_err(|fault| (at.clone(), no_value("state", state.as_deref().unwrap_or_default(), fault)))?;
    }
    program
        .program
        .evaluate(&parameters_now, &first)
        .map_err(|fault| (at, no_value("expression", &expression, fault)))?;
    Ok((FormulaEntry { name, expression, state, parameters, program }, values))
}

fn operations(
    key: &str,
    expression: &str,
    at: &Range<usize>,
    names: &[String],
) -> Result<Vec<Op<f64>>, Fault> {
    expression::parse(expression, names).map_err(|e| (at.clone(), format!("{key} \"{expression}\", {e}")))
}

fn refused(key: &str, expression: &str, ops: &[Op<f64>], error: FormulaError) -> String {
    let why = match error {
        FormulaError::TooLong => format!("has {} operations; at most {MAX_OPS} fit the board", ops.len()),
        FormulaError::TooDeep => {
            format!("needs more than {MAX_STACK} intermediate results; split or reorder it")
        }
        FormulaError::Malformed => "is malformed".into(),
    };
    format!("{key} \"{expression}\" {why}")
}

fn no_value(key: &str, expression: &str, fault: formula::Fault) -> String {
    let why = match fault {
        formula::Fault::DivisionByZero => "divides by zero",
        formula::Fault::Domain => "takes a root, power or logarithm that does not exist",
        formula::Fault::Overflow => "exceeds the largest number",
        formula::Fault::Malformed => "is malformed",
    };
    format!(
        "{key} \"{expression}\" {why} in the first step of a trial, where slip, load, rates, time and trial \
         are 0; bound what it divides by, as in max(load_n, 0.1)"
    )
}

fn bodies(list: &Spanned<Value>) -> Result<u8, Fault> {
    let fault = |what: String| (list.span(), format!("{what}; bodies is a list of {}", BODIES.join(", ")));
    let names = list.get_ref().as_array().ok_or_else(|| fault("not a list".into()))?;
    let mut mask = 0;
    for name in names {
        let k = BODIES.iter().position(|b| name.as_str() == Some(b));
        mask |= 1 << k.ok_or_else(|| fault(format!("{name} is no body")))?;
    }
    if mask == 0 { Err(fault("empty".into())) } else { Ok(mask) }
}

fn formula_parameters(table: &Spanned<Value>) -> Result<(Vec<FormulaParameter>, Vec<f64>), Fault> {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct RawParameter {
        value: f64,
        low: f64,
        high: f64,
        #[serde(default)]
        unit: String,
    }
    let fault = |what: String| (table.span(), what);
    let raw: BTreeMap<String, RawParameter> = table
        .get_ref()
        .clone()
        .try_into()
        .map_err(|e| fault(format!("parameters must be name = {{ value, low, high, unit }}: {e}")))?;
    if raw.len() > FORMULA_PARAMETERS {
        return Err(fault(format!("a formula has at most {FORMULA_PARAMETERS} parameters")));
    }
    let mut parameters = Vec::new();
    let mut values = Vec::new();
    for (name, RawParameter { value, low, high, unit }) in raw {
        if !(low <= value && value <= high && low.is_finite() && high.is_finite()) {
            return Err(fault(format!("{name} = {value} must lie between its low {low} and high {high}")));
        }
        parameters.push(FormulaParameter { name, low, high, unit });
        values.push(value);
    }
    Ok((parameters, values))
}
