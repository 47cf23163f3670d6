//! Axes, levers and signs: a recording's frames as the format's.

use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};
use serde::Deserialize;

use crate::{Pose, Wrench};

/// How axes of a recording become ours.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(untagged)]
pub enum Axes {
    /// Our x, y, z in the recording's axes: `["x", "-z", "y"]`.
    Named([String; 3]),
    /// Unit quaternion `w, x, y, z` that rotates the recording's axes into ours.
    Quaternion([f64; 4]),
}

impl Axes {
    /// The rotation from the recording's axes to ours.
    ///
    /// # Errors
    /// An unknown name, axes that are no right-handed triple, a quaternion off by more than 1 %.
    pub fn rotation(&self) -> Result<UnitQuaternion<f64>, String> {
        match self {
            Axes::Named(names) => {
                let mut rows = [Vector3::zeros(); 3];
                for (row, name) in rows.iter_mut().zip(names) {
                    *row = axis(name)?;
                }
                let matrix = Matrix3::from_rows(&rows.map(|row| row.transpose()));
                let determinant = matrix.determinant();
                if determinant.abs() < 0.5 {
                    return Err(format!("the axes {names:?} use one of x, y, z twice; name each once"));
                }
                if determinant < 0.0 {
                    return Err(format!(
                        "the axes {names:?} are a mirror image, left-handed; turn the sign of one of them"
                    ));
                }
                Ok(UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix)))
            }
            Axes::Quaternion([w, x, y, z]) => {
                let quaternion = Quaternion::new(*w, *x, *y, *z);
                let norm = quaternion.norm();
                if !((norm - 1.0).abs() < 0.01) {
                    return Err(format!("the quaternion's norm is {norm:.4}, not 1; give w, x, y, z"));
                }
                Ok(UnitQuaternion::from_quaternion(quaternion))
            }
        }
    }

    /// In words, for the list of what was assumed.
    #[must_use]
    pub fn words(&self) -> String {
        match self {
            Axes::Named([x, y, z]) => format!("our x, y, z are its {x}, {y}, {z}"),
            Axes::Quaternion(q) => format!("rotated by the quaternion {q:?}"),
        }
    }
}

fn axis(name: &str) -> Result<Vector3<f64>, String> {
    let (sign, letter) = match name.trim() {
        text if text.starts_with('-') => (-1.0, &text[1..]),
        text => (1.0, text.strip_prefix('+').unwrap_or(text)),
    };
    let unit = match letter {
        "x" | "X" => Vector3::x(),
        "y" | "Y" => Vector3::y(),
        "z" | "Z" => Vector3::z(),
        _ => return Err(format!("{name:?} names no axis; write x, -x, y, -y, z or -z")),
    };
    Ok(unit * sign)
}

/// From a sensor's wrench to that on the object, about the reference point, in our axes.
#[derive(Clone, Copy, Debug)]
pub struct WrenchFrame {
    /// From the sensor's axes.
    pub rotation: UnitQuaternion<f64>,
    /// The sensor's origin from the reference point, our axes, m.
    pub origin_m: Vector3<f64>,
    /// Minus one where the sensor reads what acts on the finger or pusher.
    pub sign: f64,
}

impl WrenchFrame {
    /// Force in N, torque in N m about the sensor's origin; NaN stays NaN. A torque moved by a lever needs
    /// all of the force.
    #[must_use]
    pub fn apply(&self, force_n: Vector3<f64>, torque_nm: Vector3<f64>) -> Wrench {
        let force = turn(&self.rotation, &force_n) * self.sign;
        let mut torque = turn(&self.rotation, &torque_nm) * self.sign;
        if self.origin_m != Vector3::zeros() {
            torque += self.origin_m.cross(&force);
        }
        Wrench { force_n: force.into(), torque_nm: torque.into() }
    }
}

