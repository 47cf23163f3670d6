//! Claims about what the observer takes from noisy measurements.

use crate::common::Noise;
use stickslip_shared::observer::bearing::Bearing;
use stickslip_shared::observer::friction::{Friction, Use};
use stickslip_shared::observer::load::{LoadNoise, LoadParams};
use stickslip_shared::observer::motion::{Forces, Motion};
use stickslip_shared::observer::plateau::{Bars, Plateau, PlateauParams};
use stickslip_shared::observer::shear::Load;
use stickslip_shared::observer::trend::{Trend, TrendParams};
use stickslip_shared::observer::{Observer, Seen};
use stickslip_shared::real::Vec3;

const DT: f32 = 0.004;
/// An hour at 250 Hz.
const HOUR: u32 = 900_000;

/// Ticks at which a trend with noise 0.005 is proven while `value` runs.
fn proven(ticks: u32, value: impl Fn(f32) -> f32) -> Vec<u32> {
    let (mut trend, mut noise) = (Trend::new(2.5e-5f32, TrendParams::default()), Noise(7));
    (0..ticks)
        .filter(|tick| {
            trend.push(value(*tick as f32 * DT) + 0.005 * noise.next(), DT);
            trend.proven().is_some()
        })
        .collect()
}

#[test]
fn noise_alone_proves_no_slope_in_an_hour() {
    assert_eq!(proven(HOUR, |_| 0.3), Vec::<u32>::new());
}

#[test]
fn a_steady_rise_is_proven_within_160_ms_with_its_value_and_a_slope_no_steeper_than_it_is() {
    let value = |t: f32| 0.2 + 0.3 * (t - 1.0).max(0.0);
    let first = *proven(400, value).first().expect("proven");
    assert!((250..=290).contains(&first), "proven at tick {first}");
    let (mut trend, mut noise) = (Trend::new(2.5e-5f32, TrendParams::default()), Noise(3));
    for tick in 0..400 {
        trend.push(value(tick as f32 * DT) + 0.005 * noise.next(), DT);
    }
    let line = trend.proven().expect("proven");
    assert!((line.value - value(399.0 * DT)).abs() < 0.01, "value {}", line.value);
    // 0.3 less twice its standard deviation, 0.027; give or take three more of them.
    assert!(line.slope_s > 0.165 && line.slope_s < 0.327, "slope {}", line.slope_s);
}

#[test]
fn steps_and_knocks_prove_no_slope() {
    for shift in 0..10u32 {
        let at = 1.0 + shift as f32 * DT / 2.0;
        let step = |t: f32| if t < at { 0.2 } else { 0.35 };
        let knock = |t: f32| 0.2 + 0.2 * (1.0 - ((t - at) / 0.02).abs()).max(0.0);
        let load = |t: f32| 0.2 + 0.2 * ((t - at) / 0.01).clamp(0.0, 1.0);
        assert_eq!(proven(500, step), Vec::<u32>::new(), "step at {at}");
        assert_eq!(proven(500, knock), Vec::<u32>::new(), "knock at {at}");
        assert_eq!(proven(500, load), Vec::<u32>::new(), "load at {at}");
    }
}

/// First tick of slip of an object of 4 N that is lifted off a table within 0.1 s, on pads that give way by
/// 60 um a newton; from 1.2 s on it moves by `path(t)` besides. A pose in every `every`-th sample.
fn slipping_in_a_lift(ticks: u32, every: u32, path: impl Fn(f32) -> f32) -> Option<u32> {
    let (mut motion, mut noise) = (Motion::default(), Noise(5));
    (0..ticks).find(|tick| {
        let t = *tick as f32 * DT;
        let borne_n = 4.0 * ((t - 1.0) / 0.1).clamp(0.0, 1.0);
        let load = Load {
            force_n: Vec3::new(0.02 * noise.next(), 0.0, -borne_n + 0.02 * noise.next()),
            normal_n: 20.0,
            gripper_m_s: Vec3::zeros(),
        };
        let z = -6e-5 * borne_n - path((t - 1.2).max(0.0));
        let p = Vec3::new(4e-5 * noise.next(), 3e-6 * noise.next(), z + 4e-5 * noise.next());
        let moved = match tick % every {
            0 => Some(motion.follow(&[p, p], Some(&load), Forces::Hold, DT)),
            _ => motion.wait(DT),
        };
        moved.is_some_and(|m| m.slip_s > 0.0)
    })
}

