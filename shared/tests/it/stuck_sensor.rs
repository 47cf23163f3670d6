//! A quiet converter repeats itself; a stuck sensor does nothing else.

#[test]
fn equal_counts_of_a_quiet_amplifier_are_no_stuck_sensor_and_a_stuck_one_is_found() {
    use stickslip_shared::health::Health;
    use stickslip_shared::predictor::{Limits, Sample as Tick, validity};
    let mut random = 1u32;
    let mut draw = move || {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        random >> 8
    };
    let mut health = Health::<f32>::default();
    let limits = Limits::default();
    let mut check = |wrench: [f32; 6], t_s: f32| {
        let mut other = wrench;
        other[0] += t_s;
        let sample = Tick {
            t_s,
            grip_cmd_n: 20.0,
            gripper: None,
            object: None,
            pusher: None,
            finger: [Some(wrench), Some(other)],
        };
        health.check(&sample, &limits).1 & validity::STUCK != 0
    };
    // Each of six channels moves by a count in every second reading or less: one reading in ten is equal.
    let (mut wrench, mut accused, mut equal) = ([2.0f32; 6], 0, 0);
    for k in 0..250_000u32 {
        let before = wrench;
        for w in &mut wrench {
            *w = 2.0 + if draw() % 100 < 16 { 0.01 } else { 0.0 } * ((draw() % 3) as f32 - 1.0);
        }
        equal += u32::from(before == wrench);
        accused += u32::from(check(wrench, k as f32 * 0.004));
    }
    assert!(equal > 20_000, "{equal}");
    assert!(accused < 3, "{accused} false alarms in 1000 s");
    let found = (0..50).find(|k| check(wrench, 1000.0 + *k as f32 * 0.004));
    assert!(found.is_some_and(|k| k < 20), "{found:?}");
}
