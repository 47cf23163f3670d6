//! The verdict as a function of a few numbers, row by row.

use stickslip_analysis::diagnose::misfit::{Misfit, Place};
use stickslip_analysis::diagnose::verdict::{
    Doubt, Left, Signs, Verdict, apart, explains, left_over, missing_beside, of_search, unbalanced,
    untouched, verdict,
};
use stickslip_analysis::fit::phases::Phase;

/// A place off by `size` run spreads; `at_least`: by all conditions but the worst.
fn place(size: f64, at_least: f64) -> Place {
    Place { channel: 6, phase: Phase::Sliding, size, at_least, run: 0 }
}

/// Nothing beside the search has a say.
const QUIET: Signs = Signs {
    equal: false,
    only_measured: false,
    only_pads: false,
    clear: false,
    swings: false,
    fits: false,
    conditions: 6,
};

/// The worst first, as misfits have them.
fn misfit(places: &[Place]) -> Misfit {
    let mut places = places.to_vec();
    places.sort_by(|a, b| b.size.total_cmp(&a.size));
    Misfit {
        error: 1.0,
        error_at_least: 0.9,
        perfect_model: 1.0,
        systematic: Vec::new(),
        excess: 0.0,
        places,
        whitened: Vec::new(),
    }
}

/// So much in each of a few channels, beyond chance.
fn of(sizes: &[f64]) -> Misfit {
    let places = sizes.iter().enumerate().map(|(channel, s)| Place { channel, ..place(*s, *s) });
    misfit(&places.collect::<Vec<_>>())
}

#[test]
fn effects_explain_the_data_by_share_and_by_what_they_leave() {
    // Share of the excess, error over that of a perfect model, worst misfit in run spreads.
    for (share, error, worst, enough, why) in [
        (0.59, 1.0, 1.0, false, "little explained, nothing relevant left"),
        (0.61, 1.0, 2.5, true, "more than 0.6 where nothing relevant is left"),
        (0.61, 1.0, 2.6, false, "not where something relevant is left"),
        (0.81, 1.3, 4.0, true, "0.8 and an error near that of a perfect model"),
        (0.81, 1.31, 4.0, false, "0.8 and more error than that"),
        (0.81, 1.3, 4.1, false, "0.8 and a clear misfit"),
        (0.86, 2.0, 8.0, true, "0.85 and no misfit beyond 8 run spreads"),
        (0.86, 1.7, 20.0, true, "0.85 and no error beyond 1.75 of a perfect model's"),
        (0.86, 1.8, 8.1, false, "0.85 and both: something else stands behind it"),
        (0.95, 9.0, 90.0, true, "0.95 whatever is left"),
    ] {
        assert_eq!(explains(share, &Left { error, worst }), enough, "{why}");
    }
}

#[test]
fn a_search_ends_in_effects_in_something_unknown_or_in_nothing() {
    let left = |worst| Left { error: 1.0, worst };
    for (explain, named, worst, expected) in [
        (true, 1, 0.5, Verdict::Effect),
        (true, 2, 9.0, Verdict::Effect),
        // The compliance that any pad has is no missing effect.
        (true, 0, 9.0, Verdict::NothingMissing),
        (false, 0, 4.1, Verdict::Unexplained),
        (false, 2, 4.1, Verdict::Unexplained),
        (false, 0, 4.0, Verdict::NothingMissing),
    ] {
        assert_eq!(of_search(explain, named, &left(worst)), expected, "{explain} {named} {worst}");
    }
    // What one condition alone shows is no systematic misfit.
    assert_eq!(Left::of(&misfit(&[place(9.0, 0.9), place(3.0, 1.1)])).worst, 3.0);
}

