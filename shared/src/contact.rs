//! Where the bodies touch: from scene, state and drive to a list of contact points.
//!
//! Everything is expressed in the carrier frame: the gripper's frame, or, where nothing is
//! grasped, a frame at rest in the world. Patches are arrays of rigidly connected points:
//!
//! | contact | points | rule |
//! |---|---|---|
//! | disc finger of radius a on a flat face | 6 on a ring of 2a/3; where its torsional stiffness is given, 3 at a and 3 at 0.487 a ([`spread`]) | torsional friction 2/3 mu N a of the uniform disc exactly; force and torsion together within 7 % of the disc's limit surface; normal moment up to 0.58 N a (disc: N a) |
//! | disc or line finger on a cylinder | 2 on the line of contact, at ± half its length | the patch is a line along the axis |
//! | line finger | 2 ends | |
//! | plane pusher | the corners of the nearest face, or the two ends of a cylinder's line; where it gives way, eight points of the face or two of the line | [`spread`] |
//! | line pusher | the two ends of its overlap with the nearest face; where it gives way, two points of that | [`spread`] |
//! | point pusher | the nearest surface point | where it pushes an object over a table, its spring up and down keeps nothing from step to step: how much of the moment of its height a rod holds is undetermined between rigid bodies, and where it meets the object it bounces until it holds none; only what tips is held by its friction |
//! | support | 10 to 16 points of the face, or the given feet | |
//!
//! A slot number belongs to each point, the same in every step, so that the spring memory
//! finds its point again; which face of the object the points are on goes with it.

mod spread;

use crate::model::{Base, FingerContact, Model, PusherContact, RIGID_N_M, Scene, SupportContact};
use crate::real::{Real, Rotation, Vec3, max, norm, sqrt};
use crate::shape::{END_BELOW, ROUND};
use crate::state::{Drive, Moving, State};
use heapless::Vec;
pub use spread::spread;

/// Points on each fingertip.
pub const FINGER_POINTS: usize = 6;
/// Points on the pusher.
pub const PUSHER_POINTS: usize = 8;
/// Slots before the support's.
pub const SUPPORT_SLOT: usize = 2 * FINGER_POINTS + PUSHER_POINTS;
/// Slots of a scene with everything: the capacity that fits any scene.
pub const SLOTS: usize = SUPPORT_SLOT + crate::shape::MAX_SAMPLES;

/// Constants of contact geometry; units as the names say, otherwise dimensionless.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactParams<R: Real> {
    /// 1e7 N/m a whole contact stands for 'rigid': 20 N deflect it by 2 um, far below the 30 um of motion
    /// capture, and in `f32` its rounding stays below a millinewton. Doubled: half the deflection, twice
    /// the force that rounding of a pose causes.
    pub rigid_n_m: R,
    /// 0.2 (78 degrees): least cosine between pad and gripped face; steeper, the pad touches an edge,
    /// which is not modelled. Doubled: contact ends at 66 degrees.
    pub min_face_cosine: R,
    /// 0.1: least length of the object's X axis seen along the pad's normal that a tangent is taken from,
    /// otherwise the gripper's X. Doubled: no change but for objects gripped at their ends.
    pub min_axis_share: R,
    /// 0.9 (26 degrees): cosine between a rod's normal and the object's Z beyond which its tangent is taken
    /// from the rod instead. Tangents only name directions: no change in forces.
    pub rod_tangent_cosine: R,
}

impl<R: Real> Default for ContactParams<R> {
    fn default() -> Self {
        Self {
            rigid_n_m: R::of(RIGID_N_M),
            min_face_cosine: R::of(0.2),
            min_axis_share: R::of(0.1),
            rod_tangent_cosine: R::of(0.9),
        }
    }
}

/// Lengths below this are no direction, m.
const NO_LENGTH_M: f64 = 1e-6;

/// The other body of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Body {
    /// Fingertip on the +Y side.
    Finger1,
    /// Fingertip on the -Y side.
    Finger2,
    /// Pusher or environment.
    Pusher,
    /// Table.
    Support,
}

impl Body {
    /// 0 to 3.
    pub fn index(self) -> usize {
        self as usize
    }

