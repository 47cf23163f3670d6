//! Solves the problems of a file by one of the solvers, timed, and judges every answer.

use std::time::Instant;

use anyhow::{Context, bail};
use serde::Serialize;
use stickslip_shared::lcp::dense::Dense;
use stickslip_shared::lcp::fallback::Fallback;
use stickslip_shared::lcp::{Outcome, Report, SolveStatus, residual, tolerance};

use crate::files::{Answer, Factors, ProblemFile};
use crate::generate::to_problem;

/// Which solver is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Solver {
    /// Lemke's method on the matrix.
    Dense,
    /// The contact solver on the factors, every problem from open contacts.
    Contact,
    /// The contact solver, every problem from the answer of the one before.
    Warm,
}

/// Repetitions of a solve: how often it is timed.
pub const REPETITIONS: usize = 9;
/// A claim with a larger residual than this is called false even where none is certified.
const FALSE_RESIDUAL: f64 = 1e-4;

/// What came of one problem.
#[derive(Clone, Debug)]
pub struct Judged {
    /// As written to a `.res` file.
    pub answer: Answer,
    /// What the solver said.
    pub report: Report<f64>,
    /// Residual of `z` by the dense rows, computed apart from the solver.
    pub residual: f64,
}

/// Counts and times of a set of answers.
#[derive(Clone, Debug, schemars::JsonSchema, Serialize)]
pub struct Summary {
    /// File or family.
    pub name: String,
    /// Unknowns.
    pub n: usize,
    /// Problems.
    pub problems: usize,
    /// Claims of a solution whose residual is 1e-8 or less.
    pub solved: usize,
    /// Claims of a solution whose residual is more than that.
    pub false_claims: usize,
    /// Of these, with a residual above 1e-4.
    pub false_above_1e4: usize,
    /// Reported as having no solution.
    pub rays: usize,
    /// Generated so that they have none: a claim is false whatever its residual.
    pub impossible: usize,
    /// Largest residual among claims.
    pub worst_residual: f64,
    /// Median over problems of the median of the repetitions, microseconds; `null` where none was timed.
    #[schemars(with = "Option<f64>")]
    pub median_us: f64,
    /// 99th percentile of the same; `null` where none was timed.
    #[schemars(with = "Option<f64>")]
    pub p99_us: f64,
    /// Largest number of pivots.
    pub most_pivots: u32,
}

/// Number that stands for a status in a `.res` file; 0 claims a solution.
pub fn status_code(status: SolveStatus) -> i32 {
    match status {
        SolveStatus::Solved => 0,
        SolveStatus::Contradiction => 1,
        SolveStatus::IterationLimit => 2,
        SolveStatus::Numerical => 3,
        SolveStatus::BadInput => 4,
    }
}

/// The solvers with their working memory.
#[derive(Default)]
pub struct Solvers {
    small: Option<Box<Dense<f64, 64>>>,
    medium: Option<Box<Dense<f64, 128>>>,
    large: Option<Box<Dense<f64, 388>>>,
    six: Option<Box<Fallback<f64, 16, 6, 98, 9216>>>,
    eight: Option<Box<Fallback<f64, 16, 8, 98, 9216>>>,
    many: Option<Box<Fallback<f64, 64, 8, 388, 147_456>>>,
}

impl Solvers {
    /// Solves a dense problem once.
    ///
    /// # Errors
    /// More than 386 unknowns.
    pub fn dense(&mut self, m: &[f64], q: &[f64]) -> anyhow::Result<(Vec<f64>, Report<f64>)> {
        fn copied(outcome: Outcome<'_, [f64], f64>, n: usize) -> (Vec<f64>, Report<f64>) {
            let (z, report) = outcome.best();
            let mut z = z.to_vec();
            z.resize(n, 0.0);
            (z, report)
        }
        let n = q.len();
        Ok(match n {
            0..=62 => copied(self.small.get_or_insert_default().solve(m, q), n),
            63..=126 => copied(self.medium.get_or_insert_default().solve(m, q), n),
            127..=386 => copied(self.large.get_or_insert_default().solve(m, q), n),
            _ => bail!("{n} unknowns; the dense solver holds 386"),
        })
    }

    /// Times and judges a dense problem.
    ///
    /// # Errors
    /// See [`Solvers::dense`].
    pub fn judge_dense(&mut self, m: &[f64], q: &[f64], repetitions: usize) -> anyhow::Result<Judged> {
        let mut times_us = Vec::with_capacity(repetitions);
        let mut last = None;
        for _ in 0..repetitions.max(1) {
            let start = Instant::now();
            let solved = self.dense(m, q)?;
            times_us.push(start.elapsed().as_nanos() as f64 / 1e3);
            last = Some(solved);
        }
        let (z, report) = last.context("a solve has at least one repetition")?;
        Ok(judged(z, report, times_us, m, q))
    }

