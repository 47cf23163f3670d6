//! The columns of a trial's table: their names, and a row of cells as a [`Sample`] and back.
//!
//! A cell is an `f64`; NaN is an empty cell (the format has no non-finite numbers).

use super::error::Problem;
use super::{Pose, Sample, Wrench};

/// Columns of a trial's table, in the format's order.
pub const COLUMNS: [&str; 41] = [
    "t_s",
    "grip_cmd_n",
    "gripper_x_m",
    "gripper_y_m",
    "gripper_z_m",
    "gripper_qw",
    "gripper_qx",
    "gripper_qy",
    "gripper_qz",
    "object_x_m",
    "object_y_m",
    "object_z_m",
    "object_qw",
    "object_qx",
    "object_qy",
    "object_qz",
    "pusher_x_m",
    "pusher_y_m",
    "pusher_z_m",
    "pusher_qw",
    "pusher_qx",
    "pusher_qy",
    "pusher_qz",
    "finger1_fx_n",
    "finger1_fy_n",
    "finger1_fz_n",
    "finger1_tx_nm",
    "finger1_ty_nm",
    "finger1_tz_nm",
    "finger2_fx_n",
    "finger2_fy_n",
    "finger2_fz_n",
    "finger2_tx_nm",
    "finger2_ty_nm",
    "finger2_tz_nm",
    "pusher_fx_n",
    "pusher_fy_n",
    "pusher_fz_n",
    "pusher_tx_nm",
    "pusher_ty_nm",
    "pusher_tz_nm",
];

/// One row: NaN where the cell is empty or the column absent.
pub type Cells = [f64; COLUMNS.len()];

/// A row of empty cells.
pub const EMPTY: Cells = [f64::NAN; COLUMNS.len()];

const GRIP: usize = 1;
const GRIPPER: usize = 2;
const OBJECT: usize = 9;
const PUSHER: usize = 16;
/// First columns of finger 1, finger 2 and pusher wrench.
const WRENCHES: [usize; 3] = [23, 29, 35];

/// Place of a column, `None` for a name that the format does not have.
#[must_use]
pub fn position(name: &str) -> Option<usize> {
    COLUMNS.iter().position(|column| *column == name)
}

/// A cell that is refused.
#[derive(Clone, Debug, PartialEq)]
pub struct BadCell {
    /// Index into [`COLUMNS`].
    pub column: usize,
    /// Why.
    pub problem: Problem,
}

/// A pose whose columns are filled in part only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PartialPoses {
    /// Rows with a part of a gripper, object, pusher pose.
    pub rows: [usize; 3],
}

/// Names of the bodies of [`PartialPoses`].
pub const BODIES: [&str; 3] = ["gripper", "object", "pusher"];

/// A row as a sample; poses given in part are taken as not measured and counted.
///
/// # Errors
/// Time that does not rise after `previous_s`, a quaternion off by more than 1 %, negative grip.
pub fn sample(cells: &Cells, previous_s: Option<f64>, partial: &mut PartialPoses) -> Result<Sample, BadCell> {
    let t_s = cells[0];
    let bad = |column, problem| Err(BadCell { column, problem });
    if t_s.is_nan() {
        return bad(0, Problem::EmptyCell("every sample needs its time stamp"));
    }
    if let Some(previous_s) = previous_s
        && t_s <= previous_s
    {
        return bad(0, Problem::TimeNotRising { previous_s });
    }
    let grip = cells[GRIP];
    if grip < 0.0 {
        return bad(GRIP, Problem::Negative("a grip force"));
    }
    let mut poses = [None; 3];
    for ((slot, first), partly) in
        poses.iter_mut().zip([GRIPPER, OBJECT, PUSHER]).zip(partial.rows.iter_mut())
    {
        match pose(&cells[first..first + 7]) {
            Ok(PoseCells::Whole(pose)) => *slot = Some(pose),
            Ok(PoseCells::Absent) => {}
            Ok(PoseCells::Part) => *partly += 1,
            Err(norm) => return bad(first + 3, Problem::QuaternionNorm { norm }),
        }
    }
    let [finger1, finger2, pusher_wrench] = WRENCHES.map(|first| wrench(&cells[first..first + 6]));
    Ok(Sample {
        t_s,
        grip_cmd_n: (!grip.is_nan()).then_some(grip),
        gripper: poses[0],
        object: poses[1],
        pusher: poses[2],
        finger: [finger1, finger2],
        pusher_wrench,
    })
}

