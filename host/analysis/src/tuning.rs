//! `predictor.toml`: the predictor's numbers as a user sets them. Names, defaults, bounds and what is said of each number come
//! from where it is declared ([`stickslip_shared::tuning`]).

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::ops::Range;
use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;
use stickslip_data::spelling::did_you_mean;
use stickslip_shared::predictor::{Checked, Tuning};
use stickslip_shared::tuning::{About, Slot, Tuned, Visitor};
use toml::de::{DeTable, DeValue};

use crate::model::file::{ModelFileError, locate, read_text};

/// A table of `predictor.toml`.
#[derive(Clone, Debug, JsonSchema, PartialEq, Serialize)]
pub struct Table {
    /// Its name in the file, with the tables that it is in: `observer.motion`.
    pub table: String,
    /// What it is about.
    pub what: String,
    /// In the order of the file.
    pub parameters: Vec<Parameter>,
}

/// A number of the predictor, or two of one kind.
#[derive(Clone, Debug, JsonSchema, PartialEq, Serialize)]
pub struct Parameter {
    /// Its key in the table.
    pub name: String,
    /// What it is, its unit, why it has its value, and what happens if it is doubled.
    pub what: String,
    /// What it is without a file: one number, or two.
    pub default: Vec<f64>,
    /// Least value.
    pub least: f64,
    /// Greatest value.
    pub most: f64,
    /// Only whole numbers.
    pub whole: bool,
}

/// A number that is not the default.
#[derive(Clone, Debug, JsonSchema, PartialEq, Serialize)]
pub struct Changed {
    /// Table and key: `observer.motion.hold.sigmas`.
    pub key: String,
    /// What the predictor ran with: one number, or two.
    pub value: Vec<f64>,
    /// What it is without a file.
    pub default: Vec<f64>,
}

/// Every number of the predictor, table by table.
#[must_use]
pub fn tables() -> Vec<Table> {
    tables_of(&Tuning::default())
}

/// The numbers that are not the defaults.
#[must_use]
pub fn changed(tuning: &Checked<f32>) -> Vec<Changed> {
    let numbers = |tables: Vec<Table>| {
        tables.into_iter().flat_map(|t| {
            let key = move |name: &str| format!("{}.{name}", t.table);
            t.parameters.into_iter().map(move |p| (key(&p.name), p.default))
        })
    };
    numbers(tables_of(tuning.get()))
        .zip(numbers(tables()))
        .filter(|((_, value), (_, default))| value != default)
        .map(|((key, value), (_, default))| Changed { key, value, default })
        .collect()
}

