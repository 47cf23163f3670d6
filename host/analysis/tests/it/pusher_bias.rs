//! A constant error of the pusher's sensor, against forces at rest that are known.

use stickslip_analysis::evidence::pusher_bias::{AtRest, Bias};
use stickslip_data::WrenchSensor;

/// As the rigs state it: an error within 0.4 N and 0.02 N m is no news.
fn sensor() -> WrenchSensor {
    WrenchSensor {
        force_noise_n: 0.03,
        force_uncertainty_n: 0.4,
        torque_noise_nm: 0.001,
        torque_uncertainty_nm: 0.02,
    }
}

/// Twenty trials in which the sensor shows `x_n`, less or more by `scatter_n`, of which the fingers bear `borne`.
fn trials(x_n: f64, borne: f64, scatter_n: f64) -> Vec<AtRest> {
    let shown = |k: i32| x_n + scatter_n * f64::from(k % 5 - 2);
    let at = |k: i32| AtRest {
        pusher: [shown(k), 0.2, -0.1, 0.001, 0.009, 0.0],
        sum_n: [shown(k) * (1.0 - borne), 0.2, -0.1],
    };
    (0..20).map(at).collect()
}

#[test]
fn what_a_pusher_shows_before_contact_and_the_fingers_do_not_bear_is_its_sensors_error() {
    for x_n in [-0.93, 0.8, 2.0] {
        let found = Bias::over(&trials(x_n, 0.0, 0.01), &sensor()).expect("an error");
        assert!((found.of_channel[0] - x_n).abs() < 0.01, "{found:?}");
        // The others are within what is stated.
        assert_eq!(found.of_channel[1..], [0.0; 5]);
        assert!(found.by_chance < 1e-9, "{found:?}");
    }
}

#[test]
fn a_force_from_afar_that_the_fingers_bear_is_no_error() {
    for borne in [0.7, 1.0] {
        assert_eq!(Bias::over(&trials(-1.9, borne, 0.01), &sensor()), None, "{borne} of it");
    }
}

#[test]
fn what_is_stated_what_drifts_and_what_few_trials_show_is_no_constant_error() {
    assert_eq!(Bias::over(&trials(0.45, 0.0, 0.01), &sensor()), None);
    assert_eq!(Bias::over(&trials(0.9, 0.0, 0.3), &sensor()), None);
    assert_eq!(Bias::over(&trials(0.9, 0.0, 0.01)[..3], &sensor()), None);
}

#[test]
fn a_torque_beyond_what_is_stated_is_found_beside_a_force_within_it() {
    let mut all = trials(0.3, 0.0, 0.01);
    all.iter_mut().for_each(|t| t.pusher[4] = -0.035);
    let found = Bias::over(&all, &sensor()).expect("an error");
    assert_eq!(found.of_channel, [0.0, 0.0, 0.0, 0.0, -0.035, 0.0]);
}