#[test]
fn doubts_and_signs_beside_the_search_decide_in_this_order() {
    use Verdict::{Ambiguous, Effect, Inconclusive, NothingMissing, Unexplained};
    let quiet = QUIET;
    let small = place(3.0, 1.1);
    let one = place(3.0, 0.9);
    for (search, signs, places, expected, doubt) in [
        (NothingMissing, quiet, vec![place(2.4, 2.4)], NothingMissing, None),
        (NothingMissing, quiet, vec![small], Inconclusive, Some(Doubt::Small(small))),
        (NothingMissing, quiet, vec![one], Inconclusive, Some(Doubt::OneCondition(one))),
        // Fitted to it, the model shows it: that condition alone tells a parameter.
        (NothingMissing, Signs { fits: true, ..quiet }, vec![one], NothingMissing, None),
        (NothingMissing, Signs { fits: true, ..quiet }, vec![small], Inconclusive, Some(Doubt::Small(small))),
        // What more than one condition shows is said, though another place is larger.
        (NothingMissing, quiet, vec![place(3.5, 0.9), small], Inconclusive, Some(Doubt::Small(small))),
        (
            NothingMissing,
            Signs { conditions: 3, ..quiet },
            vec![small],
            Inconclusive,
            Some(Doubt::FewConditions),
        ),
        (NothingMissing, Signs { swings: true, ..quiet }, vec![], Unexplained, None),
        (NothingMissing, Signs { swings: true, ..quiet }, vec![small], Unexplained, None),
        (
            NothingMissing,
            Signs { swings: true, conditions: 3, ..quiet },
            vec![],
            Inconclusive,
            Some(Doubt::FewConditions),
        ),
        // A model that may leave so much once effects are named is not condemned for it before.
        (Effect, quiet, vec![small], Inconclusive, Some(Doubt::Weak(small))),
        // But half of the whitened loss, beyond chance, is no tolerance.
        (Effect, Signs { clear: true, ..quiet }, vec![small], Effect, None),
        (Effect, Signs { clear: true, ..quiet }, vec![], Effect, None),
        (Effect, Signs { clear: true, equal: true, ..quiet }, vec![small], Ambiguous, None),
        (
            NothingMissing,
            Signs { clear: true, ..quiet },
            vec![small],
            Inconclusive,
            Some(Doubt::Small(small)),
        ),
        // Nor is what swings then a doubt about an effect that was fitted to levels.
        (Effect, Signs { swings: true, ..quiet }, vec![small], Unexplained, None),
        (
            Effect,
            Signs { equal: true, ..quiet },
            vec![place(4.0, 1.1)],
            Inconclusive,
            Some(Doubt::Weak(place(4.0, 1.1))),
        ),
        (Effect, quiet, vec![place(4.1, 1.1)], Effect, None),
        (Effect, Signs { equal: true, ..quiet }, vec![place(4.1, 1.1)], Ambiguous, None),
        (NothingMissing, Signs { only_measured: true, ..quiet }, vec![small], Effect, None),
        (Unexplained, Signs { only_measured: true, ..quiet }, vec![], Effect, None),
        (NothingMissing, Signs { only_pads: true, ..quiet }, vec![], Effect, None),
        (Unexplained, Signs { only_pads: true, ..quiet }, vec![], Effect, None),
        (Unexplained, Signs { equal: true, ..quiet }, vec![], Unexplained, None),
    ] {
        assert_eq!(verdict(search, &signs, &misfit(&places)), (expected, doubt), "{search:?} {signs:?}");
    }
}

#[test]
fn what_all_features_together_miss_beyond_a_perfect_models_error_is_no_tolerance() {
    let signs = QUIET;
    let small = place(3.0, 1.1);
    let of = |error_at_least| Misfit { error: 1.2, error_at_least, ..misfit(&[small]) };
    let weak = (Verdict::Inconclusive, Some(Doubt::Weak(small)));
    assert_eq!(verdict(Verdict::Effect, &signs, &of(1.0)), weak);
    assert_eq!(verdict(Verdict::Effect, &signs, &of(1.01)), (Verdict::Effect, None));
    let equal = Signs { equal: true, ..signs };
    assert_eq!(verdict(Verdict::Effect, &equal, &of(1.01)), (Verdict::Ambiguous, None));
    // Where no effect explains it, it stays a doubt.
    let doubt = (Verdict::Inconclusive, Some(Doubt::Small(small)));
    assert_eq!(verdict(Verdict::NothingMissing, &signs, &of(1.01)), doubt);
}

