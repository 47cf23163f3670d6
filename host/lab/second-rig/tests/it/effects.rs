//! Every hidden effect shows in the truth that sensors see, and only where it says.

use crate::common::clean;
use stickslip_second_rig::dataset::{DataSet, Wish};
use stickslip_second_rig::families::{FAMILIES, Family};
use stickslip_second_rig::hidden::CATALOGUE;
use stickslip_second_rig::plan::bench::Primitive;
use stickslip_second_rig::sensors::Row;
use stickslip_second_rig::trial::TrialSpec;

/// Largest difference of forces (N), with torques on 20 mm and positions in 0.1 mm counted alike.
fn apart(a: &[Row], b: &[Row]) -> f64 {
    let mut most = 0.0_f64;
    for (x, y) in a.iter().zip(b) {
        let wrench = |p: &[f64; 6], q: &[f64; 6]| {
            (0..6).map(|i| (p[i] - q[i]).abs() * if i > 2 { 50.0 } else { 1.0 }).fold(0.0, f64::max)
        };
        for f in 0..2 {
            most = most.max(wrench(&x.fingers[f], &y.fingers[f]));
        }
        if let (Some(p), Some(q)) = (&x.pusher_wrench, &y.pusher_wrench) {
            most = most.max(wrench(p, q));
        }
        if let (Some(p), Some(q)) = (&x.object, &y.object) {
            most = most.max((0..3).map(|i| (p[i] - q[i]).abs() * 1e4).fold(0.0, f64::max));
        }
    }
    most
}

fn family_of(primitive: Primitive) -> (&'static str, &'static str) {
    match primitive {
        Primitive::LinearPush => ("bench-hard", "linear_push"),
        Primitive::Pivot => ("bench-hard", "pivot"),
        Primitive::Roll => ("bench-roll", "roll"),
        Primitive::Lift => ("bench-lift", "lift"),
        Primitive::PlanarPush => ("bench-planar", "planar_push"),
    }
}

/// Seed, trial and the run without any effect.
fn plain(primitive: Primitive) -> (u64, usize, Vec<Row>) {
    let (family, name) = family_of(primitive);
    let is_it = |t: &TrialSpec| t.primitive == name;
    let seed = (1..50).find(|s| clean(family, *s, &[], 60).trials.iter().any(is_it)).expect("a plan");
    let set = clean(family, seed, &[], 60);
    // The last one, when wear has acted; of rolls the first: at high grip cylinders slide.
    let i = match primitive {
        Primitive::Roll => set.trials.iter().position(is_it),
        _ => set.trials.iter().rposition(is_it),
    };
    let i = i.expect("a trial");
    let rows = set.run_one(&set.trials[i]).rows;
    (seed, i, rows)
}

#[test]
fn every_effect_shows_in_each_primitive_that_it_names() {
    use Primitive::{Lift, LinearPush, Pivot, PlanarPush, Roll};
    let mut hidden = Vec::new();
    for primitive in [LinearPush, Pivot, Roll, Lift, PlanarPush] {
        let (family, _) = family_of(primitive);
        let (seed, i, without) = plain(primitive);
        for effect in CATALOGUE.iter().filter(|e| e.shows_in.contains(&primitive)) {
            let with = clean(family, seed, &[(effect.id, 1.0)], 60);
            let rows = with.run_one(&with.trials[i]).rows;
            assert!(rows.len() == without.len(), "{} in {primitive:?}: the object was lost", effect.id);
            let d = apart(&without, &rows);
            if d < 0.01 {
                hidden.push(format!("{} in {primitive:?}: {d}", effect.id));
            }
        }
    }
    assert!(hidden.is_empty(), "{hidden:#?}");
}

#[test]
fn levels_and_effects_are_drawn_widely() {
    let mut none = 0;
    let mut seen = std::collections::BTreeSet::new();
    for seed in 0..400 {
        let family = &FAMILIES[seed as usize % 10];
        let set = DataSet::draw(family, seed, &Wish::default()).unwrap();
        none += usize::from(set.effects.is_empty());
        for e in &set.effects {
            assert!((0.3..=2.5).contains(&e.level), "{}: {}", e.id, e.level);
            seen.insert(e.id);
        }
    }
    assert!((20..90).contains(&none), "{none} of 400 with nothing hidden");
    for e in CATALOGUE {
        assert!(seen.contains(e.id), "{} was never drawn", e.id);
    }
}

#[test]
fn pads_span_the_range_of_their_family() {
    for (name, low, high) in [("grasp-soft", 5e3, 5e4), ("grasp-hard", 3e5, 2e6), ("bench-wide", 5e3, 2e6)] {
        let family = Family::named(name).unwrap();
        let wish = Wish { effects: Some(Vec::new()), trials: None };
        let pads: Vec<f64> =
            (0..60).map(|s| DataSet::draw(family, s, &wish).unwrap().reality.pad.shear_n_m).collect();
        assert!(pads.iter().all(|k| (low..=high).contains(k)));
        let (least, most) = pads.iter().fold((f64::MAX, 0.0_f64), |a, k| (a.0.min(*k), a.1.max(*k)));
        assert!(least < low * 1.5 && most > high / 1.5, "{name}: {least} to {most}");
    }
}