/// The changes in a line: `observer.motion.hold.sigmas 7 (default 5.5)`.
#[must_use]
pub fn in_words(changed: &[Changed]) -> String {
    let one = |c: &Changed| format!("{} {} (default {})", c.key, number(&c.value), number(&c.default));
    changed.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// A complete file with the default values, each below what is said of it.
#[must_use]
pub fn default_file() -> String {
    let mut text = String::from(
        "# The predictor's numbers, with their defaults. A file needs only those that differ.\n\
         # They belong to 250 samples a second, poses within 30 micrometres and forces within 0.02 N.\n",
    );
    for table in tables() {
        // Writing to a String cannot fail.
        let _ = writeln!(text);
        comment(&mut text, &table.what);
        let _ = writeln!(text, "[{}]", table.table);
        for p in &table.parameters {
            let whole = if p.whole { "; a whole number" } else { "" };
            comment(&mut text, &format!("{} From {} to {}{whole}.", p.what, p.least, p.most));
            let _ = writeln!(text, "{} = {}", p.name, written(p));
        }
    }
    text
}

/// The numbers in the user's file, or the defaults where none is named.
///
/// # Errors
/// Where the file cannot be read or is wrong.
pub fn tuning_or_default(path: Option<&Path>) -> Result<Checked<f32>, ModelFileError> {
    path.map_or_else(|| Ok(Checked::default()), read)
}

/// Reads and checks the file.
///
/// # Errors
/// Where it cannot be read or is wrong.
pub fn read(path: &Path) -> Result<Checked<f32>, ModelFileError> {
    let (file, text) = read_text(path)?;
    parse(&text, &file)
}

/// Checks the text; `file` is what errors call it. What it does not say is the default.
///
/// # Errors
/// Where it is no TOML, a key is none of the predictor's, or a value is not within its bounds.
pub fn parse(text: &str, file: &str) -> Result<Checked<f32>, ModelFileError> {
    let locate = |fault| locate(text, file, fault);
    let parsed = DeTable::parse(text)
        .map_err(|e| locate((e.span().unwrap_or(0..0), e.message().trim_end().to_owned())))?;
    let known = tables();
    let mut given = BTreeMap::new();
    gather("", parsed.get_ref(), &known, &mut given).map_err(locate)?;
    let mut tuning = Tuning::default();
    let mut set = Set { path: Vec::new(), given: &given };
    tuning.visit(&mut set);
    tuning.checked().map_err(|why| locate((0..0, why.to_string())))
}

/// What is wrong, and where in the text.
type Fault = (Range<usize>, String);

/// The numbers of a table and of those in it, by table and key.
fn gather(
    path: &str,
    table: &DeTable<'_>,
    known: &[Table],
    given: &mut BTreeMap<String, Vec<f64>>,
) -> Result<(), Fault> {
    for (key, value) in table {
        let name = key.get_ref().as_ref();
        let whole_path = join(path, name);
        let own = known.iter().find(|t| t.table == path).into_iter().flat_map(|t| &t.parameters);
        if known.iter().any(|t| t.table == whole_path) {
            let DeValue::Table(inside) = value.get_ref() else {
                return Err((value.span(), format!("{whole_path} is a table: write [{whole_path}]")));
            };
            gather(&whole_path, inside, known, given)?;
        } else if let Some(parameter) = own.clone().find(|p| p.name == name) {
            let numbers = numbers(&whole_path, value.get_ref(), parameter).map_err(|m| (value.span(), m))?;
            given.insert(whole_path, numbers);
        } else {
            let tables = known.iter().filter_map(|t| {
                let inner = t.table.strip_prefix(path)?;
                let inner = if path.is_empty() { inner } else { inner.strip_prefix('.')? };
                (!inner.is_empty() && !inner.contains('.')).then_some(inner)
            });
            let here: Vec<&str> = own.map(|p| p.name.as_str()).chain(tables).collect();
            return Err((key.span(), unknown(path, name, &here, known)));
        }
    }
    Ok(())
}

fn unknown(path: &str, name: &str, here: &[&str], known: &[Table]) -> String {
    let place = if path.is_empty() { String::new() } else { format!(" in [{path}]") };
    if let Some(meant) = did_you_mean(name, here) {
        return format!("`{name}` is not known{place}; did you mean `{meant}`?");
    }
    let elsewhere: Vec<&str> = known
        .iter()
        .filter(|t| t.parameters.iter().any(|p| p.name == name))
        .map(|t| t.table.as_str())
        .collect();
    match elsewhere.as_slice() {
        [] => format!("`{name}` is not known{place}; `stickslip predictor` lists all"),
        tables => format!("`{name}` is not known{place}; it belongs to [{}]", tables.join("] or [")),
    }
}

fn numbers(path: &str, value: &DeValue<'_>, about: &Parameter) -> Result<Vec<f64>, String> {
    let one = |value: &DeValue<'_>| -> Result<f64, String> {
        let number = match value {
            DeValue::Integer(i) => i64::from_str_radix(i.as_str(), i.radix()).ok().map(|i| i as f64),
            DeValue::Float(f) if !about.whole => f.as_str().parse().ok(),
            _ => None,
        };
        let kind = if about.whole { "a whole number" } else { "a number" };
        let number = number.ok_or_else(|| format!("{path} must be {kind}"))?;
        if !(about.least..=about.most).contains(&number) {
            return Err(format!("{path} = {number} must lie between {} and {}", about.least, about.most));
        }
        Ok(number)
    };
    match (value, about.default.len()) {
        (DeValue::Array(list), many) if many > 1 => {
            if list.len() != many {
                return Err(format!("{path} must be {many} numbers, and has {}", list.len()));
            }
            list.iter().map(|v| one(v.get_ref())).collect()
        }
        (_, many) if many > 1 => Err(format!("{path} must be a list of {many} numbers")),
        (value, _) => Ok(vec![one(value)?]),
    }
}

