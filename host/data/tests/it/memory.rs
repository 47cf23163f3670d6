//! A data set from columns in memory is the one of the files, and is refused for the same reasons.

use std::fs;
use std::path::Path;

use stickslip_data::columns::COLUMNS;
use stickslip_data::memory::{Columns, filled, from_memory};
use stickslip_data::{Dataset, Problem, Trial, read};

fn demo() -> (Dataset, String, String) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo");
    let text = |name: &str| fs::read_to_string(folder.join(name)).expect("the demo data");
    (read(&folder).expect("the demo data"), text("dataset.toml"), text("trials.csv"))
}

/// Columns of a trial, by name.
type Table = Vec<(&'static str, Vec<f64>)>;

/// The trials' columns, those of the first changed.
fn of(trials: &[Trial], change: impl Fn(&mut Table)) -> Vec<(String, Table)> {
    let mut first = true;
    let one = |trial: &Trial| {
        let mut columns = filled(trial);
        if std::mem::take(&mut first) {
            change(&mut columns);
        }
        (trial.info.trial.clone(), columns)
    };
    trials.iter().map(one).collect()
}

fn view((trial, table): &(String, Table)) -> Columns<'_> {
    Columns { trial, columns: table.iter().map(|(name, values)| (*name, &values[..])).collect() }
}

fn views(tables: &[(String, Table)]) -> Vec<Columns<'_>> {
    tables.iter().map(view).collect()
}

#[test]
fn columns_in_memory_give_the_samples_of_the_files() {
    let (data, description, rows) = demo();
    let tables = of(&data.trials, |_| ());
    let (index, _) = from_memory(&description, &rows, &views(&tables)).expect("a data set");
    assert_eq!(index.description, data.description);
    for (info, trial) in index.trials.iter().zip(&data.trials) {
        // As text: a component that was not measured is NaN, which equals nothing.
        let made = index.read_trial(info).expect("a trial");
        assert_eq!(format!("{made:?}"), format!("{trial:?}"));
    }
}

#[test]
fn columns_that_make_no_table_are_refused_with_trial_row_and_column() {
    type Change = fn(&mut Table);
    let cases: [(Change, &str); 6] = [
        (|c| c[1].1.truncate(3), "values where t_s has"),
        (|c| c.retain(|(name, _)| *name != "t_s"), "column t_s: the column is missing"),
        (|c| c[0].1[5] = 0.0, "row 6, column t_s"),
        (|c| c[3].1[7] = f64::INFINITY, "row 8, column"),
        (|c| c.push(("t_s", c[0].1.clone())), "occurs twice"),
        (|c| c.iter_mut().for_each(|(_, values)| values.clear()), "no samples"),
    ];
    let (data, description, rows) = demo();
    for (change, words) in cases {
        let tables = of(&data.trials, change);
        let error = from_memory(&description, &rows, &views(&tables)).expect_err("refused").to_string();
        assert!(error.contains(words), "{error}");
        assert!(error.starts_with(&format!("trial {}", data.trials[0].info.trial)), "{error}");
    }
}

#[test]
fn a_trial_without_a_table_and_a_table_without_a_trial_are_refused() {
    let (data, description, rows) = demo();
    let mut tables = of(&data.trials, |_| ());
    let last = tables.pop().expect("a trial");
    let error = from_memory(&description, &rows, &views(&tables)).expect_err("refused");
    assert!(matches!(error.problem, Problem::MissingFile(_)), "{error}");
    tables.extend([last.clone(), ("stranger".to_owned(), last.1)]);
    let error = from_memory(&description, &rows, &views(&tables)).expect_err("refused");
    assert_eq!(error.problem, Problem::NoSuchTrial("stranger".into()));
}

#[test]
fn a_column_that_the_format_does_not_name_is_ignored_with_a_hint() {
    let (data, description, rows) = demo();
    let tables = of(&data.trials, |c| c.push(("finger1_fx", vec![0.0; c[0].1.len()])));
    let (_, warnings) = from_memory(&description, &rows, &views(&tables)).expect("a data set");
    let hint = format!("did you mean {}", COLUMNS[23]);
    assert!(warnings.iter().any(|w| w.text.contains(&hint)), "{warnings:?}");
}
