//! Draws a whole data set: rig, objects, hidden effects, plan; then runs it.

use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::Serialize;

use crate::error::Error;
use crate::families::{Family, Plan};
use crate::hidden::{Applied, CATALOGUE, Effect, Scale};
use crate::physics::friction::{Kind, Law};
use crate::physics::jaw::JawSpec;
use crate::physics::layout::Profile;
use crate::physics::record::{Record, Sample};
use crate::physics::slip::Truth;
use crate::plan::bench::{BenchPlan, Primitive};
use crate::plan::grasps;
use crate::random::{chance, log_uniform, pick, sign, stream, uniform};
use crate::reality::{Counterpart, ObjectSpec, Pad, Reality, Scatter};
use crate::scene::{RunTruth, world};
use crate::sensors::{Faults, PoseRate, Row, Sensors, Stated, read};
use crate::trial::TrialSpec;

/// Everything about a data set before it is run.
#[derive(Clone, Debug, Serialize)]
pub struct DataSet {
    /// Seed.
    pub seed: u64,
    /// Name of the family.
    pub family: &'static str,
    /// Hidden effects.
    pub effects: Vec<Applied>,
    /// The rig.
    pub reality: Reality,
    /// Levels of the bench; `None` for grasps.
    pub bench: Option<BenchPlan>,
    /// Trials in order.
    pub trials: Vec<TrialSpec>,
}

/// Effects by name, each with its level, drawn where `None`.
pub type Chosen = Vec<(String, Option<f64>)>;

/// What the caller fixes; the rest is drawn.
#[derive(Clone, Debug, Default)]
pub struct Wish {
    /// Effects with their level (drawn where `None`), in place of drawn ones; empty for none hidden.
    pub effects: Option<Chosen>,
    /// Most trials of a bench, trials of a set of grasps.
    pub trials: Option<usize>,
}

/// A trial as it was run.
pub struct Run {
    /// Rows to write.
    pub rows: Vec<Row>,
    /// What happened.
    pub truth: Truth,
    /// True friction and mass.
    pub numbers: RunTruth,
    /// Time step, s.
    pub step_s: f64,
    /// True place of the object in the gripper along its X and Z about the beginning of each gross slip: time (s), m.
    pub about_slips: Vec<Vec<[f64; 3]>>,
}

/// So long before and after the beginning of a gross slip the true motion is kept, s.
const ABOUT_SLIP_S: [f64; 2] = [0.1, 0.048];

const BENCH_TRIALS: usize = 60;
const GRASP_TRIALS: usize = 44;
/// Levels of effects over the typical strength, log-uniform.
const LEVELS: [f64; 2] = [0.3, 2.5];

impl DataSet {
    /// Draws a data set. Unknown effects are refused.
    pub fn draw(family: &'static Family, seed: u64, wish: &Wish) -> Result<Self, Error> {
        let bench = matches!(family.plan, Plan::Bench(_));
        let rng = &mut stream(seed, &format!("rig {}", family.name));
        let primitives: Vec<Primitive> = match family.plan {
            Plan::Bench(sets) => pick(rng, sets).to_vec(),
            Plan::Grasps(_) => Vec::new(),
        };
        let planar = primitives == [Primitive::PlanarPush];
        let objects = draw_objects(&primitives, bench, rng);
        let mut reality = draw_reality(family, objects, bench, rng);
        let plan_rng = &mut stream(seed, &format!("plan {}", family.name));
        let mut plan = None;
        if bench {
            let most = wish.trials.unwrap_or(BENCH_TRIALS);
            let p = BenchPlan::draw(plan_rng, &primitives, &reality.objects, reality.finger.mu, most);
            let middle = p.grips_n.iter().sum::<f64>() / p.grips_n.len() as f64;
            reality.pad.reference_n = middle;
            reality.finger.load_reference_n = middle;
            plan = Some(p);
        } else {
            let heavy = reality.objects.iter().map(|o| o.mass_kg).sum::<f64>() / 3.0;
            reality.pad.reference_n = heavy * 9.81 / reality.finger.mu;
            reality.finger.load_reference_n = reality.pad.reference_n;
        }
        let effect_rng = &mut stream(seed, &format!("effects {}", family.name));
        let scale = |level: f64| {
            let (speed_m_s, distance_m) = plan.as_ref().map_or((0.02, 0.01), |p: &BenchPlan| {
                ((p.speeds_m_s[0] * p.speeds_m_s[1]).sqrt(), p.distance_m)
            });
            Scale { level, speed_m_s, distance_m, grasped: !planar }
        };
        let chosen = match &wish.effects {
            Some(list) => named_effects(list)?,
            None if bench => draw_effects(&primitives, &reality, effect_rng),
            None => Vec::new(),
        };
        let mut effects = Vec::new();
        for (effect, level) in chosen {
            let level = level.unwrap_or_else(|| log_uniform(effect_rng, LEVELS[0], LEVELS[1]));
            effects.push(effect.apply(&mut reality, scale(level), effect_rng));
        }
        let trials = match family.plan {
            Plan::Bench(_) => plan.as_ref().map_or(Vec::new(), |p| p.trials(&reality.objects, plan_rng)),
            Plan::Grasps(weights) => {
                grasps::trials(&reality, weights, wish.trials.unwrap_or(GRASP_TRIALS), plan_rng)
            }
        };
        Ok(Self { seed, family: family.name, effects, reality, bench: plan, trials })
    }

