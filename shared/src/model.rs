//! What the predictor is told: the scene (rig and object, known from measurement) and the
//! model (contact law, friction and effects, calibrated or diagnosed).
//!
//! The scene comes from a data set's `dataset.toml`, the model from the user's
//! `model.toml`. Both are plain data without sizes decided at run time, so that the host
//! can send them to the board (`postcard`) and both sides hold the same numbers.

use crate::effect::Effect;
use crate::formula::Formula;
use crate::real::Real;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Most vertices of a polygon prism.
pub const MAX_VERTICES: usize = 8;
/// Most support points given one by one.
pub const MAX_SUPPORT_POINTS: usize = 8;
/// Most effects in one model.
pub const MAX_EFFECTS: usize = 6;
/// Most of them given as formulas.
pub const MAX_FORMULAS: usize = 2;
/// Stiffness of a whole contact that stands for 'rigid', N/m.
pub const RIGID_N_M: f64 = 1.0e7;

/// Shape of the object, in its own axes (origin at the centre of mass, X along the length).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "R: Real")]
pub enum Shape<R: Real> {
    /// Square prism: `length_m` along X, `side_m` along Y and Z.
    Prism {
        /// Along X.
        length_m: R,
        /// Along Y and Z.
        side_m: R,
    },
    /// Cylinder with axis X.
    Cylinder {
        /// Along X.
        length_m: R,
        /// Diameter.
        diameter_m: R,
        /// Distance between two flat faces at +Y and -Y (the paper's obj3); the diameter where there are none.
        across_flats_m: R,
    },
    /// Convex polygon in XY, counter-clockwise about the centre of mass, extruded along Z.
    Polygon {
        /// `[x, y]` of each corner.
        vertices_m: Vec<[R; 2], MAX_VERTICES>,
        /// Extent along Z, from -height/2 to +height/2.
        height_m: R,
    },
}

/// The manipulated object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "R: Real")]
pub struct Object<R: Real> {
    /// Geometry.
    pub shape: Shape<R>,
    /// Mass.
    pub mass_kg: R,
    /// Inertia about the centre of mass in object axes, row by column.
    pub inertia_kg_m2: [[R; 3]; 3],
}

/// Contact area of a fingertip: a flat pad normal to gripper Y.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "R: Real")]
pub enum FingerContact<R: Real> {
    /// A single point.
    Point,
    /// A line along gripper X.
    Line {
        /// End to end.
        length_m: R,
    },
    /// A flat disc.
    Disc {
        /// Across.
        diameter_m: R,
    },
}

/// Contact feature of the pusher, in the pusher frame (+X is the normal into the object).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "R: Real")]
pub enum PusherContact<R: Real> {
    /// The half space x <= 0 of the pusher frame.
    Plane,
    /// An edge along pusher Y through the origin.
    Line {
        /// End to end.
        length_m: R,
    },
    /// A sphere or a vertical rod centred at the origin.
    Point {
        /// Radius of the tip.
        tip_radius_m: R,
    },
}

/// A fixed horizontal table under the object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "R: Real")]
pub enum SupportContact<R: Real> {
    /// The object's whole lower face.
    Patch,
    /// Point feet, `[x, y]` in object axes on the lower face.
    Points(Vec<[R; 2], MAX_SUPPORT_POINTS>),
}

/// Everything about the rig and the object that is known without looking at friction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "R: Real")]
pub struct Scene<R: Real> {
    /// World axes.
    pub gravity_m_s2: [R; 3],
    /// What is manipulated.
    pub object: Object<R>,
    /// Both fingertips; `None` where nothing is grasped.
    pub fingers: Option<FingerContact<R>>,
    /// The pusher; `None` where there is none.
    pub pusher: Option<PusherContact<R>>,
    /// The table; `None` where there is none.
    pub support: Option<SupportContact<R>>,
}

/// Coulomb friction coefficients, dimensionless.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "R: Real")]
pub struct Friction<R: Real> {
    /// Fingertips on the object.
    pub finger: R,
    /// Pusher on the object (a plane under the object is a platform: it has the support's).
    pub pusher: R,
    /// Table or platform under the object.
    pub support: R,
}

/// The base contact law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "R: Real")]
pub enum Base<R: Real> {
    /// The paper's rigid contact: Coulomb, maximum dissipation, non-penetration. A
    /// vanishing compliance (documented in `contact`) only chooses one of many force
    /// distributions.
    Hard,
    /// Compliant contact with damping.
    Soft {
        /// Normal stiffness of one whole contact (patch, line or point).
        normal_n_m: R,
        /// Tangential stiffness of one whole contact.
        tangential_n_m: R,
        /// Damping time: damping coefficient over stiffness.
        damping_s: R,
    },
}

/// How the friction of a contact point enters the step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Formulation {
    /// Coulomb's cone itself, by a semismooth Newton method ([`crate::cone`]).
    #[default]
    Cone,
    /// A friction pyramid, by a linear complementarity problem (Stewart and Trinkle 1996,
    /// [`crate::lcp::step`]). What is not solved within its part of the budget is solved with the cone.
    Lcp,
}

