//! Friction on the table that depends on the direction of sliding: wood, brushed metal, woven cloth.
//!
//! The limit of friction at each point of the support is the ellipse of Michalowski and Mroz 1978 about the
//! grain at the angle `g`, `mu_along = mu sqrt(ratio)` and `mu_across = mu / sqrt(ratio)`; the body slides
//! where that dissipates most. The mean coefficient in the geometric sense stays the base model's.
//!
//! The grain may be the table's, and stay, or the face's, and turn with the object. Each is a pair
//! `ln(ratio) (cos 2g, sin 2g)`, zero where there is none, and smooth about it (a ratio and an angle are
//! not). The two pairs add in the table's axes, the face's turned by twice the angle of the object: the
//! logarithms of the two tensors of friction, exact where the grains are parallel or square and to first
//! order in `ln(ratio)` otherwise. From a fit: `ratio = exp(sqrt(a^2 + b^2))`, `g = atan2(b, a) / 2`.
//!
//! Angles of the table's grain run from the support's Y axis to its Z axis (its X is the normal), those of
//! the face's from the object axis that comes first of the two in the table (X of a body on its end face)
//! about the same normal. A body on its round side, or at a slant, has no grain of its own.

use super::law::{FrictionLaw, Law, Slip, StepContext};
use crate::contact::{Body, Contact};
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::{Real, Vec3, max, sqrt};

/// Cosine (8 degrees) between the table's normal and an object axis below which no face lies on the table. Doubled
/// angle: a body that tips takes its grain along.
const FLAT: f64 = 0.99;

/// See the module.
pub struct SupportAnisotropy;

/// Description.
pub const INFO: Info = Info {
    id: "support_anisotropy",
    code: 26,
    summary: "friction on the table depends on the direction of sliding",
    signature: "a push along one direction takes more force than across it, and the object drifts sideways towards \
                the direction of less friction",
    on_robot: "an object pushed on the table drifts towards the direction that slides easily: it does not go where it is pushed",
    source: "Michalowski and Mroz 1978, elliptic friction cone",
    role: Role::Plain,
    parameters: &[
        Parameter::new("table_cos", "1", 0.3, 0.0, [-1.2, 1.2], "grain of the table: ln(ratio) cos(2 angle)"),
        Parameter::new("table_sin", "1", 0.3, 0.0, [-1.2, 1.2], "ln(ratio) sin(2 angle), from X to Y"),
        Parameter::new("face_cos", "1", 0.3, 0.0, [-1.2, 1.2], "grain of the object's face, in object axes"),
        Parameter::new("face_sin", "1", 0.3, 0.0, [-1.2, 1.2], "ln(ratio) sin(2 angle), from object X to Y"),
    ],
};

/// The grain under the object: `ln(ratio)` and the direction along it, in the table's axes.
struct Grain<R: Real> {
    log_ratio: R,
    along: [R; 2],
}

/// Direction of the line at half the angle of `(cosine, sine) * size`, to the side of the first axis.
fn line<R: Real>(cosine: R, sine: R, size: R) -> [R; 2] {
    let half = R::of(0.5);
    let root = |x: R| sqrt(max(half + half * x / size, R::zero()));
    let (c, s) = (root(cosine), root(-cosine));
    [c, if sine < R::zero() { -s } else { s }]
}

/// First axes of a table: its X and Y where the world's Z is its normal.
fn table_axes<R: Real>(c: &StepContext<R>) -> [Vec3<R>; 2] {
    let [_, table] = c.environment;
    [table.along_y.cross(&table.normal), table.along_y]
}

/// Direction of the face's own first axis in the table's; `None` where no face lies on it.
fn face_axis<R: Real>(c: &StepContext<R>) -> Option<[R; 2]> {
    let [_, table] = c.environment;
    let normal = c.rotation.inverse_transform_vector(&table.normal);
    let flat = |x: R| x.abs() > R::of(FLAT);
    let own = match () {
        () if flat(normal.z) || flat(normal.y) => Vec3::x(),
        () if flat(normal.x) => Vec3::y(),
        () => return None,
    };
    let own = c.rotation.transform_vector(&own);
    let [x, y] = table_axes(c).map(|a| a.dot(&own));
    let size = sqrt(x * x + y * y);
    Some([x / size, y / size])
}

fn grain<R: Real>(p: &[R; MAX_PARAMETERS], c: &StepContext<R>) -> Option<Grain<R>> {
    let size = |x: R, y: R| sqrt(x * x + y * y);
    let [x, y, a, b, ..] = *p;
    let (table, mut face) = (size(x, y), size(a, b));
    let (mut sum, mut of_face) = ([x, y], [R::zero(); 2]);
    match face_axis(c) {
        Some([e, f]) if face > R::zero() => {
            let (cosine, sine) = (e * e - f * f, R::of(2.0) * e * f);
            sum = [x + a * cosine - b * sine, y + a * sine + b * cosine];
            let [u, v] = line(a, b, face);
            of_face = [e * u - f * v, f * u + e * v];
        }
        _ => face = R::zero(),
    }
    let log_ratio = size(sum[0], sum[1]);
    if !(log_ratio > R::zero()) {
        return None;
    }
    let along = line(sum[0], sum[1], log_ratio);
    // A line has two directions: that near the stronger grain's, so that springs along it do not change sign on the way.
    let stronger = if table >= face { line(x, y, table) } else { of_face };
    let same = along[0] * stronger[0] + along[1] * stronger[1] >= R::zero();
    Some(Grain { log_ratio, along: if same { along } else { along.map(|k| -k) } })
}

impl<R: Real> Law<R> for SupportAnisotropy {
    fn contact(
        &self,
        p: &[R; MAX_PARAMETERS],
        c: &StepContext<R>,
        _: &[R; MEMORY],
        contact: &mut Contact<R>,
    ) {
        if contact.body != Body::Support {
            return;
        }
        if let Some(Grain { along, .. }) = grain(p, c) {
            let [n, ..] = contact.axes;
            let [x, y] = table_axes(c);
            let along = x * along[0] + y * along[1];
            contact.axes = [n, along, n.cross(&along)];
        }
    }

    fn friction(
        &self,
        p: &[R; MAX_PARAMETERS],
        c: &StepContext<R>,
        _: &[R; MEMORY],
        slip: &Slip<R>,
        law: &mut FrictionLaw<R>,
    ) {
        if slip.body != Body::Support {
            return;
        }
        if let Some(Grain { log_ratio, .. }) = grain(p, c) {
            let root = (log_ratio * R::of(0.5)).exp();
            law.mu = [law.mu[0] * root, law.mu[1] / root];
        }
    }
}
