//! The user's own effect, given as a formula and tried without compiling.
//!
//! A formula is a small stack program (reverse Polish notation) that the host's parser
//! makes from an expression in `model.toml`; the board runs the same program. It is
//! evaluated once for each contact point (friction) or once a step (grip, added force).
//! Comparisons give 1 or 0. A program that is malformed, or a result that is not finite,
//! gives NaN, which the time step refuses as `BadInput`: a broken formula cannot pass for
//! physics.

use super::{FrictionLaw, Info, Law, Loads, MAX_PARAMETERS, MEMORY, Parameter, Slip, StepContext};
use crate::contact::Body;
use crate::real::{Real, max, min, sqrt};
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Code of an effect that is a formula.
pub const CODE: u8 = 0;
/// Most operations of a program.
pub const MAX_OPS: usize = 48;
/// Deepest stack.
pub const MAX_STACK: usize = 12;
/// Parameters `p0` to `p3`.
pub const FORMULA_PARAMETERS: usize = 4;

/// Description shared by all formulas; the user's names and intervals stay on the host.
pub const INFO: Info = Info {
    id: "formula",
    code: CODE,
    summary: "the user's own formula",
    signature: "what the formula says",
    source: "the user's model.toml",
    parameters: &[
        Parameter::new("p0", "1", 1.0, 0.0, [-1e9, 1e9], "first parameter of the formula"),
        Parameter::new("p1", "1", 1.0, 0.0, [-1e9, 1e9], "second parameter of the formula"),
        Parameter::new("p2", "1", 1.0, 0.0, [-1e9, 1e9], "third parameter of the formula"),
        Parameter::new("p3", "1", 1.0, 0.0, [-1e9, 1e9], "fourth parameter of the formula"),
    ],
};

/// What a formula may depend on. Friction sees the contact point; grip and added force see
/// the mean over both fingers (load: the sum).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Variable {
    /// Slip speed of the last step, m/s.
    SlipSpeed,
    /// Distance slipped, m.
    SlipDistance,
    /// Normal force of the whole contact, N.
    Load,
    /// Time since the point last slipped, s; zero for grip and force.
    Rest,
    /// Place on the object along its X axis, m; for grip and force the object's in the gripper.
    PositionX,
    /// The same along Y.
    PositionY,
    /// The same along Z.
    PositionZ,
    /// Since the start of the trial, s.
    Time,
    /// Place of the trial in its data set.
    Trial,
    /// Commanded grip, N.
    Grip,
}

impl Variable {
    /// Every variable with its name in expressions.
    pub const NAMES: [(&'static str, Variable); 10] = [
        ("slip_speed_m_s", Variable::SlipSpeed),
        ("slip_distance_m", Variable::SlipDistance),
        ("load_n", Variable::Load),
        ("rest_s", Variable::Rest),
        ("position_x_m", Variable::PositionX),
        ("position_y_m", Variable::PositionY),
        ("position_z_m", Variable::PositionZ),
        ("time_s", Variable::Time),
        ("trial", Variable::Trial),
        ("grip_n", Variable::Grip),
    ];
}

/// One operation. Binary operations take the deeper operand first.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "R: Real")]
#[allow(missing_docs)]
pub enum Op<R: Real> {
    Constant(R),
    Variable(Variable),
    /// `p0` to `p3`.
    Parameter(u8),
    Negate,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Minimum,
    Maximum,
    Less,
    Greater,
    Absolute,
    Root,
    Exponential,
    Logarithm,
    Sine,
    Cosine,
    Tangent,
    HyperbolicTangent,
    /// -1, 0 or 1.
    Sign,
}

/// What the result changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Target {
    /// Factor on the friction coefficient of the chosen bodies.
    Friction,
    /// Factor on the grip force.
    Grip,
    /// Force on the object along carrier X, N.
    ForceX,
    /// Force on the object along carrier Y, N.
    ForceY,
    /// Force on the object along carrier Z, N.
    ForceZ,
}

/// Why a program is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FormulaError {
    /// More than [`MAX_OPS`] operations.
    TooLong,
    /// More than [`MAX_STACK`] intermediate results.
    TooDeep,
    /// Operands missing or left over, or a parameter beyond `p3`.
    Malformed,
}

