//! What no rigid model can be better at: real pads and plates deform, and how a body at rest
//! shares its weight among them depends on how much. One set of sizes for [`mod@crate::compare`]
//! and [`mod@crate::diagnose`], so that both call the same thing an error.

use crate::channels::{COUNT, PUSHER_FORCE, Quantity, quantity};
use crate::run::simulate::Prepared;
use nalgebra::Vector3;
use stickslip_shared::model::{Scene, SupportContact};

/// Share of what an effect explains that its law may be wrong by: laws of friction, grip and stiffness are
/// idealisations that hold to about a tenth. What is left within that share is no reason for a further effect, and a
/// strength is not known better, however many trials agree: all of them have the same law.
pub const FORM: f64 = 0.1;

/// Deviations that count as deformation, timing or sharing, not as an error of the contact law.
/// Doubling any of them hides effects up to twice as large; halving it blames rigid contact for
/// the compliance of real pads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rigid {
    /// Position, m. 20 N on contacts of 1e6 N/m give 20 um. Doubled: a face tilt or compliance
    /// that moves the object by less than 0.1 mm is no error.
    pub position_m: f64,
    /// Share of the prescribed path by which the object's position may differ: slip follows the
    /// direction of forces to about half a degree. Doubled: sideways drift of 2 % is no error.
    pub of_path: f64,
    /// Rotation, rad. 0.1 N m on the face of such a contact turns it by some mrad. Doubled:
    /// turns below 6 mrad are no error.
    pub rotation_rad: f64,
    /// Share of its turn by which a body that only lies on its face may have turned more or less: sixteen points stand for
    /// the face, and no face bears evenly to a few per cent. Doubled: a load spread 8 % wider is no effect.
    pub of_turn: f64,
    /// Share of a sensor's stated uncertainty: it bounds a constant, of which a part varies.
    /// Doubled: gain errors of a few per cent disappear.
    pub of_uncertainty: f64,
    /// Share of a force's spread within a phase bin: contact happens some milliseconds earlier or
    /// later than in a rigid model. Doubled: effects that show only at the onset are missed.
    pub of_range: f64,
    /// The same for the peak of the onset, which does not depend on timing. Doubled: an overshoot
    /// of static friction below a tenth of the rise is missed.
    pub of_peak: f64,
    /// The same for the pose, which follows the prescribed motion. Doubled: as `of_path`.
    pub of_pose_range: f64,
    /// The largest of many samples lies above their mean by so many standard deviations of the
    /// noise. Doubled: peaks below six standard deviations are no overshoot.
    pub largest_of_noise: f64,
    /// Share of the weight that fingers and pusher, or two fingers, may carry differently at
    /// rest: only their sum follows from balance. Doubled (all of the weight): forces at rest
    /// say nothing about the model.
    pub of_shared_weight: f64,
    /// Lever of that share in torques, m. Doubled: torques at rest count for less.
    pub shared_weight_lever_m: f64,
}

/// The sizes in use.
pub const RIGID: Rigid = Rigid {
    position_m: 5e-5,
    of_path: 0.01,
    rotation_rad: 3e-3,
    of_turn: 0.02,
    of_uncertainty: 0.1,
    of_range: 0.15,
    of_peak: 0.05,
    of_pose_range: 0.04,
    largest_of_noise: 3.0,
    of_shared_weight: 0.5,
    shared_weight_lever_m: 0.03,
};

impl Default for Rigid {
    fn default() -> Self {
        RIGID
    }
}

impl Rigid {
    /// How far a force (N) or torque (N m) may be off where a weight is shared.
    pub fn share_of_weight(&self, weight_n: f64, quantity: Quantity) -> f64 {
        let force_n = self.of_shared_weight * weight_n;
        match quantity {
            Quantity::Position | Quantity::Rotation => 0.0,
            Quantity::Force => force_n,
            Quantity::Torque => force_n * self.shared_weight_lever_m,
        }
    }

    /// The same for the object of `scene`.
    pub fn shared_weight(&self, scene: &Scene<f64>, quantity: Quantity) -> f64 {
        let gravity = scene.gravity_m_s2.iter().map(|g| g * g).sum::<f64>().sqrt();
        self.share_of_weight(scene.object.mass_kg * gravity, quantity)
    }
}

/// Fingers: the grip and the force along x.
const OF_THE_GRIP: [usize; 4] = [6, 7, 12, 13];

/// Channel of the force with which the pusher pushes: the world axis nearest to the normal of its
/// face. None without a pusher.
pub fn push_channel(prepared: &Prepared) -> Option<usize> {
    prepared.scene.pusher.as_ref()?;
    let pose = prepared.poses().first()?.pusher?;
    let normal = pose.rotation.transform_vector(&Vector3::x());
    (0..3).max_by(|a, b| normal[*a].abs().total_cmp(&normal[*b].abs())).map(|axis| PUSHER_FORCE + axis)
}

/// Whether nothing grasps the object and its whole face lies on a support.
pub fn lies_free(scene: &Scene<f64>) -> bool {
    scene.fingers.is_none() && matches!(scene.support, Some(SupportContact::Patch))
}

/// The largest turn of the object about one axis since it was first seen, rad.
fn turned_rad(prepared: &Prepared) -> f64 {
    let turn = |channel: usize| {
        let mut seen = prepared.measured.iter().map(|s| s[channel]).filter(|x| x.is_finite());
        let first = seen.next().unwrap_or(0.0);
        seen.fold(0.0, |most: f64, x| most.max((x - first).abs()))
    };
    (0..COUNT).filter(|k| quantity(*k) == Quantity::Rotation).map(turn).fold(0.0, f64::max)
}

/// How far pose and forces of one trial may be from those of a rigid model.
pub struct OfTrial {
    position_m: f64,
    rotation_rad: f64,
    /// Zero where the object rests on one thing only.
    weight_n: f64,
    weight_nm: f64,
    push: Option<usize>,
}

/// For one trial.
pub fn of_trial(prepared: &Prepared) -> OfTrial {
    let scene = &prepared.scene;
    let turn = if lies_free(scene) { RIGID.of_turn * turned_rad(prepared) } else { 0.0 };
    let both = scene.fingers.is_some() && scene.pusher.is_some();
    let weight = |quantity| if both { RIGID.shared_weight(scene, quantity) } else { 0.0 };
    OfTrial {
        position_m: RIGID.position_m.hypot(RIGID.of_path * prepared.drive_path()),
        rotation_rad: RIGID.rotation_rad.hypot(turn),
        weight_n: weight(Quantity::Force),
        weight_nm: weight(Quantity::Torque),
        push: push_channel(prepared),
    }
}

impl OfTrial {
    /// Of `channel`; weight is shared while things are at `rest` against each other. The grip, the
    /// fingers' force along x and the push itself are not.
    pub fn of(&self, channel: usize, rest: bool) -> f64 {
        match quantity(channel) {
            Quantity::Position => self.position_m,
            Quantity::Rotation => self.rotation_rad,
            _ if !rest || OF_THE_GRIP.contains(&channel) || self.push == Some(channel) => 0.0,
            Quantity::Force => self.weight_n,
            Quantity::Torque => self.weight_nm,
        }
    }
}
