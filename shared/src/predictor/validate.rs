//! What scene and model must be for the step to work with them.

use super::types::Limits;
use crate::model::{FingerContact, Model, PusherContact, Scene, Shape, SupportContact};
use crate::real::Real;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Why scene and model were refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum ModelError {
    /// Mass or inertia not positive, or beyond any gripper's object (10 t, 10^6 kg m^2).
    Mass,
    /// A length not positive, or above 100 m.
    Geometry,
    /// A friction coefficient negative, above 10 or not finite.
    Friction,
    /// A stiffness not positive or above 10^10 N/m, a damping negative or above 1000 s.
    Compliance,
    /// An effect that this build does not know.
    UnknownEffect,
    /// An effect's parameter outside its bounds or not finite.
    EffectParameter,
    /// A formula missing, left over or malformed.
    Formula,
    /// A component of gravity above 1000 m/s^2.
    Gravity,
    /// A polygon's corners not convex, or not counter-clockwise about the centre of mass.
    Polygon,
    /// The pusher's line not positive, its tip's radius negative, or one of them above 100 m.
    Pusher,
    /// No foot under the object, or one more than 100 m away.
    Support,
    /// A limit of the predictor not finite or out of its range.
    Limit(Limit),
    /// Friction pyramids, which older firmware of the G474 does not have.
    Formulation,
}

/// A number of [`Limits`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Limit {
    /// [`Limits::horizon_s`]: 0 (no look-ahead) to 10 s.
    Horizon,
    /// [`Limits::sag_m`]: above 0, up to 1 m.
    Sag,
    /// [`Limits::rotation_rad`]: above 0, up to 10 rad.
    Rotation,
    /// `Limits::slip_m_s`: above 0, up to 1 m/s.
    Slip,
    /// [`Limits::target_utilisation`]: above 0, up to 1.
    TargetUtilisation,
    /// [`Limits::divergence_m`]: above 0, up to 1 m.
    Divergence,
    /// [`Limits::slip_warning_s`]: 0 to 10 s.
    SlipWarning,
    /// [`Limits::drop_warning_s`]: 0 to 10 s.
    DropWarning,
    /// [`Limits::force_range_n`]: above 0, up to 1 MN.
    ForceRange,
    /// [`Limits::torque_range_nm`]: above 0, up to 1 MN m.
    TorqueRange,
}

/// Refuses limits under which alarms could not be raised: a comparison with NaN is never true.
pub fn validate_limits(limits: &Limits) -> Result<(), ModelError> {
    let l = limits;
    // Value, whether zero is one, and the largest.
    let table = [
        (Limit::Horizon, l.horizon_s, true, 10.0),
        (Limit::Sag, l.sag_m, false, 1.0),
        (Limit::Rotation, l.rotation_rad, false, 10.0),
        (Limit::Slip, l.slip_m_s, false, 1.0),
        (Limit::TargetUtilisation, l.target_utilisation, false, 1.0),
        (Limit::Divergence, l.divergence_m, false, 1.0),
        (Limit::SlipWarning, l.slip_warning_s, true, 10.0),
        (Limit::DropWarning, l.drop_warning_s, true, 10.0),
        (Limit::ForceRange, l.force_range_n, false, 1e6),
        (Limit::TorqueRange, l.torque_range_nm, false, 1e6),
    ];
    for (limit, value, zero, most) in table {
        if !((value > 0.0 || (zero && value == 0.0)) && value <= most) {
            return Err(ModelError::Limit(limit));
        }
    }
    Ok(())
}

/// Convex, and counter-clockwise about the origin: the centre of mass lies to the left of every edge,
/// and so does every corner that is not the edge's.
fn is_outline<R: Real>(corners: &[[R; 2]]) -> bool {
    let left =
        |a: &[R; 2], b: &[R; 2], p: [R; 2]| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
    let edges = || corners.iter().zip(corners.iter().cycle().skip(1));
    edges().all(|(a, b)| {
        // Corners on the line of an edge may round to its other side.
        let square = (b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1]);
        let slack = square * R::of(-1e-4);
        left(a, b, [R::zero(); 2]) > R::zero() && corners.iter().all(|p| left(a, b, *p) >= slack)
    })
}

/// Beyond any gripper's object: mass, inertia, lengths.
const MOST_MASS_KG: f64 = 1e4;
const MOST_INERTIA_KG_M2: f64 = 1e6;
const MOST_LENGTH_M: f64 = 100.0;
/// Ten times a centrifuge for rockets' parts.
const MOST_GRAVITY_M_S2: f64 = 1e3;
/// A thousand times what stands for rigid.
const MOST_STIFFNESS_N_M: f64 = 1e10;
/// A parameter of a formula.
const MOST_PARAMETER: f64 = 1e12;
/// Of a contact; pads have milliseconds.
const MOST_DAMPING_S: f64 = 1e3;

