//! Words for channels.

use stickslip_analysis::channels::channel_words;

#[test]
fn channels_and_combinations_of_fingers_have_words_and_nothing_else_is_renamed() {
    for (name, words) in [
        ("object_rx_rad", "object rotation x"),
        ("finger1_fx_n", "finger 1 force x"),
        ("pusher_tz_nm", "pusher torque z"),
        ("finger_sum_fy_n", "fingers together, force y"),
        ("finger_difference_ty_nm", "finger 1 less finger 2, torque y"),
        ("something", "something"),
    ] {
        assert_eq!(channel_words(name), words);
    }
}
