//! The key: what is hidden, and what truly happened. A blind test opens it only to score.

use serde_json::{Map, Value, json};

use crate::dataset::{DataSet, Run};
use crate::error::Error;

/// The key of a data set.
pub fn json(set: &DataSet, runs: &[Run]) -> Result<String, Error> {
    let key = if set.bench.is_some() { bench(set, runs)? } else { grasps(set, runs) };
    let mut text = serde_json::to_string_pretty(&key)?;
    text.push('\n');
    Ok(text)
}

fn bench(set: &DataSet, runs: &[Run]) -> Result<Value, Error> {
    let r = &set.reality;
    let trials: Map<String, Value> = set
        .trials
        .iter()
        .zip(runs)
        .map(|(t, run)| {
            (t.id.clone(), json!({ "numbers": run.numbers, "step_s": run.step_s, "drop": run.truth.drop_s }))
        })
        .collect();
    Ok(json!({
        "seed": set.seed,
        "family": set.family,
        "kind": "bench",
        "effects": set.effects,
        "friction": {
            "finger": r.finger.mu,
            "pusher": r.pusher.law.mu,
            "support": r.table.law.mu,
        },
        "pad_tangential_n_m": r.pad.shear_n_m,
        "pad_normal_n_m": r.pad.shear_n_m * r.pad.normal_ratio,
        "reality": serde_json::to_value(r)?,
        "plan": serde_json::to_value(&set.bench)?,
        "trials": trials,
    }))
}

fn grasps(set: &DataSet, runs: &[Run]) -> Value {
    let r = &set.reality;
    let told = r.break_away_mu() * r.told_factor;
    let trials: Map<String, Value> = set
        .trials
        .iter()
        .zip(runs)
        .map(|(t, run)| {
            let o = &r.objects[t.object];
            let mut row = t.note.clone();
            let kinetic = 0.5 * (run.numbers.mu_finger[0] + run.numbers.mu_finger[1]);
            let mu = kinetic * r.finger.static_ratio;
            let episodes: Vec<_> =
                run.truth.episodes.iter().map(|e| json!([e.start_s, e.end_s, e.slip_m])).collect();
            let partial: Vec<_> =
                run.truth.partial.iter().map(|p| json!([p.start_s, p.end_s, p.share, p.plastic_m])).collect();
            row.insert("object".into(), json!(o.id));
            row.insert("mass".into(), json!(run.numbers.mass_kg));
            row.insert("mu".into(), json!(mu));
            row.insert("mu_kinetic".into(), json!(kinetic));
            row.insert("told".into(), json!(told));
            row.insert("K".into(), json!(r.pad.shear_n_m));
            row.insert("grip".into(), json!(t.grip_n));
            row.insert("episodes".into(), json!(episodes));
            row.insert("partial".into(), json!(partial));
            row.insert("about_slips".into(), json!(run.about_slips));
            row.insert("drop".into(), json!(run.truth.drop_s));
            row.insert("seconds".into(), json!(run.rows.last().map_or(0.0, |x| x.t_s)));
            (t.id.clone(), Value::Object(row))
        })
        .collect();
    let objects: Vec<_> = r
        .objects
        .iter()
        .map(|o| json!({"id": o.id, "m": o.mass_kg, "L": o.length_m, "s": o.side_m}))
        .collect();
    json!({
        "seed": set.seed,
        "family": set.family,
        "kind": "grasps",
        "effects": set.effects,
        "dataset": {
            "mu": r.break_away_mu(),
            "mu_kinetic": r.finger.mu,
            "told": told,
            "K": r.pad.shear_n_m,
            "zeta": r.pad.damping_ratio,
            "R": r.pad.radius_m,
            "pos": r.sensors.position_noise_m,
            "rot": r.sensors.rotation_noise_rad,
            "objects": objects,
        },
        "reality": r,
        "trials": trials,
    })
}
