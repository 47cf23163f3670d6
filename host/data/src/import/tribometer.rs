//! A reciprocating tribometer's record (FrictionModels.jl, examples/test_data_2.txt) as one
//! contact of our format: finger 1 is the counterface, which presses and slides.
//!
//! Gripper X is the sliding direction: the gripper's position is the measured position about
//! mid-stroke, `finger1_fy_n = -N` presses the object, `finger1_fx_n = -(recorded friction)` drags
//! it (the record's sign is that of the force on the counterface). The object is held: no
//! gravity, pose fixed.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{BadRow, numbers, quantile, sorted};
use crate::{
    ContactSpec, Dataset, Description, FORMAT, ObjectSpec, Pose, Sample, Sensors, Trial, TrialInfo, Wrench,
};

/// Samples below this share of the working load are not loaded.
const LOADED_SHARE: f64 = 0.5;
/// Speeds above this share of the drive's count as sliding: the contact yields elastically over
/// half of each stroke, in which the position moves slower.
const SLIDING_SHARE: f64 = 0.97;

/// What the import checked against physics.
#[derive(Clone, Debug, PartialEq, schemars::JsonSchema, Serialize)]
pub struct Verification {
    /// Rows used.
    pub samples: usize,
    /// Working normal force: 75th percentile.
    pub normal_force_n: f64,
    /// Rows with at least half of that.
    pub loaded: usize,
    /// Full travel while loaded.
    pub stroke_m: f64,
    /// Speed of the drive: 99th percentile of speed.
    pub speed_m_s: f64,
    /// Friction over normal force while sliding: 5 %, median, 95 % of absolute values.
    pub friction_share: [f64; 3],
    /// Share of sliding samples in which friction drags the object along: 1 where the sign is right.
    pub dragging: f64,
    /// Greatest step between time stamps.
    pub gap_s: f64,
}

/// An imported record.
#[derive(Clone, Debug)]
pub struct Import {
    /// In our format, folder not set.
    pub dataset: Dataset,
    /// Physics checks.
    pub verification: Verification,
    /// Rows that could not be used.
    pub bad_rows: Vec<BadRow>,
}

/// What makes a file unusable.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TribometerError {
    /// No row could be read.
    #[error("no row of four numbers (time s, normal uN, position mm, friction uN); see the rows reported")]
    Empty,
}

/// Reads `text`: a header line, then time (s), normal (uN), position (mm), friction (uN).
///
/// # Errors
/// A file without any row. Bad rows are reported in [`Import::bad_rows`].
pub fn import(text: &str, name: &str) -> Result<Import, TribometerError> {
    let mut bad_rows = Vec::new();
    let mut rows: Vec<[f64; 4]> = Vec::new();
    for (line, text) in (1..).zip(text.lines()).filter(|(_, text)| !text.trim().is_empty()) {
        match numbers::<4>(text) {
            Ok(row) if rows.last().is_some_and(|last| row[0] <= last[0]) => {
                bad_rows.push(BadRow::new(line, text, "time does not rise"));
            }
            Ok([t_s, normal_un, position_mm, friction_un]) => {
                rows.push([t_s, normal_un * 1e-6, position_mm * 1e-3, friction_un * 1e-6]);
            }
            // The header is no loss.
            Err(_) if line == 1 && text.contains('[') => {}
            Err(reason) => bad_rows.push(BadRow::new(line, text, reason)),
        }
    }
    if rows.is_empty() {
        return Err(TribometerError::Empty);
    }
    let verification = verify(&rows);
    let loaded = sorted(
        rows.iter().filter(|row| row[1] > LOADED_SHARE * verification.normal_force_n).map(|row| row[2]),
    );
    let middle_m = 0.5 * (quantile(&loaded, 0.0) + quantile(&loaded, 1.0));
    let samples = rows
        .iter()
        .map(|&[t_s, normal_n, position_m, friction_n]| Sample {
            t_s,
            gripper: Some(at_x(position_m - middle_m)),
            object: Some(at_x(0.0)),
            finger: [
                Some(Wrench { force_n: [-friction_n, -normal_n, f64::NAN], torque_nm: [f64::NAN; 3] }),
                None,
            ],
            ..Sample::default()
        })
        .collect();
    let info = TrialInfo {
        trial: "record".to_owned(),
        file: "trials/record.csv".to_owned(),
        object: "specimen".to_owned(),
        primitive: "tribometer".to_owned(),
        grip_n: Some(verification.normal_force_n),
        speed_m_s: Some(verification.speed_m_s).filter(|speed| speed.is_finite()),
        run: Some(1),
        extra: BTreeMap::from([("position_origin_m".to_owned(), middle_m.to_string())]),
        ..TrialInfo::default()
    };
    let dataset = Dataset {
        folder: Default::default(),
        description: describe(name),
        trials: vec![Trial { info, samples }],
    };
    Ok(Import { dataset, verification, bad_rows })
}

