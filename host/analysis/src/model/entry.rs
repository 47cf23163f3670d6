//! One `[[effects]]` table of a model file: a listed effect, or the user's formula. Read with every value
//! checked against the effect's description, and written so that reading gives it back.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use serde::Deserialize;
use stickslip_data::spelling::did_you_mean;
use stickslip_shared::effects::formula::{
    FORMULA_PARAMETERS, Formula, FormulaError, MAX_OPS, MAX_STACK, Op, Target, Variable,
};
use stickslip_shared::effects::{self, Info, MAX_PARAMETERS, Parameter, formula};
use toml::{Spanned, Value};

use crate::model::{expression, names};

/// Lowest and highest value that the data allow, by parameter name.
pub type Intervals = BTreeMap<String, [f64; 2]>;

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

    /// Whether it makes contacts give way.
    pub fn is_compliance(&self) -> bool {
        self.info().is_some_and(|i| i.role.is_compliance())
    }

    /// A formula that was never fitted (its parameters have no intervals) is a proposal: `diagnose`
    /// tries it, `add` makes it part of the model.
    pub fn is_proposal(&self) -> bool {
        self.intervals.is_empty() && self.formula.as_ref().is_some_and(|f| !f.parameters.is_empty())
    }

    /// Description of the effect: of the list, or of the user's formula (its first parameter
    /// taken as the strength, zero where that is allowed as its absence). That of a formula is kept for the
    /// rest of the program, once however often it is asked for.
    pub fn info(&self) -> Option<&'static Info> {
        static KEPT: Mutex<BTreeMap<String, &'static Info>> = Mutex::new(BTreeMap::new());
        let Some(f) = &self.formula else { return effects::find(&self.id) };
        let target = target_name(f);
        let key = format!("{:?} {target:?} {:?} {:?} {:?}", f.name, f.expression, f.parameters, self.values);
        let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
        Some(kept.entry(key).or_insert_with(|| described(f, target, &self.values)))
    }
}

fn described(f: &FormulaEntry, target: &str, values: &[f64]) -> &'static Info {
    let keep = |text: &str| -> &'static str { Box::leak(text.to_string().into_boxed_str()) };
    let each = f.parameters.iter().zip(values).enumerate();
    let parameters: Vec<Parameter> = each
        .map(|(k, (p, value))| {
            let neutral = if k == 0 { 0.0_f64.clamp(p.low, p.high) } else { *value };
            let typical = if k == 0 && *value == neutral { 0.5 * (neutral + p.high) } else { *value };
            let bounds = [p.low, p.high];
            Parameter::new(keep(&p.name), keep(&p.unit), typical, neutral, bounds, "of the user's formula")
        })
        .collect();
    Box::leak(Box::new(Info {
        id: keep(&f.name),
        summary: keep(&format!("the user's formula for {target}: {}", f.expression)),
        signature: "as the formula says",
        on_robot: "what the formula says",
        parameters: Box::leak(parameters.into_boxed_slice()),
        ..formula::INFO
    }))
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

/// Where in the text, and what.
pub(super) type Fault = (Range<usize>, String);

const TARGETS: [(&str, Target); 5] = [
    ("friction", Target::Friction),
    ("grip", Target::Grip),
    ("force_x", Target::ForceX),
    ("force_y", Target::ForceY),
    ("force_z", Target::ForceZ),
];
const BODIES: [&str; 4] = ["finger1", "finger2", "pusher", "support"];

pub(super) fn quoted(text: &str) -> String {
    Value::String(text.into()).to_string()
}

pub(super) fn write_intervals(s: &mut String, intervals: &Intervals) {
    if !intervals.is_empty() {
        let each: Vec<String> =
            intervals.iter().map(|(n, [l, h])| format!("{} = [{l:?}, {h:?}]", quoted(n))).collect();
        let _ = writeln!(s, "intervals = {{ {} }}", each.join(", "));
    }
}

fn target_name(f: &FormulaEntry) -> &'static str {
    TARGETS.iter().find(|(_, t)| *t == f.program.target).map_or("friction", |(name, _)| name)
}

pub(super) fn write_formula(s: &mut String, f: &FormulaEntry, values: &[f64]) {
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

pub(super) fn check_intervals<'a>(
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
pub(super) fn check_name(before: &[EffectEntry], entry: &EffectEntry) -> Result<(), String> {
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

pub(super) type Table = BTreeMap<String, Spanned<Value>>;

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

pub(super) fn entry(mut table: Table, span: Range<usize>) -> Result<EffectEntry, Fault> {
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
        let lacking: Vec<&Parameter> =
            info.parameters.iter().filter(|p| !table.contains_key(p.name)).collect();
        if !lacking.is_empty() {
            return Err((span, lacks(info, &lacking, &table)));
        }
        let mut values = Vec::new();
        for p in info.parameters {
            let Some(value) = table.remove(p.name) else { continue };
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

/// What to say of an effect without the parameters `lacking`; `rest` are the keys that it has.
fn lacks(info: &Info, lacking: &[&Parameter], rest: &Table) -> String {
    let described: Vec<String> =
        lacking.iter().map(|p| format!("{} ({}; {})", p.name, p.unit, p.what)).collect();
    let plural = if lacking.len() > 1 { "s" } else { "" };
    let mut message = format!("effect '{}' lacks its parameter{plural} {}", info.id, described.join(" and "));
    let names: Vec<&str> = lacking.iter().map(|p| p.name).collect();
    // A parameter that is there was not meant to be another.
    let mut strange = rest.keys().filter(|key| info.parameters.iter().all(|p| p.name != key.as_str()));
    if let Some((key, meant)) = strange.find_map(|key| Some((key, did_you_mean(key, &names)?))) {
        let _ = write!(message, "; was '{key}' meant to be {meant}?");
        return message;
    }
    let before: Vec<String> =
        lacking.iter().filter_map(|p| Some(format!("`{} = {}`", p.name, p.before?))).collect();
    if !before.is_empty() {
        let what = before.join(" and ");
        let _ = write!(
            message,
            "; write {what} for the behaviour of files from before there was such a parameter"
        );
    }
    message
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