#[test]
fn what_scatter_of_friction_hides_in_every_channel_all_of_them_together_show() {
    use Verdict::{Effect, Inconclusive, NothingMissing};
    let signs = Signs { conditions: 12, ..QUIET };
    let of = |whitened: &[f64], places: &[Place]| Misfit { whitened: whitened.to_vec(), ..misfit(places) };
    let mut many = vec![0.4; 12];
    many[..3].fill(2.1);
    let weak = [place(2.4, 2.4)];
    assert_eq!(verdict(Effect, &signs, &of(&many, &weak)), (Effect, None));
    let doubt = Some(Doubt::Together(3, 12));
    assert_eq!(verdict(NothingMissing, &signs, &of(&many, &weak)), (Inconclusive, doubt));
    // Fewer conditions, and conditions that are not clearly off, say nothing, however far one is off.
    let two = [90.0, 90.0, 0.4, 0.4, 0.4, 0.4, 0.4, 0.4, 0.4, 0.4, 0.4, 0.4];
    assert_eq!(verdict(NothingMissing, &signs, &of(&two, &weak)), (NothingMissing, None));
    assert_eq!(verdict(NothingMissing, &signs, &of(&[1.9; 12], &weak)), (NothingMissing, None));
    // What the law of an effect may be wrong by does not count.
    let before = of(&[102.0; 12], &[]);
    let left = of(&[2.9; 12], &[]);
    assert_eq!(
        (left.clear_conditions(), left.beyond_form(&before).clear_conditions()),
        (Some((12, 12)), None)
    );
}

#[test]
fn where_drift_alone_is_named_a_clear_misfit_that_nothing_explains_is_said() {
    use Verdict::{NothingMissing, Unexplained};
    let quiet = QUIET;
    let drift = Signs { only_measured: true, ..quiet };
    let clear = place(6.0, 5.0);
    for (search, signs, places, expected) in [
        (Unexplained, drift, vec![place(5.0, 4.0), clear], Some(clear)),
        // Nothing that is beyond chance, and worth it.
        (Unexplained, drift, vec![place(9.0, 0.9), place(3.9, 3.0)], None),
        (NothingMissing, drift, vec![clear], None),
        // Then the verdict says it.
        (Unexplained, quiet, vec![clear], None),
    ] {
        assert_eq!(missing_beside(search, &signs, &misfit(&places)), expected, "{search:?} {signs:?}");
    }
}

#[test]
fn a_clear_misfit_where_an_effect_does_not_act_is_not_the_form_of_its_law() {
    for (before, after, left, why) in [
        (&[127.0, 7.2], &[3.4, 7.2], true, "it settles one and does not act on the other"),
        (&[127.0, 1.0], &[3.4, 5.2], true, "it makes another one"),
        (&[127.0, 14.6], &[8.5, 7.8], false, "it acts on both, by a law that is not quite theirs"),
        (&[127.0, 3.9], &[8.5, 3.9], false, "what it does not act on is not clear"),
    ] {
        assert_eq!(untouched(&of(before), &of(after)), left, "{why}");
    }
}

#[test]
fn what_named_effects_leave_is_said_where_it_is_clear_and_more_than_a_tenth_of_what_they_explain() {
    for (before, after, left, why) in [
        (&[32.0, 6.2], &[1.2, 5.9], Some(5.9), "nothing acts on it"),
        (&[200.0, 3.0], &[16.0, 2.0], None, "a law that is wrong by a tenth leaves as much"),
        (&[32.0, 6.0], &[3.9, 3.9], None, "nothing is clear"),
    ] {
        let place = left_over(&of(before), &of(after));
        assert_eq!(place.map(|p| p.size), left, "{why}");
    }
}