#[test]
fn pads_that_give_way_under_the_load_of_a_lift_do_not_slip() {
    assert_eq!(slipping_in_a_lift(5000, 1, |_| 0.0), None);
    assert_eq!(slipping_in_a_lift(5000, 4, |_| 0.0), None);
}

#[test]
fn what_slides_under_a_constant_load_is_seen_with_poses_at_60_hz_too() {
    for (every, latest) in [(1, 308), (2, 312), (4, 320)] {
        let tick = slipping_in_a_lift(400, every, |t| t * t).expect("slips");
        assert!((301..=latest).contains(&tick), "a pose in {every} samples: tick {tick}");
    }
}

/// First tick of slip as an object moves along Z by `path(t)`, pose noise 42 um on an axis.
fn slipping(ticks: u32, path: impl Fn(f32) -> f32) -> Option<u32> {
    let (mut motion, mut noise) = (Motion::default(), Noise(11));
    (0..ticks).find(|tick| {
        let mut around = |x: f32, sigma: f32| x + sigma * noise.next();
        let p = Vec3::new(around(0.0, 42e-6), around(0.0, 3e-6), around(path(*tick as f32 * DT), 42e-6));
        motion.follow(&[p, p], None, Forces::Hold, DT).slip_s > 0.0
    })
}

#[test]
fn noise_of_the_pose_is_no_slip_in_an_hour() {
    assert_eq!(slipping(HOUR, |_| 0.0), None);
}

#[test]
fn a_creep_of_half_a_millimetre_a_second_is_no_slip() {
    assert_eq!(slipping(2500, |t| 5e-4 * (t - 1.0).max(0.0)), None);
}

#[test]
fn an_object_that_gains_speed_is_seen_to_slip_within_28_ms_of_its_first_motion() {
    for gain_m_s2 in [1.0, 2.0, 5.0] {
        let path = |t: f32| 0.5 * gain_m_s2 * (t - 1.0).max(0.0).powi(2);
        let tick = slipping(400, path).expect("slips");
        assert!((250..=257).contains(&tick), "{gain_m_s2} m/s2: tick {tick}");
    }
}

/// Slips that are told, a rest, while a push of 0.3 s at 20 mm/s is followed by `rest_s` of rest, over and over;
/// `sigma_m` of a pose, `forces` as the pads carry what they slid with.
fn told_at_rest(pushes: u32, rest_s: f32, sigma_m: f32, forces: Forces, seed: u32) -> (u32, u32) {
    let (mut motion, mut noise) = (Motion::default(), Noise(seed));
    let (mut seen, mut false_slips) = (0, 0);
    let cycle = (75 + (rest_s / DT) as u32).max(76);
    let mut place_m = 0.0;
    let mut slipped = false;
    for tick in 0..250 + pushes * cycle {
        let at = tick.checked_sub(250).map(|t| t % cycle);
        let pushed = at.is_some_and(|at| at < 75);
        place_m += if pushed { 0.02 * DT } else { 0.0 };
        let mut around = |x: f32| x + sigma_m * noise.next();
        let p = Vec3::new(around(place_m), around(0.0) * 0.1, around(0.0));
        let slips = motion.follow(&[p, p], None, forces, DT).slip_s > 0.0;
        seen += u32::from(at == Some(74) && slips);
        // Rest is told after some samples.
        false_slips += u32::from(slips && !slipped && at.is_none_or(|at| at > 80));
        slipped = slips;
    }
    (seen, false_slips)
}

#[test]
fn an_object_that_has_come_to_rest_slips_by_noise_no_oftener_than_the_bar_says() {
    for (sigma_m, forces, seed) in [
        (1e-5, Forces::Hold, 1),
        (3e-5, Forces::AtLimit, 2),
        (3e-5, Forces::Hold, 3),
        (1e-4, Forces::AtLimit, 4),
    ] {
        let (seen, false_slips) = told_at_rest(1000, 0.3, sigma_m, forces, seed);
        assert_eq!(seen, 1000, "{sigma_m} m, {forces:?}: pushes seen");
        assert_eq!(false_slips, 0, "{sigma_m} m, {forces:?}: slips by noise in 300 s of rest");
    }
}

fn held(needed: f32, slip_s: Option<f32>) -> Use<f32> {
    Use { needed, noise: 0.002, slip_s, speed_m_s: 0.05, grip_holds: true, steered: false }
}