/// A checked stack program and what it acts on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "R: Real")]
pub struct Formula<R: Real> {
    /// What the result changes.
    pub target: Target,
    /// For friction: bit [`Body::index`] set where it applies.
    pub bodies: u8,
    /// In order of execution.
    pub program: Vec<Op<R>, MAX_OPS>,
}

/// Values of the variables in the order of [`Variable`].
pub type Variables<R> = [R; Variable::NAMES.len()];

impl<R: Real> Op<R> {
    /// Values taken from the stack.
    fn takes(&self) -> usize {
        match self {
            Op::Constant(_) | Op::Variable(_) | Op::Parameter(_) => 0,
            Op::Add
            | Op::Subtract
            | Op::Multiply
            | Op::Divide
            | Op::Power
            | Op::Minimum
            | Op::Maximum
            | Op::Less
            | Op::Greater => 2,
            _ => 1,
        }
    }
}

impl<R: Real> Formula<R> {
    /// All bodies.
    pub const ALL_BODIES: u8 = 0b1111;

    /// Refuses programs that do not leave exactly one value or break a limit.
    pub fn new(target: Target, bodies: u8, ops: &[Op<R>]) -> Result<Self, FormulaError> {
        let program = Vec::from_slice(ops).map_err(|_| FormulaError::TooLong)?;
        let formula = Self { target, bodies, program };
        formula.check().map(|()| formula)
    }

    /// The same formula in another scalar.
    pub fn cast<S: Real>(&self) -> Formula<S> {
        let program = self.program.iter().map(|op| match *op {
            Op::Constant(x) => Op::Constant(S::of(x.to_f64())),
            Op::Variable(v) => Op::Variable(v),
            Op::Parameter(k) => Op::Parameter(k),
            Op::Negate => Op::Negate,
            Op::Add => Op::Add,
            Op::Subtract => Op::Subtract,
            Op::Multiply => Op::Multiply,
            Op::Divide => Op::Divide,
            Op::Power => Op::Power,
            Op::Minimum => Op::Minimum,
            Op::Maximum => Op::Maximum,
            Op::Less => Op::Less,
            Op::Greater => Op::Greater,
            Op::Absolute => Op::Absolute,
            Op::Root => Op::Root,
            Op::Exponential => Op::Exponential,
            Op::Logarithm => Op::Logarithm,
            Op::Sine => Op::Sine,
            Op::Cosine => Op::Cosine,
            Op::Tangent => Op::Tangent,
            Op::HyperbolicTangent => Op::HyperbolicTangent,
            Op::Sign => Op::Sign,
        });
        Formula { target: self.target, bodies: self.bodies, program: program.collect() }
    }

    /// Whether the program can run: it may have come over a wire.
    pub fn check(&self) -> Result<(), FormulaError> {
        let mut depth = 0_usize;
        for op in &self.program {
            if matches!(op, Op::Parameter(k) if usize::from(*k) >= FORMULA_PARAMETERS) {
                return Err(FormulaError::Malformed);
            }
            depth = depth.checked_sub(op.takes()).ok_or(FormulaError::Malformed)?.saturating_add(1);
            if depth > MAX_STACK {
                return Err(FormulaError::TooDeep);
            }
        }
        if depth == 1 { Ok(()) } else { Err(FormulaError::Malformed) }
    }

    /// Value of the program; NaN where it is malformed (it may have come over a wire).
    pub fn evaluate(&self, p: &[R; MAX_PARAMETERS], variables: &Variables<R>) -> R {
        let mut stack: Vec<R, MAX_STACK> = Vec::new();
        for op in &self.program {
            match self.apply(op, p, variables, &mut stack) {
                Some(x) if stack.push(x).is_ok() => {}
                _ => return nan(),
            }
        }
        match stack.as_slice() {
            [x] if x.finite() => *x,
            _ => nan(),
        }
    }