    /// Runs all trials, in parallel; the same bytes whatever the number of threads.
    pub fn run(&self) -> Vec<Run> {
        self.trials.par_iter().map(|trial| self.run_one(trial)).collect()
    }

    /// Runs one trial.
    pub fn run_one(&self, trial: &TrialSpec) -> Run {
        let (world, numbers) = world(&self.reality, trial, self.seed);
        let record = world.run();
        let rows = read(&self.reality.sensors, trial, &record, self.seed);
        let about_slips = record.truth.episodes.iter().map(|e| about(&record, e.start_s)).collect();
        Run { rows, truth: record.truth, numbers, step_s: record.step_s, about_slips }
    }
}

/// True motion in the grasp about a moment.
fn about(record: &Record, at_s: f64) -> Vec<[f64; 3]> {
    let [before, after] = ABOUT_SLIP_S;
    let near = |s: &&Sample| (at_s - before..=at_s + after).contains(&s.t_s);
    let place = |s: &Sample| {
        let way = s.gripper.rotation.inverse() * (s.object.position - s.gripper.position);
        [s.t_s, way.x, way.z]
    };
    record.samples.iter().filter(near).map(place).collect()
}

fn named_effects(list: &[(String, Option<f64>)]) -> Result<Vec<(&'static Effect, Option<f64>)>, Error> {
    list.iter()
        .map(|(id, level)| {
            let effect = Effect::named(id).ok_or_else(|| Error::UnknownEffect(id.clone()))?;
            Ok((effect, *level))
        })
        .collect()
}

/// Nothing (12 %), one listed effect (58 %), two (18 %), one that nobody lists (12 %).
fn draw_effects(
    primitives: &[Primitive],
    r: &Reality,
    rng: &mut ChaCha8Rng,
) -> Vec<(&'static Effect, Option<f64>)> {
    let fits = |e: &Effect| {
        primitives.iter().any(|p| e.shows_in.contains(p))
            // Soft pads in place of pads that are soft already are no effect.
            && !(e.id == "contact_compliance" && r.pad.shear_n_m < 2e5)
    };
    let of = |listed: bool| CATALOGUE.iter().filter(|e| e.listed() == listed && fits(e)).collect::<Vec<_>>();
    let (listed, outside) = (of(true), of(false));
    let case = uniform(rng, 0.0, 1.0);
    if case < 0.12 || listed.is_empty() {
        return Vec::new();
    }
    if case >= 0.88 && !outside.is_empty() {
        return vec![(pick(rng, &outside), None)];
    }
    let first = pick(rng, &listed);
    if case < 0.70 || listed.len() < 2 {
        return vec![(first, None)];
    }
    loop {
        let second = pick(rng, &listed);
        if second.id != first.id {
            return vec![(first, None), (second, None)];
        }
    }
}