#[test]
fn a_knock_that_was_withstood_proves_friction_and_only_where_the_pose_shows_it() {
    for (slip_s, proves) in [(Some(0.0), true), (None, false)] {
        let mut friction = Friction::new(0.4f32);
        for tick in 0..200 {
            let knock = if (50..60).contains(&tick) { 0.46 } else { 0.2 };
            friction.learn(&held(knock, slip_s), DT);
        }
        assert_eq!(friction.least() > 0.44, proves, "least {}", friction.least());
        assert!(friction.estimate() >= friction.least());
    }
}

#[test]
fn a_load_that_stays_proves_the_friction_that_it_needs() {
    let mut friction = Friction::new(0.4f32);
    for _ in 0..1000 {
        friction.learn(&held(0.45, None), DT);
    }
    assert!((friction.least() - 0.45).abs() < 0.01, "least {}", friction.least());
    friction.reset();
    assert_eq!(friction.estimate(), 0.4);
}

/// Samples in which the wrenches are taken for clipped while the ratio runs: noise 0.007, what
/// slips if it rose there 0.4, if it jumped 0.34.
fn clipped(ticks: u32, value: impl Fn(f32) -> f32) -> (Vec<u32>, Option<f32>) {
    clipped_while(ticks, value, 0..0)
}

/// The same while the gripper gains speed in `gains`.
fn clipped_while(
    ticks: u32,
    value: impl Fn(f32) -> f32,
    gains: std::ops::Range<u32>,
) -> (Vec<u32>, Option<f32>) {
    let (mut plateau, mut noise) = (Plateau::default(), Noise(5));
    let (mut level, mut ceiling) = (value(0.0), None);
    let found = (0..ticks)
        .filter(|tick| {
            let now = value(*tick as f32 * DT) + 0.007 * noise.next();
            level += (now - level) * DT / 0.5;
            let samples = plateau.clipped(&Bars {
                now,
                level,
                noise: 0.007,
                held: 0.0,
                steered: false,
                accelerates: gains.contains(tick),
                risen: 0.4,
                jumped: 0.34,
                sliding: 1.0,
            });
            ceiling = ceiling.or(plateau.ceiling());
            samples > 0
        })
        .collect();
    (found, ceiling)
}

/// A knock of 40 ms that would reach `peak` on top of 0.2, clipped at `mu`.
fn knock(peak: f32, mu: f32) -> impl Fn(f32) -> f32 {
    move |t: f32| (0.2 + (peak - 0.2) * (1.0 - ((t - 1.02) / 0.02).abs()).max(0.0)).min(mu)
}

#[test]
fn a_load_clipped_at_the_friction_there_is_shows_within_24_ms() {
    let load = |t: f32| if t < 1.0 { 0.2 } else { 0.36 };
    let first = *clipped(400, load).0.first().expect("clipped");
    assert!((250..=256).contains(&first), "tick {first}");
    assert!(!clipped(400, knock(0.7, 0.36)).0.is_empty(), "a knock that slides is flat");
}

#[test]
fn a_steady_load_or_a_knock_that_is_held_is_not_clipped() {
    assert_eq!(clipped(HOUR / 10, |_| 0.37).0, Vec::<u32>::new());
    assert_eq!(clipped(400, |t| if t < 1.0 { 0.2 } else { 0.3 }).0, Vec::<u32>::new());
    let (found, ceiling) = clipped(400, knock(0.5, 1.0));
    assert_eq!((found, ceiling), (Vec::new(), None));
}

#[test]
fn a_load_that_first_went_higher_is_held() {
    let load = |t: f32| match t {
        t if t < 1.0 => 0.2,
        t if t < 1.01 => 0.43,
        _ => 0.36,
    };
    assert_eq!(clipped(400, load).0, Vec::<u32>::new());
}

#[test]
fn a_load_that_stays_where_the_object_has_come_to_rest_is_held_until_it_slides_again() {
    let (mut plateau, mut noise) = (Plateau::default(), Noise(9));
    let mut clipped = |told: fn(&mut Plateau<f32>)| {
        told(&mut plateau);
        (0..250)
            .filter(|_| {
                let now = 0.46 + 0.007 * noise.next();
                let bars = Bars {
                    now,
                    level: 0.46,
                    noise: 0.007,
                    held: 0.0,
                    steered: false,
                    accelerates: false,
                    risen: 0.4,
                    jumped: 0.34,
                    sliding: 1.0,
                };
                plateau.clipped(&bars) > 0
            })
            .count()
    };
    assert!(clipped(|p| p.slides()) > 200, "beyond the friction there is");
    assert_eq!(clipped(|p| p.bears(0.46)), 0, "what bears the object at rest");
    assert!(clipped(|p| p.slides()) > 200, "it has slid under it again");
}

