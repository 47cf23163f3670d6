//! A gripped cylinder rolled over a platform.
//!
//! The gripper moves along its Y axis above the platform. Rolling, the object slips against
//! both fingertips. The platform's drag `F` acts on the object; finger 1 carries
//! `N + F/2` and finger 2 `N - F/2` or the reverse: their difference is `F`, their mean the
//! grip.

use crate::common::*;
use crate::on_both_formulations;
use stickslip_shared::cone::SolveStatus;
use stickslip_shared::effects::Effect;
use stickslip_shared::model::*;

const RADIUS_M: f64 = 0.0125;

/// Moves along +Y at `speed` on a platform that the cylinder rests on.
fn roll(
    by: Formulation,
    platform_mu: f64,
    finger_mu: f64,
    grip_n: f64,
    seconds: f64,
    each: impl FnMut(&Seen<'_, f64>),
) {
    roll_with(hard_by(by, finger_mu, 0.0, platform_mu), grip_n, seconds, each);
}

/// The same with any model.
fn roll_with(model: Model<f64>, grip_n: f64, seconds: f64, each: impl FnMut(&Seen<'_, f64>)) {
    let up = turn([0.0, 1.0, 0.0], -core::f64::consts::FRAC_PI_2);
    let play = Play {
        scene: gripped(obj1(), Some(PusherContact::Plane)),
        model,
        gripper: &|t| pose(at(0.0, 0.010 * t, 0.0), turn([1.0, 0.0, 0.0], 0.0)),
        pusher: Some(&|_| pose(at(0.0, 0.0, -RADIUS_M), up)),
        object: pose(at(0.0, 0.0, 0.0), turn([1.0, 0.0, 0.0], 0.0)),
        grip_n,
        seconds,
    };
    play.run(each);
}

on_both_formulations! {
    with_a_sticky_platform_the_cylinder_rolls_without_slip,
    the_fingers_share_the_platform_drag_as_plus_and_minus_half,
    rolling_needs_platform_friction_above_what_the_fingers_friction_asks,
    pads_that_stiffen_with_their_own_load_press_a_dragged_object_down_until_it_rolls,
}

fn with_a_sticky_platform_the_cylinder_rolls_without_slip(by: Formulation) {
    let mut last = 0.0;
    roll(by, 10.0, 0.1, 3.0, 1.0, |s| {
        let q = s.world.rotation.scaled_axis();
        assert!(s.imbalance_n.norm() < 1e-6);
        last = q.x;
    });
    // Rolling along +Y turns about -X by distance over radius.
    assert!((last + 0.010 / RADIUS_M).abs() < 0.02, "{last}");
}

fn the_fingers_share_the_platform_drag_as_plus_and_minus_half(by: Formulation) {
    for grip_n in [3.0, 5.0] {
        roll(by, 10.0, 0.1, grip_n, 0.8, |s| {
            if s.t_s < 0.2 {
                return;
            }
            let drag = s.out.reading.pusher[1];
            assert!(drag < 0.0, "the platform drags against the motion: {drag}");
            let (f1, f2) = (-s.out.reading.finger[0][1], s.out.reading.finger[1][1]);
            // The finger behind (finger 2, pushing along +Y) bears more.
            assert!((f2 - (grip_n - 0.5 * drag)).abs() < 0.02 * grip_n, "{f2} {drag}");
            assert!((f1 - (grip_n + 0.5 * drag)).abs() < 0.02 * grip_n, "{f1} {drag}");
        });
    }
}

fn rolling_needs_platform_friction_above_what_the_fingers_friction_asks(by: Formulation) {
    // Both fingers rub with mu (N +- F/2) at the radius R, the platform drags with F at R:
    // F = 2 mu N. The fingers' friction differs by mu F, which presses the object down, so
    // the platform must bear 2 mu N with the normal force weight + 2 mu^2 N.
    let (mu, grip_n) = (0.4, 3.0);
    let asked = 2.0 * mu * grip_n / (0.158 * G + 2.0 * mu * mu * grip_n);
    let rotation = |platform| {
        let (mut angle, mut unsolved) = (0.0, 0);
        roll(by, platform, mu, grip_n, 0.8, |s| {
            unsolved += u32::from(s.out.status != SolveStatus::Solved);
            angle = -s.world.rotation.scaled_axis().x;
        });
        // At the threshold rolling and sliding both solve the step: the iteration may end
        // undecided, and says so.
        assert!(unsolved <= 2, "platform {platform}: {unsolved} of 200 steps unsolved");
        angle
    };
    // Held at rest, three equal springs share the weight, platform and two fingers. Sliding on from there is a
    // solution too until finger 1, which bears (T + F) / 2 of its weight's share T and of the drag F at the normal
    // force N - F / 2, gives way. The path of the pyramids stays with it, as compliant pads do;
    // the cone's iteration finds rolling as soon as there is any, or (at 1.2 to 1.6) is undecided.
    let weight_n = 0.158 * G;
    let stuck = (2.0 * mu * grip_n - 2.0 / 3.0 * weight_n) / ((1.0 + mu) * weight_n / 3.0);
    let enough = if by == Formulation::Cone { asked } else { stuck };
    for (platform, rolls) in [(0.3, false), (0.97 * asked, false), (1.03 * enough, true), (2.5, true)] {
        let angle = rotation(platform);
        let share = angle / (0.008 / RADIUS_M);
        assert!(if rolls { share > 0.98 } else { share < 0.02 }, "mu {platform} of {enough}: {share}");
    }
}

/// Pads whose stiffness goes with the load of each (rough faces): the platform's drag `f` relieves finger 1 and loads finger 2
/// by `f / 2`, finger 2 is stiffer along its face and takes more of the drag's torque, and what it takes more presses the
/// object onto the platform: by `d(f)`, with the pads' own increments (a pad that is relieved keeps its stretch, one that is
/// loaded its force). Where `mu (p + d(f)) > f` for all `f`, the platform never slides.
fn pads_that_stiffen_with_their_own_load_press_a_dragged_object_down_until_it_rolls(by: Formulation) {
    let (finger_mu, grip_n, compliance_m_n) = (2.0, 3.0, 3e-5);
    let at = |stiffening: f64, platform_mu: f64| {
        let mut model = hard_by(by, finger_mu, 0.0, platform_mu);
        let mut pads = Effect::neutral("contact_compliance").unwrap();
        pads.parameters[0] = compliance_m_n;
        pads.parameters[4] = stiffening;
        model.effects.push(pads).unwrap();
        let (mut seen, mut rest_n) = (Vec::new(), None);
        roll_with(model, grip_n, 0.8, |s| {
            let [pusher, f1, f2] = [s.out.reading.pusher, s.out.reading.finger[0], s.out.reading.finger[1]]
                .map(|w| [w[1], w[2]]);
            rest_n.get_or_insert(s.out.normal_n[2]);
            seen.push([-pusher[0], -f1[1] - f2[1]]);
        });
        (seen, rest_n.unwrap())
    };
    // Drag and what presses down, as the object turns.
    let mut course = vec![(0.0, 0.0)];
    let (mut loaded_n, mut drag_n) = (0.0, 0.0_f64);
    let step_n = 1e-3;
    for step in 1..3000 {
        // By as much as a pad under the grip would bear.
        let reached_n = f64::from(step) * step_n;
        let relieved_n = (1.0 - 0.5 * drag_n / grip_n) * reached_n;
        loaded_n += (1.0 + 0.5 * drag_n / grip_n) * step_n;
        drag_n = relieved_n + loaded_n;
        course.push((drag_n, loaded_n - relieved_n));
    }
    let (_, rest_n) = at(1.0, 1.0);
    let (at_n, asked) = course
        .iter()
        .map(|(f, d)| (*f, f / (rest_n + d)))
        .fold((0.0, 0.0), |most, now| if now.1 > most.1 { now } else { most });
    assert!(at_n < 1.8 * grip_n, "finger 1 still bears then: {at_n}");
    let rolls = |(seen, _): &(Vec<[f64; 2]>, f64)| {
        // Rolling, it drags with all that the fingers' friction lets it.
        let share = seen.last().unwrap()[0] / grip_n;
        assert!(!(1.2..1.9).contains(&share), "{share}");
        share > 1.9
    };
    assert!(!rolls(&at(1.0, 0.96 * asked)) && rolls(&at(1.0, 1.06 * asked)), "{asked}");
    // On pads that do not stiffen it slides on.
    assert!(!rolls(&at(0.0, 1.06 * asked)));
    // As long as it is held, the course is the one above.
    let (seen, before_n) = at(1.0, 0.9 * asked);
    let [drag_n, down_n] = *seen.last().unwrap();
    let (_, expected_n) = *course.iter().find(|(f, _)| *f >= drag_n).unwrap();
    let carried_n = 0.158 * G - before_n;
    assert!((down_n + carried_n - expected_n).abs() < 0.02 * expected_n, "{down_n} {expected_n} at {drag_n}");
}