fn draw_objects(primitives: &[Primitive], bench: bool, rng: &mut ChaCha8Rng) -> Vec<ObjectSpec> {
    let count = if !bench {
        3
    } else if primitives == [Primitive::PlanarPush] || chance(rng, 0.6) {
        1
    } else {
        2
    };
    let round = primitives.contains(&Primitive::Roll);
    (0..count)
        .map(|i| {
            let side_m = (uniform(rng, 0.022, if bench { 0.04 } else { 0.07 }) * 1e3).round() / 1e3;
            let length_m = (side_m * uniform(rng, 1.8, 4.0)).clamp(0.07, 0.16);
            let length_m = (length_m * 1e3).round() / 1e3;
            let volume = length_m * side_m * side_m * if round { 0.785 } else { 1.0 };
            let density = log_uniform(rng, if bench { 900.0 } else { 300.0 }, 2800.0);
            let mass_kg = (volume * density).clamp(0.05, if bench { 0.5 } else { 0.9 });
            let mass_kg = (mass_kg * 1e4).round() / 1e4;
            ObjectSpec { id: format!("block{}", i + 1), round, length_m, side_m, mass_kg }
        })
        .collect()
}

fn draw_reality(f: &Family, objects: Vec<ObjectSpec>, bench: bool, rng: &mut ChaCha8Rng) -> Reality {
    let narrow = objects.iter().map(|o| o.side_m).fold(1.0, f64::min);
    let poor_jaw = chance(rng, f.poor_jaw);
    let kind = pick(rng, f.kinds);
    let mut finger = Law::coulomb(if bench { uniform(rng, 0.25, 0.7) } else { uniform(rng, 0.3, 0.9) });
    finger.kind = kind;
    if !bench && kind != Kind::Dahl {
        // Grasps: a Stribeck curve and some viscosity are part of the reality.
        finger.static_ratio = uniform(rng, 1.0, 1.25);
        finger.stribeck_m_s = log_uniform(rng, 1e-3, 1e-2);
        finger.viscous_s_m = uniform(rng, 0.0, 1.0);
    }
    let relaxes = chance(rng, f.relaxes);
    let pad = Pad {
        radius_m: (uniform(rng, 0.28, 0.38) * narrow * 2e3).round() / 2e3,
        radius_factor: 1.0,
        shear_n_m: log_uniform(rng, f.shear_n_m[0], f.shear_n_m[1]),
        shear_per_load: chance(rng, f.per_load),
        reference_n: 20.0,
        normal_ratio: uniform(rng, 1.2, 3.0),
        damping_ratio: log_uniform(rng, f.damping[0], f.damping[1]),
        relaxing_ratio: if relaxes { uniform(rng, 0.1, 0.8) } else { 0.0 },
        relaxation_s: log_uniform(rng, 0.05, 3.0),
        profile: pick(rng, &[Profile::Uniform, Profile::Hertz, Profile::Gaussian]),
        offset_m: [[0.0; 2]; 2],
    };
    let mut counterpart = |mu: f64, low: f64| {
        let normal_n_m = log_uniform(rng, low, 3e6);
        let shear_n_m = normal_n_m * uniform(rng, 0.4, 0.9);
        let mut law = Law::coulomb(mu);
        law.kind = pick(rng, f.kinds);
        Counterpart { law, normal_n_m, shear_n_m, damping_ratio: log_uniform(rng, 0.1, 0.6) }
    };
    let round = objects[0].round;
    let pusher_mu = if round { 2.0 } else { 0.27 };
    let mut pusher = counterpart(pusher_mu, 4e5);
    let mut table = counterpart(0.3, 3e5);
    pusher.law.mu *= uniform(rng, 0.6, 1.4);
    table.law.mu *= uniform(rng, 0.6, 1.6);
    let jaw = JawSpec {
        finger_kg: uniform(rng, 0.05, 0.15),
        damping: uniform(rng, 20.0, 80.0),
        lag_s: if poor_jaw { log_uniform(rng, 0.01, 0.08) } else { log_uniform(rng, 1e-3, 8e-3) },
        stiction_n: if poor_jaw { uniform(rng, 0.05, 0.5) } else { 0.0 },
        ..JawSpec::ideal()
    };
    let scatter = Scatter {
        friction: log_uniform(rng, 0.003, 0.04) * if bench { 1.0 } else { 2.0 },
        other_friction: log_uniform(rng, 0.003, 0.04),
        place_m: log_uniform(rng, 3e-5, 3e-4),
        angle_rad: log_uniform(rng, 2e-4, 2e-3),
        pressure_m: log_uniform(rng, 3e-5, 3e-4),
    };
    let sensors = draw_sensors(f, bench, rng);
    let told_factor = if bench { 1.0 } else { uniform(rng, 0.85, 1.15) };
    Reality {
        objects,
        pad,
        finger,
        mismatch: 0.0,
        pusher,
        table,
        jaw,
        mass_factor: 1.0,
        centre_m: [0.0; 2],
        taper: 0.0,
        wave: [0.0, 1.0, 0.0],
        plate_tilt: [0.0; 2],
        gravity_tilt: [0.0; 2],
        wear: 0.0,
        feet_m: None,
        feet_told: false,
        rolling_arm_m: 0.0,
        spring_n_m: Vector3::zeros(),
        cable: None,
        magnet: None,
        ripple: None,
        scatter,
        sensors,
        told_factor,
    }
}