/// Sets what the file gives.
struct Set<'a> {
    path: Vec<&'static str>,
    given: &'a BTreeMap<String, Vec<f64>>,
}

impl Visitor for Set<'_> {
    fn enter(&mut self, name: &'static str, _: &'static str) {
        self.path.push(name);
    }
    fn leave(&mut self) {
        self.path.pop();
    }
    fn number(&mut self, about: &About, slot: &mut dyn Slot) {
        let given = self.given.get(&join(&self.path.join("."), about.name));
        given.into_iter().flatten().enumerate().for_each(|(at, value)| slot.set(at, *value));
    }
}

/// Lists what there is.
#[derive(Default)]
struct List {
    path: Vec<&'static str>,
    tables: Vec<Table>,
}

impl Visitor for List {
    fn enter(&mut self, name: &'static str, doc: &'static str) {
        self.path.push(name);
        self.tables.push(Table { table: self.path.join("."), what: one_line(doc), parameters: Vec::new() });
    }
    fn leave(&mut self) {
        self.path.pop();
    }
    fn number(&mut self, about: &About, slot: &mut dyn Slot) {
        let table = self.path.join(".");
        if let Some(table) = self.tables.iter_mut().find(|t| t.table == table) {
            table.parameters.push(Parameter {
                name: about.name.to_owned(),
                what: one_line(about.doc),
                default: (0..slot.count()).filter_map(|at| slot.get(at)).map(shortest).collect(),
                least: about.low,
                most: about.high,
                whole: slot.is_whole(),
            });
        }
    }
}

fn tables_of(tuning: &Tuning<f32>) -> Vec<Table> {
    let mut list = List::default();
    let mut tuning = *tuning;
    tuning.visit(&mut list);
    list.tables
}

/// The shortest number that is `x` in the single precision in which it is kept.
fn shortest(x: f64) -> f64 {
    (x as f32).to_string().parse().unwrap_or(x)
}

/// A documentation's lines as one; names of code without their marks.
fn one_line(doc: &str) -> String {
    doc.split_whitespace().collect::<Vec<_>>().join(" ").replace("[`", "`").replace("`]", "`")
}

fn join(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") }
}

/// A number, or a list of them.
fn number(values: &[f64]) -> String {
    match values {
        [one] => one.to_string(),
        several => format!("[{}]", several.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")),
    }
}

/// A default as TOML.
fn written(p: &Parameter) -> String {
    let one = |x: &f64| if p.whole { x.to_string() } else { format!("{x:?}") };
    match p.default.as_slice() {
        [x] => one(x),
        several => format!("[{}]", several.iter().map(one).collect::<Vec<_>>().join(", ")),
    }
}

/// Width of a comment.
const WIDTH: usize = 110;

fn comment(text: &mut String, what: &str) {
    let mut width = 0;
    for word in what.split(' ') {
        if width == 0 || width + 1 + word.len() > WIDTH {
            text.push_str(if width == 0 { "# " } else { "\n# " });
            width = 2;
        } else {
            text.push(' ');
            width += 1;
        }
        text.push_str(word);
        width += word.len();
    }
    text.push('\n');
}