    /// Places of its points in the memory of the state.
    pub fn slots(self) -> core::ops::Range<usize> {
        match self {
            Self::Finger1 => 0..FINGER_POINTS,
            Self::Finger2 => FINGER_POINTS..2 * FINGER_POINTS,
            Self::Pusher => 2 * FINGER_POINTS..SUPPORT_SLOT,
            Self::Support => SUPPORT_SLOT..SLOTS,
        }
    }
}

/// Whether the body is one of the two fingertips.
pub fn is_finger(body: Body) -> bool {
    matches!(body, Body::Finger1 | Body::Finger2)
}

/// One point of contact before friction is known.
#[derive(Clone, Copy, Debug)]
pub struct Contact<R: Real> {
    /// Other body.
    pub body: Body,
    /// The object's face that it is on, see [`crate::shape::Face::number`].
    pub face: u8,
    /// Place in the memory of the state.
    pub slot: usize,
    /// From the centre of mass, carrier axes, m.
    pub lever_m: Vec3<R>,
    /// Normal into the object and two tangents, carrier axes.
    pub axes: [Vec3<R>; 3],
    /// Separation along the normal, m; negative when pressed.
    pub gap_m: R,
    /// Velocity of the other body at the point, relative to the carrier, m/s.
    pub surface_m_s: Vec3<R>,
    /// Place within the patch, along the tangents, from its centre, m.
    pub patch_m: [R; 2],
    /// Place on the object, object axes, m.
    pub object_m: Vec3<R>,
    /// Share of the whole contact's stiffness (sum over a patch: 1).
    pub share: R,
    /// Spring of the whole contact along the normal, N/m.
    pub normal_n_m: R,
    /// Spring of the whole contact along the tangents, N/m.
    pub tangential_n_m: R,
    /// Damper over spring, s.
    pub damping_s: R,
    /// What the tangential spring has of its stretch at the beginning of the step, 0 to 1: what stiffens as it is pressed harder
    /// does so by new contact, which is not stressed yet.
    pub eased: R,
    /// How much of the tangential spring's travel is slip before all of the contact slides, 0 to 1: see
    /// [`crate::effects::contact_compliance`].
    pub microslip: R,
    /// Slip by which the tangential spring gives way for that, m; 0 where all of the contact slides or none does.
    pub reach_m: R,
    /// What is left of the tangential spring at the end of the step, 0 to 1, as the step takes it beforehand.
    pub kept: R,
    /// Radius over which a single point is spread (see [`spread`]), m; normally 0.
    pub spread_m: R,
    /// How [`spread`] arranges the points. Of the pusher, where it bears as an even foundation does, not with its corners alone:
    /// the share of a face's stiffness that lies at its ends along the second tangent all the same. Of a flat disc finger: its
    /// torsional stiffness over the tangential one and the square of its radius, where that is not the ring's.
    pub profile: Option<R>,
}

impl<R: Real> Contact<R> {
    /// Stretch of the tangential spring at the beginning of the step, with what it had at the end of the last, m.
    pub(crate) fn stretch_m(&self, had_m: [R; 2]) -> [R; 2] {
        had_m.map(|s| s * self.eased)
    }
}

/// All contacts of a step.
pub type Contacts<R, const NC: usize> = Vec<Contact<R>, NC>;

struct Builder<'a, R: Real, const NC: usize> {
    scene: &'a Scene<R>,
    state: &'a State<R, NC>,
    out: &'a mut Contacts<R, NC>,
    params: &'a ContactParams<R>,
    springs: [R; 3],
    /// Of the points that are added.
    face: u8,
    /// The object's axes in carrier axes.
    axes: [Vec3<R>; 3],
}

/// The gripped face as seen from the pad, for all of its points.
struct UnderPad<R: Real> {
    face: crate::shape::Face<R>,
    /// Carrier axes.
    normal: Vec3<R>,
    centre: Vec3<R>,
    /// Y of the centre beyond that of the face, small.
    lifted: R,
}