/// Refuses what the step cannot work with.
pub fn validate<R: Real>(scene: &Scene<R>, model: &Model<R>) -> Result<(), ModelError> {
    // What no rig has would end beyond the numbers' range, not in a prediction.
    let within = |x: R, most: f64| x > R::zero() && x <= R::of(most);
    let positive = |x: R| within(x, MOST_LENGTH_M);
    let object = &scene.object;
    let diagonal = (0..3).all(|k| within(object.inertia_kg_m2[k][k], MOST_INERTIA_KG_M2));
    let bounded = |x: &R| x.abs() <= R::of(MOST_INERTIA_KG_M2);
    if !within(object.mass_kg, MOST_MASS_KG)
        || !diagonal
        || !object.inertia_kg_m2.iter().flatten().all(bounded)
    {
        return Err(ModelError::Mass);
    }
    let near = |x: &R| x.abs() <= R::of(MOST_LENGTH_M);
    let shape_good = match &object.shape {
        Shape::Prism { length_m, side_m } => positive(*length_m) && positive(*side_m),
        Shape::Cylinder { length_m, diameter_m, across_flats_m } => {
            positive(*length_m)
                && positive(*diameter_m)
                && positive(*across_flats_m)
                && *across_flats_m <= *diameter_m
        }
        Shape::Polygon { vertices_m, height_m } => {
            positive(*height_m) && vertices_m.len() >= 3 && vertices_m.iter().flatten().all(near)
        }
    };
    if let Shape::Polygon { vertices_m, .. } = &object.shape
        && shape_good
        && !is_outline(vertices_m)
    {
        return Err(ModelError::Polygon);
    }
    let pusher_good = match scene.pusher {
        Some(PusherContact::Line { length_m }) => positive(length_m),
        Some(PusherContact::Point { tip_radius_m }) => tip_radius_m >= R::zero() && near(&tip_radius_m),
        Some(PusherContact::Plane) | None => true,
    };
    if !pusher_good {
        return Err(ModelError::Pusher);
    }
    if let Some(SupportContact::Points(feet)) = &scene.support
        && (feet.is_empty() || !feet.iter().flatten().all(near))
    {
        return Err(ModelError::Support);
    }
    let finger_good = match scene.fingers {
        Some(FingerContact::Disc { diameter_m: d } | FingerContact::Line { length_m: d }) => positive(d),
        _ => true,
    };
    if !shape_good || !finger_good {
        return Err(ModelError::Geometry);
    }
    if !scene.gravity_m_s2.iter().all(|x| x.abs() <= R::of(MOST_GRAVITY_M_S2)) {
        return Err(ModelError::Gravity);
    }
    let f = &model.friction;
    if [f.finger, f.pusher, f.support].iter().any(|m| !(m.finite() && *m >= R::zero() && *m <= R::of(10.0))) {
        return Err(ModelError::Friction);
    }
    if let crate::model::Base::Soft { normal_n_m, tangential_n_m, damping_s } = model.base
        && !(within(normal_n_m, MOST_STIFFNESS_N_M)
            && within(tangential_n_m, MOST_STIFFNESS_N_M)
            && damping_s >= R::zero()
            && damping_s <= R::of(MOST_DAMPING_S))
    {
        return Err(ModelError::Compliance);
    }
    let formulas = model.effects.iter().filter(|e| e.code == crate::effects::formula::CODE).count();
    if formulas != model.formulas.len() || model.formulas.iter().any(|f| f.check().is_err()) {
        return Err(ModelError::Formula);
    }
    for e in &model.effects {
        let bounds = crate::effects::bounds(e.code).ok_or(ModelError::UnknownEffect)?;
        let inside = |(p, bounds): (&R, &[f32; 2])| {
            // Bounds and values sent as f32 are rounded: a value may lie just past its bound.
            let [low, high] = bounds.map(|x| R::of(f64::from(x)));
            let slack = R::of(1e-6) * (high - low);
            p.finite() && *p >= low - slack && *p <= high + slack
        };
        // Those without a description: of a formula its own, of other effects zero.
        let rest = e.parameters.iter().skip(bounds.len()).all(|p| p.abs() <= R::of(MOST_PARAMETER));
        if !rest || !e.parameters.iter().zip(bounds).all(inside) {
            return Err(ModelError::EffectParameter);
        }
    }
    Ok(())
}
