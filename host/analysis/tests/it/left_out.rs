//! Trials that are left out: what is said of them.

use stickslip_analysis::left_out::{LeftOut, sentence};

#[test]
fn the_sentence_counts_all_trials_left_out_and_tells_the_commonest_reasons_first() {
    let one = |trial: &str, reason: &str| LeftOut { trial: trial.into(), reason: reason.into() };
    assert_eq!(sentence(&[], 9), None);
    let some = ["no pose", "no grip", "no grip", "no mass", "no object"];
    let left_out: Vec<LeftOut> = some.iter().map(|reason| one("t", reason)).collect();
    assert_eq!(
        sentence(&left_out, 9).as_deref(),
        Some("5 of 9 trials are left out: no grip (2); no pose (1); other reasons (2)")
    );
    assert_eq!(sentence(&left_out[..1], 9).as_deref(), Some("1 of 9 trials is left out: no pose (1)"));
}
