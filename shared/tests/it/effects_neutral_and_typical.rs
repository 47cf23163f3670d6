//! What holds for every effect of the registry.

use crate::scenes::{Record, all};
use stickslip_shared::cone::SolveStatus;
use stickslip_shared::effects::{Effect, REGISTRY};
use stickslip_shared::real::Real;

/// Everything a run shows, as bits.
fn bits<R: Real>(record: &Record<R>) -> Vec<u64> {
    let mut all = Vec::new();
    for o in &record.outputs {
        let r = &o.reading;
        let q = r.rotation.coords;
        let channels = r.finger.iter().flatten().chain(&r.pusher).chain(&r.position_m).chain(&q);
        all.extend(channels.map(|x| x.canonical_bits()));
    }
    all
}

fn neutral_is_no_effect<R: Real>() {
    for (name, run) in all::<R>() {
        let plain = bits(&run.play());
        for info in REGISTRY {
            let mut with = run.clone();
            with.model.effects.push(Effect::neutral(info.id).unwrap()).unwrap();
            assert!(bits(&with.play()) == plain, "{} at its neutral values changes {name}", info.id);
        }
    }
}

#[test]
fn neutral_parameters_give_the_same_bits_as_no_effect_in_f64() {
    neutral_is_no_effect::<f64>();
}

#[test]
fn neutral_parameters_give_the_same_bits_as_no_effect_in_f32() {
    neutral_is_no_effect::<f32>();
}

/// Largest change of a force channel in newtons, of a torque in 10 mN m, of a position in millimetres.
fn change<R: Real>(a: &Record<R>, b: &Record<R>) -> f64 {
    let mut most = 0.0_f64;
    for (a, b) in a.outputs.iter().zip(&b.outputs) {
        let (a, b) = (&a.reading, &b.reading);
        let pairs = a.finger.iter().zip(&b.finger).chain([(&a.pusher, &b.pusher)]);
        for (x, y) in pairs {
            for (k, (x, y)) in x.iter().zip(y).enumerate() {
                most = most.max((*x - *y).to_f64().abs() * if k < 3 { 1.0 } else { 100.0 });
            }
        }
        most = most.max((a.position_m - b.position_m).norm().to_f64() * 1e3);
    }
    most
}

/// `leftover_n`: residual accepted of a step that is not called solved.
fn typical_shows<R: Real>(dt_s: f64, leftover_n: f64) {
    let mut complaints = Vec::new();
    for info in REGISTRY {
        let mut seen = 0.0_f64;
        for (name, mut run) in all::<R>() {
            run.drive.dt_s = R::of(dt_s);
            run.steps = ((run.steps as f64 * 0.004 / dt_s) as usize).max(3);
            let plain = run.play();
            run.model.effects.push(Effect::typical(info.id).unwrap()).unwrap();
            let with = run.play();
            let worst = with.outputs.iter().enumerate().find(|(_, o)| {
                let good = o.status == SolveStatus::Solved || o.residual_n.to_f64() <= leftover_n;
                !good || !o.reading.finger.iter().flatten().all(|x| x.finite()) || o.points_lost > 0
            });
            if let Some((k, o)) = worst {
                complaints.push(format!(
                    "{} in {name}: step {k} {:?}, residual {} N",
                    info.id, o.status, o.residual_n
                ));
            }
            seen = seen.max(change(&plain, &with));
        }
        if seen < 0.1 {
            complaints.push(format!("{} shows nowhere: {seen}", info.id));
        }
    }
    assert!(complaints.is_empty(), "{complaints:#?}");
}

#[test]
fn typical_strengths_show_and_every_step_is_solved_in_f64() {
    typical_shows::<f64>(0.004, 0.0);
}

#[test]
fn typical_strengths_show_and_every_step_balances_to_a_ten_thousandth_of_the_grip_in_f32() {
    typical_shows::<f32>(0.004, 1e-4 * 20.0);
}

#[test]
fn typical_strengths_stay_solved_at_coarse_look_ahead_steps() {
    typical_shows::<f64>(0.02, 0.0);
}

#[test]
fn codes_and_identifiers_are_unique_and_parameters_lie_within_their_bounds() {
    for (i, a) in REGISTRY.iter().enumerate() {
        assert!(a.code != 0 && !a.parameters.is_empty());
        for b in REGISTRY.iter().skip(i + 1) {
            assert!(a.code != b.code && a.id != b.id, "{} and {}", a.id, b.id);
        }
        assert_eq!(Effect::<f64>::typical(a.id).unwrap().info().unwrap().id, a.id);
        for p in a.parameters {
            assert!(p.low <= p.neutral && p.neutral <= p.high, "{} {}", a.id, p.name);
            assert!(p.low <= p.typical && p.typical <= p.high, "{} {}", a.id, p.name);
        }
    }
}
