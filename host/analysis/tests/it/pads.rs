//! The compliance of the pads, read off without a model, against the rig's truth.

use stickslip_analysis::calibrate::{Coefficient, Options, calibrate};
use stickslip_analysis::evidence::pads::{Pads, loadings, measured};
use stickslip_analysis::model::file::ModelFile;
use stickslip_analysis::run::simulate::prepare;
use stickslip_data::{Dataset, Trial};
use stickslip_rig::objects::bench;
use stickslip_rig::{Condition, Nuisance, Primitive, Reality, STEP_S, Setup, run};

const GIVEN: &str = "format = \"stickslip-model/1\"\nbase = \"hard\"\n[friction]\nfinger = 0.4\npusher = 0.25\nsupport = 0.3\n";

/// Pushes and pivots on pads of `stiffness_n_m` at `speed_m_s`.
fn trials((stiffness_n_m, speed_m_s): (f64, f64), primitives: &[Primitive]) -> Vec<Trial> {
    let description = bench("pads");
    let mut out = Vec::new();
    for (at, primitive) in primitives.iter().enumerate() {
        for (k, grip_n) in [(0, 12.0), (1, 20.0), (2, 28.0)] {
            let seed = 10 * at as u64 + k;
            let mut reality = Reality::draw(&description, Nuisance::PAPER, seed);
            reality.stiffness_n_m = stiffness_n_m;
            let setup = Setup { description: description.clone(), reality, step_s: STEP_S };
            let condition =
                Condition { grip_n, speed_m_s, travel: 0.006, ..Condition::new(*primitive, "obj4") };
            out.push(run(&setup, &condition, k as usize, seed).expect("suits the rig").trial);
        }
    }
    out
}

fn read_off(pads: (f64, f64), primitives: &[Primitive]) -> Option<Pads> {
    let description = bench("pads");
    let prepared = |(k, t): (usize, &Trial)| prepare(&description, t, k).expect("a scene");
    let trials = trials(pads, primitives);
    measured(&trials.iter().enumerate().map(prepared).flat_map(|p| loadings(&p)).collect::<Vec<_>>())
}

#[test]
fn stiffness_of_pads_is_read_off_pushes_and_pivots_within_a_half() {
    for (stiffness_n_m, speed_m_s) in [(1.5e4, 0.015), (4e4, 0.015), (1e5, 0.005)] {
        let pads = read_off((stiffness_n_m, speed_m_s), &[Primitive::LinearPush, Primitive::Pivot])
            .expect("loads are measured");
        let ratio = pads.tangential_m_n * stiffness_n_m;
        assert!((1.0 / 1.5..1.5).contains(&ratio), "{stiffness_n_m}: {pads:?}");
        assert!(pads.matter(), "{stiffness_n_m}: {pads:?}");
    }
}

#[test]
fn pads_that_are_loaded_within_a_sample_are_not_said_to_give_way() {
    // 100 N/mm: 12 N move the object by 60 um, and the pusher in a sample as far.
    let pads = read_off((1e5, 0.03), &[Primitive::LinearPush]).expect("loads are measured");
    assert!(!pads.give_way(), "{pads:?}");
}

#[test]
fn pads_as_stiff_as_a_rigid_model_may_be_do_not_matter() {
    let pads =
        read_off((3e6, 0.015), &[Primitive::LinearPush, Primitive::Pivot]).expect("loads are measured");
    assert!(!pads.matter(), "{pads:?}");
}