/// A sample as a row.
#[must_use]
pub fn cells(sample: &Sample) -> Cells {
    let mut cells = EMPTY;
    cells[0] = sample.t_s;
    cells[GRIP] = sample.grip_cmd_n.unwrap_or(f64::NAN);
    for (first, pose) in
        [GRIPPER, OBJECT, PUSHER].into_iter().zip([sample.gripper, sample.object, sample.pusher])
    {
        if let Some(pose) = pose {
            cells[first..first + 3].copy_from_slice(&pose.position_m);
            cells[first + 3..first + 7].copy_from_slice(&pose.quaternion);
        }
    }
    for (first, wrench) in
        WRENCHES.into_iter().zip([sample.finger[0], sample.finger[1], sample.pusher_wrench])
    {
        if let Some(wrench) = wrench {
            cells[first..first + 3].copy_from_slice(&wrench.force_n);
            cells[first + 3..first + 6].copy_from_slice(&wrench.torque_nm);
        }
    }
    cells
}

/// What seven pose cells hold.
pub(super) enum PoseCells {
    /// A pose, its quaternion normalised.
    Whole(Pose),
    /// Nothing.
    Absent,
    /// Some of it.
    Part,
}

/// `x, y, z, qw, qx, qy, qz`; the error is the norm of a quaternion off by more than 1 %.
pub(super) fn pose(cells: &[f64]) -> Result<PoseCells, f64> {
    let &[x, y, z, w, i, j, k] = cells else {
        return Ok(PoseCells::Part);
    };
    let quaternion = [w, i, j, k];
    if quaternion.iter().all(|q| !q.is_nan()) {
        let pose = Pose { position_m: [x, y, z], quaternion }.normalised()?;
        if [x, y, z].iter().all(|p| !p.is_nan()) {
            return Ok(PoseCells::Whole(pose));
        }
    }
    if cells.iter().all(|cell| cell.is_nan()) { Ok(PoseCells::Absent) } else { Ok(PoseCells::Part) }
}

fn wrench(cells: &[f64]) -> Option<Wrench> {
    let &[fx, fy, fz, tx, ty, tz] = cells else {
        return None;
    };
    cells
        .iter()
        .any(|cell| !cell.is_nan())
        .then_some(Wrench { force_n: [fx, fy, fz], torque_nm: [tx, ty, tz] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_the_ones_of_the_format_in_its_order() {
        let mut names = vec!["t_s".to_owned(), "grip_cmd_n".to_owned()];
        for body in BODIES {
            names.extend(["x", "y", "z"].map(|axis| format!("{body}_{axis}_m")));
            names.extend(["w", "x", "y", "z"].map(|axis| format!("{body}_q{axis}")));
        }
        for body in ["finger1", "finger2", "pusher"] {
            names.extend(["x", "y", "z"].map(|axis| format!("{body}_f{axis}_n")));
            names.extend(["x", "y", "z"].map(|axis| format!("{body}_t{axis}_nm")));
        }
        assert_eq!(names, COLUMNS);
        assert_eq!(COLUMNS[GRIPPER], "gripper_x_m");
        assert_eq!(COLUMNS[OBJECT], "object_x_m");
        assert_eq!(COLUMNS[PUSHER], "pusher_x_m");
        assert_eq!(WRENCHES.map(|first| COLUMNS[first]), ["finger1_fx_n", "finger2_fx_n", "pusher_fx_n"]);
    }

    #[test]
    fn a_quaternion_half_a_per_cent_off_is_normalised_and_one_two_per_cent_off_is_refused() {
        let mut row = EMPTY;
        row[0] = 0.0;
        row[OBJECT..OBJECT + 7].copy_from_slice(&[0.1, 0.2, 0.3, 1.005, 0.0, 0.0, 0.0]);
        let mut partial = PartialPoses::default();
        let read = sample(&row, None, &mut partial).expect("within 1 %");
        assert_eq!(read.object.map(|pose| pose.quaternion), Some([1.0, 0.0, 0.0, 0.0]));
        row[OBJECT + 3] = 1.02;
        let refused = sample(&row, None, &mut partial).expect_err("off by 2 %");
        assert_eq!(refused.column, OBJECT + 3);
    }
}