#[test]
fn effects_that_explain_all_that_they_act_on_are_told_from_what_is_missing_elsewhere() {
    // Misfit in each of a few channels, before and after, each beyond chance.
    for (before, after, left, why) in [
        (&[6.0, 4.0, 4.8, 3.7], &[0.9, 0.9, 4.8, 3.7], Some(4.8), "two settled, two as they were"),
        (&[6.0, 4.0, 3.0, 1.0], &[0.9, 0.9, 2.9, 1.0], Some(2.9), "little is left elsewhere"),
        (&[6.0, 4.0, 1.0, 1.0], &[0.9, 0.9, 1.0, 1.0], None, "nothing is left"),
        (&[6.0, 4.0, 4.8, 3.7], &[0.9, 2.6, 4.8, 3.7], None, "it acts on one that it does not settle"),
        (&[6.0, 4.0, 4.8, 3.7], &[0.9, 0.9, 4.2, 3.7], None, "a part of another one is its own"),
        (&[6.0, 4.0, 4.8, 3.7], &[0.9, 0.9, 4.8, 4.2], None, "it makes another one worse"),
        (&[3.9, 3.9, 4.8, 3.7], &[0.9, 0.9, 4.8, 3.7], None, "nothing that it settles was clear"),
        (&[4.1, 2.6, 4.8, 3.7], &[2.0, 2.2, 4.8, 3.7], None, "it leaves a fifth of what it acts on"),
    ] {
        assert_eq!(apart(&of(before), &of(after)).map(|p| p.size), left, "{why}");
    }
}

#[test]
fn forces_that_do_not_balance_leave_no_verdict_that_nothing_is_missing() {
    for (before, conditions, after) in [
        (Verdict::NothingMissing, 4, Verdict::Unexplained),
        (Verdict::Inconclusive, 4, Verdict::Unexplained),
        (Verdict::Inconclusive, 3, Verdict::Inconclusive),
        (Verdict::Effect, 9, Verdict::Effect),
        (Verdict::Ambiguous, 9, Verdict::Ambiguous),
        (Verdict::Unexplained, 9, Verdict::Unexplained),
    ] {
        assert_eq!(unbalanced(before, conditions), after, "{before:?} {conditions}");
    }
}

#[test]
fn what_is_left_within_a_tenth_of_what_is_explained_there_asks_for_no_further_effect() {
    let other = Place { channel: 7, ..place(9.0, 8.0) };
    // Size before and after, whether that is worth a further effect, why.
    for (before, after, relevant, why) in [
        (185.0, 17.5, false, "the law of what explains the rest may be so far off"),
        (185.0, 30.0, true, "more than a tenth"),
        (8.0, 2.8, true, "a tenth of little is little"),
        (9.0, 9.0, true, "nothing was explained here"),
    ] {
        let before = misfit(&[place(before, before - 1.0)]);
        let left = misfit(&[place(after, after - 1.0)]).beyond_form(&before);
        assert_eq!(left.exceeds(2.5), relevant, "{why}: {left:?}");
    }
    let before = misfit(&[place(185.0, 100.0), other]);
    let left = misfit(&[place(17.5, 10.0), other]).beyond_form(&before);
    assert_eq!(
        left.places[0], other,
        "another channel where nothing was explained stays as it is, and leads"
    );
}

#[test]
fn a_sensors_constant_error_carries_a_tenth_of_what_is_explained_into_its_channels_other_phases() {
    let at_rest =
        |channel: usize, size: f64| Place { channel, phase: Phase::Before, ..place(size, size - 1.0) };
    let of = |place: Place, size: f64| Place { size, at_least: size - 1.0, ..place };
    let slides = place(185.0, 180.0);
    let before = misfit(&[slides, at_rest(slides.channel, 9.0), at_rest(7, 9.0)]);
    let after =
        misfit(&[of(slides, 17.5), at_rest(slides.channel, 9.0), at_rest(7, 9.0)]).beyond_form(&before);
    let left = |channel: usize| after.at(channel, Phase::Before).map_or(f64::NAN, |p| p.size);
    // The mean of 185^2 - 17.5^2 and nothing, a tenth of its root: 13.
    assert!(left(slides.channel) < 1e-9, "{}", left(slides.channel));
    assert!((left(7) - 9.0).abs() < 1e-9, "a channel of another sensor");
}