/// `rotation * vector` in which a component that was not measured spoils only those that it turns into.
fn turn(rotation: &UnitQuaternion<f64>, vector: &Vector3<f64>) -> Vector3<f64> {
    let matrix = rotation.to_rotation_matrix();
    let matrix = matrix.matrix();
    Vector3::from_fn(|row, _| {
        (0..3)
            .map(|column| (matrix[(row, column)], vector[column]))
            .filter(|(factor, _)| factor.abs() > 1e-12)
            .map(|(factor, component)| factor * component)
            .sum()
    })
}

/// From a tracked body's pose to the pose of our body in our world.
#[derive(Clone, Copy, Debug)]
pub struct PoseFrame {
    /// From the recording's world axes to ours.
    pub world: UnitQuaternion<f64>,
    /// Our world's origin shifted: added to the position, our axes, m.
    pub world_shift_m: Vector3<f64>,
    /// Our body in the tracked body's axes.
    pub body: Isometry3<f64>,
}

impl PoseFrame {
    /// `position_m` and `rotation` as recorded, SI.
    #[must_use]
    pub fn apply(&self, position_m: Vector3<f64>, rotation: UnitQuaternion<f64>) -> Isometry3<f64> {
        let recorded = Isometry3::from_parts(Translation3::from(position_m), rotation);
        let turned = Isometry3::from_parts(Translation3::from(self.world_shift_m), self.world);
        turned * recorded * self.body
    }
}

/// As the format keeps it.
#[must_use]
pub fn pose(of: &Isometry3<f64>) -> Pose {
    Pose::of(&of.translation.vector, &of.rotation)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(names: [&str; 3]) -> Axes {
        Axes::Named(names.map(str::to_owned))
    }

    #[test]
    fn a_y_up_world_becomes_z_up() {
        // Up in the recording is y; it is our z.
        let rotation = named(["x", "-z", "y"]).rotation().expect("right-handed");
        let up = rotation * Vector3::y();
        assert!((up - Vector3::z()).norm() < 1e-15, "{up}");
    }

    #[test]
    fn mirrored_and_repeated_axes_are_refused() {
        assert!(named(["x", "z", "y"]).rotation().expect_err("mirror").contains("left-handed"));
        assert!(named(["x", "x", "y"]).rotation().expect_err("twice").contains("twice"));
        assert!(named(["x", "up", "y"]).rotation().expect_err("no axis").contains("\"up\""));
    }

    #[test]
    fn a_lever_moves_the_torque_and_a_reaction_turns_all_signs() {
        let frame = WrenchFrame {
            rotation: UnitQuaternion::identity(),
            origin_m: Vector3::new(0.0, 0.1, 0.0),
            sign: -1.0,
        };
        // 2 N along x at 0.1 m in y: the torque about the reference is y times x, -0.2 N m about z.
        let moved = frame.apply(Vector3::new(-2.0, 0.0, 0.0), Vector3::zeros());
        assert_eq!(moved.force_n, [2.0, 0.0, 0.0]);
        assert_eq!(moved.torque_nm, [0.0, 0.0, -0.2]);
    }

    #[test]
    fn a_component_that_is_not_measured_spoils_only_what_it_turns_into() {
        let frame = WrenchFrame {
            rotation: named(["y", "-x", "z"]).rotation().expect("right-handed"),
            origin_m: Vector3::zeros(),
            sign: 1.0,
        };
        let of = frame.apply(Vector3::new(1.0, f64::NAN, 3.0), Vector3::repeat(f64::NAN));
        assert!(of.force_n[0].is_nan());
        assert!((of.force_n[1] + 1.0).abs() < 1e-12 && (of.force_n[2] - 3.0).abs() < 1e-12, "{of:?}");
    }

    #[test]
    fn a_body_whose_marker_frame_sits_aside_is_moved_to_its_centre() {
        let frame = PoseFrame {
            world: UnitQuaternion::identity(),
            world_shift_m: Vector3::zeros(),
            body: Isometry3::translation(0.0, 0.0, -0.02),
        };
        // The tracked body is turned by 90 degrees about x: its -z is our +y.
        let turned = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
        let at = frame.apply(Vector3::new(1.0, 2.0, 3.0), turned);
        assert!((at.translation.vector - Vector3::new(1.0, 2.02, 3.0)).norm() < 1e-12, "{at}");
    }
}
