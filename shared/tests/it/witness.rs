//! The other formulation as a witness of the steps.

use stickslip_selftest as selftest;
use stickslip_shared::model::Formulation;
use stickslip_shared::predictor::{HASH_START, Limits, Testimony};

/// Hash of the predictions, the most work of a tick, and what the witness said, of the self-test's trials with a witness asked
/// for or not.
fn run(by: Formulation, witness: bool, ticks: u32) -> (u32, u32, Testimony) {
    let (mut hash, mut most) = (HASH_START, 0);
    let mut sum = Testimony::default();
    selftest::each(by, 3, ticks, 0.1, |predictor, sample| {
        // Before a trial's first step.
        if predictor.work() == 0 {
            let (scene, model) = predictor.model();
            let (scene, mut model) = (scene.clone(), model.clone());
            model.witness = witness;
            predictor.swap(scene, model, Limits { horizon_s: 0.1, ..Limits::default() });
        }
        let before = predictor.testimony();
        hash = predictor.tick(sample).hash(hash);
        most = most.max(predictor.work());
        let after = predictor.testimony();
        sum.asked += after.asked - before.asked;
        sum.compared += after.compared - before.compared;
        sum.alike += after.alike - before.alike;
    });
    (hash, most, sum)
}

#[test]
fn no_prediction_depends_on_the_witness_whose_steps_stay_within_the_work_of_a_tick() {
    for by in [Formulation::Cone, Formulation::Lcp] {
        let (alone, most_alone, none) = run(by, false, 6_000);
        let (witnessed, most, said) = run(by, true, 6_000);
        println!("{by:?}: {said:?}, most work {most} (alone {most_alone})");
        assert_eq!(none, Testimony::default());
        assert_eq!(alone, witnessed, "{by:?}");
        // With a look-ahead a tick has room for it in some of these hard steps.
        assert!(said.asked > 4_000 && said.compared > said.asked / 4, "{by:?} {said:?}");
        assert!(said.alike > said.compared * 9 / 10, "{by:?} {said:?}");
        // A tick's 112, and what the last solve may add: three evaluations, priced by the formulation and the points.
        assert!(most_alone.max(most) <= 128, "{by:?}: {most}, alone {most_alone}");
        // A witness is asked only where there is room for it.
        assert_eq!(most_alone, most, "{by:?}");
    }
}
