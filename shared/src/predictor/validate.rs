//! What scene and model must be for the step to work with them.

use crate::model::{FingerContact, Model, Scene, Shape};
use crate::real::Real;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Why scene and model were refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum ModelError {
    /// Mass or inertia not positive or not finite.
    Mass,
    /// A length not positive or not finite.
    Geometry,
    /// A friction coefficient negative, above 10 or not finite.
    Friction,
    /// A stiffness or damping negative, zero or not finite.
    Compliance,
    /// An effect that this build does not know.
    UnknownEffect,
    /// An effect's parameter outside its bounds or not finite.
    EffectParameter,
    /// A formula missing, left over or malformed.
    Formula,
    /// Gravity not finite.
    Gravity,
}

/// Refuses what the step cannot work with.
pub fn validate<R: Real>(scene: &Scene<R>, model: &Model<R>) -> Result<(), ModelError> {
    let positive = |x: R| x.finite() && x > R::zero();
    let object = &scene.object;
    let diagonal = (0..3).all(|k| positive(object.inertia_kg_m2[k][k]));
    if !positive(object.mass_kg) || !diagonal || !object.inertia_kg_m2.iter().flatten().all(|x| x.finite()) {
        return Err(ModelError::Mass);
    }
    let shape_good = match &object.shape {
        Shape::Prism { length_m, side_m } => positive(*length_m) && positive(*side_m),
        Shape::Cylinder { length_m, diameter_m, across_flats_m } => {
            positive(*length_m)
                && positive(*diameter_m)
                && positive(*across_flats_m)
                && *across_flats_m <= *diameter_m
        }
        Shape::Polygon { vertices_m, height_m } => {
            positive(*height_m) && vertices_m.len() >= 3 && vertices_m.iter().flatten().all(|x| x.finite())
        }
    };
    let finger_good = match scene.fingers {
        Some(FingerContact::Disc { diameter_m: d } | FingerContact::Line { length_m: d }) => positive(d),
        _ => true,
    };
    if !shape_good || !finger_good {
        return Err(ModelError::Geometry);
    }
    if !scene.gravity_m_s2.iter().all(|x| x.finite()) {
        return Err(ModelError::Gravity);
    }
    let f = &model.friction;
    if [f.finger, f.pusher, f.support].iter().any(|m| !(m.finite() && *m >= R::zero() && *m <= R::of(10.0))) {
        return Err(ModelError::Friction);
    }
    if let crate::model::Base::Soft { normal_n_m, tangential_n_m, damping_s } = model.base
        && (!positive(normal_n_m)
            || !positive(tangential_n_m)
            || !damping_s.finite()
            || damping_s < R::zero())
    {
        return Err(ModelError::Compliance);
    }
    let formulas = model.effects.iter().filter(|e| e.code == crate::effects::formula::CODE).count();
    if formulas != model.formulas.len() || model.formulas.iter().any(|f| f.check().is_err()) {
        return Err(ModelError::Formula);
    }
    for e in &model.effects {
        let info = e.info().ok_or(ModelError::UnknownEffect)?;
        let inside = |(p, i): (&R, &crate::effects::Parameter)| {
            // Bounds are decimal; a value sent as f32 may round just past them.
            let (low, high) = (R::of(i.low), R::of(i.high));
            let slack = R::of(1e-6) * (high - low);
            p.finite() && *p >= low - slack && *p <= high + slack
        };
        if !e.parameters.iter().zip(info.parameters).all(inside) {
            return Err(ModelError::EffectParameter);
        }
    }
    Ok(())
}
