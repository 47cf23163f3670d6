//! `trials.csv` and the table of each trial.

use crate::dataset::DataSet;
use crate::error::Error;
use crate::sensors::Row;
use crate::trial::TrialSpec;

const POSE: [&str; 7] = ["x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"];
const WRENCH: [&str; 6] = ["fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm"];

fn text(writer: csv::Writer<Vec<u8>>) -> Result<String, Error> {
    let bytes = writer.into_inner().map_err(|e| csv::Error::from(e.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// At most `digits` after the point, without trailing zeros.
fn number(value: f64, digits: usize) -> String {
    let s = format!("{value:.digits$}");
    let s = if s.contains('.') { s.trim_end_matches('0').trim_end_matches('.') } else { &s };
    if s == "-0" { "0".into() } else { s.into() }
}

/// Index of the trials.
pub fn trials_csv(set: &DataSet) -> Result<String, Error> {
    let mut out = csv::Writer::from_writer(Vec::new());
    let mut head: Vec<String> =
        "trial,file,object,primitive,grip_n,speed_m_s,speed_rad_s,slope_rad,pusher_offset_m,run"
            .split(',')
            .map(String::from)
            .collect();
    head.extend(POSE.iter().map(|p| format!("pusher_{p}")));
    out.write_record(&head)?;
    for t in &set.trials {
        let cell = |x: Option<f64>| x.map_or(String::new(), |x| number(x, 6));
        let mut row = vec![
            t.id.clone(),
            format!("trials/{}.csv", t.id),
            set.reality.objects[t.object].id.clone(),
            t.primitive.clone(),
            cell(t.grasped.then_some(t.grip_n)),
            cell(t.speed_m_s),
            cell(t.speed_rad_s),
            cell(t.slope_rad),
            cell(t.offset_m),
            t.run.to_string(),
        ];
        match &t.pusher {
            Some((_, m)) if m.parts.is_empty() => {
                let (p, q) = (m.start, m.rotation);
                row.extend([p.x, p.y, p.z].map(|x| number(x, 8)));
                row.extend([q.w, q.i, q.j, q.k].map(|x| number(x, 9)));
            }
            _ => row.extend(vec![String::new(); 7]),
        }
        out.write_record(&row)?;
    }
    text(out)
}

/// The table of one trial.
pub fn trial_csv(set: &DataSet, trial: &TrialSpec, rows: &[Row]) -> Result<String, Error> {
    let moving = rows.first().is_some_and(|r| r.pusher.is_some());
    let measured = rows.first().is_some_and(|r| r.pusher_wrench.is_some());
    let mut head = vec!["t_s".to_owned()];
    let mut block = |body: &str, columns: &[&str]| {
        head.extend(columns.iter().map(|c| format!("{body}_{c}")));
    };
    if trial.grasped {
        block("grip", &["cmd_n"]);
        block("gripper", &POSE);
    }
    block("object", &POSE);
    if moving {
        block("pusher", &POSE);
    }
    if trial.grasped {
        block("finger1", &WRENCH);
        block("finger2", &WRENCH);
    }
    if measured {
        block("pusher", &WRENCH);
    }
    let mut out = csv::Writer::from_writer(Vec::new());
    out.write_record(&head)?;
    let stepped = set.reality.sensors.steps;
    let digits = |step: f64| if step > 0.0 { (-step.log10()).ceil().max(0.0) as usize } else { 9 };
    let (force, torque) = (digits(stepped[0]), digits(stepped[1]));
    for r in rows {
        let mut row = vec![number(r.t_s, 6)];
        let pose = |p: &[f64; 7]| -> Vec<String> {
            (0..7).map(|i| number(p[i], if i < 3 { 8 } else { 9 })).collect()
        };
        let wrench = |w: &[f64; 6]| -> Vec<String> {
            (0..6).map(|i| number(w[i], if i < 3 { force } else { torque })).collect()
        };
        if trial.grasped {
            row.push(number(r.grip_cmd_n, 6));
            row.extend(pose(&r.gripper));
        }
        row.extend(r.object.as_ref().map_or(vec![String::new(); 7], pose));
        row.extend(r.pusher.iter().flat_map(pose));
        if trial.grasped {
            row.extend(wrench(&r.fingers[0]));
            row.extend(wrench(&r.fingers[1]));
        }
        row.extend(r.pusher_wrench.iter().flat_map(wrench));
        out.write_record(&row)?;
    }
    text(out)
}
