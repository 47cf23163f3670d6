//! An effect as plain data: which one with which parameters, and how it is described to people.
//!
//! Apart from the laws themselves ([`crate::effects`]), so that a model can hold effects without
//! knowing contacts or the time step.

use crate::real::Real;
use serde::{Deserialize, Serialize};

/// Most parameters of one effect.
pub const MAX_PARAMETERS: usize = 18;
/// Numbers that an effect may remember from step to step: one of each body, or what it needs.
pub const MEMORY: usize = 4;

/// An effect in a model: which, and its parameters (SI units, see its [`Info`]).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "R: Real")]
pub struct Effect<R: Real> {
    /// Stable number of the effect, see [`Info::code`].
    pub code: u8,
    /// Parameters in the order of its [`Info`]; the rest zero.
    pub parameters: [R; MAX_PARAMETERS],
}

/// Description of one parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name with its unit as suffix.
    pub name: &'static str,
    /// Unit as people write it.
    pub unit: &'static str,
    /// A typical strength: where a fit starts and what a sensitivity is scaled by.
    pub typical: f64,
    /// The value at which the effect is absent (or any value, if another parameter switches it off).
    pub neutral: f64,
    /// Smallest value that makes sense.
    pub low: f64,
    /// Largest value that makes sense.
    pub high: f64,
    /// What it is.
    pub what: &'static str,
    /// Where it only shapes the effect: values at which a fit starts; empty: about the typical one.
    pub tries: &'static [f64],
    /// Where it came after the effect: the value with which a model file written before behaves as it did.
    pub before: Option<f64>,
    /// What is expected of it before any fit; `None`: nothing.
    pub expected: Option<Expected>,
}

/// What is expected of a parameter before any fit. Every contact has the properties of its pads and its plate: they are no
/// missing effect, so that a fit that finds them starts from what is read off or usual, and stays near it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expected {
    /// The compliance of one pad along its face, which is read off the measurements.
    ReadOff,
    /// A share of the one that is read off: the share, and the range of shares.
    Share(f64, [f64; 2]),
    /// Whatever is read off: what is usual, and the range.
    Usual(f64, [f64; 2]),
    /// The same where the pads are read off; its neutral value where they are assumed or unknown.
    UsualBesideReadOff(f64, [f64; 2]),
}

impl Parameter {
    /// In the order of the fields; `bounds` are the smallest and the largest value.
    pub const fn new(
        name: &'static str,
        unit: &'static str,
        typical: f64,
        neutral: f64,
        bounds: [f64; 2],
        what: &'static str,
    ) -> Self {
        let [low, high] = bounds;
        Self { name, unit, typical, neutral, low, high, what, tries: &[], before: None, expected: None }
    }

    /// The same with the values at which a fit starts.
    pub const fn tried_at(self, tries: &'static [f64]) -> Self {
        Self { tries, ..self }
    }

    /// The same where it came after the effect, which behaved as with `before` until then.
    pub const fn added(self, before: f64) -> Self {
        Self { before: Some(before), ..self }
    }

    /// The same with what is expected of it.
    pub const fn expected(self, expected: Expected) -> Self {
        Self { expected: Some(expected), ..self }
    }
}

/// What a diagnosis has to know of an effect beside its law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Role {
    /// It is missing or it is not.
    Plain,
    /// How pads give way: at the largest grip real ones do by this much, and that is no missing effect.
    Compliance {
        /// m
        normal_m: f64,
    },
    /// How something is set up: as square as is ordinary, no missing effect.
    Mounting {
        /// The largest that each of its angles may be, rad.
        square_rad: f64,
    },
    /// Where pads press: off their middle by this share of their diameter they do on any finger, no missing effect.
    Pressing {
        /// The largest that each of its distances may be.
        of_diameter: f64,
    },
    /// Only what the force sensors show differs, by what they would show without it and nothing else.
    Sensing {
        /// The largest share of its typical size that each parameter has on any sensor, no missing effect.
        of_typical: f64,
    },
    /// Only what the force sensors show differs, by constants; within what is stated of a sensor, no missing effect.
    Constants,
    /// When the object is seen: late by a sample of the recording, no missing effect; its first parameter is the delay.
    Delay,
    /// A later trial of the same condition differs; its first parameter is the change from trial to trial.
    Order,
}

impl Role {
    /// Whether it is how pads give way.
    #[must_use]
    pub const fn is_compliance(self) -> bool {
        matches!(self, Self::Compliance { .. })
    }

    /// Whether it changes only what the force sensors show.
    #[must_use]
    pub const fn is_sensing(self) -> bool {
        matches!(self, Self::Sensing { .. } | Self::Constants)
    }
}

/// Description of an effect.
#[derive(Clone, Copy, Debug)]
pub struct Info {
    /// Identifier used in model files and reports; the board knows effects by their code.
    pub id: &'static str,
    /// Stable number on the wire.
    pub code: u8,
    /// One line for people.
    pub summary: &'static str,
    /// What it looks like in data.
    pub signature: &'static str,
    /// What it changes for a robot that grips: what its user has to reckon with.
    pub on_robot: &'static str,
    /// Where the law comes from.
    pub source: &'static str,
    /// How a diagnosis treats it.
    pub role: Role,
    /// At most [`MAX_PARAMETERS`].
    pub parameters: &'static [Parameter],
}