    fn apply(
        &self,
        op: &Op<R>,
        p: &[R; MAX_PARAMETERS],
        variables: &Variables<R>,
        stack: &mut Vec<R, MAX_STACK>,
    ) -> Option<R> {
        let (zero, one) = (R::zero(), R::one());
        let truth = |x: bool| if x { one } else { zero };
        Some(match op.takes() {
            0 => match *op {
                Op::Constant(x) => x,
                Op::Variable(v) => *variables.get(v as usize)?,
                Op::Parameter(k) => *p.get(usize::from(k))?,
                _ => return None,
            },
            1 => {
                let x = stack.pop()?;
                match op {
                    Op::Negate => -x,
                    Op::Absolute => x.abs(),
                    Op::Root => sqrt(x),
                    Op::Exponential => x.exp(),
                    Op::Logarithm => x.ln(),
                    Op::Sine => x.sine_cosine().0,
                    Op::Cosine => x.sine_cosine().1,
                    Op::Tangent => {
                        let (sine, cosine) = x.sine_cosine();
                        sine / cosine
                    }
                    Op::HyperbolicTangent => x.tanh(),
                    Op::Sign => truth(x > zero) - truth(x < zero),
                    _ => return None,
                }
            }
            _ => {
                let b = stack.pop()?;
                let a = stack.pop()?;
                match op {
                    Op::Add => a + b,
                    Op::Subtract => a - b,
                    Op::Multiply => a * b,
                    Op::Divide => a / b,
                    Op::Power => a.powf(b),
                    Op::Minimum => min(a, b),
                    Op::Maximum => max(a, b),
                    Op::Less => truth(a < b),
                    Op::Greater => truth(a > b),
                    _ => return None,
                }
            }
        })
    }

    /// Values for grip and force: the fingers' means, the object's place in the gripper.
    fn whole(c: &StepContext<R>) -> Variables<R> {
        let half = R::of(0.5);
        [
            (c.slip_speed_m_s[0] + c.slip_speed_m_s[1]) * half,
            (c.slip_m[0] + c.slip_m[1]) * half,
            c.load_n[0] + c.load_n[1],
            R::zero(),
            c.position_m.x,
            c.position_m.y,
            c.position_m.z,
            c.time_s,
            c.trial,
            c.grip_cmd_n,
        ]
    }
}

/// Not a number, without a literal that `Real` lacks.
fn nan<R: Real>() -> R {
    R::of(f64::NAN)
}

impl<R: Real> Law<R> for Formula<R> {
    fn info(&self) -> &'static Info {
        &INFO
    }

    fn loads(&self, p: &[R; MAX_PARAMETERS], c: &StepContext<R>, _: &mut [R; MEMORY], loads: &mut Loads<R>) {
        match self.target {
            Target::ForceX => loads.force_n.x += self.evaluate(p, &Self::whole(c)),
            Target::ForceY => loads.force_n.y += self.evaluate(p, &Self::whole(c)),
            Target::ForceZ => loads.force_n.z += self.evaluate(p, &Self::whole(c)),
            Target::Friction | Target::Grip => {}
        }
    }

    fn grip(&self, p: &[R; MAX_PARAMETERS], c: &StepContext<R>, _: &mut [R; MEMORY], grip_n: &mut R) {
        if self.target == Target::Grip {
            *grip_n *= self.evaluate(p, &Self::whole(c));
        }
    }

    fn friction(
        &self,
        p: &[R; MAX_PARAMETERS],
        c: &StepContext<R>,
        slip: &Slip<R>,
        law: &mut FrictionLaw<R>,
    ) {
        if self.target != Target::Friction || !applies(self.bodies, slip.body) {
            return;
        }
        let factor = self.evaluate(
            p,
            &[
                slip.speed_m_s,
                slip.distance_m,
                slip.patch_load_n,
                slip.rest_s,
                slip.object_m.x,
                slip.object_m.y,
                slip.object_m.z,
                c.time_s,
                c.trial,
                c.grip_cmd_n,
            ],
        );
        law.mu = law.mu.map(|mu| mu * factor);
    }
}

/// Whether the mask holds the body.
fn applies(bodies: u8, body: Body) -> bool {
    bodies & (1 << (body.index() & 7)) != 0
}