fn draw_sensors(f: &Family, bench: bool, rng: &mut ChaCha8Rng) -> Sensors {
    let poor = chance(rng, f.poor_sensors);
    let two = |x: f64| format!("{x:.1e}").parse().unwrap_or(x);
    let mut stated = |scale: f64| Stated {
        force_noise_n: two(scale * log_uniform(rng, 0.006, 0.05)),
        force_uncertainty_n: two(scale * uniform(rng, 0.1, 0.4)),
        torque_noise_nm: two(scale * log_uniform(rng, 1.5e-4, 8e-4)),
        torque_uncertainty_nm: two(scale * uniform(rng, 0.0015, 0.005)),
    };
    let finger = stated(1.0);
    let pusher = stated(2.0);
    // Constant errors are stated as bounds; they and their drift stay within.
    let share = uniform(rng, 0.0, 0.7);
    let drift = if poor { uniform(rng, 0.05, 0.5) } else { 0.0 };
    let mut faults = |s: &Stated| {
        let bound = |i: usize| if i < 3 { s.force_uncertainty_n } else { s.torque_uncertainty_nm };
        let bias = std::array::from_fn(|i| uniform(rng, -1.0, 1.0) * share * bound(i));
        let drift_per_min = std::array::from_fn(|i| sign(rng) * drift * 0.5 * bound(i));
        Faults { bias, drift_per_min, ..Faults::none() }
    };
    let faults = [faults(&finger), faults(&finger), faults(&pusher)];
    let rate_hz =
        pick(rng, if bench { &[250.0, 250.0, 250.0, 200.0, 500.0] } else { &[250.0, 250.0, 250.0] });
    let pose_rate = if poor {
        let hz = pick(rng, &[60.0, 120.0]);
        pick(rng, &[PoseRate::Full, PoseRate::Interpolated(hz), PoseRate::Gaps(hz)])
    } else {
        PoseRate::Full
    };
    Sensors {
        rate_hz,
        window_s: pick(rng, &[0.001, 0.001, 0.002, 0.004_f64.min(1.0 / rate_hz)]),
        stated: !(poor && chance(rng, 0.3)),
        finger,
        pusher,
        position_noise_m: two(log_uniform(rng, 8e-6, 8e-5)),
        rotation_noise_rad: two(log_uniform(rng, 1e-4, 8e-4)),
        gripper_noisy: chance(rng, 0.4),
        faults,
        latency_s: 0.0,
        clock_s: if poor { uniform(rng, -1.5, 1.5) / rate_hz } else { uniform(rng, -0.3, 0.3) / rate_hz },
        pose_rate,
        steps: [pick(rng, &[1e-4, 1e-3, 5e-3]), pick(rng, &[1e-6, 2e-5]), pick(rng, &[1e-8, 1e-6, 1e-5])],
        coloured: if poor { uniform(rng, 0.0, 0.6) } else { 0.0 },
        pusher_measured: !f.name.contains("roll") || chance(rng, 0.5),
    }
}
