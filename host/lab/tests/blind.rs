//! The blind test in small, with a fixed seed: what is hidden is drawn, made into data by the
//! rig's own reality and diagnosed without the key.

use rayon::prelude::*;
use stickslip_analysis::score::warnings::Share;
use stickslip_lab::blind;
use stickslip_lab::blind::generate::Wanted;
use stickslip_lab::blind::score::{Opened, figures, text};

const RUNS: usize = 60;
const SEED: u64 = 2;
/// Most conditions of a data set; the study in `docs/lab/blind-tests.md` has more.
const CONDITIONS: usize = 8;

fn run(number: usize) -> Opened {
    blind::run(SEED, number, CONDITIONS, (&Wanted::default(), &[])).unwrap()
}

fn at_least(what: &str, share: Share, least: f64, runs: &[Opened]) {
    let lines: Vec<String> = runs
        .iter()
        .map(|r| format!("{:?} {:?}: {:?} {:?}", r.truth.class, r.truth.strengths, r.verdict, r.named))
        .collect();
    let enough = share.found as f64 >= least * share.of as f64;
    assert!(enough && share.of > 0, "{what}: {}\n{}", text(&share), lines.join("\n"));
}

#[test]
#[ignore = "takes minutes: make test-full"]
fn of_sixty_hidden_causes_few_are_given_a_wrong_name() {
    let runs: Vec<Opened> = (0..RUNS).into_par_iter().map(run).collect();
    let f = figures(&runs);
    // Far from the aims where a name is wanted (docs/lab/blind-tests.md): what holds is that a name is
    // seldom wrong. The last figures guard against losing more.
    at_least("nothing missing, said so", f.nothing_right, 0.85, &runs);
    at_least("unknown effect not given a name", f.unknown_not_named, 0.85, &runs);
    let wrong = f.single_wrong;
    let right = Share { found: wrong.of - wrong.found, of: wrong.of };
    at_least("single effect not given a wrong name", right, 0.85, &runs);
    at_least("error after within 1.3 noise floors", f.error_fell, 0.8, &runs);
    at_least("strong single effect named, alone or among three", f.strong_named, 0.2, &runs);
}