#[test]
fn what_loadings_leave_open_holds_the_pads_that_they_cannot_show_and_slow_ones_leave_nothing_open() {
    for stiffness_n_m in [1e5, 3e6] {
        let quick = read_off((stiffness_n_m, 0.03), &[Primitive::LinearPush]).expect("loads are measured");
        assert!(!quick.give_way(), "{quick:?}");
        let most_m_n = quick
            .unseen()
            .unwrap_or_else(|| panic!("{stiffness_n_m}: {quick:?} leaves soft pads open"))
            .at_most_m_n
            .expect("bounded");
        assert!(1.0 / stiffness_n_m < most_m_n, "{stiffness_n_m}: {quick:?}");
    }
    // Of 1 um/N, known within a tenth, nothing is open that would move the object by 50 um under 20 N.
    let known = Pads {
        tangential_m_n: 1e-6,
        sd_m_n: 1e-7,
        clock_m_n: 1e-7,
        largest_n: 20.0,
        loadings: 6,
        at_most_m_n: None,
        grip_n: 20.0,
    };
    assert_eq!(known.unseen(), None);
}

#[test]
fn nothing_is_read_off_where_nothing_is_gripped() {
    assert_eq!(read_off((4e4, 0.015), &[Primitive::PlanarPush]), None);
}

#[test]
fn a_calibration_reports_soft_pads_and_writes_a_model_that_loads_before_it_slides() {
    let description = bench("pads");
    let given = ModelFile::parse(GIVEN, "given").expect("a model");
    let of = |stiffness_n_m| {
        let trials = trials((stiffness_n_m, 0.015), &[Primitive::LinearPush]);
        let data = Dataset { folder: "pads".into(), description: description.clone(), trials };
        calibrate(&data, &given, &Options::default(), &()).expect("calibrated")
    };
    let soft = of(3e4);
    let pads = soft.primitives[0].pads.expect("read off");
    let (low, high) = (pads.low_n_m, pads.high_n_m.expect("not rigid"));
    assert!(low < 3e4 && 3e4 < high && high < 5.0 * low, "{pads:?}");
    assert!(pads.in_model);
    for model in [&soft.model, &soft.model_of(&soft.primitives[0])] {
        assert_eq!(model.effects[0].id, "contact_compliance");
    }
    // The stiffness that is reported is that of the file, and all that was found has its interval there.
    let entry = &soft.model.effects[0];
    let parameters = stickslip_shared::effects::find("contact_compliance").expect("listed").parameters;
    for (of, value) in parameters.iter().zip(&entry.values) {
        let [low, high] = entry.intervals[of.name];
        assert!(low <= *value && *value <= high && of.low <= low && high <= of.high, "{of:?}: {value}");
    }
    let [stiffest, softest] = entry.intervals["tangential_m_n"];
    assert!((high / low - softest / stiffest).abs() < 1e-9, "{pads:?} {stiffest} {softest}");
    let stiff = of(3e6);
    assert!(stiff.model.effects.is_empty(), "{:?}", stiff.primitives[0].pads);
}

#[test]
fn friction_found_beside_pads_that_are_assumed_in_part_is_within_its_intervals() {
    for (stiffness_n_m, primitive) in [(3e4, Primitive::LinearPush), (1.5e4, Primitive::Pivot)] {
        let trials = trials((stiffness_n_m, 0.015), &[primitive]);
        let data = Dataset { folder: "pads".into(), description: bench("pads"), trials };
        let given = ModelFile::parse(GIVEN, "given").expect("a model");
        let found = calibrate(&data, &given, &Options::default(), &()).expect("calibrated");
        assert!(!found.model.effects.is_empty(), "{stiffness_n_m} {primitive:?}: the pads are in the model");
        let drawn = |seed| Reality::draw(&data.description, Nuisance::PAPER, seed);
        for e in &found.primitives[0].estimates {
            // Of three rigs alike but for their defects.
            let all = [0, 1, 2].map(|seed| match e.coefficient {
                Coefficient::Finger => drawn(seed).mu_finger,
                _ => drawn(seed).mu_pusher,
            });
            let mean = all.iter().sum::<f64>() / 3.0;
            let holds = e.low.is_none_or(|low| low < mean) && e.high.is_none_or(|high| mean < high);
            assert!(holds, "{stiffness_n_m} {primitive:?}: {mean} of {all:?}, {e:?}");
        }
    }
}