/// Appends every contact point of the step to `out` (cleared first). Points that do not
/// fit the capacity `NC` are not silently lost: the number left out is returned.
pub fn find<R: Real, const NC: usize>(
    scene: &Scene<R>,
    model: &Model<R>,
    state: &State<R, NC>,
    drive: &Drive<R>,
    out: &mut Contacts<R, NC>,
) -> usize {
    find_with(&ContactParams::default(), scene, model, state, drive, out)
}

/// [`find`] with other constants.
pub fn find_with<R: Real, const NC: usize>(
    params: &ContactParams<R>,
    scene: &Scene<R>,
    model: &Model<R>,
    state: &State<R, NC>,
    drive: &Drive<R>,
    out: &mut Contacts<R, NC>,
) -> usize {
    out.clear();
    let rigid = params.rigid_n_m;
    let springs = match model.base {
        Base::Hard => [rigid, rigid, R::zero()],
        Base::Soft { normal_n_m, tangential_n_m, damping_s } => [normal_n_m, tangential_n_m, damping_s],
    };
    let turn = state.rotation.to_rotation_matrix();
    let axes = [0, 1, 2].map(|k| Vec3::new(turn[(0, k)], turn[(1, k)], turn[(2, k)]));
    let mut builder = Builder { scene, state, out, params, springs, face: ROUND, axes };
    let mut lost = 0;
    if let Some(finger) = &scene.fingers {
        lost += builder.finger(finger, Body::Finger1);
        lost += builder.finger(finger, Body::Finger2);
    }
    if let (Some(pusher), Some(moving)) = (&scene.pusher, &drive.pusher) {
        lost += builder.pusher(pusher, moving);
    }
    if let (Some(support), Some(moving)) = (&scene.support, &drive.support) {
        lost += builder.support(support, moving);
    }
    lost
}