#[test]
fn a_load_that_falls_as_the_gripper_stops_gaining_speed_is_held_and_one_that_stays_is_clipped() {
    // A gain of 1.5 m/s2 for 40 ms.
    let held = |t: f32| match t {
        t if t < 1.0 => 0.02,
        t if t < 1.04 => 0.39,
        _ => 0.345,
    };
    assert_eq!(clipped_while(400, held, 240..265).0, Vec::<u32>::new());
    let slides = |t: f32| if t < 1.0 { 0.02 } else { 0.37 };
    let first = *clipped_while(400, slides, 240..265).0.first().expect("clipped");
    assert!((265..268).contains(&first), "tick {first}");
}

#[test]
fn friction_is_learnt_from_the_flat_top_of_a_knock_and_not_below_what_was_held() {
    let ceiling = clipped(400, knock(0.5, 0.3)).1.expect("a ceiling");
    assert!((ceiling - 0.3).abs() < 0.015, "{ceiling}");
    let mut friction = Friction::new(0.4f32);
    friction.cap(ceiling);
    assert_eq!(friction.estimate(), ceiling);
    for _ in 0..1000 {
        friction.learn(&held(0.35, None), DT);
    }
    friction.cap(ceiling);
    assert!(friction.estimate() > 0.34, "{}", friction.estimate());
}

/// First sample in which fingers that bear `share(t)` of the weight, noise 3 %, let it fall.
fn falls(ticks: u32, share: impl Fn(f32) -> f32) -> Option<u32> {
    let (mut bearing, mut noise) = (Bearing::default(), Noise(23));
    (0..ticks).find(|tick| {
        let measured = share(*tick as f32 * DT) + 0.03 * noise.next();
        bearing.falls(Some([measured, 1.0]), false, false, DT) > 0
    })
}

#[test]
fn fingers_that_bear_a_tenth_less_are_told_within_40_ms_and_noise_is_not_in_an_hour() {
    let tick = falls(1000, |t| if t < 2.0 { 1.0 } else { 0.9 }).expect("falls");
    assert!((500..510).contains(&tick), "tick {tick}");
    assert_eq!(falls(HOUR, |_| 1.0), None);
    // A weight that is not what was told proves nothing.
    assert_eq!(falls(1000, |t| if t < 2.0 { 1.4 } else { 1.2 }), None);
}

#[test]
fn a_fifth_of_the_weight_that_is_lost_is_told_within_40_ms_whatever_the_noise() {
    for sigma in [1e-4, 1e-3, 0.003, 0.01, 0.03] {
        let (mut bearing, mut noise) = (Bearing::default(), Noise(29));
        let first = (0..3000u32).find(|tick| {
            let share = if *tick < 2500 { 1.0f32 } else { 0.8 };
            bearing.falls(Some([share + sigma * noise.next(), 1.0]), *tick < 32, false, DT) > 0
        });
        let tick = first.unwrap_or_else(|| panic!("noise {sigma}: never told"));
        assert!((2500..2510).contains(&tick), "noise {sigma}: tick {tick}");
    }
}

/// Mean needed coefficient, and mean length, of a load of 0.3 along Z under broadband noise: along the face, of the torsion.
fn needed_under(noise: [f32; 2]) -> [f32; 2] {
    let mut load = LoadNoise::new(LoadParams::default());
    let mut sources = [11, 12, 13].map(|seed| Slow(Noise(seed), 0.0));
    let (mut sum, mut length) = (0.0, 0.0);
    for tick in 0..HOUR / 10 {
        let [x, y, z] = &mut sources;
        let q = Vec3::new(noise[0] * x.next(), noise[1] * y.next(), 0.3 + noise[0] * z.next());
        let needed = load.needed(&q, tick < 32).ratio;
        if tick >= 250 {
            sum += needed;
            length += q.norm();
        }
    }
    [sum, length].map(|s| s / (HOUR / 10 - 250) as f32)
}

#[test]
fn noise_as_large_as_half_the_load_adds_less_than_a_twentieth_to_what_it_needs() {
    let [needed, length] = needed_under([0.07, 0.14]);
    assert!((needed - 0.3).abs() < 0.015, "{needed}");
    // The length of the vector itself.
    assert!(length > 0.335, "{length}");
    let [needed, _] = needed_under([0.001, 0.002]);
    assert!((needed - 0.3).abs() < 1e-3, "{needed}");
}

