//! The worst that the hunt has found, kept in `data/worst`: every case is solved below the
//! tolerance or honestly marked, at a bounded cost.

use std::path::{Path, PathBuf};

use stickslip_lab::hunt::problem::{honest, in_single, most_pivots, verdict};
use stickslip_lab::hunt::run::Case;
use stickslip_lab::precision::compare;
use stickslip_lab::steps::walk;
use stickslip_lcp::files::{ProblemFile, read};
use stickslip_shared::cone::{SolveBudget, SolveStatus};
use stickslip_shared::predictor::{Predictor, flags, validity};

fn cases(extension: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/worst");
    let entries = std::fs::read_dir(&folder).expect("data/worst is part of the repository");
    let mut list: Vec<PathBuf> = entries.map(|e| e.expect("an entry").path()).collect();
    list.retain(|path| path.extension().is_some_and(|e| e == extension));
    list.sort();
    assert!(!list.is_empty(), "{}: no case ends in .{extension}", folder.display());
    list
}

fn runs() -> Vec<(String, Case)> {
    let name = |p: &Path| p.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let read = |p: &PathBuf| serde_json::from_slice(&std::fs::read(p).expect("readable")).expect("a case");
    cases("json").iter().map(|p| (name(p), read(p))).collect()
}

#[test]
fn worst_contact_problems_are_solved_or_marked_within_the_bound_of_their_pivots() {
    let worker = std::thread::Builder::new().stack_size(256 << 20).spawn(|| {
        for path in cases("fac") {
            let ProblemFile::Factors(set) = read(&path).expect("a problem file") else {
                panic!("{} holds no factors", path.display());
            };
            for (k, p) in set.problems.iter().enumerate() {
                let name = format!("{} {k}", path.display());
                let v = verdict(p).expect("it fits");
                for j in [&v.contact, &v.dense] {
                    assert!(honest(j), "{name}: {:?}", j.report);
                    assert!(j.report.pivots <= most_pivots(set.contacts), "{name}: {:?}", j.report);
                }
                // Two solvers that share no step cannot both be right where one finds that
                // there is nothing to find.
                let said: Vec<SolveStatus> = vec![v.contact.report.status, v.dense.report.status];
                assert!(
                    !(said.contains(&SolveStatus::Contradiction) && said.contains(&SolveStatus::Solved)),
                    "{name}: {said:?}"
                );
                in_single(p).expect("it fits");
            }
        }
    });
    worker.expect("a thread").join().expect("every case holds");
}

#[test]
fn worst_runs_end_every_tick_within_the_bound_of_its_work_and_mark_what_is_not_solved() {
    for (name, case) in runs() {
        let (scene, model, limits) = case.model.clone();
        let mut predictor = Predictor::new(scene, model, limits).expect("accepted when it was found");
        predictor.set_plan(case.plan.clone());
        for sample in &case.samples {
            let p = predictor.take(sample);
            assert!(p.position_m.iter().chain(&p.quaternion).all(|x| x.is_finite()), "{name}: {p:?}");
            if p.solver_status != SolveStatus::Solved {
                assert_ne!(p.validity & validity::SOLVER, 0, "{name}: {p:?}");
                assert_ne!(p.flags & flags::UNSURE, 0, "{name}: {p:?}");
            }
            // The step to the sample alone (also in three parts), or a step ahead that is begun
            // below the limit of the tick's work.
            assert!(predictor.work() <= 190, "{name}: {} evaluations", predictor.work());
        }
    }
}

#[test]
fn steps_of_the_worst_runs_balance_momentum_or_are_marked() {
    let mut steps = 0;
    for (name, case) in runs() {
        let options = SolveBudget::<f32>::present();
        walk(&case.package(), |walked| {
            let out = walked.out;
            // A Newton step is four evaluations; what has begun may add some.
            let work = 4 * out.iterations + out.evaluations;
            assert!(work <= options.max_work + 8, "{name}: {work}");
            if out.status != SolveStatus::Solved {
                return;
            }
            steps += 1;
            let largest = walked.work.answers().flat_map(|a| a.force_n).fold(1.0_f32, |m, f| m.max(f.abs()));
            // Rounding of the offsets of rigid contacts, which the certificate allows for.
            assert!(out.residual_n <= 1e-3 * largest + 5e-3, "{name}: {} N of {largest} N", out.residual_n);
            // Forces obey the contact law: no pull without adhesion, friction within its bound.
            for law in walked.work.answers() {
                let f = law.force_n;
                assert!(f[0] >= -law.adhesion_n - 1e-6, "{name}: {f:?}");
                let bound = f[0] + law.adhesion_n;
                if law.mu.iter().all(|m| *m > 0.0) {
                    let used = ((f[1] / law.mu[0]).powi(2) + (f[2] / law.mu[1]).powi(2)).sqrt();
                    assert!(used <= bound * 1.001 + 1e-4, "{name}: {used} of {bound}");
                }
            }
            let pair = compare(walked);
            // Single precision loses digits; it does not give another answer.
            assert!(!pair.solved || pair.velocity_m_s < 0.02, "{name}: {pair:?}");
        });
    }
    assert!(steps > 50, "{steps} steps of all runs are solved");
}
