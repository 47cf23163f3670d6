//! Columns and cells without which the rest means something else.

use stickslip_data::{Description, Trial};

use super::breach::{Breach, Cause, short};

/// Two fingers of one gripper have equal sensors: what one measures, the other does.
pub fn finger_columns(trial: &Trial) -> Option<Breach> {
    let names = ["fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm"];
    let measured: [[bool; 6]; 2] = std::array::from_fn(|finger| {
        std::array::from_fn(|k| {
            trial.samples.iter().filter_map(|s| s.finger[finger]).any(|wrench| {
                let [fx, fy, fz] = wrench.force_n;
                let [tx, ty, tz] = wrench.torque_nm;
                [fx, fy, fz, tx, ty, tz][k].is_finite()
            })
        })
    });
    // One finger without any sensor is a gripper of its kind.
    if measured.iter().any(|finger| !finger.contains(&true)) {
        return None;
    }
    let missing: Vec<String> = (0..2)
        .flat_map(|finger| (0..6).map(move |k| (finger, k)))
        .filter(|(finger, k)| !measured[*finger][*k] && measured[1 - finger][*k])
        .map(|(finger, k)| format!("finger{}_{}", finger + 1, names[k]))
        .collect();
    let columns = format!("column {}", missing.join(", "));
    let text =
        "it is missing or empty, but the other finger measures it; a column lost or misspelt in the header? \
                Without it forces cannot be balanced"
            .to_owned();
    (!missing.is_empty()).then_some(Breach { cause: Cause::MissingColumn, columns, text })
}

/// Finger forces are in gripper axes: without its pose they say nothing about the object.
pub fn gripper(description: &Description, trial: &Trial) -> Option<Breach> {
    let forces = trial.samples.iter().any(|s| s.finger.iter().any(Option::is_some));
    let pose = trial.samples.iter().any(|s| s.gripper.is_some());
    let text =
        "fingers measure forces, but no sample has the gripper's whole pose: the model would leave the \
                gripper out. All seven columns are needed"
            .to_owned();
    let columns = "columns gripper_{x,y,z}_m, gripper_q{w,x,y,z}".to_owned();
    (description.fingers.is_some() && forces && !pose).then_some(Breach {
        cause: Cause::MissingColumn,
        columns,
        text,
    })
}

/// What is grasped is held by a force that must be stated: it tells conditions apart.
pub fn grip(description: &Description, trial: &Trial) -> Option<Breach> {
    let grasped = description.fingers.is_some() && trial.samples.iter().any(|s| s.gripper.is_some());
    if !grasped || trial.info.grip_n.is_some() {
        return None;
    }
    let text = match trial.samples.iter().find_map(|s| s.grip_cmd_n) {
        Some(commanded) => format!(
            "it is empty, but the object is grasped (grip_cmd_n starts at {} N): trials of different grip would \
             count as repetitions of one condition. Write the normal force of each finger",
            short(commanded)
        ),
        None => "it is empty and the table has no grip_cmd_n, but the object is grasped: the model would grip with \
                 0 N. Write the normal force of each finger"
            .to_owned(),
    };
    Some(Breach { cause: Cause::MissingGrip, columns: "trials.csv, column grip_n".to_owned(), text })
}
