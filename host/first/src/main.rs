//! A first look, while the rest is being built: the predictor over a recorded push, as the board runs it.
//!
//! `stickslip replay` does the same for any data set and says more. Here the object, the plan and the columns of the file
//! are written down, so that nothing but the crate `shared` must be compiled.

use std::error::Error;
use std::time::Instant;

use stickslip_shared::model::{Base, FingerContact, Friction, Model, Object, PusherContact, Scene, Shape};
use stickslip_shared::predictor::{Intent, Limits, Plan, Predictor, Segment, flags};
use stickslip_shared::shape::inertia;
use stickslip_shared::wire::{Pose, Sample};

/// The paper's push of `obj4`: grip 20 N, 10 mm/s against a flat pusher.
const FILE: &str = "data/demo/trials/linear_push-obj4-g20-v10-s0-r1.csv";

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args().nth(1).unwrap_or_else(|| FILE.to_owned());
    let text =
        std::fs::read_to_string(&file).map_err(|error| format!("{file}: {error}; run it at the top"))?;
    let samples = samples(&text)?;
    let mut predictor = Predictor::new(scene(), model(), Limits::default())
        .map_err(|fault| format!("the predictor refuses the model: {fault:?}"))?;
    predictor.set_plan(plan()?);

    println!(
        "A recorded push, sample by sample through the predictor that the board runs (this machine, same source):"
    );
    println!("{file}: {} samples at 250 Hz\n", samples.len());
    println!("   time   friction used        push force        sag of the object");
    println!("          sensors    model     measured  model   measured  model   prediction");
    let (began, first_m) = (Instant::now(), samples[0].1[0]);
    let (mut before, mut said) = (0, -1.0);
    for (sample, [height_m, push_n]) in &samples {
        let p = predictor.take(sample);
        let t_s = f64::from(sample.t_us) * 1e-6;
        let rose = p.flags & !before;
        before = p.flags;
        let events: Vec<String> = [
            (flags::SLIP_AHEAD_1, "slip of finger 1 is ahead"),
            (flags::SLIP_AHEAD_2, "slip of finger 2 is ahead"),
            (flags::SLIP_1, "finger 1 slips"),
            (flags::SLIP_2, "finger 2 slips"),
            (flags::DROP, "the object will be lost"),
        ]
        .into_iter()
        .filter(|(flag, _)| rose & flag != 0)
        .map(|(flag, words)| match flag {
            flags::SLIP_AHEAD_1 | flags::SLIP_AHEAD_2 => {
                let finger = usize::from(flag == flags::SLIP_AHEAD_2);
                format!("{words}, in {:.0} ms", 1e3 * p.finger[finger].slip.in_s().unwrap_or(0.0))
            }
            _ => words.to_owned(),
        })
        .collect();
        if t_s - said > 0.25 || !events.is_empty() {
            said = t_s;
            let used = p.finger[0].measured_utilisation.map_or("-".to_owned(), |share| format!("{share:.2}"));
            println!(
                "{t_s:6.2} s     {used:>4}     {:4.2}      {push_n:5.1} N  {:5.1} N   {:5.2} mm  {:5.2} mm  {}",
                p.finger[0].model_utilisation,
                p.pusher_force_n[0],
                (first_m - height_m) * 1e3,
                p.sag_m * 1e3,
                events.join("; ")
            );
        }
    }
    let each_us = began.elapsed().as_secs_f64() * 1e6 / samples.len() as f64;
    println!("\n{} predictions, {each_us:.0} us each; a sample comes every 4000 us.", samples.len());
    Ok(())
}

/// A prism of aluminium between disc-shaped pads, a flat pusher.
fn scene() -> Scene<f32> {
    let (shape, mass_kg) = (Shape::Prism { length_m: 0.1, side_m: 0.025 }, 0.2005);
    Scene {
        gravity_m_s2: [0.0, 0.0, -9.81],
        object: Object { inertia_kg_m2: inertia(&shape, mass_kg), shape, mass_kg },
        fingers: Some(FingerContact::Disc { diameter_m: 0.02 }),
        pusher: Some(PusherContact::Plane),
        support: None,
    }
}

/// Rigid contact with the friction of the paper's pads.
fn model() -> Model<f32> {
    Model::base(Base::Hard, Friction { finger: 0.4, pusher: 0.25, support: 0.3 })
}

/// What the gripper means to do: wait, slide along the object, hold.
fn plan() -> Result<Plan, Box<dyn Error>> {
    let mut plan = Plan::default();
    for (duration_s, speed_m_s, intent) in
        [(0.2, 0.0, Intent::Hold), (1.5, -0.01, Intent::Slide), (10.0, 0.0, Intent::Hold)]
    {
        let velocity_m_s = [speed_m_s, 0.0, 0.0];
        let segment = Segment { duration_s, velocity_m_s, grip_n: 20.0, intent, ..Segment::default() };
        plan.segments.push(segment).map_err(|_| "a plan has at most eight segments")?;
    }
    Ok(plan)
}

/// A sample as the board takes it; the object's height (m) and the push force (N) as measured.
type Recorded = (Sample, [f32; 2]);

/// The rows of the file.
fn samples(text: &str) -> Result<Vec<Recorded>, Box<dyn Error>> {
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().ok_or("the file is empty")?.split(',').collect();
    let place =
        |name: &str| header.iter().position(|h| *h == name).ok_or_else(|| format!("no column {name}"));
    let places = |body: &str, ends: &[&str]| -> Result<Vec<usize>, String> {
        ends.iter().map(|end| place(&format!("{body}_{end}"))).collect()
    };
    let pose = ["x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"];
    let wrench = ["fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm"];
    let (gripper, object) = (places("gripper", &pose)?, places("object", &pose)?);
    let fingers = [places("finger1", &wrench)?, places("finger2", &wrench)?];
    let (time, grip, push) = (place("t_s")?, place("grip_cmd_n")?, place("pusher_fx_n")?);
    let mut samples = Vec::new();
    for (seq, line) in (0..).zip(lines) {
        let cells: Vec<f32> = line
            .split(',')
            .map(|cell| cell.parse().map_err(|_| format!("{cell:?} is no number")))
            .collect::<Result<_, _>>()?;
        let at = |places: &[usize], k: usize| cells[places[k]];
        let pose = |places: &[usize]| {
            Some(Pose {
                position_m: std::array::from_fn(|k| at(places, k)),
                quaternion: std::array::from_fn(|k| at(places, 3 + k)),
            })
        };
        let sample = Sample {
            seq,
            t_us: (cells[time] * 1e6).round() as u32,
            grip_cmd_n: cells[grip],
            gripper: pose(&gripper),
            object: pose(&object),
            // It stands still at the end of the object.
            pusher: Some(Pose { position_m: [-0.0503, 0.0, 0.0], quaternion: [1.0, 0.0, 0.0, 0.0] }),
            finger: fingers.each_ref().map(|places| Some(std::array::from_fn(|k| at(places, k)))),
        };
        samples.push((sample, [at(&object, 2), cells[push]]));
    }
    Ok(samples)
}
