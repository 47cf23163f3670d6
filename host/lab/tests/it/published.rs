//! Published complementarity problems, in `../shared/data/lcp` beside the repository.

use std::path::{Path, PathBuf};

use stickslip_lab::hunt::problem::single;
use stickslip_lcp::files::{ProblemFile, read};
use stickslip_lcp::generate::to_problem;
use stickslip_lcp::solve::{Solver, solve_file};
use stickslip_shared::lcp::SolveStatus;
use stickslip_shared::lcp::contact::ContactSolver;

fn problem_files() -> Vec<PathBuf> {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let files: Vec<PathBuf> = ["../shared/data/lcp", "../../shared/data/lcp"]
        .iter()
        .filter_map(|folder| std::fs::read_dir(repository.join(folder)).ok())
        .flat_map(|entries| entries.flatten().map(|entry| entry.path()))
        .collect();
    assert!(
        !files.is_empty(),
        "shared/data/lcp is not beside the repository: put the published problems there, or leave this test out"
    );
    files
}

/// The dense solver for the largest size keeps its tableau on the stack: more than a test
/// thread has without optimisation.
#[test]
#[ignore = "needs ../shared/data: make published"]
fn every_problem_of_the_example_files_is_solved_by_both_solvers() {
    let worker = std::thread::Builder::new().stack_size(256 << 20).spawn(solve_example_files);
    worker.expect("a thread").join().expect("every problem is solved");
}

fn solve_example_files() {
    for path in problem_files() {
        let file = read(&path).expect("an example file");
        let solver = match file {
            ProblemFile::Dense(_) => Solver::Dense,
            ProblemFile::Factors(_) => Solver::Contact,
        };
        for (k, judged) in solve_file(&file, solver).expect("it fits").iter().enumerate() {
            assert_eq!(judged.report.status, SolveStatus::Solved, "{} {k}", path.display());
            assert!(judged.residual <= 1e-8, "{} {k}: {:e}", path.display(), judged.residual);
        }
    }
}

/// As the board solves them: its bits are the host's (`make hil`).
#[test]
#[ignore = "needs ../shared/data: make published"]
fn every_contact_problem_of_the_example_files_is_solved_in_single_precision_or_marked_and_none_falsely() {
    let mut solver = Box::new(ContactSolver::<f32, 16, 8>::new());
    let (mut solved, mut marked) = (0, Vec::new());
    for path in problem_files() {
        let ProblemFile::Factors(set) = read(&path).expect("an example file") else { continue };
        for (k, factors) in set.problems.iter().enumerate() {
            let problem = single(&to_problem::<16, 8>(factors).expect("fits"));
            solver.forget();
            let mut z = vec![0.0; problem.unknowns()];
            let Some(impulses) = solver.solve(&problem).solved() else {
                marked.push(format!("{} {k}", path.display()));
                continue;
            };
            impulses.write_unknowns(&mut z);
            let value = problem.residual(&z).value();
            assert!(value <= 2e-5, "{} {k}: claimed with {value:e}", path.display());
            solved += 1;
        }
    }
    println!("{solved} solved, {} marked: {marked:?}", marked.len());
    assert!(solved > 4 * marked.len(), "{solved} solved, {} marked: {marked:?}", marked.len());
}
