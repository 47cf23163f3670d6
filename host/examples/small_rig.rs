//! Writes a small data set made by the rig, for trying `compare` on: `small_rig FOLDER [EFFECT STRENGTH]`.
use stickslip_host::dataset::{Dataset, write};
use stickslip_host::rig::objects::{bench, trimmed};
use stickslip_host::rig::{
    Condition, HiddenEffect, Kind, Nuisance, Primitive, Reality, STEP_S, Setup, simulate,
};

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let description = trimmed(bench("small"), &["linear_push"], &["obj4", "obj5"]);
    let mut reality = Reality::draw(&description, Nuisance::PAPER, 7);
    if let Some(name) = args.get(2) {
        let kind = *Kind::ALL.iter().find(|k| k.name() == name).expect("an effect");
        let strength = args.get(3).map_or(kind.typical_strength(), |s| s.parse().expect("a number"));
        reality.effects.push(HiddenEffect { kind, strength });
    }
    let setup = Setup { description: description.clone(), reality, step_s: STEP_S };
    let mut conditions = Vec::new();
    for object in ["obj4", "obj5"] {
        for grip_n in [20.0, 35.0] {
            for speed_m_s in [0.01, 0.03] {
                let mut c = Condition::new(Primitive::LinearPush, object);
                c.label = format!("push-{object}-{grip_n}N-{}mms", speed_m_s * 1e3);
                (c.grip_n, c.speed_m_s, c.travel) = (grip_n, speed_m_s, 0.008);
                conditions.push(c);
            }
        }
    }
    use rayon::prelude::*;
    let jobs: Vec<(usize, usize)> = (0..conditions.len()).flat_map(|c| (0..3).map(move |r| (c, r))).collect();
    let trials =
        jobs.par_iter().map(|(c, r)| simulate(&setup, &conditions[*c], *r, 7).expect("a trial")).collect();
    let folder = std::path::PathBuf::from(&args[1]);
    write(&Dataset { folder: folder.clone(), description, trials }, &folder).expect("written");
}