    /// Times and judges a contact problem.
    ///
    /// # Errors
    /// More than 64 contacts or 8 degrees of freedom where the factors are needed.
    pub fn judge_factors(
        &mut self,
        factors: &Factors,
        solver: Solver,
        repetitions: usize,
    ) -> anyhow::Result<Judged> {
        let (m, q) = factors.dense();
        // Only the dense form expresses other tangents than t, -t and constants of slip bounds.
        let expressible = to_problem::<64, 8>(factors).is_some();
        if solver == Solver::Dense || !expressible {
            return self.judge_dense(&m, &q, repetitions);
        }
        let (contacts, freedoms) = (factors.friction.len(), factors.inverse_mass.len());
        let (z, report, times) = match (contacts, freedoms) {
            (0..=16, 0..=6) => repeat(self.six.get_or_insert_default(), factors, solver, repetitions)?,
            (0..=16, _) => repeat(self.eight.get_or_insert_default(), factors, solver, repetitions)?,
            _ => repeat(self.many.get_or_insert_default(), factors, solver, repetitions)?,
        };
        Ok(judged(z, report, times, &m, &q))
    }
}

fn repeat<const NC: usize, const ND: usize, const N: usize, const SQUARE: usize>(
    solvers: &mut Fallback<f64, NC, ND, N, SQUARE>,
    factors: &Factors,
    solver: Solver,
    repetitions: usize,
) -> anyhow::Result<(Vec<f64>, Report<f64>, Vec<f64>)> {
    let problem = to_problem::<NC, ND>(factors).context("the problem exceeds the capacity")?;
    let mut z = vec![0.0; problem.unknowns()];
    let mut times = Vec::with_capacity(repetitions);
    let mut last = None;
    let before = solvers.contact.clone();
    for _ in 0..repetitions.max(1) {
        // A warm solve starts every repetition from the problem before, not from this one.
        if solver == Solver::Warm {
            solvers.contact.clone_from(&before);
        } else {
            solvers.contact.forget();
        }
        let start = Instant::now();
        let (impulses, report) = solvers.solve(&problem).best();
        impulses.write_unknowns(&mut z);
        times.push(start.elapsed().as_nanos() as f64 / 1e3);
        last = Some(report);
    }
    let report = last.context("a solve has at least one repetition")?;
    Ok((z, report, times))
}

fn judged(z: Vec<f64>, report: Report<f64>, times_us: Vec<f64>, m: &[f64], q: &[f64]) -> Judged {
    let residual = residual::dense(m, q, &z).value();
    let answer = Answer {
        status: status_code(report.status),
        pivots: i32::try_from(report.pivots).unwrap_or(i32::MAX),
        times_us,
        z,
    };
    Judged { answer, report, residual }
}

/// Solves all problems of a file.
///
/// # Errors
/// The contact solver is asked for a file without factors, or a capacity is exceeded.
pub fn solve_file(file: &ProblemFile, solver: Solver) -> anyhow::Result<Vec<Judged>> {
    let mut solvers = Solvers::default();
    match file {
        ProblemFile::Dense(_) if solver != Solver::Dense => bail!(
            "the file holds matrices (.lcp); the contact solver needs factors (.fac): \
             use --solver dense"
        ),
        ProblemFile::Dense(set) => {
            set.problems.iter().map(|(m, q)| solvers.judge_dense(m, q, REPETITIONS)).collect()
        }
        ProblemFile::Factors(set) => {
            set.problems.iter().map(|factors| solvers.judge_factors(factors, solver, REPETITIONS)).collect()
        }
    }
}

/// The `k`-th of a hundred parts of the sorted values; NaN of none.
pub fn percentile(sorted: &[f64], k: usize) -> f64 {
    let place = (sorted.len() * k / 100).min(sorted.len().saturating_sub(1));
    sorted.get(place).copied().unwrap_or(f64::NAN)
}

/// Summary of judged answers.
pub fn summarise(name: &str, n: usize, judged: &[Judged]) -> Summary {
    let mut medians: Vec<f64> = judged
        .iter()
        .map(|j| {
            let mut times = j.answer.times_us.clone();
            times.sort_by(f64::total_cmp);
            percentile(&times, 50)
        })
        .collect();
    medians.sort_by(f64::total_cmp);
    let claims: Vec<&Judged> = judged.iter().filter(|j| j.report.status == SolveStatus::Solved).collect();
    // Written so that a residual that is not a number counts as false.
    let certified = |j: &Judged| j.residual <= tolerance::<f64>();
    Summary {
        name: name.to_owned(),
        n,
        problems: judged.len(),
        solved: claims.iter().filter(|j| certified(j)).count(),
        false_claims: claims.iter().filter(|j| !certified(j)).count(),
        false_above_1e4: claims.iter().filter(|j| !(j.residual <= FALSE_RESIDUAL)).count(),
        rays: judged.iter().filter(|j| j.report.status == SolveStatus::Contradiction).count(),
        impossible: 0,
        worst_residual: claims.iter().map(|j| j.residual).fold(0.0, f64::max),
        median_us: percentile(&medians, 50),
        p99_us: percentile(&medians, 99),
        most_pivots: judged.iter().map(|j| j.report.pivots).max().unwrap_or(0),
    }
}
