//! A host's measurements by the unit's clock: offset, drift, wraps, and what is too old.

use proptest::prelude::*;
use stickslip_shared::wire::{HostClock, Pose, Sample};
use stickslip_unit::fingers::Fingers;
use stickslip_unit::host_clock::{MAX_AGE_US, WRENCH_AGE_US, age_us, as_measured, at_us};

fn sample(t_us: u32) -> Sample {
    let pose = Pose { position_m: [0.3, 0.0, 0.2], quaternion: [1.0, 0.0, 0.0, 0.0] };
    Sample {
        seq: 0,
        t_us,
        grip_cmd_n: 20.0,
        gripper: Some(pose),
        object: Some(pose),
        pusher: None,
        finger: [Some([1.0; 6]); 2],
    }
}

#[test]
fn a_wrench_of_12_ms_ago_is_none_and_one_of_9_ms_ago_is_measured() {
    let clock = HostClock { host_us: 1_000_000, board_us: 77_000_000, drift: 0.0 };
    // The unit's clock at 2 s of the host's.
    let now_us = 78_000_000;
    let seen = |t_us| as_measured(sample(t_us), age_us(at_us(&clock, t_us), now_us));
    assert_eq!(seen(1_988_000).finger, [None; 2]);
    assert!(seen(1_988_000).gripper.is_some(), "poses stand longer");
    assert_eq!(seen(1_991_000), sample(1_991_000));
    let old = seen(1_970_000);
    assert!(old.gripper.is_none() && old.object.is_none() && old.grip_cmd_n.is_nan(), "{old:?}");
    // What an exchange leaves open is no time to come; more is a clock that was set.
    assert_eq!(seen(2_001_500), sample(2_001_500));
    assert_eq!(seen(2_500_000).finger, [None; 2]);
}

#[test]
fn poses_age_from_when_the_host_measured_them_not_from_when_they_came() {
    let clock = HostClock { host_us: 0, board_us: 500_000, drift: 0.0 };
    let mut fingers = Fingers::new();
    fingers.told(sample(0), at_us(&clock, 0));
    assert!(fingers.sample(500_000 + MAX_AGE_US).gripper.is_some());
    fingers.told(sample(0), at_us(&clock, 0));
    assert!(fingers.sample(500_001 + MAX_AGE_US).gripper.is_none());
}

#[test]
fn a_drift_of_50_ppm_is_followed_for_half_an_hour_and_beyond_it_nothing_is_taken_for_the_present() {
    let clock = HostClock { host_us: u32::MAX - 5_000, board_us: 123, drift: 50e-6 };
    for seconds in [1, 60, 600, 2000_u32] {
        let t_us = clock.host_us.wrapping_add(seconds * 1_000_000);
        let board_us = 123_u32.wrapping_add(seconds * 1_000_050);
        assert!(at_us(&clock, t_us).abs_diff(board_us) <= 1, "{seconds} s");
    }
    let t_us = clock.host_us.wrapping_add(2_200_000_000);
    assert!(age_us(at_us(&clock, t_us), 123_u32.wrapping_add(2_200_110_000)) > MAX_AGE_US);
}

proptest! {
    #[test]
    fn no_clock_and_no_time_make_an_older_wrench_a_measurement(
        host_us: u32, board_us: u32, drift in -0.05_f32..0.05, t_us: u32, now_us: u32
    ) {
        let clock = HostClock { host_us, board_us, drift };
        let age = age_us(at_us(&clock, t_us), now_us);
        prop_assert_eq!(as_measured(sample(t_us), age).finger[0].is_some(), age <= WRENCH_AGE_US);
    }
}