impl<R: Real, const NC: usize> Builder<'_, R, NC> {
    #[inline(always)]
    fn in_object(&self, v: &Vec3<R>) -> Vec3<R> {
        Vec3::new(self.axes[0].dot(v), self.axes[1].dot(v), self.axes[2].dot(v))
    }

    #[inline(always)]
    fn in_carrier(&self, v: &Vec3<R>) -> Vec3<R> {
        self.axes[0] * v.x + self.axes[1] * v.y + self.axes[2] * v.z
    }

    /// A point of the object (object axes) seen from the origin of `moving`, carrier axes.
    /// Where the object has hardly turned it is a sum of small numbers: a gap taken from it
    /// keeps its digits in `f32`, and a rigid contact turns a nanometre into a hundredth of a newton.
    #[inline(always)]
    fn seen_from(&self, moving: &Moving<R>, point: &Vec3<R>) -> Vec3<R> {
        (point - moving.position_m) + self.state.position_m + turned_by(&self.state.rotation, point)
    }

    /// `lever` in carrier axes; completes and stores a contact.
    #[allow(clippy::too_many_arguments)]
    fn push(
        &mut self,
        body: Body,
        slot: usize,
        lever_m: Vec3<R>,
        axes: [Vec3<R>; 3],
        gap_m: R,
        surface_m_s: Vec3<R>,
        patch_m: [R; 2],
        share: R,
    ) -> usize {
        let object_m = self.in_object(&lever_m);
        let [normal_n_m, tangential_n_m, damping_s] = self.springs;
        let contact = Contact {
            body,
            face: self.face,
            slot,
            lever_m,
            axes,
            gap_m,
            surface_m_s,
            patch_m,
            object_m,
            share,
            normal_n_m,
            tangential_n_m,
            damping_s,
            eased: R::one(),
            microslip: R::zero(),
            reach_m: R::zero(),
            kept: R::one(),
            spread_m: R::zero(),
            profile: None,
        };
        usize::from(slot >= NC || self.out.push(contact).is_err())
    }

    /// A flat pad normal to carrier Y whose centre is on the carrier's Y axis.
    fn finger(&mut self, finger: &FingerContact<R>, body: Body) -> usize {
        let sign = if body == Body::Finger1 { R::one() } else { -R::one() };
        let (state, zero) = (self.state, R::zero());
        let outward = Vec3::new(zero, sign, zero);
        let in_object = self.in_object(&outward);
        let face = self.scene.object.shape.face_towards(&in_object);
        let round = face.is_none();
        self.face = face.as_ref().map_or(ROUND, |f| f.number);
        let flat_face = match face {
            Some(face) => {
                let normal = self.in_carrier(&face.normal);
                if !(normal.y.abs() > self.params.min_face_cosine) {
                    return 0;
                }
                let turned = turned_by(&state.rotation, &face.centre_m);
                let centre = state.position_m + face.centre_m + turned;
                Some(UnderPad { normal, centre, lifted: state.position_m.y + turned.y, face })
            }
            None => None,
        };
        // Tangents follow the object's X axis, so that anisotropy is the object's.
        let x = self.axes[0];
        let flat = sqrt(x.x * x.x + x.z * x.z);
        let t1 = if flat > self.params.min_axis_share {
            Vec3::new(x.x / flat, zero, x.z / flat)
        } else {
            Vec3::x()
        };
        let normal = -outward;
        let axes = [normal, t1, normal.cross(&t1)];
        let mut pads: Vec<([R; 2], R), FINGER_POINTS> = Vec::new();
        let mut add = |at: [R; 2], share: f64| {
            let _ = pads.push((at, R::of(share)));
        };
        match finger {
            FingerContact::Point => add([zero, zero], 1.0),
            FingerContact::Line { length_m } => {
                let h = *length_m * R::of(0.5);
                add([-h, zero], 0.5);
                add([h, zero], 0.5);
            }
            FingerContact::Disc { diameter_m } if round => {
                // The chord of the disc at the height of the cylinder's axis.
                let a = *diameter_m * R::of(0.5);
                let under = a * a - state.position_m.z * state.position_m.z;
                let h = if under > zero { sqrt(under) } else { zero };
                add([-h, zero], 0.5);
                add([h, zero], 0.5);
            }
            FingerContact::Disc { diameter_m } => {
                let ring = *diameter_m * R::of(1.0 / 3.0);
                let half = ring * R::of(0.5);
                let high = ring * R::of(0.866_025_403_784_438_6);
                for (x, z) in
                    [(ring, zero), (half, high), (-half, high), (-ring, zero), (-half, -high), (half, -high)]
                {
                    add([x, z], 1.0 / 6.0);
                }
            }
        }
        let first = body.index() * FINGER_POINTS;
        let mut lost = 0;
        for (k, (at, share)) in pads.iter().enumerate() {
            // Without a flat face the points lie on the line of contact of the cylinder.
            let place = if round {
                state.position_m + t1 * at[0] - outward * state.position_m.dot(&outward)
            } else {
                Vec3::new(at[0], zero, at[1])
            };
            let Some((gap, lever)) = self.under_pad(&flat_face, &in_object, sign, &place) else {
                continue;
            };
            let patch = [t1.dot(&place), axes[2].dot(&place)];
            lost += self.push(body, first + k, lever, axes, gap, Vec3::zeros(), patch, *share);
        }
        lost
    }

    /// Gap and lever of the point of the pad at `place` (carrier axes, Y ignored); `None`
    /// where the object has no surface there. Written so that the gap, a small number, is
    /// a sum of small numbers: in `f32` it keeps its digits.
    fn under_pad(
        &self,
        flat: &Option<UnderPad<R>>,
        in_object: &Vec3<R>,
        sign: R,
        place: &Vec3<R>,
    ) -> Option<(R, Vec3<R>)> {
        let s = self.state;
        match flat {
            Some(UnderPad { face, normal, centre, lifted }) => {
                let along = (normal.x * (place.x - centre.x) + normal.z * (place.z - centre.z)) / normal.y;
                let small = *lifted - along;
                let y = face.centre_m.y + small;
                let lever = Vec3::new(place.x - s.position_m.x, y - s.position_m.y, place.z - s.position_m.z);
                let at = face.local(&self.in_object(&lever));
                let gap = (s.jaw_half_m - sign * face.centre_m.y) + s.jaw_m - sign * small;
                face.covers(at).then_some((gap, lever))
            }
            None => {
                let reach = self.scene.object.shape.reach(in_object);
                let gap = (s.jaw_half_m - reach) + s.jaw_m - sign * s.position_m.y;
                let mut lever = *place - s.position_m;
                lever.y = sign * reach;
                Some((gap, lever))
            }
        }
    }

    fn pusher(&mut self, pusher: &PusherContact<R>, moving: &Moving<R>) -> usize {
        let state = self.state;
        let axis = |v: &Vec3<R>| moving.rotation.transform_vector(v);
        let (n, y) = (axis(&Vec3::x()), axis(&Vec3::y()));
        let object_axes = self.axes;
        let in_object =
            |v: &Vec3<R>| Vec3::new(object_axes[0].dot(v), object_axes[1].dot(v), object_axes[2].dot(v));
        let from_pusher = moving.position_m - state.position_m;
        let first = 2 * FINGER_POINTS;
        let mut lost = 0;
        match pusher {
            PusherContact::Plane => {
                let axes = [n, y, n.cross(&y)];
                let towards = in_object(&-n);
                // Lever, and place seen from the pusher's origin.
                let mut points: Vec<(Vec3<R>, Vec3<R>), PUSHER_POINTS> = Vec::new();
                self.face = ROUND;
                match self.scene.object.shape.face_towards(&towards) {
                    Some(face) => {
                        self.face = face.number;
                        for p in &face.corners() {
                            let at = (self.in_carrier(p), self.seen_from(moving, p));
                            lost += usize::from(points.push(at).is_err());
                        }
                    }
                    None => {
                        // The line of a cylinder nearest to the plane.
                        let x = self.axes[0];
                        let down = -(n - x * x.dot(&n));
                        let (half, radius) = cylinder_size(&self.scene.object.shape);
                        let down = down * (radius / max(norm(&down), R::of(NO_LENGTH_M)));
                        for h in [-half, half] {
                            let lever = x * h + down;
                            let _ = points.push((lever, lever - from_pusher));
                        }
                    }
                }
                let share = R::one() / R::of(points.len().max(1) as f64);
                for (k, (lever, from)) in points.iter().enumerate() {
                    let surface = moving.velocity_at(from);
                    let patch = [axes[1].dot(from), axes[2].dot(from)];
                    lost +=
                        self.push(Body::Pusher, first + k, *lever, axes, n.dot(from), surface, patch, share);
                }
            }
            PusherContact::Line { length_m } => {
                let towards = in_object(&-n);
                let half = *length_m * R::of(0.5);
                let ends = [from_pusher - y * half, from_pusher + y * half];
                let Some(face) = self.scene.object.shape.face_towards(&towards) else {
                    return self.line_on_cylinder(moving, &ends);
                };
                let [a, b] = ends.map(|e| in_object(&e));
                self.face = face.number;
                let Some(range) = face.clip(face.local(&a), face.local(&b)) else {
                    return 0;
                };
                let normal = -state.rotation.transform_vector(&face.normal);
                let t2 = normal.cross(&y);
                let t2 = t2 / max(norm(&t2), R::of(NO_LENGTH_M));
                let axes = [normal, t2.cross(&normal), t2];
                for (k, t) in range.into_iter().enumerate() {
                    let lever = ends[0] + (ends[1] - ends[0]) * t;
                    let gap = face.normal.dot(&(in_object(&lever) - face.centre_m));
                    let from = lever - from_pusher;
                    let patch = [axes[1].dot(&from), R::zero()];
                    let surface = moving.velocity_at(&from);
                    lost += self.push(Body::Pusher, first + k, lever, axes, gap, surface, patch, R::of(0.5));
                }
            }
            PusherContact::Point { tip_radius_m } => {
                let (at, out, distance) = self.scene.object.shape.closest(&in_object(&from_pusher));
                let normal = -state.rotation.transform_vector(&out);
                // Tangents from object Z, so that a rod's tangents lie in and across the table.
                let z = state.rotation.transform_vector(&Vec3::z());
                let t1 = if normal.dot(&z).abs() < self.params.rod_tangent_cosine {
                    z.cross(&normal)
                } else {
                    y.cross(&normal)
                };
                let t1 = t1 / max(norm(&t1), R::of(NO_LENGTH_M));
                let axes = [normal, t1, normal.cross(&t1)];
                self.face = ROUND;
                let lever = state.rotation.transform_vector(&at);
                let surface = moving.velocity_at(&(lever - from_pusher));
                let gap = distance - *tip_radius_m;
                lost += self.push(Body::Pusher, first, lever, axes, gap, surface, [R::zero(); 2], R::one());
            }
        }
        lost
    }

    fn line_on_cylinder(&mut self, moving: &Moving<R>, ends: &[Vec3<R>; 2]) -> usize {
        self.face = ROUND;
        let x = self.state.rotation.transform_vector(&Vec3::x());
        let (_, radius) = cylinder_size(&self.scene.object.shape);
        let from_pusher = moving.position_m - self.state.position_m;
        let mut lost = 0;
        for (k, end) in ends.iter().enumerate() {
            let out = end - x * x.dot(end);
            let distance = norm(&out);
            if !(distance > R::of(NO_LENGTH_M)) {
                continue;
            }
            let normal = -out / distance;
            let lever = end + normal * (distance - radius);
            let axes = [normal, x, normal.cross(&x)];
            let surface = moving.velocity_at(&(lever - from_pusher));
            let slot = 2 * FINGER_POINTS + k;
            lost += self.push(
                Body::Pusher,
                slot,
                lever,
                axes,
                distance - radius,
                surface,
                [R::zero(); 2],
                R::of(0.5),
            );
        }
        lost
    }

    /// A plane whose normal is the moving frame's +X, as for a plane pusher.
    fn support(&mut self, support: &SupportContact<R>, moving: &Moving<R>) -> usize {
        let state = self.state;
        let n = moving.rotation.transform_vector(&Vec3::x());
        let y = moving.rotation.transform_vector(&Vec3::y());
        let axes = [n, y, n.cross(&y)];
        let mut points: Vec<(Vec3<R>, R), { crate::shape::MAX_SAMPLES }> = Vec::new();
        match support {
            SupportContact::Patch => {
                let down = state.rotation.inverse_transform_vector(&-n);
                match self.scene.object.shape.face_towards(&down) {
                    Some(face) => {
                        self.face = face.number;
                        points = face.samples();
                    }
                    None => {
                        self.face = ROUND;
                        let (half, radius) = cylinder_size(&self.scene.object.shape);
                        let across = Vec3::new(R::zero(), down.y, down.z);
                        let across = across * (radius / max(norm(&across), R::of(NO_LENGTH_M)));
                        for h in [-half, half] {
                            let _ = points.push((Vec3::x() * h + across, R::of(0.5)));
                        }
                    }
                }
            }
            SupportContact::Points(feet) => {
                self.face = END_BELOW;
                let down = self.scene.object.shape.reach(&-Vec3::z());
                let share = R::one() / R::of(feet.len().max(1) as f64);
                for p in feet {
                    let _ = points.push((Vec3::new(p[0], p[1], -down), share));
                }
            }
        }
        let mut lost = 0;
        for (k, (point, share)) in points.iter().enumerate() {
            let lever = self.in_carrier(point);
            let from = self.seen_from(moving, point);
            let patch = [point.x, point.y];
            let surface = moving.velocity_at(&from);
            lost +=
                self.push(Body::Support, SUPPORT_SLOT + k, lever, axes, n.dot(&from), surface, patch, *share);
        }
        lost
    }
}

/// `R v - v`, without the cancellation of computing it so.
fn turned_by<R: Real>(rotation: &Rotation<R>, v: &Vec3<R>) -> Vec3<R> {
    let q = rotation.vector();
    let q = Vec3::new(q[0], q[1], q[2]);
    let c = q.cross(v) * R::of(2.0);
    c * rotation.scalar() + q.cross(&c)
}

/// Half length and radius; zero for other shapes.
fn cylinder_size<R: Real>(shape: &crate::model::Shape<R>) -> (R, R) {
    match shape {
        crate::model::Shape::Cylinder { length_m, diameter_m, .. } => {
            (*length_m * R::of(0.5), *diameter_m * R::of(0.5))
        }
        _ => (R::zero(), R::zero()),
    }
}