impl<R: Real> Base<R> {
    /// Soft contact of a hard plastic fingertip with a thin layer of hard rubber, the
    /// paper's: 20 N press it in by 0.1 mm; across, a rubber layer is about half as stiff
    /// (shear over indentation modulus of a thin bonded layer is lower still, that of a
    /// half space 0.7, Johnson 1985, 3.7 and 7.2). The damping time makes the paper's
    /// objects settle in some 50 ms. A starting point for calibration, not a measurement.
    /// The step is implicit in spring and damper, so any positive stiffness and any
    /// damping time are stable at any step.
    pub fn rubber_pad() -> Self {
        Base::Soft { normal_n_m: R::of(2e5), tangential_n_m: R::of(1e5), damping_s: R::of(0.005) }
    }
}

/// Contact law, friction and effects: what is calibrated, diagnosed and sent to the board.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "R: Real")]
pub struct Model<R: Real> {
    /// The base contact law.
    pub base: Base<R>,
    /// How friction enters the step; independent of base and effects.
    #[serde(default)]
    pub formulation: Formulation,
    /// Whether the other formulation makes each step once more, as a witness, where a tick has work left
    /// ([`crate::predictor::Testimony`]). What is predicted does not depend on it.
    #[serde(default)]
    pub witness: bool,
    /// Friction coefficients of the base model.
    pub friction: Friction<R>,
    /// Effects on top of the base, applied in this order.
    pub effects: Vec<Effect<R>, MAX_EFFECTS>,
    /// The user's formulas: the n-th effect of code 0 is the n-th formula.
    pub formulas: Vec<Formula<R>, MAX_FORMULAS>,
}

impl<R: Real> Model<R> {
    /// The base contact law alone.
    pub fn base(base: Base<R>, friction: Friction<R>) -> Self {
        let formulation = Formulation::default();
        Self { base, formulation, witness: false, friction, effects: Vec::new(), formulas: Vec::new() }
    }
}

impl<R: Real> Scene<R> {
    /// The same scene in another scalar.
    pub fn cast<S: Real>(&self) -> Scene<S> {
        let c = to::<R, S>;
        let shape = match &self.object.shape {
            Shape::Prism { length_m, side_m } => Shape::Prism { length_m: c(*length_m), side_m: c(*side_m) },
            Shape::Cylinder { length_m, diameter_m, across_flats_m } => Shape::Cylinder {
                length_m: c(*length_m),
                diameter_m: c(*diameter_m),
                across_flats_m: c(*across_flats_m),
            },
            Shape::Polygon { vertices_m, height_m } => Shape::Polygon {
                vertices_m: vertices_m.iter().map(|v| v.map(c)).collect(),
                height_m: c(*height_m),
            },
        };
        Scene {
            gravity_m_s2: self.gravity_m_s2.map(c),
            object: Object {
                shape,
                mass_kg: c(self.object.mass_kg),
                inertia_kg_m2: self.object.inertia_kg_m2.map(|row| row.map(c)),
            },
            fingers: self.fingers.map(|f| match f {
                FingerContact::Point => FingerContact::Point,
                FingerContact::Line { length_m } => FingerContact::Line { length_m: c(length_m) },
                FingerContact::Disc { diameter_m } => FingerContact::Disc { diameter_m: c(diameter_m) },
            }),
            pusher: self.pusher.map(|p| match p {
                PusherContact::Plane => PusherContact::Plane,
                PusherContact::Line { length_m } => PusherContact::Line { length_m: c(length_m) },
                PusherContact::Point { tip_radius_m } => {
                    PusherContact::Point { tip_radius_m: c(tip_radius_m) }
                }
            }),
            support: self.support.as_ref().map(|s| match s {
                SupportContact::Patch => SupportContact::Patch,
                SupportContact::Points(feet) => {
                    SupportContact::Points(feet.iter().map(|p| p.map(c)).collect())
                }
            }),
        }
    }
}

impl<R: Real> Model<R> {
    /// The same model in another scalar.
    pub fn cast<S: Real>(&self) -> Model<S> {
        let c = to::<R, S>;
        let base = match self.base {
            Base::Hard => Base::Hard,
            Base::Soft { normal_n_m, tangential_n_m, damping_s } => Base::Soft {
                normal_n_m: c(normal_n_m),
                tangential_n_m: c(tangential_n_m),
                damping_s: c(damping_s),
            },
        };
        let friction = Friction {
            finger: c(self.friction.finger),
            pusher: c(self.friction.pusher),
            support: c(self.friction.support),
        };
        Model {
            base,
            formulation: self.formulation,
            witness: self.witness,
            friction,
            effects: self
                .effects
                .iter()
                .map(|e| Effect { code: e.code, parameters: e.parameters.map(c) })
                .collect(),
            formulas: self.formulas.iter().map(Formula::cast).collect(),
        }
    }
}

/// The nearest number of another scalar.
fn to<R: Real, S: Real>(x: R) -> S {
    S::of(x.to_f64())
}