fn at_x(x_m: f64) -> Pose {
    Pose { position_m: [x_m, 0.0, 0.0], quaternion: [1.0, 0.0, 0.0, 0.0] }
}

fn verify(rows: &[[f64; 4]]) -> Verification {
    let normal_force_n = quantile(&sorted(rows.iter().map(|row| row[1])), 0.75);
    let is_loaded = |row: &[f64; 4]| row[1] > LOADED_SHARE * normal_force_n;
    let positions = sorted(rows.iter().filter(|row| is_loaded(row)).map(|row| row[2]));
    // Central differences over 20 samples: the position is recorded in steps of 0.1 um.
    let speeds: Vec<(f64, &[f64; 4])> = rows
        .windows(21)
        .filter_map(|window| match window {
            [first, .., last] => Some(((last[2] - first[2]) / (last[0] - first[0]), &window[10])),
            _ => None,
        })
        .filter(|(_, row)| is_loaded(row))
        .collect();
    let speed_m_s = quantile(&sorted(speeds.iter().map(|(speed, _)| speed.abs())), 0.99);
    let sliding: Vec<_> =
        speeds.iter().filter(|(speed, _)| speed.abs() > SLIDING_SHARE * speed_m_s).collect();
    let shares = sorted(sliding.iter().map(|(_, row)| (row[3] / row[1]).abs()));
    let dragging = sliding.iter().filter(|(speed, row)| -row[3] * speed > 0.0).count();
    Verification {
        samples: rows.len(),
        normal_force_n,
        loaded: positions.len(),
        stroke_m: quantile(&positions, 1.0) - quantile(&positions, 0.0),
        speed_m_s,
        friction_share: [0.05, 0.5, 0.95].map(|share| quantile(&shares, share)),
        dragging: dragging as f64 / sliding.len().max(1) as f64,
        gap_s: rows
            .windows(2)
            .map(|pair| match pair {
                [a, b] => b[0] - a[0],
                _ => 0.0,
            })
            .fold(0.0, f64::max),
    }
}

fn describe(name: &str) -> Description {
    Description {
        format: FORMAT.to_owned(),
        name: format!("Reciprocating tribometer, one contact: {name}"),
        sample_rate_hz: 200.0,
        gravity_m_s2: [0.0; 3],
        objects: vec![ObjectSpec {
            id: "specimen".to_owned(),
            shape: "prism".to_owned(),
            // Nominal: neither the specimen's size nor its mass is recorded, nor do they matter
            // to a specimen that is held.
            length_m: Some(0.02),
            side_m: Some(0.01),
            across_flats_m: None,
            vertices_m: None,
            height_m: None,
            mass_kg: 1.0,
            inertia_kg_m2: None,
        }],
        fingers: Some(ContactSpec { contact: "point".to_owned(), ..ContactSpec::default() }),
        pushers: BTreeMap::new(),
        supports: BTreeMap::new(),
        sensors: Sensors::default(),
    }
}
