//! The hunt for the worst: problems that cost most, and problems that are answered worst.
//!
//! Candidates are contact problems by their factors ([`problem`]) or short runs of the
//! predictor ([`run`]). The search is evolutionary with restarts ([`search`]) and gives the
//! same finds for the same seed on every machine.

pub mod problem;
pub mod run;
pub mod search;

use serde::Serialize;

/// Quantity to maximise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Target {
    /// Pivots of the contact solver, cold, and of the dense one where it is used
    Pivots,
    /// Pivots of the dense solver on the same problems
    DensePivots,
    /// Residual of claimed solutions, computed independently of the solvers
    Residual,
    /// Relative difference of the object's velocity between the two solvers
    Disagreement,
    /// Relative difference of the contact solver's velocities in single and double precision
    Single,
    /// Work of a tick of the predictor, in evaluations of the momentum balance
    TickWork,
    /// Work of the step from sample to sample alone
    StepWork,
    /// Residual of a step, N
    StepResidual,
    /// Difference of contact forces of a step in single and double precision, over the largest force
    StepForce,
    /// Difference of the object's velocity in single and double precision, m/s
    StepVelocity,
}

/// Every target, in the order of reports.
pub const TARGETS: [Target; 10] = [
    Target::Pivots,
    Target::DensePivots,
    Target::Residual,
    Target::Disagreement,
    Target::Single,
    Target::TickWork,
    Target::StepWork,
    Target::StepResidual,
    Target::StepForce,
    Target::StepVelocity,
];

impl Target {
    /// As on the command line.
    #[must_use]
    pub fn name(self) -> String {
        clap::ValueEnum::to_possible_value(&self).map_or_else(String::new, |v| v.get_name().to_owned())
    }

    /// Whether its candidates are runs of the predictor; otherwise they are contact problems.
    #[must_use]
    pub fn is_run(self) -> bool {
        matches!(
            self,
            Target::TickWork
                | Target::StepWork
                | Target::StepResidual
                | Target::StepForce
                | Target::StepVelocity
        )
    }
}