/// Samples in which an observer that sees no pose takes a load of 4 N for clipped while the grip is commanded by `grip_n`, and
/// the normal force follows within some samples. Friction told: 0.4.
fn over_while(ticks: u32, grip_n: impl Fn(u32) -> f32, load_n: impl Fn(u32) -> f32) -> Vec<u32> {
    let (mut observer, mut noise) = (Observer::new(0.4f32), Noise(31));
    let mut normal_n = grip_n(0);
    (0..ticks)
        .filter(|tick| {
            let grip_n = grip_n(*tick);
            normal_n += (grip_n - normal_n) * 0.3;
            let half_n = 0.5 * load_n(*tick);
            let wrench = |sign: f32, noise: &mut Noise| {
                Some([0.01 * noise.next(), sign * normal_n, half_n + 0.01 * noise.next(), 0.0, 0.0, 0.0])
            };
            let measured = [wrench(-1.0, &mut noise), wrench(1.0, &mut noise)];
            observer.tare(&measured, &measured.map(Option::unwrap), *tick < 32);
            let seen = observer.observe(&Seen {
                wrenches: &measured,
                grip_n,
                points_m: None,
                gripper_m_s: Vec3::zeros(),
                arm_m: 0.005,
                bearing_n: Some([2.0 * half_n, 2.0 * half_n]),
                steered: false,
                accelerates: false,
                effects: 1.0,
                sliding: 1.0,
                dt_s: DT,
            });
            seen.over_s > 0.0
        })
        .collect()
}

#[test]
fn a_grip_that_is_commanded_down_to_a_level_that_holds_clips_no_load() {
    // To nine tenths of the friction told; the same ratio by a load that jumps may be clipped.
    let step = |tick: u32| if tick < 500 { 7.0 } else { 5.55 };
    assert_eq!(over_while(900, step, |_| 4.0), Vec::<u32>::new());
    let jump = |tick: u32| if tick < 500 { 4.0 } else { 5.05 };
    assert!(!over_while(900, |_| 7.0, jump).is_empty());
}

/// Noise of unit variance through a low-pass, of which 0.6 is left a sample later.
struct Slow(Noise, f32);

impl Slow {
    fn next(&mut self) -> f32 {
        self.1 = 0.6 * self.1 + 0.8 * self.0.next();
        self.1
    }
}

#[test]
fn a_light_object_under_broadband_force_noise_is_not_told_to_fall_once_the_noise_is_learnt() {
    let (mut bearing, mut noise) = (Bearing::default(), Slow(Noise(3), 0.0));
    // 70 g, 0.3 N of noise.
    let falls: Vec<u32> = (0..HOUR / 4)
        .filter(|_| bearing.falls(Some([0.7 + 0.3 * noise.next(), 0.7]), false, false, DT) == 1)
        .filter(|tick| *tick > 250)
        .collect();
    assert!(falls.is_empty(), "at ticks {falls:?}");
}

/// How often broadband noise of 0.07 on a load of 0.41 is taken for a clipped load in a quarter of an hour; the bar is 0.5.
fn clipped_by_broadband_noise(params: PlateauParams<f32>) -> u32 {
    let (mut plateau, mut noise) = (Plateau::new(params), Slow(Noise(4), 0.0));
    let mut level = 0.41;
    let mut clipped = 0;
    for _ in 0..HOUR / 4 {
        let now: f32 = 0.41 + 0.07 * noise.next();
        level += (now - level) * DT / 0.5;
        let samples = plateau.clipped(&Bars {
            now,
            level,
            noise: 0.05,
            held: 0.0,
            steered: false,
            accelerates: false,
            risen: 0.5,
            jumped: 0.5,
            sliding: 1.0,
        });
        clipped += u32::from(samples == 5);
    }
    clipped
}

#[test]
fn broadband_noise_that_reaches_over_the_bar_is_a_clipped_load_a_third_as_often_by_its_level() {
    let without = PlateauParams { level_sigmas: 0.0, ..PlateauParams::default() };
    let (without, with) =
        (clipped_by_broadband_noise(without), clipped_by_broadband_noise(PlateauParams::default()));
    assert!(with * 3 <= without, "{with} in place of {without}");
}

#[test]
fn a_flat_top_far_below_the_told_friction_was_held() {
    for (top, believed) in [(0.52, true), (0.33, false)] {
        let mut friction = Friction::new(0.62f32);
        friction.cap(top);
        assert_eq!(friction.estimate() < 0.6, believed, "{top}: {}", friction.estimate());
    }
}
