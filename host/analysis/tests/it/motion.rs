//! Motion recovered from noisy poses.

use nalgebra::{UnitQuaternion, Vector3};
use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use stickslip_analysis::run::motion::*;
use stickslip_shared::track::Pose;

fn push(noise_m: f64) -> (Vec<f64>, Vec<Pose<f64>>, Vec<f64>) {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let n = Normal::new(0.0, noise_m).expect("noise");
    let t: Vec<f64> = (0..500).map(|i| i as f64 * 0.004).collect();
    let x: Vec<f64> = t.iter().map(|t| -0.01 * (t - 0.4).clamp(0.0, 1.2)).collect();
    let poses = x
        .iter()
        .map(|x| Pose {
            position_m: Vector3::new(*x + n.sample(&mut rng), n.sample(&mut rng), n.sample(&mut rng)),
            rotation: UnitQuaternion::identity(),
        })
        .collect();
    (t, poses, x)
}

/// Rounding of a held coordinate.
const REST_M: f64 = 1e-15;

#[test]
fn a_noisy_push_is_recovered_to_a_few_micrometres_and_rests_exactly() {
    let (t, poses, truth) = push(3e-5);
    let clean = denoised(&t, &poses);
    for (i, x) in truth.iter().enumerate() {
        assert!((clean[i].position_m.x - x).abs() < 4e-5, "sample {i}");
        assert!((clean[i].position_m.y - clean[0].position_m.y).abs() < REST_M);
    }
    assert!((clean[5].position_m - clean[60].position_m).norm() < REST_M);
    assert!((clean[420].position_m - clean[499].position_m).norm() < REST_M);
    let slope = (clean[300].position_m.x - clean[200].position_m.x) / 0.4;
    assert!((slope + 0.01).abs() < 1e-4, "{slope}");
}

/// The push as a motion capture of `rate_hz` sees it, interpolated to `samples_hz`: times, poses,
/// and where the gripper is.
fn captured(rate_hz: f64, samples_hz: f64, seed: u64) -> (Vec<f64>, Vec<Pose<f64>>, Vec<f64>) {
    let x = |t: f64| -0.01 * (t - 0.4).clamp(0.0, 1.2);
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let n = Normal::new(0.0, 3e-5).expect("noise");
    let frames = (0..(2.1 * rate_hz) as usize).map(|i| i as f64 / rate_hz);
    let times: Vec<f64> = frames.collect();
    let seen: Vec<Option<Pose<f64>>> = times
        .iter()
        .map(|t| {
            let position_m = Vector3::new(x(*t) + n.sample(&mut rng), n.sample(&mut rng), n.sample(&mut rng));
            Some(Pose { position_m, rotation: UnitQuaternion::identity() })
        })
        .collect();
    let t: Vec<f64> = (0..(2.0 * samples_hz) as usize).map(|i| i as f64 / samples_hz).collect();
    let poses = t
        .iter()
        .map(|t| {
            let k = ((t * rate_hz) as usize).min(times.len() - 2);
            let two = interpolated(&[times[k], *t, times[k + 1]], &[seen[k], None, seen[k + 1]]);
            let two = two.expect("both are known");
            if *t == times[k] { two[0] } else { two[1] }
        })
        .collect();
    let truth = t.iter().map(|t| x(*t)).collect();
    (t, poses, truth)
}

#[test]
fn a_push_captured_at_60_hz_or_more_is_recovered_within_one_poses_noise_and_its_speed_to_a_per_cent() {
    for (rate_hz, samples_hz) in [60.0, 75.0, 100.0, 120.0, 125.0, 200.0, 250.0]
        .into_iter()
        .flat_map(|rate_hz| [(rate_hz, 250.0), (rate_hz, 1000.0)])
    {
        for seed in 0..10 {
            let what = format!("{rate_hz} Hz at {samples_hz} Hz, seed {seed}");
            let (t, poses, truth) = captured(rate_hz, samples_hz, seed);
            let clean = denoised(&t, &poses);
            // Onset and end included: two lines of many frames cross where neither frame is.
            let off = (0..t.len()).map(|i| (clean[i].position_m.x - truth[i]).abs()).fold(0.0, f64::max);
            assert!(off < 3e-5, "{what}: {off} m");
            let speed = |i: usize| (clean[i + 1].position_m.x - clean[i].position_m.x) * samples_hz;
            let within = |from_s: f64, to_s: f64| {
                (0..t.len() - 1).filter(|i| t[*i] > from_s && t[*i + 1] < to_s).map(speed).collect::<Vec<_>>()
            };
            // A frame after the onset to a frame before the end.
            let steady = within(0.4 + 1.0 / rate_hz, 1.6 - 1.0 / rate_hz);
            let worst = steady.iter().map(|v| (v + 0.01).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-4, "{what}: {worst} m/s");
            let rest = within(0.0, 0.4 - 1.0 / rate_hz);
            assert!(rest.iter().all(|v| v.abs() < 1e-9), "{what}: {rest:?} at rest");
        }
    }
}

#[test]
fn a_record_of_a_thousand_strokes_is_recovered_in_one_pass_of_blocks() {
    // Strokes of 5 mm to and fro, 0.8 s each with a rest of 0.2 s: 17 minutes.
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
    let n = Normal::new(0.0, 3e-5).expect("noise");
    let t: Vec<f64> = (0..250_000).map(|i| f64::from(i) * 0.004).collect();
    let x = |t: f64| {
        let (stroke, share) = (t.floor(), (1.25 * (t - t.floor())).min(1.0));
        0.005 * if stroke % 2.0 == 0.0 { share } else { 1.0 - share }
    };
    let pose = |t: &f64| Pose {
        position_m: Vector3::new(x(*t) + n.sample(&mut rng), n.sample(&mut rng), n.sample(&mut rng)),
        rotation: UnitQuaternion::identity(),
    };
    let poses: Vec<Pose<f64>> = t.iter().map(pose).collect();
    let clean = denoised(&t, &poses);
    let off = |i: usize| (clean[i].position_m.x - x(t[i])).abs();
    let worst = (0..t.len()).map(off).fold(0.0, f64::max);
    assert!(worst < 3e-5, "{worst}");
}

#[test]
fn poses_known_at_every_other_sample_only_lie_on_the_line_between() {
    let (t, poses, truth) = push(0.0);
    let known: Vec<_> = poses.iter().enumerate().map(|(i, p)| (i % 2 == 0).then_some(*p)).collect();
    let filled = interpolated(&t, &known).expect("poses");
    for (x, pose) in truth.iter().zip(&filled).take(499) {
        assert!((pose.position_m.x - x).abs() < 2.1e-5, "{x}");
    }
    assert_eq!(interpolated(&t, &vec![None; t.len()]), None);
}

#[test]
fn a_track_without_noise_is_returned_as_it_came() {
    let (t, poses, _) = push(0.0);
    assert_eq!(denoised(&t, &poses)[333], poses[333]);
}
